"""The XPBD step of springs: sweeps over their threads, each solved exactly along its whole length.

With the velocities after the kick, the particles would come to x + h v. There each spring of a thread has the direction n, the
length l and the speed u = n.(v_b - v_a) along it. Its impulse is J = h k (l + h du - L) + h c (u + du), where du is the change
that the impulses of the thread make. With K = h^2 k + h c and w the inverse masses that is
(w_a + w_b + 1/K) J_e - w_a n_e.n_(e-1) J_(e-1) - w_b n_e.n_(e+1) J_(e+1) = h (k (l - L) + c u) / K,
less J / K of the sweeps before. For a thread of one spring this is the projection of XPBD with compliance 1/k; for a longer
one the matrix is tridiagonal and is eliminated without a subtraction: the pivot is w_b + s_e, where
s_e = 1/K + w_a (s_(e-1) + w_a sin^2) / (w_a + s_(e-1)) is a sum of positive terms, however stiff. One step is one substep.
Sources: Macklin, Mueller, Chentanez, XPBD (2016); Macklin et al., Small Steps in Physics Simulation (2019); for threads solved
at once Deul et al., Direct Position-Based Solver for Stiff Rods (2018).
"""

from functools import cache

import numpy as np

from gen_art import runtime
from gen_art.interactions.threads import LANES, Threads
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.runtime import ti

__all__ = ["sweep"]


def sweep(floats: np.ndarray, n: int, threads: Threads, h: float, precision: str, sweeps: int = 1) -> None:
    """Change the velocities (rows 3-5) of the first n particles by the impulses of the springs over a step h.

    sweeps : rounds of Newton's method; a spring's impulses add up, so that its stiffness is the same after any number
    """
    give = np.zeros(n + LANES, floats.dtype)
    np.divide(1, floats[6, :n], out=give[:n], where=floats[6, :n] > 0)
    give[:n][fixed_lifetimes(floats[9, :n])] = 0
    kernel, flat, capacity = _kernel(precision), floats.reshape(-1), floats.shape[1]
    for k in range(sweeps):
        for begin, end in threads.colours:
            kernel(
                flat, give, threads.index, threads.numbers, threads.scratch, threads.total, begin, end, *threads.parts,
                capacity, threads.room, h, min(k, 1), sweeps - 1 - k,
            )  # fmt: skip


