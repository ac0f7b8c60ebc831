"""The inverse square law by a tree: cells act on cells, in a time proportional to the number of particles.

The sources of a cell are represented by their moments. Each pair of cells that are distant relative to their sizes gives both
cells a local expansion about their centres (expansions.py). Both sides keep all terms up to the same order, so that the forces
of a pair cancel and momentum is conserved to round-off. Near pairs are summed particle by particle. Every sum has a fixed order.

two cells are distant if radius_A + radius_B < theta abs(z_A - z_B)

Source: Dehnen (2000), ApJ 536, L39; Dehnen (2002), J. Comput. Phys. 179, 27.
"""

import numpy as np

from gen_art.interactions.expansions import CENTRE, RADIUS, expansion, gather_kernel, raise_kernel
from gen_art.interactions.octree import LEAF, Octree, build_octree
from gen_art.interactions.pair_sums import LANES
from gen_art.interactions.tree_walk import LEVEL_COLUMNS, walk_kernel

__all__ = ["sum_by_tree"]

_TASKS = 128  # about as many branches of the target tree are walked on their own
_SHORT = 1 << 11  # the length that a task's lists have at first
_FAR_AWAY = 1e100  # m, where the cell without sources is


class _Cells:
    """An octree with its particles in order, `sorted` (4, n + LANES): position and amount; and the moments of its cells.

    The last row of moments is that of a cell without sources.
    """

    def __init__(self, positions: np.ndarray, amounts: np.ndarray | None, order: int, precision: str):
        positions = np.ascontiguousarray(positions)
        self.tree: Octree = build_octree(positions)
        n = len(self.tree.order)
        self.sorted = np.zeros((4, n + LANES), positions.dtype)
        self.sorted[:3, :n] = np.take(positions, self.tree.order, axis=1)
        if amounts is not None:
            self.sorted[3, :n] = amounts[self.tree.order]
        tree = self.tree
        self.moments = np.zeros((len(tree.begin) + 1, expansion(order).columns))
        self.moments[-1, CENTRE : CENTRE + 3] = _FAR_AWAY
        gather_kernel(order, precision)(self.sorted, tree.begin, tree.end, tree.links, self.moments)
        for first, last in reversed([*zip(tree.levels, tree.levels[1:])]):
            raise_kernel(order)(tree.links, self.moments, first, last)


def sum_by_tree(
    targets: np.ndarray,
    sources,
    amounts: np.ndarray,
    softening: float,
    theta: float,
    order: int,
    precision: str,
    valued=False,
):
    """The gradient of ψ at `targets`, (3, n); or, if `valued`, ψ, (n,).

    targets : (3, n) m
    sources : (3, m) m; None for the targets themselves, none of which then acts on itself
    amounts : (m,), mass or charge of the sources
    order : of the expansions
    """
    same = sources is None
    target_cells = _Cells(targets, amounts if same else None, order, precision)
    source_cells = target_cells if same else _Cells(sources, amounts, order, precision)
    a, b = target_cells.tree, source_cells.tree
    roots = _branches(a)
    out = np.zeros((1 if valued else 3, targets.shape[1]), targets.dtype)
    numbers, levels = np.array([softening**2, theta**2]), len(a.levels)
    geometries = (np.ascontiguousarray(cells.moments[:, : RADIUS + 1]) for cells in (target_cells, source_cells))
    arrays = (a.begin, a.end, a.links, b.begin, b.end, b.links, *geometries, target_cells.moments, source_cells.moments,
              target_cells.sorted, source_cells.sorted)  # fmt: skip
    capacity = _SHORT
    while len(roots):
        tasks, full = len(roots), np.zeros(len(roots), np.int32)
        walk_kernel(valued, order, precision)(
            roots, *arrays, *(np.empty((tasks, capacity), np.int32) for _ in range(3)),
            np.empty((tasks, levels + 1, LEVEL_COLUMNS), np.int32), np.empty((tasks, levels, expansion(order).coefficients)),
            numbers, int(same), a.order, out, full,
        )  # fmt: skip
        roots, capacity = roots[full > 0], 8 * capacity
    if not valued:
        return out
    if same and softening > 0:
        out[0] -= amounts / softening  # what each particle is to itself
    return out[0]


def _branches(tree: Octree) -> np.ndarray:
    """Cells that hold each particle once, of about as many particles each."""
    most = max(int(tree.end[0]) // _TASKS, LEAF)
    small = tree.end - tree.begin <= most
    small[tree.levels[-2] :] = True
    parent = np.zeros(len(small), np.int64)
    inner = np.flatnonzero(tree.links[:, 1] > 0)
    parent[1:] = np.repeat(inner, tree.links[inner, 1])
    whole = small | (tree.links[:, 1] == 0)
    owned = whole & ~whole[parent]
    owned[0] = whole[0]
    return np.flatnonzero(owned).astype(np.int32)
