"""Upthrust: of a sphere in a fluid, and of hot gas in air."""

import math

from gen_art.elementary import exp
from gen_art.forces.base import Force, force
from gen_art.registry import param
from gen_art.runtime import ti


@force("buoyancy")
class Buoyancy(Force):
    """Archimedes' upthrust on the particle's sphere.

    F = -fluid_density (4/3) pi radius^3 gravity;  U = fluid_density (4/3) pi radius^3 gravity . x

    fluid_density : kg/m^3, >= 0     gravity : (3,) m/s^2, the field that makes the pressure.  Conservative.
    """

    fluid_density: float = param(1.2, unit="kg/m^3", min=0)
    gravity: tuple = param((0.0, -9.81, 0.0), unit="m/s^2")
    conservative = True

    @ti.func
    def force(self, p, t, q):
        return q.gravity * (-q.fluid_density * (4.0 / 3.0 * math.pi) * p.radius**3)

    @ti.func
    def potential(self, p, t, q):
        return q.fluid_density * (4.0 / 3.0 * math.pi) * p.radius**3 * q.gravity.dot(p.position)


@force("thermal_lift")
class ThermalLift(Force):
    """The net upthrust of a parcel of hot gas in cooler air of the same pressure, cooling with its age.

    a = -gravity (T / ambient - 1),  T = end + (start - end) exp(-age / cooling);  the parcel's own weight is included

    start, end, ambient : K, > 0     cooling : s, > 0     gravity : (3,) m/s^2.  Does work; time-dependent, no potential.
    """

    start: float = param(353.0, unit="K", min=1e-3, doc="temperature at birth")
    end: float = param(293.0, unit="K", min=1e-3, doc="temperature it tends to")
    cooling: float = param(2.0, unit="s", min=1e-9, doc="time in which the excess falls to 1/e")
    ambient: float = param(293.0, unit="K", min=1e-3, doc="temperature of the air")
    gravity: tuple = param((0.0, -9.81, 0.0), unit="m/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        temperature = q.end + (q.start - q.end) * exp(-p.age / q.cooling)
        return q.gravity * (1.0 - temperature / q.ambient)
