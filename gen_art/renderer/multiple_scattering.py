"""Light that smoke scatters many times: discrete ordinates along the 14 directions of Lebedev's rule, on a grid.

With S = albedo (J + D), D the light that arrives straight from lamps and J all other light, each as its mean over directions,

    J = sum over directions of w * (mean in the cell of the light that travels there),

where light that enters a cell of optical depth t with the radiance I has the mean and leaves it with

    S + (I - S) (1 - e^-t) / t,        S + (I - S) e^-t

so that each cell scatters exactly what it takes, and smoke of albedo 1 loses nothing. Light enters at the border as the sky
sends it. Scattering is isotropic; for a mean cosine g of the phase function, the extinction is (1 - albedo g) times the smoke's,
and less of it is scattered (similarity). Cells deeper than about 1 let light diffuse a little too far.

The equation, divided by what each cell does not scatter again itself, is solved on grids of 4, 2 and 1 cells by fixed numbers of
Chebyshev's iterations, each grid beginning with the light of the coarser one. The eigenvalues are real, between that of the
slowest mode in a slab of the smoke's depth, which the coarsest grid takes care of, and 2: no sums over the grid steer the
iteration.
Source: Chandrasekhar, Radiative Transfer (1950); step characteristics: Lathrop, Spatial differencing of the transport
equation (1969); van de Hulst, Multiple Light Scattering (1980), for similarity.

The one-letter names in kernels are in docs/glossary.md.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.array_functions import exp, expm1
from gen_art.renderer.smoke_density import DIRECTIONS, WEIGHTS, Smoke

__all__ = ["albedo_on_nodes", "light_scattered_many_times"]

ITERATIONS = (12, 16, 40)  # on the given grid, on one of twice the cell, and so on
_HIGHEST = 2.0  # not below the largest eigenvalue
_SMOOTH = 0.1  # the least eigenvalue that a grid follows if a coarser one has solved the equation
_SLOWEST = 0.003  # the least eigenvalue for which the iteration is set: a slab of optical depth 30

F1, F2, F3, I2 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.f32, 3), (ti.i32, 2)))


@ti.kernel
def _sweep(S: F2, E: F2, d0: ti.i32, d1: ti.i32, d2: ti.i32, directions: I2, border: F2, I: F3):
    """I[d, node]: the light that enters each node along each direction.

    S : (nodes, 3) what the smoke adds; E : (2, nodes) e^-t along the axes and along the diagonals
    border : (directions, 3) light of the sky
    """
    ti.loop_config(block_dim=1)
    for d in range(directions.shape[0]):
        p, q, r = directions[d, 0], directions[d, 1], directions[d, 2]
        diagonal = ti.select(abs(p) + abs(q) + abs(r) > 1, 1, 0)
        for a in range(d0):
            i = ti.select(p < 0, d0 - 1 - a, a)
            for b in range(d1):
                j = ti.select(q < 0, d1 - 1 - b, b)
                for c in range(d2):
                    k = ti.select(r < 0, d2 - 1 - c, c)
                    before_i, before_j, before_k = i - p, j - q, k - r
                    node = (i * d1 + j) * d2 + k
                    inside = before_i >= 0 and before_j >= 0 and before_k >= 0
                    inside = inside and before_i < d0 and before_j < d1 and before_k < d2
                    if inside:
                        before = (before_i * d1 + before_j) * d2 + before_k
                        passed = E[diagonal, before]
                        for e in ti.static(range(3)):
                            I[d, node, e] = S[before, e] + (I[d, before, e] - S[before, e]) * passed
                    else:
                        for e in ti.static(range(3)):
                            I[d, node, e] = border[d, e]


@ti.kernel
def _mean(S: F2, G: F2, weights: F1, nodes: ti.i32, I: F3, out: F2):
    """out: the mean of the light over all directions in each node. G : (2, nodes) (1 - e^-t) / t."""
    ti.loop_config(block_dim=1)
    for block in range((nodes + 1023) // 1024):
        for node in range(block * 1024, ti.min((block + 1) * 1024, nodes)):
            for e in ti.static(range(3)):
                total = 0.0
                for d in range(weights.shape[0]):
                    kept = G[ti.select(d < 6, 0, 1), node]
                    total += weights[d] * (S[node, e] + (I[d, node, e] - S[node, e]) * kept)
                out[node, e] = total


_sweep_kernel, _mean_kernel = kernel(_sweep), kernel(_mean)


class _Transport:
    """The means over directions of the light of any sources in one grid of smoke."""

    def __init__(self, smoke: Smoke, part: float):
        """part : factor on the extinction."""
        self.shape = smoke.extinction.shape
        nodes = smoke.extinction.size
        depth = smoke.extinction.reshape(1, -1) * (part / smoke.cell**2 * np.array([[1.0], [np.sqrt(3.0)]]))
        self.kept = np.where(depth > 1e-6, -expm1(-depth) / np.maximum(depth, 1e-30), 1.0).astype(np.float32)
        self.passed = exp(-depth).astype(np.float32)
        self.directions, self.weights = DIRECTIONS.astype(np.int32), WEIGHTS.astype(np.float32)
        self.entering = np.zeros((len(WEIGHTS), nodes, 3), np.float32)
        # the part of a cell's light that it scatters again itself
        self.own = 1.0 - (WEIGHTS[:6].sum() * self.kept[0] + WEIGHTS[6:].sum() * self.kept[1]).astype(np.float32)
        through = depth[0].reshape(self.shape)
        thickness = min(float(through.sum(axis=axis).max()) for axis in range(3))
        # 1 - the largest eigenvalue of scattering in a slab, whose edges lie 0.71 beyond its sides on each side
        self.slowest = min(max(np.pi**2 / 3.0 / (thickness + 1.42) ** 2, _SLOWEST), 0.7)

    def mean(self, sources: np.ndarray, border: np.ndarray) -> np.ndarray:
        out = np.zeros_like(sources)
        _sweep_kernel(sources, self.passed, *self.shape, self.directions, border, self.entering)
        _mean_kernel(sources, self.kept, self.weights, len(sources), self.entering, out)
        return out

    def solve(self, guess, albedo, direct, border, iterations: int, slowest: float) -> np.ndarray:
        """J, (nodes, 3), after some of Chebyshev's iterations for (1 - mean albedo) J = mean(albedo D, border).

        slowest : the least eigenvalue that they are set for
        """
        dark = np.zeros_like(border)
        given = self.mean(albedo * direct, border)
        middle, half = 0.5 * (_HIGHEST + slowest), 0.5 * (_HIGHEST - slowest)
        light = guess
        # divided by what is left of a cell's own light: the light of dense cells converges as fast as that of thin ones
        scale = 1.0 / np.maximum(1.0 - albedo * self.own[:, None], np.float32(1e-3))
        residual = scale * (given - light + self.mean(albedo * light, dark))
        rho = half / middle
        step = residual * np.float32(1.0 / middle)
        for _ in range(iterations):
            light = light + step
            residual = scale * (given - light + self.mean(albedo * light, dark))
            next_rho = 1.0 / (2.0 * middle / half - rho)
            step = step * np.float32(next_rho * rho) + residual * np.float32(2.0 * next_rho / half)
            rho = next_rho
        return np.maximum(light + step, np.float32(0.0))


def light_scattered_many_times(
    smoke: Smoke, albedo: np.ndarray, asymmetry: float, direct: np.ndarray, sky: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """J, (nodes, 3) float32: the mean over directions of all light but the lamps' own, at the nodes of smoke.

    albedo : (nodes, 3) or (3,), 0..1
    asymmetry : g, the mean cosine of the phase function
    direct : D, (nodes, 3)
    sky : the radiance (3,) that comes from a unit direction (3,)
    """
    border = np.array([sky(-(d / np.linalg.norm(d)) @ smoke.axes) for d in DIRECTIONS], np.float32)
    scattered = np.broadcast_to(np.asarray(albedo, np.float32), direct.shape)
    grey = float(scattered.mean())
    part = 1.0 - grey * asymmetry
    scattered = np.minimum(scattered * np.float32((1.0 - asymmetry) / part), np.float32(1.0))
    shape = smoke.extinction.shape
    smoke = _padded(smoke)
    padded = smoke.extinction.shape
    grids = [(smoke, _resized(scattered, shape, padded), _resized(direct, shape, padded))]
    for _ in ITERATIONS[1:]:
        fine, of_scattered, of_direct = grids[-1]
        nodes = fine.extinction.shape
        grids.append((fine.coarse(1), _every_other(of_scattered, nodes), _every_other(of_direct, nodes)))
    light, previous = None, padded
    for (grid, of_scattered, of_direct), iterations in zip(grids[::-1], ITERATIONS[::-1]):
        if light is None:
            light = np.broadcast_to(np.float32(WEIGHTS) @ border, of_direct.shape).astype(np.float32)
        else:
            light = _between(light, previous)
        transport = _Transport(grid, part)
        slowest = transport.slowest if grid is grids[-1][0] else max(transport.slowest, _SMOOTH)
        light = transport.solve(light, of_scattered, of_direct, border, iterations, slowest)
        previous = grid.extinction.shape
    assert light is not None
    return _resized(light, padded, shape)


def _padded(smoke: Smoke) -> Smoke:
    """The smoke on a grid whose nodes allow every coarser grid, with empty nodes at the ends."""
    times = 2 ** (len(ITERATIONS) - 1)
    more = [(0, -(n - 1) % times) for n in smoke.extinction.shape]
    return replace(smoke, extinction=np.pad(smoke.extinction, more))


def _resized(table: np.ndarray, shape, wanted) -> np.ndarray:
    """A table (nodes, 3) of one grid on a grid with more or fewer nodes at the ends; those that are new have 0."""
    out = np.zeros((*wanted, 3), np.float32)
    both = tuple(slice(min(a, b)) for a, b in zip(shape, wanted))
    out[both] = table.reshape(*shape, 3)[both]
    return out.reshape(-1, 3)


def _every_other(table: np.ndarray, shape) -> np.ndarray:
    """The values (nodes, 3) at every other node along each axis, smoothed by 1-2-1."""
    grid = table.reshape(*shape, 3)
    for axis in range(3):
        a = np.moveaxis(grid, axis, 0)
        out = 0.5 * a[::2]
        out[1:] += 0.25 * a[1::2]
        out[:-1] += 0.25 * a[1::2]
        out[0] += 0.25 * a[0]
        out[-1] += 0.25 * a[-1]
        grid = np.moveaxis(out, 0, axis)
    return np.ascontiguousarray(grid.reshape(-1, 3), np.float32)


def _between(table: np.ndarray, shape) -> np.ndarray:
    """The values at nodes half as far apart, linear in between."""
    grid = table.reshape(*shape, 3)
    for axis in range(3):
        a = np.moveaxis(grid, axis, 0)
        finer = np.empty((2 * len(a) - 1, *a.shape[1:]), np.float32)
        finer[::2], finer[1::2] = a, np.float32(0.5) * (a[:-1] + a[1:])
        grid = np.moveaxis(finer, 0, axis)
    return np.ascontiguousarray(grid.reshape(-1, 3))


def albedo_on_nodes(smoke: Smoke, positions, cross_sections, albedos) -> np.ndarray:
    """(nodes, 3) or (3,) float32: the mean albedo of the particles around each node of smoke, by their cross sections.

    albedos : (n, 3), NaN where it is not known; those particles count as the mean of the others
    """
    known = np.isfinite(albedos).all(axis=1) & (cross_sections > 0.0)
    if not known.any():
        return np.ones(3, np.float32)
    mean = np.array(
        [
            np.bincount(np.zeros(int(known.sum()), np.int64), (cross_sections[known] * albedos[known, c]))[0]
            for c in range(3)
        ]
    )
    mean = np.clip(mean / np.bincount(np.zeros(int(known.sum()), np.int64), cross_sections[known])[0], 0.0, 1.0)
    if np.ptp(albedos[known], axis=0).max() < 2e-3:
        return mean.astype(np.float32)
    shape = smoke.extinction.shape
    nodes = smoke.to_nodes(positions[known]).astype(np.float64)
    first = nodes.astype(np.int64)
    fraction = nodes - first
    weight, sums = np.full(smoke.extinction.size, 1e-30), np.outer(np.full(smoke.extinction.size, 1e-30), mean)
    for corner in np.ndindex(2, 2, 2):
        place = first + corner
        index = (place[:, 0] * shape[1] + place[:, 1]) * shape[2] + place[:, 2]
        share = cross_sections[known] * np.where(corner, fraction, 1.0 - fraction).prod(axis=1)
        weight += np.bincount(index, share, len(weight))
        for c in range(3):
            sums[:, c] += np.bincount(index, share * albedos[known, c], len(weight))
    return np.clip(sums / weight[:, None], 0.0, 1.0).astype(np.float32)
