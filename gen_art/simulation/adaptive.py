"""Adaptive steps for scripts: Dormand and Prince's pair, to a tolerance, between the steps of a simulation's clock."""

import math
from dataclasses import dataclass

import numpy as np

from gen_art.errors import UsageError
from gen_art.integrators.dormand_prince import ERROR, STAGES, TIMES, first_step, make_slopes, next_step
from gen_art.interactions.base import ForceRequest
from gen_art.particles.storage import PADDING

__all__ = ["Effort", "adaptive"]


@dataclass(frozen=True)
class Effort:
    """What adaptive steps took: evaluations of all forces, steps accepted and rejected, the shortest and the longest, s."""

    evaluations: int
    accepted: int
    rejected: int
    shortest: float
    longest: float


def adaptive(sim, seconds: float, rtol: float | None = None, atol: float = 1e-12) -> Effort:
    """Advance a simulation by `seconds`, with steps chosen so that each particle's error in each stays within tolerance.

    abs(error of x) <= atol + rtol abs(x), and the same for v, estimated for each particle and each step: errors add up, so
    compare with a smaller rtol to know the whole. The integrators of its systems are not used.

    seconds : a whole number of sim.dt, at whose ends births and what is looked at stand; steps do not reach across them,
    so choose a long dt     rtol : 1e-9, or 1e-5 in f32, when left out; from 10 eps of the precision     atol : m and m/s, >= 0
    Systems that pair forces join share their steps. The same calls give the same bits on any number of threads.
    Raises UsageError for what it cannot take (the ledger, colliders, implicit springs, speed_of_light, emitters fed by
    events), and where the step falls below round-off, naming the particle; the simulation then stands before that dt.
    Source: Dormand & Prince (1980); Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I.
    """
    _check(sim)
    eps = float(np.finfo(sim.dtype).eps)
    rtol = (1e-9 if sim.precision == "f64" else 1e-5) if rtol is None else rtol
    if not (math.isfinite(rtol) and rtol >= 10 * eps):
        raise UsageError(
            f"rtol must be at least {10 * eps:.1e}, ten times the round-off of {sim.precision}, not {rtol}"
        )
    if not (math.isfinite(atol) and atol >= 0):
        raise UsageError(f"atol must be at least 0, not {atol}")
    control = _Control(sim, rtol, atol)
    for _ in range(sim.steps_in(seconds)):
        sim.step_with(control.move)
    return control.effort()


def _check(sim) -> None:
    if sim.keeps_ledger:
        raise UsageError("adaptive steps keep no ledger: leave out ledger=True and compare diagnostics()")
    for name, system in sim.members.items():
        what = None
        if system.composition.colliders:
            what = "colliders, whose impacts are of order 2"
        elif system.scheme.light:
            what = "speed_of_light, which needs a pusher"
        elif any(one.implicit for one in system.interactions):
            what = "implicit springs, which are of order 1"
        elif any(emission.event is not None for emission in system.emitters):
            what = "emitters fed by events, whose children begin at the ends of steps"
        if what:
            raise UsageError(f"adaptive steps cannot take system '{name}': it has {what}")


class _Part:
    """One system within a step of the clock: its state in float64, and the arrays its kernel works on."""

    def __init__(self, sim, name: str):
        self.name, self.stepper, self.system = name, sim.stepper(name), sim.members[name]
        self.state = self.system.state
        self.n = self.state.count
        self.stepper.begin()
        self.rows = self.state.floats[:6].copy()
        self.out = np.zeros((6, self.state.capacity + PADDING), sim.dtype)
        self.y = self.rows[:, : self.n].astype(np.float64)
        self.new = self.y  # the state at the end of the step in hand
        self.slopes = np.zeros((7, 6, self.n))
        self.kernel = make_slopes(self.system.composition, self.stepper.parts[-1], self.state.attributes, sim.precision)

    def stage(self, g: int, h: float) -> np.ndarray:
        """The state of stage g of a step h, which the kernel sees rounded to the precision."""
        y = self.y.copy()
        for weight, slope in zip(STAGES[g], self.slopes):
            y += (h * weight) * slope
        self.rows[:, : self.n] = y
        return y

    def worst(self, values: np.ndarray, scale: np.ndarray) -> tuple[float, int]:
        """The largest over particles of abs(x) and abs(v) of `values` over their scales (2, n), and whose it is."""
        if not self.n:
            return 0.0, 0
        ratio = (_sizes(values) / scale).max(axis=0)
        ratio[np.isnan(ratio)] = np.inf
        at = int(ratio.argmax())
        return float(ratio[at]), at


def _sizes(y: np.ndarray) -> np.ndarray:
    """(2, n): abs(x) and abs(v)."""
    return np.sqrt(np.stack([y[0] ** 2 + y[1] ** 2 + y[2] ** 2, y[3] ** 2 + y[4] ** 2 + y[5] ** 2]))


