"""A spring to a fixed point, and a spring to a moving hand."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.forces.controls import Controlled
from gen_art.forces.steering import Pointer
from gen_art.registry import param


@force("spring")
class Spring(Force):
    """A linear spring to a fixed point.

    F = -stiffness (abs(r) - rest_length) n,  n = r / abs(r),  r = x - center
    U = stiffness (abs(r) - rest_length)^2 / 2
    slack: both are 0 where abs(r) < rest_length, as for an elastic cord

    stiffness : N/m, >= 0
    rest_length : m, >= 0
    Conservative.
    """

    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    stiffness: float = param(1.0, unit="N/m", min=0)
    rest_length: float = param(0.0, unit="m", min=0)
    slack: bool = param(False, doc="no force when shorter than rest_length, as a cord")
    conservative = True

    @ti.func
    def force(self, p, t, q):
        r = p.position - q.center
        length = ti.max(r.norm(), 1e-30)
        stretch = length - q.rest_length
        if ti.static(self.values["slack"]):
            stretch = ti.max(stretch, 0.0)
        return r * (-q.stiffness * stretch / length)

    @ti.func
    def potential(self, p, t, q):
        stretch = (p.position - q.center).norm() - q.rest_length
        if ti.static(self.values["slack"]):
            stretch = ti.max(stretch, 0.0)
        return 0.5 * q.stiffness * stretch * stretch


@force("hand")
class Hand(Controlled):
    """A spring, or a cord, to a hand that moves along a recorded path and drags the particles behind it.

    F = -stiffness (abs(r) - rest_length) n,  n = r / abs(r),  r = p - (x, y, z)(t);  0 where abs(r) < rest_length

    stiffness : N/m, >= 0
    rest_length : m, >= 0; 0 for a spring
    x, y, z : m, position of the hand
    controls : a .csv file with the columns time (s) and any of x, y, z, linear between its rows
    The ledger records the hand's work. Behind a hand of constant velocity v, under drag of c kg/s, the lag becomes
    c v / stiffness.
    Source: Feynman, Lectures on Physics I, chapter 23, for the oscillator with a driven end.
    """

    stiffness: float = param(1.0, unit="N/m", min=0)
    rest_length: float = param(0.0, unit="m", min=0, doc="length up to which it is slack")
    x: float = param(0.0, unit="m")
    y: float = param(0.0, unit="m")
    z: float = param(0.0, unit="m")
    inputs = ("x", "y", "z")
    steering = {"x": Pointer(axis=0), "y": Pointer(axis=1), "z": Pointer(axis=2)}

    @ti.func
    def force(self, p, t, q):
        r = p.position - ti.Vector([self.recorded(0, t, q), self.recorded(1, t, q), self.recorded(2, t, q)])
        length = ti.max(r.norm(), 1e-30)
        return r * (-q.stiffness * ti.max(length - q.rest_length, 0.0) / length)
