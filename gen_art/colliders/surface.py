"""All surfaces of one system as a single function of position and time, and how they move.

`kinds` are the ColliderKinds of a system; a surface is one side of a collider, numbered through all of them.
"""

from gen_art.backend.kernel_views import traced
from gen_art.backend.runtime import STOCK_TAICHI, ti
from gen_art.colliders.kinds import numbers_of
from gen_art.maths.elementary import cos, sin

__all__ = [
    "carried_along",
    "distance_and_normal",
    "nearest_distance",
    "surface_properties",
    "count",
    "is_of_kind",
    "make_surface",
    "collider_of",
    "rotated_about",
    "rotation_speed",
    "to_start_frame",
]

# The last parameters of every collider in Q, from _first_property on: restitution, kinetic and static friction, and motion
_RESTITUTION, _VELOCITY, _ANGULAR_VELOCITY, _PIVOT, _PROPERTIES = 0, 3, 6, 9, 12


@traced
def count(kinds) -> int:
    """The number of surfaces."""
    return sum(kind.count * kind.collider.sides for kind in kinds)


@ti.func
def is_of_kind(kind: ti.template(), s):
    """Whether surface s belongs to a collider of the kind."""
    return kind.first_surface <= s and s < kind.first_surface + kind.count * kind.collider.sides


@ti.func
def collider_of(kinds: ti.template(), s):
    """The index of the collider that surface s belongs to."""
    which = 0
    for kind in ti.static(kinds):
        if is_of_kind(kind, s):
            which = kind.first + (s - kind.first_surface) // kind.collider.sides
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
def distance_and_normal(kinds: ti.template(), Q: ti.template(), s, x, t, with_normal):
    """(normal, distance) of surface s at the position x, m, and time t, s; the normal is valid only if with_normal is 1."""
    result = ti.Vector([x[0], x[1], x[2], t])
    for kind in ti.static(kinds):
        if is_of_kind(kind, s):
            which = (s - kind.first_surface) // kind.collider.sides
            side = s - kind.first_surface - which * kind.collider.sides
            q = numbers_of(Q, kind, which)
            y, axis, angle = to_start_frame(kind.collider, q, x, t)
            result[3] = kind.collider.distance(y, q, side)
            if with_normal == 1:
                n = kind.collider.gradient(y, q, side)
                if ti.static(kind.collider.rotates):
                    n = rotated_about(n, axis, angle)
                result[0], result[1], result[2] = n[0], n[1], n[2]
    return result


def make_surface(kinds, real):
    """surface(Q, s, x, t, with_normal): (normal, distance) of surface s at the position x, m, and time t, s.

    The distance is that of x from the surface, m; the normal is valid only if with_normal is 1.

    It is a real function, called instead of inlined, so that kernels with colliders compile in a fraction of the time. It needs
    backend/real_function_patch.py; without the patch the function is inlined. Each kernel gets a function of its own, because
    Taichi 1.7.4 does not reliably find a kernel that shares one with others in its cache.
    """
    if STOCK_TAICHI:

        @ti.func
        def inlined(Q: ti.template(), s, x, t, with_normal):
            return distance_and_normal(kinds, Q, s, x, t, with_normal)

        return inlined
    vector, numbers = ti.types.vector(3, real), ti.types.ndarray(real, 1)

    @ti.real_func
    def surface(Q: numbers, s: ti.i32, x: vector, t: real, with_normal: ti.i32) -> ti.types.vector(4, real):
        return distance_and_normal(kinds, Q, s, x, t, with_normal)

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
def _properties_offset(kind) -> int:
    return kind.offset + sum(size for _, _, size in kind.collider.layout()) - _PROPERTIES


@ti.func
def _first_property(kinds: ti.template(), s):
    """Where in Q the properties of the collider of surface s begin."""
    k = 0
    for kind in ti.static(kinds):
        if is_of_kind(kind, s):
            k = _properties_offset(kind) + (s - kind.first_surface) // kind.collider.sides * kind.stride
    return k


@traced
def _any_rotates(kinds) -> bool:
    return any(kind.collider.rotates for kind in kinds)


@ti.func
def _vector(Q: ti.template(), k):
    return ti.Vector([Q[k], Q[k + 1], Q[k + 2]])


@ti.func
def surface_properties(kinds: ti.template(), Q: ti.template(), s, x, t):
    """((restitution, kinetic, static friction), velocity at the position x and time t) of surface s."""
    k = _first_property(kinds, s)
    U = _vector(Q, k + _VELOCITY)
    if ti.static(_any_rotates(kinds)):
        rate, pivot = _vector(Q, k + _ANGULAR_VELOCITY), _vector(Q, k + _PIVOT)
        U += rate.cross(x - pivot - U * t)
    return _vector(Q, k + _RESTITUTION), U


@ti.func
def carried_along(kinds: ti.template(), Q: ti.template(), s, x, t, h):
    """Position and velocity after h, s, of a particle that is fixed to surface s at the position x at time t."""
    _, U = surface_properties(kinds, Q, s, x, t)
    y = x + U * h
    if ti.static(_any_rotates(kinds)):
        k = _first_property(kinds, s)
        velocity = _vector(Q, k + _VELOCITY)
        spin, pivot = _vector(Q, k + _ANGULAR_VELOCITY), _vector(Q, k + _PIVOT)
        rate = spin.norm()
        arm = rotated_about(x - pivot - velocity * t, spin / ti.max(rate, 1e-30), rate * h)
        y = pivot + velocity * (t + h) + arm
        U = velocity + spin.cross(arm)
    return y, U
