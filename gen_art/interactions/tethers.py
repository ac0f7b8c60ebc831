"""Tethers: a particle cannot be farther from its nearest fixed particle than the path to it along the springs, plus a strain.

abs(x_i - x_a) <= (1 + tether) s_i, with s_i the sum of the rest lengths along the shortest path. Springs that do not stretch
imply this, but the sweeps of a large net need many steps to longest it. A particle that would be beyond the limit after the step
loses the part of its velocity that takes it there: an inelastic pull, whose reaction acts on the fixed particle.
Source: Kim, Chentanez & Mueller-Fischer, Long Range Attachments (2012).

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.adjacency import Adjacency
from gen_art.interactions.spring_kernels import REST
from gen_art.particles.rows import PX, PY, PZ, VX, VY, VZ

__all__ = ["BLOCK", "apply_tethers", "find_tethers"]

BLOCK = 1024
_MAX_GROUPS = 8


def find_tethers(springs: Adjacency, fixed: np.ndarray, dtype) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each group of fixed particles that springs join: (anchor, path), of at most _MAX_GROUPS groups.

    anchor : (n,), the slot of the nearest fixed particle of the group; a particle's own slot where no path leads to one
    path : (n,) m, the length of the shortest path to it along the springs
    Groups are in the order of their first members.
    """
    found = []
    group = _groups(springs.pairs, fixed)
    for label in np.unique(group[fixed])[:_MAX_GROUPS]:
        members = fixed & (group == label)
        anchor, path = np.arange(len(fixed), dtype=np.int32), np.where(members, 0.0, np.inf)
        rest = springs.half_numbers[REST].astype(np.float64)
        _, shortest = _kernels("f64")
        shortest(springs.first, springs.other, rest, anchor, path)
        anchor[fixed] = np.flatnonzero(fixed)  # a fixed particle is not tethered to another
        found.append((anchor, np.where(np.isfinite(path), path, 0.0).astype(dtype)))
    return found


def _groups(pairs: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """For each fixed particle, (n,), the lowest slot of the fixed particles that springs join to it."""
    label = np.arange(len(fixed))
    i, j = pairs[fixed[pairs].all(1)].T
    while (label[i] != label[j]).any():
        low = np.minimum(label[i], label[j])
        np.minimum.at(label, label[i], low)
        np.minimum.at(label, label[j], low)
        label = label[label]
    return label


def apply_tethers(floats: np.ndarray, n: int, tethers: list, most: float, h: float, precision: str) -> None:
    """Change the velocities of the first n particles so that after h, s, none is beyond (1 + most) path from its anchor."""
    limit, _ = _kernels(precision)
    for anchor, path in tethers:
        limit(floats, n, anchor, path, 1.0 + most, h)


@cache
def _kernels(precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector, ints = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1), ti.types.ndarray(ti.i32, 1)
    double = ti.types.ndarray(ti.f64, 1)

    @ti.kernel
    def limit(S: matrix, n: ti.i32, anchor: ints, path: vector, most: real, h: real):
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                a = anchor[i]
                d = ti.Vector([S[PX, i] - S[PX, a], S[PY, i] - S[PY, a], S[PZ, i] - S[PZ, a]])
                d += h * ti.Vector([S[VX, i], S[VY, i], S[VZ, i]])
                longest = most * path[i]
                length = d.norm()
                if length > longest and a != i:
                    d *= (length - longest) / (h * length)
                    S[VX, i], S[VY, i], S[VZ, i] = S[VX, i] - d[0], S[VY, i] - d[1], S[VZ, i] - d[2]

    @ti.kernel
    def shortest(first: ints, other: ints, rest: double, anchor: ints, path: double):
        """Bellman-Ford relaxation, forwards and backwards over the particles until nothing changes: a few rounds for a net."""
        n = anchor.shape[0]
        ti.loop_config(serialize=True)
        for _ in range(1):
            changed = 1
            while changed > 0:
                changed = 0
                for k in range(2 * n):
                    i = ti.select(k < n, k, 2 * n - 1 - k)
                    for e in range(first[i], first[i + 1]):
                        if path[other[e]] + rest[e] < path[i]:
                            path[i], anchor[i] = path[other[e]] + rest[e], anchor[other[e]]
                            changed = 1

    return runtime.kernel(limit, precision), runtime.kernel(shortest, "f64")
