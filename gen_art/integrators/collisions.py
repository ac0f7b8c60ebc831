"""Collisions inside a step: the path of the step is followed from surface to surface, and what is left of it goes on from there.

The path is the parabola through both ends of the step, x0 + v0 t + a t^2 / 2 with a = (v1 - v0) / h, plus a drift for what the
scheme adds. At an impact the particle stands exactly on the surface with the speed it has there; it leaves with the speed that
restitution and friction give it and the same acceleration, but for what the change of velocity does to drag and magnetic
force. Where a bounce would end within the step, the particle rests: the surface then holds it back from where it would fall
to, along the normal where it stands, and its end velocity is laid into the surface where it ends (the RATTLE scheme), while
friction acts on the way that the surface holds it back. Order 2, whatever the scheme's is. A lane that meets nothing keeps
its bits. Source: Andersen (1983), J. Comput. Phys. 52, 24, for RATTLE; Coulomb's law of friction.
"""

from gen_art.backend.kernel_views import parameters, traced
from gen_art.backend.runtime import is_f64, real, ti
from gen_art.colliders.base import ACTIONS
from gen_art.colliders.impact import bounce, resting_velocity, support, time_of_impact
from gen_art.colliders.surface import (
    carried_along,
    collider_of,
    count,
    nearest_distance,
    surface_properties,
    turning_speed,
)
from gen_art.integrators.ledger_rows import add_entry
from gen_art.integrators.tile import WIDTH
from gen_art.maths.elementary import phi
from gen_art.particles.rows import CHARGE, LIFETIME, MASS, RADIUS

__all__ = ["resolve_collisions"]

MAX_IMPACTS = 16  # impacts in a step; after that a particle waits for the next one


@traced
def number_of_action(one) -> int:
    """0 bounce, 1 stick, 2 kill, 3 emit. (A function: Taichi takes `a = ti.static(...)` for another name, not for a value.)"""
    return ACTIONS.index(one.values["action"])


@ti.func
def change_of_acceleration(terms: ti.template(), L: ti.template(), S: ti.template(), i, j, before, after, left):
    """How drag and magnetic force answer a sudden change of velocity: the change of acceleration for the time left."""
    r = before * 0.0
    for d in ti.static(range(len(terms.dampings))):
        m = ti.static(terms.dampings[d][2])
        u = ti.Vector([L.at("u", m, 0)[j], L.at("u", m, 1)[j], L.at("u", m, 2)[j]])
        k0 = L.at("k", d)[j] + L.at("q", d)[j] * (before - u).norm()
        k1 = L.at("k", d)[j] + L.at("q", d)[j] * (after - u).norm()
        r += ((before - u) * k0 - (after - u) * k1) * phi(ti.max(k0, k1) * left)
    if ti.static(len(terms.magnetics) > 0):
        r += (after - before).cross(ti.Vector([L.b0[j], L.b1[j], L.b2[j]])) * (S[CHARGE, i + j] / S[MASS, i + j])
    return r


