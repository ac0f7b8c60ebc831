"""Stars: how many, how bright, of which colour and where, from a seed, and their light in a picture.

    number brighter than magnitude m    N(m) = 5.1 * 10^(m / 2), 9,070 for m = 6.5
    light of magnitude m                10^(-0.4 m) of that of magnitude 0
    colour                              of black bodies, whose temperatures are spread as those of the spectral classes
    place                               even over the sphere

Star k is one of the k + 1 brightest for every limit, so a fainter limit adds stars and moves none.
Sources: Allen's Astrophysical Quantities (4th ed., 2000), counts of stars by magnitude; Hoffleit, Warren, The Bright Star
Catalogue (5th ed., 1991): 9,096 stars to 6.5, and the shares of its spectral classes.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.array_functions import cos, exp, log, sin
from gen_art.maths.random import derive, uniform
from gen_art.preset.sky import Stars
from gen_art.renderer.colour import blackbody, luminance_of

__all__ = ["StarField", "add_stars", "star_field", "stars_brighter"]

D2, F1 = ti.types.ndarray(ti.f64, 2), ti.types.ndarray(ti.f32, 1)

_BRIGHTER_THAN_0, _SLOPE = 5.1, 0.5  # stars; growth of log10 N with the magnitude
_DISC = math.pi * math.radians(0.1) ** 2  # sr: a star of magnitude 0 has the light of this area with light 1
# ends of the classes B (with O), A, F, G, K, M, from hot to cool, and the share of the stars down to there
_TEMPERATURES = np.array([28_000.0, 10_000.0, 7_500.0, 6_000.0, 5_200.0, 3_700.0, 2_900.0])
_SHARES = np.array([0.0, 0.20, 0.42, 0.56, 0.69, 0.94, 1.0])
_COLOURS = 4096  # entries of the table of colours
_PLACE, _TURN, _MAGNITUDE, _TEMPERATURE = range(4)  # channels of the random numbers


@dataclass(frozen=True, eq=False)
class StarField:
    """Stars of one sky.

    directions : (n, 3) unit vectors
    light : (n, 3) linear light times solid angle, sr
    """

    directions: np.ndarray
    light: np.ndarray


def stars_brighter(magnitude: float) -> float:
    """The number of stars of the whole sky that are brighter than a magnitude."""
    return _BRIGHTER_THAN_0 * 10.0 ** (_SLOPE * magnitude)


@lru_cache(8)
def star_field(spec: Stars) -> StarField:
    """The stars, the brightest first."""
    number = int(stars_brighter(spec.magnitude))
    keys = derive(derive(np.uint64(spec.seed), 0), np.arange(number, dtype=np.uint64))
    # one star in each whole number of N(m), in its second half, so that the first is no brighter than Sirius
    rank = np.arange(number) + 0.5 + 0.5 * uniform(keys, _MAGNITUDE)
    flux = exp(log(rank / _BRIGHTER_THAN_0) * (-0.4 / _SLOPE))  # 10^(-0.4 m) with m from N(m) = rank
    mired = np.interp(uniform(keys, _TEMPERATURE), _SHARES, 1.0 / _TEMPERATURES)
    colour = _colours(mired)
    colour = colour / luminance_of(colour)[:, None]
    y, angle = 2.0 * uniform(keys, _PLACE) - 1.0, 2.0 * math.pi * uniform(keys, _TURN)
    level = np.sqrt(np.maximum(1.0 - y * y, 0.0))
    directions = np.stack([level * cos(angle), y, level * sin(angle)], axis=1)
    return StarField(directions, colour * (flux * (spec.intensity * _DISC))[:, None])


def _colours(mired: np.ndarray) -> np.ndarray:
    """(n, 3) the colours of black bodies of 1 / `mired` kelvin, from a table, which is within 1e-3 of them."""
    places = np.linspace(1.0 / _TEMPERATURES.max(), 1.0 / _TEMPERATURES.min(), _COLOURS)
    table = np.round(blackbody(1.0 / places), 9)  # the last bits of NumPy's exponentials differ between processors
    return np.stack([np.interp(mired, places, table[:, c]) for c in range(3)], axis=1)


def add_stars(stars: StarField, axes: np.ndarray, scale: float, pixels: np.ndarray) -> None:
    """Add the stars to a picture (height, width, 4), in place, where nothing hides them.

    axes : (3, 3), rows right, up, forward
    scale : pixels per unit of slope
    A star is spread over 3 x 3 pixels with the weights of a quadratic B-spline, whose sum is 1 wherever the star is. Its light
    is that of its solid angle in pixels, which at the angle a from the middle of the picture are cos(a)^3 / scale^2 sr each.
    """
    height, width = pixels.shape[:2]
    stride = pixels.strides[0] // pixels.itemsize
    flat = np.lib.stride_tricks.as_strided(pixels, (stride * (height - 1) + 4 * width,), (pixels.itemsize,))
    if len(stars.directions):
        _add_kernel(
            stars.directions, stars.light, np.ascontiguousarray(axes, np.float64), scale, width, height, stride, flat
        )


@ti.func
def _weights(f):
    """Of a pixel's neighbour, the pixel and its other neighbour, for a point at -0.5..0.5 from the pixel's middle."""
    return ti.Vector([0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f)])


@ti.kernel
def _add(
    directions: D2, light: D2, axes: D2, scale: ti.f64, width: ti.i32, height: ti.i32, stride: ti.i32, pixels: F1
):  # fmt: skip
    ti.loop_config(serialize=True)  # stars may share pixels
    for star in range(directions.shape[0]):
        n = ti.Vector([directions[star, 0], directions[star, 1], directions[star, 2]])
        x, y, z = [n[0] * axes[c, 0] + n[1] * axes[c, 1] + n[2] * axes[c, 2] for c in ti.static(range(3))]
        if (z > 1e-3) & (ti.max(light[star, 0], light[star, 1], light[star, 2]) > 0.0):
            column, row = 0.5 * width + x * scale / z, 0.5 * height - y * scale / z
            if (column > -1.0) & (column < width + 1.0) & (row > -1.0) & (row < height + 1.0):
                i, j = ti.floor(row), ti.floor(column)
                down, right, share = _weights(row - i - 0.5), _weights(column - j - 0.5), scale * scale / (z * z * z)
                for k in ti.static(range(3)):
                    for m in ti.static(range(3)):
                        at, beside = ti.cast(i, ti.i32) + (k - 1), ti.cast(j, ti.i32) + (m - 1)
                        if (at >= 0) & (at < height) & (beside >= 0) & (beside < width):
                            o = at * stride + 4 * beside
                            weight = down[k] * right[m] * ti.max(1.0 - ti.cast(pixels[o + 3], ti.f64), 0.0) * share
                            for c in ti.static(range(3)):
                                pixels[o + c] += ti.cast(light[star, c] * weight, ti.f32)


_add_kernel = kernel(_add, "f64")
