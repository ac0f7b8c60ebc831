"""The shape of each particle's neighbourhood, which a look's `stretch: {by: neighbours}` gives to its disc.

The shape is the covariance of the positions of the particles within reach about their mean, weighted by (1 - (d / reach)^2)^3,
as in the anisotropic kernels of fluids. A few particles lie in some direction by chance. N independent ones of an even cloud
give the traceless part D of the sum S = sum of w e e^T, e the places from the mean, a square |D|^2 of 2/3 sum of w^2 |e|^4,
times N / (N - 1) because the mean is theirs, with N = (sum of w)^2 / (sum of w^2). That square is taken away from the one found
(the positive part of Stein's rule): D is multiplied by 1 - expected / found, or by 0. So one neighbour or two give no direction.

The lengths of the ellipsoid are the roots of the eigenvalues. None is less than the greatest divided by `most`, and together
they keep the volume.

Source: Yu and Turk, Reconstructing Surfaces of Particle-Based Fluids Using Anisotropic Kernels, ACM Trans. Graph. 32 (2013), with
their weighted covariance and bound of lengths; James and Stein, Estimation with Quadratic Loss (1961).

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp, log
from gen_art.renderer.neighbour_sums import CHANCE, DIAGONAL, OTHERS, SQUARES, TOTAL, NeighbourSums

__all__ = ["neighbour_shapes"]

SWEEPS = 6  # of Jacobi's method: it converges to float32 in four
ROWS = ((0, 3, 4), (3, 1, 5), (4, 5, 2))  # of a symmetric matrix xx, yy, zz, xy, xz, yz

F2 = ti.types.ndarray(ti.f32, 2)


@ti.func
def _ellipsoid(a, most):
    """The symmetric matrix of an ellipsoid of volume 1 with the axes of `a` and lengths bounded by `most`.

    Jacobi's method. Source: Golub and Van Loan, Matrix Computations, section 8.5.
    """
    v = ti.Matrix([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for _ in range(SWEEPS):
        for p, q, r in ti.static(((0, 1, 2), (0, 2, 1), (1, 2, 0))):
            off = a[p, q]
            if abs(off) > 1e-12:
                theta = (a[q, q] - a[p, p]) / (2.0 * off)
                t = ti.select(theta < 0.0, -1.0, 1.0) / (abs(theta) + ti.sqrt(theta * theta + 1.0))
                c = 1.0 / ti.sqrt(t * t + 1.0)
                s = t * c
                a[p, p], a[q, q] = a[p, p] - t * off, a[q, q] + t * off
                a[p, q], a[q, p] = 0.0, 0.0
                x, y = a[r, p], a[r, q]
                a[r, p], a[r, q] = c * x - s * y, s * x + c * y
                a[p, r], a[q, r] = a[r, p], a[r, q]
                for m in ti.static(range(3)):
                    x, y = v[m, p], v[m, q]
                    v[m, p], v[m, q] = c * x - s * y, s * x + c * y
    least = ti.max(a[0, 0], ti.max(a[1, 1], a[2, 2])) / (most * most)
    squares = ti.Vector([ti.max(a[0, 0], least), ti.max(a[1, 1], least), ti.max(a[2, 2], least)])
    squares *= exp(log(squares[0] * squares[1] * squares[2]) * (-1.0 / 3.0))
    return v @ ti.Matrix([[squares[0], 0.0, 0.0], [0.0, squares[1], 0.0], [0.0, 0.0, squares[2]]]) @ v.transpose()


@ti.kernel
def _shapes(sums: F2, most: ti.f32, result: F2):
    """The shape of each particle: xx, yy, zz, xy, xz, yz of the squared lengths, whose product is 1, from NeighbourSums."""
    for i in range(sums.shape[0]):
        for c in ti.static(range(6)):
            result[i, c] = 1.0 if c < 3 else 0.0
        total, squares = sums[i, TOTAL], sums[i, SQUARES]
        if total * total > squares * 1.000001:  # more than one
            diagonal = ti.Vector([sums[i, DIAGONAL], sums[i, DIAGONAL + 1], sums[i, DIAGONAL + 2]])
            others = ti.Vector([sums[i, OTHERS], sums[i, OTHERS + 1], sums[i, OTHERS + 2]])
            even = (diagonal[0] + diagonal[1] + diagonal[2]) / 3.0
            if even > 0.0:  # of places that are no longer all the same
                diagonal, others = diagonal / even - 1.0, others / even
                found = diagonal.dot(diagonal) + 2.0 * others.dot(others)
                # squares N / (N - 1) with N of the sums
                chance = 2.0 / 3.0 * sums[i, CHANCE] * total * total / (total * total - squares) / (even * even)
                part = ti.max(1.0 - chance / ti.max(found, 1e-20), 0.0)
                if part > 0.0:
                    diagonal, others = diagonal * part + 1.0, others * part
                    x, y, z = others[0], others[1], others[2]
                    shape = _ellipsoid(ti.Matrix([[diagonal[0], x, y], [x, diagonal[1], z], [y, z, diagonal[2]]]), most)
                    for p, q in ti.static(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
                        result[i, ROWS[p][q]] = shape[p, q]


_shapes_kernel = kernel(_shapes)


def neighbour_shapes(neighbours: NeighbourSums, most: float) -> np.ndarray:
    """(n, 6) float32: xx, yy, zz, xy, xz, yz of the ellipsoid of each of a system's particles, 1, 1, 1, 0, 0, 0 for a ball.

    It is R diag(a^2, b^2, c^2) R^T with a b c = 1 and no ratio of lengths above `most`. One that does not exist has a ball.
    """
    result = np.zeros((neighbours.count, 6), np.float32)
    result[:, :3] = 1.0
    if len(neighbours.slots):
        found = np.empty((len(neighbours.slots), 6), np.float32)
        _shapes_kernel(neighbours.sums, most, found)
        result[neighbours.slots] = found
    return result
