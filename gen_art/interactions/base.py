"""The contract of an interaction: forces between particles, summed by a pair kernel into an array of accelerations."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.storage import Particles
from gen_art.registry import Parametric, Registry

__all__ = ["INTERACTIONS", "ForcePart", "ForceRequest", "ImplicitStage", "Interaction", "Shapes", "interaction"]

INTERACTIONS = Registry("interaction")
interaction = INTERACTIONS


@dataclass(frozen=True)
class ForcePart:
    """Accelerations of an interaction that the ledger records separately.

    label : their name in the ledger; "" for that of the interaction
    dissipates : whether the ledger counts minus their work as dissipated; else the interaction's flags decide
    """

    label: str = ""
    dissipates: bool = False


@dataclass
class ForceRequest:
    """What an interaction is asked for at one stage of a step.

    rows : (6 or more, capacity), position and velocity at this stage
    state : the particles that the forces act on, for everything else
    n : their number
    source_rows, sources, m : the same of the particles that exert the forces, of this system or of another
    span : s, the length of the kick that the accelerations serve; 0 for a stage of Runge-Kutta
    dt : s, the whole step
    time : s, of this stage
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
    time: float


@dataclass
class ImplicitStage:
    """The part of a step in which an implicit interaction changes velocities: after a kick, before a drift.

    old : (3, n) m/s, velocities before the forces' kick
    kick, drift : s, the length of the kick, and of the drift that follows
    time : s, at the start of the step
    dt : s, the whole step
    with_ledger : whether a ledger is kept, which reads the velocities before the drift
    """

    old: np.ndarray
    kick: float
    drift: float
    time: float
    dt: float
    precision: str
    with_ledger: bool


@dataclass(frozen=True)
class Shapes:
    """What an interaction makes of its particles to be seen: boxes with rounded edges, of which capsules and balls are some.

    particle : (n,), slot of the particle that gives each its colour and size
    center : (n, 3) m
    half : (n, 3) m, half extents of the box inside the rounding, along its own axes
    radius : (n,) m, of the rounding; NaN for that of the particle
    axes : (n, 3, 3), rows: its axes in the world
    velocity : (n, 3) m/s, of the centre
    spin : (n, 3) rad/s, angular velocity
    """

    particle: np.ndarray
    center: np.ndarray
    half: np.ndarray
    radius: np.ndarray
    axes: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


class Interaction(Parametric):
    """Forces between particles.

    `accelerate(request, out)` writes accelerations, m/s^2, of the first request.n particles into out, (3 len(parts), capacity):
    three rows for each of `parts`, which the ledger records separately.
    `energy(state, slots, precision)` returns the potential energy, J, of the particles in these slots together.
    If `implicit`, `solve(state, stage)` changes velocities instead, between each kick of a step and the drift after it.
    `take_colliders(colliders, names)` takes over those of a system's colliders that it handles itself, and returns the others.
    If `moves_particles`, `drift(state, stage)` moves the particles too, in place of the kernel's drift. It then handles all
    colliders, and the ledger reads `collider_impulses` and `drift_displacement`.
    If `periodic`, forces act across the sides of a periodic `box` too, between nearest images, and positions in a request may lie
    outside of it; other interactions are refused there.
    If `breaks`, `break_bonds(state, precision)` is called at the end of each step.
    While `at_rest`, it changes nothing by itself: a system whose particles are all fixed then takes no steps.
    `saved_arrays` are the arrays by name that a snapshot stores beside the particles and the parameters;
    `restore_arrays(saved_arrays, time)` restores them.
    """

    parts: tuple[ForcePart, ...] = (ForcePart(),)
    attributes: tuple[str, ...] = ()  # declared attributes that its particles need
    conservative: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True
    implicit: bool = False
    breaks: bool = False
    moves_particles: ClassVar[bool] = False
    periodic: ClassVar[bool] = False
    box: PeriodicBox | None = None  # of the simulation that has taken its system; None in open space
    smooth: ClassVar[bool] = False  # whether forces vary with the distances as smoothly as the motion does

    def fresh(self) -> "Interaction":
        """One with the same parameters, for another system."""
        return type(self)(**self.values)

    @property
    def at_rest(self) -> bool:
        return False

    @property
    def source_system(self) -> str | None:
        """The other system whose particles exert the forces; None if the system's particles act on each other."""
        return self.values.get("sources")

    def problem_in(self, box: PeriodicBox, largest_radius: float) -> str | None:
        """Why this cannot act in a periodic box, between particles of up to this radius, m; None if it can."""
        if self.periodic:
            return None
        able = ", ".join(name for name, cls in INTERACTIONS.classes.items() if getattr(cls, "periodic", False))
        return (
            f"{self.name} does not act across the sides of a periodic box (these do: {able}): "
            f"leave out {self.name}, or the domain"
        )

    def check(self, system) -> None:
        """Raise UsageError for a system that this cannot act in; called before any of its particles exists."""

    def check_masses(self, system, ids: np.ndarray, masses: np.ndarray) -> None:
        """Raise UsageError for a particle of `system` whose mass, (n,) kg, this cannot move; called before masses change."""

    def attach(self, system, dt: float) -> list[str]:
        """Called once the particles of the start exist. Returns sentences about a start or a step that cannot be right."""
        return []

    def advice(self, state: Particles) -> list[str]:
        """Called now and then during a run. Returns sentences about a state that cannot be right."""
        return []

    def shapes(self, state: Particles) -> Shapes | None:
        """The shapes of bodies (`draw: body`) or of links between particles (`draw: thread`), or None if it has none."""
        return None

    def sheet(self, state: Particles) -> np.ndarray | None:
        """(k, 3), slots of the particles at the corners of each triangle of a cloth (`draw: cloth`), or None if it has none."""
        return None

    def accelerate(self, request: ForceRequest, out: np.ndarray) -> None:
        raise NotImplementedError

    def solve(self, state: Particles, stage: ImplicitStage) -> None:
        raise NotImplementedError

    def drift(self, state: Particles, stage: ImplicitStage) -> None:
        raise NotImplementedError

    def take_colliders(self, colliders: list, names: dict) -> list:
        """Take over colliders; returns those that stay. `names` gives the name of each in the ledger, by id()."""
        return colliders

    def collider_impulses(self) -> dict[str, tuple[np.ndarray, float]]:
        """The impulse (3,), N s, and the work, J, of each collider in the last solve, by name."""
        raise NotImplementedError

    def drift_displacement(self):
        """(3, n) m, how far the coming drift moves the particles beside their velocities; or 0."""
        raise NotImplementedError

    @property
    def saved_arrays(self) -> dict[str, np.ndarray]:
        return {}

    def restore_arrays(self, saved_arrays: dict[str, np.ndarray], time: float) -> None:
        raise NotImplementedError

    def disturb(self, share: float, push: np.ndarray) -> None:
        """Move velocities that are not the particles' own towards `push`, (3,) m/s, by a share: v <- (1 - share) v + share push.

        `gen-art check` does this to see whether a claim notices it.
        """

    def break_bonds(self, state: Particles, precision: str) -> float | None:
        """Break bonds that are overstretched at the present positions; their energy, J, or None if none breaks."""
        raise NotImplementedError

    def energy(self, state: Particles, slots: np.ndarray, precision: str) -> float:
        raise NotImplementedError
