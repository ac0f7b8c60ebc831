"""Sums over all pairs of targets and sources by whole vectors, whose lanes are sixteen targets.

For a pair at the vector d from target to source, with s^2 = d^2 + softening^2, the field is the sum of c s^(n-1) d, and the
potential is the sum of c s^(n+1), for a whole number n and the source's amount c. A pair with s = 0 adds nothing. Square roots
and divisions are correctly rounded, and each target adds its sources in their order: the bits do not depend on threads.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import real, ti

__all__ = ["LANES", "field_sums", "half_powers", "pack", "potential_sums", "spread"]

LANES = 16
CHUNK = 256  # sources in a partial sum: keeps float32 sums over many thousands accurate
_TASK = 4  # pairs of vectors of targets


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


def pack(positions: np.ndarray) -> np.ndarray:
    """(3, n) m, as the kernels read targets: (tiles, 3, LANES), an even number of tiles, filled with zeros."""
    n = positions.shape[1]
    tiles = 2 * -(-n // (2 * LANES))
    full, rest = divmod(n, LANES)
    packed = runtime.aligned((tiles, 3, LANES), positions.dtype)
    packed[:full] = positions[:, : full * LANES].reshape(3, full, LANES).transpose(1, 0, 2)
    if rest:
        packed[full, :, :rest] = positions[:, full * LANES :]
    return packed


def field_sums(targets: np.ndarray, sources: np.ndarray, n: int, softening: float, precision: str) -> np.ndarray:
    """(3, targets): the sums of c s^(n-1) d.

    targets : (3, targets) m
    sources : (4, sources), their positions, m, and amounts
    """
    packed = pack(targets)
    out = runtime.aligned(packed.shape, packed.dtype)
    _field_kernel(n, precision)(packed, sources, out, np.array([softening**2], packed.dtype))
    return out.transpose(1, 0, 2).reshape(3, -1)[:, : targets.shape[1]]


def potential_sums(targets: np.ndarray, sources: np.ndarray, n: int, softening: float, precision: str) -> np.ndarray:
    """(targets,): the sums of c s^(n+1). The arguments are those of `field_sums`."""
    packed = pack(targets)
    out = runtime.aligned((len(packed), LANES), packed.dtype)
    _potential_kernel(n, precision)(packed, sources, out, np.array([softening**2], packed.dtype))
    return out.reshape(-1)[: targets.shape[1]]


@cache
def _field_kernel(n: int, precision: str):
    float_type = runtime.DTYPES[precision]
    vectors = ti.types.ndarray(ti.types.vector(LANES, float_type), 2)
    weight = half_powers(n - 1)

    @ti.kernel
    def field(T: vectors, M: ti.types.ndarray(float_type, 2), out: vectors, q: ti.types.ndarray(float_type, 1)):
        m, pairs = M.shape[1], T.shape[0] // 2
        ti.loop_config(block_dim=1)
        for b in range((pairs + _TASK - 1) // _TASK):
            for t in range(b * _TASK, ti.min((b + 1) * _TASK, pairs)):
                # two vectors of targets, (X, Y, Z) and (U, V, W), hide each other's wait for square roots and divisions
                i = 2 * t
                e2 = spread(q[0])
                X, Y, Z, U, V, W = T[i, 0], T[i, 1], T[i, 2], T[i + 1, 0], T[i + 1, 1], T[i + 1, 2]
                A, B, C = spread(0.0), spread(0.0), spread(0.0)
                D, E, F = spread(0.0), spread(0.0), spread(0.0)
                for chunk in range((m + CHUNK - 1) // CHUNK):
                    a, b1, c = spread(0.0), spread(0.0), spread(0.0)
                    d, e, f = spread(0.0), spread(0.0), spread(0.0)
                    for j in range(chunk * CHUNK, ti.min((chunk + 1) * CHUNK, m)):
                        x, y, z, amount = spread(M[0, j]), spread(M[1, j]), spread(M[2, j]), spread(M[3, j])
                        dx, dy, dz = x - X, y - Y, z - Z
                        w = weight(amount, dx * dx + dy * dy + dz * dz + e2)
                        a += w * dx
                        b1 += w * dy
                        c += w * dz
                        du, dv, dw = x - U, y - V, z - W
                        v = weight(amount, du * du + dv * dv + dw * dw + e2)
                        d += v * du
                        e += v * dv
                        f += v * dw
                    A += a
                    B += b1
                    C += c
                    D += d
                    E += e
                    F += f
                out[i, 0], out[i, 1], out[i, 2] = A, B, C
                out[i + 1, 0], out[i + 1, 1], out[i + 1, 2] = D, E, F

    return runtime.kernel(field, precision, vectors=True)


@cache
def _potential_kernel(n: int, precision: str):
    float_type = runtime.DTYPES[precision]
    vectors = ti.types.ndarray(ti.types.vector(LANES, float_type), 2)
    weight = half_powers(n + 1)

    @ti.kernel
    def potential(
        T: vectors, M: ti.types.ndarray(float_type, 2), out: ti.types.ndarray(ti.types.vector(LANES, float_type), 1),
        q: ti.types.ndarray(float_type, 1),
    ):  # fmt: skip
        m, pairs = M.shape[1], T.shape[0] // 2
        ti.loop_config(block_dim=1)
        for b in range((pairs + _TASK - 1) // _TASK):
            for t in range(b * _TASK, ti.min((b + 1) * _TASK, pairs)):
                i = 2 * t
                e2 = spread(q[0])
                X, Y, Z, U, V, W = T[i, 0], T[i, 1], T[i, 2], T[i + 1, 0], T[i + 1, 1], T[i + 1, 2]
                A, B = spread(0.0), spread(0.0)
                for chunk in range((m + CHUNK - 1) // CHUNK):
                    a, b1 = spread(0.0), spread(0.0)
                    for j in range(chunk * CHUNK, ti.min((chunk + 1) * CHUNK, m)):
                        x, y, z, amount = spread(M[0, j]), spread(M[1, j]), spread(M[2, j]), spread(M[3, j])
                        dx, dy, dz = x - X, y - Y, z - Z
                        a += weight(amount, dx * dx + dy * dy + dz * dz + e2)
                        du, dv, dw = x - U, y - V, z - W
                        b1 += weight(amount, du * du + dv * dv + dw * dw + e2)
                    A += a
                    B += b1
                out[i], out[i + 1] = A, B

    return runtime.kernel(potential, precision, vectors=True)
