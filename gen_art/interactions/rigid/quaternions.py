"""Rotations of many bodies at once, in NumPy: unit quaternions (w, x, y, z) and their rotation matrices.

Sums are written out, so that their order, and the bits, never depend on the processor.
"""

import numpy as np

from gen_art.interactions.rigid.small_matrices import cross, dot
from gen_art.maths.array_functions import cos, sin

__all__ = ["matrices", "product", "quaternion", "rotation"]


def rotation(vectors: np.ndarray) -> np.ndarray:
    """Quaternions (..., 4) of the rotation vectors (..., 3), axis times angle, rad."""
    v = np.asarray(vectors, float)
    square = dot(v, v)[..., None]
    half = 0.5 * np.sqrt(square)
    small = half < 1e-4
    factor = np.where(small, 0.5 - square / 48, sin(half) / np.where(small, 1.0, 2 * half))
    return np.concatenate([cos(half), factor * v], -1)


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The rotation q followed by p, as a unit quaternion (..., 4)."""
    a, u, b, v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    result = np.concatenate([a * b - dot(u, v)[..., None], a * v + b * u + cross(u, v)], -1)
    return result / np.sqrt(_square(result))[..., None]


def _square(q: np.ndarray) -> np.ndarray:
    return q[..., 0] * q[..., 0] + q[..., 1] * q[..., 1] + q[..., 2] * q[..., 2] + q[..., 3] * q[..., 3]


def matrices(q: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 3) from the body's frame to the world's; columns are the body's axes."""
    w, x, y, z = (q[..., k] for k in range(4))
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
        ],
        -2,
    )


def quaternion(matrix: np.ndarray) -> np.ndarray:
    """The quaternion (4,) of one rotation matrix (3, 3), from its largest component."""
    m = matrix
    squares = np.array([m[0, 0] + m[1, 1] + m[2, 2], m[0, 0], m[1, 1], m[2, 2]])
    k = int(np.argmax(squares))
    if k == 0:
        q = np.array([1 + squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        i, j, l = k - 1, k % 3, (k + 1) % 3
        q = np.zeros(4)
        q[0] = m[l, j] - m[j, l]
        q[1 + i] = 1 + m[i, i] - m[j, j] - m[l, l]
        q[1 + j], q[1 + l] = m[i, j] + m[j, i], m[i, l] + m[l, i]
    return q / np.sqrt(_square(q))
