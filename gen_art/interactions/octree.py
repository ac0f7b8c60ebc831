"""Octrees: particles in Morton order, and cells that are ranges of them, level by level.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.maths.array_functions import median
from gen_art.maths.radix_sort import stable_order

__all__ = ["LEAF", "Octree", "build_octree"]

LEAF = 48  # most particles in a leaf: pairs cost less than expansions
_COARSE = 3  # levels above the typical one
_TASK = 1 << 14  # particles
_SPREADING = (
    (32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249),
)  # fmt: skip
_LEVELS = 20  # a cell of the last level is a leaf, however many particles it has


@dataclass
class Octree:
    """An octree.

    order : (n,) int32, slots in Morton order
    begin, end : (cells,) int32, the particles of each cell are begin to end - 1 in that order
    links : (cells, 2) int32, the first child of each cell and how many children follow each other from there; a leaf has 0
    levels : the first cell of each level, and the number of cells
    """

    order: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    links: np.ndarray
    levels: list[int]


def build_octree(positions: np.ndarray) -> Octree:
    """The octree of positions (3, n). Cells of more than LEAF particles are divided into eight; empty ones are left out.

    Cells that are much larger than where most particles are, are divided down to single particles: a large leaf with few of
    them would act particle by particle on everything around it.
    """
    keys = _morton(positions)
    order = stable_order(keys)
    keys = keys[order]
    coarse = _typical_level(keys) - _COARSE
    begin: np.ndarray = np.zeros(1, np.int64)
    end: np.ndarray = np.full(1, len(order))
    parts, levels, cells = [], [0], 0
    for level in range(_LEVELS + 1):
        split = end - begin > (1 if level <= coarse else LEAF) if level < _LEVELS else np.zeros(len(begin), bool)
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
    return Octree(order, begins, ends, np.stack([firsts, counts], axis=1), levels)


def _typical_level(keys: np.ndarray) -> int:
    """The level whose cells hold about LEAF particles where most particles are; keys in order."""
    together = keys[:-LEAF] ^ keys[LEAF:]  # 0 in the bits of the levels down to which LEAF particles share a cell
    if not len(together):
        return 0
    _, bits = np.frexp(together[:: max(1, len(together) // 4096)].astype(np.float64))
    return int(_LEVELS - median((bits + 2) // 3))


def _morton(positions: np.ndarray) -> np.ndarray:
    """Morton keys (n,) uint64: the interleaved bits of the coordinates within a cube around all positions."""
    low = positions.min(1).astype(np.float64)
    size = max(float((positions.max(1) - low).max()), 1e-300)
    keys = np.empty(positions.shape[1], np.uint64)
    _keys_kernel(positions.dtype == np.float64)(positions, np.array([*low, 2.0**_LEVELS / size]), keys)
    return keys


@cache
def _keys_kernel(double: bool):
    precision = "f64" if double else "f32"

    @ti.func
    def spread(v):
        """The bits of v with two zeros after each."""
        for shift, mask in ti.static(_SPREADING):
            v = (v | (v << ti.u64(shift))) & ti.u64(mask)
        return v

    @ti.kernel
    def make_keys(
        X: ti.types.ndarray(runtime.DTYPES[precision], 2),
        q: ti.types.ndarray(ti.f64, 1),
        keys: ti.types.ndarray(ti.u64, 1),
    ):
        n = keys.shape[0]
        ti.loop_config(block_dim=1)
        for task in range((n + _TASK - 1) // _TASK):
            for i in range(task * _TASK, ti.min((task + 1) * _TASK, n)):
                key = ti.u64(0)
                for axis in ti.static(range(3)):
                    place = ti.min((ti.cast(X[axis, i], ti.f64) - q[axis]) * q[3], 2.0**_LEVELS - 1)
                    key |= spread(ti.cast(place, ti.u64)) << ti.u64(axis)
                keys[i] = key

    return runtime.kernel(make_keys, precision)
