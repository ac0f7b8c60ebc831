"""Ribbons: each particle's path through its last positions, as a chain of streaks that become narrower and fainter.

Between two positions the path is curved as path_history.py says, and cut into pieces where the picture shows it. Positions are
kept at fixed steps of the simulation. The joints of a chain are not visible, because a streak is a disc swept along a segment:
two segments on one line add up to the long one. In a periodic box a segment is left out where its particle was wrapped, which is
where its ends are more than half of the box apart.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from gen_art.particles.rows import LIFETIME, POSITION, RADIUS, VELOCITY
from gen_art.preset.look import Ribbon
from gen_art.renderer.path_history import MOTION, PastMotion, PathHistory

__all__ = ["RibbonHistory", "Segment", "cut_by_plane"]


@dataclass(frozen=True)
class Segment:
    """What the shading kernel reads as a system of streaks: from each particle's position at `time` back over `duration` seconds.

    motion : (6, n) positions and velocities at `time`
    past : the same at the older end
    width, light : factors of the look's own, at the newer end
    taper, tail : width and light at the older end, divided by those at the newer
    """

    system: SimpleNamespace
    time: float
    duration: float
    motion: np.ndarray
    past: PastMotion
    width: float
    light: float
    taper: float
    tail: float


class RibbonHistory(PathHistory):
    """The last positions of one system's particles."""

    def __init__(self, ribbon: Ribbon):
        super().__init__(ribbon.points)
        self.ribbon = ribbon

    def segments(self, system, time: float):
        """The ribbons at `time` as segments, newest first."""
        n, length = int(system.count), self.ribbon.length
        newer, newer_time = np.array(system.floats[MOTION, :n]), time
        for older_time, older, known in self.before(system, time, unwrap=False):
            if time - newer_time >= length:
                return
            older = np.where(known, older, newer)
            drawn = known if system.box is None else known & ~system.box.jumps((newer - older)[POSITION])
            yield self._segment(system, newer, older, drawn, newer_time, older_time, time)
            newer, newer_time = older, older_time

    def _segment(self, system, newer, older, drawn, newer_time: float, older_time: float, time: float) -> Segment:
        floats, n = np.array(system.floats), newer.shape[1]
        floats[POSITION, :n] = newer[POSITION]
        floats[VELOCITY, :n] = (newer - older)[POSITION] / (newer_time - older_time)
        floats[LIFETIME, :n][~drawn] = 0.0  # nothing is drawn without an earlier position, or across a periodic box
        birth = np.array(system.birth)
        birth[:n] = np.where(drawn, np.minimum(birth[:n], older_time), birth[:n])
        ribbon = self.ribbon
        head, end = (min((time - t) / ribbon.length, 1.0) for t in (newer_time, older_time))
        width, end_width = (1.0 - (1.0 - ribbon.taper) * fraction for fraction in (head, end))
        light, end_light = (1.0 - (1.0 - ribbon.tail) * fraction for fraction in (head, end))
        floats[RADIUS, :n] *= width
        system_copy = SimpleNamespace(
            floats=floats, birth=birth, key=system.key, id=system.id, source=system.source, sources=system.sources,
            count=n, channels=system.channels, entries=system.entries, booked=system.booked,
        )  # fmt: skip
        taper, tail = end_width / max(width, 1e-9), end_light / max(light, 1e-9)
        past = PastMotion(np.array([older_time]), older[None], drawn[None])
        return Segment(system_copy, newer_time, newer_time - older_time, newer, past, width, light, taper, tail)


def cut_by_plane(segment: Segment, point, normal) -> None:
    """Leave of a segment, of all particles, the part before a plane.

    point, normal : (3,) of the plane, the normal of length 1
    The light goes by the length that is drawn, so what is left keeps its own.
    """
    system, n = segment.system, segment.system.count
    new, velocity = system.floats[POSITION, :n], system.floats[VELOCITY, :n]
    old = new - velocity * segment.duration
    normal = np.asarray(normal, np.float64)
    above, old_above = (normal @ place - float(np.dot(normal, point)) for place in (new, old))
    # where the segment crosses the plane, as a part of the way from its new end to its old one
    span = above - old_above
    part = np.clip(above / np.where(span != 0.0, span, 1.0), 0.0, 1.0)
    first = np.where(above < 0.0, part, 0.0)
    last = np.where(old_above < 0.0, part, 1.0)
    system.floats[POSITION, :n] = new - velocity * (segment.duration * first)
    system.floats[VELOCITY, :n] = velocity * np.maximum(last - first, 0.0)
    system.floats[LIFETIME, :n][(above < 0.0) & (old_above < 0.0)] = 0.0
