"""A capsule: a rod with round ends."""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.base import Collider, collider
from gen_art.registry import param


@collider("capsule")
class Capsule(Collider):
    """All points within a radius of a segment: a solid rod with round ends.

    distance = abs(x - c) - radius,  c = a + clamp((x - a).(b - a) / abs(b - a)^2, 0, 1) (b - a)

    a, b : m, ends of the segment
    radius : m
    """

    convex = True

    a: tuple = param((0.0, 0.0, 0.0), unit="m", doc="one end of the segment")
    b: tuple = param((0.0, 1.0, 0.0), unit="m", doc="the other end")
    radius: float = param(0.5, unit="m", min=1e-30)

    def ball(self) -> tuple[np.ndarray, float]:
        a, b, radius = (np.array(self.values[key], np.float64) for key in ("a", "b", "radius"))
        return 0.5 * (a + b), 0.5 * math.dist(a, b) + float(radius)

    def surface_area(self) -> float:
        radius = float(self.values["radius"])
        return 4.0 * math.pi * radius * (radius + 0.5 * math.dist(self.values["a"], self.values["b"]))

    @ti.func
    def from_segment(self, x, q):
        """The vector, m, from the nearest point of the segment to x."""
        segment = q.b - q.a
        square = segment.dot(segment)
        t = (x - q.a).dot(segment) / ti.select(square > 0.0, square, 1.0)
        return x - q.a - segment * ti.min(ti.max(t, 0.0), 1.0)

    @ti.func
    def distance(self, x, q, side):
        return self.from_segment(x, q).norm() - q.radius

    @ti.func
    def gradient(self, x, q, side):
        r = self.from_segment(x, q)
        length = r.norm()
        up = ti.Vector([0.0, 1.0, 0.0])
        return ti.select(length > 0.0, r / ti.select(length > 0.0, length, 1.0), up)
