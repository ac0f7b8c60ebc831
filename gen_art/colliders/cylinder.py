"""A cylinder: a solid drum, disc, post or wheel with flat ends."""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.base import Collider, collider
from gen_art.errors import UsageError
from gen_art.registry import param

__all__ = ["Cylinder"]


@collider("cylinder")
class Cylinder(Collider):
    """A solid cylinder with flat ends. Its edges act rounded by a particle's radius, as an edge does on a ball.

    distance = abs(max(d, 0)) + min(max(d_i), 0),  d = (distance from the axis - radius, distance from the middle along the axis
    - half the length)

    a, b : m, the middles of its ends
    radius : m
    Raises UsageError if both ends are in one place.
    """

    convex = True
    faceted = True

    a: tuple = param((0.0, 0.0, 0.0), unit="m", doc="the middle of one end")
    b: tuple = param((0.0, 1.0, 0.0), unit="m", doc="the middle of the other end")
    radius: float = param(0.5, unit="m", min=1e-30)

    def prepare(self):
        super().prepare()
        if math.dist(self.values["a"], self.values["b"]) == 0.0:
            raise UsageError("the ends `a` and `b` of a cylinder must not be in one place: they say where its axis is")

    def ball(self) -> tuple[np.ndarray, float]:
        a, b, radius = (np.array(self.values[key], np.float64) for key in ("a", "b", "radius"))
        return 0.5 * (a + b), math.hypot(0.5 * math.dist(a, b), float(radius))

    def surface_area(self) -> float:
        radius = float(self.values["radius"])
        return 2.0 * math.pi * radius * (radius + math.dist(self.values["a"], self.values["b"]))

    @ti.func
    def across(self, x, q):
        """The vector, m, from the nearest point of the axis, endless, to x."""
        axis, r = (q.b - q.a).normalized(), x - 0.5 * (q.a + q.b)
        return r - axis * r.dot(axis)

    @ti.func
    def outside(self, x, q):
        """(2,) m, how far x is outside of the round face and of the flat ones; negative inside."""
        along = (x - 0.5 * (q.a + q.b)).dot((q.b - q.a).normalized())
        return ti.Vector([self.across(x, q).norm() - q.radius, ti.abs(along) - 0.5 * (q.b - q.a).norm()])

    @ti.func
    def facet(self, x, q):
        """0 on the round face, 1 on a flat one."""
        d = self.outside(x, q)
        return ti.cast(d[1] > d[0], ti.i32)

    @ti.func
    def distance(self, x, q, side):
        d = self.outside(x, q)
        return ti.max(d, 0.0).norm() + ti.min(d.max(), 0.0)

    @ti.func
    def gradient(self, x, q, side):
        axis, across, d = (q.b - q.a).normalized(), self.across(x, q), self.outside(x, q)
        length = across.norm()
        if length > 0.0:
            across /= length
        else:  # on the axis all directions across it are equivalent
            across = axis.cross(
                ti.select(ti.abs(axis[2]) < 0.9, ti.Vector([0.0, 0.0, 1.0]), ti.Vector([1.0, 0.0, 0.0]))
            ).normalized()
        end = ti.select((x - 0.5 * (q.a + q.b)).dot(axis) < 0.0, -axis, axis)
        n = across * ti.max(d[0], 0.0) + end * ti.max(d[1], 0.0)
        if n.norm() > 0.0:
            n = n.normalized()
        else:  # inside: the normal of the nearest face
            n = ti.select(d[1] > d[0], end, across)
        return n
