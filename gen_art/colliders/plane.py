"""A plane: floor, wall or slope."""

from gen_art.backend.runtime import ti
from gen_art.colliders.base import Collider, collider
from gen_art.registry import param


@collider("plane")
class Plane(Collider):
    """A plane that keeps particles on the side its normal points to.

    distance = (x - point).normal / abs(normal)

    point : m, a point of the plane
    normal : of any length but 0
    """

    convex = flat = True

    point: tuple = param((0.0, 0.0, 0.0), unit="m")
    normal: tuple = param((0.0, 1.0, 0.0), doc="points to the side of the particles")

    def prepare(self):
        super().prepare()
        self.unit("normal")

    @ti.func
    def distance(self, x, q, side):
        return (x - q.point).dot(q.normal)

    @ti.func
    def gradient(self, x, q, side):
        return q.normal
