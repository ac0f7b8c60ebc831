"""What all step kernels share: each lane's own step, and the loops that sum a composition's terms over a tile.

Each loop over lanes is innermost, reads global memory and writes only to local vectors, so that it vectorises; repeats
(octaves) are run-time loops around it.
"""

from typing import Any

from gen_art.backend.kernel_views import parameters, particle, traced
from gen_art.backend.runtime import impl, make_matrix, ti
from gen_art.colliders.kinds import collider_kinds
from gen_art.colliders.surface import make_surface
from gen_art.forces.base import is_steady, term_acceleration
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.lanes import (
    STATE,
    WIDTH,
    age_of,
    all_alive,
    are_whole,
    copy,
    load_lifespans,
    step_of,
    tile,
    time_of,
)
from gen_art.particles.fixed import is_fixed
from gen_art.particles.periodic_box import wrapped
from gen_art.particles.rows import CHARGE, FIRST_ATTRIBUTE, LIFETIME, MASS, RADIUS

__all__ = [
    "TileTerms", "accumulate", "flow_velocity", "lane_steps", "place", "repeats", "specific_charge", "stage_view", "view", "wrap",
]  # fmt: skip


class TileTerms:
    """A composition as kernels use it.

    accelerations, magnetics, dampings, noises, mass_loss_terms, potentials : the Terms of each kind
    lifespans : whether particles may be born or die within a step, or are fixed
    media : the Terms of each medium
    kinds : the ColliderKinds
    collider_row : the ledger's row of the first collider
    pairs : number of arrays of pair accelerations
    rows : the declared attributes' rows in S, by name
    surface : the function of distance and normal of surface.py, None without colliders
    exhaust_row : the ledger's row of the first engine's exhaust
    box_offset : where the numbers of the periodic box begin in Q, or -1 in open space
    boundary_row : the ledger's row of the sides of the box, or -1 if no potential changes there
    start_vectors : names of the vectors that keep the start of a step for collisions
    collisions_balance_energy : whether the work at impacts is found from the energy, because other forces are not conservative
    uniform_damping : whether the damping is the same for all particles and steps, and so is its exponential for whole steps
    keeps_rates : whether the rates of the dampings are read after the kick too
    reusable : whether the result of `accumulate` holds for the next step too if no position changes in between
    vectors : names of the lanes' vectors L
    """

    _data_oriented = True

    def __init__(
        self, composition: KernelTerms, channels: tuple, pairs: int, real, rotation: tuple = ("", False, False),
        lifespans: bool = True,
    ):  # fmt: skip
        self.lifespans = lifespans
        self.pusher, self.relativistic, self.exact = rotation
        self.accelerations, self.magnetics = composition.accelerations, composition.magnetics
        self.dampings, self.noises = composition.dampings, composition.noises
        self.mass_loss_terms, self.potentials = composition.mass_loss_terms, composition.potentials
        self.media = composition.media
        self.rows = {name: FIRST_ATTRIBUTE + k for k, name in enumerate(channels)}
        self.pairs = pairs
        self.count = len(composition.terms)
        self.kinds = collider_kinds(composition.colliders)
        self.surface: Any = make_surface(self.kinds, real) if self.kinds else None
        self.collider_row = self.count + pairs
        self.exhaust_row = self.collider_row + len(composition.colliders)
        self.box_offset = -1 if composition.box is None else composition.box_offset
        self.boundary_row = -1
        if composition.box is not None and self.potentials:
            self.boundary_row = self.exhaust_row + 2 * len(self.mass_loss_terms)
        self.start_vectors = STATE if self.kinds else ""
        self.collisions_balance_energy = any(kind.collider.rotates for kind in self.kinds) or any(
            t.force.does_work and not t.force.conservative for t in composition.terms
        )
        varying = [
            t
            for t in self.dampings
            if not t.force.steady or t.force.damping_reads_particle or t.force.quadratic_damping
        ]
        self.uniform_damping = bool(self.dampings) and not (varying or self.magnetics)
        self.quadratic = any(t.force.quadratic_damping for t in self.dampings)
        steady = all(is_steady(t.force) for terms in (composition.terms, *self.media) for t in terms)
        self.reusable = steady and not (self.magnetics or self.kinds or self.mass_loss_terms)
        self.magnetic_without_damping = bool(self.magnetics) and not self.dampings
        self.keeps_rates = bool(self.kinds or self.noises)
        names = ["a0 a1 a2"]
        if lifespans:
            names.append("h age t lifetime")
            if self.uniform_damping:
                names.append("gain")
        if self.keeps_rates:
            names += [f"k{d} q{d}" for d in range(len(self.dampings))]
        names += [f"u{m}0 u{m}1 u{m}2" for m in range(len(self.media)) if self.media[m]]
        if self.mass_loss_terms:
            names.append("m w")  # mass at the stage, and its loss in kg/s
        if self.noises:
            names.append("s n0 n1 n2")  # strength of the thermal noise, m^2/s^3, and the velocity that it has added
        if self.magnetics:
            names.append("b0 b1 b2")
        self.vectors = " ".join(names)


