"""Springs by particle: for each particle its springs one after the other, in a fixed order, so that it sums its own."""

import numpy as np

__all__ = ["Adjacency"]


class Adjacency:
    """Half-edges in rows: those of slot i are first[i] to first[i + 1] - 1.

    pairs : (m, 2) slots     numbers : (m, c) what each spring has; `of` (c, 2m) repeats it for both of its ends
    """

    def __init__(self, pairs: np.ndarray, numbers: np.ndarray, count: int, dtype):
        self.pairs, self.numbers = pairs, numbers
        here = np.concatenate([pairs[:, 0], pairs[:, 1]])
        there = np.concatenate([pairs[:, 1], pairs[:, 0]])
        order = np.argsort(here, kind="stable")
        half = np.empty(len(order), np.int64)
        half[order] = np.arange(len(order))
        self.halves = half.reshape(2, -1).T  # (m, 2): where the two half-edges of each spring stand
        self.first = np.zeros(count + 1, np.int32)
        np.cumsum(np.bincount(here, minlength=count), out=self.first[1:])
        self.other = np.ascontiguousarray(there[order].astype(np.int32))
        self.of = np.ascontiguousarray(np.concatenate([numbers, numbers])[order].T.astype(dtype))
        if not len(self.other):  # kernels take no empty arrays
            self.other, self.of = np.zeros(1, np.int32), np.zeros((numbers.shape[1], 1), dtype)
