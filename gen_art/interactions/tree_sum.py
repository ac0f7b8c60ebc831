"""The inverse square by a tree: cells act on cells, and both feel the same, in a time that grows as the particles do.

Each cell's sources are known by their moments up to the quadrupole; each pair of cells that are far apart for their sizes
gives both a local expansion to third order in the distance from their centres. All terms up to the same order are kept on
both sides, so that the forces of a pair of cells cancel and momentum stays to round-off. Pairs that are near are summed
particle by particle. Every sum has a fixed order.

ψ(x) = sum_a c_a g(x - x_a), g(R) = 1 / sqrt(R^2 + softening^2), to order 3 in d = x - z_B and s = x_a - z_A
two cells are far when radius_A + radius_B < theta abs(z_A - z_B)

Source: Dehnen (2000), ApJ 536, L39; Dehnen (2002), J. Comput. Phys. 179, 27.
"""

import numpy as np

from gen_art.interactions.octree import Octree, grow
from gen_art.interactions.tree_kernels import COEFFICIENTS, MOMENTS, tree_kernels

__all__ = ["sum_by_tree"]

_STACK = 1 << 14  # pairs of cells that wait: 64 for each of 2 x 20 levels is the most there can be


class _Cells:
    """An octree with its particles in order, (4, n + 16): place and amount, and its cells' moments."""

    def __init__(self, positions: np.ndarray, amounts: np.ndarray, precision: str):
        self.tree: Octree = grow(positions)
        n = len(self.tree.order)
        self.sorted = np.zeros((4, n + 16), positions.dtype)
        self.sorted[:3, :n] = positions[:, self.tree.order]
        self.sorted[3, :n] = amounts[self.tree.order]
        self.moments = np.zeros((len(self.tree.begin), MOMENTS))
        tree_kernels(precision).gather(self.sorted, self.tree.begin, self.tree.end, self.moments)


def sum_by_tree(
    targets: np.ndarray, sources, amounts: np.ndarray, softening: float, theta: float, precision: str, valued=False
):
    """(4, n): at `targets` (3, n) the gradient of ψ in the first three rows, or, where `valued`, ψ in the last.

    amounts (m,) at `sources` (3, m) make it. The other rows are of no use.

    sources is None: the targets themselves, with their amounts; none then acts on itself.
    """
    kernels = tree_kernels(precision)
    alone = sources is None
    ours = _Cells(targets, amounts if alone else np.zeros(targets.shape[1], targets.dtype), precision)
    theirs = ours if alone else _Cells(sources, amounts, precision)
    far, far_first, near, near_first = _lists(kernels, ours, theirs, alone, theta)
    tree = ours.tree
    numbers = np.array([softening**2])
    local = np.zeros((len(tree.begin), COEFFICIENTS))
    kernels.far(ours.moments, theirs.moments, far, far_first, local, numbers)
    for first, last in zip(tree.levels, tree.levels[1:]):
        kernels.down(ours.moments, tree.child, tree.children, first, last, local)
    out = np.zeros((4, ours.sorted.shape[1]), targets.dtype)
    (kernels.value if valued else kernels.near)(
        ours.sorted, theirs.sorted, ours.moments, local, tree.leaves, tree.begin, tree.end, theirs.tree.begin,
        theirs.tree.end, near, near_first, numbers.astype(targets.dtype), int(alone), out,
    )  # fmt: skip
    result = np.empty((4, targets.shape[1]), targets.dtype)
    result[:, tree.order] = out[:, : targets.shape[1]]
    return result


def _lists(kernels, ours: _Cells, theirs: _Cells, alone: bool, theta: float):
    """For each of our cells, in order, which of theirs act on it as a whole, and which particle by particle."""
    cells = len(ours.tree.begin)
    stack = np.zeros((2, _STACK), np.int32)
    counts = np.zeros((2, cells + 1), np.int32)
    nothing, limit = np.zeros(1, np.int32), np.array([theta])
    trees = (ours.tree.child, ours.tree.children, theirs.tree.child, theirs.tree.children, ours.moments, theirs.moments)
    kernels.walk(*trees, stack, counts, nothing, nothing, int(alone), 0, limit)
    first = np.zeros((2, cells + 1), np.int32)
    np.cumsum(counts[:, :cells], axis=1, out=first[:, 1:])
    far, near = np.empty(first[0, -1] + 1, np.int32), np.empty(first[1, -1] + 1, np.int32)
    counts[:] = first
    kernels.walk(*trees, stack, counts, far, near, int(alone), 1, limit)
    return far, np.ascontiguousarray(first[0]), near, np.ascontiguousarray(first[1])
