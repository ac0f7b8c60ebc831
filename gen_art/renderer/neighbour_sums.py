"""Sums over the neighbours of each particle, from which a look's `spread` and `stretch: {by: neighbours}` are found.

Neighbours are the particles within reach, weighted by w = (1 - (d / reach)^2)^3, d their distance. Of a crowded cell of
NeighbourCells SAMPLES particles, the first by their keys, stand for all.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import aligned, kernel, ti
from gen_art.renderer.lanes import LANES, all_lanes
from gen_art.renderer.neighbour_cells import NeighbourCells

__all__ = ["CHANCE", "DIAGONAL", "OTHERS", "SQUARES", "TOTAL", "NeighbourSums"]

SAMPLES = LANES  # of a cell, a vector of them

TOTAL, SQUARES, CHANCE, DIAGONAL, OTHERS, SUMS = 0, 1, 2, 3, 6, 9  # columns of the sums, and their number

F2, I1, I2 = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i32, 2)
VECTORS = ti.types.ndarray(ti.types.vector(SAMPLES, ti.f32), 2)


@ti.func
def _sum(v):
    """Of the lanes, in pairs."""
    numbers = [v[k] for k in ti.static(range(SAMPLES))]
    for width in ti.static((8, 4, 2, 1)):
        for k in ti.static(range(width)):
            numbers[k] += numbers[k + width]
    return numbers[0]


@ti.func
def _neighbours(S: ti.template(), cell, x, y, z, per_reach):
    """Where the samples of a cell lie from (x, y, z), in reaches, and their weights."""
    a, b, c = (S[cell, 0] - x) * per_reach, (S[cell, 1] - y) * per_reach, (S[cell, 2] - z) * per_reach
    s = ti.max(all_lanes(1.0) - (a * a + b * b + c * c), all_lanes(0.0))
    return a, b, c, s * s * s * S[cell, 3]


@ti.kernel
def _sums(X: F2, S: VECTORS, first: I1, runs: I2, per_reach: ti.f32, moments: ti.i32, result: F2):
    """The sums over the neighbours of each sorted particle.

    X, first, runs : positions, first and runs of NeighbourCells
    S : the samples of each cell, three coordinates and how many particles each stands for
    moments : whether the sums of e are found, or are 0
    """
    ti.loop_config(block_dim=1)
    for block in range((runs.shape[0] + 63) // 64):
        for cell in range(block * 64, ti.min((block + 1) * 64, runs.shape[0])):
            for i in range(first[cell], first[cell + 1]):
                x, y, z, per = all_lanes(X[i, 0]), all_lanes(X[i, 1]), all_lanes(X[i, 2]), all_lanes(per_reach)
                total, squares, mean = all_lanes(0.0), all_lanes(0.0), [all_lanes(0.0) for _ in ti.static(range(3))]
                for r in range(9):
                    for other in range(runs[cell, 2 * r], runs[cell, 2 * r + 1]):
                        a, b, c, w = _neighbours(S, other, x, y, z, per)
                        total, squares = total + w, squares + w * w
                        mean[0], mean[1], mean[2] = mean[0] + a * w, mean[1] + b * w, mean[2] + c * w
                result[i, TOTAL], result[i, SQUARES] = _sum(total), _sum(squares)
                parts = [all_lanes(0.0) for _ in ti.static(range(7))]
                if moments == 1 and result[i, TOTAL] > 0.0:
                    per_total = 1.0 / result[i, TOTAL]
                    middle = [all_lanes(_sum(mean[k]) * per_total) for k in ti.static(range(3))]
                    for r in range(9):
                        for other in range(runs[cell, 2 * r], runs[cell, 2 * r + 1]):
                            a, b, c, w = _neighbours(S, other, x, y, z, per)
                            a, b, c = a - middle[0], b - middle[1], c - middle[2]
                            aa, bb, cc = a * a, b * b, c * c
                            square = w * (aa + bb + cc)
                            parts[0] = parts[0] + square * square
                            parts[1], parts[2], parts[3] = parts[1] + aa * w, parts[2] + bb * w, parts[3] + cc * w
                            parts[4], parts[5], parts[6] = (
                                parts[4] + a * b * w,
                                parts[5] + a * c * w,
                                parts[6] + b * c * w,
                            )
                for k in ti.static(range(7)):
                    result[i, CHANCE + k] = _sum(parts[k])


_sums_kernel = kernel(_sums, vectors=True)


def _samples(cells: NeighbourCells) -> np.ndarray:
    """(cells, 4, SAMPLES) float32: three coordinates, m, and the number of particles that each sample stands for, or 0."""
    start, number = cells.first[:-1], np.diff(cells.first)
    taken = np.minimum(number, SAMPLES)
    lane = np.arange(SAMPLES)
    present = lane < taken[:, None]
    samples = aligned((len(start), 4, SAMPLES), np.float32)
    at = start[:, None] + np.where(present, lane, 0)
    for axis in range(3):
        samples[:, axis] = np.take(cells.positions[:, axis], at)
    samples[:, 3] = np.where(present, (number / taken)[:, None], 0.0)
    return samples


@dataclass(frozen=True)
class NeighbourSums:
    """The sums of those particles of a system that exist.

    slots : (n,) the particles
    sums : (n, 9) float32: of w, w^2, w^2 |e|^4 and w e e^T (xx, yy, zz, xy, xz, yz), e the place from the neighbours' mean,
        in reaches
    count : the particles of the system, those that do not exist among them
    reach : m
    """

    slots: np.ndarray
    sums: np.ndarray
    count: int
    reach: float

    @classmethod
    def of(cls, system, time: float, reach: float, moments: bool = True) -> "NeighbourSums":
        """The sums of a system at simulated time `time`.

        moments : whether the sums of e are needed; otherwise they are 0
        """
        count = max(int(system.count), 1)
        cells = NeighbourCells.of(system, time, reach)
        if cells is None:
            return cls(np.empty(0, np.int64), np.empty((0, SUMS), np.float32), count, reach)
        sums = np.empty((len(cells.slots), SUMS), np.float32)
        _sums_kernel(cells.positions, _samples(cells), cells.first, cells.runs, 1.0 / reach, int(moments), sums)
        return cls(cells.slots, sums, count, reach)
