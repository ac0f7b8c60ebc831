"""The contract of an interaction: forces between particles, summed by a pair kernel into an array of accelerations."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gen_art.particles.storage import Particles
from gen_art.registry import Parametric, Registry

__all__ = ["INTERACTIONS", "Interaction", "ForceRequest", "ImplicitStage", "interaction"]

INTERACTIONS = Registry("interaction")
interaction = INTERACTIONS


@dataclass
class ForceRequest:
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


@dataclass
class ImplicitStage:
    """The part of a step that an implicit interaction takes: what stands around its change of the velocities.

    old : (3, n) velocities before the forces' kick     kick, drift : s, how long the forces kicked, and the drift that follows
    time : s, at the start of the step     dt : s, the whole step     booked : the ledger reads the velocities before the drift
    """

    old: np.ndarray
    kick: float
    drift: float
    time: float
    dt: float
    precision: str
    booked: bool


class Interaction(Parametric):
    """Acts between particles.

    `accelerate(pull, out)` writes accelerations, m/s^2, of the first pull.n particles into out, (3 len(parts), capacity):
    three rows for each of `parts`, which the ledger books apart: "" by the class's flags, any other name as dissipated.
    `energy(state, slots, precision)` gives the potential energy, J, that the particles in these slots have together.
    Where `implicit`, `solve(state, turn)` changes velocities instead, between each kick of a step and the drift after it.
    Where it `carries` the particles, `drift(state, turn)` moves them too, in the place of the kernel's drift; the system's
    colliders are then its own, by `take_colliders`, and the ledger asks for their `impulses` and for its `shifts`.
    Where it `breaks`, `break_bonds(state, precision)` is called at the end of each step.
    `saved_arrays` is what a snapshot must keep beside the particles and the parameters, arrays by name;
    `restore_arrays(saved_arrays, time)` restores it.
    """

    parts: ClassVar[tuple[str, ...]] = ("",)
    attributes: tuple[str, ...] = ()  # declared attributes that its particles have
    conservative: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True
    implicit: bool = False
    breaks: bool = False
    carries: ClassVar[bool] = False

    @property
    def source_system(self) -> str | None:
        """The other system whose particles act, or None: the particles of the system act on each other."""
        return self.values.get("sources")

    def attach(self, system, dt: float) -> None:
        """Called when the particles of the start have been born: learn who they are, refuse by UsageError, or warn."""

    def accelerate(self, request: ForceRequest, out: np.ndarray) -> None:
        raise NotImplementedError

    def solve(self, state: Particles, turn: ImplicitStage) -> None:
        raise NotImplementedError

    def drift(self, state: Particles, turn: ImplicitStage) -> None:
        raise NotImplementedError

    def take_colliders(self, colliders) -> None:
        raise NotImplementedError

    def impulses(self) -> dict[str, tuple[np.ndarray, float]]:
        """(N s (3,), J) that each collider gave in the last solve, by name: impulse, and work where it moves."""
        raise NotImplementedError

    def shifts(self):
        """(3, n) m that the coming drift moves particles by, beside their velocities; or 0."""
        raise NotImplementedError

    @property
    def saved_arrays(self) -> dict[str, np.ndarray]:
        return {}

    def restore_arrays(self, saved_arrays: dict[str, np.ndarray], time: float) -> None:
        raise NotImplementedError

    def break_bonds(self, state: Particles, precision: str) -> float | None:
        """Let go of what breaks at these positions: the energy it held, J, or None when nothing broke."""
        raise NotImplementedError

    def energy(self, state: Particles, slots: np.ndarray, precision: str) -> float:
        raise NotImplementedError