@traced
def single(terms: list) -> list:
    """Those of some Terms that are evaluated once: one loop over the lanes takes them all."""
    return [term for term in terms if term.count_offset < 0]


@traced
def repeated(terms: list) -> list:
    """Those that are sums over repeats: each takes a loop over the lanes of its own, within the loop over the repeats."""
    return [term for term in terms if term.count_offset >= 0]


@traced
def view(terms: TileTerms, S, K, i, x, v, age, flow=None, mass=None, step=None):
    """The particle `p` in slot i as forces see it, at position x with velocity v.

    age : s
    flow : velocity of its medium, for terms that depend on one
    mass : kg, where it changes within a step; else the stored one is used
    step : (age at the start of its step, length of the step), s, for particles that lose mass
    """
    row = lambda r: impl.subscript(None, S, r, i)  # noqa: E731
    key = make_matrix([impl.subscript(None, K, 0, i), impl.subscript(None, K, 1, i)])
    extra = {name: row(r) for name, r in terms.rows.items()}
    if flow is not None:
        extra["flow"] = flow
    if step is not None:
        extra["since"], extra["step"] = step
    return particle(
        position=x,
        velocity=v,
        mass=row(MASS) if mass is None else mass,
        charge=row(CHARGE),
        radius=row(RADIUS),
        lifetime=row(LIFETIME),
        age=age,
        key=key,
        **extra,
    )


@traced
def stage_view(terms: TileTerms, S, K, L, i, j, x, v, age, flow=None):
    """The particle in lane j of the tile at slot i, at a stage of the step; its mass is L.m if it loses mass."""
    mass = step = None
    if terms.mass_loss_terms:
        mass = impl.subscript(None, L.m, j)
        step = (age_of(L, j), step_of(L, j))
    return view(terms, S, K, i + j, x, v, age, flow, mass, step)


@traced
def flow_velocity(terms: TileTerms, L, medium: int, j):
    """The velocity of a medium in lane j, which `accumulate` has summed; None if the term depends on no medium."""
    if medium < 0:
        return None
    if not terms.media[medium]:
        return make_matrix([0.0, 0.0, 0.0])
    return make_matrix([impl.subscript(None, L.at("u", medium, c), j) for c in range(3)])


@ti.func
def specific_charge(terms: ti.template(), L: ti.template(), S: ti.template(), i, j):
    """Charge over mass, C/kg, of lane j."""
    ratio = S[CHARGE, i + j] / S[MASS, i + j]
    if ti.static(len(terms.mass_loss_terms) > 0):
        ratio = S[CHARGE, i + j] / L.m[j]
    return ratio


@ti.func
def repeats(Q: ti.template(), count_offset: ti.template()):
    """How often a term is evaluated; 1 for a count_offset of -1."""
    count = 1
    if ti.static(count_offset >= 0):
        count = ti.cast(Q[count_offset], ti.i32)
    return count


