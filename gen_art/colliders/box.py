"""Boxes along the axes: a hollow one that contains particles, and a solid one."""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.base import Collider, collider
from gen_art.errors import UsageError
from gen_art.registry import param


@collider("box")
class Box(Collider):
    """A box along the axes that keeps particles inside. Its six walls are separate surfaces, so that corners are exact.

    distance = x_i - min_i or max_i - x_i, for each wall

    min, max : m, opposite corners, min below max
    """

    sides = 6
    convex = True

    min: tuple = param((-1.0, -1.0, -1.0), unit="m")
    max: tuple = param((1.0, 1.0, 1.0), unit="m")

    def prepare(self):
        super().prepare()
        check_corners(self)

    @ti.func
    def nearest(self, x, q):
        return ti.min(x - q.min, q.max - x).min()

    @ti.func
    def distance(self, x, q, side):
        d = x[0] - q.min[0]
        for axis in ti.static(range(3)):
            if side == 2 * axis:
                d = x[axis] - q.min[axis]
            if side == 2 * axis + 1:
                d = q.max[axis] - x[axis]
        return d

    @ti.func
    def gradient(self, x, q, side):
        n = x * 0.0
        for axis in ti.static(range(3)):
            if side == 2 * axis:
                n[axis] = 1.0
            if side == 2 * axis + 1:
                n[axis] = -1.0
        return n


@collider("block")
class Block(Collider):
    """A solid box along the axes. Its edges and corners act rounded by a particle's radius, as an edge does on a ball.

    distance = abs(max(d, 0)) + min(max(d_i), 0),  d = max(min - x, x - max)

    min, max : m, opposite corners, min below max
    """

    convex = flat = True
    faceted = True

    min: tuple = param((-1.0, -1.0, -1.0), unit="m")
    max: tuple = param((1.0, 1.0, 1.0), unit="m")

    def prepare(self):
        super().prepare()
        check_corners(self)

    def ball(self) -> tuple[np.ndarray, float]:
        low, high = (np.array(self.values[key], np.float64) for key in ("min", "max"))
        return 0.5 * (low + high), 0.5 * math.dist(low, high)

    def surface_area(self) -> float:
        a, b, c = (high - low for low, high in zip(self.values["min"], self.values["max"]))
        return 2.0 * (a * b + b * c + c * a)

    @ti.func
    def facet(self, x, q):
        """The axis that the face lies across."""
        d = ti.max(q.min - x, x - q.max)
        result = 2
        if d[0] >= d[1] and d[0] >= d[2]:
            result = 0
        elif d[1] >= d[2]:
            result = 1
        return result

    @ti.func
    def distance(self, x, q, side):
        d = ti.max(q.min - x, x - q.max)
        return ti.max(d, 0.0).norm() + ti.min(d.max(), 0.0)

    @ti.func
    def gradient(self, x, q, side):
        d = ti.max(q.min - x, x - q.max)
        sign = ti.select(x - q.max > q.min - x, x * 0.0 + 1.0, x * 0.0 - 1.0)
        out = ti.max(d, 0.0)
        n = out * sign
        length = out.norm()
        if length > 0.0:
            n /= length
        else:  # inside: the normal of the nearest face
            found = 0
            for axis in ti.static(range(3)):
                n[axis] = 0.0
                if found == 0 and d[axis] == d.max():
                    n[axis] = sign[axis]
                    found = 1
        return n


def check_corners(box) -> None:
    """Raise UsageError unless min is below max on every axis."""
    for axis, low, high in zip("xyz", box.values["min"], box.values["max"]):
        if low >= high:
            raise UsageError(f"min must be below max on every axis: {axis} runs from {low:g} to {high:g}")
