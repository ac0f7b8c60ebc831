"""The share of space that a liquid's spheres fill: with it, a sum over spheres becomes a length of liquid."""

import numpy as np

__all__ = ["packing"]

_CELL = 4.0  # side of a cell in radii
_LOOSE, _CELLS = 0.6, 8.0  # of a heap of spheres that touch, which counts as this many cells
_MOST = 2**24  # cells of the grid


def packing(positions: np.ndarray, radii: np.ndarray) -> float:
    """The mean share inside the liquid: over cells all of whose neighbours hold particles, too.

    positions : (n, 3); radii : (n,) m
    Spheres that overlap fill more than 1. Thin sheets and drops have no inside and count as a loose heap.
    """
    if not len(radii):
        return _LOOSE
    middle = float(np.median(radii))
    low, high = positions.min(axis=0).astype(np.float64), positions.max(axis=0).astype(np.float64)
    cell = max(_CELL * middle, float((high - low).max()) / 1e4)
    shape = np.floor((high - low) / cell).astype(np.int64) + 3  # with an empty cell at both ends
    while shape.prod() > _MOST:
        cell *= 1.26
        shape = np.floor((high - low) / cell).astype(np.int64) + 3
    x, y, z = (np.floor((positions[:, c] - low[c]) / cell).astype(np.int64) + 1 for c in range(3))
    volumes = (4.0 / 3.0 * np.pi) * radii.astype(np.float64) ** 3
    filled = np.bincount((x * shape[1] + y) * shape[2] + z, volumes, int(shape.prod())).reshape(shape)
    inside = filled > 0.0
    for axis in range(3):
        inside = inside & np.roll(inside, 1, axis) & np.roll(inside, -1, axis)
    # one after the other, so that the sum's bits do not depend on the processor
    total = float(np.cumsum(filled[inside])[-1]) / cell**3 if inside.any() else 0.0
    return (_CELLS * _LOOSE + total) / (_CELLS + int(inside.sum()))
