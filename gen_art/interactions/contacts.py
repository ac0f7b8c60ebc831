"""Contacts between spheres."""

import math
import warnings
from functools import cache

import numpy as np

from gen_art import runtime
from gen_art.errors import UsageError
from gen_art.interactions.base import Interaction, Pull, interaction
from gen_art.interactions.grid import Grid, cell_of, sort_into_grid
from gen_art.registry import param
from gen_art.runtime import ti

__all__ = ["Contacts"]

_BLOCK = 512  # spheres a task
_STEPS = 20  # of a contact whose duration is not given
_FEWEST = 8
_SOFTEST = 1e-3  # restitution that stands for 0


@interaction("contacts")
class Contacts(Interaction):
    """Spheres that touch push each other apart, as damped linear springs that every collision takes the same time on.

    d = r_i + r_j - abs(x_i - x_j) > 0,  m = 1 / (1/m_i + 1/m_j),  w = (v_i - v_j).n,  L = -ln restitution,  T = duration
    F_n = m (pi^2 + L^2) d / T^2 - 2 m L w / T,  F_t <= friction F_n against the sliding
    U = sum m (pi^2 + L^2) d^2 / (2 T^2)

    restitution : speed after over speed before, 0 to 1 (0 counts as 0.001), at any masses and speeds
    friction : Coulomb's coefficient, >= 0; spheres do not spin
    duration : s, of a collision; 20 steps when left out. A sphere sinks in by speed T / pi at most: shorter is harder
    Reciprocal to round-off; conservative but for restitution and friction, which the ledger has as dissipated.
    Neighbours come from a sorted uniform grid as wide as the largest sphere. Source: Cundall & Strack (1979).
    """

    restitution: float = param(0.8, min=0, max=1)
    friction: float = param(0.0, min=0)
    duration: float = param(None, unit="s", min=1e-300, doc="of a collision; 20 steps when left out")

    @property
    def parts(self):
        return ("",) if self.values["restitution"] == 1 and self.values["friction"] == 0 else ("", "loss")

    def join(self, system, dt):
        self._duration = self.values["duration"] or _STEPS * dt
        if self._duration < _FEWEST * dt:
            warnings.warn(
                f"system '{system.name}': contacts of {self._duration:g} s last {self._duration / dt:.3g} steps; "
                f"they need {_FEWEST}: a step of at most {self._duration / _FEWEST:.3g} s",
                stacklevel=2,
            )

    def _numbers(self, span: float, dt: float, dtype) -> np.ndarray:
        """stiffness and damping over the reduced mass, friction, and its rate; damping as its exact decay over the kick."""
        decay = -math.log(max(self.values["restitution"], _SOFTEST)) / self._duration
        rate = -math.expm1(-2 * decay * span) / span if span > 0 else 2 * decay
        square = (math.pi / self._duration) ** 2 + decay**2
        return np.array([square, rate, self.values["friction"], 0.5 / (span or dt)], dtype)

    def _grid(self, rows, floats, n, precision) -> Grid | None:
        radius = float(floats[8, :n].max())
        if radius <= 0:
            return None
        return sort_into_grid(rows, floats, n, 2 * radius * (1 + 1e-6), precision)

    def accelerate(self, pull: Pull, out):
        state, n = pull.state, pull.n
        if (state.floats[6, :n] <= 0).any():
            raise UsageError("contacts: a particle has no mass; give it one, or fix it")
        grid = self._grid(pull.rows, state.floats, n, pull.precision)
        if grid is None:
            out[:, :n] = 0.0
            return
        numbers = self._numbers(pull.span, pull.dt, out.dtype)
        width = np.array([grid.size], out.dtype)
        _kernels(pull.precision)[0](
            grid.sorted, grid.slots, grid.first, width, grid.low, grid.shape, numbers, out, len(self.parts)
        )

    def energy(self, state, slots, precision):
        if not len(slots):
            return 0.0
        rows = np.ascontiguousarray(state.floats[:, slots])
        grid = self._grid(rows, rows, len(slots), precision)
        if grid is None:
            return 0.0
        width, out = np.array([grid.size], rows.dtype), np.zeros((-(-len(slots) // _BLOCK), 1))
        _kernels(precision)[1](
            grid.sorted, grid.first, width, grid.low, grid.shape, self._numbers(0.0, 1.0, rows.dtype), out
        )
        return float(out.sum())


@cache
def _kernels(precision: str):
    real = runtime.DTYPES[precision]
    matrix, whole, vector = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1), ti.types.ndarray(real, 1)

    @ti.func
    def three(P: ti.template(), row: ti.template(), k):
        return ti.Vector([P[k, row], P[k, row + 1], P[k, row + 2]])

    @ti.func
    def run_of(first: ti.template(), shape: ti.template(), x, y, z):
        """Where the three cells about x in the row (y, z) of the grid begin and end; y and z may be one cell beyond it."""
        y = ti.select(y < 0, shape[1] - 1, ti.select(y == shape[1], 0, y))
        z = ti.select(z < 0, shape[2] - 1, ti.select(z == shape[2], 0, z))
        row = shape[0] * (y + shape[1] * z)
        last = shape[0] - 1
        return first[row + ti.min(ti.max(x - 1, 0), last)], first[row + ti.min(ti.max(x + 1, 0), last) + 1]

    @ti.kernel
    def accelerate(
        P: matrix,
        slots: whole,
        first: whole,
        size: vector,
        low: whole,
        shape: whole,
        q: vector,
        out: matrix,
        parts: ti.i32,
    ):
        n = slots.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((n + _BLOCK - 1) // _BLOCK):
            for k in range(b * _BLOCK, ti.min((b + 1) * _BLOCK, n)):
                x, v, r, w = three(P, 0, k), three(P, 3, k), P[k, 6], P[k, 7]
                push, loss = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
                X = cell_of(x[0], size[0]) - low[0]
                Y = (cell_of(x[1], size[0]) - low[1]) % shape[1]
                Z = (cell_of(x[2], size[0]) - low[2]) % shape[2]
                for row in range(9):
                    begin, end = run_of(first, shape, X, Y + row % 3 - 1, Z + row // 3 - 1)
                    for j in range(begin, end):
                        d = x - three(P, 0, j)
                        reach = r + P[j, 6]
                        square = d.dot(d)
                        if (square < reach * reach) & (j != k) & (w + P[j, 7] > 0.0):
                            distance = ti.sqrt(square)
                            normal = d * (1.0 / ti.max(distance, 1e-30))
                            m = 1.0 / (w + P[j, 7])
                            f = m * q[0] * (reach - distance)
                            push += f * normal
                            if parts > 1:
                                u = v - three(P, 3, j)
                                along = u.dot(normal)
                                g = -m * q[1] * along
                                slide = u - along * normal
                                speed = slide.norm()
                                most = ti.min(q[2] * ti.max(f + g, 0.0), m * q[3] * speed)
                                loss += g * normal - (most / ti.max(speed, 1e-30)) * slide
                for c in ti.static(range(3)):
                    out[c, slots[k]] = push[c] * w
                if parts > 1:
                    for c in ti.static(range(3)):
                        out[3 + c, slots[k]] = loss[c] * w

    @ti.kernel
    def potential(
        P: matrix, first: whole, size: vector, low: whole, shape: whole, q: vector, out: ti.types.ndarray(ti.f64, 2)
    ):
        n = P.shape[0]
        ti.loop_config(block_dim=1)
        for b in range(out.shape[0]):
            total = ti.f64(0.0)
            for k in range(b * _BLOCK, ti.min((b + 1) * _BLOCK, n)):
                x, r, w = three(P, 0, k), P[k, 6], P[k, 7]
                X = cell_of(x[0], size[0]) - low[0]
                Y = (cell_of(x[1], size[0]) - low[1]) % shape[1]
                Z = (cell_of(x[2], size[0]) - low[2]) % shape[2]
                for row in range(9):
                    begin, end = run_of(first, shape, X, Y + row % 3 - 1, Z + row // 3 - 1)
                    for j in range(begin, end):
                        d = x - three(P, 0, j)
                        overlap = r + P[j, 6] - d.norm()
                        if (overlap > 0.0) & (j != k) & (w + P[j, 7] > 0.0):
                            total += ti.cast(0.25 * q[0] * overlap * overlap / (w + P[j, 7]), ti.f64)
            out[b, 0] = total

    return runtime.kernel(accelerate, precision), runtime.kernel(potential, precision)