@ti.func
def resolve_collisions(
    terms: ti.template(), L: ti.template(), G: ti.template(), X: ti.template(), S: ti.template(), Q: ti.template(),
    i, n, B: ti.template(), b, C: ti.template(), books: ti.template(),
):  # fmt: skip
    """Mend the step from G to X where its path meets a surface. With `books`, book to B (block b) and leave S alone;
    C then holds the change of velocity that conservative forces make in the step."""
    for j in range(
        ti.min(WIDTH, n - i)
    ):  # a bound that the compiler does not know: it would lay the body out again and again
        if L.h[j] > 0.0:
            h, radius, m = L.h[j], S[RADIUS, i + j], S[MASS, i + j]
            x = ti.Vector([G.x0[j], G.x1[j], G.x2[j]])
            v = ti.Vector([G.v0[j], G.v1[j], G.v2[j]])
            x1 = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
            v1 = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            a = (v1 - v) / h
            drift = (x1 - x) / h - 0.5 * (v + v1)
            reach = x.norm() * ti.static(1e-14 if is_f64() else 1e-5) + radius * 1e-3
            near, swing = 0, h * 0.0  # most do not come near a wall; how fast turning walls move where the particle is
            for wall in ti.static(terms.walls):
                q = parameters(Q, wall[0], wall[1])
                pace = (v + drift - q.velocity).norm() + a.norm() * h
                swung = turning_speed(wall[0], q, x, L.t[j])
                if ti.static(wall[0].turns):
                    swung += pace * h * q.angular_velocity.norm()
                swing = ti.max(swing, swung)
                if nearest_distance(wall[0], q, x, L.t[j]) - radius <= (pace + swung) * h + reach:
                    near = 1
            pushed = x * 0.0  # out of walls
            U = x * 0.0  # velocity of the surface touched last
            left, now = h * ti.cast(near, real()), L.t[j]
            rests, last, touched = 0, -1, 0
            work, dissipated = h * 0.0, h * 0.0
            for c, wall in ti.static(enumerate(terms.walls)):  # what sticks stays
                if ti.static(wall[0].values["action"] == "stick"):
                    q = parameters(Q, wall[0], wall[1])
                    for side in range(wall[0].sides):
                        _, W = surface_properties(terms.walls, Q, wall[2] + side, x, now)
                        if left > 0.0 and (v - W).norm() <= ti.static(1e-12 if is_f64() else 1e-5) * W.norm():
                            if ti.abs(terms.surface(Q, wall[2] + side, x, now, 0)[3] - radius) <= reach:
                                last, U, left = c, W, 0.0
                                x, v = carried_along(terms.walls, Q, wall[2] + side, x, now, h)
                                if ti.static(books):
                                    work += m * (v - v1).dot(U)
                                    add_entry(B, b, wall[3], 0.0, 0.0, m * (v - v1))
            event = 0
            while left > 0.0 and event < MAX_IMPACTS:
                event += 1
                if left > 0.0:
                    path, hold, rub, along = a, x * 0.0, x * 0.0, x * 0.0
                    free = x + (v + drift) * left + a * (0.5 * left * left)
                    kinetic, static = h * 0.0, h * 0.0
                    sticks = 0
                    stop = 2.0 * left
                    if rests != 0:
                        hold, kinetic, static = support(
                            terms.surface, terms.walls, Q, rests, x, free, now, left, radius
                        )
                        w = v - U
                        ridden, _ = carried_along(terms.walls, Q, touched, x, now, left)
                        slide = free + hold - ridden
                        slow = w.norm() <= ti.static(1e-9 if is_f64() else 1e-4) * a.norm() * h
                        if slow and static > 0.0 and slide.norm() <= static:
                            sticks = 1
                        elif kinetic > 0.0:
                            along = ti.select(slow or slide.dot(w) > 0.0, slide, w)
                            along /= ti.max(along.norm(), 1e-30)
                            rub = along * -kinetic
                        path = a + (hold + rub) * (2.0 / (left * left))
                        if kinetic > 0.0 and path.dot(along) < 0.0 and w.dot(along) > 0.0 and not slow:
                            stop = -w.dot(along) / path.dot(along)
                    first, which = 2.0 * left, -1
                    if sticks == 0:
                        for k in range(count(terms.walls)):
                            if (rests >> k) & 1 == 0:
                                _, W = surface_properties(terms.walls, Q, k, x, now)
                                t = time_of_impact(terms.surface, Q, k, x, v + drift, W, swing, path, now, left, radius)
                                if t <= left and t < first:
                                    first, which = t, k
                    if stop < first and stop < left:
                        which = -1
                    t = ti.min(ti.min(first, stop), left)
                    before, fall = x, v + a * t
                    whole = left
                    if last >= 0 or which >= 0:  # else nothing has happened, and the scheme's end stands
                        if sticks == 1:
                            x, v = carried_along(terms.walls, Q, touched, x, now, t)
                        elif t == left and which < 0:
                            x = free + hold + rub
                            v = fall + (hold + 2.0 * rub) / left
                        else:
                            x += (v + drift) * t + path * (0.5 * t * t)
                            v += path * t
                        now += t
                        if rests != 0:
                            if which < 0 and t < left:
                                v -= along * (v - U).dot(along)
                            if sticks == 0:
                                v = resting_velocity(terms.surface, terms.walls, Q, rests, x, v, now)
                            if ti.static(books):
                                gained = m * (v - fall)
                                work += gained.dot(U)
                                dissipated -= m * (2.0 / (whole * whole)) * rub.dot(x - before - U * t)
                                for c, wall in ti.static(enumerate(terms.walls)):
                                    if last == c:
                                        add_entry(B, b, wall[3], 0.0, 0.0, gained)
                        drift *= 0.0
                    left -= t
                    if which >= 0:
                        numbers, W = surface_properties(terms.walls, Q, which, x, now)
                        U = W
                        last, touched = collider_of(terms.walls, which), which
                        on = terms.surface(Q, which, x, now, 1)
                        normal = ti.Vector([on[0], on[1], on[2]])
                        inside = ti.max(radius - on[3], 0.0)
                        x += normal * inside
                        pushed += normal * inside
                        old = v
                        place = x
                        action = 0  # bounce
                        for c, wall in ti.static(enumerate(terms.walls)):
                            if last == c:
                                action = number_of_action(wall[0])
                        if action == 1:
                            place, v = carried_along(terms.walls, Q, which, x, now, left)
                        elif action != 2:
                            if action == 3:
                                if (U - v).dot(normal) > ti.max(
                                    -a.dot(normal), 0.0
                                ) * h:  # it arrives, and does not lie there
                                    if ti.static(not books and "impact" in terms.rows):
                                        S[ti.static(terms.rows["impact"]), i + j] = L.age[j] + h - left
                            w, stays = bounce(numbers, v - U, normal, -a.dot(normal), h)
                            v = U + w
                            rests = ti.select(stays == 1, rests | (1 << which), 0)
                        answer = change_of_acceleration(terms, L, S, i, j, old, v, left)
                        if ti.static(books):
                            change = v - old
                            work += m * change.dot(U)
                            dissipated += 0.5 * m * ((old - U).dot(old - U) - (v - U).dot(v - U))
                            spent = change + answer * left
                            if action == 1:
                                spent = change - a * left
                                work -= m * left * a.dot(U)
                            if action == 2:
                                spent = a * -left
                            for c, wall in ti.static(enumerate(terms.walls)):
                                if last == c:
                                    add_entry(B, b, wall[3], 0.0, 0.0, m * spent)
                        a += answer
                        if action == 1:
                            x = place
                        if action == 2:
                            if ti.static(not books):
                                S[LIFETIME, i + j] = L.age[j] + h - left
                        if action == 1 or action == 2:
                            left = 0.0
            if last >= 0:
                if ti.static(books):
                    extra = pushed.dot(ti.Vector([C.c0[j], C.c1[j], C.c2[j]])) * (-m / h)
                    if ti.static(terms.worked):
                        kept = (x - x1).dot(ti.Vector([C.c0[j], C.c1[j], C.c2[j]])) * (m / h)
                        extra = 0.5 * m * (v.dot(v) - v1.dot(v1)) + dissipated - work - kept
                    for c, wall in ti.static(enumerate(terms.walls)):
                        if last == c:
                            add_entry(B, b, wall[3], work + extra, dissipated, x * 0.0)
                X.x0[j], X.x1[j], X.x2[j] = x[0], x[1], x[2]
                X.v0[j], X.v1[j], X.v2[j] = v[0], v[1], v[2]
