"""Small jets that push a spacecraft along the axes."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import force
from gen_art.forces.controls import Controlled
from gen_art.forces.steering import Stick
from gen_art.registry import param


@force("thruster")
class Thruster(Controlled):
    """The jets of a spacecraft, along the axes of the scene, with control inputs over time.

    F = max_thrust (x, y, z),  and where abs((x, y, z)) > 1, max_thrust (x, y, z) / abs((x, y, z))

    max_thrust : N
    x, y, z : -1 to 1, the share of the thrust along each axis
    controls : a .csv file with the columns time (s) and any of x, y, z, linear between its rows
    It uses up no mass (`thrust` burns its own). The ledger records its work.
    """

    max_thrust: float = param(1.0, unit="N", min=0)
    x: float = param(0.0, min=-1, max=1)
    y: float = param(0.0, min=-1, max=1)
    z: float = param(0.0, min=-1, max=1)
    inputs = ("x", "y", "z")
    steering = {
        "x": Stick(less=("ArrowLeft", "a"), more=("ArrowRight", "d"), seconds=0.1),
        "y": Stick(less=("ArrowDown", "s"), more=("ArrowUp", "w"), seconds=0.1),
        "z": Stick(less=("e",), more=("q",), seconds=0.1),
    }

    @ti.func
    def force(self, p, t, q):
        share = ti.Vector([self.recorded(0, t, q), self.recorded(1, t, q), self.recorded(2, t, q)])
        return share * (q.max_thrust / ti.max(share.norm(), 1.0))
