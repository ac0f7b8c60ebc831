"""The particles of a system, sorted into cells as wide as the reach within which neighbours are looked for."""

from dataclasses import dataclass

import numpy as np

from gen_art.maths.radix_sort import stable_order
from gen_art.particles.rows import LIFETIME, POSITION

__all__ = ["NeighbourCells"]

FARTHEST = 2**19  # cells from the origin: three numbers of 21 bits make one of 63


@dataclass(frozen=True)
class NeighbourCells:
    """Those particles that exist, in cubes whose side is the reach.

    slots : (n,) the particles, in the order of their cells, and in a cell in that of their keys, so that the first ones of
        a crowded cell stay the same from frame to frame
    positions : (n, 3) float32 m, in that order, from the corner of all
    first : (cells + 1,) int32, the first particle of each cell
    runs : (cells, 18) int32, the first cell, and the one after the last, of the nine rows of neighbouring cells
    """

    slots: np.ndarray
    positions: np.ndarray
    first: np.ndarray
    runs: np.ndarray

    @classmethod
    def of(cls, system, time: float, reach: float) -> "NeighbourCells | None":
        """The cells of a system at simulated time `time`; None if nothing exists."""
        n = int(system.count)
        positions = np.asarray(system.floats[POSITION, :n], np.float64)
        birth, life = system.birth[:n], np.asarray(system.floats[LIFETIME, :n], np.float64)
        with np.errstate(all="ignore"):
            near = (np.abs(positions) < FARTHEST * reach).all(axis=0)
        slots = np.flatnonzero(near & (birth <= time) & (birth + life > time))
        if not len(slots):
            return None
        slots = slots[stable_order(system.key[0, slots] ^ system.key[1, slots])]
        positions = np.take(positions, slots, axis=1)
        positions -= positions.min(axis=1, keepdims=True)
        cells = np.floor(positions / reach).astype(np.int64) + 1
        key = (cells[2] << 42) | (cells[1] << 21) | cells[0]
        order = stable_order(key.astype(np.uint64))
        keys, first = np.unique(key[order], return_index=True)
        runs = np.empty((len(keys), 18), np.int32)
        rows = [(z << 42) + (y << 21) for z in (-1, 0, 1) for y in (-1, 0, 1)]
        for r, row in enumerate(rows):
            runs[:, 2 * r] = np.searchsorted(keys, keys + row - 1)
            runs[:, 2 * r + 1] = np.searchsorted(keys, keys + row + 1, side="right")
        sorted_positions = np.take(positions.astype(np.float32), order, axis=1).T.copy()
        return cls(slots[order], sorted_positions, np.append(first, len(slots)).astype(np.int32), runs)
