"""The fused step kernels: forces, integrator, ageing and colliders in one pass over the state, generated for a composition.

The particles are processed in blocks (one task each) of tiles of WIDTH lanes. A tile's state stays in local vectors while
several steps run. Births and deaths inside a step need no branches: a lane's own step is the part of it that it is alive.
With interactions, one launch runs one stage, after the pair kernel has written its accelerations to A.
In a periodic box positions are wrapped at the end of each step; within it a path goes on beyond the sides, so that colliders
find its impacts.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.integrators.collisions import resolve_collisions
from gen_art.integrators.damping import damping_rate, damping_rates, find_gains, stage_gains
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.kick import kick
from gen_art.integrators.lanes import STATE, WIDTH, copy, lanes, load, step_of, store, tile
from gen_art.integrators.mass_loss import apply_mass_loss, compute_mass_loss
from gen_art.integrators.particle_tile import (
    TileTerms,
    accumulate,
    flow_velocity,
    lane_steps,
    place,
    specific_charge,
    wrap,
)
from gen_art.integrators.schemes import AHEAD, DRIFT, FIRST_DRIFT, KICK, STAGE, TIME, WEIGHT
from gen_art.particles.rows import PX

__all__ = ["BLOCK", "advance_stage", "drift", "make_step"]

BLOCK = 1024


@cache
def make_step(
    composition: KernelTerms, kind: str, rotation: tuple, pairs: int, staged: bool, channels: tuple, precision: str,
    lifespans: bool,
):  # fmt: skip
    """The step kernel of one system. Numbers are never part of the cache key.

    kind : "splitting" or "runge_kutta"
    rotation : the scheme's `rotation`
    pairs : number of arrays of pair accelerations
    staged : whether a launch may run only some of the stages; Runge-Kutta then keeps its stage states in R
    channels : names of the declared attributes
    lifespans : whether particles may be born or die within a step, or are fixed

    step(S, birth, K, A, R, Q, P, begin, n, first, steps, dt, earliest, stage0, stage1, at, at_birth, at_scratch)
    S (channels, capacity), the state
    birth (capacity,) f64, s
    K (2, capacity) u32, keys
    A (3 pairs, capacity), pair accelerations
    R (12, capacity), stage states of Runge-Kutta with pairs; or, with colliders, the state at the start of the step
    Q, parameters; P, the scheme's numbers
    begin, n : slots begin to n - 1
    first, steps, dt : `steps` steps of dt, s, the first being number `first`
    earliest : lower bound of the start of a lane's own step relative to the step's, s: 0, or -inf for children born earlier
    stage0, stage1 : stages stage0 to stage1 - 1 of each step; from -1 the first drift too
    at, at_birth, at_scratch : the addresses of S, birth and R
    """
    real = runtime.DTYPES[precision]
    terms = TileTerms(composition, channels, pairs, real, rotation, lifespans)
    if kind == "splitting":
        return runtime.kernel(_splitting(terms, staged, real), precision)
    return runtime.kernel(_runge_kutta(terms, staged, real), precision)


@ti.func
def drift(L: ti.template(), X: ti.template(), fraction):
    for j in range(WIDTH):
        h = fraction * step_of(L, j)
        X.x0[j] += h * X.v0[j]
        X.x1[j] += h * X.v1[j]
        X.x2[j] += h * X.v2[j]


def _splitting(terms: TileTerms, staged: bool, real):
    matrix = ti.types.ndarray(real, 2)
    vector = ti.types.ndarray(real, 1)

    @ti.kernel
    def splitting(
        S: matrix,
        birth: ti.types.ndarray(ti.f64, 1),
        K: ti.types.ndarray(ti.u32, 2),
        A: matrix,
        R: matrix,
        Q: vector,
        P: vector,
        begin: ti.i32,
        n: ti.i32,
        first: ti.f64,
        steps: ti.i32,
        dt: ti.f64,
        earliest: ti.f64,
        stage0: ti.i32,
        stage1: ti.i32,
        at: ti.i64,
        at_birth: ti.i64,
        at_scratch: ti.i64,
    ):
        ti.loop_config(block_dim=1)
        for b in range((n - begin + BLOCK - 1) // BLOCK):
            F = tile("gain")  # of each stage
            stage_gains(terms, F, Q, P, ti.cast(dt, real))
            for s in range(BLOCK // WIDTH):
                i = begin + b * BLOCK + s * WIDTH
                if i < n:
                    X = tile(STATE)
                    G = tile(terms.start_vectors)  # the state at the start of the step, where there are colliders
                    L = lanes(terms)
                    load(X, L, S, at, i, PX)
                    # no drift between a step's last kick and the next one's first
                    still = P[FIRST_DRIFT] == 0.0 and P[P.shape[0] - 2] == 0.0
                    for step in range(steps):
                        number = first + ti.cast(step, ti.f64)
                        lane_steps(terms, L, S, at, birth, at_birth, i, number * dt, dt, earliest, real)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            compute_mass_loss(terms, L, X, S, K, Q, i)
                        if ti.static(len(terms.kinds) > 0):
                            begin_step(staged, G, X, L, R, at_scratch, P, i, stage0)
                        if stage0 < 0:
                            drift(L, X, P[FIRST_DRIFT])
                        for g in range(ti.max(stage0, 0), stage1):
                            if P[KICK + STAGE * g] != 0.0:  # 0 for the drift after an implicit interaction
                                if ti.static(terms.reusable):
                                    if step == 0 or g > 0 or not still:
                                        accumulate(terms, L, X, S, K, A, Q, i, P[TIME + STAGE * g])
                                else:
                                    accumulate(terms, L, X, S, K, A, Q, i, P[TIME + STAGE * g])
                                find_gains(terms, L, F, Q, g, P[KICK + STAGE * g])
                                time, light = P[TIME + STAGE * g], P[P.shape[0] - 1]
                                kick(terms, L, X, S, K, Q, i, P[KICK + STAGE * g], light, number, time)
                            drift(L, X, P[DRIFT + STAGE * g])
                        if ti.static(len(terms.kinds) > 0):
                            if stage1 == (P.shape[0] - 1) // STAGE:
                                resolve_collisions(terms, L, G, X, S, Q, i, n, 0, 0, 0, False)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            if stage1 == (P.shape[0] - 1) // STAGE:
                                apply_mass_loss(L, S, i, n)
                        if ti.static(terms.box_offset >= 0):
                            if stage1 == (P.shape[0] - 1) // STAGE:
                                wrap(terms, X, Q)
                    store(X, S, at, i, PX)

    return splitting


@ti.func
def begin_step(
    staged: ti.template(), G: ti.template(), X: ti.template(), L: ti.template(), R: ti.template(), at_scratch,
    P: ti.template(), i, stage0,
):  # fmt: skip
    """Copy the state at the start of the step to G: X in the first launch of a step, which stores it in R for the others."""
    if ti.static(staged):
        if stage0 < 0 or (stage0 == 0 and P[FIRST_DRIFT] == 0.0):
            store(X, R, at_scratch, i, 0)
        load(G, L, R, at_scratch, i, 0)
    else:
        copy(G, X)


def _runge_kutta(terms: TileTerms, staged: bool, real):
    matrix = ti.types.ndarray(real, 2)
    vector = ti.types.ndarray(real, 1)

    @ti.kernel
    def runge_kutta(
        S: matrix,
        birth: ti.types.ndarray(ti.f64, 1),
        K: ti.types.ndarray(ti.u32, 2),
        A: matrix,
        R: matrix,
        Q: vector,
        P: vector,
        begin: ti.i32,
        n: ti.i32,
        first: ti.f64,
        steps: ti.i32,
        dt: ti.f64,
        earliest: ti.f64,
        stage0: ti.i32,
        stage1: ti.i32,
        at: ti.i64,
        at_birth: ti.i64,
        at_scratch: ti.i64,
    ):
        ti.loop_config(block_dim=1)
        for b in range((n - begin + BLOCK - 1) // BLOCK):
            for s in range(BLOCK // WIDTH):
                i = begin + b * BLOCK + s * WIDTH
                if i < n:
                    X = tile(STATE)  # the state at the start of the step
                    Y = tile(STATE)  # the state of this stage
                    Z = tile(STATE)  # the weighted sum of the stages' increments
                    L = lanes(terms)
                    load(X, L, S, at, i, PX)
                    for step in range(steps):
                        number = first + ti.cast(step, ti.f64)
                        lane_steps(terms, L, S, at, birth, at_birth, i, number * dt, dt, earliest, real)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            compute_mass_loss(terms, L, X, S, K, Q, i)
                        for j in range(WIDTH):
                            Y.x0[j], Y.x1[j], Y.x2[j] = X.x0[j], X.x1[j], X.x2[j]
                            Y.v0[j], Y.v1[j], Y.v2[j] = X.v0[j], X.v1[j], X.v2[j]
                            Z.x0[j], Z.x1[j], Z.x2[j], Z.v0[j], Z.v1[j], Z.v2[j] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                        if ti.static(staged):
                            if stage0 > 0:
                                load(Y, L, R, at_scratch, i, 0)
                                load(Z, L, R, at_scratch, i, 6)
                        for g in range(ti.max(stage0, 0), stage1):
                            accumulate(terms, L, Y, S, K, A, Q, i, P[TIME + STAGE * g])
                            time = P[TIME + STAGE * g]
                            advance_stage(
                                terms, L, X, Y, Z, S, K, Q, i, time, P[WEIGHT + STAGE * g], P[AHEAD + STAGE * g]
                            )
                        if ti.static(staged):
                            store(Y, R, at_scratch, i, 0)
                            store(Z, R, at_scratch, i, 6)
                        if stage1 == (P.shape[0] - 1) // STAGE:
                            if ti.static(len(terms.kinds) > 0):
                                copy(Y, X)
                            for j in range(WIDTH):
                                X.x0[j] += Z.x0[j]
                                X.x1[j] += Z.x1[j]
                                X.x2[j] += Z.x2[j]
                                X.v0[j] += Z.v0[j]
                                X.v1[j] += Z.v1[j]
                                X.v2[j] += Z.v2[j]
                            if ti.static(len(terms.kinds) > 0):
                                resolve_collisions(terms, L, Y, X, S, Q, i, n, 0, 0, 0, False)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            if stage1 == (P.shape[0] - 1) // STAGE:
                                apply_mass_loss(L, S, i, n)
                        if ti.static(terms.box_offset >= 0):
                            if stage1 == (P.shape[0] - 1) // STAGE:
                                wrap(terms, X, Q)
                    store(X, S, at, i, PX)

    return runge_kutta


@ti.func
def advance_stage(
    terms: ti.template(), L: ti.template(), X: ti.template(), Y: ti.template(), Z: ti.template(), S: ti.template(),
    K: ti.template(), Q: ti.template(), i, tau, weight, ahead,
):  # fmt: skip
    """Add this stage's increments to Z and set Y to the next stage's state; drag and magnetic force are part of the slope."""
    for j in range(WIDTH):
        v = ti.Vector([Y.v0[j], Y.v1[j], Y.v2[j]])
        a = ti.Vector([L.a0[j], L.a1[j], L.a2[j]])
        rates = damping_rates(terms, L, place(terms, Y, Q, j), v, S, K, Q, i, j, tau)
        for d, term in ti.static(enumerate(terms.dampings)):
            a -= damping_rate(terms, L, d, j, rates, v) * (v - flow_velocity(terms, L, term.medium, j))
        if ti.static(len(terms.magnetics) > 0):
            a += v.cross(ti.Vector([L.b0[j], L.b1[j], L.b2[j]])) * specific_charge(terms, L, S, i, j)
        h = step_of(L, j)
        Z.x0[j] += weight * h * v[0]
        Z.x1[j] += weight * h * v[1]
        Z.x2[j] += weight * h * v[2]
        Z.v0[j] += weight * h * a[0]
        Z.v1[j] += weight * h * a[1]
        Z.v2[j] += weight * h * a[2]
        Y.x0[j], Y.x1[j], Y.x2[j] = X.x0[j] + ahead * h * v[0], X.x1[j] + ahead * h * v[1], X.x2[j] + ahead * h * v[2]
        Y.v0[j], Y.v1[j], Y.v2[j] = X.v0[j] + ahead * h * a[0], X.v1[j] + ahead * h * a[1], X.v2[j] + ahead * h * a[2]
