"""Solids in the cells of a grid in space, through which rays from one surface to the next find what they meet.

A ray visits the cells on its way in order and stops at a hit that lies in the cell where it is.
Source: Amanatides and Woo, A fast voxel traversal algorithm for ray tracing, Eurographics 1987.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.cell_lists import cell_lists
from gen_art.renderer.surfaces.scene_numbers import GRID_CELL, GRID_CORNER, GRID_SHAPE, vector_at
from gen_art.renderer.surfaces.solids import BOUND, CENTER, NEVER, solid_hit

__all__ = ["SolidGrid", "far_side", "nearest_solid"]

_CELLS = 64  # most cells along a side
_PER_SOLID = 2.0  # cells for each solid


@dataclass(frozen=True)
class SolidGrid:
    """Solids in cells along the axes of the world.

    corner : (3,) of the grid relative to the camera
    cell : (3,) sides of a cell
    shape : cells along each axis
    starts : (cells + 1,) int32, the first of each cell's solids
    solids : their indices
    """

    corner: np.ndarray
    cell: np.ndarray
    shape: tuple[int, int, int]
    starts: np.ndarray
    solids: np.ndarray

    @classmethod
    def none(cls) -> "SolidGrid":
        """A grid without solids."""
        return cls(np.zeros(3), np.ones(3), (0, 0, 0), np.zeros(2, np.int32), np.zeros(1, np.int32))

    @classmethod
    def of(cls, rows: np.ndarray) -> "SolidGrid":
        """The grid of these rows of solids, by the balls around them."""
        if not len(rows):
            return cls.none()
        centers, bound = rows[:, CENTER : CENTER + 3].astype(np.float64), rows[:, BOUND, None].astype(np.float64)
        low, high = (centers - bound).min(axis=0), (centers + bound).max(axis=0)
        margin = 1e-5 * (np.abs(low) + np.abs(high) + high - low) + 1e-30
        low, high = low - margin, high + margin
        extent = high - low
        side = float(np.cbrt(extent.prod() / (_PER_SOLID * len(rows))))
        counts = np.clip(np.ceil(extent / max(side, 1e-30)), 1, _CELLS).astype(np.int64)
        cell = extent / counts
        first = np.clip(((centers - bound - low) / cell).astype(np.int64), 0, counts - 1)
        last = np.clip(((centers + bound - low) / cell).astype(np.int64), 0, counts - 1)
        shape = (int(counts[0]), int(counts[1]), int(counts[2]))
        return cls(low, cell, shape, *cell_lists(first, last, shape))


@ti.func
def nearest_solid(scene: ti.template(), o, d, high):
    """(distance, index) of the first solid that a ray (relative to the camera) enters before `high`, or (high, -1)."""
    N = ti.static(scene.N)
    nearest, found = high, -1
    if N[GRID_SHAPE] > 0.5:
        low, end = 0.0, high
        inverse, cell = d, ti.Vector([0, 0, 0])
        for k in ti.static(range(3)):
            inverse[k] = 1.0 / ti.select(abs(d[k]) > 1e-12, d[k], 1e-12)
            a = (N[GRID_CORNER + k] - o[k]) * inverse[k]
            b = a + N[GRID_CELL + k] * N[GRID_SHAPE + k] * inverse[k]
            low, end = ti.max(low, ti.min(a, b)), ti.min(end, ti.max(a, b))
        if low < end:
            corner, step, crossing, change = vector_at(N, GRID_CORNER), ti.Vector([0, 0, 0]), d, d
            for k in ti.static(range(3)):
                last = ti.cast(N[GRID_SHAPE + k], ti.i32) - 1
                at = ti.cast(ti.floor((o[k] + d[k] * low - corner[k]) / N[GRID_CELL + k]), ti.i32)
                cell[k] = ti.min(ti.max(at, 0), last)
                step[k] = ti.select(inverse[k] > 0.0, 1, -1)
                border = ti.cast(cell[k] + ti.select(inverse[k] > 0.0, 1, 0), ti.f32)
                crossing[k] = (corner[k] + border * N[GRID_CELL + k] - o[k]) * inverse[k]
                change[k] = N[GRID_CELL + k] * abs(inverse[k])
            inside = 1
            while inside == 1:
                here = (cell[0] * ti.cast(N[GRID_SHAPE + 1], ti.i32) + cell[1]) * ti.cast(
                    N[GRID_SHAPE + 2], ti.i32
                ) + cell[2]
                for k in range(scene.grid_starts[here], scene.grid_starts[here + 1]):
                    i = scene.grid_solids[k]
                    t = solid_hit(scene.B, i, o, d, False)
                    if t < nearest:
                        nearest, found = t, i
                leaves = crossing.min()
                if nearest <= leaves or leaves >= end:
                    inside = 0
                else:
                    moved = 0
                    for k in ti.static(range(3)):
                        if moved == 0 and crossing[k] == leaves:
                            moved = 1
                            cell[k] += step[k]
                            crossing[k] += change[k]
                            if cell[k] < 0 or cell[k] >= ti.cast(N[GRID_SHAPE + k], ti.i32):
                                inside = 0
    return nearest, found


@ti.func
def far_side(B: ti.template(), i, o, d):
    """The distance at which a ray leaves solid i from inside: where the ray back from beyond it enters."""
    reach = ti.max((ti.Vector([B[i, 0], B[i, 1], B[i, 2]]) - o).dot(d), 0.0) + 1.5 * B[i, BOUND]
    back = solid_hit(B, i, o + d * reach, -d, False)
    return ti.select(back < NEVER, ti.max(reach - back, 0.0), 0.0)
