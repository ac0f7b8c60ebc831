"""Links between pairs of particles as capsules, to be drawn."""

import numpy as np

from gen_art.interactions.base import Shapes

__all__ = ["capsules_along"]


def capsules_along(positions: np.ndarray, velocities: np.ndarray, pairs: np.ndarray) -> Shapes:
    """A capsule from the first to the second particle of each pair, as thick as the first.

    positions, velocities : (3, n) m and m/s
    pairs : (m, 2), slots
    """
    a, b = positions[:, pairs[:, 0]], positions[:, pairs[:, 1]]
    along = b - a
    length = np.sqrt((along * along).sum(axis=0))
    y = np.where(length > 0.0, along / np.where(length > 0.0, length, 1.0), np.array([[0.0], [1.0], [0.0]]))
    # the axis of the world to which y is least parallel gives a second direction
    least = np.argmin(np.abs(y), axis=0)
    x = np.eye(3)[:, least] - y * y[least, np.arange(len(least))]
    x /= np.sqrt((x * x).sum(axis=0))
    z = np.stack([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]])
    half = np.zeros((len(pairs), 3))
    half[:, 1] = 0.5 * length
    axes = np.stack([x.T, y.T, z.T], axis=1)
    va, vb = velocities[:, pairs[:, 0]], velocities[:, pairs[:, 1]]
    change = (vb - va) / np.where(length > 0.0, length, np.inf)
    spin = np.stack([y[k - 2] * change[k - 1] - y[k - 1] * change[k - 2] for k in range(3)], axis=1)
    return Shapes(pairs[:, 0], 0.5 * (a + b).T, half, np.full(len(pairs), np.nan), axes, 0.5 * (va + vb).T, spin)
