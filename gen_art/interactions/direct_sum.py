"""Sums of a central force law over all pairs: the base of mutual gravity, Coulomb's law and the power laws.

Whole exponents are summed by whole vectors (pair_sums.py). Others, and the potential of exponent -1, need logarithms, which
Taichi cannot take of whole vectors: in their kernels the targets are lanes, and the sources the inner run-time loop.
Inverse squares of many particles may be summed by a tree instead.

The one-letter names in kernels are in docs/glossary.md.
"""

import math
from functools import cache
from typing import ClassVar

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.interactions.base import ForceRequest, Interaction
from gen_art.interactions.pair_sums import CHUNK, LANES, field_kernel, potential_kernel
from gen_art.maths.elementary import log, power
from gen_art.particles.rows import MASS, POSITION

__all__ = ["DirectSum"]

_BLOCK = 256  # targets per task
_TREE_PAIRS = 14_000**2  # `auto` uses the tree for more pairs


class DirectSum(Interaction):
    """a_i = -k c_i / m_i sum_j c_j s^(n-1) (x_i - x_j), with c the mass or the charge; each pair's potential is c_i c_j phi(s).

    A subclass defines `law`, which is (k, n, softening), and `weight`, the name of c.
    """

    weight: ClassVar[str] = "mass"
    smooth = True

    @property
    def law(self) -> tuple[float, float, float]:
        raise NotImplementedError

    @property
    def amount(self) -> str:
        """The name of c, the quantity that the forces are proportional to."""
        return self.weight

    def prepare(self):
        if self.values.get("sources") == "":
            raise UsageError("sources must name a system")

    def by_tree(self, pairs: int) -> bool:
        """Whether this number of pairs is summed by the tree."""
        method = self.values.get("method", "direct")
        return method == "tree" or (method == "auto" and pairs > _TREE_PAIRS)

    def attach(self, system, dt):
        state = system.state
        pair = self._coincident(state, np.arange(state.count))
        if pair is None:
            return []
        a, b = sorted(int(state.id[slot]) for slot in pair)
        return [
            f"particles {a} and {b} are at the same place, where {self.name} has no direction and an infinite energy: move one "
            "of them, or give it a softening"
        ]

    def _coincident(self, state, slots: np.ndarray) -> tuple[int, int] | None:
        """Two of the slots whose particles are at the same place and have an infinite energy together; None if there are none."""
        _, n, softening = self.law
        if softening != 0 or n > -1 or self.source_system is not None:
            return None
        acting = slots[state.floats[state.channels[self.amount], slots] != 0]
        order = acting[np.lexsort(state.floats[POSITION][:, acting])]
        x = state.floats[POSITION][:, order]
        same = np.flatnonzero((x[:, 1:] == x[:, :-1]).all(axis=0))
        return (int(order[same[0]]), int(order[same[0] + 1])) if len(same) else None

    def accelerate(self, request: ForceRequest, out: np.ndarray) -> None:
        k, n, softening = self.law
        amounts = request.sources.floats[request.sources.channels[self.amount], : request.m]
        if self.by_tree(request.n * request.m):
            sources = None if request.rows is request.source_rows else request.source_rows[:3, : request.m]
            out[:, : request.n] = k * self._tree(request.rows[:3, : request.n], sources, amounts, request.precision)
            self._to_accelerations(request, out)
            return
        sources = np.ascontiguousarray(np.concatenate([request.source_rows[:3, : request.m], amounts[None]]))
        whole = float(n).is_integer()
        numbers = np.array([k, softening**2, n], out.dtype)
        kernel = field_kernel(int(n), request.precision) if whole else _acceleration_kernel(request.precision)
        kernel(request.rows, sources, out, request.n, numbers)
        self._to_accelerations(request, out)

    def _tree(self, targets, sources, amounts, precision, valued=False):
        from gen_art.interactions.tree_sum import sum_by_tree

        softening, theta, order = (self.values[key] for key in ("softening", "theta", "order"))
        return sum_by_tree(targets, sources, amounts, softening, theta, order, precision, valued)

    def _to_accelerations(self, request: ForceRequest, out: np.ndarray) -> None:
        """Multiply the field in `out` by charge over mass, where it does not act on mass."""
        if self.amount != "mass":
            state, n = request.state, request.n
            mass, charge = state.floats[MASS, :n], state.floats[state.channels[self.amount], :n]
            if ((mass == 0) & (charge != 0)).any():
                raise UsageError(
                    f"{self.name}: a particle with a charge and no mass has no acceleration; give it a mass"
                )
            out[:, :n] *= np.divide(charge, mass, out=np.zeros_like(charge), where=mass > 0)

    def energy(self, state, slots, precision):
        count = len(slots)
        if self.source_system is not None or count == 0:
            return 0.0
        k, n, softening = self.law
        dtype = state.floats.dtype
        amounts = state.floats[state.channels[self.amount], slots]
        if (pair := self._coincident(state, slots)) is not None:
            a, b = state.floats[state.channels[self.amount], list(pair)]
            return -math.inf if k * a * b > 0 else math.inf
        if self.by_tree(count * count):
            field = self._tree(state.floats[POSITION, slots], None, amounts, precision, valued=True)
            return float(-0.5 * k * np.sum(amounts.astype(np.float64) * field))
        positions = state.floats[POSITION, slots]
        sources = np.ascontiguousarray(np.concatenate([positions, amounts[None]]))
        targets = np.zeros((3, -(-count // LANES) * LANES), dtype)
        targets[:, :count] = positions
        potential = np.zeros(targets.shape[1], dtype)
        if float(n).is_integer() and n != -1:
            numbers = np.array([1 / (n + 1), softening**2], dtype)
            potential_kernel(int(n), precision)(targets, sources, potential, count, numbers)
        else:
            numbers = np.array([k, softening**2, n], dtype)
            _potential_kernel(n == -1, precision)(targets, sources, potential, count, numbers)
        c = amounts.astype(np.float64)
        self_potential = 0.0 if softening == 0 else -c / softening if n == -2 else c * _phi(softening, n)
        return float(0.5 * k * np.sum(c * (potential[:count].astype(np.float64) - self_potential)))


def _phi(s: float, n: float) -> float:
    """The potential whose force is -s^n."""
    return float(np.log(s)) if n == -1 else s ** (n + 1) / (n + 1)


@cache
def _acceleration_kernel(precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)

    @ti.kernel
    def accelerate(T: matrix, M: matrix, out: matrix, n: ti.i32, q: vector):
        k0, e2, exponent = q[0], q[1], q[2]
        m = M.shape[1]
        ti.loop_config(block_dim=1)
        for b in range((n + _BLOCK - 1) // _BLOCK):
            for s in range(_BLOCK // LANES):
                i = b * _BLOCK + s * LANES
                if i < n:
                    X, Y, Z = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                    A, B, C = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                    for k in range(LANES):
                        X[k], Y[k], Z[k] = T[0, i + k], T[1, i + k], T[2, i + k]
                    for c in range((m + CHUNK - 1) // CHUNK):
                        P, Q, R = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                        for j in range(c * CHUNK, ti.min((c + 1) * CHUNK, m)):
                            xj, yj, zj, mj = M[0, j], M[1, j], M[2, j], M[3, j]
                            for k in range(LANES):
                                dx, dy, dz = xj - X[k], yj - Y[k], zj - Z[k]
                                w = mj * power(dx * dx + dy * dy + dz * dz + e2, 0.5 * (exponent - 1.0))
                                P[k] += w * dx
                                Q[k] += w * dy
                                R[k] += w * dz
                        for k in range(LANES):
                            A[k] += P[k]
                            B[k] += Q[k]
                            C[k] += R[k]
                    for k in range(LANES):
                        out[0, i + k], out[1, i + k], out[2, i + k] = k0 * A[k], k0 * B[k], k0 * C[k]

    return runtime.kernel(accelerate, precision)


@cache
def _potential_kernel(logarithm: bool, precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)

    @ti.func
    def phi(r2, n):
        """The potential of a unit source, from r2 = s^2; 0 at s = 0, a particle's own position without softening."""
        f = r2 * 0.0
        if ti.static(logarithm):
            f = 0.5 * log(ti.select(r2 > 0.0, r2, 1.0))
        else:
            f = power(r2, 0.5 * (n + 1.0)) / (n + 1.0)
        return ti.select(r2 > 0.0, f, 0.0)

    @ti.kernel
    def potential(T: matrix, M: matrix, out: vector, n: ti.i32, q: vector):
        e2, exponent = q[1], q[2]
        m = M.shape[1]
        ti.loop_config(block_dim=1)
        for b in range((n + _BLOCK - 1) // _BLOCK):
            for s in range(_BLOCK // LANES):
                i = b * _BLOCK + s * LANES
                if i < n:
                    A = ti.Vector([0.0] * LANES)
                    for c in range((m + CHUNK - 1) // CHUNK):
                        P = ti.Vector([0.0] * LANES)
                        for j in range(c * CHUNK, ti.min((c + 1) * CHUNK, m)):
                            xj, yj, zj, mj = M[0, j], M[1, j], M[2, j], M[3, j]
                            for k in range(LANES):
                                dx, dy, dz = xj - T[0, i + k], yj - T[1, i + k], zj - T[2, i + k]
                                P[k] += mj * phi(dx * dx + dy * dy + dz * dz + e2, exponent)
                        for k in range(LANES):
                            A[k] += P[k]
                    for k in range(LANES):
                        out[i + k] = A[k]

    return runtime.kernel(potential, precision)
