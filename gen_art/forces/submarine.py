"""A submarine: a buoyant hull, ballast tanks that flood, and a propeller."""

import math

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import force
from gen_art.forces.controls import Controlled
from gen_art.forces.steering import Lever, Stick
from gen_art.maths.elementary import cos, sin
from gen_art.registry import param


@force("ballast")
class Ballast(Controlled):
    """Buoyancy of a hull with ballast tanks, submerged and at the surface.

    F = -density gravity (volume - flooded tanks) s
    s = 1/2 + (surface - y) / height, limited to 0 (dry) .. 1 (submerged),  y the particle's coordinate along -gravity
    A flooded tank counts as water, not as hull (lost buoyancy).

    volume, tanks : m^3, of the hull and of the tanks in it
    flooded : 0 (blown) to 1 (full)
    density : kg/m^3, of the water
    gravity : (3,) m/s^2
    surface : m, height of the surface
    height : m, of the hull, along gravity
    controls : a .csv file with the columns time (s) and flooded
    It hovers where mass = density (volume - flooded tanks), and oscillates at the surface with
    w^2 = density g (volume - flooded tanks) / (mass height). The ledger records its work.
    Source: Rawson & Tupper, Basic Ship Theory, chapter 3.
    """

    volume: float = param(1.0, unit="m^3", min=0, doc="of the hull")
    tanks: float = param(0.2, unit="m^3", min=0, doc="of the ballast tanks in it")
    flooded: float = param(0.0, min=0, max=1, doc="share of the tanks that holds water")
    density: float = param(1025.0, unit="kg/m^3", min=0, doc="of the water")
    gravity: tuple = param((0.0, -9.81, 0.0), unit="m/s^2")
    surface: float = param(0.0, unit="m", doc="height of the surface")
    height: float = param(1.0, unit="m", min=1e-30, doc="of the hull")
    inputs = ("flooded",)
    steering = {"flooded": Lever(less=("ArrowUp",), more=("ArrowDown",), rate=0.7)}

    def prepare(self):
        super().prepare()
        if self.values["tanks"] > self.values["volume"]:
            raise UsageError(
                f"ballast: tanks of {self.values['tanks']:g} m^3 do not fit in a hull of {self.values['volume']:g} m^3"
            )
        if not any(self.values["gravity"]):
            raise UsageError("ballast: gravity must not be the null vector")

    @ti.func
    def force(self, p, t, q):
        g = q.gravity.norm()
        y = -p.position.dot(q.gravity) / g
        submerged = ti.min(ti.max(0.5 + (q.surface - y) / q.height, 0.0), 1.0)
        return q.gravity * (-q.density * (q.volume - self.recorded(0, t, q) * q.tanks) * submerged)


@force("propeller")
class Propeller(Controlled):
    """A propeller's thrust, with a controlled heading and pitch.

    F = throttle max_thrust (cos(pitch) cos(heading), sin(pitch), -cos(pitch) sin(heading))

    throttle : -1 (astern) to 1
    max_thrust : N
    heading : degrees in YAML and in the file (radians in Python), from x towards -z (to the left, seen from above)
    pitch : degrees, upwards
    controls : a .csv file with the columns time (s) and any of throttle, heading, pitch
    It uses up no mass. The ledger records its work.
    """

    max_thrust: float = param(100.0, unit="N", min=0)
    throttle: float = param(1.0, min=-1, max=1)
    heading: float = param(0.0, unit="rad")
    pitch: float = param(0.0, unit="rad", min=-1.5707963267948966, max=1.5707963267948966)
    inputs = ("throttle", "heading", "pitch")
    steering = {
        "throttle": Lever(less=("s",), more=("w",), low=-1.0, rate=0.8),
        "heading": Lever(less=("ArrowRight", "d"), more=("ArrowLeft", "a"), low=-math.inf, high=math.inf, rate=40.0),
        "pitch": Stick(less=("e",), more=("q",), low=-30.0, high=30.0, seconds=0.5),
    }

    @ti.func
    def force(self, p, t, q):
        thrust, heading, pitch = self.recorded(0, t, q) * q.max_thrust, self.recorded(1, t, q), self.recorded(2, t, q)
        horizontal = cos(pitch)
        return ti.Vector([horizontal * cos(heading), sin(pitch), -horizontal * sin(heading)]) * thrust
