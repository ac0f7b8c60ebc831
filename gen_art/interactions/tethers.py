"""Tethers: a particle comes no further from its nearest fixed particle than the way to it along the springs, and a little more.

abs(x_i - x_a) <= (1 + tether) s_i, with s_i the sum of the rest lengths along the shortest way. Springs that do not stretch imply
it; the sweeps of a long net take many steps to find that out. A particle beyond it loses, of its velocity, what
would leave it there: an inelastic pull that the fixed particle answers for.
Source: Kim, Chentanez & Mueller-Fischer, Long Range Attachments (2012).
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.adjacency import Adjacency
from gen_art.particles.rows import PX, PY, PZ, VX, VY, VZ

__all__ = ["BLOCK", "hold", "ways"]

BLOCK = 1024
_GROUPS = 8


def ways(springs: Adjacency, fixed: np.ndarray, dtype) -> list[tuple[np.ndarray, np.ndarray]]:
    """Of each group of fixed particles that springs join: each particle's nearest member ((n,) slots, itself where none is
    joined to it) and the way to it along the springs, m. Of _GROUPS groups at most, in the order of their first members."""
    found = []
    group = _groups(springs.pairs, fixed)
    for label in np.unique(group[fixed])[:_GROUPS]:
        here = fixed & (group == label)
        anchor, way = np.arange(len(fixed), dtype=np.int32), np.where(here, 0.0, np.inf)
        _kernels("f64")[1](springs.first, springs.other, springs.of[1].astype(np.float64), anchor, way)
        anchor[fixed] = np.flatnonzero(fixed)  # fixed particles stay
        found.append((anchor, np.where(np.isfinite(way), way, 0.0).astype(dtype)))
    return found


def _groups(pairs: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """The lowest slot of the fixed particles that springs join to each fixed one: (n,)."""
    label = np.arange(len(fixed))
    i, j = pairs[fixed[pairs].all(1)].T
    while (label[i] != label[j]).any():
        low = np.minimum(label[i], label[j])
        np.minimum.at(label, label[i], low)
        np.minimum.at(label, label[j], low)
        label = label[label]
    return label


def hold(floats: np.ndarray, n: int, tethers: list, most: float, h: float, precision: str) -> None:
    """Change the velocities of the first n particles so that after h none is further than (1 + most) way from its anchor."""
    for anchor, way in tethers:
        _kernels(precision)[0](floats, n, anchor, way, 1.0 + most, h)


@cache
def _kernels(precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector, whole = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1), ti.types.ndarray(ti.i32, 1)
    double = ti.types.ndarray(ti.f64, 1)

    @ti.kernel
    def pull(S: matrix, n: ti.i32, anchor: whole, way: vector, most: real, h: real):
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                a = anchor[i]
                d = ti.Vector([S[PX, i] - S[PX, a], S[PY, i] - S[PY, a], S[PZ, i] - S[PZ, a]])
                d += h * ti.Vector([S[VX, i], S[VY, i], S[VZ, i]])
                reach = most * way[i]
                length = d.norm()
                if length > reach and a != i:
                    d *= (length - reach) / (h * length)
                    S[VX, i], S[VY, i], S[VZ, i] = S[VX, i] - d[0], S[VY, i] - d[1], S[VZ, i] - d[2]

    @ti.kernel
    def shortest(first: whole, other: whole, rest: double, anchor: whole, way: double):
        """Bellman and Ford's relaxation, up and down the particles until nothing changes: a few rounds for a net."""
        n = anchor.shape[0]
        ti.loop_config(serialize=True)
        for _ in range(1):
            changed = 1
            while changed > 0:
                changed = 0
                for k in range(2 * n):
                    i = ti.select(k < n, k, 2 * n - 1 - k)
                    for e in range(first[i], first[i + 1]):
                        if way[other[e]] + rest[e] < way[i]:
                            way[i], anchor[i] = way[other[e]] + rest[e], anchor[other[e]]
                            changed = 1

    return runtime.kernel(pull, precision), runtime.kernel(shortest, "f64")
