"""Collisions inside a step: the path of the step is followed to a surface, and the rest of the step continues from there.

The path is the parabola through both ends of the step, x0 + v0 t + a t^2 / 2 with a = (v1 - v0) / h, plus a drift for terms
that the scheme adds. At an impact the particle is exactly on the surface, with the speed that it has there. It leaves with the
velocity that restitution and friction give it and the same acceleration, except that drag and magnetic force change with the
velocity. If a bounce would end within the step, the particle rests: the surface then displaces it back from its free path,
along the normal at its position, its final velocity is projected onto the surface at its final position (the RATTLE scheme),
and friction acts on that displacement. The order is 2, whatever the scheme's is. A lane without contact keeps its bits.
Source: Andersen (1983), J. Comput. Phys. 52, 24, for RATTLE; Coulomb's law of friction.
"""

from gen_art.backend.kernel_views import traced
from gen_art.backend.runtime import is_f64, real, ti
from gen_art.colliders.base import ACTIONS
from gen_art.colliders.impact import bounce, resting_velocity, support, time_of_impact
from gen_art.colliders.kinds import numbers_of
from gen_art.colliders.surface import (
    carried_along,
    collider_of,
    count,
    is_of_kind,
    nearest_distance,
    rotation_speed,
    surface_properties,
)
from gen_art.integrators.lanes import WIDTH, age_of, step_of, time_of
from gen_art.integrators.ledger_rows import add_entry
from gen_art.integrators.particle_tile import flow_velocity
from gen_art.maths.elementary import phi
from gen_art.particles.rows import CHARGE, LIFETIME, MASS, RADIUS

__all__ = ["resolve_collisions"]

MAX_IMPACTS = 16  # in a step; after that a particle stays where it is until the next step
_BOUNCE, _STICK, _KILL, _EMIT = (ACTIONS.index(action) for action in ("bounce", "stick", "kill", "emit"))


@traced
def action_number(collider) -> int:
    """The collider's action. A function, because Taichi treats `a = ti.static(...)` as an alias, not as a value."""
    return ACTIONS.index(collider.values["action"])


@ti.func
def change_of_acceleration(terms: ti.template(), L: ti.template(), S: ti.template(), i, j, before, after, left):
    """The change of acceleration, for the time left, by drag and magnetic force after a sudden change of velocity."""
    r = before * 0.0
    for d, term in ti.static(enumerate(terms.dampings)):
        u = flow_velocity(terms, L, term.medium, j)
        k0 = L.at("k", d)[j] + L.at("q", d)[j] * (before - u).norm()
        k1 = L.at("k", d)[j] + L.at("q", d)[j] * (after - u).norm()
        r += ((before - u) * k0 - (after - u) * k1) * phi(ti.max(k0, k1) * left)
    if ti.static(len(terms.magnetics) > 0):
        r += (after - before).cross(ti.Vector([L.b0[j], L.b1[j], L.b2[j]])) * (S[CHARGE, i + j] / S[MASS, i + j])
    return r


