"""Advances the systems that forces between particles couple, together and stage by stage."""

from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import ForceRequest, ImplicitStage
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME, VELOCITY
from gen_art.registry import suggest
from gen_art.simulation.block_steps import BlockSteps, check_blocks, parts_of
from gen_art.simulation.stepper import Stepper

if TYPE_CHECKING:
    from gen_art.simulation.ledger import LedgerKeeper
    from gen_art.simulation.system import ParticleSystem

__all__ = ["CoupledSystems"]


class CoupledSystems:
    """The systems on which forces between particles act, and the systems that exert them.

    resting : the names of those in which nothing ever moves, such as static bodies, so that they take no steps
    """

    def __init__(self, steppers: dict[str, Stepper], names: set[str], dt: float, precision: str):
        self.steppers, self.dt, self.precision = {name: steppers[name] for name in sorted(names)}, dt, precision
        self.ledger: LedgerKeeper | None = None
        self._blocks = BlockSteps(self.steppers, dt, precision)
        self.resting: frozenset[str] = frozenset()
        self._accelerations_at = -1  # the step for whose start the stored pair accelerations are valid; -1: for none

    @staticmethod
    def names(members: dict) -> set[str]:
        """The names of the systems that a mutual force couples. Raises UsageError for a source that is no system."""
        coupled = {name for name, system in members.items() if system.interactions}
        for name in sorted(coupled):
            for interaction in members[name].interactions:
                other = interaction.source_system
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
        if parts_of(members[name] for name in coupled) > 1:
            for name in sorted(coupled):
                check_blocks(name, members[name])
        return coupled

    @property
    def moving(self) -> dict[str, Stepper]:
        return {name: stepper for name, stepper in self.steppers.items() if name not in self.resting}

    def find_resting(self) -> None:
        """Find the systems that rest, from the particles that there are now."""
        sources = {one.source_system for stepper in self.steppers.values() for one in stepper.system.interactions}
        rest = {name for name, stepper in self.steppers.items() if name not in sources and _rests(stepper.system)}
        self.resting = frozenset(rest) if self._blocks.parts == 1 else frozenset()

    def forget(self) -> None:
        """Discard the stored pair accelerations, because particles were added, removed or moved."""
        self._accelerations_at = -1

    def step(self, first: int) -> None:
        """One step, stage by stage: pair accelerations at each stage's positions, then the fused kernel's stage."""
        coupled = self.moving
        for stepper in coupled.values():
            stepper.begin()
        if self._blocks.parts > 1:
            self._blocks.step(first, self._accelerations_at == first)
            colliding = any(stepper.system.composition.colliders for stepper in coupled.values())
            self._accelerations_at = -1 if colliding else first + 1
            return
        schemes = [stepper.system.scheme for stepper in coupled.values()]
        if any(s.first_drift for s in schemes):
            self.forget()
            for stepper in coupled.values():
                stepper.stage(first, self.dt, -1, 0)
        for g in range(max(len(s.stages) for s in schemes)):
            active = {name: stepper for name, stepper in coupled.items() if g < len(stepper.system.scheme.stages)}
            if g > 0 or self._accelerations_at != first:
                for stepper in active.values():
                    time = (first + stepper.system.scheme.stages[g][1]) * self.dt
                    self.sum_pair_forces(stepper, g, time, stepper.pair)
            for name, stepper in active.items():
                if any(interaction.implicit for interaction in stepper.system.interactions):
                    self._implicit_stage(name, stepper, first, g)
                else:
                    stepper.stage(first, self.dt, g, g + 1)
        # if no particle moves after the last kick, its pair accelerations are also those of the next step's first kick
        unmoved = all(s.kind == "splitting" and s.stages[-1][2] == 0 for s in schemes)
        unmoved = unmoved and not any(stepper.system.composition.colliders for stepper in coupled.values())
        self._accelerations_at = first + 1 if unmoved else -1
        for name, stepper in coupled.items():
            for interaction in stepper.system.interactions:
                state = stepper.system.state
                energy = interaction.break_bonds(state, self.precision) if interaction.breaks else None
                if energy is not None:
                    self.forget()
                    if self.ledger:
                        self.ledger.record_broken_bonds(name, interaction, energy)

    def _implicit_stage(self, name: str, stepper: Stepper, first: int, g: int) -> None:
        """Kick, let the implicit interactions change the velocities, and drift.

        If an interaction moves the particles (rigid bodies), it does the drift instead of the kernel.
        """
        system, state = stepper.system, stepper.system.state
        kick, time, drift = system.scheme.stages[g]
        # the kick and the drift as stages of their own, so that colliders and engines act in the drift only
        numbers = np.array([0.0, kick, time, 0.0, 0.0, time, drift, 0.0], state.floats.dtype)
        old = state.floats[VELOCITY, : state.count].copy()
        stage = ImplicitStage(
            old, self.dt * kick, self.dt * drift, first * self.dt, self.dt, self.precision, bool(self.ledger)
        )
        stepper.stage(first, self.dt, 0, 1, numbers)
        mover = None
        for interaction in system.interactions:
            if interaction.implicit and state.count:
                before = state.floats[VELOCITY, : state.count].copy() if self.ledger else None
                interaction.solve(state, stage)
                mover = interaction if interaction.moves_particles else mover
                if self.ledger and before is not None:
                    self.ledger.record_implicit(name, interaction, state, before, stage)
        if mover is None:
            stepper.stage(first, self.dt, 1, 2, numbers)
        elif drift > 0:
            before = state.floats[VELOCITY, : state.count].copy() if self.ledger else None
            mover.drift(state, stage)
            if self.ledger and before is not None:
                self.ledger.record_turn(name, mover, state, before)

    def sum_pair_forces(self, stepper: Stepper, g: int, time: float, out: np.ndarray) -> None:
        """Compute the accelerations of the forces between particles at the places of stage g and at `time`, s, for one system.

        out : three rows for each part of each interaction
        """
        system = stepper.system
        for k, interaction in enumerate(system.interactions):
            if interaction.implicit:
                continue
            other = self.steppers[interaction.source_system or system.name]
            if system.state.count:
                request = ForceRequest(
                    stepper.stage_rows(g), system.state, system.state.count, other.stage_rows(g), other.system.state,
                    other.system.state.count, stepper.span(g, self.dt), self.dt, self.precision, time,
                )  # fmt: skip
                row = 3 * stepper.part_offsets[k]
                interaction.accelerate(request, out[row : row + 3 * len(interaction.parts)])


def _rests(system: "ParticleSystem") -> bool:
    """Whether all particles of a system are fixed, and the forces between them leave them as they are."""
    lifetimes = system.state.floats[LIFETIME, : system.state.count]
    still = bool(system.interactions) and all(one.at_rest for one in system.interactions)
    return still and bool(fixed_lifetimes(lifetimes).all())
