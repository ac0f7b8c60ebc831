"""The implicit step of springs: velocities at its end, by conjugate gradients.

(M + h D + h^2 K) dv = h (f(x) + ...) is backward Euler, linearised at the start of the step. It is stable at any step, and at
rest the spring forces equal the load exactly, whatever the step or the number of iterations. Directions are preconditioned by
the masses: every residual then sums to zero over free springs, so momentum is kept to round-off however early it stops.
Source: Baraff & Witkin, Large Steps in Cloth Simulation (1998).
"""

import numpy as np

from gen_art.interactions.adjacency import Adjacency
from gen_art.interactions.spring_kernels import BLOCK, EDGE_ROWS, spring_kernels
from gen_art.particles.rows import VELOCITY

__all__ = ["TOLERANCE", "solve_implicit"]

TOLERANCE = {"f32": 1e-3, "f64": 1e-9}  # of the residual, relative to the right-hand side, in the norm of the masses
_MAX_ITERATIONS = 1000  # far more than a net needs whose stiffness float32 can represent


def solve_implicit(floats: np.ndarray, n: int, springs: Adjacency, h: float, precision: str) -> int:
    """Advance the velocities of the first n particles by h, s, under the springs; returns the number of iterations."""
    _, assemble, multiply, descend, new_direction = spring_kernels(precision)
    dtype = floats.dtype
    edges = np.empty((EDGE_ROWS, len(springs.other)), dtype)
    residual, direction, image, change = np.zeros((4, 3, n), dtype)  # `image` is the matrix times the direction
    sums = np.zeros((-(-n // BLOCK), 1))
    assemble(floats, springs.first, springs.other, springs.half_numbers, edges, residual, n, h)
    descend(floats, change, residual, direction, image, n, 0.0, sums)
    squared = first_squared = float(sums.sum())
    iterations, beta = 0, 0.0
    while squared > TOLERANCE[precision] ** 2 * first_squared and squared > 0 and iterations < _MAX_ITERATIONS:
        new_direction(floats, residual, direction, n, beta)
        multiply(floats, springs.first, springs.other, edges, direction, image, n, sums)
        curvature = float(sums.sum())
        if not curvature > 0:
            break
        descend(floats, change, residual, direction, image, n, squared / curvature, sums)
        new_squared = float(sums.sum())
        beta, squared = new_squared / squared, new_squared
        iterations += 1
    floats[VELOCITY, :n] += change
    return iterations
