"""Contacts between spheres; the kernels are in sphere_contact_kernels.py."""

import math
from dataclasses import replace

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import ForcePart, ForceRequest, Interaction, interaction
from gen_art.interactions.neighbour_grid import Grid, sort_into_grid
from gen_art.interactions.sphere_contact_kernels import BLOCK, RESULT, contact_kernels, overlap_kernel
from gen_art.interactions.sphere_walls import SphereWalls, is_wall
from gen_art.maths.array_functions import expm1, log
from gen_art.particles.rows import MASS, POSITION, RADIUS, VELOCITY
from gen_art.registry import param

__all__ = ["Contacts"]

_DEFAULT_STEPS = 20  # the duration of a contact when it is not given
_MIN_STEPS = 8
_ENERGY_ERROR = 0.01 / 300  # of a collision: 1 % in 300
_DEEP = 0.02  # relative to a sphere's radius: deeper overlaps at the start give a warning
_DEEPEST = 0.9  # overlap by the fastest over the smallest radius: two that meet head-on overlap by twice as much
_MOST = 0.99  # of the spheres are no faster than the one that is judged; of fewer than a hundred, all
_MIN_RESTITUTION = 1e-3  # used for 0


@interaction("contacts")
class Contacts(Interaction):
    """Spheres that touch repel each other as damped linear springs, so that every collision has the same duration.

    d = r_i + r_j - abs(x_i - x_j) > 0,  m = 1 / (1/m_i + 1/m_j),  w = (v_i - v_j).n,  L = -ln restitution,  T = duration
    F_n = m (pi^2 + L^2) d / T^2 - 2 m L w / T,  F_t <= friction F_n against the sliding
    U = sum m (pi^2 + L^2) d^2 / (2 T^2)

    restitution : speed after over speed before, 0 to 1 (0 counts as 0.001), at any masses and speeds
    friction : Coulomb's coefficient, >= 0
    rolling : with spin, torque rolling R F_n against the rolling, 1/R = 1/r_i + 1/r_j; >= 0, and above 0 spheres spin
    spin : spheres rotate (moment of inertia 2/5 m r^2): friction acts where they touch, and its torque changes the attributes
        spin_x, spin_y, spin_z, 1/s, which particles may be born with and which are 0 otherwise
    duration : s, of a collision; 20 steps when left out. Spheres overlap by speed T / pi at most: shorter is harder
    Colliders at rest that bounce press spheres by the same law, with m the sphere's mass and with their own restitution and
    kinetic friction, so that a sphere between a wall and another keeps its energy. Others strike spheres at an instant.
    Diagnostics and the ledger do not include spin: energy that friction turns into rotation counts as dissipated.
    Reciprocal to round-off; conservative except for restitution and friction, which the ledger records as dissipated.
    Neighbours come from a sorted uniform grid with cells as wide as the largest sphere. In a periodic box spheres touch across
    its sides, and it must be three of the largest spheres long. Source: Cundall & Strack (1979).
    """

    restitution: float = param(0.8, min=0, max=1)
    friction: float = param(0.0, min=0)
    rolling: float = param(0.0, min=0)
    spin: bool = param(False, doc="spheres rotate; always on where rolling is above 0")
    duration: float = param(None, unit="s", min=1e-300, doc="of a collision; 20 steps when left out")
    periodic = True

    def prepare(self):
        self._walls: SphereWalls | None = None

    @property
    def parts(self):
        return self._own_parts + (self._walls.parts if self._walls else ())

    @property
    def _own_parts(self) -> tuple[ForcePart, ...]:
        """The parts of the forces between spheres."""
        lossless = self.values["restitution"] == 1 and self.values["friction"] == 0 and not self.spins
        return (ForcePart(),) if lossless else (ForcePart(), ForcePart(dissipates=True))

    @property
    def spins(self) -> bool:
        return self.values["spin"] or self.values["rolling"] > 0

    @property
    def attributes(self):
        return ("spin_x", "spin_y", "spin_z") if self.spins else ()

    def take_colliders(self, colliders, names):
        walls = [one for one in colliders if is_wall(one)]
        self._walls = SphereWalls(walls, [names[id(one)] for one in walls]) if walls else None
        return [one for one in colliders if not is_wall(one)]

    def check_masses(self, system, ids, masses):
        if (masses <= 0).any():
            raise UsageError("contacts: a particle has no mass; give it one, or fix it")

    def check(self, system):
        self.check_masses(system, np.zeros(1), np.array([system.least_mass]))
        _least_steps(system)
        if self.spins and system.scheme.name not in ("semi_implicit_euler", "position_verlet"):
            raise UsageError(
                f"contacts: spin is advanced once a step; give '{system.name}' semi_implicit_euler or position_verlet, "
                f"not {system.scheme.name}"
            )

    def attach(self, system, dt):
        self._duration = self.values["duration"] or _DEFAULT_STEPS * dt
        self._steps = _least_steps(system)
        sentences = []
        if self._duration < self._steps * dt:
            sentences.append(
                f"contacts of {self._duration:g} s last {self._duration / dt:.3g} steps; {system.scheme.name} needs "
                f"{self._steps}: use a step of at most {self._duration / self._steps:.3g} s"
            )
        return [*sentences, *self._overlap_advice(system.state)]

    def overlaps(self, state, precision: str) -> tuple[np.ndarray, np.ndarray]:
        """The deepest overlap of each sphere, (n,) m, and the slot (n,) of the other; its own slot if there is none."""
        n = state.count
        depth, other = np.zeros(n, state.floats.dtype), np.arange(n, dtype=np.int32)
        grid = self._grid(state.floats, state.floats, n, precision) if n else None
        if grid is not None:
            numbers = self._numbers(0.0, 1.0, grid, state.floats.dtype)
            overlap_kernel(precision, self.box is not None)(
                grid.sorted, grid.slots, grid.first, grid.low, grid.shape, numbers, grid.size, depth, other
            )
        return depth, other

    def advice(self, state):
        """Spheres that are too fast for the duration: they overlap by up to v T / pi, and pass through each other."""
        n = state.count
        if not n:
            return []
        velocity = state.floats[VELOCITY, :n].astype(np.float64)
        if not self._walls:  # spheres that fly together do not meet
            velocity = velocity - velocity.mean(axis=1, keepdims=True)
        speeds, smallest = np.sqrt((velocity**2).sum(0)), float(state.floats[RADIUS, :n].min())
        fastest = int(np.argsort(speeds, kind="stable")[math.ceil(_MOST * (n - 1))])
        longest = _DEEPEST * smallest * math.pi / max(float(speeds[fastest]), 1e-300)
        if self._duration <= longest or smallest <= 0:
            return []
        better = 0.95 * longest  # rounding to two digits must not make it too long
        return [
            f"contacts of {self._duration:g} s are too soft for particle {state.id[fastest]}, which has {speeds[fastest]:.3g} "
            f"m/s: spheres may pass through each other; use a duration of at most {better:.2g} s, and a step of at most "
            f"{0.95 * better / self._steps:.2g} s"
        ]

    def _overlap_advice(self, state) -> list[str]:
        """Spheres that overlap at the start, because they are thrown apart; the sentence names the deepest pair."""
        if not state.count:
            return []
        depth, other = self.overlaps(state, "f64" if state.floats.dtype == np.float64 else "f32")
        i = int(np.argmax(depth))
        if depth[i] <= _DEEP * float(state.floats[RADIUS, i]):
            return []
        a, b = sorted((int(state.id[i]), int(state.id[other[i]])))
        return [
            f"{(depth > 0).sum()} spheres overlap at the start, particles {a} and {b} the most, by {depth[i]:.3g} m: they will "
            f"be thrown apart at up to {depth[i] * math.pi / self._duration:.3g} m/s"
        ]

    def _numbers(self, span: float, dt: float, grid: Grid, dtype) -> np.ndarray:
        """The kernels' parameters; the damping is averaged over the kick, so that its decay is exact."""
        stiffness, damping = self._response(self.values["restitution"], span)
        rate = _sliding_rate(span, dt)
        friction, rolling = self.values["friction"], self.values["rolling"]
        return np.array([stiffness, damping, friction, rate, rolling, *grid.frame], dtype)

    def _response(self, restitution: float, span: float) -> tuple[float, float]:
        """Stiffness, 1/s^2, and damping, 1/s, over the reduced mass, for a kick of `span`, s."""
        decay = -float(log(max(restitution, _MIN_RESTITUTION))) / self._duration
        damping = -float(expm1(-2 * decay * span)) / span if span > 0 else 2 * decay
        return (math.pi / self._duration) ** 2 + decay**2, damping

    def problem_in(self, box, largest_radius):
        return box.problem_of_reach("contacts of the largest spheres", 2 * largest_radius)

    def _grid(self, rows, floats, n, precision) -> Grid | None:
        radius = float(floats[RADIUS, :n].max())
        if radius <= 0:
            return None
        # spheres that are born may be larger than those of the start
        if self.box is not None and (problem := self.problem_in(self.box, radius)) is not None:
            raise UsageError(problem)
        return sort_into_grid(rows, floats, n, 2 * radius * (1 + 1e-6), precision, self.box)

    def _in_box(self, request: ForceRequest) -> ForceRequest:
        """The request with its positions in the periodic box, if there is one: within a step they go on beyond the sides."""
        if self.box is None:
            return request
        rows = request.rows[:6].copy()
        self.box.wrap(rows[POSITION, : request.n])
        return replace(request, rows=rows)

    def accelerate(self, request: ForceRequest, out):
        state, n = request.state, request.n
        if (state.floats[MASS, :n] <= 0).any():
            raise UsageError("contacts: a particle has no mass; give it one, or fix it")
        request = self._in_box(request)
        grid = self._grid(request.rows, state.floats, n, request.precision)
        if grid is None:
            out[:, :n] = 0.0
            return
        numbers = self._numbers(request.span, request.dt, grid, out.dtype)
        angular = np.zeros((3, n if self.spins else 1), out.dtype)
        first = state.channels["spin_x"] if self.spins else 0
        accelerate, unsort, _ = contact_kernels(request.precision, self.spins, self.box is not None)
        result = np.empty(RESULT * n, out.dtype)
        parts = len(self._own_parts)
        accelerate(
            grid.sorted, grid.slots, grid.first, grid.low, grid.shape, numbers, grid.size, state.floats, first, result, angular,
            parts,
        )  # fmt: skip
        unsort(result, grid.rank, out, 3 * parts)
        if self._walls:
            self._walls.accelerate(
                request, lambda e: self._response(e, request.span), _sliding_rate(request.span, request.dt),
                self.values["rolling"], self.spins, first, out[3 * parts :], angular,
            )  # fmt: skip
        if self.spins:
            state.floats[first : first + 3, :n] += request.span * angular

    def energy(self, state, slots, precision):
        if not len(slots):
            return 0.0
        rows = np.ascontiguousarray(state.floats[:, slots])
        grid = self._grid(rows, rows, len(slots), precision)
        if grid is None:
            return 0.0
        out, numbers = np.zeros((-(-len(slots) // BLOCK), 1)), self._numbers(0.0, 1.0, grid, rows.dtype)
        _, _, potential = contact_kernels(precision, False, self.box is not None)
        potential(grid.sorted, grid.first, grid.low, grid.shape, numbers, grid.size, out)
        walls = self._walls.energy(rows, lambda e: self._response(e, 0.0), precision) if self._walls else 0.0
        return float(out.sum()) + walls


def _least_steps(system) -> int:
    """The steps of a collision that a system's scheme needs. Raises UsageError for a scheme that gains energy in each."""
    power, coefficient = system.scheme.energy_error
    if coefficient > 0:
        raise UsageError(
            f"contacts: {system.scheme.name} gains energy in every collision; give '{system.name}' leapfrog or "
            "semi_implicit_euler"
        )
    if not power:
        return _MIN_STEPS
    # a collision of n steps is half an oscillation, w dt = pi / n: it loses n c (pi / n)^k
    return max(_MIN_STEPS, math.ceil((-coefficient * math.pi**power / _ENERGY_ERROR) ** (1 / (power - 1))))


def _sliding_rate(span: float, dt: float) -> float:
    """The largest rate, 1/s, at which friction may stop a slide in a kick of `span`, s: half of it, as others act too."""
    return 0.5 / (span or dt)
