"""A torus: a ring of round section, whole or an arc of it with round ends."""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.base import Collider, collider
from gen_art.errors import UsageError
from gen_art.registry import param

__all__ = ["Torus"]

_TOWARD, _HALF_ARC = 0, 3  # in the table: a unit vector, and the cosine and sine of half the arc


@collider("torus")
class Torus(Collider):
    """All points within the radius `tube` of a circle, or of an arc of it: a solid ring, coil, tyre or hook.

    distance = abs(x - c) - tube,  c the nearest point of the arc

    center : m, of the circle
    radius : m, of the circle
    tube : m, radius of the round section, at most the circle's radius
    axis : perpendicular to the circle, of any length but 0
    arc : degrees in YAML (radians in Python), how much of the circle there is, half of it on either side of `toward`
    toward : from the centre to the middle of the arc; what of it is along the axis is left out
    Raises UsageError for a tube that is wider than the circle, and for `toward` along the axis.
    """

    has_clear_way = True

    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    radius: float = param(1.0, unit="m", min=1e-30)
    tube: float = param(0.1, unit="m", min=1e-30)
    axis: tuple = param((0.0, 1.0, 0.0), doc="perpendicular to the circle")
    arc: float = param(2 * math.pi, unit="rad", min=1e-3, max=2 * math.pi + 1e-9, doc="360 is the whole circle")
    toward: tuple = param(
        None, kind="vector", doc="to the middle of the arc; a direction across the axis when left out"
    )

    tabled = True

    def prepare(self):
        super().prepare()
        self.unit("axis")
        v = self.values
        if v["tube"] > v["radius"]:
            raise UsageError(
                f"a torus's tube must be at most as wide as its circle, radius {v['radius']:g} m, not {v['tube']:g}"
            )
        axis = np.array(v["axis"])
        guess = v["toward"] if v["toward"] is not None else np.eye(3)[np.argmin(np.abs(axis))]
        across = np.array(guess, float)
        length = float(np.sqrt((across * across).sum()))
        across -= axis * float((across * axis).sum())
        rest = float(np.sqrt((across * across).sum()))
        if rest <= 1e-9 * length:
            raise UsageError("a torus's `toward` must not be along its axis: it says where on the circle the arc is")
        self._toward = across / rest

    def table(self) -> np.ndarray:
        half = 0.5 * self.values["arc"]
        # no point is farther round than the whole circle reaches, whatever the rounding of its angle
        cosine = -2.0 if half >= math.pi else math.cos(half)
        return np.array([*self._toward, cosine, math.sin(half)])

    def ball(self) -> tuple[np.ndarray, float]:
        return np.array(self.values["center"], np.float64), float(self.values["radius"] + self.values["tube"])

    @ti.func
    def from_circle(self, x, q):
        """The vector, m, from the nearest point of the arc to x."""
        r = x - q.center
        toward = ti.Vector([q.table(_TOWARD), q.table(_TOWARD + 1), q.table(_TOWARD + 2)])
        cosine, sine = q.table(_HALF_ARC), q.table(_HALF_ARC + 1)
        flat = r - q.axis * r.dot(q.axis)
        length = flat.norm()
        nearest = toward
        if length > 0.0:
            nearest = flat / length
        if nearest.dot(toward) < cosine:
            side = q.axis.cross(toward)
            nearest = toward * cosine + side * ti.select(flat.dot(side) < 0.0, -sine, sine)
        return r - nearest * q.radius

    @ti.func
    def distance(self, x, q, side):
        return self.from_circle(x, q).norm() - q.tube

    @ti.func
    def ray_span(self, o, d, q, radius, tangent):
        """Where the ray is in a ball about the torus and between two planes across its axis, a tenth of its tube beyond it."""
        r, beyond = o - q.center, 1.1 * q.tube + radius
        along = -r.dot(d)
        if tangent < 0.99:  # the cone is widest where it leaves the ball
            beyond += tangent * ti.max((along + q.radius + beyond) / (1.0 - tangent), 0.0)
        nearest = r + d * along  # not by the difference of two squares, which is all rounding from far away
        square = (q.radius + beyond) * (q.radius + beyond) - nearest.dot(nearest)
        first, last = 1e30, -1e30
        if tangent >= 0.99:
            first, last = -1e30, 1e30
        elif square > 0.0:
            first, last = along - ti.sqrt(square), along + ti.sqrt(square)
            height, slope = r.dot(q.axis), d.dot(q.axis)
            if abs(slope) > 1e-6:
                middle, half = -height / slope, beyond / abs(slope)
                first, last = ti.max(first, middle - half), ti.min(last, middle + half)
        return ti.Vector([first, last])

    @ti.func
    def clear_way(self, q):
        """The chord, at that slope, of the circle round the hole, in which the surface bends inward most."""
        return 0.2 * (q.radius - q.tube)

    @ti.func
    def gradient(self, x, q, side):
        r = self.from_circle(x, q)
        length = r.norm()
        return ti.select(length > 0.0, r / ti.select(length > 0.0, length, 1.0), q.axis)
