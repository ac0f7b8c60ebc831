"""The air: what it scatters and absorbs of each wavelength, and how much of it a ray meets.

Light is a spectrum of 17 bands, 380 to 720 nm, in units of the sunlight above the air in that band. Lengths are in metres.

    extinction at height h      sum over air, aerosol and ozone of coefficient * density(h)
    air                         Rayleigh scattering 1.24062e-6 / wavelength^4 (wavelength in um) /m, density exp(-h / 8000)
    aerosol                     haze * 4e-5 / (wavelength / 0.55)^1.3 /m, of which 0.9 is scattered; density exp(-h / 1200).
                                haze 1 has an optical depth of 0.048 and lets one see 75 km
    ozone                       300 Dobson units between 10 and 40 km, most at 25 km; it only absorbs

A ray that starts level or upwards is looked up in a table of the metres of air, aerosol and ozone up to the top. One that starts
downwards meets twice what lies beyond its lowest point, less what lies behind its start.
Sources: Bruneton, Neyret, Precomputed Atmospheric Scattering (2008), with the coefficients of Bruneton's implementation of 2017,
except for the aerosol, of which that has a ninth; Angstrom (1929) for its exponent, Koschmieder (1924) for how far one sees;
sunlight: ASTM G-173, above the air; ozone: Serdyuchenko et al., Atmos. Meas. Tech. 7 (2014), at 233 K.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gen_art.maths.array_functions import exp, log

__all__ = [
    "AEROSOL_HEIGHT", "AIR_HEIGHT", "BANDS", "GROUND", "SUN_RADIUS", "TOP", "Air", "bilinear", "columns", "densities",
    "sun_spectrum", "sunlight", "wavelengths",
]  # fmt: skip

GROUND, TOP = 6_360e3, 6_420e3  # m from the Earth's middle
AIR_HEIGHT, AEROSOL_HEIGHT = 8_000.0, 1_200.0  # m over which the density falls to 1/e
SUN_RADIUS = math.radians(0.267)  # of the disc as seen from the Earth
BANDS = 17
_AEROSOL, _ANGSTROM, _SCATTERED = (
    4e-5,
    1.3,
    0.9,
)  # extinction at the ground, 1/m, its exponent; the part that is scattering
_OZONE_MOST = 300 * 2.687e20 / 15_000.0  # molecules a m^3, where there are most

# means over bands of 10 nm from 380 nm on; two make a band of 20 nm
_SUNLIGHT = (  # W/m^2/nm
    1.01249, 1.14716, 1.72765, 1.73054, 1.6887, 1.61253, 1.91198, 2.03474, 2.02042, 2.02212, 1.93377, 1.95809,
    1.91686, 1.8298, 1.8685, 1.8931, 1.85149, 1.8504, 1.8341, 1.8345, 1.8147, 1.78158, 1.7533, 1.6965,
    1.68194, 1.64654, 1.6048, 1.52143, 1.55622, 1.5113, 1.474, 1.4482, 1.41018, 1.36775,
)  # fmt: skip
_OZONE = (  # cross section of a molecule, 1e-26 m^2
    0.02818, 0.06636, 0.1527, 0.2763, 0.552, 0.8451, 1.582, 2.316, 3.669, 4.924, 7.752, 9.016,
    14.8, 16.02, 21.39, 27.55, 30.91, 35.0, 42.66, 46.72, 43.98, 47.01, 50.19, 43.05,
    37.4, 32.15, 26.62, 22.38, 18.52, 14.73, 12.09, 9.423, 7.455, 6.566,
)  # fmt: skip

_RADII, _SLOPES, _STEPS = 48, 64, 80  # of the table of columns, and of the sums in it
_HORIZON = math.sqrt(TOP**2 - GROUND**2)  # the longest way from the ground to the top


def _by_band(values) -> np.ndarray:
    pairs = np.array(values)
    return 0.5 * (pairs[0::2] + pairs[1::2])


def wavelengths() -> np.ndarray:
    """(34,) nm, the middles of the halves of the bands."""
    return np.arange(385.0, 720.0, 10.0)


def sun_spectrum() -> np.ndarray:
    """(17,) W/m^2/nm: sunlight above the air in each band."""
    return _by_band(_SUNLIGHT)


@dataclass(frozen=True, eq=False)
class Air:
    """What a cubic metre at the ground does to light, by band.

    rayleigh, aerosol_scattering, aerosol_extinction, ozone : (17,) 1/m; ozone where it is densest
    albedo : (17,) the part of the light that the ground scatters
    """

    rayleigh: np.ndarray
    aerosol_scattering: np.ndarray
    aerosol_extinction: np.ndarray
    ozone: np.ndarray
    albedo: np.ndarray

    @classmethod
    def of_earth(cls, haze: float = 1.0, albedo=0.2) -> "Air":
        """The air of a clear day with `haze` times its aerosol; albedo : a number or (17,)."""
        micrometres = 0.001 * wavelengths()
        square = micrometres * micrometres
        aerosol = haze * _AEROSOL * _by_band(exp(-_ANGSTROM * log(micrometres / 0.55)))
        return cls(
            rayleigh=_by_band(1.24062e-6 / (square * square)), aerosol_scattering=_SCATTERED * aerosol,
            aerosol_extinction=aerosol, ozone=_by_band(_OZONE) * 1e-26 * _OZONE_MOST,
            albedo=np.broadcast_to(np.asarray(albedo, float), (BANDS,)),
        )  # fmt: skip

    def depth(self, metres: np.ndarray) -> np.ndarray:
        """Optical depth (..., 17) of metres (..., 3) of air, aerosol and ozone, each at its greatest density."""
        # summed by hand: the order in which a matrix product sums differs between processors
        air, aerosol, ozone = (metres[..., k, None] for k in range(3))
        return air * self.rayleigh + aerosol * self.aerosol_extinction + ozone * self.ozone

    def transmittance(self, metres: np.ndarray) -> np.ndarray:
        """(..., 17) the part of the light that passes metres (..., 3) of air, aerosol and ozone."""
        return exp(-self.depth(metres))


def densities(height) -> np.ndarray:
    """(..., 3) of air, aerosol and ozone at heights above the ground, m, relative to the greatest."""
    h = np.asarray(height, float)
    ozone = np.clip(np.minimum(h - 10e3, 40e3 - h) / 15e3, 0.0, 1.0)
    return np.stack([exp(-h / AIR_HEIGHT), exp(-h / AEROSOL_HEIGHT), ozone], axis=-1)


@lru_cache(1)
def _table() -> np.ndarray:
    """(radii, slopes, 3) metres of air, aerosol and ozone from a point to the top: columns k and l are those of `_columns_up`."""
    rho = np.linspace(0.0, _HORIZON, _RADII)[:, None]
    radius = np.sqrt(rho**2 + GROUND**2)
    shortest, longest = TOP - radius, np.sqrt(np.maximum(TOP**2 - radius**2, 0.0))
    length = shortest + np.linspace(0.0, 1.0, _SLOPES) * (longest - shortest)
    cosine = np.clip((TOP**2 - radius**2 - length**2) / (2.0 * radius * np.maximum(length, 1.0)), 0.0, 1.0)
    total = np.zeros((_RADII, _SLOPES, 3))
    for k in range(_STEPS):  # steps that grow with the distance: the air is densest at the start
        u = (k + 0.5) / _STEPS
        s = length * u * u
        total += (
            densities(np.sqrt(radius**2 + s * s + 2.0 * radius * s * cosine) - GROUND)
            * (length * (2.0 * u / _STEPS))[..., None]
        )
    return total


def bilinear(table: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Values (..., k) of a table (rows, columns, k) between its entries; beyond its ends those at the ends."""
    row, column = np.clip(row, 0.0, table.shape[0] - 1.0), np.clip(column, 0.0, table.shape[1] - 1.0)
    i = np.minimum(row.astype(np.int64), table.shape[0] - 2)
    j = np.minimum(column.astype(np.int64), table.shape[1] - 2)
    a, b = (row - i)[..., None], (column - j)[..., None]
    upper = table[i, j] + (table[i, j + 1] - table[i, j]) * b
    lower = table[i + 1, j] + (table[i + 1, j + 1] - table[i + 1, j]) * b
    return upper + (lower - upper) * a


