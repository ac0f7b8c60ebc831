"""The fused kernels: forces, integrator, ageing and colliders in one pass over the state, generated from a composition.

The particles are taken in blocks (one task each) of tiles of WIDTH lanes. A tile's state lives in local vectors while
several steps run. Births and deaths inside a step need no branches: a lane's own step is the part of it that it is alive.
With interactions one launch runs one stage, around the pair kernel, which leaves its accelerations in A.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.integrators.collisions import resolve_collisions
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.mass_loss import apply_mass_loss, find_mass_loss
from gen_art.integrators.tile import (
    WIDTH,
    TileTerms,
    accumulate,
    copy,
    kick,
    lifespan,
    load,
    specific_charge,
    store,
    tile,
)

__all__ = ["BLOCK", "advance_stage", "drift", "make_step", "load_stage"]

BLOCK = 1024


@cache
def make_step(
    composition: KernelTerms, kind: str, rotates: tuple, pairs: int, staged: bool, channels: tuple, precision: str
):
    """The step kernel of one system; `channels` names the declared attributes. Numbers are never in the key.

    step(S, birth, K, A, R, Q, P, begin, n, first, steps, dt, earliest, stage0, stage1)

    S (channels, capacity); birth (capacity,) f64; K keys (2, capacity) u32; A (3 pairs, capacity) pair accelerations;
    R (12, capacity) stage states of Runge-Kutta with pairs, or, with colliders, the state at the start of the step; Q parameters;
    P the scheme's numbers; slots begin to n - 1;
    `steps` steps of dt, the first being number `first`; `earliest` bounds the start of a lane's own step relative to the
    step's (0, or -inf for children that are behind); stages stage0 to stage1 - 1 of each step, and from -1 the first drift too.
    `staged`: launches may hold a part of the stages; Runge-Kutta then keeps its stage states in R.
    """
    real = runtime.DTYPES[precision]
    terms = TileTerms(composition, channels, pairs, rotates, real)
    if kind == "splitting":
        return runtime.kernel(_splitting(terms, staged, real), precision)
    return runtime.kernel(_runge_kutta(terms, staged, real), precision)


@ti.func
def drift(L: ti.template(), X: ti.template(), fraction):
    for j in range(WIDTH):
        h = fraction * L.h[j]
        X.x0[j] += h * X.v0[j]
        X.x1[j] += h * X.v1[j]
        X.x2[j] += h * X.v2[j]


def _splitting(terms: TileTerms, resumes: bool, real):
    matrix = ti.types.ndarray(real, 2)
    vector = ti.types.ndarray(real, 1)
    names = terms.vectors

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
    ):
        ti.loop_config(block_dim=1)
        for b in range((n - begin + BLOCK - 1) // BLOCK):
            for s in range(BLOCK // WIDTH):
                i = begin + b * BLOCK + s * WIDTH
                if i < n:
                    X = tile("x0 x1 x2 v0 v1 v2")
                    G = tile(terms.start)  # the state at the start of the step, where there are colliders
                    L = tile(names)
                    load(X, S, i)
                    # nothing moves between a step's last kick and the next one's first
                    still = P[0] == 0.0 and P[P.shape[0] - 2] == 0.0
                    for step in range(steps):
                        lifespan(L, S, birth, i, (first + ti.cast(step, ti.f64)) * dt, dt, earliest, real)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            find_mass_loss(terms, L, X, S, K, Q, i)
                        if ti.static(len(terms.walls) > 0):
                            begin_step(resumes, G, X, R, P, i, stage0)
                        if stage0 < 0:
                            drift(L, X, P[0])
                        for g in range(ti.max(stage0, 0), stage1):
                            if P[1 + 3 * g] != 0.0:  # else the drift after an interaction's own change of velocities
                                if ti.static(terms.kept):
                                    if step == 0 or g > 0 or not still:
                                        accumulate(terms, L, X, S, K, A, Q, i, P[2 + 3 * g])
                                else:
                                    accumulate(terms, L, X, S, K, A, Q, i, P[2 + 3 * g])
                                kick(terms, L, X, S, i, P[1 + 3 * g], P[P.shape[0] - 1])
                            drift(L, X, P[3 + 3 * g])
                        if ti.static(len(terms.walls) > 0):
                            if stage1 == (P.shape[0] - 1) // 3:
                                resolve_collisions(terms, L, G, X, S, Q, i, n, 0, 0, 0, False)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            if stage1 == (P.shape[0] - 1) // 3:
                                apply_mass_loss(L, S, i, n)
                    store(X, S, i)

    return splitting


@ti.func
def begin_step(
    resumes: ti.template(), G: ti.template(), X: ti.template(), R: ti.template(), P: ti.template(), i, stage0
):
    """Take the state at the start of the step into G: X at its first launch, which keeps it in R for the others."""
    if ti.static(resumes):
        if stage0 < 0 or (stage0 == 0 and P[0] == 0.0):
            store(X, R, i)
        load(G, R, i)
    else:
        copy(G, X)


def _runge_kutta(terms: TileTerms, resumes: bool, real):
    matrix = ti.types.ndarray(real, 2)
    vector = ti.types.ndarray(real, 1)
    names = terms.vectors

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
    ):
        ti.loop_config(block_dim=1)
        for b in range((n - begin + BLOCK - 1) // BLOCK):
            for s in range(BLOCK // WIDTH):
                i = begin + b * BLOCK + s * WIDTH
                if i < n:
                    X = tile("x0 x1 x2 v0 v1 v2")  # the state at the start of the step
                    Y = tile("x0 x1 x2 v0 v1 v2")  # the state of this stage
                    Z = tile("x0 x1 x2 v0 v1 v2")  # the weighted sum of the stages' increments
                    L = tile(names)
                    load(X, S, i)
                    for step in range(steps):
                        lifespan(L, S, birth, i, (first + ti.cast(step, ti.f64)) * dt, dt, earliest, real)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            find_mass_loss(terms, L, X, S, K, Q, i)
                        for j in range(WIDTH):
                            Y.x0[j], Y.x1[j], Y.x2[j] = X.x0[j], X.x1[j], X.x2[j]
                            Y.v0[j], Y.v1[j], Y.v2[j] = X.v0[j], X.v1[j], X.v2[j]
                            Z.x0[j], Z.x1[j], Z.x2[j], Z.v0[j], Z.v1[j], Z.v2[j] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                        if ti.static(resumes):
                            if stage0 > 0:
                                load_stage(Y, Z, R, i)
                        for g in range(ti.max(stage0, 0), stage1):
                            accumulate(terms, L, Y, S, K, A, Q, i, P[2 + 3 * g])
                            advance_stage(terms, L, X, Y, Z, S, i, P[1 + 3 * g], P[3 + 3 * g])
                        if ti.static(resumes):
                            save_stage(Y, Z, R, i)
                        if stage1 == (P.shape[0] - 1) // 3:
                            if ti.static(len(terms.walls) > 0):
                                copy(Y, X)
                            for j in range(WIDTH):
                                X.x0[j] += Z.x0[j]
                                X.x1[j] += Z.x1[j]
                                X.x2[j] += Z.x2[j]
                                X.v0[j] += Z.v0[j]
                                X.v1[j] += Z.v1[j]
                                X.v2[j] += Z.v2[j]
                            if ti.static(len(terms.walls) > 0):
                                resolve_collisions(terms, L, Y, X, S, Q, i, n, 0, 0, 0, False)
                        if ti.static(len(terms.mass_loss_terms) > 0):
                            if stage1 == (P.shape[0] - 1) // 3:
                                apply_mass_loss(L, S, i, n)
                    store(X, S, i)

    return runge_kutta


@ti.func
def advance_stage(
    terms: ti.template(),
    L: ti.template(),
    X: ti.template(),
    Y: ti.template(),
    Z: ti.template(),
    S: ti.template(),
    i,
    weight,
    ahead,
):
    """Add this stage's increments to Z and move Y to the next stage's state; drag and rotation are part of the slope."""
    for j in range(WIDTH):
        v = ti.Vector([Y.v0[j], Y.v1[j], Y.v2[j]])
        a = ti.Vector([L.a0[j], L.a1[j], L.a2[j]])
        for d in ti.static(range(len(terms.dampings))):
            m = ti.static(terms.dampings[d][2])
            w = v - ti.Vector([L.at("u", m, 0)[j], L.at("u", m, 1)[j], L.at("u", m, 2)[j]])
            a -= (L.at("k", d)[j] + L.at("q", d)[j] * w.norm()) * w
        if ti.static(len(terms.magnetics) > 0):
            a += v.cross(ti.Vector([L.b0[j], L.b1[j], L.b2[j]])) * specific_charge(terms, L, S, i, j)
        h = L.h[j]
        Z.x0[j] += weight * h * v[0]
        Z.x1[j] += weight * h * v[1]
        Z.x2[j] += weight * h * v[2]
        Z.v0[j] += weight * h * a[0]
        Z.v1[j] += weight * h * a[1]
        Z.v2[j] += weight * h * a[2]
        Y.x0[j], Y.x1[j], Y.x2[j] = X.x0[j] + ahead * h * v[0], X.x1[j] + ahead * h * v[1], X.x2[j] + ahead * h * v[2]
        Y.v0[j], Y.v1[j], Y.v2[j] = X.v0[j] + ahead * h * a[0], X.v1[j] + ahead * h * a[1], X.v2[j] + ahead * h * a[2]


@ti.func
def load_stage(Y: ti.template(), Z: ti.template(), R: ti.template(), i):
    for j in range(WIDTH):
        Y.x0[j], Y.x1[j], Y.x2[j], Y.v0[j], Y.v1[j], Y.v2[j] = (
            R[0, i + j],
            R[1, i + j],
            R[2, i + j],
            R[3, i + j],
            R[4, i + j],
            R[5, i + j],
        )
        Z.x0[j], Z.x1[j], Z.x2[j], Z.v0[j], Z.v1[j], Z.v2[j] = (
            R[6, i + j],
            R[7, i + j],
            R[8, i + j],
            R[9, i + j],
            R[10, i + j],
            R[11, i + j],
        )


@ti.func
def save_stage(Y: ti.template(), Z: ti.template(), R: ti.template(), i):
    for j in range(WIDTH):
        R[0, i + j], R[1, i + j], R[2, i + j], R[3, i + j], R[4, i + j], R[5, i + j] = (
            Y.x0[j],
            Y.x1[j],
            Y.x2[j],
            Y.v0[j],
            Y.v1[j],
            Y.v2[j],
        )
        R[6, i + j], R[7, i + j], R[8, i + j], R[9, i + j], R[10, i + j], R[11, i + j] = (
            Z.x0[j],
            Z.x1[j],
            Z.x2[j],
            Z.v0[j],
            Z.v1[j],
            Z.v2[j],
        )
