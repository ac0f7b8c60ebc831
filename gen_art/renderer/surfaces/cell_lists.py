"""Lists of the things that touch each cell of a grid."""

import numpy as np

__all__ = ["cell_lists"]


def cell_lists(first: np.ndarray, last: np.ndarray, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(starts, things): cell c = row * shape[1] + column holds things[starts[c] : starts[c + 1]], in their order.

    first, last : (n, 2) integers, row and column of the first and the last cell that each thing touches; none if last < first
    shape : rows and columns of the grid
    """
    spans = np.maximum(last - first + 1, 0)
    counts = spans[:, 0] * spans[:, 1]
    thing = np.repeat(np.arange(len(counts)), counts)
    nth = np.arange(len(thing)) - np.repeat(np.cumsum(counts) - counts, counts)
    row, column = nth // spans[thing, 1], nth % spans[thing, 1]
    cell = (first[thing, 0] + row) * shape[1] + first[thing, 1] + column
    order = np.argsort(cell, kind="stable")
    starts = np.searchsorted(cell[order], np.arange(shape[0] * shape[1] + 1)).astype(np.int32)
    return starts, thing[order].astype(np.int32)
