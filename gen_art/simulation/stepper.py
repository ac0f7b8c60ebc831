"""The step kernel of one system and its arguments."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from gen_art.integrators.step_kernels import make_step
from gen_art.particles.storage import PADDING
from gen_art.simulation.system import ParticleSystem

if TYPE_CHECKING:
    from gen_art.simulation.ledger import LedgerKeeper

__all__ = ["Stepper"]


class Stepper:
    """The step kernel of one system and its arguments.

    numbers : parameters of the forces and colliders (Q in kernels)
    scheme_numbers : numbers of the integrator's stages (P)
    pair : accelerations of the forces between particles, three rows for each part of an interaction (A)
    scratch : states within a step (R)
    part_offsets : number of the first part of each interaction; the last entry is the number of all parts
    """

    def __init__(self, system: ParticleSystem, precision: str, coupled: bool):
        self.system, self.coupled = system, coupled
        dtype = system.state.floats.dtype
        self.ledger: LedgerKeeper | None = None
        self.numbers = system.composition.numbers(dtype)
        self.scheme_numbers = np.array(system.scheme.numbers, dtype)
        self.pair = np.zeros((1, 1), dtype)
        self.scratch = np.zeros((1, 1), dtype)
        sizes = [len(interaction.parts) for interaction in system.interactions]
        self.part_offsets = np.cumsum([0, *sizes]).tolist()
        self.precision = precision
        self._kernels: dict[bool, Callable] = {}

    def _kernel(self, start: float) -> Callable:
        """The step kernel: one of whole steps in every lane where nobody dies, is fixed or is born after `start`, s."""
        system = self.system
        lifespans = system.state.may_die or system.state.has_fixed or system.state.last_birth > start
        if lifespans not in self._kernels:
            self._kernels[lifespans] = make_step(
                system.composition, system.scheme.kind, system.scheme.rotation, self.part_offsets[-1],
                self.coupled, system.state.attributes, self.precision, lifespans,
            )  # fmt: skip
        return self._kernels[lifespans]

    def run(self, first: int, steps: int, dt: float, begin: int = 0, earliest: float = 0.0) -> None:
        """Take whole steps in one launch, for slots from `begin` on.

        earliest : lower bound of the start of a particle's step relative to the step, s; -inf for children born before it
        """
        if self.coupled:
            self.begin()
            # forces between particles act on newborn particles from their first whole step on
            self.pair[:, begin : self.system.state.count] = 0.0
        self._launch(begin, first, steps, dt, earliest, -1, len(self.system.scheme.stages))

    def begin(self) -> None:
        """Resize the arrays of pair accelerations and stage states to the storage's capacity."""
        size = self.system.state.capacity + PADDING
        if self.system.interactions and self.pair.shape[1] != size:
            self.pair = np.zeros((max(1, 3 * self.part_offsets[-1]), size), self.numbers.dtype)
        needs_scratch = self.system.scheme.kind == "runge_kutta" or self.system.composition.colliders
        if needs_scratch and self.scratch.shape[1] != size:
            self.scratch = np.zeros((12, size), self.numbers.dtype)

    def span(self, g: int, dt: float) -> float:
        """The length of the kick of stage g, s; 0 in Runge-Kutta schemes."""
        return dt * self.system.scheme.stages[g][0] if self.system.scheme.kind == "splitting" else 0.0

    def stage_rows(self, g: int) -> np.ndarray:
        """An array whose first six rows are the positions and velocities at stage g."""
        return self.scratch if g > 0 and self.system.scheme.kind == "runge_kutta" else self.system.state.floats

    def stage(self, first: int, dt: float, stage0: int, stage1: int, numbers: np.ndarray | None = None) -> None:
        """Take stages stage0 to stage1 - 1 of one step; stage -1 is the first drift.

        numbers : used instead of scheme_numbers
        """
        saved = self.scheme_numbers
        self.scheme_numbers = saved if numbers is None else numbers
        self._launch(0, first, 1, dt, 0.0, stage0, stage1)
        self.scheme_numbers = saved

    def _launch(self, begin, first, steps, dt, earliest, stage0, stage1) -> None:
        state = self.system.state
        if state.count > begin:
            if self.ledger:
                self.ledger.record_step(self.system.name, self, begin, first, dt, earliest, stage0, stage1)
            self._kernel(first * dt)(
                state.floats, state.birth, state.key, self.pair, self.scratch, self.numbers, self.scheme_numbers,
                begin, state.count, float(first), steps, dt, earliest, stage0, stage1,
                state.floats.ctypes.data, state.birth.ctypes.data, self.scratch.ctypes.data,
            )  # fmt: skip
