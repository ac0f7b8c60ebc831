"""The order in which whole numbers ascend: a radix sort on all threads.

Equal keys keep their order, so there is one result, whatever the number of threads and whichever way is taken.
"""

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti

__all__ = ["stable_order"]

_BITS = 10  # of a digit
_DIGITS = 1 << _BITS
_RUN = 1 << 14  # keys of a task
_FEW = 1 << 15  # keys that NumPy sorts sooner

KEYS, ORDER, TABLE = ti.types.ndarray(ti.u64, 1), ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i32, 2)


def stable_order(keys: np.ndarray) -> np.ndarray:
    """(n,) int32: the places of the keys, (n,) unsigned, from the least to the greatest; equal ones in the order they had."""
    n = len(keys)
    if n <= _FEW:
        return np.argsort(keys, kind="stable").astype(np.int32)
    keys, other_keys = keys.astype(np.uint64), np.empty(n, np.uint64)  # a copy, which is written to
    order, other_order = np.arange(n, dtype=np.int32), np.empty(n, np.int32)
    counts = np.empty((-(-n // _RUN), _DIGITS), np.int32)
    for shift in range(0, int(keys.max()).bit_length(), _BITS):
        _count(keys, shift, counts)
        if counts.sum(axis=0).max() == n:
            continue  # all keys have the same digit
        ends = np.cumsum(counts.T.reshape(-1)).reshape(_DIGITS, -1).T
        firsts = np.ascontiguousarray(ends - counts, dtype=np.int32)
        _place(keys, order, shift, firsts, other_keys, other_order)
        keys, other_keys, order, other_order = other_keys, keys, other_order, order
    return order


@ti.func
def _digit(key, shift):
    return ti.cast((key >> ti.cast(shift, ti.u64)) & ti.u64(_DIGITS - 1), ti.i32)


def _counts(keys: KEYS, shift: ti.i32, counts: TABLE):
    ti.loop_config(block_dim=1)
    for task in range(counts.shape[0]):
        for digit in range(_DIGITS):
            counts[task, digit] = 0
        for i in range(task * _RUN, ti.min((task + 1) * _RUN, keys.shape[0])):
            digit = _digit(keys[i], shift)
            counts[task, digit] = counts[task, digit] + 1


def _placing(keys: KEYS, order: ORDER, shift: ti.i32, firsts: TABLE, new_keys: KEYS, new_order: ORDER):
    ti.loop_config(block_dim=1)
    for task in range(firsts.shape[0]):
        for i in range(task * _RUN, ti.min((task + 1) * _RUN, keys.shape[0])):
            digit = _digit(keys[i], shift)
            at = firsts[task, digit]
            firsts[task, digit] = at + 1
            new_keys[at], new_order[at] = keys[i], order[i]


_count, _place = runtime.kernel(ti.kernel(_counts)), runtime.kernel(ti.kernel(_placing))
