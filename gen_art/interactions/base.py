"""The contract of an interaction: forces between particles, summed by a pair kernel into an array of accelerations."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gen_art.particles.state import Particles
from gen_art.registry import Parametric, Registry

__all__ = ["INTERACTIONS", "Interaction", "Pull", "interaction"]

INTERACTIONS = Registry("interaction")
interaction = INTERACTIONS


@dataclass
class Pull:
    """What an interaction is asked for at one stage of a step.

    rows : (6 or more, capacity): position and velocity at this stage     state : the particles acted on, for the rest
    n : how many there are     source_rows, sources, m : the same of those that act (this very system, or another)
    span : s, the length of the kick that the accelerations serve; 0 for a stage of Runge-Kutta     dt : s, the whole step
    """

    rows: np.ndarray
    state: Particles
    n: int
    source_rows: np.ndarray
    sources: Particles
    m: int
    span: float
    dt: float
    precision: str


class Interaction(Parametric):
    """Acts between particles.

    `accelerate(pull, out)` writes accelerations, m/s^2, of the first pull.n particles into out, (3 len(parts), capacity):
    three rows for each of `parts`, which the ledger books apart: "" by the class's flags, any other name as dissipated.
    `energy(state, slots, precision)` gives the potential energy, J, that the particles in these slots have together.
    Where `implicit`, `solve(state, dt, precision)` changes velocities instead, between the kick and the drift of a step.
    Where it `tears`, `let_go(state, precision)` is called at the end of each step.
    """

    parts: ClassVar[tuple[str, ...]] = ("",)
    attributes: tuple[str, ...] = ()  # declared attributes that its particles have
    conservative: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True
    implicit: bool = False
    tears: bool = False

    @property
    def source_system(self) -> str | None:
        """The other system whose particles act, or None: the particles of the system act on each other."""
        return self.values.get("sources")

    def join(self, system, dt: float) -> None:
        """Called when the particles of the start have been born: learn who they are, refuse by UsageError, or warn."""

    def accelerate(self, pull: Pull, out: np.ndarray) -> None:
        raise NotImplementedError

    def solve(self, state: Particles, dt: float, precision: str) -> None:
        raise NotImplementedError

    def let_go(self, state: Particles, precision: str) -> float | None:
        """Let go of what breaks at these positions: the energy it held, J, or None when nothing broke."""
        raise NotImplementedError

    def memory(self) -> dict[str, np.ndarray]:
        """What it knows beyond its parameters, by name: part of snapshots and of the digest."""
        return {}

    def recall(self, memory: dict[str, np.ndarray]) -> None:
        """Take up what `memory` gave."""

    def energy(self, state: Particles, slots: np.ndarray, precision: str) -> float:
        raise NotImplementedError
