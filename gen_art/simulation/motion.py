"""How fast the velocities of a system's particles change, from states at equal distances in time."""

from typing import TYPE_CHECKING

import numpy as np

from gen_art.particles.rows import POSITION, VELOCITY

if TYPE_CHECKING:
    from gen_art.simulation.system import ParticleSystem

__all__ = ["MotionSample", "is_smooth"]

_SETTLED = 8  # steps after which the transient of strong drag is over


def is_smooth(system: "ParticleSystem") -> bool:
    """Whether velocities change smoothly where all is right: without impacts, noise, springs and contacts."""
    noisy = any(force.random for force in system.forces)
    return not (noisy or system.colliders) and all(interaction.smooth for interaction in system.interactions)


class MotionSample:
    """The velocities of some particles of one system at the latest times, at most `states`, the latest last.

    most : the largest number of particles; they lie evenly among all
    ids : of the particles
    """

    def __init__(self, system: "ParticleSystem", most: int, states: int = 3):
        self.system, self._most, self._states = system, most, states
        # drag is solved exactly, however strong: a newborn particle may take its medium's velocity within a step
        self._settles = bool(system.composition.dampings) and system.scheme.kind == "splitting"
        self.restart()

    def restart(self) -> None:
        """Forget all states. The next one chooses the particles."""
        self.ids, self._slots, self._key = np.zeros(0, np.int64), np.zeros(0, int), (-1, -1)
        self._velocities: list[np.ndarray] = []

    def record(self) -> None:
        """Add the present state. Particles that have died are left out of the earlier ones too."""
        state = self.system.state
        key = (state.next_id, state.count)
        if not self._velocities:
            n = state.count
            self._slots = np.arange(n) if n <= self._most else np.linspace(0, n - 1, self._most).astype(int)
            self.ids = state.id[self._slots]
        elif key != self._key:  # slots are in the order of ids
            slots = np.searchsorted(state.id[: state.count], self.ids)
            slots = np.minimum(slots, max(state.count - 1, 0))
            same = state.id[slots] == self.ids if state.count else np.zeros(len(slots), bool)
            self.ids, self._slots = self.ids[same], slots[same]
            self._velocities = [v[:, same] for v in self._velocities]
        self._key = key
        whole = len(self._slots) == state.count  # a slice is copied faster than chosen columns
        velocities = state.floats[VELOCITY, : state.count].copy() if whole else state.floats[VELOCITY, self._slots]
        self._velocities = [*self._velocities[1 - self._states :], velocities]

    @property
    def is_full(self) -> bool:
        return len(self._velocities) == self._states

    def keep(self, states: int) -> None:
        """Forget all but the latest states."""
        self._velocities = self._velocities[-states:]

    def count_above(self, limit: float) -> np.ndarray:
        """For each three states in succession the number of particles for which the ratio of `measure` is above a limit.

        The dead and unsettled count too.
        """
        if len(self._velocities) < 3:
            return np.zeros(0, int)
        v = np.stack(self._velocities)
        with np.errstate(all="ignore"):
            change = v[2:] - 2 * v[1:-1] + v[:-2]
            speed = v[1:-1]
            above = np.einsum("kci,kci->ki", change, change) > limit * limit * np.einsum("kci,kci->ki", speed, speed)
        return np.count_nonzero(above, axis=1)

    def measure(self, time: float, dt: float, before: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """(abs(v2 - 2 v1 + v0) / abs(v1), slots) of the particles that live at `time` and have moved; empty without three states.

        before : number of states after v2
        v0, v1, v2 : the three velocities; for an oscillation or a gyration by the angle a between them the ratio is
        2 (1 - cos a), and a^2 for small angles
        """
        if len(self._velocities) < 3 or not len(self.ids):
            return np.zeros(0), np.zeros(0, int)
        last = len(self._velocities) - before
        v0, v1, v2 = self._velocities[last - 3 : last]
        change, speed = v2 - 2 * v1 + v0, v1
        with np.errstate(all="ignore"):
            change, speed = np.sqrt((change * change).sum(0)), np.sqrt((speed * speed).sum(0))
            chosen = speed > 0
            state = self.system.state
            if state.may_die or self._settles:
                birth, age = state.birth[self._slots], time - state.birth[self._slots]
                chosen &= (state.death()[self._slots] > time) & (birth <= time)
                if self._settles:
                    chosen &= age > _SETTLED * dt
            return change[chosen] / speed[chosen], self._slots[chosen]

    def paths(self, dt: float) -> np.ndarray:
        """The particles' paths in the last step, m."""
        return np.sqrt((self._velocities[-1].astype(np.float64) ** 2).sum(0)) * dt

    def rounding(self, slots: np.ndarray, dt: float) -> np.ndarray:
        """The distance of neighbouring numbers at these particles' positions over their path in a step."""
        state = self.system.state
        at = np.abs(state.floats[POSITION, slots]).max(axis=0, initial=0.0)
        path = self.paths(dt)[np.isin(self._slots, slots)]
        with np.errstate(all="ignore"):
            return np.spacing(at) / path
