"""The systems that forces between particles join, advanced together stage by stage."""

from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import Pull, Turn
from gen_art.registry import suggest
from gen_art.simulation.stepper import Stepper

if TYPE_CHECKING:
    from gen_art.simulation.ledger import Bookkeeper

__all__ = ["Joined"]


class Joined:
    """Those of the systems that forces between particles act on, or that act."""

    def __init__(self, steppers: dict[str, Stepper], names: set[str], dt: float, precision: str):
        self.steppers, self.dt, self.precision = {name: steppers[name] for name in sorted(names)}, dt, precision
        self.books: Bookkeeper | None = None
        self._known_at = -1  # the step at whose start the accelerations between particles are known

    @staticmethod
    def names(members: dict) -> set[str]:
        """Of which ParticleSystems by name. Raises UsageError where a force asks for what is not there."""
        joined = {name for name, system in members.items() if system.interactions}
        for name in sorted(joined):
            for one in members[name].interactions:
                other = one.source_system
                if other is None:
                    continue
                if other not in members:
                    raise UsageError(
                        f"system '{name}' takes '{other}' as sources: no such system{suggest(other, members)}"
                    )
                if members[other].scheme.stages != members[name].scheme.stages:
                    raise UsageError(
                        f"systems '{name}' and '{other}' are joined by a force: give both the same integrator"
                    )
                joined = joined | {other}
        return joined

    def forget(self) -> None:
        """Particles came, went, or were moved: what they do to each other is to be found anew."""
        self._known_at = -1

    def step(self, first: int) -> None:
        """One step, stage by stage: pair accelerations at each stage's positions, then the fused kernel's stage."""
        joined = self.steppers
        for stepper in joined.values():
            stepper.begin()
        schemes = [stepper.system.scheme for stepper in joined.values()]
        if any(s.first_drift for s in schemes):
            self.forget()
            for stepper in joined.values():
                stepper.stage(first, self.dt, -1, 0)
        for g in range(max(len(s.stages) for s in schemes)):
            active = {name: stepper for name, stepper in joined.items() if g < len(stepper.system.scheme.stages)}
            if g > 0 or self._known_at != first:
                for name, stepper in active.items():
                    self._pull(stepper, g)
            for name, stepper in active.items():
                if any(one.implicit for one in stepper.system.interactions):
                    self._implicit_stage(name, stepper, first, g)
                else:
                    stepper.stage(first, self.dt, g, g + 1)
        # where nothing moves after the last kick, its pair accelerations serve the next step's first
        still = all(s.kind == "splitting" and s.stages[-1][2] == 0 for s in schemes)
        still = still and not any(stepper.system.composition.colliders for stepper in joined.values())
        self._known_at = first + 1 if still else -1
        for name, stepper in joined.items():
            for one in stepper.system.interactions:
                energy = one.let_go(stepper.system.state, self.precision) if one.tears else None
                if energy is not None:
                    self.forget()
                    if self.books:
                        self.books.released(name, one, energy)

    def _implicit_stage(self, name: str, stepper: Stepper, first: int, g: int) -> None:
        """Kick, the implicit interactions' own change of velocities, and the drift: theirs, if one carries the particles."""
        system, state = stepper.system, stepper.system.state
        kick, time, drift = system.scheme.stages[g]
        # two stages, so that walls and engines act in the drift alone
        parts = np.array([0.0, kick, time, 0.0, 0.0, time, drift, 0.0], state.floats.dtype)
        old = state.floats[3:6, : state.count].copy()
        turn = Turn(old, self.dt * kick, self.dt * drift, first * self.dt, self.dt, self.precision, bool(self.books))
        stepper.stage(first, self.dt, 0, 1, parts)
        carrier = None
        for one in system.interactions:
            if one.implicit and state.count:
                before = state.floats[3:6, : state.count].copy() if self.books else None
                one.solve(state, turn)
                carrier = one if one.carries else carrier
                if self.books and before is not None:
                    self.books.solved(name, one, state, before, turn)
        if carrier is None:
            stepper.stage(first, self.dt, 1, 2, parts)
        elif drift > 0:
            carrier.drift(state, turn)

    def _pull(self, stepper: Stepper, g: int) -> None:
        system = stepper.system
        for k, one in enumerate(system.interactions):
            if one.implicit:
                continue
            other = self.steppers[one.source_system or system.name]
            if system.state.count:
                pull = Pull(
                    stepper.stage_rows(g), system.state, system.state.count, other.stage_rows(g), other.system.state,
                    other.system.state.count, stepper.span(g, self.dt), self.dt, self.precision,
                )  # fmt: skip
                first = 3 * stepper.parts[k]
                one.accelerate(pull, stepper.pair[first : first + 3 * len(one.parts)])
