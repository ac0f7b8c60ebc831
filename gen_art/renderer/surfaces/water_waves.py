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

__all__ = ["mean_reflected", "patch_rows", "wave_rows", "wave_slope"]

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
def _fading(x):
    """e^-x for 0 <= x < NOTHING_LEFT, to 2e-4: the sixteenth power of the series of a sixteenth."""
    y = x * (1.0 / 16.0)
    y = 1.0 - y * (1.0 - y * (0.5 - y * (1.0 / 6.0)))
    y *= y
    y *= y
    y *= y
    return y * y


@ti.func
def _cosine(x):
    """cos(x), to 5e-6 where x is exact: by the series of cos(x / 2), which its square leaves exact at its zeros."""
    turns = x * (0.5 / math.pi)
    half = math.pi * (turns - ti.floor(turns + 0.5))
    u = half * half
    c = 1.0 - u * (1.0 / 2.0 - u * (1.0 / 24.0 - u * (1.0 / 720.0 - u * (1.0 / 40320.0))))
    return 2.0 * c * c - 1.0


@ti.func
def _sine_over_pixel(W: ti.template(), k, place, east, south):
    """(row k's sine, the part of its amplitude that is left) at a place, both as means over a pixel."""
    number = ti.Vector([W[k, 0], W[k, 1]])
    # the pixel as a Gaussian with the variance of its square
    a, b = number.dot(east), number.dot(south)
    narrow, sine, left = (a * a + b * b) * (1.0 / 24.0), 0.0, 0.0
    if narrow < NOTHING_LEFT:
        left = _fading(narrow)
        sine = left * _cosine(number.dot(place) + W[k, 3])
    return sine, left


@ti.func
def wave_slope(W: ti.template(), M: ti.template(), m, column, place, east, south):
    """(3,) the slopes of waves along the two axes as the mean over a pixel, and the mean square slope of what is shorter."""
    result = ti.Vector([0.0, 0.0, 0.0])
    first = ti.cast(M[m, column], ti.i32)
    last = first + ti.cast(M[m, column + 1], ti.i32)
    for k in range(first, last):
        sine, left = _sine_over_pixel(W, k, place, east, south)
        result[0] += sine * W[k, 4]
        result[1] += sine * W[k, 5]
        result[2] += 0.5 * W[k, 2] * W[k, 2] * (1.0 - left * left)
    factor, hidden = 1.0, 0.0  # the pixel's mean of the factor on the slope, and its variance in the pixel
    for k in range(last, last + ti.cast(M[m, column + 2], ti.i32)):
        sine, left = _sine_over_pixel(W, k, place, east, south)
        factor += W[k, 2] * sine
        hidden += 0.5 * W[k, 2] * W[k, 2] * (1.0 - left * left)
    factor = ti.max(factor, 0.0)
    result[2] = factor * factor * result[2] + hidden * result[2]
    result[0] *= factor
    result[1] *= factor
    return result


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
