"""The share of space that a liquid's spheres fill: with it, a sum over spheres becomes a length of liquid.

The particles are counted in the cells of several grids, each shifted against the others: in one alone, the layers of a lattice of
particles could fall into its cells unevenly.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti

__all__ = ["packing"]

_CELL = 4.0  # side of a cell in radii
_LOOSE, _CELLS = 0.6, 1.0  # of a heap of spheres that touch, which counts as this many cells
_MOST = 2**19  # cells of a grid
_GRIDS = 8

F1, F2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)


@ti.kernel
def _fill_cells(X: F2, radii: F1, corner: F1, per_cell: ti.f32, rows: ti.i32, columns: ti.i32, cells: F1):
    """Add each sphere's volume to its cell. One thread, in their order, so that the number of threads changes no bit."""
    ti.loop_config(serialize=True)
    for i in range(X.shape[0]):
        a = ti.cast((X[i, 0] - corner[0]) * per_cell, ti.i32)
        b = ti.cast((X[i, 1] - corner[1]) * per_cell, ti.i32)
        c = ti.cast((X[i, 2] - corner[2]) * per_cell, ti.i32)
        cell = (a * rows + b) * columns + c
        cells[cell] = cells[cell] + 4.1887902 * radii[i] * radii[i] * radii[i]


_fill_kernel = kernel(_fill_cells)


def packing(positions: np.ndarray, radii: np.ndarray) -> float:
    """The mean share inside the liquid: over cells all of whose neighbours hold particles, too.

    positions : (n, 3); radii : (n,) m
    Spheres that overlap fill more than 1. Thin sheets and drops have no inside and count as a loose heap.
    """
    if not len(radii):
        return _LOOSE
    positions, radii = np.ascontiguousarray(positions, np.float32), np.ascontiguousarray(radii, np.float32)
    low, high = positions.min(axis=0).astype(np.float64), positions.max(axis=0).astype(np.float64)
    cell = max(_CELL * float(np.median(radii)), float((high - low).max()) / 1e4, 1e-30)
    while True:
        shape = np.floor((high - low) / cell).astype(np.int64) + 4  # with an empty cell at both ends, at any shift
        if shape.prod() <= _MOST:
            break
        cell *= 1.26
    total, inside = 0.0, 0
    for k in range(_GRIDS):
        shift = np.array([k, 3 * k % _GRIDS, 5 * k % _GRIDS]) / _GRIDS
        corner = (low - (1.0 + shift) * cell).astype(np.float32)
        cells = np.zeros(int(shape.prod()), np.float32)
        _fill_kernel(positions, radii, corner, 1.0 / cell, int(shape[1]), int(shape[2]), cells)
        filled = cells.reshape(shape)
        inner = filled > 0.0
        for axis in range(3):
            inner = inner & np.roll(inner, 1, axis) & np.roll(inner, -1, axis)
        found = filled[inner].astype(np.float64)
        # one after the other, so that the sum's bits do not depend on the processor
        total += float(np.cumsum(found)[-1]) / cell**3 if len(found) else 0.0
        inside += len(found)
    return (_CELLS * _LOOSE + total / _GRIDS) / (_CELLS + inside / _GRIDS)
