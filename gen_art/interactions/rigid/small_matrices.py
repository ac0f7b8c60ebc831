"""Products of 3 by 3 matrices and vectors, many at once, and the eigenvectors of one symmetric matrix.

Every sum is written out, so that its order is fixed: BLAS, LAPACK and einsum choose theirs by the
processor, and the last bits with it.
"""

import math

import numpy as np

__all__ = ["apply", "apply_transposed", "compose", "cross", "dot", "norm", "symmetric_eigen", "transposed"]

_SWEEPS = 60  # at most; a sweep of Jacobi rotations squares the elements off the diagonal, so that six are enough


def apply(A: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A x, with A (..., 3, 3) and x (..., 3)."""
    return A[..., 0] * x[..., 0, None] + A[..., 1] * x[..., 1, None] + A[..., 2] * x[..., 2, None]


def apply_transposed(A: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A^T x, with A (..., 3, 3) and x (..., 3)."""
    return A[..., 0, :] * x[..., 0, None] + A[..., 1, :] * x[..., 1, None] + A[..., 2, :] * x[..., 2, None]


def transposed(A: np.ndarray) -> np.ndarray:
    """A^T of each matrix (..., 3, 3)."""
    return np.swapaxes(A, -1, -2)


def compose(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """A B, both (..., 3, 3)."""
    first, second, third = (A[..., :, k, None] * B[..., None, k, :] for k in range(3))
    return first + second + third


def dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The scalar product along the last axis, of 3."""
    return u[..., 0] * v[..., 0] + u[..., 1] * v[..., 1] + u[..., 2] * v[..., 2]


def norm(v: np.ndarray) -> np.ndarray:
    """The length along the last axis, of 3."""
    return np.sqrt(dot(v, v))


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The cross product along the last axis."""
    return np.stack(
        [
            u[..., 1] * v[..., 2] - u[..., 2] * v[..., 1],
            u[..., 2] * v[..., 0] - u[..., 0] * v[..., 2],
            u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0],
        ],
        -1,
    )


def symmetric_eigen(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (3,), increasing, of one symmetric matrix (3, 3), and its eigenvectors as the columns of a rotation.

    Jacobi's method. Source: Golub & Van Loan, Matrix Computations, section 8.5.
    """
    A, V = np.array(matrix, float), np.eye(3)
    for _ in range(_SWEEPS):
        if A[0, 1] == A[0, 2] == A[1, 2] == 0.0:
            break
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(A[p, q]) <= 1e-300 or abs(A[p, q]) <= 1e-18 * (abs(A[p, p]) + abs(A[q, q])):
                A[p, q] = A[q, p] = 0.0
                continue
            theta = (A[q, q] - A[p, p]) / (2 * A[p, q])
            t = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1))
            c = 1 / math.sqrt(t * t + 1)
            s = t * c
            for M in (A.T, A, V):  # the rows, then the columns
                M[:, p], M[:, q] = c * M[:, p] - s * M[:, q], s * M[:, p] + c * M[:, q]
            A[p, q] = A[q, p] = 0.0
    values = np.array([A[0, 0], A[1, 1], A[2, 2]])
    order = np.argsort(values, kind="stable")
    axes = V[:, order]
    if dot(cross(axes[:, 0], axes[:, 1]), axes[:, 2]) < 0:
        axes[:, 2] *= -1
    return values[order], axes
