"""When a path meets a surface, and what the surface does to a velocity. `surface` is the function of surface.py."""

from gen_art.backend.runtime import is_f64, ti
from gen_art.colliders.surface import count, surface_properties

__all__ = ["time_of_impact", "bounce", "resting_velocity", "support"]

_FIRST, _GROWTH = 1e-4, 1.05  # least step of the march along a path, of its length, and its growth: at most 130 steps
_GRAZE = 0.02  # a hop shorter than this share of the path counts as resting
_SWEEPS = 6  # over the surfaces a particle rests on: exact for right angles, closing in for others


@ti.func
def time_of_impact(surface: ti.template(), Q: ti.template(), s, x, v, W, turning, a, now, left, radius):
    """The time in [0, left] when the path x + v t + a t^2 / 2 from time `now` on first meets surface s; 2 left if it does not.

    W : velocity of the surface     turning : m/s, the most that its turning moves it there
    No particle passes through: the path is marched along by the distance over the largest speed on it, then the root is
    bracketed and found by the Illinois rule. A path that starts on the surface is followed from where it is off it.
    """
    speed = ti.max((v - W).norm() + a.norm() * left + turning, 1e-30)
    result = 2.0 * left
    least = left * _FIRST
    t, low, high, above, below = left * 0.0, left * 0.0, left, left * 0.0, left * 0.0
    mode, steps, was = 0, 0, 0  # 0 at the start, 1 off the surface again, 2 marching, 3 between low and high, 4 done
    while mode < 4:
        on = surface(Q, s, x + v * t + a * (0.5 * t * t), now + t, ti.cast(mode == 0, ti.i32))
        d = on[3] - radius
        if d > 0.0 and mode < 3:
            if (mode == 0 and d > speed * left) or t >= left:
                mode = 4
            else:
                low, above = t, d
                t = ti.min(t + ti.max(d / speed, least), left)
                least *= _GROWTH
                mode = 2
        elif mode == 0:
            n = ti.Vector([on[0], on[1], on[2]])
            away, pull = (v - W).dot(n), -a.dot(n)
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
def bounce(numbers, w, n, pull, h):
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
def resting_velocity(surface: ti.template(), walls: ti.template(), Q: ti.template(), rests, x, v, time):
    """The velocity v without what leads into the surfaces of the mask `rests`, at place x."""
    for sweep in range(_SWEEPS):
        for s in range(count(walls)):
            if (rests >> s) & 1 == 1:
                _, U = surface_properties(walls, Q, s, x, time)
                on = surface(Q, s, x, time, 1)
                n = ti.Vector([on[0], on[1], on[2]])
                v -= n * ti.min((v - U).dot(n), 0.0)
    return v


@ti.func
def support(surface: ti.template(), walls: ti.template(), Q: ti.template(), rests, x, free, now, left, radius):
    """How far the surfaces of the mask hold a particle back from the place `free` it would fall to, m, and with
    which friction: the way (3,), and kinetic and static coefficient times its length."""
    way = free * 0.0
    kinetic, static = left * 0.0, left * 0.0
    for sweep in range(_SWEEPS):
        for s in range(count(walls)):
            if (rests >> s) & 1 == 1:
                numbers, _ = surface_properties(walls, Q, s, x, now)
                on = surface(Q, s, x, now, 1)
                n = ti.Vector([on[0], on[1], on[2]])
                d = ti.max(radius - surface(Q, s, free + way, now + left, 0)[3], 0.0)
                way += n * d
                kinetic += numbers[1] * d
                static += numbers[2] * d
    return way, kinetic, static
