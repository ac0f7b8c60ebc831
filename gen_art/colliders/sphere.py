"""A sphere, solid or hollow."""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.base import Collider, collider
from gen_art.registry import param


@collider("sphere")
class Sphere(Collider):
    """A solid ball, or with `inside` a hollow one that contains the particles.

    distance = abs(x - center) - radius, or radius - abs(x - center) inside

    center : m
    radius : m
    """

    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    radius: float = param(1.0, unit="m", min=1e-30)
    inside: bool = param(False, doc="the particles are inside it")

    @property
    def convex(self) -> bool:  # type: ignore[override]  # only an instance knows on which side the particles are
        return not self.values["inside"]

    def ball(self) -> tuple[np.ndarray, float]:
        return np.array(self.values["center"], np.float64), float(self.values["radius"])

    def surface_area(self) -> float:
        return 0.0 if self.values["inside"] else 4.0 * math.pi * float(self.values["radius"]) ** 2

    @ti.func
    def distance(self, x, q, side):
        d = (x - q.center).norm() - q.radius
        return -d if ti.static(self.values["inside"]) else d

    @ti.func
    def gradient(self, x, q, side):
        r = x - q.center
        length = r.norm()
        up = ti.Vector([0.0, 1.0, 0.0])  # at the centre all directions are equivalent
        n = ti.select(length > 0.0, r / ti.select(length > 0.0, length, 1.0), up)
        return -n if ti.static(self.values["inside"]) else n