@cache
def _kernel(precision: str):
    real = runtime.DTYPES[precision]
    vector, whole = ti.types.ndarray(real, 1), ti.types.ndarray(ti.i32, 1)

    @ti.kernel
    def project(
        S: vector, give: vector, index: whole, N: vector, T: vector, G: vector, begin: ti.i32, end: ti.i32, tasks: ti.i32,
        nodes: ti.i32, near: ti.i32, capacity: ti.i32, room: ti.i32, h: real, keep: real, more: ti.i32,
    ):  # fmt: skip
        """index: first group of each task, first slot of each group, particle of each slot, steps of neighbours;
        room: scratch a task; keep: 0 in a step's first sweep, else 1; more: sweeps follow."""
        ti.loop_config(block_dim=1)
        for t in range(begin, end):
            mine = (t - begin) * room
            row = capacity  # flat arrays with strides in registers: half the time of two-dimensional ones
            for g in range(index[t], index[t + 1]):
                at = index[tasks + g]
                count = (index[tasks + g + 1] - at) // LANES
                X, Y, Z = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)  # the last node
                U, V, W = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                x, y, z = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)  # the next
                u, v, w = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                A, B, C = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)  # direction
                M, m = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                acc = ti.Vector([0.0] * LANES)
                s, J, f = ti.Vector([1e24] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                for j in range(LANES):
                    i = index[nodes + at + j]
                    X[j], Y[j], Z[j], M[j] = S[i], S[i + row], S[i + 2 * row], give[i]
                    U[j], V[j], W[j] = S[i + 3 * row], S[i + 4 * row], S[i + 5 * row]
                for e in range(1, count):
                    q = at + e * LANES
                    i = index[nodes + q]
                    if index[near + q // LANES] > 0:  # neighbours in memory too: whole vectors
                        for j in range(LANES):
                            x[j], y[j], z[j], m[j] = S[i + j], S[i + j + row], S[i + j + 2 * row], give[i + j]
                            u[j], v[j], w[j] = S[i + j + 3 * row], S[i + j + 4 * row], S[i + j + 5 * row]
                    else:
                        for j in range(LANES):
                            o = index[nodes + q + j]
                            x[j], y[j], z[j], m[j] = S[o], S[o + row], S[o + 2 * row], give[o]
                            u[j], v[j], w[j] = S[o + 3 * row], S[o + 4 * row], S[o + 5 * row]
                    if keep > 0.0:
                        for j in range(LANES):
                            acc[j] = G[q + j]
                    for j in range(LANES):
                        k, rest, c = N[3 * q + j], N[3 * q + LANES + j], N[3 * q + 2 * LANES + j]
                        a, b, c0 = u[j] - U[j], v[j] - V[j], w[j] - W[j]
                        dx, dy, dz = x[j] - X[j] + h * a, y[j] - Y[j] + h * b, z[j] - Z[j] + h * c0
                        length = ti.sqrt(dx * dx + dy * dy + dz * dz)
                        each = 1.0 / ti.max(length, 1e-30)
                        dx, dy, dz = dx * each, dy * each, dz * each
                        loose = 1.0 / ti.max(h * (h * k + c), 1e-24)
                        wants = (h * (k * (length - rest) + c * (dx * a + dy * b + dz * c0)) - acc[j]) * loose
                        cosine = dx * A[j] + dy * B[j] + dz * C[j]
                        pivot = 1.0 / (M[j] + s[j])  # of the spring before
                        share = M[j] * cosine
                        f[j] = share * pivot
                        s[j] = loose + M[j] * ((s[j] + M[j] * ti.max(1.0 - cosine * cosine, 0.0)) * pivot)
                        M[j] = m[j]
                        J[j] = (wants + share * J[j]) / (s[j] + m[j])
                        X[j], Y[j], Z[j], U[j], V[j], W[j] = x[j], y[j], z[j], u[j], v[j], w[j]
                        A[j], B[j], C[j] = dx, dy, dz
                    for j in range(LANES):
                        o = mine + 5 * (q - at) + j
                        T[o], T[o + LANES], T[o + 2 * LANES] = A[j], B[j], C[j]
                        T[o + 3 * LANES], T[o + 4 * LANES] = J[j], f[j]
                for j in range(LANES):  # from the end back: A, B, C now the impulse of the spring after, f its share
                    A[j], B[j], C[j], J[j], f[j] = 0.0, 0.0, 0.0, 0.0, 0.0
                for e in range(1, count):
                    q = at + (count - e) * LANES
                    i, close = index[nodes + q], index[near + q // LANES] > 0
                    if close:
                        for j in range(LANES):
                            u[j], v[j], w[j] = S[i + j + 3 * row], S[i + j + 4 * row], S[i + j + 5 * row]
                            m[j] = give[i + j]
                    else:
                        for j in range(LANES):
                            o = index[nodes + q + j]
                            u[j], v[j], w[j], m[j] = S[o + 3 * row], S[o + 4 * row], S[o + 5 * row], give[o]
                    for j in range(LANES):
                        o = mine + 5 * (q - at) + j
                        J[j] = T[o + 3 * LANES] + f[j] * J[j]
                        f[j] = T[o + 4 * LANES]
                        a, b, c = J[j] * T[o], J[j] * T[o + LANES], J[j] * T[o + 2 * LANES]
                        u[j] += m[j] * (A[j] - a)
                        v[j] += m[j] * (B[j] - b)
                        w[j] += m[j] * (C[j] - c)
                        A[j], B[j], C[j] = a, b, c
                    if close:
                        for j in range(LANES):
                            S[i + j + 3 * row], S[i + j + 4 * row], S[i + j + 5 * row] = u[j], v[j], w[j]
                    else:
                        for j in range(LANES):
                            o = index[nodes + q + j]
                            S[o + 3 * row], S[o + 4 * row], S[o + 5 * row] = u[j], v[j], w[j]
                    if more > 0:
                        for j in range(LANES):
                            G[q + j] = keep * G[q + j] + J[j]
                for j in range(LANES):
                    i = index[nodes + at + j]
                    S[i + 3 * row] = S[i + 3 * row] + give[i] * A[j]
                    S[i + 4 * row] = S[i + 4 * row] + give[i] * B[j]
                    S[i + 5 * row] = S[i + 5 * row] + give[i] * C[j]

    return runtime.kernel(project, precision)
