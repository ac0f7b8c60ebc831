"""The distance of particles to their neighbours, from which a look's `spread` takes the radius of its discs.

The number density at a particle is the sum of (1 - (d / reach)^2)^3 over the particles within reach, itself among them, divided
by that kernel's integral, 64 pi reach^3 / 315. The distance is its cube root's inverse: (number / volume)^(-1/3).
"""

import numpy as np

from gen_art.renderer.neighbour_sums import TOTAL, NeighbourSums

__all__ = ["NO_SPACING", "spacing"]

KERNEL_INTEGRAL = 64.0 * np.pi / 315.0  # of (1 - r^2)^3 over the unit ball
NO_SPACING = np.zeros(1, np.float32)


def spacing(neighbours: NeighbourSums) -> np.ndarray:
    """(n,) m float32: the distance of each of a system's particles to its neighbours; 0 for those that do not exist.

    A lone particle has 0.86 reach.
    """
    result = np.zeros(neighbours.count, np.float32)
    number = np.maximum(neighbours.sums[:, TOTAL], 1.0)  # a crowded particle may not be in its own sample
    result[neighbours.slots] = np.cbrt(KERNEL_INTEGRAL / number) * neighbours.reach
    return result
