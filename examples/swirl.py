"""A force of one's own: a solid-body push around the y axis.

Use it from a preset:   gen-art render examples/swirl.yaml -o swirl.mp4 --plugin examples/swirl.py --plugin examples/spiral.py
or from Python:         from examples.swirl import Swirl;  ga.ParticleSystem(..., forces=[Swirl(strength=2.0)])
"""

import gen_art as ga
from gen_art import ti


@ga.force("swirl")
class Swirl(ga.Force):
    """A solid-body push around the y axis.

    a = strength (r x y)

    strength : 1/s^2.  Does work: a particle that goes round gains energy on each turn, so there is no potential.
    """

    strength: float = ga.param(1.0, unit="1/s^2", doc="push for each metre from the axis")

    @ti.func
    def acceleration(self, p, t, q):
        # p is the particle; q holds the run-time numbers, so that another strength compiles nothing
        return q.strength * ti.Vector([-p.position.z, 0.0, p.position.x])
