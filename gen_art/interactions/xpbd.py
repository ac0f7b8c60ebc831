"""The XPBD step of springs: sweeps over their strands, each solved exactly along its whole length.

With the velocities after the kick, the particles would move to x + h v. There each spring of a strand has the direction n, the
length l and the speed u = n.(v_b - v_a) along it. Its impulse is J = h k (l + h du - L) + h c (u + du), where du is the change
of u by the impulses of the strand. With K = h^2 k + h c and w the inverse masses this is
(w_a + w_b + 1/K) J_e - w_a n_e.n_(e-1) J_(e-1) - w_b n_e.n_(e+1) J_(e+1) = h (k (l - L) + c u) / K,
less J / K of the sweeps before. For a strand of one spring it is the projection of XPBD with compliance 1/k. For a longer
strand the matrix is tridiagonal and is eliminated without a subtraction: the pivot is w_b + s_e, where
s_e = 1/K + w_a (s_(e-1) + w_a sin^2) / (w_a + s_(e-1)) is a sum of positive terms at any stiffness. One step is one substep.
Sources: Macklin, Mueller, Chentanez, XPBD (2016); Macklin et al., Small Steps in Physics Simulation (2019); for the solution
of whole strands Deul et al., Direct Position-Based Solver for Stiff Rods (2018).

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.strands import LANES, SCRATCH, Strands
from gen_art.particles.fixed import is_fixed
from gen_art.particles.rows import LIFETIME, MASS, PX, PY, PZ, VX, VY, VZ

__all__ = ["sweep"]

_BLOCK = 1024


def sweep(floats: np.ndarray, n: int, strands: Strands, h: float, precision: str, sweeps: int = 1) -> None:
    """Change the velocities of the first n particles by the impulses of the springs over a step h, s.

    sweeps : iterations of Newton's method; a spring's impulses add up, so that its stiffness does not depend on their number
    """
    load, project, store = _kernels(precision)
    load(floats, n, strands.particles)
    for k in range(sweeps):
        for begin, end in strands.colours:
            project(
                strands.particles, strands.index, strands.numbers, strands.scratch, strands.total, begin, end, *strands.parts,
                strands.scratch_rows, h, min(k, 1), sweeps - 1 - k,
            )  # fmt: skip
    store(floats, n, strands.particles)


@cache
def _kernels(precision: str):
    real = runtime.DTYPES[precision]
    rows = ti.types.ndarray(real, 2)
    ints = ti.types.ndarray(ti.i32, 1)
    lanes = ti.types.ndarray(ti.types.vector(LANES, real), 1)
    fours = ti.types.ndarray(ti.types.vector(4, real), 1)

    @ti.kernel
    def load(S: rows, n: ti.i32, P: fours):
        """Write P: for each particle position and inverse mass (0 if fixed), then velocity, next to each other in memory."""
        ti.loop_config(block_dim=1)
        for b in range((n + _BLOCK - 1) // _BLOCK):
            for i in range(b * _BLOCK, ti.min((b + 1) * _BLOCK, n)):
                inverse_mass = 0.0
                if S[MASS, i] > 0.0 and not is_fixed(S[LIFETIME, i]):
                    inverse_mass = 1.0 / S[MASS, i]
                P[2 * i] = ti.Vector([S[PX, i], S[PY, i], S[PZ, i], inverse_mass])
                P[2 * i + 1] = ti.Vector([S[VX, i], S[VY, i], S[VZ, i], 0.0])

    @ti.kernel
    def store(S: rows, n: ti.i32, P: fours):
        ti.loop_config(block_dim=1)
        for b in range((n + _BLOCK - 1) // _BLOCK):
            for i in range(b * _BLOCK, ti.min((b + 1) * _BLOCK, n)):
                v = P[2 * i + 1]
                S[VX, i], S[VY, i], S[VZ, i] = v[0], v[1], v[2]

    @ti.kernel
    def project(
        P: fours, index: ints, N: lanes, T: lanes, G: lanes, begin: ti.i32, end: ti.i32, rows_at: ti.i32, nodes_at: ti.i32,
        scratch_rows: ti.i32, h: real, keep: real, more: ti.i32,
    ):  # fmt: skip
        """Solve the strands of the tasks begin to end - 1 and apply their impulses.

        P: the particles, as `load` writes them
        index: first group of each task, first row of each group from `rows_at` on, particle of each slot from `nodes_at` on
        N: stiffness, rest length and damping of the springs
        T: scratch, scratch_rows rows per task
        G: impulses of the sweeps so far
        keep: 0 in the first sweep of a step, else 1
        more: number of sweeps that follow
        """
        ti.loop_config(block_dim=1)
        for t in range(begin, end):
            for g in range(index[t], index[t + 1]):
                row = index[rows_at + g]
                count = index[rows_at + g + 1] - row
                first, scratch = nodes_at + row * LANES, (t - begin) * scratch_rows
                zero = ti.Vector([0.0] * LANES)
                X, Y, Z, M, U, V, W = zero, zero, zero, zero, zero, zero, zero  # the node before
                for j in ti.static(range(LANES)):
                    p, q = P[2 * index[first + j]], P[2 * index[first + j] + 1]
                    X[j], Y[j], Z[j], M[j], U[j], V[j], W[j] = p[0], p[1], p[2], p[3], q[0], q[1], q[2]
                A, B, C, J, f = zero, zero, zero, zero, zero  # direction and impulse of the spring before
                s = zero + 1e24
                for e in range(1, count):
                    x, y, z, m, u, v, w = zero, zero, zero, zero, zero, zero, zero  # the next node
                    for j in ti.static(range(LANES)):
                        i = 2 * index[first + e * LANES + j]
                        p, q = P[i], P[i + 1]
                        x[j], y[j], z[j], m[j], u[j], v[j], w[j] = p[0], p[1], p[2], p[3], q[0], q[1], q[2]
                    total = zero
                    if keep > 0.0:
                        total = G[row + e]
                    k, rest, c = N[3 * (row + e)], N[3 * (row + e) + 1], N[3 * (row + e) + 2]
                    du, dv, dw = u - U, v - V, w - W
                    a, b, d = x - X + h * du, y - Y + h * dv, z - Z + h * dw
                    length = ti.sqrt(a * a + b * b + d * d)
                    inverse = 1.0 / ti.max(length, 1e-30)
                    a, b, d = a * inverse, b * inverse, d * inverse
                    compliance = 1.0 / ti.max(h * (h * k + c), 1e-24)
                    right = (h * (k * (length - rest) + c * (a * du + b * dv + d * dw)) - total) * compliance
                    cosine = a * A + b * B + d * C
                    inverse_pivot = 1.0 / (M + s)  # of the spring before
                    coupling = M * cosine
                    s = compliance + M * ((s + M * ti.max(1.0 - cosine * cosine, 0.0)) * inverse_pivot)
                    J = (right + coupling * J) / (s + m)
                    X, Y, Z, M, U, V, W, A, B, C = x, y, z, m, u, v, w, a, b, d
                    o = scratch + SCRATCH * e
                    T[o], T[o + 1], T[o + 2], T[o + 3], T[o + 4] = A, B, C, J, coupling * inverse_pivot
                A, B, C, J = zero, zero, zero, zero  # back substitution; f J is the contribution of the spring after
                for r in range(1, count):
                    e = count - r
                    o = scratch + SCRATCH * e
                    J = T[o + 3] + f * J
                    f = T[o + 4]
                    a, b, d = J * T[o], J * T[o + 1], J * T[o + 2]
                    A, B, C = A - a, B - b, C - d
                    for j in ti.static(range(LANES)):
                        i = 2 * index[first + e * LANES + j]
                        P[i + 1] = P[i + 1] + P[i][3] * ti.Vector([A[j], B[j], C[j], 0.0])
                    A, B, C = a, b, d
                    if more > 0:
                        G[row + e] = keep * G[row + e] + J
                for j in ti.static(range(LANES)):
                    i = 2 * index[first + j]
                    P[i + 1] = P[i + 1] + P[i][3] * ti.Vector([A[j], B[j], C[j], 0.0])

    return (
        runtime.kernel(load, precision, vectors=True), runtime.kernel(project, precision, vectors=True),
        runtime.kernel(store, precision, vectors=True),
    )  # fmt: skip
