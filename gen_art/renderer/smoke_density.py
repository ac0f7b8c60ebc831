"""Smoke as a grid of extinction: particles are deposited on nodes, optical depth is summed along directions.

Nodes stand `cell` apart along three axes that the caller chooses. A particle's extinction cross section (m^2) goes to the eight
nodes around it by trilinear weights. Large sprites go into grids of two and four times the cell, which are interpolated and
added to the fine one. Cell size and corner change in fixed steps, so that the grid does not move with the outline of the
cloud. One thread deposits the particles in their order (8 ms for 300,000), so the number of threads changes no bit.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import kernel, ti

__all__ = ["DIRECTIONS", "LEVELS", "STEP", "Smoke", "WEIGHTS"]

LEVELS = 3  # grids of 1, 2 and 4 cells
SIGMA = 0.95  # standard deviation, in cells, of a deposited particle in the finest grid, including the lookup
STEP = 2 ** (LEVELS - 1)  # cells of the finest grid along a cell of the coarsest
OFFSET = 3  # column of `shapes` with a grid's first node; the columns before it hold the nodes along each axis

# Lebedev's rule of 14 points on the sphere, exact for polynomials up to degree 5: the axes, then the diagonals of a cube.
DIRECTIONS = np.array(
    [[s * (k == c) for c in range(3)] for k in range(3) for s in (1, -1)]
    + [[a, b, c] for a in (1, -1) for b in (1, -1) for c in (1, -1)],
    dtype=np.int64,
)
WEIGHTS = np.array([1 / 15] * 6 + [3 / 40] * 8)

F1, F2 = (ti.types.ndarray(ti.f32, n) for n in (1, 2))


@ti.kernel
def _deposit(
    nodes: F2, cross_section: F1, level: F1, n: ti.i32, shapes: ti.types.ndarray(ti.i32, 2), grid: F1
):  # fmt: skip
    """Add n particles' cross sections to the grids of two neighbouring levels each.

    nodes : (n, 3) positions in cells of the finest grid
    level : (n,) 0 for the finest grid; the fraction shares the particle between two levels
    grid : all levels' nodes, one after another as `shapes` says
    """
    ti.loop_config(serialize=True)
    for i in range(n):
        if cross_section[i] > 0.0:
            for which_level in range(2):
                level_here = ti.min(ti.cast(level[i], ti.i32) + which_level, LEVELS - 1)
                level_weight = level[i] - ti.cast(ti.cast(level[i], ti.i32), ti.f32)
                if which_level == 0:
                    level_weight = 1.0 - level_weight
                if level_weight > 0.0:
                    scale = 1.0 / ti.cast(1 << level_here, ti.f32)
                    x, y, z = nodes[i, 0] * scale, nodes[i, 1] * scale, nodes[i, 2] * scale
                    d1, d2 = shapes[level_here, 1], shapes[level_here, 2]
                    j, k, m = ti.cast(x, ti.i32), ti.cast(y, ti.i32), ti.cast(z, ti.i32)
                    fx, fy, fz = x - ti.cast(j, ti.f32), y - ti.cast(k, ti.f32), z - ti.cast(m, ti.f32)
                    for a in range(2):
                        wa = level_weight * cross_section[i] * ti.select(a == 1, fx, 1.0 - fx)
                        for b in range(2):
                            wb = wa * ti.select(b == 1, fy, 1.0 - fy)
                            at = shapes[level_here, OFFSET] + ((j + a) * d1 + k + b) * d2 + m
                            grid[at] = grid[at] + wb * (1.0 - fz)
                            grid[at + 1] = grid[at + 1] + wb * fz


deposit = kernel(_deposit)


def _blurred(grid: np.ndarray) -> np.ndarray:
    """The 1-2-1 mean along each axis; what would leave the grid is lost (smoke keeps away from the border)."""
    for axis in range(3):
        a = np.moveaxis(grid, axis, 0)
        out = 0.5 * a
        out[1:] += 0.25 * a[:-1]
        out[:-1] += 0.25 * a[1:]
        grid = np.moveaxis(out, 0, axis)
    return np.ascontiguousarray(grid)


def _finer(grid: np.ndarray) -> np.ndarray:
    """The same extinction on nodes half as far apart, (2n - 1) along each axis, linear in between."""
    for axis in range(3):
        a = np.moveaxis(grid, axis, 0)
        out = np.empty((2 * len(a) - 1, *a.shape[1:]), a.dtype)
        out[::2] = 0.5 * a
        out[1::2] = 0.25 * (a[:-1] + a[1:])
        grid = np.moveaxis(out, 0, axis)
    return grid


def _coarser(grid: np.ndarray) -> np.ndarray:
    """The same extinction on nodes twice as far apart; n must be odd along each axis."""
    for axis in range(3):
        a = np.moveaxis(grid, axis, 0)
        out = a[::2].copy()
        out[:-1] += 0.5 * a[1::2]
        out[1:] += 0.5 * a[1::2]
        grid = np.moveaxis(out, 0, axis)
    return np.ascontiguousarray(grid)


def _self_shadow_depth(depth: np.ndarray) -> np.ndarray:
    """-log((1 - e^-d) / d): the depth whose transmittance is the mean transmittance of a uniform layer of depth d to its smoke.

    Half of d where the layer is thin; less where it is dense, so that the surface of dense smoke is not dark.
    """
    result = 0.5 * depth
    dense = depth > 0.1
    d = depth[dense]
    result[dense] = np.log(d / -np.expm1(-d))
    return result


def _sweep(extinction: np.ndarray, direction, length: float) -> np.ndarray:
    """Sums of `extinction` times `length` before each node along `direction` (three of -1, 0, 1), plus the node's own shadow."""
    flip = tuple(slice(None, None, -1) if d < 0 else slice(None) for d in direction)
    layer = extinction[flip] * np.float32(length)
    if np.count_nonzero(direction) == 1:
        total = np.cumsum(layer, axis=int(np.flatnonzero(direction)[0]), dtype=np.float32)
    else:
        total = layer.copy()
        for i in range(1, len(layer)):
            total[i, 1:, 1:] += total[i - 1, :-1, :-1]
    total -= layer - _self_shadow_depth(layer)
    return total[flip]


