"""Adaptive time steps for scripts: the Dormand-Prince 5(4) pair with a tolerance, inside the steps of a simulation."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.integrators.dormand_prince import ERROR, STAGES, TIMES, first_step, make_slopes, next_step
from gen_art.interactions.base import ForceRequest
from gen_art.particles.storage import PADDING

if TYPE_CHECKING:
    from gen_art.simulation.simulation import Simulation

__all__ = ["Effort", "adaptive"]


@dataclass(frozen=True)
class Effort:
    """The cost of a call of `adaptive`.

    evaluations : evaluations of all forces
    accepted, rejected : numbers of steps
    shortest, longest : accepted steps, s
    """

    evaluations: int
    accepted: int
    rejected: int
    shortest: float
    longest: float


def adaptive(sim: "Simulation", seconds: float, rtol: float | None = None, atol: float = 1e-12) -> Effort:
    """Advance a simulation by `seconds` with steps that keep every particle's error within a tolerance.

    abs(error of x) <= atol + rtol abs(x), and the same for v, estimated for each particle and each step. Errors add up over
    the steps: to know the total, compare with a smaller rtol. The integrators of the systems are not used.

    seconds : a whole number of sim.dt. Births happen, and the state can be read, at the ends of dt only; an adaptive step
    does not cross such an end, so choose a long dt
    rtol : at least 10 eps of the precision; 1e-9, or 1e-5 in f32, when left out
    atol : m and m/s, >= 0
    Systems that are coupled by forces between particles share their steps. The same calls give the same bits on any number
    of threads.
    Raises UsageError for a simulation with a ledger, colliders, implicit springs, speed_of_light or emitters fed by events,
    and when the step falls below round-off, naming the particle; the simulation is then in its state before that dt.
    Source: Dormand & Prince (1980); Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I.
    """
    _check(sim)
    atol = arguments.number("atol", atol, "m and m/s", low=0.0)
    if rtol is not None:
        rtol = arguments.number("rtol", rtol)
    eps = float(np.finfo(sim.dtype).eps)
    rtol = (1e-9 if sim.precision == "f64" else 1e-5) if rtol is None else rtol
    if rtol < 10 * eps:
        raise UsageError(
            f"rtol must be at least {10 * eps:.1e}, ten times the round-off of {sim.precision}, not {rtol}"
        )
    control = _Control(sim, rtol, atol)
    for _ in range(sim.steps_in(seconds)):
        sim.step_with(control.move)
    return control.effort()


def _check(sim) -> None:
    if not hasattr(sim, "step_with"):
        raise UsageError(f"adaptive advances a ga.Simulation, not {arguments.shown(sim)}")
    for name, system in sim.members.items():
        if system.entries:
            raise UsageError(
                f"adaptive steps keep no ledger, and system '{name}' keeps its particles' shares of {system.entries[0]}: leave "
                "that out of its look and of `booked`"
            )
    if sim.keeps_ledger:
        raise UsageError("adaptive steps keep no ledger: leave out ledger=True and compare diagnostics()")
    for name, system in sim.members.items():
        obstacle = None
        if system.composition.colliders:
            obstacle = "colliders, whose impacts are of order 2"
        elif system.composition.noises:
            obstacle = f"{system.composition.noises[0].name}, whose noise is drawn once a step of the clock"
        elif system.scheme.light:
            obstacle = "speed_of_light, which needs a pusher"
        elif any(interaction.implicit for interaction in system.interactions):
            obstacle = "implicit springs, which are of order 1"
        elif any(emission.event is not None for emission in system.emitters):
            obstacle = "emitters fed by events, whose children begin at the ends of steps"
        if obstacle:
            raise UsageError(f"adaptive steps cannot take system '{name}': it has {obstacle}")


class _Part:
    """One system during a step of the clock: its state in float64, and the arrays of its kernel."""

    def __init__(self, sim, name: str):
        self.name, self.stepper, self.system = name, sim.stepper(name), sim.members[name]
        self.state = self.system.state
        self.n = self.state.count
        self.stepper.begin()
        self.rows = self.state.floats[:6].copy()
        self.out = np.zeros((6, self.state.capacity + PADDING), sim.dtype)
        self.y = self.rows[:, : self.n].astype(np.float64)
        self.new = self.y  # the state at the end of the step that is being tried
        self.slopes = np.zeros((7, 6, self.n))
        pairs = self.stepper.part_offsets[-1]
        self.kernel = make_slopes(self.system.composition, pairs, self.state.attributes, sim.precision)

    def stage(self, g: int, h: float) -> np.ndarray:
        """The state at stage g of a step h; the kernel gets it rounded to the simulation's precision."""
        y = self.y.copy()
        for weight, slope in zip(STAGES[g], self.slopes):
            y += (h * weight) * slope
        self.rows[:, : self.n] = y
        return y

    def worst(self, values: np.ndarray, scale: np.ndarray) -> tuple[float, int]:
        """(largest abs(x) or abs(v) of `values` relative to its scale (2, n), index of its particle)."""
        if not self.n:
            return 0.0, 0
        ratio = (_norms(values) / scale).max(axis=0)
        ratio[np.isnan(ratio)] = np.inf
        at = int(ratio.argmax())
        return float(ratio[at]), at


def _norms(y: np.ndarray) -> np.ndarray:
    """(2, n): abs(x) and abs(v)."""
    return np.sqrt(np.stack([y[0] ** 2 + y[1] ** 2 + y[2] ** 2, y[3] ** 2 + y[4] ** 2 + y[5] ** 2]))


