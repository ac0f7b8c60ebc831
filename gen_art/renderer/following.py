"""Where the living particles of a system are on the average, and where they are heading: what cameras and labels follow."""

import math
from dataclasses import dataclass, replace

import numpy as np

from gen_art.errors import UsageError
from gen_art.particles.rows import LIFETIME, POSITION, VELOCITY
from gen_art.simulation.accelerations import accelerations

__all__ = ["Followed", "living", "followed"]


@dataclass(frozen=True)
class Followed:
    """The mean of a system's living particles.

    position : (3,) m
    velocity : (3,) m/s
    acceleration : (3,) m/s^2; 0 where it was not asked for
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @property
    def heading(self) -> float:
        """The horizontal direction of the velocity as an angle in radians from x towards z; 0 where there is none."""
        return math.atan2(self.velocity[2], self.velocity[0])

    def bank(self, gravity: float) -> float:
        """Radians to the right, by which an aeroplane leans that turns as this does: atan(a / gravity) with a to the right."""
        right = (-math.sin(self.heading), 0.0, math.cos(self.heading))
        return math.atan(float(self.acceleration @ right) / gravity)

    def before(self, seconds: float) -> "Followed":
        """Where it was so long ago, at its velocity of now."""
        return replace(self, position=self.position - seconds * self.velocity)


def living(system, time: float) -> np.ndarray:
    """Slots of the particles that are alive at simulated time `time`, in order of id."""
    n = int(system.count)
    birth, life = system.birth[:n], np.asarray(system.floats[LIFETIME, :n], dtype=np.float64)
    return np.flatnonzero((birth <= time) & (birth + life > time))


def followed(sim, name: str, accelerates: bool = False) -> Followed | None:
    """The mean of a system now, or None while no particle of it is alive.

    accelerates : whether the acceleration is asked for
    Raises UsageError if there is no such system, or if it has no acceleration at one time.
    """
    if name not in sim.systems:
        raise UsageError(f"there is no system '{name}' to follow; there are {', '.join(sim.systems)}")
    system = sim.systems[name]
    alive = living(system, sim.time)
    if not len(alive):
        return None
    position, velocity = (system.floats[rows, alive].astype(np.float64).mean(axis=1) for rows in (POSITION, VELOCITY))
    acceleration = np.zeros(3)
    if accelerates:
        acceleration = accelerations(sim, name)[:, alive].astype(np.float64).mean(axis=1)
    return Followed(position, velocity, acceleration)
