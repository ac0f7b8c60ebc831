"""The surface of a liquid from the depths of its nearest spheres, smoothed along rows and columns of the picture.

Each pass fits a line to the depths along a row or a column, weighted by (1 - (d/R)^2)^3 with the distance d, and takes its value
at the pixel. R is a length in the world, so the surface is the same at any size of the picture and from any distance. With
perspective the line is fitted to 1/depth, in which planes are straight. A depth takes part, with a weight that falls to 0, as far
as it differs by a few radii of a particle at most from those before it on its side: other sheets, and drops before the
surface, are skipped.

The narrow range of depths is that of Truong and Yuksel, A Narrow-Range Filter for Screen-Space Fluid Rendering (2018); the
fitted line replaces their weighted mean, which bends the surface near its outline.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.surfaces.scene_numbers import PARALLEL, SCALE
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["STEP_DEPTH", "STEP_SLOPE", "smooth", "spread_lengths"]

TAPS = 8  # depths read on each side at most
PASSES = (1.0, 1.0, 0.4)  # parts of R, each along rows and then along columns
RIDGE = 0.001  # how much a flat line is preferred
STEP_DEPTH = 3.0  # radii by which the depth may change from one tap to the next, and
STEP_SLOPE = 4.0  # by how much more for the distance between them

F1, F2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)


@ti.kernel
def _to_plane(N: F1, depth: F2, out: F2):
    """Depths as what is smoothed: 1/depth with perspective; 0 stays where there is nothing."""
    ti.loop_config(block_dim=1)
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            z = depth[row, column]
            out[row, column] = NEVER
            if z < NEVER:
                out[row, column] = ti.select(N[PARALLEL] > 0.5, z, 1.0 / z)


@ti.func
def _alike(change, limit):
    """1 for no change of depth, falling smoothly to 0 at the limit: a hard limit would leave its own edges on the surface."""
    q = change / limit
    inside = ti.max(1.0 - q * q, 0.0)
    return inside * (2.0 - inside)


@ti.kernel
def _smooth(N: F1, radius: ti.f32, sphere: ti.f32, down: ti.i32, U: F2, out: F2):
    """One pass along rows (down = 0) or columns (down = 1).

    U, out : depths as `_to_plane` leaves them; radius, sphere : R and the particles' radius, m
    """
    ti.loop_config(block_dim=1)
    for row in range(U.shape[0]):
        for column in range(U.shape[1]):
            middle = U[row, column]
            result = middle
            if middle < NEVER:
                # a length as pixels, and as a change of what is smoothed
                pixels, change = N[SCALE], 1.0
                if N[PARALLEL] < 0.5:
                    pixels, change = N[SCALE] * middle, middle * middle
                reach = radius * pixels
                spacing = ti.max(reach / TAPS, 1.0)
                limit = (STEP_DEPTH * sphere + STEP_SLOPE * spacing / pixels) * change
                s0, s1, s2, t0, t1 = 1.0, 0.0, 0.0, 0.0, 0.0
                place, last = column, U.shape[1] - 1
                if down == 1:
                    place, last = row, U.shape[0] - 1
                taps = ti.cast(reach / spacing, ti.i32)
                for side in range(2):
                    before, sign = 0.0, 1 - 2 * side
                    for k in range(1, taps + 1):
                        offset = ti.cast(k, ti.f32) * spacing
                        whole = ti.cast(offset, ti.i32)
                        fraction = offset - ti.cast(whole, ti.f32)
                        i = place + sign * whole
                        j = i + sign * ti.select(fraction > 0.0, 1, 0)
                        if ti.min(i, j) >= 0 and ti.max(i, j) <= last:
                            a, b = 0.0, 0.0
                            if down == 1:
                                a, b = U[i, column], U[j, column]
                            else:
                                a, b = U[row, i], U[row, j]
                            if ti.max(a, b) < NEVER:
                                v = a + (b - a) * fraction - middle
                                alike = _alike(a - b, limit) * _alike(v - before, limit)
                                if alike > 0.0:
                                    before += alike * (v - before)
                                    t = offset / reach
                                    w = 1.0 - t * t
                                    w = w * w * w * alike
                                    x = t * ti.cast(sign, ti.f32)
                                    s0, s1, s2 = s0 + w, s1 + w * x, s2 + w * x * x
                                    t0, t1 = t0 + w * v, t1 + w * x * v
                spread = s0 * s2 - s1 * s1
                shift = (s2 * t0 - s1 * t1 + RIDGE * s0 * t0) / (spread + RIDGE * s0 * s0)
                result = middle + shift
            out[row, column] = result


_plane_kernel, _smooth_kernel = kernel(_to_plane), kernel(_smooth)


def smooth(
    numbers: np.ndarray, depth: np.ndarray, radius: float, sphere: float, scratch: np.ndarray, out: np.ndarray
) -> None:
    """The smoothed surface, as 1/depth with perspective and as depth without, NEVER where there is nothing.

    numbers : of scene_numbers
    depth : (rows, columns) m; scratch, out : of the same shape, written
    radius, sphere : over which it is smoothed, and of the particles, m
    """
    _plane_kernel(numbers, depth, out)
    if radius > 0.0:
        for share in PASSES:
            _smooth_kernel(numbers, share * radius, sphere, 0, out, scratch)
            _smooth_kernel(numbers, share * radius, sphere, 1, scratch, out)


@ti.kernel
def _blur(N: F1, radius: ti.f32, down: ti.i32, U: F2, T: F2, out: F2):
    """Spread the lengths T of liquid, in blocks of 2 x 2 pixels, along rows (down = 0) or columns (down = 1), over `radius` m."""
    ti.loop_config(block_dim=1)
    for row in range(T.shape[0]):
        for column in range(T.shape[1]):
            u, total, weight = (
                U[ti.min(2 * row, U.shape[0] - 1), ti.min(2 * column, U.shape[1] - 1)],
                T[row, column],
                1.0,
            )
            if u < NEVER:
                reach = 0.5 * radius * N[SCALE] * ti.select(N[PARALLEL] > 0.5, 1.0, u)
                spacing = ti.max(reach / TAPS, 1.0)
                place, last = ti.select(down == 1, row, column), ti.select(down == 1, T.shape[0] - 1, T.shape[1] - 1)
                for k in range(1, ti.cast(reach / spacing, ti.i32) + 1):
                    offset = ti.cast(k, ti.f32) * spacing
                    whole = ti.cast(offset, ti.i32)
                    fraction, t = offset - ti.cast(whole, ti.f32), offset / reach
                    w = (1.0 - t * t) ** 3
                    for side in range(2):
                        i = place + (1 - 2 * side) * whole
                        j = i + (1 - 2 * side) * ti.select(fraction > 0.0, 1, 0)
                        if ti.min(i, j) >= 0 and ti.max(i, j) <= last:
                            a, b = T[ti.select(down == 1, i, row), ti.select(down == 1, column, i)], 0.0
                            b = T[ti.select(down == 1, j, row), ti.select(down == 1, column, j)]
                            total += w * (a + (b - a) * fraction)
                            weight += w
            out[row, column] = total / weight


_blur_kernel = kernel(_blur)


def spread_lengths(
    numbers: np.ndarray, surface: np.ndarray, radius: float, lengths: np.ndarray, scratch: np.ndarray
) -> None:
    """Smooth the lengths of liquid in place, over a radius in m.

    surface : of `smooth`; lengths, scratch : (rows / 2, columns / 2)
    """
    for _ in range(2):
        _blur_kernel(numbers, radius, 0, surface, lengths, scratch)
        _blur_kernel(numbers, radius, 1, surface, scratch, lengths)
