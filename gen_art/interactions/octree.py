"""Octrees: particles in Morton order, and cells that are ranges of them, level by level."""

from dataclasses import dataclass

import numpy as np

__all__ = ["LEAF", "Octree", "build_octree"]

LEAF = 48  # most particles in a leaf: pairs cost less than expansions
_LEVELS = 20  # a cell of the last level is a leaf, however many particles it has


@dataclass
class Octree:
    """An octree.

    order : (n,), slots in Morton order
    begin, end : (cells,) int32, the particles of each cell are begin to end - 1 in that order
    child, children : (cells,) int32, the children of each cell are child to child + children - 1; a leaf has 0
    levels : the first cell of each level, and the number of cells
    """

    order: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    child: np.ndarray
    children: np.ndarray
    levels: list[int]

    @property
    def leaves(self) -> np.ndarray:
        return np.flatnonzero(self.children == 0).astype(np.int32)


def build_octree(positions: np.ndarray) -> Octree:
    """The octree of positions (3, n). Cells of more than LEAF particles are divided into eight; empty ones are left out."""
    keys = _morton(positions)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    begin: np.ndarray = np.zeros(1, np.int64)
    end: np.ndarray = np.full(1, len(order))
    parts, levels, cells = [], [0], 0
    for level in range(_LEVELS + 1):
        split = end - begin > LEAF if level < _LEVELS else np.zeros(len(begin), bool)
        shift = np.uint64(3 * max(_LEVELS - 1 - level, 0))
        prefix = (keys[begin[split]] >> shift) >> np.uint64(3)
        bounds = np.searchsorted(keys, ((prefix[:, None] << np.uint64(3)) + np.arange(9, dtype=np.uint64)) << shift)
        low, high = bounds[:, :-1], bounds[:, 1:]
        occupied = high > low
        children = np.zeros(len(begin), np.int64)
        children[split] = occupied.sum(1)
        next_level = cells + len(begin)
        child = next_level + np.cumsum(children) - children
        parts.append((begin, end, child, children))
        cells = next_level
        levels.append(cells)
        if not split.any():
            break
        begin, end = low[occupied], high[occupied]
    begins, ends, firsts, counts = (np.concatenate(column).astype(np.int32) for column in zip(*parts))
    return Octree(order, begins, ends, firsts, counts, levels)


def _morton(positions: np.ndarray) -> np.ndarray:
    """Morton keys (n,) uint64: the interleaved bits of the coordinates within a cube around all positions."""
    x = positions.astype(np.float64)
    low = x.min(1)
    size = max(float((x.max(1) - low).max()), 1e-300)
    key = np.zeros(x.shape[1], np.uint64)
    for axis in range(3):
        place = np.minimum((x[axis] - low[axis]) * (2.0**_LEVELS / size), 2**_LEVELS - 1).astype(np.uint64)
        key |= _spread(place) << np.uint64(axis)
    return key


def _spread(v: np.ndarray) -> np.ndarray:
    """The bits of v with two zeros after each."""
    for shift, mask in (
        (32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249),
    ):  # fmt: skip
        v = (v | (v << np.uint64(shift))) & np.uint64(mask)
    return v
