"""The ledger kernel: what each force does to the particles in a step.

It repeats the step of step_kernels.py on local copies, with the same functions and therefore the same bits, and stores no
state. It records the work m a.(v0 + v1)/2 h of each term (stage weights in Runge-Kutta), the energy that drag takes and that
its medium gives, and all impulses. With a speed of light the momentum is m u, u = gamma v, and the work is the impulse times
(u0 + u1) / (gamma0 + gamma1): the change of (gamma - 1) m c^2 is exactly m (u1 - u0) times it.
The sides of a periodic box have a row where forces have potentials: a potential jumps where a particle is wrapped.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.forces.base import term_acceleration
from gen_art.integrators.collisions import resolve_collisions
from gen_art.integrators.damping import damping_rate, damping_rates, find_gains, stage_gains
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.kick import kick
from gen_art.integrators.lanes import STATE, WIDTH, age_of, copy, lanes, load, step_of, tile, time_of
from gen_art.integrators.ledger_rows import LEDGER_COLUMNS, add_entry, ledger_arrays
from gen_art.integrators.mass_loss import add_exhaust_entries, compute_mass_loss
from gen_art.integrators.particle_tile import (
    TileTerms,
    accumulate,
    flow_velocity,
    lane_steps,
    place,
    repeats,
    stage_view,
    view,
)
from gen_art.integrators.pushers import gamma_at
from gen_art.integrators.schemes import AHEAD, DRIFT, FIRST_DRIFT, KICK, STAGE, TIME, WEIGHT
from gen_art.integrators.step_kernels import BLOCK, advance_stage, drift
from gen_art.particles.rows import CHARGE, MASS, PX

__all__ = ["LEDGER_COLUMNS", "make_ledger_kernel"]


@ti.func
def _add_kick_entries(
    terms: ti.template(), B: ti.template(), b, L: ti.template(), X: ti.template(), O: ti.template(),
    S: ti.template(), K: ti.template(), A: ti.template(), Q: ti.template(), i, n, tau, fraction, kicked: ti.template(),
    C: ti.template(), light,
):  # fmt: skip
    """Record a kick (kicked: from the velocities in O to those in X), or a Runge-Kutta stage (slopes at X)."""
    for j in range(WIDTH):
        if i + j < n and step_of(L, j) > 0.0:
            m = S[MASS, i + j]
            if ti.static(len(terms.mass_loss_terms) > 0):
                m = L.m[j]
            h = fraction * step_of(L, j)
            x = place(terms, X, Q, j)
            new = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            old = ti.Vector([O.v0[j], O.v1[j], O.v2[j]])
            mean = new
            if ti.static(kicked):
                mean = 0.5 * (old + new)
            p = stage_view(terms, S, K, L, i, j, x, old, age_of(L, j) + tau * step_of(L, j))
            t = time_of(L, j) + tau * step_of(L, j)
            rest = m * (new - old)  # what the terms below do not account for is due to drag
            if ti.static(terms.relativistic):
                g0, g1 = gamma_at(old, light), gamma_at(new, light)
                mean = (old * g0 + new * g1) / (g0 + g1)
                rest = m * (new * g1 - old * g0)
            for k in ti.static(range(terms.pairs)):
                a = ti.Vector([A[3 * k, i + j], A[3 * k + 1, i + j], A[3 * k + 2, i + j]])
                impulse = a * (m * h)
                rest -= impulse
                add_entry(B, b, i + j, terms.count + k, impulse.dot(mean), 0.0, impulse)
                if ti.static(len(terms.kinds) > 0 and terms.mutual[k]):
                    C.c0[j], C.c1[j], C.c2[j] = C.c0[j] + a[0] * h, C.c1[j] + a[1] * h, C.c2[j] + a[2] * h
            for term in ti.static(terms.accelerations):
                age = age_of(L, j) + tau * step_of(L, j)
                seen = stage_view(terms, S, K, L, i, j, x, old, age, flow_velocity(terms, L, term.medium, j))
                for repeat in range(repeats(Q, term.count_offset)):
                    a = term_acceleration(term.force, seen, t, parameters(Q, term.force, term.offset, repeat))
                    impulse = a * (m * h)
                    rest -= impulse
                    add_entry(B, b, i + j, term.ledger_row, impulse.dot(mean), 0.0, impulse)
                    if ti.static(len(terms.kinds) > 0 and term.force.conservative):
                        C.c0[j], C.c1[j], C.c2[j] = C.c0[j] + a[0] * h, C.c1[j] + a[1] * h, C.c2[j] + a[2] * h
            if ti.static(len(terms.noises) > 0 and kicked):
                impulse = ti.Vector([L.n0[j], L.n1[j], L.n2[j]]) * m
                rest -= impulse
                add_entry(B, b, i + j, terms.noises[0].ledger_row, impulse.dot(mean), 0.0, impulse)
            for term in ti.static(terms.magnetics):
                for repeat in range(repeats(Q, term.count_offset)):
                    field = term.force.magnetic(p, t, parameters(Q, term.force, term.offset, repeat))
                    impulse = mean.cross(field) * (S[CHARGE, i + j] * h)
                    rest -= impulse
                    add_entry(B, b, i + j, term.ledger_row, 0.0, 0.0, impulse)
            if ti.static(terms.magnetic_without_damping and kicked):
                # the pusher's rotation differs from the sum over the fields
                add_entry(B, b, i + j, terms.magnetics[0].ledger_row, 0.0, 0.0, rest)
            if ti.static(len(terms.dampings) > 0):
                rates = damping_rates(terms, L, x, old, S, K, Q, i, j, tau)
                total = h * 0.0
                drive = ti.Vector([0.0, 0.0, 0.0])
                for d, term in ti.static(enumerate(terms.dampings)):
                    u = flow_velocity(terms, L, term.medium, j)
                    k = damping_rate(terms, L, d, j, rates, mean)
                    total += k
                    drive += k * u
                drag_velocity = mean  # the mean velocity that the drag has acted at
                if ti.static(kicked):
                    if total * h != 0.0:  # h may be below 0 within a step
                        drag_velocity = (drive - rest / (m * h)) / total
                for d, term in ti.static(enumerate(terms.dampings)):
                    u = flow_velocity(terms, L, term.medium, j)
                    k = damping_rate(terms, L, d, j, rates, mean)
                    impulse = (u - drag_velocity) * (k * m * h)
                    work = impulse.dot(u)
                    add_entry(B, b, i + j, term.ledger_row, work, work - impulse.dot(mean), impulse)


@ti.func
def drift_with_exhaust(
    terms: ti.template(), B: ti.template(), b, L: ti.template(), X: ti.template(),
    S: ti.template(), K: ti.template(), Q: ti.template(), i, n, tau, fraction,
):  # fmt: skip
    """A drift. Half of the mass lost during it leaves before it, and half after it."""
    if ti.static(len(terms.mass_loss_terms) > 0):
        add_exhaust_entries(terms, B, b, L, X, S, K, Q, i, n, tau, 0.5 * fraction)
    drift(L, X, fraction)
    if ti.static(len(terms.mass_loss_terms) > 0):
        add_exhaust_entries(terms, B, b, L, X, S, K, Q, i, n, tau + fraction, 0.5 * fraction)


@ti.func
def _add_boundary_entries(
    terms: ti.template(), B: ti.template(), b, L: ti.template(), X: ti.template(),
    S: ti.template(), K: ti.template(), Q: ti.template(), i, n,
):  # fmt: skip
    """Record by how much the potentials change where the end X of the step is wrapped: the work of the sides of the box."""
    for j in range(WIDTH):
        if i + j < n and step_of(L, j) > 0.0:
            x, inside = ti.Vector([X.x0[j], X.x1[j], X.x2[j]]), place(terms, X, Q, j)
            if (inside - x).norm() > 0.0:
                v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
                m, age, t = S[MASS, i + j], age_of(L, j) + step_of(L, j), time_of(L, j) + step_of(L, j)
                if ti.static(len(terms.mass_loss_terms) > 0):
                    m -= step_of(L, j) * L.w[j]
                before = view(terms, S, K, i + j, x, v, age, None, m, (age_of(L, j), step_of(L, j)))
                after = view(terms, S, K, i + j, inside, v, age, None, m, (age_of(L, j), step_of(L, j)))
                gain = m * 0.0
                for term in ti.static(terms.potentials):
                    for repeat in range(repeats(Q, term.count_offset)):
                        q = parameters(Q, term.force, term.offset, repeat)
                        gain += term.force.potential(after, t, q) - term.force.potential(before, t, q)
                add_entry(B, b, i + j, terms.boundary_row, gain, 0.0, x * 0.0)


@cache
def make_ledger_kernel(
    composition: KernelTerms, kind: str, rotation: tuple, mutual: tuple, staged: bool, channels: tuple, precision: str,
    shares: tuple = (),
):  # fmt: skip
    """The ledger kernel of one system: as make_step's kernel, for one step, with three more arrays at the end.

    mutual : for each array of pair accelerations, whether it is conservative
    shares : what is booked of each row for each particle, see LedgerArrays
    T (blocks, rows x LEDGER_COLUMNS) f64 : the entries
    M (3, capacity) : with colliders, the change of velocity by conservative forces in the stages so far
    W (entries, capacity) f64 : the booked joules of each particle
    """
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)
    terms = TileTerms(composition, channels, len(mutual), real, rotation)
    terms.mutual = mutual
    splitting = kind == "splitting"

    @ti.kernel
    def ledger_kernel(
        S: matrix, birth: ti.types.ndarray(ti.f64, 1), K: ti.types.ndarray(ti.u32, 2), A: matrix, R: matrix, Q: vector,
        P: vector, begin: ti.i32, n: ti.i32, first: ti.f64, dt: ti.f64, earliest: ti.f64, stage0: ti.i32, stage1: ti.i32,
        at: ti.i64, at_birth: ti.i64, at_scratch: ti.i64,
        T: ti.types.ndarray(ti.f64, 2), M: matrix, W: ti.types.ndarray(ti.f64, 2),
    ):  # fmt: skip
        B = ledger_arrays(T, W, shares)
        ti.loop_config(block_dim=1)
        for b in range((n - begin + BLOCK - 1) // BLOCK):
            F = tile("gain")  # of each stage
            if ti.static(splitting):
                stage_gains(terms, F, Q, P, ti.cast(dt, real))
            for s in range(BLOCK // WIDTH):
                i = begin + b * BLOCK + s * WIDTH
                if i < n:
                    X = tile(STATE)
                    Y = tile(STATE)
                    Z = tile(STATE)
                    G = tile(terms.start_vectors)
                    C = tile("c0 c1 c2")
                    L = lanes(terms)
                    load(X, L, S, at, i, PX)
                    if ti.static(not splitting):
                        load(Y, L, S, at, i, PX)
                    if ti.static(len(terms.kinds) > 0):
                        if stage0 <= 0:
                            for j in range(WIDTH):
                                M[0, i + j], M[1, i + j], M[2, i + j] = 0.0, 0.0, 0.0
                        for j in range(WIDTH):
                            C.c0[j], C.c1[j], C.c2[j] = M[0, i + j], M[1, i + j], M[2, i + j]
                    lane_steps(terms, L, S, at, birth, at_birth, i, first * dt, dt, earliest, real)
                    if ti.static(len(terms.mass_loss_terms) > 0):
                        compute_mass_loss(terms, L, X, S, K, Q, i)
                    if ti.static(splitting):
                        if ti.static(len(terms.kinds) > 0):
                            copy(G, X)
                            if ti.static(staged):
                                if stage0 > 0 or (stage0 == 0 and P[FIRST_DRIFT] != 0.0):
                                    load(G, L, R, at_scratch, i, 0)
                        if stage0 < 0:
                            drift_with_exhaust(terms, B, b, L, X, S, K, Q, i, n, 0.0, P[FIRST_DRIFT])
                        for g in range(ti.max(stage0, 0), stage1):
                            for j in range(WIDTH):
                                Y.v0[j], Y.v1[j], Y.v2[j] = X.v0[j], X.v1[j], X.v2[j]
                            time, length, light = P[TIME + STAGE * g], P[KICK + STAGE * g], P[P.shape[0] - 1]
                            accumulate(terms, L, X, S, K, A, Q, i, time)
                            find_gains(terms, L, F, Q, g, length)
                            kick(terms, L, X, S, K, Q, i, length, light, first, time)
                            _add_kick_entries(terms, B, b, L, X, Y, S, K, A, Q, i, n, time, length, True, C, light)
                            drift_with_exhaust(terms, B, b, L, X, S, K, Q, i, n, time, P[DRIFT + STAGE * g])
                    else:
                        if stage0 > 0:
                            load(Y, L, R, at_scratch, i, 0)
                            load(Z, L, R, at_scratch, i, 6)
                        for g in range(ti.max(stage0, 0), stage1):
                            time, weight = P[TIME + STAGE * g], P[WEIGHT + STAGE * g]
                            accumulate(terms, L, Y, S, K, A, Q, i, time)
                            _add_kick_entries(terms, B, b, L, Y, Y, S, K, A, Q, i, n, time, weight, False, C, 0.0)
                            if ti.static(len(terms.mass_loss_terms) > 0):
                                add_exhaust_entries(terms, B, b, L, Y, S, K, Q, i, n, time, weight)
                            advance_stage(terms, L, X, Y, Z, S, K, Q, i, time, weight, P[AHEAD + STAGE * g])
                    if ti.static(len(terms.kinds) > 0):
                        for j in range(WIDTH):
                            M[0, i + j], M[1, i + j], M[2, i + j] = C.c0[j], C.c1[j], C.c2[j]
                    if ti.static(len(terms.kinds) > 0 or terms.boundary_row >= 0):
                        if stage1 == (P.shape[0] - 1) // STAGE:
                            if ti.static(not splitting):
                                if ti.static(len(terms.kinds) > 0):
                                    copy(G, X)
                                for j in range(WIDTH):
                                    X.x0[j], X.x1[j], X.x2[j] = X.x0[j] + Z.x0[j], X.x1[j] + Z.x1[j], X.x2[j] + Z.x2[j]
                                    X.v0[j], X.v1[j], X.v2[j] = X.v0[j] + Z.v0[j], X.v1[j] + Z.v1[j], X.v2[j] + Z.v2[j]
                            if ti.static(len(terms.kinds) > 0):
                                resolve_collisions(terms, L, G, X, S, Q, i, n, B, b, C, True)
                            if ti.static(terms.boundary_row >= 0):
                                _add_boundary_entries(terms, B, b, L, X, S, K, Q, i, n)

    return runtime.kernel(ledger_kernel, precision)
