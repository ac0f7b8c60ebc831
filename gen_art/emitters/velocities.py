"""Velocities of particles at birth. Channels 11 to 19 of the random stream belong to velocities."""

from gen_art.backend.runtime import real, ti
from gen_art.emitters.base import Velocity, velocity
from gen_art.emitters.shapes import across
from gen_art.maths.elementary import cos, sin
from gen_art.registry import param


@velocity("constant")
class Constant(Velocity):
    """The same velocity for all.

    v = value
    value : (3,) m/s
    """

    value: tuple = param((0.0, 0.0, 0.0), unit="m/s")

    @ti.func
    def velocity(self, r, t, q, x):
        return q.value


@velocity("cone")
class Cone(Velocity):
    """Directions uniform over the cap of half-angle `angle` around an axis.

    v = speed n, cos(n, axis) uniform in [cos angle, 1]
    axis : (3,)
    angle : degrees in YAML (radians in Python)
    speed : m/s
    """

    axis: tuple = param((0.0, 1.0, 0.0))
    angle: float = param(0.2, unit="rad", min=0, max=3.1415926535897936)
    speed: tuple = param((1.0, 1.0), unit="m/s", kind="range")

    @ti.func
    def velocity(self, r, t, q, x):
        e, f, n = across(q.axis)
        c = 1.0 - r.uniform(11) * (1.0 - cos(q.angle))
        s = ti.sqrt(ti.max(1.0 - c * c, 0.0))
        azimuth = 6.283185307179586 * r.uniform(12)
        return (n * c + (e * cos(azimuth) + f * sin(azimuth)) * s) * r.range(q.speed, 13)


@velocity("sphere")
class Isotropic(Velocity):
    """Directions uniform over the sphere.

    v = speed n, n isotropic
    speed : m/s
    """

    speed: tuple = param((1.0, 1.0), unit="m/s", kind="range")

    @ti.func
    def velocity(self, r, t, q, x):
        return r.sphere(11) * r.range(q.speed, 13)


@velocity("pitched")
class Pitched(Velocity):
    """Along an axis at a fixed pitch angle, rotated about the axis as the place of birth is: ions on field lines.

    v = speed (cos(pitch) n + sin(pitch) e_phi), e_phi around the axis n at the place of birth; plus a spread
    axis : (3,)
    speed : m/s
    pitch : degrees in YAML (radians in Python), 0 along the axis
    spread : m/s, standard deviation, normal in each direction
    """

    axis: tuple = param((0.0, 1.0, 0.0))
    pitch: float = param(1.0, unit="rad", min=0, max=3.1415926535897936)
    speed: tuple = param((1.0, 1.0), unit="m/s", kind="range")
    spread: float = param(0.0, unit="m/s", min=0)

    @ti.func
    def velocity(self, r, t, q, x):
        e, _, n = across(q.axis)
        around = n.cross(x)
        length = around.norm()
        around = ti.select(length > 1e-12, around / ti.max(length, 1e-30), e)
        jitter = ti.Vector([r.normal(14), r.normal(16), r.normal(17)])
        return (n * cos(q.pitch) + around * sin(q.pitch)) * r.range(q.speed, 13) + q.spread * jitter


@velocity("orbit")
class Orbit(Velocity):
    """An orbit around a centre of attraction, from the place of birth: a circle or an ellipse.

    v = mean + sqrt(GM (1 + e) / abs(r)) n x r / abs(n x r),  r = x - center, n along the axis, e the eccentricity
    GM : m^3/s^2
    eccentricity : above 0 the particle is born at the pericentre of an ellipse, below 0 at its apocentre; the semi-major axis is
        abs(r) / (1 - e)
    mean : (3,) m/s, velocity of the centre
    Source: Murray & Dermott, Solar System Dynamics, ch. 2.
    """

    GM: float = param(1.0, unit="m^3/s^2", min=0)
    center: tuple = param((0.0, 0.0, 0.0), unit="m")
    axis: tuple = param((0.0, 1.0, 0.0))
    eccentricity: tuple = param((0.0, 0.0), kind="range", min=-1, max=1)
    mean: tuple = param((0.0, 0.0, 0.0), unit="m/s")

    @ti.func
    def velocity(self, r, t, q, x):
        e, _, n = across(q.axis)
        offset = x - q.center
        around = n.cross(offset)
        length = around.norm()
        around = ti.select(length > 1e-12, around / ti.max(length, 1e-30), e)
        speed = ti.sqrt(q.GM * (1.0 + r.range(q.eccentricity, 13)) / ti.max(offset.norm(), 1e-30))
        return q.mean + speed * around


@velocity("radial")
class Radial(Velocity):
    """Away from the emitter's origin, through the place of birth.

    v = speed x / abs(x)
    speed : m/s
    """

    speed: tuple = param((1.0, 1.0), unit="m/s", kind="range")

    @ti.func
    def velocity(self, r, t, q, x):
        return x * (r.range(q.speed, 13) / ti.max(x.norm(), 1e-30))


@velocity("thermal")
class Thermal(Velocity):
    """Maxwell's distribution about a mean.

    v = mean + sigma (normal, normal, normal)
    sigma : m/s, >= 0, sqrt(kT/m)
    mean : (3,) m/s
    """

    sigma: float = param(1.0, unit="m/s", min=0)
    mean: tuple = param((0.0, 0.0, 0.0), unit="m/s")

    @ti.func
    def velocity(self, r, t, q, x):
        return q.mean + q.sigma * ti.Vector([r.normal(11), r.normal(12), r.normal(14)])


@velocity("cross")
class Cross(Velocity):
    """The particles of a burst leave at right angles in one random plane.

    v = speed (cos(k pi/2) e + sin(k pi/2) f), k the ordinal in the burst, e and f from the burst's stream
    speed : m/s
    """

    speed: tuple = param((1.0, 1.0), unit="m/s", kind="range")

    @ti.func
    def velocity(self, r, t, q, x):
        e, f, _ = across(r.burst.sphere(15))
        azimuth = 1.5707963267948966 * ti.cast(r.ordinal % 4, real())
        return (e * cos(azimuth) + f * sin(azimuth)) * r.burst.range(q.speed, 13)


@velocity("ring")
class RingBurst(Velocity):
    """The particles of a burst leave in one plane, at random angles.

    v = speed (cos a e + sin a f), a uniform, e and f perpendicular to the axis
    speed : m/s
    axis : (0, 0, 0) gives each burst a random plane
    """

    speed: tuple = param((1.0, 1.0), unit="m/s", kind="range")
    axis: tuple = param((0.0, 0.0, 0.0))

    @ti.func
    def velocity(self, r, t, q, x):
        n = ti.select(q.axis.norm() > 0.0, q.axis, r.burst.sphere(15))
        e, f, _ = across(n)
        azimuth = 6.283185307179586 * r.uniform(12)
        return (e * cos(azimuth) + f * sin(azimuth)) * r.range(q.speed, 13)
