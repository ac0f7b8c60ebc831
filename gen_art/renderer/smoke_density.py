"""Smoke as a grid of optical depth: laid out of sprites, swept along directions, read back at the particles.

Nodes stand `cell` apart along three axes of the caller's choice; a particle's extinction cross section (m^2) goes to the
eight nodes around it by trilinear weights. Large sprites go into grids of two and four times the cell, which are laid over
the fine one as their spread asks for. Cell and corner come in fixed steps, so that the grid does not crawl with the
cloud's outline. One thread lays the particles in their order (8 ms for 300,000): the same bits on any number of threads.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import kernel, ti

__all__ = ["DIRECTIONS", "LEVELS", "STEP", "Smoke", "WEIGHTS"]

LEVELS = 3  # grids of 1, 2 and 4 cells
SPREAD = 0.95  # standard deviation, in cells, of what a particle becomes in the finest of them, its lookup included
STEP = 2 ** (LEVELS - 1)

# Lebedev's rule of 14 points on the sphere, exact for polynomials up to degree 5: the axes, then the diagonals of a cube.
DIRECTIONS = np.array(
    [[s * (k == c) for c in range(3)] for k in range(3) for s in (1, -1)]
    + [[a, b, c] for a in (1, -1) for b in (1, -1) for c in (1, -1)],
    dtype=np.int64,
)
WEIGHTS = np.array([1 / 15] * 6 + [3 / 40] * 8)

F1, F2 = (ti.types.ndarray(ti.f32, n) for n in (1, 2))


@ti.kernel
def _lay(
    place: F2, section: F1, level: F1, n: ti.i32, shapes: ti.types.ndarray(ti.i32, 2), grid: F1
):  # fmt: skip
    ti.loop_config(serialize=True)
    for i in range(n):
        if section[i] > 0.0:
            for half in range(2):
                step = ti.min(ti.cast(level[i], ti.i32) + half, LEVELS - 1)
                part = level[i] - ti.cast(ti.cast(level[i], ti.i32), ti.f32)
                if half == 0:
                    part = 1.0 - part
                if part > 0.0:
                    size = 1.0 / ti.cast(1 << step, ti.f32)
                    x, y, z = place[i, 0] * size, place[i, 1] * size, place[i, 2] * size
                    j, k, m = ti.cast(x, ti.i32), ti.cast(y, ti.i32), ti.cast(z, ti.i32)
                    fx, fy, fz = x - ti.cast(j, ti.f32), y - ti.cast(k, ti.f32), z - ti.cast(m, ti.f32)
                    for a in range(2):
                        wa = part * section[i] * ti.select(a == 1, fx, 1.0 - fx)
                        for b in range(2):
                            wb = wa * ti.select(b == 1, fy, 1.0 - fy)
                            at = shapes[step, 3] + ((j + a) * shapes[step, 1] + k + b) * shapes[step, 2] + m
                            grid[at] = grid[at] + wb * (1.0 - fz)
                            grid[at + 1] = grid[at + 1] + wb * fz


lay = kernel(_lay)


def _blurred(grid: np.ndarray) -> np.ndarray:
    """The 1-2-1 mean along each axis; what would leave goes (the smoke keeps away from the border)."""
    for axis in range(3):
        a = np.moveaxis(grid, axis, 0)
        out = 0.5 * a
        out[1:] += 0.25 * a[:-1]
        out[:-1] += 0.25 * a[1:]
        grid = np.moveaxis(out, 0, axis)
    return np.ascontiguousarray(grid)


def _finer(grid: np.ndarray) -> np.ndarray:
    """The same extinction on nodes half as far apart, (2n - 1) along each axis: linear in between."""
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


def _within(depth: np.ndarray) -> np.ndarray:
    """-log((1 - e^-d) / d): the depth that lets through what a uniform layer of depth d lets through to its own smoke, on
    the mean. Half of d where it is thin; less where it is dense, so that the skin of dense smoke is not dark.
    """
    result = 0.5 * depth
    dense = depth > 0.1
    d = depth[dense]
    result[dense] = np.log(d / -np.expm1(-d))
    return result


def _sweep(dense: np.ndarray, direction, length: float) -> np.ndarray:
    """Sums of `dense` times `length` along `direction` (three of -1, 0, 1) before each node, and what of its own layer
    shadows it.
    """
    flip = tuple(slice(None, None, -1) if d < 0 else slice(None) for d in direction)
    own = dense[flip] * np.float32(length)
    if np.count_nonzero(direction) == 1:
        total = np.cumsum(own, axis=int(np.flatnonzero(direction)[0]), dtype=np.float32)
    else:
        total = own.copy()
        for i in range(1, len(own)):
            total[i, 1:, 1:] += total[i - 1, :-1, :-1]
    total -= own - _within(own)
    return total[flip]


@dataclass(frozen=True)
class Smoke:
    """Extinction on nodes: `dense` (a, b, c) float32, cross section (m^2) a node; node (i, j, k) stands at
    (corner + (i, j, k)) * cell along `axes` (rows, unit vectors).
    """

    axes: np.ndarray
    cell: float
    corner: np.ndarray
    dense: np.ndarray

    @classmethod
    def of(cls, positions, sections, radii, axes, resolution: int) -> "Smoke":
        """Particles at positions (n, 3) with extinction cross sections (n,) and sprites of radii (n,), laid on axes (3, 3);
        at most `resolution` cells along the longest side.
        """
        some = np.flatnonzero(sections > 0)
        if not len(some):
            return cls(axes, 1.0, np.zeros(3), np.zeros((STEP + 1,) * 3, np.float32))
        local = axes @ np.asarray(positions, np.float64)[some].T  # (3, n): rows are quicker to search than columns
        low, high = local.min(axis=1), local.max(axis=1)
        extent = max(float((high - low).max()), 1e-6 * (1.0 + float(np.abs(local).max())))
        cell = 2.0 ** (np.ceil(np.log2(extent / resolution) * 2.0) / 2.0)
        corner = (np.floor(low / (cell * STEP)) - 1.0) * STEP
        steps = (np.floor(high / (cell * STEP)) - corner / STEP).astype(int) + 2  # cells of the coarsest grid
        shapes = np.zeros((LEVELS, 4), np.int32)
        offset = 0
        for level in range(LEVELS):
            shapes[level, :3] = steps * 2 ** (LEVELS - 1 - level) + 1
            shapes[level, 3] = offset
            offset += int(np.prod(shapes[level, :3].astype(np.int64)))
        place = np.ascontiguousarray((local / cell - corner[:, None]).T, np.float32)
        spread = np.asarray(radii, np.float32)[some] / np.float32(2.2 * SPREAD * cell)
        level = np.clip(np.log2(np.maximum(spread, 1e-6)), 0.0, LEVELS - 1.0).astype(np.float32)
        flat = np.zeros(offset, np.float32)
        lay(place, np.ascontiguousarray(sections[some], np.float32), level, len(some), shapes, flat)
        dense = None
        for shape in shapes[::-1]:
            own = flat[shape[3] : shape[3] + int(np.prod(shape[:3]))].reshape(shape[:3])
            dense = _blurred(own if dense is None else own + _finer(dense))
        return cls(axes, cell, corner, dense)

    def coarse(self, times: int) -> "Smoke":
        """The same smoke on nodes farther apart by a factor 2^times, at most STEP: the same for every shape of cloud."""
        smoke = self
        for _ in range(times):
            smoke = Smoke(self.axes, smoke.cell * 2.0, smoke.corner / 2.0, _coarser(smoke.dense))
        return smoke

    def depth(self, direction) -> np.ndarray:
        """Optical depth at each node of light that travels along `direction` (three of -1, 0, 1 along the axes)."""
        length = np.sqrt(np.count_nonzero(direction))
        return _sweep(self.dense, direction, length / self.cell**2)

    def places(self, positions) -> np.ndarray:
        """(n, 3) float32 where world positions (n, 3) stand, in nodes; kept inside the grid."""
        place = np.asarray(positions, np.float64) @ (self.axes.T / self.cell) - self.corner
        return np.clip(place, 0.0, np.array(self.dense.shape) - 1.001).astype(np.float32)
