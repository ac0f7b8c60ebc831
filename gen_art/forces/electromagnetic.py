"""Electric and magnetic fields that act on charges."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.forces.field_functions import field_of
from gen_art.registry import param


@force("electric_field")
class ElectricField(Force):
    """A uniform electric field.

    F = q E,  U = -q E . x
    field : (3,) V/m
    Conservative. In Python `field` may also be a source: a force with an electric field, a @ti.func of (p, t, q), or a grid's
    path or array.
    """

    def __new__(cls, field=None, *args, **options):
        return field_of("electric", field, options) or super().__new__(cls)

    field: tuple = param((0.0, 0.0, 0.0), unit="V/m")
    conservative = True

    @ti.func
    def electric(self, p, t, q):
        return q.field

    @ti.func
    def potential(self, p, t, q):
        return -p.charge * q.field.dot(p.position)


@force("magnetic_field")
class MagneticField(Force):
    """A uniform magnetic field.

    F = q v x B
    field : (3,) T
    Does no work. Use the `boris` integrator. In Python `field` may also be a source: a force with a magnetic field, a @ti.func of
    (p, t, q), or a grid's path or array.
    """

    def __new__(cls, field=None, *args, **options):
        return field_of("magnetic", field, options) or super().__new__(cls)

    field: tuple = param((0.0, 0.0, 0.0), unit="T")
    does_work = False
    depends_on_velocity = True

    @ti.func
    def magnetic(self, p, t, q):
        return q.field


@force("magnetic_mirror")
class MagneticMirror(Force):
    """A magnetic bottle: a field along an axis that grows on either side of the centre, to second order in the distance.

    B_z = strength (1 + z^2 / L^2 - rho^2 / (2 L^2)),  B_rho = -strength rho z / L^2: curl-free and divergence-free

    strength : T, at the centre
    length : L, m, > 0
    center : (3,) m
    axis : (3,)
    Does no work. Use the `boris` integrator.
    Source: the vacuum field on an axis, expanded; Chen, Introduction to Plasma Physics, section 2.3.
    """

    strength: float = param(1.0, unit="T")
    length: float = param(1.0, unit="m", min=1e-30)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    does_work = False
    depends_on_velocity = True

    @ti.func
    def magnetic(self, p, t, q):
        n = q.axis / ti.max(q.axis.norm(), 1e-30)
        r = (p.position - q.center) / q.length
        z = r.dot(n)
        rho = r - n * z
        return q.strength * (n * (1.0 + z * z - 0.5 * rho.dot(rho)) - rho * z)
