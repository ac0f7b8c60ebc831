"""The linear equations of joints: their matrix, its factors, and the solution with bounds on some of the unknowns.

Sums run in a fixed order on one thread, so that the bits never depend on the processor or the number of threads.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.rigid import contact_columns as col

__all__ = ["DEPENDENT", "joint_kernels"]

DEPENDENT = 1e-10  # relative to a row's own mobility: a row with less of its own is a combination of those before it
_SWEEPS = 2000

_matrix = ti.types.ndarray(ti.f64, 2)
_ints = ti.types.ndarray(ti.i32, 1)
_floats = ti.types.ndarray(ti.f64, 1)


@ti.func
def _spread(B: ti.template(), body, J: ti.template(), i):
    """B J^T of one row and one of its bodies: the velocity and spin that a unit impulse gives it."""
    out = ti.Vector([0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    for c in ti.static(range(3)):
        out[c] = B[body, col.INVERSE_MASS] * J[i, c]
        for k in ti.static(range(3)):
            out[3 + c] += B[body, col.INVERSE_INERTIA + 3 * c + k] * J[i, 3 + k]
    return out


@ti.func
def _along(J: ti.template(), i, v):
    out = 0.0
    for c in ti.static(range(6)):
        out += J[i, c] * v[c]
    return out


@cache
def joint_kernels():
    """(factor, solve) for m rows, of which the first `held` are equations and the others have bounds.

    factor(B, first, second, J1, J2, K, F, P, held)
        B (bodies + 1, col.BODY_COLUMNS): as of the contact kernel; the world is the last body
        first, second (m,): the bodies of each row; J1, J2 (m, 6): the row's derivatives by their places and turns
        Writes K (m, m) = J B J^T, and the factors L D L^T of its held part: L below the diagonal of F (m, m), D on it, 0 where a
        row depends on earlier ones. P (m,) is the column of the first element that is not 0: the factors have none before it.
    solve(K, F, P, r, low, high, x, held)
        Changes x (m,) so that K dx + r = 0 in the held rows; the others have low <= x <= high, and K dx + r >= 0 at the low
        bound, <= 0 at the high one, 0 between: projected Gauss-Seidel sweeps over the bounded rows, the held
        ones eliminated exactly.
    """

    @ti.kernel
    def factor(
        B: _matrix,
        first: _ints,
        second: _ints,
        J1: _matrix,
        J2: _matrix,
        K: _matrix,
        F: _matrix,
        P: _ints,
        held: ti.i32,
    ):
        ti.loop_config(serialize=True)
        for _ in range(1):
            m = first.shape[0]
            for i in range(m):
                a, b = first[i], second[i]
                to_a, to_b = _spread(B, a, J1, i), _spread(B, b, J2, i)
                P[i] = i
                for j in range(i + 1):
                    value = 0.0
                    if first[j] == a:
                        value += _along(J1, j, to_a)
                    if second[j] == b:
                        value += _along(J2, j, to_b)
                    if first[j] == b:
                        value += _along(J1, j, to_b)
                    if second[j] == a:
                        value += _along(J2, j, to_a)
                    K[i, j] = value
                    K[j, i] = value
                    if value != 0.0 and j < P[i]:
                        P[i] = j
            for i in range(held):
                for j in range(P[i], i):
                    value = K[i, j]
                    for k in range(ti.max(P[i], P[j]), j):
                        value -= F[i, k] * F[k, k] * F[j, k]
                    F[i, j] = 0.0
                    if F[j, j] > 0.0:
                        F[i, j] = value / F[j, j]
                pivot = K[i, i]
                for k in range(P[i], i):
                    pivot -= F[i, k] * F[i, k] * F[k, k]
                F[i, i] = ti.select(pivot > DEPENDENT * K[i, i], pivot, 0.0)

    @ti.func
    def divide(F: ti.template(), P: ti.template(), y: ti.template(), row, held):
        """Row `row` of y becomes K^-1 of it, for the held part."""
        for i in range(held):
            for k in range(P[i], i):
                y[row, i] = y[row, i] - F[i, k] * y[row, k]
        for i in range(held):
            y[row, i] = ti.select(F[i, i] > 0.0, y[row, i] / ti.max(F[i, i], 1e-300), 0.0)
        for back in range(held):
            i = held - 1 - back
            for k in range(P[i], i):
                y[row, k] = y[row, k] - F[i, k] * y[row, i]

    @ti.kernel
    def solve(
        K: _matrix,
        F: _matrix,
        P: _ints,
        Y: _matrix,
        S: _matrix,
        r: _floats,
        low: _floats,
        high: _floats,
        x: _floats,
        held: ti.i32,
    ):
        ti.loop_config(serialize=True)
        for _ in range(1):
            m = r.shape[0]
            n = m - held
            for i in range(held):
                Y[n, i] = r[i]
            divide(F, P, Y, n, held)
            for p in range(n):
                for i in range(held):
                    Y[p, i] = K[held + p, i]
                divide(F, P, Y, p, held)
            for p in range(n):
                for q in range(n):
                    S[p, q] = K[held + p, held + q]
                    for i in range(held):
                        S[p, q] = S[p, q] - K[held + p, i] * Y[q, i]
                S[n, p] = 0.0  # the change of x
                S[p, n] = r[held + p]
                for i in range(held):
                    S[p, n] = S[p, n] - K[held + p, i] * Y[n, i]
            change, sweeps = 1.0, 0
            while change > 0.0 and sweeps < _SWEEPS:
                change = 0.0
                for p in range(n):
                    rest = S[p, n]
                    for q in range(n):
                        rest += S[p, q] * S[n, q]
                    if S[p, p] > DEPENDENT * K[held + p, held + p]:
                        old = S[n, p]
                        at = x[held + p]
                        new = ti.min(ti.max(at + old - rest / S[p, p], low[held + p]), high[held + p]) - at
                        S[n, p] = new
                        if ti.abs(new - old) > 1e-15 * ti.abs(at + new):
                            change = 1.0
                sweeps += 1
            for i in range(held):
                step = Y[n, i]
                for p in range(n):
                    step += Y[p, i] * S[n, p]
                x[i] = x[i] - step
            for p in range(n):
                x[held + p] = x[held + p] + S[n, p]

    return runtime.kernel(factor, "f64"), runtime.kernel(solve, "f64")
