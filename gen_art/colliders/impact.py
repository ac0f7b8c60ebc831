"""When a path meets a surface, and what the surface does to a velocity."""

from gen_art.colliders.base import surface
from gen_art.runtime import is_f64, ti

__all__ = ["gap", "meeting", "reflected", "settled", "support"]

_MARCH = 48  # the least step of the march along a path is its length over this: a shorter dip below a surface is a graze
_SWEEPS = 6  # over the surfaces a particle rests on: exact for right angles, closing in for others


@ti.func
def gap(one: ti.template(), q: ti.template(), side, x, time, radius):
    """The distance between a particle's skin and the surface, m, at a time."""
    return one.distance(x - q.velocity * time, q, side) - radius


@ti.func
def meeting(one: ti.template(), q: ti.template(), side, x, v, a, left, time, radius):
    """The time in [0, left] when the path x + v t + a t^2 / 2 first meets the surface; 2 left if it does not.

    No particle passes through: the path is marched along by the distance over the largest speed on it, then the root is
    bracketed and found by the Illinois rule. A path that starts on the surface is followed from where it is off it.
    """
    speed = ti.max((v - q.velocity).norm() + a.norm() * left, 1e-30)
    result = 2.0 * left
    d = gap(one, q, side, x, time, radius)
    if d <= speed * left:
        least = left / _MARCH
        t = left * 0.0
        at_once = 0
        if d <= 0.0:
            n = one.gradient(x - q.velocity * time, q, side)
            away, pull = (v - q.velocity).dot(n), -a.dot(n)
            if away < 0.0 or 2.0 * away <= pull * least:
                at_once = 1
            else:
                t = ti.min(ti.select(pull > 0.0, away / ti.select(pull > 0.0, pull, 1.0), least), left)
                d = gap(one, q, side, x + v * t + a * (0.5 * t * t), time + t, radius)
                if d <= 0.0:
                    at_once = 1
        if at_once == 1:
            result = left * 0.0
        else:
            low, above = t, d
            while d > 0.0 and t < left:
                low, above = t, d
                t = ti.min(t + ti.max(d / speed, least), left)
                d = gap(one, q, side, x + v * t + a * (0.5 * t * t), time + t, radius)
            if d <= 0.0:
                high, below, was = t, d, 0
                for step in range(ti.static(16 if is_f64() else 9)):
                    t = ti.min(ti.max((low * below - high * above) / (below - above), low), high)
                    d = gap(one, q, side, x + v * t + a * (0.5 * t * t), time + t, radius)
                    if d > 0.0:
                        low, above = t, d
                        below *= ti.select(was == 1, 0.5, 1.0)
                        was = 1
                    else:
                        high, below = t, d
                        above *= ti.select(was == 2, 0.5, 1.0)
                        was = 2
                    if below == above:  # both exactly on it
                        above = below + 1.0
                result = t
    return result


@ti.func
def reflected(one: ti.template(), q: ti.template(), w, n, pull, h):
    """(velocity after, 1 if it rests): restitution and Coulomb's friction on the velocity w against the surface.

    w_n' = -e w_n, and 0 where gravity undoes the bounce within the step, e abs(w_n) <= pull h, with pull the acceleration
    into the surface; w_t' = 0 where abs(w_t) <= mu_s J, else w_t (1 - mu_k J / abs(w_t)), with J the change of w_n.
    """
    wn = w.dot(n)
    wt = w - n * wn
    rebound = q.restitution * ti.max(-wn, 0.0)
    rests = 0
    if rebound <= ti.max(pull, 0.0) * h + ti.static(1e-14 if is_f64() else 5e-7) * w.norm():
        rests = 1
        rebound = 0.0
    J = ti.max(rebound - wn, 0.0)
    slip = wt.norm()
    if slip <= q.friction[1] * J:
        wt *= 0.0
    else:
        wt *= ti.max(1.0 - q.friction[0] * J / slip, 0.0)
    return wt + n * rebound, rests


@ti.func
def settled(walls: ti.template(), Q: ti.template(), rests, x, v, time):
    """The velocity v without what leads into the surfaces of the mask `rests`, at place x."""
    for sweep in range(_SWEEPS):
        for wall in ti.static(walls):
            q = surface(Q, wall[0], wall[1])
            for side in range(wall[0].sides):
                if (rests >> (wall[2] + side)) & 1 == 1:
                    n = wall[0].gradient(x - q.velocity * time, q, side)
                    v -= n * ti.min((v - q.velocity).dot(n), 0.0)
    return v


@ti.func
def support(walls: ti.template(), Q: ti.template(), rests, x, free, now, left, radius):
    """How far the surfaces of the mask hold a particle back from the place `free` it would fall to, m, and with
    which friction: the way (3,), and kinetic and static coefficient times its length."""
    way = free * 0.0
    kinetic, static = left * 0.0, left * 0.0
    for sweep in range(_SWEEPS):
        for wall in ti.static(walls):
            q = surface(Q, wall[0], wall[1])
            for side in range(wall[0].sides):
                if (rests >> (wall[2] + side)) & 1 == 1:
                    n = wall[0].gradient(x - q.velocity * now, q, side)
                    d = ti.max(-gap(wall[0], q, side, free + way, now + left, radius), 0.0)
                    way += n * d
                    kinetic += q.friction[0] * d
                    static += q.friction[1] * d
    return way, kinetic, static
