"""Velocity fields for a medium: vortices and the flow through an aperture."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("vortex")
class Vortex(Force):
    """A straight vortex with a smooth core.

    u = circulation / (2 pi) n x rho / (abs(rho)^2 + core_radius^2),  rho the distance vector from the axis n

    circulation : m^2/s
    core_radius : m, > 0
    center : (3,) m, a point of the axis
    axis : (3,), its direction
    As a term of a medium a velocity; as a force an acceleration.
    Source: Kaufmann (Scully) vortex, Saffman, Vortex Dynamics.
    """

    steady = True
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    circulation: float = param(1.0, unit="m^2/s")
    core_radius: float = param(0.1, unit="m", min=1e-30)

    @ti.func
    def acceleration(self, p, t, q):
        n = q.axis / ti.max(q.axis.norm(), 1e-30)
        r = p.position - q.center
        rho = r - n * r.dot(n)
        return n.cross(rho) * (q.circulation / 6.283185307179586 / (rho.dot(rho) + q.core_radius * q.core_radius))


@force("aperture")
class Aperture(Force):
    """Ideal flow through a round hole in a thin wall: it converges, passes the hole, and spreads again.

    u = speed (c n + s rho / (1 + s^2)) / (s^2 + c^2) in units of the hole's radius b, with z = s c and
    abs(rho)^2 = (1 + s^2)(1 - c^2): oblate spheroidal coordinates. On the axis u = speed / (1 + z^2 / b^2).
    It is the gradient of speed b atan(s), without divergence and curl; the singular edge of the hole is smoothed.

    speed : m/s at the centre of the hole
    radius : b, m, > 0
    center : (3,) m
    axis : (3,)
    Source: Lamb, Hydrodynamics, section 108.
    """

    steady = True
    speed: float = param(1.0, unit="m/s")
    radius: float = param(1.0, unit="m", min=1e-30)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 0.0, 1.0))

    @ti.func
    def acceleration(self, p, t, q):
        n = q.axis / ti.max(q.axis.norm(), 1e-30)
        r = (p.position - q.center) / q.radius
        z = r.dot(n)
        rho = r - n * z
        d = rho.dot(rho) + z * z - 1.0
        root = ti.sqrt(d * d + 4.0 * z * z)  # s^2 + c^2
        s2 = ti.max(0.5 * (root + d), 0.0)
        c = ti.sqrt(ti.max(0.5 * (root - d), 0.0))
        s = ti.select(z < 0.0, -1.0, 1.0) * ti.sqrt(s2)
        return (n * c + rho * (s / (1.0 + s2))) * (q.speed / ti.max(root, 0.02))
