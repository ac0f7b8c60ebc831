"""Waves on water: sines that turn the normal of a level surface.

They travel as gravity and capillary waves on deep water: w^2 = g k + (s / rho) k^3, w their angular frequency, k the wave
number, s the surface tension and rho the density of water. What is shorter than a pixel makes the surface rougher instead; the
mean that a rough sea reflects follows Bruneton, Neyret and Holzschuch, Real-time realistic ocean lighting using seamless
transitions from geometry to BRDF (2010).

The one-letter names in kernels are in docs/glossary.md.
"""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.maths.array_functions import cos as cosines
from gen_art.maths.array_functions import exp as exponentials
from gen_art.maths.array_functions import log as logarithms
from gen_art.maths.array_functions import sin as sines
from gen_art.maths.elementary import exp, log
from gen_art.maths.random import derive, uniform
from gen_art.preset.surface import Waves

__all__ = ["mean_reflected", "one_number", "patch_rows", "wave_rows", "wave_slope"]

_PATCH_SINES = 24  # that make the water uneven
_WORD = 2**64 - 1
_GRAVITY, _TENSION = 9.81, 7.28e-5  # m/s^2; surface tension over density of water, m^3/s^2
NOTHING_LEFT = 20.0  # exp(-20), a pixel's part of a wave that float32 no longer shows beside others

# channels of the random numbers: of waves, and of the sines that make the water uneven
_DIRECTION, _LENGTH, _PHASE, _PATCH_DIRECTION, _PATCH_LENGTH, _PATCH_PHASE = range(6)


def wave_rows(waves: Waves, time: float) -> np.ndarray:
    """(number, 6) float32 of SurfaceMaps.waves: lengths even in their logarithm, each with the same mean square slope."""
    n = waves.number
    keys = derive(np.uint64(waves.seed & _WORD), np.arange(n))
    share = (np.arange(n) + uniform(keys, _LENGTH)) / n
    low, high = waves.length.lo, max(waves.length.hi, waves.length.lo)
    k = 2.0 * math.pi / exponentials(logarithms(np.float64(low)) + share * (math.log(high) - math.log(low)))
    # directions by the inverse of a linear density that falls to 0 at `spread` on both sides
    u = 2.0 * uniform(keys, _DIRECTION) - 1.0
    turn = np.sign(u) * (1.0 - np.sqrt(1.0 - np.abs(u))) * math.radians(waves.spread)
    heading = math.radians(waves.direction) + turn
    frequency = np.sqrt(_GRAVITY * k + _TENSION * k**3)
    phase = 2.0 * math.pi * uniform(keys, _PHASE) - frequency * time * waves.speed
    slope = waves.slope * math.sqrt(2.0 / n)
    return _rows(k, heading, slope, phase)


def patch_rows(waves: Waves) -> np.ndarray:
    """(m, 6) float32 of SurfaceMaps.waves: sines whose sum, plus 1, is the factor on the slope; no rows for an even sea.

    Their lengths go from twice `patch_size` to a quarter of it, in all directions, and their sum has the deviation `patches`.
    """
    if waves.patches == 0.0:
        return np.zeros((0, 6), np.float32)
    n = _PATCH_SINES
    keys = derive(np.uint64(waves.seed & _WORD), np.arange(n))
    length = waves.patch_size * exponentials(
        math.log(2.0) * (1.0 - 3.0 * (np.arange(n) + uniform(keys, _PATCH_LENGTH)) / n)
    )
    heading = 2.0 * math.pi * uniform(keys, _PATCH_DIRECTION)
    return _rows(
        2.0 * math.pi / length, heading, waves.patches * math.sqrt(2.0 / n), 2.0 * math.pi * uniform(keys, _PATCH_PHASE)
    )


def _rows(k: np.ndarray, heading: np.ndarray, amplitude: float, phase: np.ndarray) -> np.ndarray:
    east, south, all_rows = cosines(heading), sines(heading), np.ones(len(k))
    rows = [
        k * east,
        k * south,
        amplitude * all_rows,
        np.mod(phase, 2.0 * math.pi),
        amplitude * east,
        amplitude * south,
    ]
    return np.stack(rows, axis=1).astype(np.float32)


