"""Finds the particles that live, and moves them to the front of every column, in their order."""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.particles.rows import LIFETIME

__all__ = ["compact", "slots_of_living"]

_CHUNK = 4096  # slots of which one thread finds the living


@cache
def _moving(precision: str):
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


@cache
def _living(precision: str):
    real = runtime.DTYPES[precision]
    matrix, times, integers = ti.types.ndarray(real, 2), ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.i32, 1)

    @ti.func
    def lives(floats: ti.template(), birth: ti.template(), k, time):
        return ti.select(birth[k] + ti.cast(floats[LIFETIME, k], ti.f64) > time, 1, 0)

    @ti.kernel
    def count(floats: matrix, birth: times, n: ti.i32, time: ti.f64, counts: integers):
        ti.loop_config(block_dim=1)
        for c in range(counts.shape[0]):
            living = 0
            for k in range(c * _CHUNK, ti.min((c + 1) * _CHUNK, n)):
                living += lives(floats, birth, k, time)
            counts[c] = living

    @ti.kernel
    def write(floats: matrix, birth: times, n: ti.i32, time: ti.f64, starts: integers, slots: integers):
        ti.loop_config(block_dim=1)
        for c in range(starts.shape[0]):
            place = starts[c]
            for k in range(c * _CHUNK, ti.min((c + 1) * _CHUNK, n)):
                if lives(floats, birth, k, time) == 1:
                    slots[place] = k
                    place += 1

    return runtime.kernel(count, precision), runtime.kernel(write, precision)


def slots_of_living(
    floats: np.ndarray, birth: np.ndarray, count: int, time: float, most: int
) -> tuple[int, np.ndarray | None]:
    """How many of the first `count` particles live after `time`, and their slots (int32, ascending) unless they are more than
    `most`."""
    counting, writing = _living(_precision(floats))
    counts = np.zeros(-(-count // _CHUNK), np.int32)
    counting(floats, birth, count, time, counts)
    ends = np.cumsum(counts)
    living = int(ends[-1])
    if living > most:
        return living, None
    slots = np.empty(living, np.int32)
    if living:
        writing(floats, birth, count, time, (ends - counts).astype(np.int32), slots)
    return living, slots


def _precision(floats: np.ndarray) -> str:
    return "f64" if floats.dtype == np.float64 else "f32"


def compact(keep: np.ndarray, floats, birth, key, id, source, booked) -> None:
    """Move the particles in the slots `keep` (int32, ascending) to slots 0, 1, 2 ... of all columns of a Particles."""
    first = int(np.searchsorted(keep - np.arange(len(keep), dtype=np.int32), 1))  # those before it stay where they are
    nothing = np.zeros((1, 1)) if not len(booked) else booked
    _moving(_precision(floats))(
        floats, birth[None], key, id[None], source[None], nothing, len(floats), len(booked), keep, first,
    )  # fmt: skip
