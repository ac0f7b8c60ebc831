"""Ribbons: each particle's path through its last positions, as a chain of streaks that get narrower and fainter.

Positions are remembered at fixed steps of the simulation. A chain's joints do not show: a streak is a disc swept along a
segment, and two segments on one line add up to the long one.
"""

from collections import deque
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from gen_art.particles.rows import LIFETIME, POSITION, RADIUS, VELOCITY
from gen_art.preset.look import Ribbon

__all__ = ["RibbonHistory", "Segment"]


@dataclass(frozen=True)
class Segment:
    """What the shading kernel reads as a system of streaks: from each particle's place at `time` back over `lapse` seconds.

    width, light : at the newer end, of the look's own      taper, tail : at the older end, of those at the newer
    """

    system: SimpleNamespace
    time: float
    lapse: float
    width: float
    light: float
    taper: float
    tail: float


class RibbonHistory:
    """The last positions of one system's particles."""

    def __init__(self, ribbon: Ribbon):
        self.ribbon = ribbon
        self._kept: deque = deque(maxlen=ribbon.points)

    def remember(self, system, time: float) -> None:
        """Keep where the particles are; a second time the same moment is not kept."""
        if not self._kept or self._kept[-1][0] < time:
            n = int(system.count)
            self._kept.append((time, np.array(system.id[:n]), np.array(system.floats[POSITION, :n])))

    def segments(self, system, time: float):
        """The ribbons at `time` as segments, newest first."""
        n, length = int(system.count), self.ribbon.length
        newer, at, known = np.array(system.floats[POSITION, :n]), time, np.ones(n, bool)
        for then, ids, places in reversed(self._kept):
            if then >= at:
                continue
            if time - at >= length or not len(ids):
                return
            slot = np.minimum(np.searchsorted(ids, system.id[:n]), len(ids) - 1)
            known &= ids[slot] == system.id[:n]
            older = np.where(known, places[:, slot], newer)
            yield self._segment(system, newer, older, known, at, then, time)
            newer, at = older, then

    def _segment(self, system, newer, older, known, at: float, then: float, time: float) -> Segment:
        floats, n = np.array(system.floats), newer.shape[1]
        floats[POSITION, :n], floats[VELOCITY, :n] = newer, (newer - older) / (at - then)
        floats[LIFETIME, :n][~known] = 0.0  # without a past: not drawn
        birth = np.array(system.birth)
        birth[:n] = np.where(known, np.minimum(birth[:n], then), birth[:n])
        ribbon, (head, end) = self.ribbon, (min((time - t) / self.ribbon.length, 1.0) for t in (at, then))
        width, narrow = (1.0 - (1.0 - ribbon.taper) * a for a in (head, end))
        light, faint = (1.0 - (1.0 - ribbon.tail) * a for a in (head, end))
        floats[RADIUS, :n] *= width
        drawn = SimpleNamespace(
            floats=floats, birth=birth, key=system.key, id=system.id, source=system.source, sources=system.sources,
            count=n, channels=system.channels,
        )  # fmt: skip
        return Segment(drawn, at, at - then, width, light, narrow / max(width, 1e-9), faint / max(light, 1e-9))
