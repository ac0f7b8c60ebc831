"""A uniform wind: the simplest velocity field of a medium."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("wind")
class Wind(Force):
    """A uniform, steady velocity of the medium.

    u = velocity
    velocity : (3,) m/s
    Meant for `medium:`; as a force it is a uniform acceleration in m/s^2 without a potential.
    """

    steady = True
    velocity: tuple = param((0.0, 0.0, 0.0), unit="m/s", doc="velocity of the medium")

    @ti.func
    def acceleration(self, p, t, q):
        return q.velocity
