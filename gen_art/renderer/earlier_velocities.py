"""The acceleration of a picture's particles: how their velocities have changed since an earlier moment."""

from dataclasses import dataclass

import numpy as np

from gen_art.particles.rows import VELOCITY

__all__ = ["EarlierVelocities"]


@dataclass(frozen=True)
class EarlierVelocities:
    """The velocities of one system at an earlier moment.

    time : s
    ids : (n,) of its particles, in ascending order
    velocities : (3, n) m/s
    """

    time: float
    ids: np.ndarray
    velocities: np.ndarray

    @classmethod
    def of(cls, system, time: float) -> "EarlierVelocities":
        n = int(system.count)
        return cls(time, np.array(system.id[:n]), np.array(system.floats[VELOCITY, :n], np.float64))

    def acceleration(self, system, time: float) -> np.ndarray | None:
        """(n,) m/s^2 since then; 0 for particles that did not exist then. None if no time has passed or there were none."""
        if self.time == time or not len(self.ids):
            return None
        current = system.id[: int(system.count)]
        slot = np.minimum(np.searchsorted(self.ids, current), len(self.ids) - 1)
        change = system.floats[VELOCITY, : len(current)] - self.velocities[:, slot]
        acceleration = np.linalg.norm(change, axis=0) / abs(time - self.time)
        return np.where(self.ids[slot] == current, acceleration, 0.0).astype(np.float32)
