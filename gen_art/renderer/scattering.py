"""Sunlight that the air scatters: once, integrated along rays, and many times, by Hillaire's approximation.

With T the transmittance along the ray, S the sun's light at a point and p the phase function for the angle to the sun,

    light along a ray   L = integral of T(s) [S sum_k (scattering_k p_k) + scattering Psi] ds + T light of the ground
    many times          Psi = M / (1 - f): M is the mean over all directions of light that was scattered once before (evenly, or
                        by the ground), f the mean of what even light 1 becomes when it is scattered once more

Psi is the same in all directions and depends on height and the sun's height alone. Hillaire's ground is lit by the sun; here the
air lights it too, which matters over snow.
Sources: Nishita, Sirai, Tadamura, Nakamae, Display of the Earth (1993); Hillaire, A Scalable and Production Ready Sky and
Atmosphere Rendering Technique (2020); Cornette, Shanks, Applied Optics 31 (1992), for the phase function of aerosols.
"""

import math
from typing import NamedTuple

import numpy as np

from gen_art.maths.array_functions import cos, exp
from gen_art.renderer.atmosphere import AIR_HEIGHT, BANDS, GROUND, TOP, Air, bilinear, densities, sunlight

__all__ = ["Scattered", "aerosol_phase", "along_rays", "multiple_scattering", "rayleigh_phase"]

_FORWARD = 0.8  # mean cosine of the angle by which aerosol scatters
_HEIGHTS, _SUNS, _LOWEST = 16, 28, -0.5  # of the table of Psi; its suns are at cosines x abs(x), x from _LOWEST to 1
_SLOPES, _AZIMUTHS, _STEPS = 10, 4, 12  # directions and steps of its means


def rayleigh_phase(cosine):
    """Phase function of air, 1/sr, for the cosine of the angle between light and ray: 3 (1 + cos^2) / (16 pi)."""
    return 3.0 / (16.0 * math.pi) * (1.0 + cosine * cosine)


def aerosol_phase(cosine):
    """Phase function of aerosol, 1/sr, after Cornette and Shanks, with g = 0.8."""
    g = _FORWARD
    q = 1.0 + g * g - 2.0 * g * cosine
    scale = 3.0 / (8.0 * math.pi) * (1.0 - g * g) / (2.0 + g * g)
    return scale * (1.0 + cosine * cosine) / (q * np.sqrt(q))


def ray_length(radius, cosine):
    """(m to the ground or, past it, to the top; whether it meets the ground) of rays from inside the air."""
    along = radius * cosine
    to_ground = along * along - radius * radius + GROUND * GROUND
    meets = (along < 0.0) & (to_ground >= 0.0)
    ground = -along - np.sqrt(np.maximum(to_ground, 0.0))
    top = -along + np.sqrt(np.maximum(along * along - radius * radius + TOP * TOP, 0.0))
    return np.where(meets, np.maximum(ground, 0.0), top), meets


def _steps(length, descends, number: int):
    """(middle, length) of the steps of rays, short where the air is dense: at the start, or at the end where one descends."""
    for k in range(number):
        u, du = (k + 0.5) / number, 1.0 / number
        down = 1.0 - u
        yield (
            np.where(descends, 1.0 - down * down, u * u) * length,
            np.where(descends, 2.0 * down, 2.0 * u) * du * length,
        )


def _local(air: Air, height):
    """(extinction (..., 17), scattering by air, scattering by aerosol) at heights, 1/m."""
    density = densities(height)
    by_air, by_aerosol = density[..., 0, None] * air.rayleigh, density[..., 1, None] * air.aerosol_scattering
    return air.depth(density), by_air, by_aerosol


def _mean_over_step(extinction, step):
    """The mean over a step of the transmittance from its start, times its length."""
    depth = extinction * step
    thin = depth < 1e-4
    return np.where(thin, step * (1.0 - 0.5 * depth), (1.0 - exp(-depth)) / np.where(thin, 1.0, extinction))


def _psi_place(height, sun_cosine):
    """Row and column of the table of Psi."""
    x = np.sqrt(np.abs(sun_cosine)) * np.where(sun_cosine < 0.0, -1.0, 1.0)
    row = np.sqrt(np.clip(height / (TOP - GROUND), 0.0, 1.0)) * (_HEIGHTS - 1)
    return row, (x - _LOWEST) * ((_SUNS - 1) / (1.0 - _LOWEST))


