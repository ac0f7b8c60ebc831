"""Automatic exposure: how bright a film is, and the stops that make it as bright as it should be.

A film is metered on a grid of at most 36 x 64 cells, so that a point is as bright at any size of picture. With L the
luminance of each cell, the metered light is the log-average in which each cell counts by its light,

    log2 M = sum(L log2 L) / sum(L),

in stops above middle grey (0.18): what is black counts nothing, however much of it there is, and twice the light is one stop
more. Exposure is then a function of the metered values at fixed earlier times of the film, weighted by 2^(-age / half_life),
so a frame has the exposure it has in a film, whichever frames are made and on how many threads.
"""

import math
from collections.abc import Sequence

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.preset.develop import AutoExposure
from gen_art.renderer.bloom import flat
from gen_art.renderer.colour import LUMINANCE
from gen_art.renderer.tone_curves import GREY

__all__ = ["ages", "meter", "smooth"]

DOWN, ACROSS = 36, 64
SAMPLES = 8  # how many earlier values are weighed, over LONGEST half-lives
LONGEST = 3.0
DARKEST = 2.0**-30  # light below it is no light

F1, F2, I1 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f64, 2), ti.types.ndarray(ti.i32, 1)


@ti.kernel
def _cells(film: F1, stride: ti.i32, y: I1, x: I1, red: ti.f32, green: ti.f32, blue: ti.f32, cells: F2):
    """Mean luminance of rows y[i] .. y[i + 1] and columns x[j] .. x[j + 1]; each cell is one sum in one order."""
    ti.loop_config(block_dim=1)
    for i in range(cells.shape[0]):
        for j in range(cells.shape[1]):
            total = ti.cast(0.0, ti.f64)
            for row in range(y[i], y[i + 1]):
                r, g, b = 0.0, 0.0, 0.0
                for column in range(x[j], x[j + 1]):
                    o = row * stride + column * 4
                    r += film[o]
                    g += film[o + 1]
                    b += film[o + 2]
                total += ti.cast(red * r + green * g + blue * b, ti.f64)
            cells[i, j] = total / ti.cast((y[i + 1] - y[i]) * (x[j + 1] - x[j]), ti.f64)


cells_kernel = kernel(_cells)


def _edges(n: int, parts: int) -> np.ndarray:
    parts = min(n, parts)
    return (np.arange(parts + 1) * n // parts).astype(np.int32)


def meter(film: np.ndarray) -> float:
    """How bright linear light (height, width, 4) float32 is, in stops above middle grey; -inf when it is black."""
    height, width, _ = film.shape
    light, stride = flat(film)
    y, x = _edges(height, DOWN), _edges(width, ACROSS)
    cells = np.zeros((len(y) - 1, len(x) - 1))
    cells_kernel(light.reshape(-1), 16 * stride, y, x, *(float(c) for c in LUMINANCE), cells)
    cells = cells[np.isfinite(cells) & (cells > DARKEST)]
    if not len(cells):
        return -math.inf
    return float((cells * np.log2(cells)).sum() / cells.sum()) - math.log2(GREY)


def ages(spec: AutoExposure, fps: float) -> list[float]:
    """How many seconds before a frame the values lie that its exposure is made of, 0 first: whole frames apart.

    Ages beyond the film's start are left out by the caller.
    """
    if spec.half_life == 0.0:
        return [0.0]
    frames = LONGEST * spec.half_life * fps
    apart = max(1, round(frames / SAMPLES))
    return [k * apart / fps for k in range(min(SAMPLES, math.ceil(frames / apart - 1e-9)) + 1)]


def smooth(values: Sequence[float], ages: Sequence[float], spec: AutoExposure) -> float:
    """The exposure in stops of what was metered (`meter`) some seconds ago: the newest counts most; black counts nothing.

    Within the spec's range; 0 when all is black.
    """
    total = weight = 0.0
    for value, age in zip(values, ages, strict=True):
        if math.isfinite(value):
            share = 2.0 ** (-age / spec.half_life) if spec.half_life else float(age == 0.0)
            total, weight = total + share * value, weight + share
    if not weight:
        return 0.0
    wanted = math.log2(spec.key / GREY) - total / weight
    return min(max(wanted, spec.range.lo), spec.range.hi)