class _Control:
    """Chooses the steps of one call, by the largest error of any particle: no sum whose order could matter."""

    def __init__(self, sim, rtol: float, atol: float):
        self.sim, self.rtol, self.atol = sim, rtol, atol
        coupled = sim.coupled_names
        self.groups = [coupled] if coupled else []
        self.groups += [[name] for name in sim.members if name not in coupled]
        self.proposed: dict[int, float] = {}  # s, by group
        self.before = dict.fromkeys(range(len(self.groups)), 1e-4)
        self.evaluations = self.rejected = 0
        self.taken: list[float] = []

    def effort(self) -> Effort:
        shortest, longest = (min(self.taken), max(self.taken)) if self.taken else (0.0, 0.0)
        return Effort(self.evaluations, len(self.taken), self.rejected, shortest, longest)

    def move(self, first: int) -> None:
        """One step of the clock; no state is touched before all have come to its end."""
        parts = [[_Part(self.sim, name) for name in group] for group in self.groups]
        for k, group in enumerate(parts):
            if any(part.n for part in group):
                self._cross(k, group, first)
        for part in (part for group in parts for part in group):
            if part.n and part.system.composition.mass_loss_terms:
                self._launch(part, first, 1.0, 1)
            part.state.floats[:6, : part.n] = part.y

    def _cross(self, k: int, parts: list[_Part], first: int) -> None:
        """From tau = 0 to 1 of the clock's step."""
        dt, tau, rejected = self.sim.dt, 0.0, False
        self._slope(parts, first, 0, 0.0)
        h = self.proposed.get(k) or self._first(parts, first)
        while tau < 1.0:
            step = min(h / dt, 1.0 - tau)
            if 1.0 - tau - step < 1e-12:
                step = 1.0 - tau
            error, blame = self._try(parts, first, tau, step)
            factor = next_step(error, self.before[k], rejected)
            if error <= 1.0:
                tau = 1.0 if step == 1.0 - tau else tau + step
                self.taken.append(step * dt)
                self.before[k] = max(error, 1e-4)
                for part in parts:
                    part.y, part.slopes[0] = part.new, part.slopes[6]
                h = max(h, step * dt * factor) if step * dt < h else step * dt * factor
            else:
                self.rejected += 1
                h = step * dt * factor
                if h < 16 * np.finfo(float).eps * max(dt, self.sim.time):
                    raise UsageError(
                        f"the step falls below round-off at {self.sim.time + tau * dt:.9g} s for {blame}: "
                        "does it meet a singularity? A softening takes it away"
                    )
            rejected = error > 1.0
        self.proposed[k] = h

    def _try(self, parts: list[_Part], first: int, tau: float, step: float) -> tuple[float, str]:
        """The largest error of a step over the tolerance, and whose it is; leaves the new states in the parts."""
        for g in range(1, 7):
            for part in parts:
                part.new = part.stage(g, step)
            self._slope(parts, first, g, tau + TIMES[g] * step)
        largest, blame = -1.0, ""
        for part in parts:
            error = np.tensordot(np.array(ERROR) * step, part.slopes, 1)
            scale = self.atol + self.rtol * np.maximum(_sizes(part.y), _sizes(part.new))
            worst, at = part.worst(error, np.maximum(scale, 1e-300))
            if worst > largest and part.n:
                largest, blame = worst, f"particle {part.state.id[at]} of '{part.name}'"
        return largest, blame

    def _first(self, parts: list[_Part], first: int) -> float:
        """A first step, s."""
        dt = self.sim.dt
        scales = [np.maximum(self.atol + self.rtol * _sizes(part.y), 1e-300) for part in parts]
        largest = lambda arrays: max(part.worst(a, s)[0] for part, a, s in zip(parts, arrays, scales))  # noqa: E731
        state, slope = largest([part.y for part in parts]), largest([part.slopes[0] for part in parts])
        guess = min(1.0, 1e-6 if min(state, slope) < 1e-5 else 0.01 * state / slope)
        for part in parts:
            part.rows[:, : part.n] = part.y + guess * part.slopes[0]
        self._slope(parts, first, 1, guess)
        change = largest([part.slopes[1] - part.slopes[0] for part in parts]) / guess
        return min(1.0, first_step(slope, change, guess)) * dt

    def _slope(self, parts: list[_Part], first: int, g: int, tau: float) -> None:
        """Slope g of every part, at the states in their rows."""
        self.evaluations += 1
        for part in parts:
            for k, one in enumerate(part.system.interactions):
                other = next((p for p in parts if p.name == (one.source_system or part.name)), part)
                if part.n:
                    at = 3 * part.stepper.parts[k]
                    request = ForceRequest(
                        part.rows,
                        part.state,
                        part.n,
                        other.rows,
                        other.state,
                        other.n,
                        0.0,
                        self.sim.dt,
                        self.sim.precision,
                    )
                    one.accelerate(request, part.stepper.pair[at : at + 3 * len(one.parts)])
            if part.n:
                self._launch(part, first, tau, 0)
                part.slopes[g] = part.out[:, : part.n]

    def _launch(self, part: _Part, first: int, tau: float, last: int) -> None:
        state = part.state
        part.kernel(
            state.floats, state.birth, state.key, part.stepper.pair, part.rows, part.stepper.numbers, part.out, part.n,
            float(first), self.sim.dt, tau, last,
        )  # fmt: skip
