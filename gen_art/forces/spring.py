"""A spring to a fixed point."""

from gen_art.forces.base import Force, force
from gen_art.registry import param
from gen_art.runtime import ti


@force("spring")
class Spring(Force):
    """A linear spring from a fixed point.

    F = -stiffness (abs(r) - rest_length) n,  n = r / abs(r),  r = x - center
    U = stiffness (abs(r) - rest_length)^2 / 2

    stiffness : N/m, >= 0     rest_length : m, >= 0.  Conservative.
    """

    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    stiffness: float = param(1.0, unit="N/m", min=0)
    rest_length: float = param(0.0, unit="m", min=0)
    conservative = True

    @ti.func
    def force(self, p, t, q):
        r = p.position - q.center
        length = ti.max(r.norm(), 1e-30)
        return r * (-q.stiffness * (length - q.rest_length) / length)

    @ti.func
    def potential(self, p, t, q):
        stretch = (p.position - q.center).norm() - q.rest_length
        return 0.5 * q.stiffness * stretch * stretch
