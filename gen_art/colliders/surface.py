"""All surfaces of one system as a single function of position and time, and how they move.

`colliders` are the CollisionTerms of a system; a surface is one side of a collider, numbered through all of them.
"""

from gen_art.backend.kernel_views import parameters, traced
from gen_art.backend.runtime import STOCK_TAICHI, ti
from gen_art.maths.elementary import cos, sin

__all__ = [
    "carried_along",
    "distance_and_normal",
    "nearest_distance",
    "surface_properties",
    "count",
    "make_surface",
    "collider_of",
    "rotated_about",
    "rotation_speed",
    "to_start_frame",
]

# The last parameters of every collider in Q, from _first_property on: restitution, kinetic and static friction, and motion
_RESTITUTION, _VELOCITY, _ANGULAR_VELOCITY, _PIVOT, _PROPERTIES = 0, 3, 6, 9, 12


@traced
def count(colliders) -> int:
    """The number of surfaces."""
    return sum(entry.collider.sides for entry in colliders)


@ti.func
def collider_of(colliders: ti.template(), s):
    """The index of the collider that surface s belongs to."""
    which = 0
    for c, entry in ti.static(enumerate(colliders)):
        if s >= entry.first_surface:
            which = c
    return which


@ti.func
def rotated_about(v, axis, angle):
    """v rotated about the unit axis by the angle, rad (Rodrigues' formula)."""
    c, s = cos(angle), sin(angle)
    return v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c))


@ti.func
def to_start_frame(collider: ti.template(), q: ti.template(), x, t):
    """The position x at time t in the collider's frame at time 0, and the axis and angle of its rotation since."""
    y = x - q.velocity * t
    axis, angle = x * 0.0, t * 0.0
    if ti.static(collider.rotates):
        rate = q.angular_velocity.norm()
        axis = q.angular_velocity / ti.max(rate, 1e-30)
        angle = rate * t
        y = q.pivot + rotated_about(y - q.pivot, axis, -angle)
    return y, axis, angle


@ti.func
def distance_and_normal(colliders: ti.template(), Q: ti.template(), s, x, t, with_normal):
    """(normal, distance) of surface s at the position x, m, and time t, s; the normal is valid only if with_normal is 1."""
    result = ti.Vector([x[0], x[1], x[2], t])
    for entry in ti.static(colliders):
        if entry.first_surface <= s and s < entry.first_surface + entry.collider.sides:
            q = parameters(Q, entry.collider, entry.offset)
            y, axis, angle = to_start_frame(entry.collider, q, x, t)
            result[3] = entry.collider.distance(y, q, s - entry.first_surface)
            if with_normal == 1:
                n = entry.collider.gradient(y, q, s - entry.first_surface)
                if ti.static(entry.collider.rotates):
                    n = rotated_about(n, axis, angle)
                result[0], result[1], result[2] = n[0], n[1], n[2]
    return result


def make_surface(colliders, real):
    """surface(Q, s, x, t, with_normal): (normal, distance) of surface s at the position x, m, and time t, s.

    The distance is that of x from the surface, m; the normal is valid only if with_normal is 1.

    It is a real function, called instead of inlined, so that kernels with colliders compile in a fraction of the time. It needs
    backend/real_function_patch.py; without the patch the function is inlined. Each kernel gets a function of its own, because
    Taichi 1.7.4 does not reliably find a kernel that shares one with others in its cache.
    """
    if STOCK_TAICHI:

        @ti.func
        def inlined(Q: ti.template(), s, x, t, with_normal):
            return distance_and_normal(colliders, Q, s, x, t, with_normal)

        return inlined
    vector, numbers = ti.types.vector(3, real), ti.types.ndarray(real, 1)

    @ti.real_func
    def surface(Q: numbers, s: ti.i32, x: vector, t: real, with_normal: ti.i32) -> ti.types.vector(4, real):
        return distance_and_normal(colliders, Q, s, x, t, with_normal)

    return surface


@ti.func
def nearest_distance(collider: ti.template(), q: ti.template(), x, t):
    """The distance, m, of the position x at time t from the nearest side of a collider."""
    y, _, _ = to_start_frame(collider, q, x, t)
    return collider.nearest(y, q)


@ti.func
def rotation_speed(collider: ti.template(), q: ti.template(), x, t):
    """The speed, m/s, of the collider's rotation at the position x and time t."""
    speed = t * 0.0
    if ti.static(collider.rotates):
        speed = q.angular_velocity.cross(x - q.pivot - q.velocity * t).norm()
    return speed


@traced
def _first_property(entry) -> int:
    return entry.offset + sum(size for _, _, size in entry.collider.layout()) - _PROPERTIES


@traced
def _any_rotates(colliders) -> bool:
    return any(entry.collider.rotates for entry in colliders)


@ti.func
def _vector(Q: ti.template(), k):
    return ti.Vector([Q[k], Q[k + 1], Q[k + 2]])


@ti.func
def surface_properties(colliders: ti.template(), Q: ti.template(), s, x, t):
    """((restitution, kinetic, static friction), velocity at the position x and time t) of surface s."""
    k = 0
    for entry in ti.static(colliders):
        if s >= entry.first_surface:
            k = _first_property(entry)
    U = _vector(Q, k + _VELOCITY)
    if ti.static(_any_rotates(colliders)):
        rate, pivot = _vector(Q, k + _ANGULAR_VELOCITY), _vector(Q, k + _PIVOT)
        U += rate.cross(x - pivot - U * t)
    return _vector(Q, k + _RESTITUTION), U


@ti.func
def carried_along(colliders: ti.template(), Q: ti.template(), s, x, t, h):
    """Position and velocity after h, s, of a particle that is fixed to surface s at the position x at time t."""
    _, U = surface_properties(colliders, Q, s, x, t)
    y = x + U * h
    if ti.static(_any_rotates(colliders)):
        k = 0
        for entry in ti.static(colliders):
            if s >= entry.first_surface:
                k = _first_property(entry)
        velocity = _vector(Q, k + _VELOCITY)
        spin, pivot = _vector(Q, k + _ANGULAR_VELOCITY), _vector(Q, k + _PIVOT)
        rate = spin.norm()
        arm = rotated_about(x - pivot - velocity * t, spin / ti.max(rate, 1e-30), rate * h)
        y = pivot + velocity * (t + h) + arm
        U = velocity + spin.cross(arm)
    return y, U