def _columns_up(radius: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    rho = np.sqrt(np.maximum(radius**2 - GROUND**2, 0.0))
    shortest, longest = TOP - radius, np.sqrt(np.maximum(TOP**2 - radius**2, 0.0))
    along = radius * cosine
    length = np.sqrt(np.maximum(along**2 + TOP**2 - radius**2, 0.0)) - along
    slope = (length - shortest) / np.maximum(longest - shortest, 1.0)
    return bilinear(_table(), rho * ((_RADII - 1) / _HORIZON), slope * (_SLOPES - 1))


def columns(radius, cosine) -> np.ndarray:
    """(..., 3) metres of air, aerosol and ozone from points to the top, each at its greatest density.

    radius : distance from the Earth's middle, GROUND to TOP
    cosine : of the angle between the ray and straight up; a ray below the horizon is taken as one along it
    """
    radius, cosine = np.broadcast_arrays(np.asarray(radius, float), np.asarray(cosine, float))
    down = cosine < 0.0
    up = _columns_up(radius, np.abs(cosine))
    if not down.any():
        return up
    lowest = np.maximum(radius * np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), GROUND)
    beyond = _columns_up(lowest, np.zeros_like(lowest))
    return np.where(down[..., None], np.maximum(2.0 * beyond - up, up), up)


def sunlight(air: Air, radius, cosine) -> np.ndarray:
    """(..., 17) the sun's light at points, of that above the air: 0 where the Earth is before all of its disc.

    cosine : of the sun's distance from straight up
    """
    radius, cosine = np.asarray(radius, float), np.asarray(cosine, float)
    horizon = -np.sqrt(np.maximum(1.0 - (GROUND / radius) ** 2, 0.0))
    u = np.clip((cosine - horizon) * (0.5 / SUN_RADIUS) + 0.5, 0.0, 1.0)
    visible = u * u * (3.0 - 2.0 * u)
    return air.transmittance(columns(radius, cosine)) * visible[..., None]
