"""The inverse square law by a tree: cells act on cells, in a time proportional to the number of particles.

The sources of a cell are represented by their moments up to the quadrupole. Each pair of cells that are distant relative to
their sizes gives both cells a local expansion to third order in the distance from their centres. Both sides keep all terms up
to the same order, so that the forces of a pair cancel and momentum is conserved to round-off. Near pairs are summed particle
by particle. Every sum has a fixed order.

ψ(x) = sum_a c_a g(x - x_a), g(R) = 1 / sqrt(R^2 + softening^2), to order 3 in d = x - z_B and s = x_a - z_A
two cells are distant if radius_A + radius_B < theta abs(z_A - z_B)

Source: Dehnen (2000), ApJ 536, L39; Dehnen (2002), J. Comput. Phys. 179, 27.
"""

import numpy as np

from gen_art.interactions.octree import Octree, build_octree
from gen_art.interactions.tree_kernels import COEFFICIENTS, MOMENTS, tree_kernels

__all__ = ["sum_by_tree"]

_STACK = 1 << 14  # pairs of cells that wait: at most 64 for each of 2 x 20 levels


class _Cells:
    """An octree with its particles in order, `sorted` (4, n + 16): position and amount; and the moments of its cells."""

    def __init__(self, positions: np.ndarray, amounts: np.ndarray, precision: str):
        self.tree: Octree = build_octree(positions)
        n = len(self.tree.order)
        self.sorted = np.zeros((4, n + 16), positions.dtype)
        self.sorted[:3, :n] = positions[:, self.tree.order]
        self.sorted[3, :n] = amounts[self.tree.order]
        self.moments = np.zeros((len(self.tree.begin), MOMENTS))
        tree_kernels(precision).gather(self.sorted, self.tree.begin, self.tree.end, self.moments)


def sum_by_tree(
    targets: np.ndarray, sources, amounts: np.ndarray, softening: float, theta: float, precision: str, valued=False
):
    """The gradient of ψ at `targets`, in the first three rows of (4, n); or, if `valued`, ψ in the last row.

    targets : (3, n) m
    sources : (3, m) m; None for the targets themselves, none of which then acts on itself
    amounts : (m,), mass or charge of the sources
    The other rows of the result have no meaning.
    """
    kernels = tree_kernels(precision)
    same = sources is None
    target_cells = _Cells(targets, amounts if same else np.zeros(targets.shape[1], targets.dtype), precision)
    source_cells = target_cells if same else _Cells(sources, amounts, precision)
    far, far_first, near, near_first = _lists(kernels, target_cells, source_cells, same, theta)
    tree = target_cells.tree
    numbers = np.array([softening**2])
    local = np.zeros((len(tree.begin), COEFFICIENTS))
    kernels.far(target_cells.moments, source_cells.moments, far, far_first, local, numbers)
    for first, last in zip(tree.levels, tree.levels[1:]):
        kernels.down(target_cells.moments, tree.child, tree.children, first, last, local)
    out = np.zeros((4, target_cells.sorted.shape[1]), targets.dtype)
    arrays = (target_cells.sorted, source_cells.sorted, target_cells.moments, local)
    ranges = (tree.leaves, tree.begin, tree.end, source_cells.tree.begin, source_cells.tree.end)
    close = kernels.value if valued else kernels.near
    close(*arrays, *ranges, near, near_first, numbers.astype(targets.dtype), int(same), out)
    result = np.empty((4, targets.shape[1]), targets.dtype)
    result[:, tree.order] = out[:, : targets.shape[1]]
    return result


def _lists(kernels, target_cells: _Cells, source_cells: _Cells, same: bool, theta: float):
    """For each target cell, in order, the source cells that act on it as a whole, and those that act particle by particle."""
    cells = len(target_cells.tree.begin)
    stack = np.zeros((2, _STACK), np.int32)
    counts = np.zeros((2, cells + 1), np.int32)
    nothing, limit = np.zeros(1, np.int32), np.array([theta])
    a, b = target_cells, source_cells
    trees = (a.tree.child, a.tree.children, b.tree.child, b.tree.children, a.moments, b.moments)
    kernels.walk(*trees, stack, counts, nothing, nothing, int(same), 0, limit)
    first = np.zeros((2, cells + 1), np.int32)
    np.cumsum(counts[:, :cells], axis=1, out=first[:, 1:])
    far, near = np.empty(first[0, -1] + 1, np.int32), np.empty(first[1, -1] + 1, np.int32)
    counts[:] = first
    kernels.walk(*trees, stack, counts, far, near, int(same), 1, limit)
    return far, np.ascontiguousarray(first[0]), near, np.ascontiguousarray(first[1])
