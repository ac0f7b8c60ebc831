"""Ribbons: each particle's path through its last positions, as a chain of streaks that become narrower and fainter.

Between two positions the path is curved as path_history.py says, and cut into pieces where the picture shows it. Positions are
kept at fixed steps of the simulation. A ribbon ends with its particle's life, also where the storage still holds it.
The joints of a chain are not visible, because a streak is a disc swept along a segment: two segments on one line add up to the
long one. In a periodic box a segment is left out where its particle was wrapped, which is where its ends are more than half of
the box apart.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen_art.particles.rows import LIFETIME, POSITION
from gen_art.preset.look import Ribbon
from gen_art.renderer.path_history import MOTION, PathHistory

__all__ = ["Links", "RibbonHistory"]


LINKS = 1 << 18  # particles times moments that are drawn together


@dataclass(frozen=True)
class Links:
    """Some of a ribbon's links, between one moment and the next older.

    system : the particles, as they are at the newest moment of the ribbon
    times : (moments,) s, newest first; motion : (moments, 6, n) positions and velocities
    drawn : (links, n) bool
    factors : (4, links) float32: light and width of the look's own at the newer end; both at the older end divided by those
    """

    system: Any
    times: np.ndarray
    motion: np.ndarray
    drawn: np.ndarray
    factors: np.ndarray


class RibbonHistory(PathHistory):
    """The last positions of one system's particles."""

    def __init__(self, ribbon: Ribbon):
        super().__init__(ribbon.points)
        self.ribbon = ribbon

    def links(self, system, time: float) -> Iterator[Links]:
        """The ribbons at `time`, newest first, at most LINKS links at a time or those of one moment."""
        n = int(system.count)
        birth, lifetime = system.birth[:n], system.floats[LIFETIME, :n].astype(np.float64)
        alive = (birth <= time) & (birth + lifetime > time)
        times, motions = [time], [np.array(system.floats[MOTION, :n])]
        drawn: list[np.ndarray] = []
        for older_time, older, known in self.before(system, time, unwrap=False):
            if time - times[-1] >= self.ribbon.length:
                break
            if drawn and (len(drawn) + 1) * n > LINKS:
                yield self._links(system, time, times, motions, drawn)
                times, motions, drawn = times[-1:], motions[-1:], []
            newer = motions[-1]
            older = np.where(known, older, newer)
            known = known & alive
            drawn.append(known if system.box is None else known & ~system.box.jumps((newer - older)[POSITION]))
            times.append(older_time)
            motions.append(older)
        if drawn:
            yield self._links(system, time, times, motions, drawn)

    def _links(self, system, time: float, times: list, motions: list, drawn: list) -> Links:
        ribbon, moments = self.ribbon, np.array(times)
        fraction = np.minimum((time - moments) / ribbon.length, 1.0)
        light, width = 1.0 - (1.0 - ribbon.tail) * fraction, 1.0 - (1.0 - ribbon.taper) * fraction
        factors = np.stack([
            light[:-1], width[:-1], light[1:] / np.maximum(light[:-1], 1e-9), width[1:] / np.maximum(width[:-1], 1e-9)
        ])  # fmt: skip
        return Links(system, moments, np.stack(motions), np.stack(drawn), factors.astype(np.float32))
