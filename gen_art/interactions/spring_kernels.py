"""The kernels of springs: forces, and the matrix of the implicit step. Each particle sums the forces of its own springs.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.particles.fixed import is_fixed
from gen_art.particles.rows import LIFETIME, MASS, PX, VX

__all__ = ["BLOCK", "DAMPING", "EDGE_ROWS", "REST", "STIFFNESS", "spring_kernels"]

BLOCK = 512  # particles per task
STIFFNESS, REST, DAMPING = 0, 1, 2  # rows of N, the springs' numbers
_DIRECTION, _ACROSS, _ALONG, EDGE_ROWS = 0, 3, 4, 5  # rows of E, the half-edges' matrices


@ti.func
def _vector(M: ti.template(), row: ti.template(), i):
    return ti.Vector([M[row, i], M[row + 1, i], M[row + 2, i]])


@cache
def spring_kernels(precision: str):
    """(accelerate, assemble, multiply, descend, new_direction); `first`, `other` and N are those of an Adjacency."""
    real = runtime.DTYPES[precision]
    matrix, ints = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1)
    sums = ti.types.ndarray(ti.f64, 2)

    @ti.kernel
    def accelerate(X: matrix, S: matrix, first: ints, other: ints, N: matrix, out: matrix, n: ti.i32, parts: ti.i32):
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, v = _vector(X, PX, i), _vector(X, VX, i)
                elastic, damping = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
                for e in range(first[i], first[i + 1]):
                    d = _vector(X, PX, other[e]) - x
                    length = d.norm()
                    d = d * (1.0 / ti.max(length, 1e-30))
                    elastic += (N[STIFFNESS, e] * (length - N[REST, e])) * d
                    damping += (N[DAMPING, e] * (_vector(X, VX, other[e]) - v).dot(d)) * d
                inverse_mass = 1.0 / ti.max(S[MASS, i], 1e-30)
                for c in ti.static(range(3)):
                    out[c, i] = elastic[c] * inverse_mass
                if parts > 1:
                    for c in ti.static(range(3)):
                        out[3 + c, i] = damping[c] * inverse_mass

    @ti.kernel
    def assemble(S: matrix, first: ints, other: ints, N: matrix, E: matrix, R: matrix, n: ti.i32, h: real):
        """Write E, the matrix of each half-edge, across (1 - d d^T) + (across + along) d d^T, and R, the right-hand side."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, v = _vector(S, PX, i), _vector(S, VX, i)
                force = ti.Vector([0.0, 0.0, 0.0])
                for e in range(first[i], first[i + 1]):
                    d = _vector(S, PX, other[e]) - x
                    length = d.norm()
                    d = d * (1.0 / ti.max(length, 1e-30))
                    k = h * h * N[STIFFNESS, e]
                    across = k * ti.max(1.0 - N[REST, e] / ti.max(length, 1e-30), 0.0)
                    along = k + h * N[DAMPING, e] - across
                    w = _vector(S, VX, other[e]) - v
                    force += (h * N[STIFFNESS, e] * (length - N[REST, e]) + along * w.dot(d)) * d + across * w
                    for c in ti.static(range(3)):
                        E[_DIRECTION + c, e] = d[c]
                    E[_ACROSS, e], E[_ALONG, e] = across, along
                for c in ti.static(range(3)):
                    R[c, i] = ti.select(is_fixed(S[LIFETIME, i]), 0.0, force[c])

    @ti.kernel
    def multiply(S: matrix, first: ints, other: ints, E: matrix, P: matrix, Q: matrix, n: ti.i32, B: sums):
        """Q = (M + h D + h^2 K) P, with the sum of P.Q of each block in B."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            total = ti.f64(0.0)
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                p = _vector(P, 0, i)
                q = S[MASS, i] * p
                for e in range(first[i], first[i + 1]):
                    w = p - _vector(P, 0, other[e])
                    d = _vector(E, _DIRECTION, e)
                    q += E[_ACROSS, e] * w + (E[_ALONG, e] * w.dot(d)) * d
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
    def new_direction(S: matrix, R: matrix, P: matrix, n: ti.i32, beta: real):
        """P = R / m + beta P."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                inverse_mass = 1.0 / ti.max(S[MASS, i], 1e-30)
                for c in ti.static(range(3)):
                    P[c, i] = R[c, i] * inverse_mass + beta * P[c, i]

    return tuple(runtime.kernel(f, precision) for f in (accelerate, assemble, multiply, descend, new_direction))
