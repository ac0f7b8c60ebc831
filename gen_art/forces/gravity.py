"""Uniform gravity, and gravity that weakens with height."""

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("gravity")
class Gravity(Force):
    """A uniform field.

    a = g,  U = -m g . x
    field : g, (3,) m/s^2
    Conservative. Source: Landau & Lifshitz, Mechanics, section 5.
    """

    field: tuple = param((0.0, -9.81, 0.0), unit="m/s^2", doc="acceleration")
    conservative = True
    does_work = True

    @ti.func
    def acceleration(self, p, t, q):
        return q.field

    @ti.func
    def potential(self, p, t, q):
        return -p.mass * q.field.dot(p.position)


@force("height_gravity")
class HeightGravity(Force):
    """Gravity that decreases with the height above the ground: of a globe, or of a flat ground with a globe's field strength.

    a = -surface (radius / (radius + h))^2 n,  U = -m surface radius^2 / (radius + h)
    globe: h = abs(x - c) - radius, n = (x - c) / abs(x - c), c = point - radius up; below ground a falls linearly to 0 at c
    flat: h = (x - point) . up, n = up; below ground a is that of the ground

    surface : m/s^2, at the ground, >= 0
    radius : m, > 0
    point : (3,) m, a point of the ground
    up : (3,)
    Conservative. Source: Landau & Lifshitz, Mechanics, section 15.
    """

    surface: float = param(9.81, unit="m/s^2", min=0)
    radius: float = param(6.371e6, unit="m", min=1e-30)
    point: tuple = param((0.0, 0.0, 0.0), unit="m")
    up: tuple = param((0.0, 1.0, 0.0))
    ground: str = param("flat", choices=("flat", "globe"), doc="the form of the ground")
    conservative = True

    def prepare(self):
        if not any(self.values["up"]):
            raise UsageError("HeightGravity: up must not be the null vector")

    @ti.func
    def acceleration(self, p, t, q):
        up = q.up / q.up.norm()
        x = p.position - q.point
        a = ti.Vector([0.0, 0.0, 0.0])
        if ti.static(self.values["ground"] == "flat"):
            ratio = q.radius / (q.radius + ti.max(x.dot(up), 0.0))
            a = up * (-q.surface * ratio * ratio)
        else:
            r = x / q.radius + up
            distance = r.norm()
            a = r * (-q.surface * ti.select(distance > 1.0, 1.0 / ti.max(distance, 1.0) ** 3, 1.0))
        return a

    @ti.func
    def potential(self, p, t, q):
        up = q.up / q.up.norm()
        x = p.position - q.point
        u = p.mass * 0.0
        if ti.static(self.values["ground"] == "flat"):
            h = x.dot(up) / q.radius
            u = ti.select(h > 0.0, -1.0 / (1.0 + ti.max(h, 0.0)), h - 1.0)
        else:
            r = x / q.radius + up
            distance = r.norm()
            u = ti.select(distance > 1.0, -1.0 / ti.max(distance, 1.0), 0.5 * distance * distance - 1.5)
        return p.mass * q.surface * q.radius * u
