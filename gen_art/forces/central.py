"""Forces towards a point."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.maths.elementary import log, power
from gen_art.registry import param


@force("central_force")
class CentralForce(Force):
    """A softened power law about a centre, per unit mass or per unit charge.

    a = -strength s^(exponent - 1) r,  s^2 = abs(r)^2 + softening^2,  r = x - center;  times charge / mass if per_charge
    U = m strength s^(exponent + 1) / (exponent + 1), or m strength ln s for exponent -1

    strength : m^(1 - exponent) / s^2 (N m^-exponent / C if per_charge)
    exponent : -6 to 6
    softening : m, >= 0
    Conservative. Source: Landau & Lifshitz, Mechanics, section 14.
    """

    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    strength: float = param(1.0)
    exponent: float = param(-2.0, min=-6, max=6)
    softening: float = param(0.0, unit="m", min=0)
    per_charge: bool = param(False, doc="the strength is per unit charge instead of mass")
    conservative = True

    @ti.func
    def force(self, p, t, q):
        r = p.position - q.center
        s = ti.sqrt(r.dot(r) + q.softening * q.softening)
        return r * (-self.mass_or_charge(p) * q.strength * power(s, q.exponent - 1.0))

    @ti.func
    def mass_or_charge(self, p):
        return p.charge if ti.static(self.values["per_charge"]) else p.mass

    @ti.func
    def potential(self, p, t, q):
        r = p.position - q.center
        s = ti.sqrt(r.dot(r) + q.softening * q.softening)
        n = q.exponent + 1.0
        logarithmic = ti.abs(n) < 1e-12
        u = ti.select(logarithmic, log(s), power(s, n) / ti.select(logarithmic, 1.0, n))
        return self.mass_or_charge(p) * q.strength * u


@force("point_gravity")
class PointGravity(Force):
    """The field of a point mass, softened after Plummer.

    a = -GM r / s^3,  U = -m GM / s,  s^2 = abs(r)^2 + softening^2,  r = x - center

    GM : m^3/s^2
    softening : m, >= 0
    Conservative.
    """

    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    GM: float = param(1.0, unit="m^3/s^2")
    softening: float = param(0.0, unit="m", min=0)
    conservative = True

    @ti.func
    def acceleration(self, p, t, q):
        r = p.position - q.center
        s2 = r.dot(r) + q.softening * q.softening
        return r * (-q.GM / (s2 * ti.sqrt(s2)))

    @ti.func
    def potential(self, p, t, q):
        r = p.position - q.center
        return -p.mass * q.GM / ti.sqrt(r.dot(r) + q.softening * q.softening)


@force("hernquist")
class Hernquist(Force):
    """The field of a Hernquist sphere: a bulge, or a halo of dark matter.

    a = -GM r / (abs(r) (abs(r) + scale)^2),  U = -m GM / (abs(r) + scale),  r = x - center

    GM : m^3/s^2
    scale : m, > 0
    Conservative. Source: Hernquist (1990), ApJ 356, 359.
    """

    GM: float = param(1.0, unit="m^3/s^2", min=0)
    scale: float = param(1.0, unit="m", min=1e-30)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    conservative = True

    @ti.func
    def acceleration(self, p, t, q):
        r = p.position - q.center
        distance = r.norm()
        s = distance + q.scale
        return r * (-q.GM / (ti.max(distance, 1e-30) * s * s))

    @ti.func
    def potential(self, p, t, q):
        return -p.mass * q.GM / ((p.position - q.center).norm() + q.scale)
