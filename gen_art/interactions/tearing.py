"""Which springs are stretched too far.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.adjacency import Adjacency
from gen_art.interactions.spring_kernels import DAMPING, REST, STIFFNESS
from gen_art.particles.rows import PX, PY, PZ

__all__ = ["stretched"]

_BLOCK = 4096


def stretched(floats: np.ndarray, springs: Adjacency, most: float, precision: str) -> np.ndarray:
    """Indices of the unbroken springs that are longer than (1 + most) times their rest length."""
    if not len(springs.pairs):
        return np.zeros(0, np.int64)
    too_long = np.zeros(len(springs.pairs), np.int32)
    _kernel(precision)(floats, springs.pairs, springs.numbers, too_long, 1.0 + most)
    return np.flatnonzero(too_long)


@cache
def _kernel(precision: str):
    real = runtime.DTYPES[precision]

    @ti.kernel
    def find(
        S: ti.types.ndarray(real, 2), pairs: ti.types.ndarray(ti.i64, 2), N: ti.types.ndarray(ti.f64, 2),
        too_long: ti.types.ndarray(ti.i32, 1), most: ti.f64,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range((too_long.shape[0] + _BLOCK - 1) // _BLOCK):
            for e in range(b * _BLOCK, ti.min((b + 1) * _BLOCK, too_long.shape[0])):
                i, j = ti.cast(pairs[e, 0], ti.i32), ti.cast(pairs[e, 1], ti.i32)
                d = ti.Vector([S[PX, i] - S[PX, j], S[PY, i] - S[PY, j], S[PZ, i] - S[PZ, j]])
                unbroken = N[e, STIFFNESS] > 0.0 or N[e, DAMPING] > 0.0
                too_long[e] = ti.select(unbroken and ti.cast(d.norm(), ti.f64) > most * N[e, REST], 1, 0)

    return runtime.kernel(find, precision)
