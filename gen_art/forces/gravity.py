"""Uniform gravity."""

from gen_art.forces.base import Force, force
from gen_art.registry import param
from gen_art.runtime import ti


@force("gravity")
class Gravity(Force):
    """A uniform field.

    a = g;  U = -m g . x

    field : (3,) m/s^2.  Conservative. Source: Landau & Lifshitz, Mechanics, section 5.
    """

    field: tuple = param((0.0, -9.81, 0.0), unit="m/s^2", doc="acceleration")
    conservative = True
    does_work = True

    @ti.func
    def acceleration(self, p, t, q):
        return q.field

    @ti.func
    def potential(self, p, t, q):
        return -p.mass * q.field.dot(p.position)
