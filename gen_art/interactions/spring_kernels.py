"""The kernels of springs: forces, and the matrix of the implicit step, each particle summing its own springs."""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.particles.fixed import is_fixed
from gen_art.particles.rows import LIFETIME, MASS

__all__ = ["BLOCK", "spring_kernels"]

BLOCK = 512  # particles a task
STIFFNESS, REST, DAMPING = 0, 1, 2  # rows of the springs' numbers


@ti.func
def _vector(M: ti.template(), row: ti.template(), i):
    return ti.Vector([M[row, i], M[row + 1, i], M[row + 2, i]])


@cache
def spring_kernels(precision: str):
    """(accelerate, assemble, multiply, descend); arrays as the callers in springs.py and implicit.py lay them out."""
    real = runtime.DTYPES[precision]
    matrix, whole = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1)
    sums = ti.types.ndarray(ti.f64, 2)

    @ti.kernel
    def accelerate(X: matrix, S: matrix, first: whole, other: whole, N: matrix, out: matrix, n: ti.i32, parts: ti.i32):
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, v = _vector(X, 0, i), _vector(X, 3, i)
                pull, drag = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
                for e in range(first[i], first[i + 1]):
                    d = _vector(X, 0, other[e]) - x
                    length = d.norm()
                    d = d * (1.0 / ti.max(length, 1e-30))
                    pull += (N[STIFFNESS, e] * (length - N[REST, e])) * d
                    drag += (N[DAMPING, e] * (_vector(X, 3, other[e]) - v).dot(d)) * d
                each = 1.0 / ti.max(S[MASS, i], 1e-30)
                for c in ti.static(range(3)):
                    out[c, i] = pull[c] * each
                if parts > 1:
                    for c in ti.static(range(3)):
                        out[3 + c, i] = drag[c] * each

    @ti.kernel
    def assemble(S: matrix, first: whole, other: whole, N: matrix, E: matrix, R: matrix, n: ti.i32, h: real):
        """E: direction, h^2 k across, and what lies beyond it along, of each half-edge; R: the right-hand side."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, v = _vector(S, 0, i), _vector(S, 3, i)
                right = ti.Vector([0.0, 0.0, 0.0])
                for e in range(first[i], first[i + 1]):
                    d = _vector(S, 0, other[e]) - x
                    length = d.norm()
                    d = d * (1.0 / ti.max(length, 1e-30))
                    k = h * h * N[STIFFNESS, e]
                    across = k * ti.max(1.0 - N[REST, e] / ti.max(length, 1e-30), 0.0)
                    along = k + h * N[DAMPING, e] - across
                    w = _vector(S, 3, other[e]) - v
                    right += (h * N[STIFFNESS, e] * (length - N[REST, e]) + along * w.dot(d)) * d + across * w
                    for c in ti.static(range(3)):
                        E[c, e] = d[c]
                    E[3, e], E[4, e] = across, along
                for c in ti.static(range(3)):
                    R[c, i] = ti.select(is_fixed(S[LIFETIME, i]), 0.0, right[c])

    @ti.kernel
    def multiply(S: matrix, first: whole, other: whole, E: matrix, P: matrix, Q: matrix, n: ti.i32, B: sums):
        """Q = (M + h D + h^2 K) P, with the sum of P.Q of each block in B."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            total = ti.f64(0.0)
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                p = _vector(P, 0, i)
                q = S[MASS, i] * p
                for e in range(first[i], first[i + 1]):
                    w = p - _vector(P, 0, other[e])
                    d = _vector(E, 0, e)
                    q += E[3, e] * w + (E[4, e] * w.dot(d)) * d
                if is_fixed(S[LIFETIME, i]):
                    q = p * 0.0
                total += ti.cast(p.dot(q), ti.f64)
                for c in ti.static(range(3)):
                    Q[c, i] = q[c]
            B[b, 0] = total

    @ti.kernel
    def descend(S: matrix, V: matrix, R: matrix, P: matrix, Q: matrix, n: ti.i32, a: real, B: sums):
        """V += a P, R -= a Q, and R.R / m of each block in B."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            total = ti.f64(0.0)
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                r = _vector(R, 0, i) - a * _vector(Q, 0, i)
                for c in ti.static(range(3)):
                    V[c, i] = V[c, i] + a * P[c, i]
                    R[c, i] = r[c]
                total += ti.cast(r.dot(r) / ti.max(S[MASS, i], 1e-30), ti.f64)
            B[b, 0] = total

    @ti.kernel
    def turn(S: matrix, R: matrix, P: matrix, n: ti.i32, beta: real):
        """P = R / m + beta P."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                each = 1.0 / ti.max(S[MASS, i], 1e-30)
                for c in ti.static(range(3)):
                    P[c, i] = R[c, i] * each + beta * P[c, i]

    return tuple(runtime.kernel(f, precision) for f in (accelerate, assemble, multiply, descend, turn))
