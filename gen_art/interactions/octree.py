"""Octrees: particles in Morton order, and cells that are runs of them, level by level."""

from dataclasses import dataclass

import numpy as np

__all__ = ["LEAF", "Octree", "grow"]

LEAF = 48  # particles in a leaf: pairs are cheap beside expansions
_BITS = 20  # levels; beyond, particles share a leaf however many they are


@dataclass
class Octree:
    """order (n,): slots in Morton order.   Of each cell, (cells,) int32: its particles begin .. end - 1 in that order, and
    its children child .. child + children - 1 (0 children: a leaf).   levels: the first cell of each level, and the end."""

    order: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    child: np.ndarray
    children: np.ndarray
    levels: list[int]

    @property
    def leaves(self) -> np.ndarray:
        return np.flatnonzero(self.children == 0).astype(np.int32)


def grow(positions: np.ndarray) -> Octree:
    """The octree of (3, n) positions: cells of more than LEAF particles are divided in eight, empty ones left out."""
    keys = _morton(positions)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    begin, end = np.zeros(1, np.int64), np.full(1, len(order))
    parts, levels, cells = [], [0], 0
    for level in range(_BITS + 1):
        split = end - begin > LEAF if level < _BITS else np.zeros(len(begin), bool)
        shift = np.uint64(3 * max(_BITS - 1 - level, 0))
        prefix = (keys[begin[split]] >> shift) >> np.uint64(3)
        bounds = np.searchsorted(keys, ((prefix[:, None] << np.uint64(3)) + np.arange(9, dtype=np.uint64)) << shift)
        low, high = bounds[:, :-1], bounds[:, 1:]
        full = high > low
        children = np.zeros(len(begin), np.int64)
        children[split] = full.sum(1)
        below = cells + len(begin)
        child = below + np.cumsum(children) - children
        parts.append((begin, end, child, children))
        cells = below
        levels.append(cells)
        if not split.any():
            break
        begin, end = low[full], high[full]
    begin, end, child, children = (np.concatenate(column).astype(np.int32) for column in zip(*parts))
    return Octree(order, begin, end, child, children, levels)


def _morton(positions: np.ndarray) -> np.ndarray:
    """(n,) uint64: the bits of the three coordinates in turn, on a cube about all positions."""
    x = positions.astype(np.float64)
    low = x.min(1)
    size = max(float((x.max(1) - low).max()), 1e-300)
    key = np.zeros(x.shape[1], np.uint64)
    for axis in range(3):
        place = np.minimum((x[axis] - low[axis]) * (2.0**_BITS / size), 2**_BITS - 1).astype(np.uint64)
        key |= _spread(place) << np.uint64(axis)
    return key


def _spread(v: np.ndarray) -> np.ndarray:
    """The bits of v, two zeros after each."""
    for shift, mask in (
        (32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249),
    ):  # fmt: skip
        v = (v | (v << np.uint64(shift))) & np.uint64(mask)
    return v
