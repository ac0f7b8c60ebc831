"""Dormand and Prince's Runge-Kutta pair of orders 5 and 4: its coefficients, its step size control, and the kernel of slopes.

The step continues with the fifth order; the difference of both orders is the error estimate. The seventh slope is the first
of the next step. Source: Dormand & Prince (1980), J. Comput. Appl. Math. 6, 19; Hairer, Norsett & Wanner, Solving Ordinary
Differential Equations I, sections II.4 (step size) and II.5 (the pair).

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.lanes import STATE, WIDTH, lanes, load, store, tile
from gen_art.integrators.mass_loss import apply_mass_loss, compute_mass_loss
from gen_art.integrators.particle_tile import TileTerms, accumulate, lane_steps
from gen_art.integrators.step_kernels import BLOCK, advance_stage
from gen_art.particles.rows import PX

__all__ = ["ERROR", "STAGES", "TIMES", "first_step", "make_slopes", "next_step"]

TIMES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
STAGES = (  # weights of the slopes so far in each stage's state; the last row is the step itself
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)  # fifth order minus fourth

_SAFETY, _MIN_FACTOR, _MAX_FACTOR = 0.9, 0.2, 10.0  # of the change of the step from one to the next
_INTEGRAL = 0.04  # the exponent of the last error in the proportional-integral control


def next_step(error: float, before: float, rejected: bool) -> float:
    """The factor from one step to the next, from its error and that of the last accepted step, relative to the tolerance."""
    if not error < np.inf:
        return _MIN_FACTOR
    factor = _SAFETY * max(error, 1e-10) ** -(0.2 - 0.75 * _INTEGRAL) * max(before, 1e-4) ** _INTEGRAL
    return float(np.clip(factor, _MIN_FACTOR, 1.0 if rejected else _MAX_FACTOR))


def first_step(slope: float, change: float, guess: float) -> float:
    """The length of the first step, from the size of the slope and its change over the step `guess`."""
    largest = max(slope, change)
    step = max(1e-6 * guess, guess * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** 0.2
    return min(100 * guess, step)


@cache
def make_slopes(composition: KernelTerms, pairs: int, channels: tuple, precision: str):
    """slopes(S, birth, K, A, Y, Q, out, n, first, dt, tau, last, at, at_birth, at_stage, at_out)

    The derivatives d(x, v) / d tau of each lane, with tau from 0 to 1.

    S : the state at the start of the step; birth, K, A, Q, n, first and dt as of make_step's kernel
    Y (6, capacity) : positions and velocities at tau
    out (6, capacity) : the slopes
    tau : fraction of each lane's own step
    at, at_birth, at_stage, at_out : the addresses of S, birth, Y and out
    last : not 0 to subtract the mass lost in the step from the masses in S
    """
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)
    terms = TileTerms(composition, channels, pairs, real)

    @ti.kernel
    def slopes(
        S: matrix, birth: ti.types.ndarray(ti.f64, 1), K: ti.types.ndarray(ti.u32, 2), A: matrix, Y: matrix, Q: vector,
        out: matrix, n: ti.i32, first: ti.f64, dt: ti.f64, tau: real, last: ti.i32,
        at: ti.i64,
        at_birth: ti.i64,
        at_stage: ti.i64,
        at_out: ti.i64,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for s in range(BLOCK // WIDTH):
                i = b * BLOCK + s * WIDTH
                if i < n:
                    X = tile(STATE)
                    Z = tile(STATE)
                    L = lanes(terms)
                    load(X, L, S, at, i, PX)
                    lane_steps(terms, L, S, at, birth, at_birth, i, first * dt, dt, 0.0, real)
                    if ti.static(len(terms.mass_loss_terms) > 0):
                        compute_mass_loss(terms, L, X, S, K, Q, i)
                    load(X, L, Y, at_stage, i, 0)
                    accumulate(terms, L, X, S, K, A, Q, i, tau)
                    advance_stage(terms, L, X, X, Z, S, K, Q, i, tau, 1.0, 0.0)
                    store(Z, out, at_out, i, 0)
                    if ti.static(len(terms.mass_loss_terms) > 0):
                        if last != 0:
                            apply_mass_loss(L, S, i, n)

    return runtime.kernel(slopes, precision)
