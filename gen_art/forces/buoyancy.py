"""Buoyancy: of a sphere in a fluid, and of hot gas in air."""

import math

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.maths.elementary import exp
from gen_art.registry import param


@force("buoyancy")
class Buoyancy(Force):
    """Archimedes' buoyancy of the particle's sphere.

    F = -fluid_density (4/3) pi radius^3 gravity s
    without a surface: s = 1,  U = fluid_density (4/3) pi radius^3 gravity . x
    with a surface: s = (2 + 3 c - c^3) / 4, the submerged share of the sphere,  c = (surface - y) / radius limited to -1..1,
        y the particle's coordinate along -gravity

    fluid_density : kg/m^3, >= 0
    gravity : (3,) m/s^2, the field that makes the pressure
    surface : m, the height above which there is no fluid
    Conservative. A sphere of density rho floats where s = rho / fluid_density, and oscillates there with
    w^2 = 3 g fluid_density (1 - c^2) / (4 radius rho).
    """

    fluid_density: float = param(1.2, unit="kg/m^3", min=0)
    gravity: tuple = param((0.0, -9.81, 0.0), unit="m/s^2")
    surface: float = param(None, unit="m", doc="height of the fluid's surface; none when left out")
    conservative = True

    @property
    def fixed(self) -> tuple:
        return (*super().fixed, self.has_surface)

    @property
    def has_surface(self) -> bool:
        return self.values["surface"] is not None

    @ti.func
    def force(self, p, t, q):
        buoyancy = q.gravity * (-q.fluid_density * (4.0 / 3.0 * math.pi) * p.radius**3)
        if ti.static(self.has_surface):
            c = self._depth(p, q)
            buoyancy *= 0.25 * (2.0 + 3.0 * c - c * c * c)
        return buoyancy

    @ti.func
    def potential(self, p, t, q):
        displaced_mass = q.fluid_density * (4.0 / 3.0 * math.pi) * p.radius**3
        energy = displaced_mass * q.gravity.dot(p.position)
        if ti.static(self.has_surface):
            g, c = q.gravity.norm(), self._depth(p, q)
            h = q.surface + p.position.dot(q.gravity) / ti.max(g, 1e-30)
            height = p.radius * (3.0 + 8.0 * c + 6.0 * c * c - c**4) / 16.0 + ti.max(h - p.radius, 0.0)
            energy = displaced_mass * g * height
        return energy

    @ti.func
    def _depth(self, p, q):
        """Depth of the centre below the surface, in radii, from -1 (dry) to 1 (submerged)."""
        h = q.surface + p.position.dot(q.gravity) / ti.max(q.gravity.norm(), 1e-30)
        return ti.min(ti.max(h / ti.max(p.radius, 1e-30), -1.0), 1.0)


@force("thermal_lift")
class ThermalLift(Force):
    """The net buoyancy of a parcel of hot gas in cooler air of the same pressure, which cools with its age.

    a = -gravity (T / ambient - 1),  T = end + (start - end) exp(-age / cooling);  the parcel's own weight is included

    start, end, ambient : K, > 0
    cooling : s, > 0
    gravity : (3,) m/s^2
    Does work; time-dependent, no potential.
    """

    start: float = param(353.0, unit="K", min=1e-3, doc="temperature at birth")
    end: float = param(293.0, unit="K", min=1e-3, doc="temperature in the end")
    cooling: float = param(2.0, unit="s", min=1e-9, doc="time in which the excess falls to 1/e")
    ambient: float = param(293.0, unit="K", min=1e-3, doc="temperature of the air")
    gravity: tuple = param((0.0, -9.81, 0.0), unit="m/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        temperature = q.end + (q.start - q.end) * exp(-p.age / q.cooling)
        return q.gravity * (1.0 - temperature / q.ambient)
