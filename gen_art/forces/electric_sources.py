"""Electric fields of sources: a dipole, a charged wire, a quadrupole trap, a grid."""

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.forces.vector_field import Sampled
from gen_art.maths.elementary import log
from gen_art.registry import param

COULOMB = 8.9875517923e9  # 1 / (4 pi epsilon0), N m^2 / C^2


def _check_axis(source):
    if not any(source.values["axis"]):
        raise UsageError(f"{type(source).__name__}: axis must not be the null vector")


@force("electric_dipole")
class ElectricDipole(Force):
    """The field of two opposite charges close together.

    E = k (3 (d . r) r / s^5 - d / s^3),  U = q k d . r / s^3,  s^2 = abs(r)^2 + softening^2,  r = x - center,
    k = 1 / (4 pi epsilon0)

    moment : d, (3,) C m, from the negative to the positive charge
    softening : m, >= 0
    Conservative. Source: Jackson, Classical Electrodynamics, section 4.1.
    """

    moment: tuple = param((0.0, 1e-10, 0.0), unit="C m")
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    softening: float = param(0.0, unit="m", min=0)
    conservative = True

    @ti.func
    def electric(self, p, t, q):
        r = p.position - q.center
        s2 = r.dot(r) + q.softening * q.softening
        d = q.moment * COULOMB
        return (3.0 * d.dot(r) * r - s2 * d) / (s2 * s2 * ti.sqrt(s2))

    @ti.func
    def potential(self, p, t, q):
        r = p.position - q.center
        s2 = r.dot(r) + q.softening * q.softening
        return p.charge * (q.moment * COULOMB).dot(r) / (s2 * ti.sqrt(s2))


@force("electric_wire")
class ElectricWire(Force):
    """The field of a long straight charged wire.

    E = 2 k charge_density rho / (abs(rho)^2 + core^2),  U = -q k charge_density ln(abs(rho)^2 + core^2),
    rho the distance vector from the wire,  k = 1 / (4 pi epsilon0)

    charge_density : C/m
    core : m, > 0, thickness of the wire
    center : (3,) m, a point of the wire
    axis : (3,), its direction
    Conservative. Source: Jackson, Classical Electrodynamics, section 1.3.
    """

    charge_density: float = param(1e-10, unit="C/m")
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    core: float = param(0.001, unit="m", min=1e-15)
    conservative = True

    def prepare(self):
        _check_axis(self)

    @ti.func
    def _distance_vector(self, p, q):
        n = q.axis / q.axis.norm()
        r = p.position - q.center
        return r - n * r.dot(n)

    @ti.func
    def electric(self, p, t, q):
        rho = self._distance_vector(p, q)
        return rho * (2.0 * COULOMB * q.charge_density / (rho.dot(rho) + q.core * q.core))

    @ti.func
    def potential(self, p, t, q):
        rho = self._distance_vector(p, q)
        return -p.charge * COULOMB * q.charge_density * log(rho.dot(rho) + q.core * q.core)


@force("electric_quadrupole")
class ElectricQuadrupole(Force):
    """The field of a Penning trap's electrodes: it confines charges along its axis and accelerates them away from it.

    E = -voltage / (2 size^2) (2 z n - rho),  U = q voltage / (2 size^2) (z^2 - abs(rho)^2 / 2),  r = x - center = z n + rho
    w_z^2 = q voltage / (m size^2); in a magnetic field B along n, w+- = w_c / 2 +- sqrt(w_c^2 / 4 - w_z^2 / 2), w_c = q B / m

    voltage : V
    size : m, > 0, the trap's characteristic length
    center : (3,) m
    axis : (3,), the direction n
    Conservative. Source: Brown & Gabrielse (1986), Rev. Mod. Phys. 58, 233.
    """

    voltage: float = param(1.0, unit="V")
    size: float = param(1.0, unit="m", min=1e-30)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    conservative = True

    def prepare(self):
        _check_axis(self)

    @ti.func
    def electric(self, p, t, q):
        n = q.axis / q.axis.norm()
        r = (p.position - q.center) / q.size
        return (r - n * (3.0 * r.dot(n))) * (0.5 * q.voltage / q.size)

    @ti.func
    def potential(self, p, t, q):
        n = q.axis / q.axis.norm()
        r = (p.position - q.center) / q.size
        z = r.dot(n)
        return p.charge * q.voltage * (0.75 * z * z - 0.25 * r.dot(r))


@force("electric_grid")
class ElectricGrid(Sampled):
    """An electric field sampled on a grid.

    E = strength V(x), V the trilinear interpolation of the grid's vectors in V/m

    field : a .npy file, picture or array, as of vector_field
    bounds : m, the corners at which the first and the last vector stand
    strength : factor
    outside : zero, or the vectors of the edge
    Does work (no potential is kept). Source: Press and others, Numerical Recipes, section 3.6.
    """

    @ti.func
    def electric(self, p, t, q):
        return self.sampled(p, q)
