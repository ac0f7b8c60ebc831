"""A point that pulls and moves: gravity in a hand."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import force
from gen_art.forces.controls import Controlled
from gen_art.forces.steering import Button, Pointer
from gen_art.registry import param


@force("attractor")
class Attractor(Controlled):
    """The field of a point mass that moves along a recorded path, and that can be switched.

    a = -pull GM r / s^3,  s^2 = abs(r)^2 + softening^2,  r = p - (x, y, z)(t)

    GM : m^3/s^2
    softening : m, >= 0
    pull : 1 pulls, 0 does nothing, -1 pushes
    x, y, z : m, its position
    controls : a .csv file with the columns time (s) and any of pull, x, y, z, linear between its rows
    The ledger records its work. At rest, with a pull of 1, it is `point_gravity`.
    """

    GM: float = param(1.0, unit="m^3/s^2", min=0)
    softening: float = param(0.0, unit="m", min=0)
    pull: float = param(1.0, min=-1, max=1)
    x: float = param(0.0, unit="m")
    y: float = param(0.0, unit="m")
    z: float = param(0.0, unit="m")
    inputs = ("pull", "x", "y", "z")
    steering = {
        "pull": Button(less=("x",), more=("mouse", " ")), "x": Pointer(axis=0), "y": Pointer(axis=1),
        "z": Pointer(axis=2),
    }  # fmt: skip

    @ti.func
    def acceleration(self, p, t, q):
        r = p.position - ti.Vector([self.recorded(1, t, q), self.recorded(2, t, q), self.recorded(3, t, q)])
        s2 = r.dot(r) + q.softening * q.softening
        return r * (-self.recorded(0, t, q) * q.GM / (s2 * ti.sqrt(s2)))