@ti.func
def one_number(x):
    """The number itself: `of` where functions are used with numbers; with whole vectors it is `all_lanes`."""
    return x


@ti.func
def _fading(x, of: ti.template()):
    """e^-x for 0 <= x < NOTHING_LEFT, to 2e-4: the sixteenth power of the series of a sixteenth."""
    y = x * of(1.0 / 16.0)
    series = of(1.0) - y * (of(1.0) - y * (of(0.5) - y * of(1.0 / 6.0)))
    second = series * series
    fourth = second * second
    eighth = fourth * fourth
    return eighth * eighth


@ti.func
def _cosine(x, of: ti.template()):
    """cos(x), to 5e-6 where x is exact: by the series of cos(x / 2), which its square leaves exact at its zeros."""
    turns = x * of(0.5 / math.pi)
    half = of(math.pi) * (turns - ti.floor(turns + of(0.5)))
    u = half * half
    c = of(1.0) - u * (of(1.0 / 2.0) - u * (of(1.0 / 24.0) - u * (of(1.0 / 720.0) - u * of(1.0 / 40320.0))))
    return of(2.0) * c * c - of(1.0)


@ti.func
def _sine_over_pixel(
    W: ti.template(), k, of: ti.template(), place: ti.template(), east: ti.template(), south: ti.template()
):
    """(row k's sine, the part of its amplitude that is left) at a place, both as means over a pixel."""
    along, across = of(W[k, 0]), of(W[k, 1])
    # the pixel as a Gaussian with the variance of its square
    a, b = along * east[0] + across * east[1], along * south[0] + across * south[1]
    narrow, gone = (a * a + b * b) * of(1.0 / 24.0), of(NOTHING_LEFT)
    left = ti.select(narrow < gone, _fading(ti.min(narrow, gone), of), of(0.0))
    return left * _cosine(along * place[0] + across * place[1] + of(W[k, 3]), of), left


@ti.func
def wave_slope(
    W: ti.template(), first, waves, uneven, of: ti.template(), place: ti.template(), east: ti.template(), south: ti.template()
):  # fmt: skip
    """The slopes of waves along the two axes as the mean over a pixel, and the mean square slope of what is shorter.

    W : of SurfaceMaps.waves; first, waves, uneven : the first row, the number of waves, and of the rows that make them uneven
    of : `one_number`, or `all_lanes` where the places of sixteen pixels are whole vectors
    place : m, on the two axes; east, south : from one pixel to the next
    """
    slope_east, slope_south, shorter = of(0.0), of(0.0), of(0.0)
    for k in range(first, first + waves):
        sine, left = _sine_over_pixel(W, k, of, place, east, south)
        square = of(0.5 * W[k, 2] * W[k, 2])
        slope_east, slope_south = slope_east + sine * of(W[k, 4]), slope_south + sine * of(W[k, 5])
        shorter = shorter + square * (of(1.0) - left * left)
    factor, hidden = of(1.0), of(0.0)  # the pixel's mean of the factor on the slope, and its variance in the pixel
    for k in range(first + waves, first + waves + uneven):
        sine, left = _sine_over_pixel(W, k, of, place, east, south)
        factor = factor + of(W[k, 2]) * sine
        hidden = hidden + of(0.5 * W[k, 2] * W[k, 2]) * (of(1.0) - left * left)
    factor = ti.max(factor, of(0.0))
    return slope_east * factor, slope_south * factor, (factor * factor + hidden) * shorter


@ti.func
def _rough_sea(nv, base, square):
    deviation = ti.sqrt(square)
    power = 5.0 * exp(-2.69 * deviation)
    return base + (1.0 - base) * exp(power * log(ti.max(1.0 - nv, 1e-6))) / (
        1.0 + 22.7 * deviation * ti.sqrt(deviation)
    )


@ti.func
def mean_reflected(reflected, nv, ior, square):
    """What water reflects of light from above, as the mean over waves with this mean square slope along the view.

    reflected : what it reflects where it is flat
    """
    at_once = (ior - 1.0) / (ior + 1.0)
    base = at_once * at_once
    return reflected * _rough_sea(nv, base, square) / _rough_sea(nv, base, 0.0)
