"""The time of impact of a path on a surface, and the velocity after it. `surface` is the function of surface.py."""

from gen_art.backend.runtime import is_f64, ti
from gen_art.colliders.surface import count, surface_properties

__all__ = ["time_of_impact", "bounce", "resting_velocity", "support"]

_FIRST, _GROWTH = 1e-4, 1.05  # smallest step along a path, relative to its length, and its growth: at most 130 steps
_GRAZE = 0.02  # a hop shorter than this part of the path counts as resting
_SWEEPS = 6  # over the surfaces that a particle rests on: exact for right angles, convergent for others

# states of the search for an impact
_START, _OFF_AGAIN, _MARCH, _BRACKETED, _DONE = 0, 1, 2, 3, 4


@ti.func
def time_of_impact(surface: ti.template(), Q: ti.template(), s, x, v, W, rotation, a, now, left, radius):
    """The time in [0, left] of the first contact of the path x + v t + a t^2 / 2 with surface s; 2 left if there is none.

    W : velocity of the surface, m/s
    rotation : upper bound of the speed, m/s, by which the surface's rotation moves it there
    now : time at the start of the path, s
    No particle passes through: the search steps along the path by the distance over the largest speed, until the root is
    bracketed, and then uses the Illinois method. If the path starts on the surface, the search starts where it leaves it.
    """
    speed = ti.max((v - W).norm() + a.norm() * left + rotation, 1e-30)
    result = 2.0 * left
    step = left * _FIRST
    t, low, high, above, below = left * 0.0, left * 0.0, left, left * 0.0, left * 0.0
    mode, steps, last_side = _START, 0, 0
    while mode < _DONE:
        hit = surface(Q, s, x + v * t + a * (0.5 * t * t), now + t, ti.cast(mode == _START, ti.i32))
        d = hit[3] - radius
        if d > 0.0 and mode < _BRACKETED:
            if (mode == _START and d > speed * left) or t >= left:
                mode = _DONE
            else:
                low, above = t, d
                t = ti.min(t + ti.max(d / speed, step), left)
                step *= _GROWTH
                mode = _MARCH
        elif mode == _START:
            n = ti.Vector([hit[0], hit[1], hit[2]])
            away, into = (v - W).dot(n), -a.dot(n)
            if away < 0.0 or 2.0 * away <= into * left * _GRAZE:
                result = left * 0.0
                mode = _DONE
            else:
                t = ti.min(ti.select(into > 0.0, away / ti.select(into > 0.0, into, 1.0), left * _GRAZE), left)
                mode = _OFF_AGAIN
        elif mode == _OFF_AGAIN:
            result = left * 0.0
            mode = _DONE
        else:
            if mode == _MARCH:
                high, below = t, d
                mode = _BRACKETED
            elif d > 0.0:
                low, above = t, d
                below *= ti.select(last_side == 1, 0.5, 1.0)
                last_side = 1
            else:
                high, below = t, d
                above *= ti.select(last_side == 2, 0.5, 1.0)
                last_side = 2
            steps += 1
            if steps > ti.static(16 if is_f64() else 9) or d == 0.0:
                result = t
                mode = _DONE
            t = ti.min(ti.max((low * below - high * above) / ti.min(below - above, -1e-37), low), high)
    return result


@ti.func
def bounce(material, w, n, into_surface, h):
    """(velocity after, 1 if the particle then rests), for the velocity w relative to the surface.

    material : restitution e, kinetic and static friction mu_k and mu_s
    n : normal of the surface
    into_surface : m/s^2, acceleration into the surface
    h : s, the step

    w_n' = -e w_n, and 0 where gravity undoes the bounce within the step, e abs(w_n) <= into_surface h;
    w_t' = 0 where abs(w_t) <= mu_s J, else w_t (1 - mu_k J / abs(w_t)), with J the change of w_n (Coulomb's friction).
    """
    wn = w.dot(n)
    wt = w - n * wn
    rebound = material[0] * ti.max(-wn, 0.0)
    resting = 0
    if rebound <= ti.max(into_surface, 0.0) * h + ti.static(1e-14 if is_f64() else 5e-7) * w.norm():
        resting = 1
        rebound = 0.0
    J = ti.max(rebound - wn, 0.0)
    slip = wt.norm()
    if slip <= material[2] * J:
        wt *= 0.0
    else:
        wt *= ti.max(1.0 - material[1] * J / slip, 0.0)
    return wt + n * rebound, resting


@ti.func
def resting_velocity(surface: ti.template(), kinds: ti.template(), Q: ti.template(), resting_on, x, v, time):
    """The velocity v without its components into the surfaces of the mask `resting_on`, at the position x."""
    for sweep in range(_SWEEPS):
        for s in range(count(kinds)):
            if (resting_on >> s) & 1 == 1:
                _, U = surface_properties(kinds, Q, s, x, time)
                hit = surface(Q, s, x, time, 1)
                n = ti.Vector([hit[0], hit[1], hit[2]])
                v -= n * ti.min((v - U).dot(n), 0.0)
    return v


@ti.func
def support(surface: ti.template(), kinds: ti.template(), Q: ti.template(), resting_on, x, free, now, left, radius):
    """The displacement (3,), m, by which the surfaces of the mask keep a particle from its free position `free`.

    Returns it with the kinetic and the static friction coefficient, each times its length, m.
    """
    shift = free * 0.0
    kinetic, static = left * 0.0, left * 0.0
    for sweep in range(_SWEEPS):
        for s in range(count(kinds)):
            if (resting_on >> s) & 1 == 1:
                material, _ = surface_properties(kinds, Q, s, x, now)
                hit = surface(Q, s, x, now, 1)
                n = ti.Vector([hit[0], hit[1], hit[2]])
                d = ti.max(radius - surface(Q, s, free + shift, now + left, 0)[3], 0.0)
                shift += n * d
                kinetic += material[1] * d
                static += material[2] * d
    return shift, kinetic, static