@ti.func
def wrap(terms: ti.template(), T: ti.template(), Q: ti.template()):
    """Move the tile's positions into the periodic box, if there is one."""
    if ti.static(terms.box_offset >= 0):
        b = ti.static(terms.box_offset)
        for j in range(WIDTH):
            T.x0[j] = wrapped(T.x0[j], Q[b], Q[b + 3], Q[b + 6])
            T.x1[j] = wrapped(T.x1[j], Q[b + 1], Q[b + 4], Q[b + 7])
            T.x2[j] = wrapped(T.x2[j], Q[b + 2], Q[b + 5], Q[b + 8])


@ti.func
def place(terms: ti.template(), X: ti.template(), Q: ti.template(), j):
    """The position of lane j as forces see it: in the periodic box, if there is one."""
    x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
    if ti.static(terms.box_offset >= 0):
        b = ti.static(terms.box_offset)
        for c in ti.static(range(3)):
            x[c] = wrapped(x[c], Q[b + c], Q[b + 3 + c], Q[b + 6 + c])
    return x


@ti.func
def lane_steps(
    terms: ti.template(), L: ti.template(), S: ti.template(), at, birth: ti.template(), at_birth, i, now, dt, earliest,
    real: ti.template(),
):  # fmt: skip
    """Find each lane's own step: the part of [now, now + dt] that it is alive, and its age and time where that part begins."""
    if ti.static(terms.lifespans):
        load_lifespans(L, S, at, birth, at_birth, i)
        for j in range(WIDTH):
            since = L.birth[j] - now
            start = ti.max(since, earliest)
            end = ti.min(since + ti.cast(L.lifetime[j], ti.f64), dt)
            h = ti.cast(ti.max(end - start, ti.f64(0.0)), real)
            L.h[j] = ti.select(is_fixed(L.lifetime[j]), h * 0.0, h)
            L.age[j] = ti.cast(start - since, real)
            L.t[j] = ti.cast(now + start, real)
        if ti.static(terms.uniform_damping):
            parts = 0
            for j in range(WIDTH):
                parts += ti.select(L.h[j] == ti.cast(dt, real) or L.h[j] == 0.0, 0, 1)
            are_whole(L, parts == 0)
    else:
        all_alive(L, ti.cast(dt, real), ti.cast(now, real), now, birth, i)


@ti.func
def accumulate(
    terms: ti.template(), L: ti.template(), X: ti.template(), S: ti.template(), K: ti.template(), A: ti.template(),
    Q: ti.template(), i, tau,
):  # fmt: skip
    """Sum all terms at the state X of the tile and the fraction tau of each lane's step; the sums are written to L.

    In a periodic box X may have left it, because the path of a step is not wrapped; forces act at the place in the box.
    """
    if ti.static(terms.box_offset >= 0):
        Y = tile(STATE)
        copy(Y, X)
        wrap(terms, Y, Q)
        sum_terms(terms, L, Y, S, K, A, Q, i, tau)
    else:
        sum_terms(terms, L, X, S, K, A, Q, i, tau)


