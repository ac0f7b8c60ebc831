"""The implicit step of springs: velocities at its end, by conjugate gradients.

(M + h D + h^2 K) dv = h (f(x) + ...) is backward Euler, linearised at the start of the step: stable at any step, and
at rest the springs carry exactly the load, whatever the step or the number of iterations. Directions are preconditioned by
the masses: every residual then sums to zero over free springs, so momentum is kept to round-off however early it stops.
Source: Baraff & Witkin, Large Steps in Cloth Simulation (1998).
"""

import numpy as np

from gen_art.interactions.adjacency import Adjacency
from gen_art.interactions.spring_kernels import BLOCK, spring_kernels
from gen_art.particles.rows import VELOCITY

__all__ = ["TOLERANCE", "solve"]

TOLERANCE = {"f32": 1e-3, "f64": 1e-9}  # of the residual, relative to the right-hand side, in the norm of the masses
_MOST = 1000  # iterations: far beyond what a net needs whose stiffness float32 can hold


def solve(floats: np.ndarray, n: int, springs: Adjacency, h: float, precision: str) -> int:
    """Advance the velocities (rows 3-5) of the first n particles by h under the springs; returns the iterations taken."""
    _, assemble, multiply, descend, turn = spring_kernels(precision)
    dtype = floats.dtype
    edges, (residual, along, image, change) = np.empty((5, len(springs.other)), dtype), np.zeros((4, 3, n), dtype)
    sums = np.zeros((-(-n // BLOCK), 1))
    assemble(floats, springs.first, springs.other, springs.of, edges, residual, n, h)
    descend(floats, change, residual, along, image, n, 0.0, sums)
    left = first = float(sums.sum())
    taken, beta = 0, 0.0
    while left > TOLERANCE[precision] ** 2 * first and left > 0 and taken < _MOST:
        turn(floats, residual, along, n, beta)
        multiply(floats, springs.first, springs.other, edges, along, image, n, sums)
        curvature = float(sums.sum())
        if not curvature > 0:
            break
        descend(floats, change, residual, along, image, n, left / curvature, sums)
        now = float(sums.sum())
        beta, left = now / left, now
        taken += 1
    floats[VELOCITY, :n] += change
    return taken
