"""The surfaces of one system as a single function of place and time, and where each of them moves to.

`walls` are the colliders of a system as (collider, offset of its numbers, number of its first surface, row in the ledger);
a surface is a side of one, numbered through all of them.
"""

from gen_art.backend.kernel_views import parameters, traced
from gen_art.backend.runtime import STOCK_TAICHI, ti
from gen_art.maths.elementary import cos, sin

__all__ = [
    "carried_along",
    "nearest_distance",
    "surface_properties",
    "count",
    "make_surface",
    "collider_of",
    "turning_speed",
]

PROPERTIES = (
    12  # restitution, kinetic and static friction, velocity, angular velocity, pivot: the last parameters of a collider
)


@traced
def count(walls) -> int:
    """How many surfaces there are."""
    return sum(wall[0].sides for wall in walls)


@ti.func
def collider_of(walls: ti.template(), s):
    """Which collider surface s belongs to."""
    which = 0
    for c, wall in ti.static(enumerate(walls)):
        if s >= wall[2]:
            which = c
    return which


@ti.func
def rotated_about(v, axis, angle):
    """v turned about the unit axis (Rodrigues' formula)."""
    c, s = cos(angle), sin(angle)
    return v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c))


@ti.func
def _to_start_frame(one: ti.template(), q: ti.template(), x, t):
    """The place x at time t as the collider stood at time 0, and the axis and angle it has turned by since."""
    y = x - q.velocity * t
    axis, angle = x * 0.0, t * 0.0
    if ti.static(one.turns):
        rate = q.angular_velocity.norm()
        axis = q.angular_velocity / ti.max(rate, 1e-30)
        angle = rate * t
        y = q.pivot + rotated_about(y - q.pivot, axis, -angle)
    return y, axis, angle


@ti.func
def _distance_and_normal(walls: ti.template(), Q: ti.template(), s, x, t, wanted):
    result = ti.Vector([x[0], x[1], x[2], t])
    for wall in ti.static(walls):
        if wall[2] <= s and s < wall[2] + wall[0].sides:
            q = parameters(Q, wall[0], wall[1])
            y, axis, angle = _to_start_frame(wall[0], q, x, t)
            result[3] = wall[0].distance(y, q, s - wall[2])
            if wanted == 1:
                n = wall[0].gradient(y, q, s - wall[2])
                if ti.static(wall[0].turns):
                    n = rotated_about(n, axis, angle)
                result[0], result[1], result[2] = n[0], n[1], n[2]
    return result


def make_surface(walls, real):
    """surface(Q, s, x, t, wanted): the distance of the place x (m) at time t (s) from surface s, and, where `wanted` is 1,
    its unit normal there, as (normal, distance).

    A real function, called instead of inlined: kernels with colliders compile in a fraction of the time. It needs
    backend/real_function_patch.py; without the patch the function is inlined. Each kernel gets a function of its own:
    Taichi 1.7.4 finds a kernel that shares one with others in its cache only by chance.
    """
    if STOCK_TAICHI:

        @ti.func
        def inlined(Q: ti.template(), s, x, t, wanted):
            return _distance_and_normal(walls, Q, s, x, t, wanted)

        return inlined
    vector, numbers = ti.types.vector(3, real), ti.types.ndarray(real, 1)

    @ti.real_func
    def surface(Q: numbers, s: ti.i32, x: vector, t: real, wanted: ti.i32) -> ti.types.vector(4, real):
        return _distance_and_normal(walls, Q, s, x, t, wanted)

    return surface


@ti.func
def nearest_distance(one: ti.template(), q: ti.template(), x, t):
    """The distance of the place x at time t from the nearest side of a collider."""
    y, _, _ = _to_start_frame(one, q, x, t)
    return one.nearest(y, q)


@ti.func
def turning_speed(one: ti.template(), q: ti.template(), x, t):
    """How fast the collider's turning moves what is at the place x at time t, m/s."""
    speed = t * 0.0
    if ti.static(one.turns):
        speed = q.angular_velocity.cross(x - q.pivot - q.velocity * t).norm()
    return speed


@traced
def _first_property(wall) -> int:
    return wall[1] + sum(size for _, _, size in wall[0].layout()) - PROPERTIES


@traced
def _any_turns(walls) -> bool:
    return any(wall[0].turns for wall in walls)


@ti.func
def surface_properties(walls: ti.template(), Q: ti.template(), s, x, t):
    """((restitution, kinetic, static friction), velocity at the place x and time t) of surface s."""
    k = 0
    for wall in ti.static(walls):
        if s >= wall[2]:
            k = _first_property(wall)
    U = ti.Vector([Q[k + 3], Q[k + 4], Q[k + 5]])
    if ti.static(_any_turns(walls)):
        rate, pivot = ti.Vector([Q[k + 6], Q[k + 7], Q[k + 8]]), ti.Vector([Q[k + 9], Q[k + 10], Q[k + 11]])
        U += rate.cross(x - pivot - U * t)
    return ti.Vector([Q[k], Q[k + 1], Q[k + 2]]), U


@ti.func
def carried_along(walls: ti.template(), Q: ti.template(), s, x, t, h):
    """Where what rides on surface s from the place x at time t is after h, and its velocity there."""
    _, U = surface_properties(walls, Q, s, x, t)
    y = x + U * h
    if ti.static(_any_turns(walls)):
        k = 0
        for wall in ti.static(walls):
            if s >= wall[2]:
                k = _first_property(wall)
        velocity = ti.Vector([Q[k + 3], Q[k + 4], Q[k + 5]])
        spin, pivot = ti.Vector([Q[k + 6], Q[k + 7], Q[k + 8]]), ti.Vector([Q[k + 9], Q[k + 10], Q[k + 11]])
        rate = spin.norm()
        arm = rotated_about(x - pivot - velocity * t, spin / ti.max(rate, 1e-30), rate * h)
        y = pivot + velocity * (t + h) + arm
        U = velocity + spin.cross(arm)
    return y, U