@dataclass(frozen=True)
class Smoke:
    """Extinction on nodes.

    axes : (3, 3), rows are unit vectors
    cell : distance of two nodes, m
    corner : (3,) in cells; node (i, j, k) stands at (corner + (i, j, k)) * cell along the axes
    extinction : (a, b, c) float32, cross section of each node, m^2
    """

    axes: np.ndarray
    cell: float
    corner: np.ndarray
    extinction: np.ndarray

    @classmethod
    def of(cls, positions, cross_sections, radii, axes, resolution: int, margin: float = 0.0) -> "Smoke":
        """The smoke of particles, with at most `resolution` cells along the longest side.

        positions : (n, 3) m
        cross_sections : (n,) extinction, m^2
        radii : (n,) of the sprites, m
        axes : (3, 3), rows are unit vectors
        margin : empty space on every side, as a part of the longest side
        """
        occupied = np.flatnonzero(cross_sections > 0)
        if not len(occupied):
            return cls(axes, 1.0, np.zeros(3), np.zeros((STEP + 1,) * 3, np.float32))
        local = axes @ np.asarray(positions, np.float64)[occupied].T  # (3, n): rows are faster to search than columns
        low, high = local.min(axis=1), local.max(axis=1)
        extent = max(float((high - low).max()), 1e-6 * (1.0 + float(np.abs(local).max())))
        if margin > 0.0:
            low, high = low - margin * extent, high + margin * extent
            extent *= 1.0 + 2.0 * margin
        cell = 2.0 ** (np.ceil(np.log2(extent / resolution) * 2.0) / 2.0)
        corner = (np.floor(low / (cell * STEP)) - 1.0) * STEP
        coarse_cells = (np.floor(high / (cell * STEP)) - corner / STEP).astype(int) + 2  # cells of the coarsest grid
        shapes = np.zeros((LEVELS, 4), np.int32)
        offset = 0
        for level in range(LEVELS):
            shapes[level, :OFFSET] = coarse_cells * 2 ** (LEVELS - 1 - level) + 1
            shapes[level, OFFSET] = offset
            offset += int(np.prod(shapes[level, :OFFSET].astype(np.int64)))
        nodes = np.ascontiguousarray((local / cell - corner[:, None]).T, np.float32)
        sprite_sigma = np.asarray(radii, np.float32)[occupied] / np.float32(2.2 * SIGMA * cell)
        level = np.clip(np.log2(np.maximum(sprite_sigma, 1e-6)), 0.0, LEVELS - 1.0).astype(np.float32)
        grids = np.zeros(offset, np.float32)
        present = np.ascontiguousarray(cross_sections[occupied], np.float32)
        deposit(nodes, present, level, len(occupied), shapes, grids)
        extinction: np.ndarray | None = None
        for shape in shapes[::-1]:
            grid = grids[shape[OFFSET] : shape[OFFSET] + int(np.prod(shape[:OFFSET]))].reshape(shape[:OFFSET])
            extinction = _blurred(grid if extinction is None else grid + _finer(extinction))
        assert extinction is not None  # there is a level at least
        return cls(axes, cell, corner, extinction)

    def coarse(self, times: int) -> "Smoke":
        """The same smoke on nodes 2^times as far apart; a factor up to STEP works for every shape of cloud."""
        smoke = self
        for _ in range(times):
            smoke = Smoke(self.axes, smoke.cell * 2.0, smoke.corner / 2.0, _coarser(smoke.extinction))
        return smoke

    def depth(self, direction) -> np.ndarray:
        """Optical depth at each node of light that travels along `direction` (three of -1, 0, 1 along the axes)."""
        length = np.sqrt(np.count_nonzero(direction))
        return _sweep(self.extinction, direction, length / self.cell**2)

    def to_nodes(self, positions) -> np.ndarray:
        """World positions (n, 3) in node coordinates, (n, 3) float32, kept inside the grid."""
        x, y, z = np.asarray(positions, np.float64).T  # rows: a product of an array this thin is slow
        nodes = np.empty((len(x), 3), np.float32)
        for c, axis in enumerate(self.axes / self.cell):
            along = x * axis[0] + y * axis[1] + z * axis[2] - self.corner[c]
            nodes[:, c] = np.clip(along, 0.0, self.extinction.shape[c] - 1.001)
        return nodes