def multiple_scattering(air: Air) -> np.ndarray:
    """(heights, suns, 17) Psi, 1/sr, for sunlight 1 above the air; `_psi_place` says which entry is which."""
    u = np.linspace(0.0, 1.0, _HEIGHTS)
    radius = np.clip(GROUND + (TOP - GROUND) * u * u, GROUND + 1.0, TOP - 1.0)[:, None, None, None]
    x = np.linspace(_LOWEST, 1.0, _SUNS)
    sun = (x * np.abs(x))[:, None, None]
    slope = (np.arange(_SLOPES) + 0.5) * (2.0 / _SLOPES) - 1.0
    cosine = (slope * np.abs(slope))[:, None]  # dense at the horizon, where the light of dusk is
    azimuth = (np.arange(_AZIMUTHS) + 0.5) * (math.pi / _AZIMUTHS)
    to_sun = cosine * sun + np.sqrt((1.0 - cosine**2) * np.maximum(1.0 - sun**2, 0.0)) * cos(azimuth)
    length, meets = ray_length(radius, cosine)
    depth = np.zeros((*length.shape, BANDS))
    once = np.zeros((_HEIGHTS, _SUNS, _SLOPES, _AZIMUTHS, BANDS))
    again = np.zeros_like(depth)
    for s, step in _steps(length, meets, _STEPS):
        r = np.sqrt(radius**2 + s * s + 2.0 * radius * s * cosine)
        extinction, by_air, by_aerosol = _local(air, r - GROUND)
        passed = exp(-depth) * _mean_over_step(extinction, step[..., None]) * (by_air + by_aerosol)
        once += passed * sunlight(air, r, (radius * sun + s * to_sun) / r) * (1.0 / (4.0 * math.pi))
        again += passed
        depth += extinction * step[..., None]
    weight = np.abs(slope) / float(sum(np.abs(slope).tolist()))
    even = _mean(again, weight)
    # the light that falls from the air on the ground is a + b Psi; what the ground makes of it comes to the other heights too
    cosines = np.maximum(cosine[:, 0], 0.0)
    a, b = (4.0 * math.pi * _mean(part[:1], weight * cosines) for part in (once, again))
    high = np.clip((radius * sun + length * to_sun) / GROUND, 0.0, 1.0)
    scattered = air.albedo / math.pi * (exp(-depth) * meets[..., None])  # of light 1 on the ground
    once += scattered * high[..., None] * sunlight(air, np.full_like(high, GROUND), high)
    direct, share = _mean(once, weight), _mean(scattered, weight)
    psi_on_ground = (direct[:1] + share[:1] * a) / (1.0 - even[:1] - share[:1] * b)
    return (direct + share * (a + b * psi_on_ground)) / (1.0 - even)


def _mean(values, weight):
    """The mean over directions, the axes 2 (with its weights) and 3, in a fixed order."""
    total = np.zeros_like(values[:, :, 0, 0])
    for i, part in enumerate(weight):
        for j in range(values.shape[3]):
            total = total + values[:, :, i, j] * (part / values.shape[3])
    return total


class Scattered(NamedTuple):
    """What reaches the eye along rays, by band: the phase functions are not in it, because they change faster than the rest.

    by_air, by_aerosol : (rows, columns, 17), to be multiplied by the phase functions
    often : (rows, columns, 17) light that was scattered more than once, 1/sr
    passed : (rows, 17) the part of the light at a ray's end that passes
    """

    by_air: np.ndarray
    by_aerosol: np.ndarray
    often: np.ndarray
    passed: np.ndarray

    def radiance(self, to_sun) -> np.ndarray:
        """(rows, columns, 17) 1/sr, without the ground's light; to_sun : cosines (rows, columns) of the angle to the sun."""
        air, aerosol = rayleigh_phase(to_sun)[..., None], aerosol_phase(to_sun)[..., None]
        return self.by_air * air + self.by_aerosol * aerosol + self.often


def along_rays(
    air: Air, psi: np.ndarray, radius: float, cosine, azimuth, sun_cosine: float, steps: int = 32
) -> Scattered:
    """Light along rays from `radius`, for sunlight 1 above the air.

    psi : from `multiple_scattering`
    cosine : (rows,) of the angle between ray and straight up
    azimuth : (columns,) between ray and sun, rad
    sun_cosine : of the angle between the sun and straight up
    """
    cosine = np.asarray(cosine, float)[:, None]
    to_sun = angle_to_sun(cosine, azimuth, sun_cosine)
    length, meets = ray_length(radius, cosine)
    descends = meets & (radius > GROUND + AIR_HEIGHT)
    shape = (*to_sun.shape, BANDS)
    by_air, by_aerosol, often = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    depth = np.zeros((*length.shape, BANDS))
    for s, step in _steps(length, descends, steps):
        r = np.sqrt(radius**2 + s * s + 2.0 * radius * s * cosine)
        extinction, air_here, aerosol_here = _local(air, r - GROUND)
        passed = exp(-depth) * _mean_over_step(extinction, step[..., None])
        sun = (radius * sun_cosine + s * to_sun) / r
        light = sunlight(air, np.broadcast_to(r, sun.shape), sun)
        by_air += light * (passed * air_here)
        by_aerosol += light * (passed * aerosol_here)
        row, column = _psi_place(np.broadcast_to(r - GROUND, sun.shape), sun)
        often += bilinear(psi, row, column) * (passed * (air_here + aerosol_here))
        depth += extinction * step[..., None]
    return Scattered(by_air, by_aerosol, often, exp(-depth)[:, 0])


def angle_to_sun(cosine, azimuth, sun_cosine: float):
    """Cosine of the angle between rays and the sun, whose azimuths differ by `azimuth`."""
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0) * max(1.0 - sun_cosine * sun_cosine, 0.0))
    return cosine * sun_cosine + sine * cos(azimuth)
