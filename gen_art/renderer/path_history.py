"""The last positions and velocities of a system's particles, from which curved paths are drawn.

Between two moments a path is the cubic Hermite curve through both positions with both velocities, which the simulation
knows at the same times. On a circle of which an angle a is passed it errs by radius times a^4 / 384; the quadratic from one
moment's acceleration errs by radius times a^3 / 6.
"""

from collections import deque
from dataclasses import dataclass
from itertools import islice

import numpy as np

from gen_art.particles.rows import POSITION, VZ

__all__ = ["MOMENTS", "MOTION", "PathHistory", "PastMotion"]

MOMENTS = 8  # moments between which a streak's path is drawn: a whole turn errs by a thousandth of its radius
MOTION = slice(POSITION.start, VZ + 1)  # the rows of position and velocity


@dataclass(frozen=True)
class PastMotion:
    """Earlier positions and velocities of the particles that exist now, newest first.

    times : (moments,) s
    motion : (moments, 6, n or more)
    known : (moments, n) bool, whether the particle was there at this moment and at all later ones
    """

    times: np.ndarray
    motion: np.ndarray
    known: np.ndarray


class PathHistory:
    """Positions and velocities of one system's particles at the last `moments` moments at which `remember` was called."""

    def __init__(self, moments: int):
        self._moments: deque = deque(maxlen=moments)

    def remember(self, system, time: float) -> None:
        """Keep the particles' positions and velocities; a second call at the same moment does nothing."""
        if not self._moments or self._moments[-1][0] < time:
            n = int(system.count)
            self._moments.append((time, np.array(system.id[:n]), np.array(system.floats[MOTION, :n])))

    def before(self, system, time: float, unwrap: bool = True, into: np.ndarray | None = None):
        """(time, motion, known) at each moment before `time`, newest first, for the particles that a system has now.

        unwrap : in a periodic box, give the images that lie nearest to where the particle was a moment later
        into : (moments, 6, n), where the motion is written; else it may be what is kept
        """
        n, moments = int(system.count), 0
        ids, known, newer = system.id[:n], np.ones(n, bool), system.floats[POSITION, :n]
        for older_time, older_ids, motion in reversed(self._moments):
            if older_time >= time:
                continue
            older, m = None if into is None else into[moments], len(older_ids)
            if not m:
                return
            nobody_left = m <= n and np.array_equal(older_ids, ids[:m])
            if nobody_left and m == n and older is None:
                older = motion
            elif nobody_left:
                older = np.empty((len(motion), n), motion.dtype) if older is None else older
                older[:, :m], older[:, m:] = motion, motion[:, -1:]
                known = known & (np.arange(n) < m)
            else:
                index = np.minimum(np.searchsorted(older_ids, ids), m - 1)
                known = known & (older_ids[index] == ids)
                older = motion.take(index, axis=1, out=older, mode="clip")  # "clip" writes without a copy between
            if unwrap and system.box is not None:
                older = older.copy() if into is None else older
                older[POSITION] = newer - system.box.nearest(newer - older[POSITION])
            yield older_time, older, known
            newer, moments = older[POSITION], moments + 1

    def since(self, system, time: float, start: float) -> PastMotion | None:
        """What is known between `start` and `time`, and of one moment at or before `start`; None if nothing is."""
        earlier = [moment for moment, *_ in self._moments if moment < time]
        wanted = sum(moment > start for moment in earlier) + 1
        motion = np.empty(
            (min(wanted, len(earlier)), len(system.floats[MOTION]), int(system.count)), system.floats.dtype
        )
        times, knowns = [], []
        for older_time, _, known in islice(self.before(system, time, into=motion), len(motion)):
            times.append(older_time)
            knowns.append(known)
        if not times:
            return None
        return PastMotion(np.array(times), motion[: len(times)], np.stack(knowns))