@ti.func
def resolve_collisions(
    terms: ti.template(), L: ti.template(), G: ti.template(), X: ti.template(), S: ti.template(), Q: ti.template(),
    i, n, B: ti.template(), b, C: ti.template(), for_ledger: ti.template(),
):  # fmt: skip
    """Correct the step from G to X, in X, for lanes whose path touches a surface.

    for_ledger : write entries to B (block b) and leave S unchanged; C is then the change of velocity by conservative forces
    """
    # a run-time bound: with a constant one the compiler would unroll the body
    for j in range(ti.min(WIDTH, n - i)):
        if step_of(L, j) > 0.0:
            h, radius, m = step_of(L, j), S[RADIUS, i + j], S[MASS, i + j]
            x = ti.Vector([G.x0[j], G.x1[j], G.x2[j]])
            v = ti.Vector([G.v0[j], G.v1[j], G.v2[j]])
            x1 = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
            v1 = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            a = (v1 - v) / h
            drift = (x1 - x) / h - 0.5 * (v + v1)
            margin = x.norm() * ti.static(1e-14 if is_f64() else 1e-5) + radius * 1e-3
            near, rotation = 0, h * 0.0  # whether a surface may be touched, and the largest speed of rotating ones here
            for kind in ti.static(terms.kinds):
                for c in range(kind.count):
                    q = numbers_of(Q, kind, c)
                    fastest = (v + drift - q.velocity).norm() + a.norm() * h
                    speed = rotation_speed(kind.collider, q, x, time_of(L, j))
                    if ti.static(kind.collider.rotates):
                        speed += fastest * h * q.angular_velocity.norm()
                    rotation = ti.max(rotation, speed)
                    if nearest_distance(kind.collider, q, x, time_of(L, j)) - radius <= (fastest + speed) * h + margin:
                        near = 1
            correction = x * 0.0  # out of surfaces
            U = x * 0.0  # velocity of the surface touched last
            left, now = h * ti.cast(near, real()), time_of(L, j)
            resting_on, last, touched = 0, -1, 0
            work, dissipated = h * 0.0, h * 0.0
            for kind in ti.static(terms.kinds):  # a particle that sticks moves with its surface
                if ti.static(kind.collider.values["action"] == "stick"):
                    for k in range(kind.first_surface, kind.first_surface + kind.count * kind.collider.sides):
                        _, W = surface_properties(terms.kinds, Q, k, x, now)
                        if left > 0.0 and (v - W).norm() <= ti.static(1e-12 if is_f64() else 1e-5) * W.norm():
                            if ti.abs(terms.surface(Q, k, x, now, 0)[3] - radius) <= margin:
                                last, U, left = collider_of(terms.kinds, k), W, 0.0
                                x, v = carried_along(terms.kinds, Q, k, x, now, h)
                                if ti.static(for_ledger):
                                    work += m * (v - v1).dot(U)
                                    add_entry(B, b, i + j, terms.collider_row + last, 0.0, 0.0, m * (v - v1))
            impacts = 0
            while left > 0.0 and impacts < MAX_IMPACTS:
                impacts += 1
                if left > 0.0:
                    path, displaced, friction, along = a, x * 0.0, x * 0.0, x * 0.0
                    free = x + (v + drift) * left + a * (0.5 * left * left)
                    kinetic, static = h * 0.0, h * 0.0
                    sticks = 0
                    stop = 2.0 * left
                    if resting_on != 0:
                        displaced, kinetic, static = support(
                            terms.surface, terms.kinds, Q, resting_on, x, free, now, left, radius
                        )
                        w = v - U
                        moved, _ = carried_along(terms.kinds, Q, touched, x, now, left)
                        slide = free + displaced - moved
                        slow = w.norm() <= ti.static(1e-9 if is_f64() else 1e-4) * a.norm() * h
                        if slow and static > 0.0 and slide.norm() <= static:
                            sticks = 1
                        elif kinetic > 0.0:
                            along = ti.select(slow or slide.dot(w) > 0.0, slide, w)
                            along /= ti.max(along.norm(), 1e-30)
                            friction = along * -kinetic
                        path = a + (displaced + friction) * (2.0 / (left * left))
                        if kinetic > 0.0 and path.dot(along) < 0.0 and w.dot(along) > 0.0 and not slow:
                            stop = -w.dot(along) / path.dot(along)
                    first, which = 2.0 * left, -1
                    if sticks == 0:
                        for k in range(count(terms.kinds)):
                            if (resting_on >> k) & 1 == 0:
                                _, W = surface_properties(terms.kinds, Q, k, x, now)
                                t = time_of_impact(
                                    terms.surface, Q, k, x, v + drift, W, rotation, path, now, left, radius
                                )
                                if t <= left and t < first:
                                    first, which = t, k
                    if stop < first and stop < left:
                        which = -1
                    t = ti.min(ti.min(first, stop), left)
                    before, free_velocity = x, v + a * t
                    span = left
                    if last >= 0 or which >= 0:  # else there is no contact, and the scheme's result is kept
                        if sticks == 1:
                            x, v = carried_along(terms.kinds, Q, touched, x, now, t)
                        elif t == left and which < 0:
                            x = free + displaced + friction
                            v = free_velocity + (displaced + 2.0 * friction) / left
                        else:
                            x += (v + drift) * t + path * (0.5 * t * t)
                            v += path * t
                        now += t
                        if resting_on != 0:
                            if which < 0 and t < left:
                                v -= along * (v - U).dot(along)
                            if sticks == 0:
                                v = resting_velocity(terms.surface, terms.kinds, Q, resting_on, x, v, now)
                            if ti.static(for_ledger):
                                gained = m * (v - free_velocity)
                                work += gained.dot(U)
                                dissipated -= m * (2.0 / (span * span)) * friction.dot(x - before - U * t)
                                if last >= 0:
                                    add_entry(B, b, i + j, terms.collider_row + last, 0.0, 0.0, gained)
                        drift *= 0.0
                    left -= t
                    if which >= 0:
                        material, W = surface_properties(terms.kinds, Q, which, x, now)
                        U = W
                        last, touched = collider_of(terms.kinds, which), which
                        hit = terms.surface(Q, which, x, now, 1)
                        normal = ti.Vector([hit[0], hit[1], hit[2]])
                        depth = ti.max(radius - hit[3], 0.0)
                        x += normal * depth
                        correction += normal * depth
                        old = v
                        final = x
                        action = _BOUNCE
                        for kind in ti.static(terms.kinds):
                            if is_of_kind(kind, which):
                                action = action_number(kind.collider)
                        if action == _STICK:
                            final, v = carried_along(terms.kinds, Q, which, x, now, left)
                        elif action != _KILL:
                            if action == _EMIT:
                                # faster than a particle that lies on the surface gets in a step
                                if (U - v).dot(normal) > ti.max(-a.dot(normal), 0.0) * h:
                                    if ti.static(not for_ledger and "impact" in terms.rows):
                                        S[ti.static(terms.rows["impact"]), i + j] = age_of(L, j) + h - left
                            w, resting = bounce(material, v - U, normal, -a.dot(normal), h)
                            v = U + w
                            resting_on = ti.select(resting == 1, resting_on | (1 << which), 0)
                        response = change_of_acceleration(terms, L, S, i, j, old, v, left)
                        if ti.static(for_ledger):
                            change = v - old
                            work += m * change.dot(U)
                            dissipated += 0.5 * m * ((old - U).dot(old - U) - (v - U).dot(v - U))
                            used = change + response * left
                            if action == _STICK:
                                used = change - a * left
                                work -= m * left * a.dot(U)
                            if action == _KILL:
                                used = a * -left
                            add_entry(B, b, i + j, terms.collider_row + last, 0.0, 0.0, m * used)
                        a += response
                        if action == _STICK:
                            x = final
                            left = 0.0
                        if action == _KILL:
                            if ti.static(not for_ledger):
                                S[LIFETIME, i + j] = age_of(L, j) + h - left
                            left = 0.0
            if last >= 0:
                if ti.static(for_ledger):
                    extra = correction.dot(ti.Vector([C.c0[j], C.c1[j], C.c2[j]])) * (-m / h)
                    if ti.static(terms.collisions_balance_energy):
                        potential = (x - x1).dot(ti.Vector([C.c0[j], C.c1[j], C.c2[j]])) * (m / h)
                        extra = 0.5 * m * (v.dot(v) - v1.dot(v1)) + dissipated - work - potential
                    # after MAX_IMPACTS the forces of the time left do not act
                    add_entry(B, b, i + j, terms.collider_row + last, work + extra, dissipated, a * (-m * left))
                X.x0[j], X.x1[j], X.x2[j] = x[0], x[1], x[2]
                X.v0[j], X.v1[j], X.v2[j] = v[0], v[1], v[2]
