"""One system's step kernel and what it is launched with."""

from typing import TYPE_CHECKING

import numpy as np

from gen_art.integrators.step_kernels import make_step
from gen_art.particles.storage import PADDING
from gen_art.simulation.system import ParticleSystem

if TYPE_CHECKING:
    from gen_art.simulation.ledger import LedgerKeeper

__all__ = ["Stepper"]


class Stepper:
    """One system's kernel and what it is launched with."""

    def __init__(self, system: ParticleSystem, precision: str, coupled: bool):
        self.system, self.coupled = system, coupled
        dtype = system.state.floats.dtype
        self.ledger: LedgerKeeper | None = None
        self.numbers = system.composition.numbers(dtype)
        self.scheme_numbers = np.array(system.scheme.numbers, dtype)
        self.pair = np.zeros((1, 1), dtype)
        self.scratch = np.zeros((1, 1), dtype)
        self.parts = np.cumsum([0, *(len(one.parts) for one in system.interactions)]).tolist()
        self.kernel = make_step(
            system.composition, system.scheme.kind, system.scheme.rotation, self.parts[-1],
            coupled, system.state.attributes, precision,
        )  # fmt: skip

    def run(self, first: int, steps: int, dt: float, begin: int = 0, earliest: float = 0.0) -> None:
        """Whole steps in one launch, for slots from `begin` on."""
        if self.coupled:
            self.begin()
            # children feel the other particles from their first whole step on
            self.pair[:, begin : self.system.state.count] = 0.0
        self._launch(begin, first, steps, dt, earliest, -1, len(self.system.scheme.stages))

    def begin(self) -> None:
        """Fit the arrays of pair accelerations and stage states to the storage."""
        size = self.system.state.capacity + PADDING
        if self.system.interactions and self.pair.shape[1] != size:
            self.pair = np.zeros((max(1, 3 * self.parts[-1]), size), self.numbers.dtype)
        keeps = self.system.scheme.kind == "runge_kutta" or self.system.composition.colliders
        if keeps and self.scratch.shape[1] != size:
            self.scratch = np.zeros((12, size), self.numbers.dtype)

    def span(self, g: int, dt: float) -> float:
        """The length of the kick of stage g, s; 0 in Runge-Kutta."""
        return dt * self.system.scheme.stages[g][0] if self.system.scheme.kind == "splitting" else 0.0

    def stage_rows(self, g: int) -> np.ndarray:
        """Rows of which the first six are the positions and velocities at stage g."""
        return self.scratch if g > 0 and self.system.scheme.kind == "runge_kutta" else self.system.state.floats

    def stage(self, first: int, dt: float, stage0: int, stage1: int, numbers: np.ndarray | None = None) -> None:
        """Stages stage0 to stage1 - 1 of one step; from -1 the first drift. numbers : in the place of the scheme's"""
        own = self.scheme_numbers
        self.scheme_numbers = own if numbers is None else numbers
        self._launch(0, first, 1, dt, 0.0, stage0, stage1)
        self.scheme_numbers = own

    def _launch(self, begin, first, steps, dt, earliest, stage0, stage1) -> None:
        state = self.system.state
        if state.count > begin:
            if self.ledger:
                self.ledger.record_step(self.system.name, self, begin, first, dt, earliest, stage0, stage1)
            self.kernel(
                state.floats, state.birth, state.key, self.pair, self.scratch, self.numbers, self.scheme_numbers,
                begin, state.count, float(first), steps, dt, earliest, stage0, stage1,
            )  # fmt: skip
