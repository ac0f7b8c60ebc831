"""Moves the particles that are kept to the front of every column, in their order."""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti

__all__ = ["compact"]


@cache
def _kernel(precision: str):
    real = runtime.DTYPES[precision]

    @ti.func
    def gather(column: ti.template(), r, keep: ti.template(), first):
        """In place: a particle moves to an earlier slot, whose own particle has moved already."""
        for k in range(first, keep.shape[0]):
            column[r, k] = column[r, keep[k]]

    @ti.kernel
    def move(
        floats: ti.types.ndarray(real, 2), birth: ti.types.ndarray(ti.f64, 2), key: ti.types.ndarray(ti.u32, 2),
        id: ti.types.ndarray(ti.i64, 2), source: ti.types.ndarray(ti.i32, 2), booked: ti.types.ndarray(ti.f64, 2),
        rows: ti.i32, entries: ti.i32, keep: ti.types.ndarray(ti.i32, 1), first: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for c in range(rows + entries + 5):  # a column each
            if c < rows:
                gather(floats, c, keep, first)
            elif c < rows + entries:
                gather(booked, c - rows, keep, first)
            elif c < rows + entries + 2:
                gather(key, c - rows - entries, keep, first)
            elif c == rows + entries + 2:
                gather(birth, 0, keep, first)
            elif c == rows + entries + 3:
                gather(id, 0, keep, first)
            else:
                gather(source, 0, keep, first)

    return runtime.kernel(move, precision)


def compact(keep: np.ndarray, floats, birth, key, id, source, booked) -> None:
    """Move the particles in the slots `keep` (int32, ascending) to slots 0, 1, 2 ... of all columns of a Particles."""
    precision = "f64" if floats.dtype == np.float64 else "f32"
    first = int(np.searchsorted(keep - np.arange(len(keep), dtype=np.int32), 1))  # those before it stay where they are
    nothing = np.zeros((1, 1)) if not len(booked) else booked
    _kernel(precision)(
        floats, birth[None], key, id[None], source[None], nothing, len(floats), len(booked), keep, first,
    )  # fmt: skip
