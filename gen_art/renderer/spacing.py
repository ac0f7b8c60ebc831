"""The distance of particles to their neighbours, from which a look's `spread` takes the radius of its discs.

The number density at a particle is the sum of (1 - (d / reach)^2)^3 over the particles within reach, itself among them, divided
by that kernel's integral, 64 pi reach^3 / 315. The distance is its cube root's inverse: (number / volume)^(-1/3).

Particles are sorted into cells as wide as the reach. Of a crowded cell SAMPLES particles, evenly chosen, stand for all.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp, log
from gen_art.renderer.neighbour_cells import NeighbourCells

__all__ = ["NO_SPACING", "spacing"]

SAMPLES = 8  # of a cell
KERNEL_INTEGRAL = 64.0 * np.pi / 315.0  # of (1 - r^2)^3 over the unit ball
NO_SPACING = np.zeros(1, np.float32)

F1, F2, I1, I2 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.i32, 1), (ti.i32, 2)))


@ti.kernel
def _spacing(X: F2, first: I1, runs: I2, per_reach: ti.f32, result: F1):
    """The distance to the neighbours of each sorted particle, divided by the reach.

    X, first, runs : positions, first and runs of NeighbourCells
    """
    ti.loop_config(block_dim=1)
    for block in range((runs.shape[0] + 63) // 64):
        for cell in range(block * 64, ti.min((block + 1) * 64, runs.shape[0])):
            for i in range(first[cell], first[cell + 1]):
                density = 0.0
                for r in range(9):
                    for other in range(runs[cell, 2 * r], runs[cell, 2 * r + 1]):
                        start, number = first[other], first[other + 1] - first[other]
                        taken, part = ti.min(number, SAMPLES), 0.0
                        for k in range(taken):
                            j = start + ti.cast(ti.cast(k, ti.i64) * number // taken, ti.i32)
                            x, y, z = X[j, 0] - X[i, 0], X[j, 1] - X[i, 1], X[j, 2] - X[i, 2]
                            s = ti.max(1.0 - (x * x + y * y + z * z) * (per_reach * per_reach), 0.0)
                            part += s * s * s
                        density += part * (ti.cast(number, ti.f32) / ti.cast(taken, ti.f32))
                # a crowded particle may not be in its own sample
                result[i] = exp(log(ti.max(density, 1.0) / KERNEL_INTEGRAL) * (-1.0 / 3.0))


_spacing_kernel = kernel(_spacing)


def spacing(system, time: float, reach: float) -> np.ndarray:
    """(n,) m float32: the distance of each of a system's particles to its neighbours; 0 for those that do not exist.

    reach : how far neighbours are looked for; a lone particle has 0.86 reach
    """
    result = np.zeros(max(int(system.count), 1), np.float32)
    cells = NeighbourCells.of(system, time, reach)
    if cells is not None:
        found = np.empty(len(cells.slots), np.float32)
        _spacing_kernel(cells.positions, cells.first, cells.runs, 1.0 / reach, found)
        result[cells.slots] = found * np.float32(reach)
    return result
