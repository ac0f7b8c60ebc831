"""Drag and damping against the medium's velocity."""

import math

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("drag")
class Drag(Force):
    """Linear and quadratic drag on the particle, in newtons, against a moving medium.

    F = -linear w - (quadratic + 1/2 density cd pi radius^2) abs(w) w,  w = v - u(x, t)

    linear : kg/s, >= 0
    quadratic : kg/m, >= 0
    cd : drag coefficient of the particle's sphere, >= 0
    density : kg/m^3 of the fluid, for cd; the medium's when left out
    medium : a ga.Medium; the system's when left out
    Dissipative. Source: Landau & Lifshitz, Fluid Mechanics, sections 20 and 45.
    """

    steady = True
    drags_on_mass = True
    linear: float = param(0.0, unit="kg/s", min=0)
    quadratic: float = param(0.0, unit="kg/m", min=0)
    medium: object = param(None)
    cd: float = param(0.0, min=0, doc="drag coefficient of a sphere of the particle's radius")
    density: float = param(None, unit="kg/m^3", min=0, doc="of the fluid; the medium's when left out")
    dissipative = True

    @property
    def needs_density(self) -> bool:
        return bool(self.values["cd"])

    @ti.func
    def damping(self, p, t, q):
        area = math.pi * p.radius * p.radius
        return ti.Vector([q.linear, q.quadratic + 0.5 * q.density * q.cd * area]) / p.mass


@force("damping")
class Damping(Force):
    """Relaxation towards the medium's velocity, whatever the particle's mass.

    a = -rate (v - u(x, t));  after the time 1/rate, 1/e of the difference is left

    rate : 1/s, >= 0
    medium : a ga.Medium; the system's when left out
    Dissipative.
    """

    steady = True
    rate: float = param(1.0, unit="1/s", min=0)
    medium: object = param(None)
    dissipative = True
    quadratic_damping = False
    damping_reads_particle = False

    @ti.func
    def damping(self, p, t, q):
        return ti.Vector([q.rate, 0.0])
