"""The systems that forces between particles couple, advanced together stage by stage."""

from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import ForceRequest, ImplicitStage
from gen_art.particles.rows import VELOCITY
from gen_art.registry import suggest
from gen_art.simulation.stepper import Stepper

if TYPE_CHECKING:
    from gen_art.simulation.ledger import LedgerKeeper

__all__ = ["CoupledSystems"]


class CoupledSystems:
    """The systems on which forces between particles act, and those that exert them."""

    def __init__(self, steppers: dict[str, Stepper], names: set[str], dt: float, precision: str):
        self.steppers, self.dt, self.precision = {name: steppers[name] for name in sorted(names)}, dt, precision
        self.ledger: LedgerKeeper | None = None
        self._known_at = -1  # the step at whose start the accelerations between particles are known

    @staticmethod
    def names(members: dict) -> set[str]:
        """The names of the systems that a mutual force couples. Raises UsageError for a source that is no system."""
        coupled = {name for name, system in members.items() if system.interactions}
        for name in sorted(coupled):
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
                        f"systems '{name}' and '{other}' are coupled by a force: give both the same integrator"
                    )
                coupled = coupled | {other}
        return coupled

    def forget(self) -> None:
        """Pair accelerations must be computed again: particles came, went, or were moved."""
        self._known_at = -1

    def step(self, first: int) -> None:
        """One step, stage by stage: pair accelerations at each stage's positions, then the fused kernel's stage."""
        coupled = self.steppers
        for stepper in coupled.values():
            stepper.begin()
        schemes = [stepper.system.scheme for stepper in coupled.values()]
        if any(s.first_drift for s in schemes):
            self.forget()
            for stepper in coupled.values():
                stepper.stage(first, self.dt, -1, 0)
        for g in range(max(len(s.stages) for s in schemes)):
            active = {name: stepper for name, stepper in coupled.items() if g < len(stepper.system.scheme.stages)}
            if g > 0 or self._known_at != first:
                for name, stepper in active.items():
                    self._sum_pair_forces(stepper, g)
            for name, stepper in active.items():
                if any(one.implicit for one in stepper.system.interactions):
                    self._implicit_stage(name, stepper, first, g)
                else:
                    stepper.stage(first, self.dt, g, g + 1)
        # where nothing moves after the last kick, its pair accelerations serve the next step's first
        still = all(s.kind == "splitting" and s.stages[-1][2] == 0 for s in schemes)
        still = still and not any(stepper.system.composition.colliders for stepper in coupled.values())
        self._known_at = first + 1 if still else -1
        for name, stepper in coupled.items():
            for one in stepper.system.interactions:
                energy = one.break_bonds(stepper.system.state, self.precision) if one.breaks else None
                if energy is not None:
                    self.forget()
                    if self.ledger:
                        self.ledger.record_broken_bonds(name, one, energy)

    def _implicit_stage(self, name: str, stepper: Stepper, first: int, g: int) -> None:
        """Kick, the implicit interactions' own change of velocities, and the drift: theirs, if one carries the particles."""
        system, state = stepper.system, stepper.system.state
        kick, time, drift = system.scheme.stages[g]
        # two stages, so that walls and engines act in the drift alone
        parts = np.array([0.0, kick, time, 0.0, 0.0, time, drift, 0.0], state.floats.dtype)
        old = state.floats[VELOCITY, : state.count].copy()
        part = ImplicitStage(
            old, self.dt * kick, self.dt * drift, first * self.dt, self.dt, self.precision, bool(self.ledger)
        )
        stepper.stage(first, self.dt, 0, 1, parts)
        carrier = None
        for one in system.interactions:
            if one.implicit and state.count:
                before = state.floats[VELOCITY, : state.count].copy() if self.ledger else None
                one.solve(state, part)
                carrier = one if one.moves_particles else carrier
                if self.ledger and before is not None:
                    self.ledger.record_implicit(name, one, state, before, part)
        if carrier is None:
            stepper.stage(first, self.dt, 1, 2, parts)
        elif drift > 0:
            carrier.drift(state, part)

    def _sum_pair_forces(self, stepper: Stepper, g: int) -> None:
        system = stepper.system
        for k, one in enumerate(system.interactions):
            if one.implicit:
                continue
            other = self.steppers[one.source_system or system.name]
            if system.state.count:
                request = ForceRequest(
                    stepper.stage_rows(g), system.state, system.state.count, other.stage_rows(g), other.system.state,
                    other.system.state.count, stepper.span(g, self.dt), self.dt, self.precision,
                )  # fmt: skip
                first = 3 * stepper.parts[k]
                one.accelerate(request, stepper.pair[first : first + 3 * len(one.parts)])
