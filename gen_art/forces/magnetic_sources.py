"""Magnetic fields of sources: a dipole, a wire, a loop of current, a grid."""

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.forces.vector_field import Sampled
from gen_art.registry import param

MU0_4PI = 1e-7  # mu0 / (4 pi), T m / A, to 2e-10
_AGM_STEPS = 6  # steps of the arithmetic-geometric mean: float64 down to a complementary modulus of 1e-4


def _check_axis(source):
    if not any(source.values["axis"]):
        raise UsageError(f"{type(source).__name__}: axis must not be the null vector")


@force("magnetic_dipole")
class MagneticDipole(Force):
    """The field of a small magnet, or of a planet at a distance.

    B = mu0 / (4 pi) (3 (m . r) r + (2 softening^2 - r^2) m) / s^5 = curl (mu0 / (4 pi) m x r / s^3),
    s^2 = r^2 + softening^2,  r = x - center

    moment : m, (3,) A m^2
    softening : m, >= 0
    center : (3,) m
    Divergence-free. Does no work. Use the `boris` integrator.
    Source: Jackson, Classical Electrodynamics, section 5.6.
    """

    moment: tuple = param((0.0, 1.0, 0.0), unit="A m^2")
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    softening: float = param(0.0, unit="m", min=0)
    does_work = False
    depends_on_velocity = True

    @ti.func
    def magnetic(self, p, t, q):
        r = p.position - q.center
        e2 = q.softening * q.softening
        r2 = r.dot(r)
        s2 = r2 + e2
        return (3.0 * q.moment.dot(r) * r + (2.0 * e2 - r2) * q.moment) * (MU0_4PI / (s2 * s2 * ti.sqrt(s2)))


@force("magnetic_wire")
class MagneticWire(Force):
    """The field of a long straight wire.

    B = mu0 current / (2 pi) n x rho / (abs(rho)^2 + core^2),  rho the distance vector from the wire, n along its axis

    current : A, along the axis
    core : m, >= 0, thickness of the wire
    center : (3,) m, a point of the wire
    axis : (3,), its direction
    Divergence-free. Does no work. Use the `boris` integrator. Source: Jackson, Classical Electrodynamics, section 5.2.
    """

    current: float = param(1.0, unit="A")
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    core: float = param(0.0, unit="m", min=0)
    does_work = False
    depends_on_velocity = True

    def prepare(self):
        _check_axis(self)

    @ti.func
    def magnetic(self, p, t, q):
        n = q.axis / q.axis.norm()
        r = p.position - q.center
        rho = r - n * r.dot(n)
        return n.cross(rho) * (2.0 * MU0_4PI * q.current / ti.max(rho.dot(rho) + q.core * q.core, 1e-30))


@force("magnetic_loop")
class MagneticLoop(Force):
    """The field of a circular loop of current, everywhere: a coil; two of them make a magnetic bottle.

    B_z = b (K + (a^2 - rho^2 - z^2) / d^2 E),  B_rho = b z / rho ((a^2 + rho^2 + z^2) / d^2 E - K),  a the radius,
    b = mu0 current / (2 pi) / D,  D^2 = (a + rho)^2 + z^2,  d^2 = (a - rho)^2 + z^2,  K and E of the modulus 4 a rho / D^2;
    on the axis B_z = mu0 current a^2 / (2 (a^2 + z^2)^(3/2)).  A `core` adds core^2 to z^2 in D, d and B_z.

    current : A, right-handed about the axis
    radius : m, > 0
    core : m, >= 0, thickness of the wire
    center : (3,) m
    axis : (3,)
    Divergence-free. Does no work. Use the `boris` integrator. K and E by the arithmetic-geometric mean.
    Source: Smythe, Static and Dynamic Electricity, section 7.10; Abramowitz & Stegun, section 17.6.
    """

    current: float = param(1.0, unit="A")
    radius: float = param(1.0, unit="m", min=1e-30)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    core: float = param(0.0, unit="m", min=0)
    does_work = False
    depends_on_velocity = True

    def prepare(self):
        _check_axis(self)

    @ti.func
    def magnetic(self, p, t, q):
        n = q.axis / q.axis.norm()
        r = (p.position - q.center) / q.radius  # all lengths in radii
        z = r.dot(n)
        rho = r - n * z
        rho2 = rho.dot(rho)
        distance = ti.sqrt(rho2)
        z2 = z * z + (q.core / q.radius) ** 2
        far2 = (1.0 + distance) ** 2 + z2
        near2 = ti.max((1.0 - distance) ** 2 + z2, 1e-20)
        k2 = 4.0 * distance / far2
        complement = near2 / far2  # 1 - k2
        # agm(1, sqrt(complement)); E / K = 1 - k2 / 2 - k2^2 tail, so that B_rho loses no digits at small rho
        a, b = 0.5 * (1.0 + ti.sqrt(complement)), ti.sqrt(ti.sqrt(complement))
        term = 0.25 / (1.0 + ti.sqrt(complement)) ** 2  # c_n^2 / k2^2
        tail, weight = term, 1.0
        for _ in ti.static(range(_AGM_STEPS)):
            mean = 0.5 * (a + b)
            term *= term * k2 * k2 / (16.0 * mean * mean)
            weight *= 2.0
            tail += weight * term
            b = ti.sqrt(a * b)
            a = mean
        K = 1.5707963267948966 / a
        scale = 2.0 * MU0_4PI * q.current * K / (q.radius * ti.sqrt(far2))
        b_z = (2.0 - 2.0 * distance - (1.0 - rho2 - z2) * (0.5 * k2 + k2 * k2 * tail)) / near2
        b_rho_over_rho = z * (0.5 - (1.0 + complement) * tail) * 8.0 / (far2 * near2)
        return scale * (b_z * n + b_rho_over_rho * rho)


@force("magnetic_grid")
class MagneticGrid(Sampled):
    """A magnetic field sampled on a grid.

    B = strength V(x), V the trilinear interpolation of the grid's vectors in T

    field : a .npy file, picture or array, as of vector_field
    bounds : m, the corners at which the first and the last vector stand
    strength : factor
    outside : zero, or the vectors of the edge
    Does no work. Its divergence vanishes only in the limit of a fine grid. Use the `boris` integrator.
    Source: Press and others, Numerical Recipes, section 3.6.
    """

    does_work = False
    depends_on_velocity = True

    @ti.func
    def magnetic(self, p, t, q):
        return self.sampled(p, q)
