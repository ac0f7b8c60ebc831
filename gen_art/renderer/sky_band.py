"""The band of distant stars in a sky: its light by direction, with clouds of dust before it, from a seed.

    light = intensity * gradient(t) * t,    t = glow * clumps * exp(-dust)
    glow  = exp(-(s / w)^2 / 2) (1 + 2 exp(-angle^2 / 2 / 0.4^2)) / 3 + a third of a band three times as wide

where s is the sine of the height above the band's plane, w that of its width, and `angle` the direction's distance from the core.
Clumps and dust are sums of octaves of value noise on a periodic lattice; the smallest are as large as the cells of the table.
"""

import math

import numpy as np

from gen_art.backend.kept_arrays import kept
from gen_art.maths.array_functions import exp
from gen_art.maths.random import derive, uniform
from gen_art.preset.sky import Band
from gen_art.renderer.colour import gradient_table
from gen_art.renderer.sky_table import directions_of_table

__all__ = ["band_light", "band_table"]

_SIDE = 32  # cells of the lattice, which repeats after them
_CORE = 0.4  # rad
_GRADIENT = 1025


def _noise(lattice: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Smooth noise in 0..1 at lattice positions p (..., 3)."""
    base = np.floor(p)
    f = p - base
    u, v, w = np.moveaxis(f * f * (3.0 - 2.0 * f), -1, 0)
    i = base.astype(np.int64) % _SIDE
    j = (i + 1) % _SIDE
    flat = lattice.ravel()

    def along_z(x, y):
        row = (x * _SIDE + y) * _SIDE
        first = flat[row + i[..., 2]]
        return first + (flat[row + j[..., 2]] - first) * w

    a, b = along_z(i[..., 0], i[..., 1]), along_z(j[..., 0], i[..., 1])
    c, d = along_z(i[..., 0], j[..., 1]), along_z(j[..., 0], j[..., 1])
    a, c = a + (b - a) * u, c + (d - c) * u
    return a + (c - a) * v


def _octaves(lattice: np.ndarray, d: np.ndarray, cells: float, octaves: int, ridges: bool = False) -> np.ndarray:
    """A sum of octaves of noise over directions d, in 0..1; with `ridges`, high along lines."""
    total, most, size = np.zeros(d.shape[:-1]), 0.0, 1.0
    for k in range(octaves):
        n = _noise(lattice, d * (cells * 2.0**k) + (7.3 + 11.7 * k))
        total += size * (1.0 - np.abs(2.0 * n - 1.0) if ridges else n)
        most, size = most + size, 0.55 * size
    return total / most


def band_table(spec: Band) -> np.ndarray:
    """(ROWS, COLUMNS, 3) linear light of the directions of a sky's table."""
    return _band_table(spec)[0]


@kept
def _band_table(spec: Band) -> tuple[np.ndarray, ...]:
    return (band_light(spec, directions_of_table()),)


def band_light(spec: Band, d: np.ndarray) -> np.ndarray:
    """(..., 3) linear light of unit directions d (..., 3)."""
    keys = derive(derive(np.uint64(spec.seed), 1), np.arange(_SIDE**3, dtype=np.uint64))
    clumps, dust = (uniform(keys, channel).reshape(_SIDE, _SIDE, _SIDE) for channel in (0, 1))
    normal = np.array(spec.normal) / math.sqrt(sum(x * x for x in spec.normal))
    core = np.array(spec.core, np.float64)
    core = core - normal * float(np.sum(core * normal))
    core = core / math.sqrt(float(np.sum(core * core)))
    width = math.radians(spec.width)
    height = d[..., 0] * normal[0] + d[..., 1] * normal[1] + d[..., 2] * normal[2]
    towards = d[..., 0] * core[0] + d[..., 1] * core[1] + d[..., 2] * core[2]
    bent = height + width * 1.1 * (_octaves(clumps, d, 1.7, 3) - 0.5)
    near_core = exp(-(2.0 - 2.0 * towards) / (2.0 * _CORE * _CORE))
    thick = width * (1.0 + 0.6 * near_core)
    glow = (
        exp(-0.5 * (bent / thick) ** 2) * (1.0 + 2.0 * near_core) / 3.0
        + exp(-0.5 * (height / (3.0 * width)) ** 2) / 9.0
    )
    texture = _octaves(clumps, d, 4.0, 4)
    texture = 0.3 + 2.4 * texture * texture
    flat = d + normal * height[..., None]  # lanes run along the band
    lanes = _octaves(dust, flat + 0.12 * (texture[..., None] - 0.9), 2.5, 4, ridges=True)
    lanes = np.maximum(lanes - 0.5, 0.0) * exp(-0.5 * (bent / width) ** 2)
    t = glow * texture * exp(-spec.dust * 6.0 * lanes)
    table = gradient_table(spec.color, _GRADIENT)
    at = np.minimum(t * 1.25, 1.0)
    places = np.linspace(0.0, 1.0, _GRADIENT)
    colour = np.stack([np.interp(at, places, table[:, c]) for c in range(3)], axis=-1)
    return colour * (spec.intensity * t)[..., None]
