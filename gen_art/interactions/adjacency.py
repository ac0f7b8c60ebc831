"""The springs of each particle in a fixed order, so that each particle can sum the forces of its own springs."""

import numpy as np

__all__ = ["Adjacency"]


class Adjacency:
    """Each spring as two half-edges, sorted by particle: those of slot i are first[i] to first[i + 1] - 1.

    pairs : (m, 2), the slots that each spring joins
    numbers : (m, c), the numbers of each spring
    other : (2m,), the slot at the far end of each half-edge
    half_numbers : (c, 2m), the numbers of each half-edge's spring
    halves : (m, 2), the two half-edges of each spring
    """

    def __init__(self, pairs: np.ndarray, numbers: np.ndarray, count: int, dtype):
        self.pairs, self.numbers = pairs, numbers
        here = np.concatenate([pairs[:, 0], pairs[:, 1]])
        there = np.concatenate([pairs[:, 1], pairs[:, 0]])
        order = np.argsort(here, kind="stable")
        half = np.empty(len(order), np.int64)
        half[order] = np.arange(len(order))
        self.halves = half.reshape(2, -1).T
        self.first = np.zeros(count + 1, np.int32)
        np.cumsum(np.bincount(here, minlength=count), out=self.first[1:])
        self.other = np.ascontiguousarray(there[order].astype(np.int32))
        self.half_numbers = np.ascontiguousarray(np.concatenate([numbers, numbers])[order].T.astype(dtype))
        if not len(self.other):  # kernels take no empty arrays
            self.other, self.half_numbers = np.zeros(1, np.int32), np.zeros((numbers.shape[1], 1), dtype)
