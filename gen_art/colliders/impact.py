"""When a path meets a surface, and what the surface does to a velocity.

`walls` are the colliders of a system as (collider, offset of its numbers, number of its first surface, row in the ledger);
a surface is a side of one, numbered through all of them. Each loop asks for a distance in one place only, and picks the
shape there: code that is laid out once for each shape takes long to compile.
"""

from gen_art.runtime import is_f64, ti
from gen_art.tracing import parameters, traced

__all__ = ["common", "count", "gap", "gradient", "meeting", "owner", "reflected", "settled", "support"]

_FIRST, _GROWTH = 1e-4, 1.05  # least step of the march along a path, of its length, and its growth: at most 130 steps
_GRAZE = 0.02  # a hop shorter than this share of the path counts as resting
_SWEEPS = 6  # over the surfaces a particle rests on: exact for right angles, closing in for others
_COMMON = 6  # restitution, kinetic and static friction, velocity: the last parameters of every collider


@traced
def count(walls) -> int:
    """How many surfaces there are."""
    return sum(wall[0].sides for wall in walls)


@traced
def _first_common(wall) -> int:
    return wall[1] + sum(size for _, _, size in wall[0].layout()) - _COMMON


@ti.func
def owner(walls: ti.template(), s):
    """Which collider surface s belongs to."""
    which = 0
    for c, wall in ti.static(enumerate(walls)):
        if s >= wall[2]:
            which = c
    return which


@ti.func
def common(walls: ti.template(), Q: ti.template(), s):
    """((restitution, kinetic, static friction), velocity) of surface s."""
    first = 0
    for wall in ti.static(walls):
        if s >= wall[2]:
            first = _first_common(wall)
    return ti.Vector([Q[first], Q[first + 1], Q[first + 2]]), ti.Vector([Q[first + 3], Q[first + 4], Q[first + 5]])


@ti.func
def gap(walls: ti.template(), Q: ti.template(), s, x):
    """The distance (m) of the place x, as surface s sees it, from that surface."""
    d = x[0]
    for wall in ti.static(walls):
        if wall[2] <= s and s < wall[2] + wall[0].sides:
            d = wall[0].distance(x, parameters(Q, wall[0], wall[1]), s - wall[2])
    return d


@ti.func
def gradient(walls: ti.template(), Q: ti.template(), s, x):
    """The unit normal of surface s at the place x, as the surface sees it."""
    n = x
    for wall in ti.static(walls):
        if wall[2] <= s and s < wall[2] + wall[0].sides:
            n = wall[0].gradient(x, parameters(Q, wall[0], wall[1]), s - wall[2])
    return n


@ti.func
def meeting(walls: ti.template(), Q: ti.template(), s, x, v, a, left, radius):
    """The time in [0, left] when the path x + v t + a t^2 / 2, as surface s sees it, first meets it; 2 left if it does not.

    No particle passes through: the path is marched along by the distance over the largest speed on it, then the root is
    bracketed and found by the Illinois rule. A path that starts on the surface is followed from where it is off it.
    """
    speed = ti.max(v.norm() + a.norm() * left, 1e-30)
    result = 2.0 * left
    least = left * _FIRST
    t, low, high, above, below = left * 0.0, left * 0.0, left, left * 0.0, left * 0.0
    mode, steps, was = 0, 0, 0  # 0 at the start, 1 off the surface again, 2 marching, 3 between low and high, 4 done
    while mode < 4:
        d = gap(walls, Q, s, x + v * t + a * (0.5 * t * t)) - radius
        if d > 0.0 and mode < 3:
            if (mode == 0 and d > speed * left) or t >= left:
                mode = 4
            else:
                low, above = t, d
                t = ti.min(t + ti.max(d / speed, least), left)
                least *= _GROWTH
                mode = 2
        elif mode == 0:
            n = gradient(walls, Q, s, x)
            away, pull = v.dot(n), -a.dot(n)
            if away < 0.0 or 2.0 * away <= pull * left * _GRAZE:
                result = left * 0.0
                mode = 4
            else:
                t = ti.min(ti.select(pull > 0.0, away / ti.select(pull > 0.0, pull, 1.0), left * _GRAZE), left)
                mode = 1
        elif mode == 1:
            result = left * 0.0
            mode = 4
        else:
            if mode == 2:
                high, below = t, d
                mode = 3
            elif d > 0.0:
                low, above = t, d
                below *= ti.select(was == 1, 0.5, 1.0)
                was = 1
            else:
                high, below = t, d
                above *= ti.select(was == 2, 0.5, 1.0)
                was = 2
            steps += 1
            if steps > ti.static(16 if is_f64() else 9) or d == 0.0:
                result = t
                mode = 4
            t = ti.min(ti.max((low * below - high * above) / ti.min(below - above, -1e-37), low), high)
    return result


@ti.func
def reflected(numbers, w, n, pull, h):
    """(velocity after, 1 if it rests): restitution and Coulomb's friction on the velocity w against the surface.

    w_n' = -e w_n, and 0 where gravity undoes the bounce within the step, e abs(w_n) <= pull h, with pull the acceleration
    into the surface; w_t' = 0 where abs(w_t) <= mu_s J, else w_t (1 - mu_k J / abs(w_t)), with J the change of w_n.
    """
    wn = w.dot(n)
    wt = w - n * wn
    rebound = numbers[0] * ti.max(-wn, 0.0)
    rests = 0
    if rebound <= ti.max(pull, 0.0) * h + ti.static(1e-14 if is_f64() else 5e-7) * w.norm():
        rests = 1
        rebound = 0.0
    J = ti.max(rebound - wn, 0.0)
    slip = wt.norm()
    if slip <= numbers[2] * J:
        wt *= 0.0
    else:
        wt *= ti.max(1.0 - numbers[1] * J / slip, 0.0)
    return wt + n * rebound, rests


@ti.func
def settled(walls: ti.template(), Q: ti.template(), rests, x, v, time):
    """The velocity v without what leads into the surfaces of the mask `rests`, at place x."""
    for sweep in range(_SWEEPS):
        for s in range(count(walls)):
            if (rests >> s) & 1 == 1:
                _, U = common(walls, Q, s)
                n = gradient(walls, Q, s, x - U * time)
                v -= n * ti.min((v - U).dot(n), 0.0)
    return v


@ti.func
def support(walls: ti.template(), Q: ti.template(), rests, x, free, now, left, radius):
    """How far the surfaces of the mask hold a particle back from the place `free` it would fall to, m, and with
    which friction: the way (3,), and kinetic and static coefficient times its length."""
    way = free * 0.0
    kinetic, static = left * 0.0, left * 0.0
    for sweep in range(_SWEEPS):
        for s in range(count(walls)):
            if (rests >> s) & 1 == 1:
                numbers, U = common(walls, Q, s)
                n = gradient(walls, Q, s, x - U * now)
                d = ti.max(radius - gap(walls, Q, s, free + way - U * (now + left)), 0.0)
                way += n * d
                kinetic += numbers[1] * d
                static += numbers[2] * d
    return way, kinetic, static
