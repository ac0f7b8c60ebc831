"""Shapes: where particles are born. Channels 1 to 9 of the particle's random stream belong to shapes."""

from gen_art.backend.runtime import real, ti
from gen_art.emitters.base import Shape, shape
from gen_art.maths.elementary import cos, power, sin
from gen_art.registry import param


@ti.func
def across(axis):
    """Two unit vectors that complete a right-handed frame with `axis` (any length > 0), and the unit axis."""
    n = axis / ti.max(axis.norm(), 1e-30)
    helper = ti.select(ti.abs(n[1]) < 0.9, ti.Vector([0.0, 1.0, 0.0]), ti.Vector([1.0, 0.0, 0.0]))
    e = helper.cross(n)
    e = e / ti.max(e.norm(), 1e-30)
    return e, n.cross(e), n


@shape("point")
class Point(Shape):
    """One point.

    x = at
    at : (3,) m
    """

    at: tuple = param((0.0, 0.0, 0.0), unit="m")

    @ti.func
    def place(self, r, t, q):
        return q.at


@shape("line")
class Line(Shape):
    """A segment, uniformly.

    x = start + s (end - start), s uniform in 0..1
    start, end : (3,) m
    """

    start: tuple = param((0.0, 0.0, 0.0), unit="m")
    end: tuple = param((1.0, 0.0, 0.0), unit="m")

    @ti.func
    def place(self, r, t, q):
        return q.start + (q.end - q.start) * r.uniform(1)


@shape("ball")
class Ball(Shape):
    """The inside of a ball, uniformly in volume.

    abs(x - center) = radius s^(1/3), s uniform in 0..1
    radius : m, >= 0
    center : (3,) m
    """

    radius: float = param(1.0, unit="m", min=0)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")

    @ti.func
    def place(self, r, t, q):
        return q.center + r.sphere(1) * (q.radius * power(r.uniform(2), 1.0 / 3.0))


@shape("sphere")
class Sphere(Shape):
    """The surface of a sphere, uniformly.

    abs(x - center) = radius
    radius : m, >= 0
    center : (3,) m
    """

    radius: float = param(1.0, unit="m", min=0)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")

    @ti.func
    def place(self, r, t, q):
        return q.center + r.sphere(1) * q.radius


@shape("disc")
class Disc(Shape):
    """A flat disc or annulus, uniformly in area.

    inner <= abs(x - center) <= radius, perpendicular to `axis`
    radius, inner : m, >= 0
    center : (3,) m
    axis : (3,)
    """

    radius: float = param(1.0, unit="m", min=0)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    inner: float = param(0.0, unit="m", min=0)

    @ti.func
    def place(self, r, t, q):
        e, f, _ = across(q.axis)
        rho = ti.sqrt(q.inner * q.inner + (q.radius * q.radius - q.inner * q.inner) * r.uniform(1))
        angle = 6.283185307179586 * r.uniform(2)
        return q.center + (e * cos(angle) + f * sin(angle)) * rho


@shape("ring")
class Ring(Shape):
    """A circle, uniformly, or `spokes` points evenly spaced on it.

    abs(x - center) = radius, perpendicular to `axis`
    radius : m, >= 0
    center : (3,) m
    axis : (3,)
    spokes : 0 for the whole circle
    """

    radius: float = param(1.0, unit="m", min=0)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    spokes: int = param(0, min=0, max=100000, doc="points on the circle; 0 is all of it")
    phase: float = param(0.0, unit="rad", doc="angle of the first spoke")

    @ti.func
    def place(self, r, t, q):
        e, f, _ = across(q.axis)
        u = r.uniform(1)
        n = ti.cast(q.spokes, real())
        angle = 6.283185307179586 * ti.select(n > 0.0, ti.floor(u * n) / ti.max(n, 1.0), u) + q.phase
        return q.center + (e * cos(angle) + f * sin(angle)) * q.radius


@shape("box")
class Box(Shape):
    """The inside of a box, uniformly.

    min <= x <= max, component by component
    min, max : (3,) m
    """

    min: tuple = param((-0.5, -0.5, -0.5), unit="m")
    max: tuple = param((0.5, 0.5, 0.5), unit="m")

    @ti.func
    def place(self, r, t, q):
        return q.min + (q.max - q.min) * ti.Vector([r.uniform(1), r.uniform(2), r.uniform(3)])


@shape("gaussian")
class Gaussian(Shape):
    """A normal cloud.

    x = center + sigma (n1, n2, n3), component by component, each n standard normal
    sigma, center : (3,) m
    """

    sigma: tuple = param((1.0, 1.0, 1.0), unit="m", min=0)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")

    @ti.func
    def place(self, r, t, q):
        return q.center + q.sigma * ti.Vector([r.normal(1), r.normal(2), r.normal(3)])
