"""The light of the air and the sun's disc as the eye sees them from a low hill: from bands of wavelengths to a sky's table.

The eye is EYE metres above the ground. From there the horizon is a little below level; all directions are shifted by as much, so
that in the picture the horizon is at eye level. The colours are those of a camera that is balanced for noon: with the sun in the
zenith, sun and sky together light a white level floor with pi in every channel, so the floor has light 1.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gen_art.backend.kept_arrays import kept
from gen_art.maths.array_functions import arctan2, cos, sin
from gen_art.preset.sky import Sky
from gen_art.renderer.atmosphere import (
    BANDS,
    GROUND,
    SUN_RADIUS,
    Air,
    columns,
    sun_spectrum,
    sunlight,
    wavelengths,
)
from gen_art.renderer.colour import colour_matching, linear, rgb_to_xyz
from gen_art.renderer.scattering import (
    Scattered,
    aerosol_phase,
    along_rays,
    angle_to_sun,
    multiple_scattering,
    rayleigh_phase,
)
from gen_art.renderer.sky_table import COLUMNS, azimuths, elevations

__all__ = ["DISC_ROWS", "Daylight", "daylight"]

EYE = 200.0  # m above the ground
DISC_ROWS = 32  # across the sun's disc, from below to above: its colour changes where it rises and sets
_UP_ROWS, _DOWN_ROWS, _HALF_CIRCLE = (
    64,
    32,
    49,
)  # directions for which the light is integrated; those between are interpolated
_DIP = float(arctan2(math.sqrt((GROUND + EYE) ** 2 - GROUND**2), GROUND))  # rad from level down to the horizon


@dataclass(frozen=True, eq=False)
class Daylight:
    """Light of a sky with a sun, of intensity 1.

    table : (ROWS, COLUMNS, 3) float64, as sky_table.py lays it out
    sun_direction : (3,) unit vector from the scene to the sun
    sun_irradiance : (3,) of a plane that faces the sun, by the sun alone
    disc : (DISC_ROWS, 3) mean light of the disc over its whole width at each height, from its lower to its upper rim
    extinction : (ROWS / 2, 3) the part of a star's light that the air lets through, for the rows above the horizon
    """

    table: np.ndarray
    sun_direction: np.ndarray
    sun_irradiance: np.ndarray
    disc: np.ndarray
    extinction: np.ndarray


def _seen(elevation):
    """The elevation above level of directions that are shown at an elevation above the horizon, rad."""
    e = np.asarray(elevation, float)
    return e - _DIP * (1.0 - np.abs(e) * (2.0 / math.pi))


@lru_cache(1)
def _rgb_of_bands() -> np.ndarray:
    """(17, 3) linear Rec.709 of the sunlight above the air in each band, in arbitrary units."""
    xyz = colour_matching(wavelengths())
    xyz = (xyz[0::2] + xyz[1::2]) * sun_spectrum()[:, None]
    to_rgb = np.linalg.inv(rgb_to_xyz())
    rgb = np.stack([sum(to_rgb[c, k] * xyz[:, k] for k in range(3)) for c in range(3)], axis=1)
    return np.round(rgb, 9)  # the last bits of NumPy's exponentials and inverses differ between processors


def _rgb(spectrum) -> np.ndarray:
    """(..., 3) of (..., 17), summed in a fixed order."""
    weights = _rgb_of_bands()
    total = np.zeros((*spectrum.shape[:-1], 3))
    for k in range(BANDS):
        total += spectrum[..., k, None] * weights[k]
    return total


def _albedo(colour) -> np.ndarray:
    """(17,) of a colour: its channels by wavelength, with even passages at 490 and 580 nm."""
    red, green, blue = np.round(linear(colour), 9)  # the last bits of powers differ, too
    nm = 0.5 * (wavelengths()[0::2] + wavelengths()[1::2])
    short, long = np.clip((510.0 - nm) / 40.0, 0.0, 1.0), np.clip((nm - 560.0) / 40.0, 0.0, 1.0)
    return short * blue + (1.0 - short - long) * green + long * red


def sky_irradiance(light: np.ndarray, elevation: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """(k,) on a level plane from light (rows, columns, k) of an upper half that is the same on both sides of the sun.

    elevation : (rows,) rad, 0 to pi/2
    azimuth : (columns,) rad, 0 to pi; or (1,), if the light is the same all round
    """
    weight = sin(elevation) * cos(elevation) * _trapezoid(elevation)
    around = np.array([math.pi]) if len(azimuth) == 1 else _trapezoid(azimuth)
    total = np.zeros(light.shape[2])
    for i, row in enumerate(weight):
        for j, column in enumerate(around):
            total += light[i, j] * (2.0 * row * column)
    return total


def _trapezoid(x: np.ndarray) -> np.ndarray:
    step = x[1:] - x[:-1]
    return 0.5 * (np.append(step, 0.0) + np.append(0.0, step))


def _rows(number: int) -> np.ndarray:
    """Elevations 0 to pi/2 at the places of a table of `number` rows."""
    t = (np.arange(number) / (number - 1.0)) ** 2
    return arctan2(t, 1.0 - t)


@lru_cache(8)
def _air_of(haze: float, ground) -> tuple[Air, np.ndarray, np.ndarray]:
    """The air, its Psi, and the factors that give noon its light."""
    air = Air.of_earth(haze, _albedo(ground))
    psi = multiple_scattering(air)
    elevation = _rows(2 * _UP_ROWS)
    noon = along_rays(air, psi, GROUND + EYE, sin(_seen(elevation)) + 1e-9, np.zeros(1), 1.0)
    light = noon.radiance(sin(elevation)[:, None])
    level = sunlight(air, GROUND + EYE, 1.0) + sky_irradiance(light, elevation, np.zeros(1))
    return air, psi, math.pi / _rgb(level)


def daylight(spec: Sky) -> Daylight:
    """The light of a sky with a `sun`, of intensity 1."""
    assert spec.sun is not None
    return Daylight(*_daylight(spec.haze, spec.ground, spec.sun.height, spec.sun.azimuth))


@kept
def _daylight(haze: float, ground, sun_height: float, sun_azimuth: float) -> tuple[np.ndarray, ...]:
    """The fields of a Daylight: of haze, colour of the ground, and height and azimuth of the sun in degrees."""
    air, psi, white = _air_of(haze, ground)
    height, turn = math.radians(sun_height), math.radians(sun_azimuth)
    seen = float(sin(_seen(height)))
    half = np.arange(_HALF_CIRCLE) * (math.pi / (_HALF_CIRCLE - 1))
    up, down = _rows(_UP_ROWS), _rows(_DOWN_ROWS)
    # at the horizon itself a ray would both meet the ground and miss it
    above = along_rays(air, psi, GROUND + EYE, sin(_seen(up)) + 1e-9, half, seen)
    below = along_rays(air, psi, GROUND + EYE, sin(_seen(-down) - 1e-9), half, seen)
    light = above.radiance(angle_to_sun(sin(up)[:, None], half, float(sin(height))))
    on_ground = sunlight(air, GROUND + EYE, seen) * max(seen, 0.0) + sky_irradiance(light, up, half)
    from_ground = below.passed[:, None] * (on_ground * air.albedo / math.pi)
    from_ground = np.broadcast_to(from_ground, below.often.shape)
    below = below._replace(often=below.often + from_ground)
    upper, lower = _finer(above, elevations(), height, turn), _finer(below, -elevations(), height, turn)[::-1]
    e_disc = height + SUN_RADIUS * np.linspace(-1.0, 1.0, DISC_ROWS)
    disc = _rgb(air.transmittance(columns(GROUND + EYE, sin(_seen(e_disc))))) * (e_disc >= 0.0)[:, None] * white
    across = np.sqrt(np.maximum(1.0 - np.linspace(-1.0, 1.0, DISC_ROWS) ** 2, 0.0))
    irradiance = np.array([sum((across * disc[:, c]).tolist()) for c in range(3)]) / sum(across.tolist())
    clear = _rgb(air.transmittance(columns(GROUND + EYE, sin(_seen(elevations()))))) / _rgb(np.ones(BANDS))
    solid_angle = math.pi * float(sin(SUN_RADIUS)) ** 2
    table = np.maximum(np.concatenate([lower, upper]) * white, 0.0)
    sun_direction = np.array([float(cos(height) * sin(turn)), float(sin(height)), -float(cos(height) * cos(turn))])
    disc = np.maximum(disc, 0.0) / solid_angle
    return table, sun_direction, np.maximum(irradiance, 0.0), disc, np.clip(clear, 0.0, 1.0)


def _finer(scattered: Scattered, elevation: np.ndarray, height: float, turn: float) -> np.ndarray:
    """(HALF, COLUMNS, 3) of the light in half of the sky, on the rows and columns of the table."""
    azimuth = azimuths() - turn
    row = np.linspace(0.0, scattered.often.shape[0] - 1.0, len(elevation))
    # the angle from the sun, 0 to pi, on either side
    column = np.abs(azimuth - 2.0 * math.pi * np.floor(azimuth / (2.0 * math.pi) + 0.5)) * (
        (_HALF_CIRCLE - 1) / math.pi
    )
    to_sun = angle_to_sun(sin(elevation)[:, None], azimuth, float(sin(height)))[..., None]
    by_air, by_aerosol, often = (
        _cubic(_cubic(_rgb(part), row, 0, mirrored=False), column, 1, mirrored=True)
        for part in (scattered.by_air, scattered.by_aerosol, scattered.often)
    )
    table = by_air * rayleigh_phase(to_sun) + by_aerosol * aerosol_phase(to_sun) + often
    table[:, COLUMNS - 1] = table[:, 0]
    return table


def _cubic(values: np.ndarray, at: np.ndarray, axis: int, mirrored: bool) -> np.ndarray:
    """Values between the entries along an axis, by Catmull and Rom's cubic; beyond the ends mirrored ones, or straight on."""
    v = np.moveaxis(values, axis, 0)
    first, last = (v[1], v[-2]) if mirrored else (2.0 * v[0] - v[1], 2.0 * v[-1] - v[-2])
    v = np.concatenate([first[None], v, last[None]])
    i = np.minimum(at.astype(np.int64), len(v) - 4)
    u = (at - i).reshape(-1, *([1] * (v.ndim - 1)))
    a, b, c, d = v[i], v[i + 1], v[i + 2], v[i + 3]
    mixed = b + 0.5 * u * (c - a + u * (2.0 * a - 5.0 * b + 4.0 * c - d + u * (3.0 * (b - c) + d - a)))
    return np.moveaxis(mixed, 0, axis)
