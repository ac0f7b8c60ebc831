"""Lists of the things that touch each cell of a grid."""

import numpy as np

__all__ = ["cell_lists"]


def cell_lists(first: np.ndarray, last: np.ndarray, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """(starts, things): cell c, counted along the last axis first, holds things[starts[c] : starts[c + 1]], in their order.

    first, last : (n, axes) integers, the first and the last cell that each thing touches along each axis; none if last < first
    shape : cells along each axis
    """
    spans = np.maximum(last - first + 1, 0)
    counts = spans.prod(axis=1)
    thing = np.repeat(np.arange(len(counts)), counts)
    rest = np.arange(len(thing)) - np.repeat(np.cumsum(counts) - counts, counts)
    cell, stride = np.zeros(len(thing), np.int64), 1
    for axis in reversed(range(len(shape))):
        span = spans[thing, axis]
        cell += (first[thing, axis] + rest % span) * stride
        rest, stride = rest // span, stride * shape[axis]
    order = np.argsort(cell, kind="stable")
    starts = np.searchsorted(cell[order], np.arange(stride + 1)).astype(np.int32)
    return starts, thing[order].astype(np.int32)
