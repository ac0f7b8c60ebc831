"""Mutual gravity by direct summation."""

from functools import cache

import numpy as np

from gen_art import runtime
from gen_art.errors import UsageError
from gen_art.interactions.base import Interaction, interaction
from gen_art.registry import param
from gen_art.runtime import ti

__all__ = ["SelfGravity"]

_LANES = 16
_BLOCK = 256  # targets a task
_CHUNK = 256  # sources summed before they join the total: keeps float32 sums of many thousands accurate


@interaction("self_gravity")
class SelfGravity(Interaction):
    """Every particle attracts every other, softened after Plummer.

    a_i = G sum_j m_j (x_j - x_i) / s^3,  s^2 = abs(x_j - x_i)^2 + softening^2;  U = -G sum_{i<j} m_i m_j / s

    G : constant of gravitation in the preset's units, 6.6743e-11 m^3/kg/s^2 when left out     softening : m, >= 0
    method : "direct"     sources : the name of another system, whose field then acts without reaction (booked in the ledger)
    Conservative and reciprocal, unless `sources` is given. Source: Dehnen & Read, Eur. Phys. J. Plus 126, 55 (2011).
    """

    G: float = param(6.67430e-11, min=0, doc="constant of gravitation; units.G of the preset when left out")
    softening: float = param(0.0, unit="m", min=0)
    method: str = param("direct", choices=("direct",))
    sources: str = param(None, doc="another system that attracts this one, without reaction")

    def accelerate(self, targets, n, sources, out, precision):
        numbers = np.array([self.values["G"], self.values["softening"] ** 2], targets.dtype)
        _kernels(precision)[0](targets, sources, out, n, numbers)

    def energy(self, targets, weights, precision):
        n = targets.shape[1]
        if self.source_system is not None or n == 0:
            return 0.0
        padded = np.zeros((3, -(-n // _LANES) * _LANES), targets.dtype)
        padded[:, :n] = targets[:3]
        sources = np.concatenate([targets[:3], weights[None].astype(targets.dtype)])
        potential = np.zeros(padded.shape[1], targets.dtype)
        numbers = np.array([self.values["G"], self.values["softening"] ** 2], targets.dtype)
        _kernels(precision)[1](padded, np.ascontiguousarray(sources), potential, n, numbers)
        mass = weights.astype(np.float64)
        self_term = mass / self.values["softening"] if self.values["softening"] > 0 else 0.0
        return float(-0.5 * self.values["G"] * np.sum(mass * (potential[:n].astype(np.float64) - self_term)))

    def prepare(self):
        if self.values["sources"] == "":
            raise UsageError("sources must name a system")


@cache
def _kernels(precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)

    @ti.func
    def inverse_cube(r2):
        return ti.select(r2 > 0.0, 1.0 / (r2 * ti.sqrt(r2)), 0.0)

    @ti.kernel
    def accelerate(T: matrix, M: matrix, out: matrix, n: ti.i32, q: vector):
        G, e2 = q[0], q[1]
        m = M.shape[1]
        ti.loop_config(block_dim=1)
        for b in range((n + _BLOCK - 1) // _BLOCK):
            for s in range(_BLOCK // _LANES):
                i = b * _BLOCK + s * _LANES
                if i < n:
                    X, Y, Z = ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES)
                    A, B, C = ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES)
                    for k in range(_LANES):
                        X[k], Y[k], Z[k] = T[0, i + k], T[1, i + k], T[2, i + k]
                    for c in range((m + _CHUNK - 1) // _CHUNK):
                        P, Q, R = ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES)
                        for j in range(c * _CHUNK, ti.min((c + 1) * _CHUNK, m)):
                            xj, yj, zj, mj = M[0, j], M[1, j], M[2, j], M[3, j]
                            for k in range(_LANES):
                                dx, dy, dz = xj - X[k], yj - Y[k], zj - Z[k]
                                w = mj * inverse_cube(dx * dx + dy * dy + dz * dz + e2)
                                P[k] += w * dx
                                Q[k] += w * dy
                                R[k] += w * dz
                        for k in range(_LANES):
                            A[k] += P[k]
                            B[k] += Q[k]
                            C[k] += R[k]
                    for k in range(_LANES):
                        out[0, i + k], out[1, i + k], out[2, i + k] = G * A[k], G * B[k], G * C[k]

    @ti.kernel
    def potential(T: matrix, M: matrix, out: vector, n: ti.i32, q: vector):
        e2 = q[1]
        m = M.shape[1]
        ti.loop_config(block_dim=1)
        for b in range((n + _BLOCK - 1) // _BLOCK):
            for s in range(_BLOCK // _LANES):
                i = b * _BLOCK + s * _LANES
                if i < n:
                    A = ti.Vector([0.0] * _LANES)
                    for c in range((m + _CHUNK - 1) // _CHUNK):
                        P = ti.Vector([0.0] * _LANES)
                        for j in range(c * _CHUNK, ti.min((c + 1) * _CHUNK, m)):
                            xj, yj, zj, mj = M[0, j], M[1, j], M[2, j], M[3, j]
                            for k in range(_LANES):
                                dx, dy, dz = xj - T[0, i + k], yj - T[1, i + k], zj - T[2, i + k]
                                r2 = dx * dx + dy * dy + dz * dz + e2
                                P[k] += ti.select(r2 > 0.0, mj / ti.sqrt(r2), 0.0)
                        for k in range(_LANES):
                            A[k] += P[k]
                    for k in range(_LANES):
                        out[i + k] = A[k]

    return runtime.kernel(accelerate, precision), runtime.kernel(potential, precision)
