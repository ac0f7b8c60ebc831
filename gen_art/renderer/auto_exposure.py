"""Automatic exposure: how bright a picture is, and the stops that give it the brightness it should have.

A picture is metered on a grid of at most 36 x 64 cells, so that a point is as bright at any size of picture. With L the
luminance of each cell, the metered light is the log-average in which each cell is weighted by its light,

    log2 M = sum(L log2 L) / sum(L),

in stops above middle grey (0.18). Black areas do not count, however large they are, and twice the light is one stop more.
The exposure is a function of the metered values at fixed earlier times of the film, weighted by 2^(-age / half_life). So a
frame's exposure is the same whichever other frames are made, and on however many threads.

The one-letter names in kernels are in docs/glossary.md.
"""

import math
from collections.abc import Sequence

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.preset.develop import AutoExposure
from gen_art.renderer.bloom import as_vectors
from gen_art.renderer.colour import LUMINANCE
from gen_art.renderer.tone_curves import GREY

__all__ = ["metered_stops", "metering_ages", "smoothed_exposure"]

CELL_ROWS, CELL_COLUMNS = 36, 64
MAX_SAMPLES = 8  # how many earlier values are used, over MAX_HALF_LIVES
MAX_HALF_LIVES = 3.0
MIN_LIGHT = 2.0**-30  # luminance below it counts as black

F1, F2, I1 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f64, 2), ti.types.ndarray(ti.i32, 1)


@ti.kernel
def _cell_luminance(linear: F1, stride: ti.i32, y: I1, x: I1, red: ti.f32, green: ti.f32, blue: ti.f32, cells: F2):
    """Mean luminance of rows y[i] .. y[i + 1] and columns x[j] .. x[j + 1].

    Each cell is summed by one thread in a fixed order, so the number of threads changes no bit.
    """
    ti.loop_config(block_dim=1)
    for i in range(cells.shape[0]):
        for j in range(cells.shape[1]):
            total = ti.cast(0.0, ti.f64)
            for row in range(y[i], y[i + 1]):
                r, g, b = 0.0, 0.0, 0.0
                for column in range(x[j], x[j + 1]):
                    o = row * stride + column * 4
                    r += linear[o]
                    g += linear[o + 1]
                    b += linear[o + 2]
                total += ti.cast(red * r + green * g + blue * b, ti.f64)
            cells[i, j] = total / ti.cast((y[i + 1] - y[i]) * (x[j + 1] - x[j]), ti.f64)


_cells_kernel = kernel(_cell_luminance)


def _cell_edges(n: int, cells: int) -> np.ndarray:
    cells = min(n, cells)
    return (np.arange(cells + 1) * n // cells).astype(np.int32)


def metered_stops(linear: np.ndarray) -> float:
    """The brightness of linear light (height, width, 4) float32, in stops above middle grey; -inf when it is black."""
    height, width, _ = linear.shape
    vectors, stride = as_vectors(linear)
    y, x = _cell_edges(height, CELL_ROWS), _cell_edges(width, CELL_COLUMNS)
    cells = np.zeros((len(y) - 1, len(x) - 1))
    _cells_kernel(vectors.reshape(-1), 16 * stride, y, x, *(float(c) for c in LUMINANCE), cells)
    cells = cells[np.isfinite(cells) & (cells > MIN_LIGHT)]
    if not len(cells):
        return -math.inf
    return float((cells * np.log2(cells)).sum() / cells.sum()) - math.log2(GREY)


def metering_ages(spec: AutoExposure, fps: float) -> list[float]:
    """The ages, in seconds before a frame, of the metered values that make its exposure: 0 first, whole frames apart.

    The caller leaves out ages that lie before the film's start.
    """
    if spec.half_life == 0.0:
        return [0.0]
    frames = MAX_HALF_LIVES * spec.half_life * fps
    interval = max(1, round(frames / MAX_SAMPLES))
    return [k * interval / fps for k in range(min(MAX_SAMPLES, math.ceil(frames / interval - 1e-9)) + 1)]


def smoothed_exposure(values: Sequence[float], ages: Sequence[float], spec: AutoExposure) -> float:
    """The exposure in stops, within the spec's range, from metered values and their ages in seconds.

    The newest value has the largest weight; black ones (-inf) have none. 0 when all are black.
    """
    total = weight = 0.0
    for value, age in zip(values, ages, strict=True):
        if math.isfinite(value):
            age_weight = 2.0 ** (-age / spec.half_life) if spec.half_life else float(age == 0.0)
            total, weight = total + age_weight * value, weight + age_weight
    if not weight:
        return 0.0
    stops = math.log2(spec.key / GREY) - total / weight
    return min(max(stops, spec.range.lo), spec.range.hi)