@ti.func
def sum_terms(
    terms: ti.template(), L: ti.template(), X: ti.template(), S: ti.template(), K: ti.template(), A: ti.template(),
    Q: ti.template(), i, tau,
):  # fmt: skip
    if ti.static(len(terms.mass_loss_terms) > 0):
        for j in range(WIDTH):
            L.m[j] = S[MASS, i + j] - tau * step_of(L, j) * L.w[j]
    for m in ti.static(range(len(terms.media))):
        if ti.static(len(terms.media[m]) > 0):
            for j in range(WIDTH):
                u = ti.Vector([0.0, 0.0, 0.0])
                x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                for term in ti.static(single(terms.media[m])):
                    p = stage_view(terms, S, K, L, i, j, x, v, age_of(L, j) + tau * step_of(L, j))
                    q = parameters(Q, term.force, term.offset)
                    u += term.force.acceleration(p, time_of(L, j) + tau * step_of(L, j), q)
                L.at("u", m, 0)[j], L.at("u", m, 1)[j], L.at("u", m, 2)[j] = u[0], u[1], u[2]
        for term in ti.static(repeated(terms.media[m])):
            for repeat in range(repeats(Q, term.count_offset)):
                for j in range(WIDTH):
                    x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                    v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                    p = stage_view(terms, S, K, L, i, j, x, v, age_of(L, j) + tau * step_of(L, j))
                    q = parameters(Q, term.force, term.offset, repeat)
                    u = term.force.acceleration(p, time_of(L, j) + tau * step_of(L, j), q)
                    L.at("u", m, 0)[j] += u[0]
                    L.at("u", m, 1)[j] += u[1]
                    L.at("u", m, 2)[j] += u[2]
    for j in range(WIDTH):
        a = ti.Vector([0.0, 0.0, 0.0])
        x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
        v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
        for k in ti.static(range(terms.pairs)):
            a += ti.Vector([A[3 * k, i + j], A[3 * k + 1, i + j], A[3 * k + 2, i + j]])
        for term in ti.static(single(terms.accelerations)):
            age = age_of(L, j) + tau * step_of(L, j)
            p = stage_view(terms, S, K, L, i, j, x, v, age, flow_velocity(terms, L, term.medium, j))
            q = parameters(Q, term.force, term.offset)
            a += term_acceleration(term.force, p, time_of(L, j) + tau * step_of(L, j), q)
        L.a0[j], L.a1[j], L.a2[j] = a[0], a[1], a[2]
    for term in ti.static(repeated(terms.accelerations)):
        for repeat in range(repeats(Q, term.count_offset)):
            for j in range(WIDTH):
                x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                age = age_of(L, j) + tau * step_of(L, j)
                p = stage_view(terms, S, K, L, i, j, x, v, age, flow_velocity(terms, L, term.medium, j))
                q = parameters(Q, term.force, term.offset, repeat)
                a = term_acceleration(term.force, p, time_of(L, j) + tau * step_of(L, j), q)
                L.a0[j] += a[0]
                L.a1[j] += a[1]
                L.a2[j] += a[2]
    if ti.static(len(terms.noises) > 0):
        for j in range(WIDTH):
            L.s[j] = 0.0
        for term in ti.static(terms.noises):
            for j in range(WIDTH):
                x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                p = stage_view(terms, S, K, L, i, j, x, v, age_of(L, j) + tau * step_of(L, j))
                t = time_of(L, j) + tau * step_of(L, j)
                L.s[j] += term.force.noise(p, t, parameters(Q, term.force, term.offset))
    if ti.static(len(terms.magnetics) > 0):
        for j in range(WIDTH):
            b = ti.Vector([0.0, 0.0, 0.0])
            x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
            v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            for term in ti.static(single(terms.magnetics)):
                p = stage_view(terms, S, K, L, i, j, x, v, age_of(L, j) + tau * step_of(L, j))
                t = time_of(L, j) + tau * step_of(L, j)
                b += term.force.magnetic(p, t, parameters(Q, term.force, term.offset))
            L.b0[j], L.b1[j], L.b2[j] = b[0], b[1], b[2]
        for term in ti.static(repeated(terms.magnetics)):
            for repeat in range(repeats(Q, term.count_offset)):
                for j in range(WIDTH):
                    x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
                    v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                    p = stage_view(terms, S, K, L, i, j, x, v, age_of(L, j) + tau * step_of(L, j))
                    q = parameters(Q, term.force, term.offset, repeat)
                    field = term.force.magnetic(p, time_of(L, j) + tau * step_of(L, j), q)
                    L.b0[j] += field[0]
                    L.b1[j] += field[1]
                    L.b2[j] += field[2]
