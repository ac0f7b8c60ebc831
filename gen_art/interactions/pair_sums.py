"""Sums over all pairs of targets and sources by whole vectors, whose lanes are sixteen targets.

For a pair at the vector d from target to source, with s^2 = d^2 + softening^2, the field is the sum of c s^(n-1) d, and the
potential is the sum of c s^(n+1), for a whole number n and the source's amount c. A pair with s = 0 adds nothing. Square roots
and divisions are correctly rounded, and each target adds its sources in their order: the bits do not depend on threads.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import real, ti

__all__ = ["CHUNK", "LANES", "field_kernel", "half_powers", "load", "potential_kernel", "spread"]

LANES = 16
CHUNK = 256  # sources in a partial sum: keeps float32 sums over many thousands accurate
_VECTORS = 8  # of targets in a task


@ti.func
def spread(x):
    """A vector with the same number, in the kernel's precision, in each lane."""
    y = ti.cast(x, real())
    return ti.Vector([y for _ in ti.static(range(LANES))])


def half_powers(k: int):
    """The function (c, r2) -> c r2^(k/2) of vectors, for a whole number k; 0 where r2 = 0."""
    half, odd = divmod(abs(k), 2)

    @ti.func
    def weight(c, r2):
        power = [spread(1.0)]  # in a list, because Taichi 1.7.4 may not rebind the name of a whole vector
        if ti.static(odd == 1):
            power[0] = ti.sqrt(r2)
        elif ti.static(half > 0):
            power[0] = r2
        for _ in ti.static(range(half if odd else half - 1)):
            power[0] = power[0] * r2
        if ti.static(k < 0):
            power[0] = c / power[0]
        else:
            power[0] = c * power[0]
        return ti.select(r2 > spread(0.0), power[0], spread(0.0))

    return weight


@ti.func
def load(T: ti.template(), row, i):
    """Sixteen numbers of a row from column i on."""
    return ti.Vector([T[row, i + lane] for lane in ti.static(range(LANES))])


@cache
def field_kernel(n: int, precision: str):
    """The kernel (T, M, out, count, q) that writes q[0] times the sums of c s^(n-1) d into the first three rows of `out`.

    T, out : (3 or more, capacity), the capacity a multiple of LANES and at least the number of targets, `count`
    M : (4, sources), their positions, m, and amounts
    q : factor, softening^2
    """
    float_type = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(float_type, 2), ti.types.ndarray(float_type, 1)
    weight = half_powers(n - 1)

    @ti.kernel
    def field(T: matrix, M: matrix, out: matrix, count: ti.i32, q: vector):
        m, tiles = M.shape[1], (count + LANES - 1) // LANES
        ti.loop_config(block_dim=1)
        for task in range((tiles + _VECTORS - 1) // _VECTORS):
            for t in range(_VECTORS // 2):
                # two vectors of targets, X, Y, Z and U, V, W, share the loads of sources; the last one alone counts twice
                i = (task * _VECTORS + 2 * t) * LANES
                if i < count:
                    second = ti.min(i + LANES, (tiles - 1) * LANES)
                    e2 = spread(q[1])
                    X, Y, Z = load(T, 0, i), load(T, 1, i), load(T, 2, i)
                    U, V, W = load(T, 0, second), load(T, 1, second), load(T, 2, second)
                    A, B, C = spread(0.0), spread(0.0), spread(0.0)
                    D, E, F = spread(0.0), spread(0.0), spread(0.0)
                    for chunk in range((m + CHUNK - 1) // CHUNK):
                        a, b, c = spread(0.0), spread(0.0), spread(0.0)
                        d, e, f = spread(0.0), spread(0.0), spread(0.0)
                        for j in range(chunk * CHUNK, ti.min((chunk + 1) * CHUNK, m)):
                            x, y, z, amount = spread(M[0, j]), spread(M[1, j]), spread(M[2, j]), spread(M[3, j])
                            dx, dy, dz = x - X, y - Y, z - Z
                            w = weight(amount, dx * dx + dy * dy + dz * dz + e2)
                            a += w * dx
                            b += w * dy
                            c += w * dz
                            du, dv, dw = x - U, y - V, z - W
                            v = weight(amount, du * du + dv * dv + dw * dw + e2)
                            d += v * du
                            e += v * dv
                            f += v * dw
                        A += a
                        B += b
                        C += c
                        D += d
                        E += e
                        F += f
                    k = spread(q[0])
                    for at, sums in ti.static(((i, (A, B, C)), (second, (D, E, F)))):
                        for row in ti.static(range(3)):
                            result = k * sums[row]
                            for lane in ti.static(range(LANES)):
                                out[row, at + lane] = result[lane]

    return runtime.kernel(field, precision, vectors=True)


@cache
def potential_kernel(n: int, precision: str):
    """The kernel (T, M, out, count, q) that writes q[0] times the sums of c s^(n+1) into out, (capacity,); see `field_kernel`."""
    float_type = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(float_type, 2), ti.types.ndarray(float_type, 1)
    weight = half_powers(n + 1)

    @ti.kernel
    def potential(T: matrix, M: matrix, out: vector, count: ti.i32, q: vector):
        m, tiles = M.shape[1], (count + LANES - 1) // LANES
        ti.loop_config(block_dim=1)
        for task in range((tiles + _VECTORS - 1) // _VECTORS):
            for t in range(task * _VECTORS, ti.min((task + 1) * _VECTORS, tiles)):
                i, e2 = t * LANES, spread(q[1])
                X, Y, Z, A = load(T, 0, i), load(T, 1, i), load(T, 2, i), spread(0.0)
                for chunk in range((m + CHUNK - 1) // CHUNK):
                    a = spread(0.0)
                    for j in range(chunk * CHUNK, ti.min((chunk + 1) * CHUNK, m)):
                        dx, dy, dz = spread(M[0, j]) - X, spread(M[1, j]) - Y, spread(M[2, j]) - Z
                        a += weight(spread(M[3, j]), dx * dx + dy * dy + dz * dz + e2)
                    A += a
                A = spread(q[0]) * A
                for lane in ti.static(range(LANES)):
                    out[i + lane] = A[lane]

    return runtime.kernel(potential, precision, vectors=True)