class _Control:
    """Chooses the steps of one call by the largest error of any particle, which does not depend on an order of summation."""

    def __init__(self, sim, rtol: float, atol: float):
        self.sim, self.rtol, self.atol = sim, rtol, atol
        coupled = sim.coupled_names
        self.groups = [coupled] if coupled else []
        self.groups += [[name] for name in sim.members if name not in coupled]
        self.proposed: dict[int, float] = {}  # next step by group, s
        self.last_error = dict.fromkeys(range(len(self.groups)), 1e-4)  # by group, relative to the tolerance
        self.evaluations = self.rejected = 0
        self.accepted_steps: list[float] = []

    def effort(self) -> Effort:
        steps = self.accepted_steps
        shortest, longest = (min(steps), max(steps)) if steps else (0.0, 0.0)
        return Effort(self.evaluations, len(steps), self.rejected, shortest, longest)

    def move(self, first: int) -> None:
        """One step of the clock. The simulation's state changes only after all groups have reached the end of the step."""
        parts = [[_Part(self.sim, name) for name in group] for group in self.groups]
        for k, group in enumerate(parts):
            if any(part.n for part in group):
                self._advance_group(k, group, first)
        for part in (part for group in parts for part in group):
            if part.n and part.system.composition.mass_loss_terms:
                self._launch(part, first, 1.0, 1)
            part.state.floats[:6, : part.n] = part.y

    def _advance_group(self, k: int, parts: list[_Part], first: int) -> None:
        """Advance group k from tau = 0 to 1 of the clock's step."""
        dt, tau, rejected = self.sim.dt, 0.0, False
        self._slope(parts, first, 0, 0.0)
        h = self.proposed.get(k) or self._first_step(parts, first)
        while tau < 1.0:
            step = min(h / dt, 1.0 - tau)
            if 1.0 - tau - step < 1e-12:
                step = 1.0 - tau
            error, worst_particle = self._try(parts, first, tau, step)
            factor = next_step(error, self.last_error[k], rejected)
            if error <= 1.0:
                tau = 1.0 if step == 1.0 - tau else tau + step
                self.accepted_steps.append(step * dt)
                self.last_error[k] = max(error, 1e-4)
                for part in parts:
                    part.y, part.slopes[0] = part.new, part.slopes[6]
                h = max(h, step * dt * factor) if step * dt < h else step * dt * factor
            else:
                self.rejected += 1
                h = step * dt * factor
                if h < 16 * np.finfo(float).eps * max(dt, self.sim.time):
                    raise UsageError(
                        f"the step falls below round-off at {self.sim.time + tau * dt:.9g} s for {worst_particle}: "
                        "is it at a singularity? A softening removes it"
                    )
            rejected = error > 1.0
        self.proposed[k] = h

    def _try(self, parts: list[_Part], first: int, tau: float, step: float) -> tuple[float, str]:
        """(largest error of a step relative to the tolerance, its particle). Stores the new states in the parts."""
        for g in range(1, 7):
            for part in parts:
                part.new = part.stage(g, step)
            self._slope(parts, first, g, tau + TIMES[g] * step)
        largest, worst_particle = -1.0, ""
        for part in parts:
            error = np.tensordot(np.array(ERROR) * step, part.slopes, 1)
            scale = self.atol + self.rtol * np.maximum(_norms(part.y), _norms(part.new))
            worst, at = part.worst(error, np.maximum(scale, 1e-300))
            if worst > largest and part.n:
                largest, worst_particle = worst, f"particle {part.state.id[at]} of '{part.name}'"
        return largest, worst_particle

    def _first_step(self, parts: list[_Part], first: int) -> float:
        """The length of the first step, s."""
        dt = self.sim.dt
        scales = [np.maximum(self.atol + self.rtol * _norms(part.y), 1e-300) for part in parts]
        largest = lambda arrays: max(part.worst(a, s)[0] for part, a, s in zip(parts, arrays, scales))  # noqa: E731
        state, slope = largest([part.y for part in parts]), largest([part.slopes[0] for part in parts])
        guess = min(1.0, 1e-6 if min(state, slope) < 1e-5 else 0.01 * state / slope)
        for part in parts:
            part.rows[:, : part.n] = part.y + guess * part.slopes[0]
        self._slope(parts, first, 1, guess)
        change = largest([part.slopes[1] - part.slopes[0] for part in parts]) / guess
        return min(1.0, first_step(slope, change, guess)) * dt

    def _slope(self, parts: list[_Part], first: int, g: int, tau: float) -> None:
        """Compute slope g of every part at the states in their rows."""
        self.evaluations += 1
        for part in parts:
            for k, interaction in enumerate(part.system.interactions):
                other = next((p for p in parts if p.name == (interaction.source_system or part.name)), part)
                if part.n:
                    at = 3 * part.stepper.part_offsets[k]
                    request = ForceRequest(
                        part.rows, part.state, part.n, other.rows, other.state, other.n, 0.0, self.sim.dt, self.sim.precision,
                        first * self.sim.dt + tau,
                    )  # fmt: skip
                    interaction.accelerate(request, part.stepper.pair[at : at + 3 * len(interaction.parts)])
            if part.n:
                self._launch(part, first, tau, 0)
                part.slopes[g] = part.out[:, : part.n]

    def _launch(self, part: _Part, first: int, tau: float, last: int) -> None:
        state = part.state
        part.kernel(
            state.floats, state.birth, state.key, part.stepper.pair, part.rows, part.stepper.numbers, part.out, part.n,
            float(first), self.sim.dt, tau, last, state.floats.ctypes.data, state.birth.ctypes.data, part.rows.ctypes.data,
            part.out.ctypes.data,
        )  # fmt: skip
