"""The booking kernel: what each force does to the particles in a step, for the ledger.

It repeats the step of kernels.py on local copies, with the same functions and so the same bits, and stores no state: work
m a.(v0 + v1)/2 h of each push (stage weights in Runge-Kutta), what drag takes and what its medium gives, all impulses.
With a speed of light the momentum is m u, u = gamma v, and a push works at (u0 + u1) / (gamma0 + gamma1): the change of
(gamma - 1) m c^2 is exactly m (u1 - u0) times it.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.forces.base import term_acceleration
from gen_art.integrators.collisions import resolve_collisions
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.ledger_rows import LEDGER_COLUMNS, add_entry
from gen_art.integrators.mass_loss import add_exhaust_entries, find_mass_loss
from gen_art.integrators.pushers import gamma_at
from gen_art.integrators.step_kernels import BLOCK, advance_stage, drift, load_stage
from gen_art.integrators.tile import (
    WIDTH,
    TileTerms,
    accumulate,
    copy,
    flow,
    kick,
    lifespan,
    load,
    repeats,
    step_of,
    tile,
    view,
    weight,
)
from gen_art.particles.rows import CHARGE, MASS

__all__ = ["LEDGER_COLUMNS", "make_ledger_kernel"]


@ti.func
def _add_kick_entries(
    terms: ti.template(), B: ti.template(), b, L: ti.template(), X: ti.template(), O: ti.template(),
    S: ti.template(), K: ti.template(), A: ti.template(), Q: ti.template(), i, n, tau, fraction, kicked: ti.template(),
    C: ti.template(), light,
):  # fmt: skip
    """Book a kick (kicked: old velocities in O, new in X) or a Runge-Kutta stage (slopes at X) over a fraction of the step."""
    for j in range(WIDTH):
        if i + j < n and L.h[j] > 0.0:
            m = S[MASS, i + j]
            if ti.static(len(terms.mass_loss_terms) > 0):
                m = L.m[j]
            h = fraction * L.h[j]
            x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
            new = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            old = ti.Vector([O.v0[j], O.v1[j], O.v2[j]])
            mean = new
            if ti.static(kicked):
                mean = 0.5 * (old + new)
            p = view(
                terms, S, K, i + j, x, old, L.age[j] + tau * L.h[j], None, weight(terms, L, j), step_of(terms, L, j)
            )
            t = L.t[j] + tau * L.h[j]
            rest = m * (new - old)  # what the kick changed, less what the pushes account for, is the drag's
            if ti.static(terms.relativistic):
                g0, g1 = gamma_at(old, light), gamma_at(new, light)
                mean = (old * g0 + new * g1) / (g0 + g1)
                rest = m * (new * g1 - old * g0)
            for k in ti.static(range(terms.pairs)):
                a = ti.Vector([A[3 * k, i + j], A[3 * k + 1, i + j], A[3 * k + 2, i + j]])
                impulse = a * (m * h)
                rest -= impulse
                add_entry(B, b, terms.count + k, impulse.dot(mean), 0.0, impulse)
                if ti.static(len(terms.walls) > 0 and terms.mutual[k]):
                    C.c0[j], C.c1[j], C.c2[j] = C.c0[j] + a[0] * h, C.c1[j] + a[1] * h, C.c2[j] + a[2] * h
            for force, offset, count, row, medium in ti.static(terms.pushes):
                seen = view(
                    terms, S, K, i + j, x, old, L.age[j] + tau * L.h[j], flow(L, medium, j),
                    weight(terms, L, j), step_of(terms, L, j),
                )  # fmt: skip
                for repeat in range(repeats(Q, count)):
                    a = term_acceleration(force, seen, t, parameters(Q, force, offset, repeat))
                    impulse = a * (m * h)
                    rest -= impulse
                    add_entry(B, b, row, impulse.dot(mean), 0.0, impulse)
                    if ti.static(len(terms.walls) > 0 and force.conservative):
                        C.c0[j], C.c1[j], C.c2[j] = C.c0[j] + a[0] * h, C.c1[j] + a[1] * h, C.c2[j] + a[2] * h
            for force, offset, count, row in ti.static(terms.magnetics):
                for repeat in range(repeats(Q, count)):
                    field = force.magnetic(p, t, parameters(Q, force, offset, repeat))
                    impulse = mean.cross(field) * (S[CHARGE, i + j] * h)
                    rest -= impulse
                    add_entry(B, b, row, 0.0, 0.0, impulse)
            if ti.static(terms.turns_alone and kicked):  # what the pusher turns otherwise than each field by itself
                add_entry(B, b, terms.magnetics[0][3], 0.0, 0.0, rest)
            if ti.static(len(terms.dampings) > 0):
                total = h * 0.0
                pull = ti.Vector([0.0, 0.0, 0.0])
                for d in ti.static(range(len(terms.dampings))):
                    u = medium_velocity(terms, L, d, j)
                    k = L.at("k", d)[j] + L.at("q", d)[j] * (mean - u).norm()
                    total += k
                    pull += k * u
                met = mean  # the mean velocity the drag has acted at
                if ti.static(kicked):
                    if total * h != 0.0:  # a part of a step may lead back
                        met = (pull - rest / (m * h)) / total
                for d in ti.static(range(len(terms.dampings))):
                    u = medium_velocity(terms, L, d, j)
                    k = L.at("k", d)[j] + L.at("q", d)[j] * (mean - u).norm()
                    impulse = (u - met) * (k * m * h)
                    work = impulse.dot(u)
                    add_entry(B, b, ti.static(terms.dampings[d][3]), work, work - impulse.dot(mean), impulse)


@ti.func
def drift_with_exhaust(
    terms: ti.template(), B: ti.template(), b, L: ti.template(), X: ti.template(),
    S: ti.template(), K: ti.template(), Q: ti.template(), i, n, tau, fraction,
):  # fmt: skip
    """A drift; what burns meanwhile leaves in halves, before and after it."""
    if ti.static(len(terms.mass_loss_terms) > 0):
        add_exhaust_entries(terms, B, b, L, X, S, K, Q, i, n, tau, 0.5 * fraction)
    drift(L, X, fraction)
    if ti.static(len(terms.mass_loss_terms) > 0):
        add_exhaust_entries(terms, B, b, L, X, S, K, Q, i, n, tau + fraction, 0.5 * fraction)


@ti.func
def medium_velocity(terms: ti.template(), L: ti.template(), d: ti.template(), j):
    m = ti.static(terms.dampings[d][2])
    return ti.Vector([L.at("u", m, 0)[j], L.at("u", m, 1)[j], L.at("u", m, 2)[j]])


@cache
def make_ledger_kernel(
    composition: KernelTerms, kind: str, rotates: tuple, mutual: tuple, staged: bool, channels: tuple, precision: str
):
    """The booking kernel of one system: as make_step's kernel, for one step, with B (blocks, rows x 5) f64 at the end.

    `mutual` says of each array of pair accelerations whether it is conservative. M (3, capacity) keeps, for colliders, the
    change of velocity that conservative forces made in the stages so far.
    """
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)
    terms = TileTerms(composition, channels, len(mutual), rotates, real)
    terms.mutual = mutual
    names = terms.vectors
    splitting = kind == "splitting"

    @ti.kernel
    def ledger_kernel(
        S: matrix, birth: ti.types.ndarray(ti.f64, 1), K: ti.types.ndarray(ti.u32, 2), A: matrix, R: matrix, Q: vector,
        P: vector, begin: ti.i32, n: ti.i32, first: ti.f64, dt: ti.f64, earliest: ti.f64, stage0: ti.i32, stage1: ti.i32,
        B: ti.types.ndarray(ti.f64, 2), M: matrix,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range((n - begin + BLOCK - 1) // BLOCK):
            for s in range(BLOCK // WIDTH):
                i = begin + b * BLOCK + s * WIDTH
                if i < n:
                    X = tile("x0 x1 x2 v0 v1 v2")
                    Y = tile("x0 x1 x2 v0 v1 v2")
                    Z = tile("x0 x1 x2 v0 v1 v2")
                    G = tile(terms.start)
                    C = tile("c0 c1 c2")
                    L = tile(names)
                    load(X, S, i)
                    load(Y, S, i)
                    if ti.static(len(terms.walls) > 0):
                        if stage0 <= 0:
                            for j in range(WIDTH):
                                M[0, i + j], M[1, i + j], M[2, i + j] = 0.0, 0.0, 0.0
                        for j in range(WIDTH):
                            C.c0[j], C.c1[j], C.c2[j] = M[0, i + j], M[1, i + j], M[2, i + j]
                    lifespan(L, S, birth, i, first * dt, dt, earliest, real)
                    if ti.static(len(terms.mass_loss_terms) > 0):
                        find_mass_loss(terms, L, X, S, K, Q, i)
                    if ti.static(splitting):
                        if ti.static(len(terms.walls) > 0):
                            copy(G, X)
                            if ti.static(staged):
                                if stage0 > 0 or (stage0 == 0 and P[0] != 0.0):
                                    load(G, R, i)
                        if stage0 < 0:
                            drift_with_exhaust(terms, B, b, L, X, S, K, Q, i, n, 0.0, P[0])
                        for g in range(ti.max(stage0, 0), stage1):
                            for j in range(WIDTH):
                                Y.v0[j], Y.v1[j], Y.v2[j] = X.v0[j], X.v1[j], X.v2[j]
                            accumulate(terms, L, X, S, K, A, Q, i, P[2 + 3 * g])
                            kick(terms, L, X, S, i, P[1 + 3 * g], P[P.shape[0] - 1])
                            _add_kick_entries(
                                terms,
                                B,
                                b,
                                L,
                                X,
                                Y,
                                S,
                                K,
                                A,
                                Q,
                                i,
                                n,
                                P[2 + 3 * g],
                                P[1 + 3 * g],
                                True,
                                C,
                                P[P.shape[0] - 1],
                            )
                            drift_with_exhaust(terms, B, b, L, X, S, K, Q, i, n, P[2 + 3 * g], P[3 + 3 * g])
                    else:
                        if stage0 > 0:
                            load_stage(Y, Z, R, i)
                        for g in range(ti.max(stage0, 0), stage1):
                            accumulate(terms, L, Y, S, K, A, Q, i, P[2 + 3 * g])
                            _add_kick_entries(
                                terms, B, b, L, Y, Y, S, K, A, Q, i, n, P[2 + 3 * g], P[1 + 3 * g], False, C, 0.0
                            )
                            if ti.static(len(terms.mass_loss_terms) > 0):
                                add_exhaust_entries(terms, B, b, L, Y, S, K, Q, i, n, P[2 + 3 * g], P[1 + 3 * g])
                            advance_stage(terms, L, X, Y, Z, S, i, P[1 + 3 * g], P[3 + 3 * g])
                    if ti.static(len(terms.walls) > 0):
                        for j in range(WIDTH):
                            M[0, i + j], M[1, i + j], M[2, i + j] = C.c0[j], C.c1[j], C.c2[j]
                        if stage1 == (P.shape[0] - 1) // 3:
                            if ti.static(not splitting):
                                copy(G, X)
                                for j in range(WIDTH):
                                    X.x0[j], X.x1[j], X.x2[j] = X.x0[j] + Z.x0[j], X.x1[j] + Z.x1[j], X.x2[j] + Z.x2[j]
                                    X.v0[j], X.v1[j], X.v2[j] = X.v0[j] + Z.v0[j], X.v1[j] + Z.v1[j], X.v2[j] + Z.v2[j]
                            resolve_collisions(terms, L, G, X, S, Q, i, n, B, b, C, True)

    return runtime.kernel(ledger_kernel, precision)
