"""Soft discs stretched to ellipses: what a particle's ellipsoid looks like, and how its light is spread over pixels.

The ellipsoid has the volume of the particle's ball. By motion it is k^(2/3) times as long along a unit vector d, and k^(-1/3)
times as wide across it; by neighbours it has the shape that neighbour_shapes.py finds. Along the line of sight its density adds
up to that of a Gaussian, whose covariance is the ellipsoid's without its row and column ahead. The covariance of the narrowest
disc is added to it, so that none is too narrow for the pixels, at any size.

The kernel of an ellipse is g(t) of sprite.py, t^2 = (u / width)^2 + ((v - slope u) / height)^2 with u and v from its middle. Its
weights are divided by their sum, as those of all sprites.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp, log
from gen_art.particles.rows import VX, VY, VZ
from gen_art.renderer.look_tables import AXES, ORTHOGRAPHIC, SCALE
from gen_art.renderer.sprite import (
    ACROSS,
    ALPHA,
    BLUE,
    BOTTOM,
    COARSE_VARIANCE,
    COVERED_DISC,
    DEPTH,
    DISC,
    DX,
    DY,
    EDGE,
    ELLIPSE,
    FOOTPRINT,
    FOOTPRINT_PER_RADIUS,
    GREEN,
    KERNEL_VARIANCE,
    KIND,
    LEFT,
    LEVEL,
    MIN_FOOTPRINT,
    NORM,
    RED,
    RIGHT,
    SLOPE,
    SPHERE,
    THICKNESS,
    TOP,
    X,
    Y,
)
from gen_art.renderer.sprite_rows import axis_sum, choose_level, rim_sum
from gen_art.renderer.surfaces.hiding import BEFORE, BEHIND, place_among_surfaces

__all__ = ["draw_ellipse", "ellipses_of_motion", "ellipses_of_shapes", "write_ellipses"]

XX, XY, YY = range(3)  # rows of ellipses: covariance on the picture, to the right and down, divided by that of the disc
ROUND = 1e-3  # an ellipse that is as round as this is a disc
ROUND_VARIANCE = 0.0846  # of the kernel of an ellipse of width and height 1; a disc's is KERNEL_VARIANCE
SIDE = 8  # pixels along the side of a tile of tiled_splat.py
BLOCK = 2048  # particles per iteration of the parallel loop

F1, F2, F3, F64 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.f32, 3), (ti.f64, 1)))
H2, REAL2 = ti.types.ndarray(ti.i16, 2), ti.types.ndarray(ndim=2)


@ti.func
def sharp_footprint(footprint):
    """A disc's footprint without the least one, which was added to it in squares."""
    return ti.sqrt(ti.max(footprint * footprint - MIN_FOOTPRINT * MIN_FOOTPRINT, 0.0))


@ti.kernel
def _of_motion(S: REAL2, C: F2, n: ti.i32, Q: F64, seconds: ti.f32, most: ti.f32, E: F2):
    """The ellipses of discs that are swept along their velocity for some time.

    A disc of standard deviation s that moves by l has the deviation sqrt(s^2 + l^2 / 12) along its way.
    """
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        scale, parallel = ti.cast(Q[SCALE], ti.f32), Q[ORTHOGRAPHIC] > 0.5
        a = ti.Vector([ti.cast(Q[AXES + k], ti.f32) for k in range(9)])
        for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, n)):
            E[XX, i], E[XY, i], E[YY, i] = 1.0, 0.0, 1.0
            u, v, w = ti.cast(S[VX, i], ti.f32), ti.cast(S[VY, i], ti.f32), ti.cast(S[VZ, i], ti.f32)
            speed, footprint = ti.sqrt(u * u + v * v + w * w), sharp_footprint(C[FOOTPRINT, i])
            if C[FOOTPRINT, i] > 0.0 and footprint > 0.0 and speed > 0.0 and speed < 1e18:
                pixels = scale
                if not parallel:
                    pixels /= C[DEPTH, i]
                way = speed * seconds * pixels / footprint
                k = ti.min(ti.sqrt(1.0 + way * way / (12.0 * KERNEL_VARIANCE)), most)
                across = exp(log(k) * (-2.0 / 3.0))  # the variance; that along the way is k^2 times as large
                x, y = (a[0] * u + a[1] * v + a[2] * w) / speed, -(a[3] * u + a[4] * v + a[5] * w) / speed
                longer = across * (k * k - 1.0)
                E[XX, i], E[XY, i], E[YY, i] = across + longer * x * x, longer * x * y, across + longer * y * y


@ti.kernel
def _of_shapes(shapes: F2, n: ti.i32, Q: F64, E: F2):
    """The ellipses of ellipsoids, (n, 6) xx, yy, zz, xy, xz, yz of their covariances divided by that of the disc."""
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        right = ti.Vector([ti.cast(Q[AXES + k], ti.f32) for k in range(3)])
        down = -ti.Vector([ti.cast(Q[AXES + 3 + k], ti.f32) for k in range(3)])
        for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, n)):
            s = ti.Vector([shapes[i, k] for k in range(6)])
            rows = ti.Matrix([[s[0], s[3], s[4]], [s[3], s[1], s[5]], [s[4], s[5], s[2]]])
            of_right, of_down = rows @ right, rows @ down
            E[XX, i], E[XY, i], E[YY, i] = right.dot(of_right), right.dot(of_down), down.dot(of_down)


@ti.func
def _kernel(square):
    """g(t) from t^2, 0 beyond 1."""
    s = ti.min(square, 1.0)
    a = 1.0 - 0.3125 * s
    a2 = a * a
    a4, b = a2 * a2, 1.0 - s
    return a4 * a4 * (b * b)


@ti.func
def _sum(x, y, width, height, slope):
    """The sum of an ellipse's weights over all pixel centres."""
    total = 0.0
    for m in range(ti.cast(ti.floor(x - width), ti.i32), ti.cast(ti.floor(x + width), ti.i32) + 1):
        u = ti.cast(m, ti.f32) + 0.5 - x
        middle, square = y + slope * u, (u / width) * (u / width)
        for n in range(ti.cast(ti.floor(middle - height), ti.i32), ti.cast(ti.floor(middle + height), ti.i32) + 1):
            v = (ti.cast(n, ti.f32) + 0.5 - middle) / height
            total += _kernel(square + v * v)
    return total


@ti.kernel
def _write_ellipses(
    C: F2, E: F2, n: ti.i32, P: F2, headers: H2, depths: F1, base: ti.i32, width: ti.i32, height: ti.i32, surface_bins: F3,
    surface_tiles: F3,
    pixel: ti.f32, parallel: ti.i32,
):  # fmt: skip
    """Fill sprite rows base.. from n particles, as `write_sprites` does from discs.

    E : (3, n) ellipses
    """
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        for c in range(block * BLOCK, ti.min((block + 1) * BLOCK, n)):
            i = base + c
            headers[i, TOP], headers[i, BOTTOM], headers[i, LEVEL] = ti.i16(1), ti.i16(0), ti.i16(0)
            headers[i, KIND] = ti.cast(ELLIPSE, ti.i16)
            depths[i] = C[DEPTH, c]
            x, y, footprint, edge = C[X, c], C[Y, c], C[FOOTPRINT, c], C[EDGE, c]
            sharp, least = sharp_footprint(footprint), MIN_FOOTPRINT * MIN_FOOTPRINT
            xx, xy, yy = E[XX, c] * sharp * sharp + least, E[XY, c] * sharp * sharp, E[YY, c] * sharp * sharp + least
            mean, spread = 0.5 * (xx + yy), ti.sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy)
            wide, partly_hidden = ti.sqrt(KERNEL_VARIANCE / ROUND_VARIANCE * (mean + spread)), 0.0
            if edge > 0.0:
                wide = footprint + edge
            if surface_bins.shape[0] > 0 and footprint > 0.0:
                thickness = footprint / FOOTPRINT_PER_RADIUS * pixel * ti.select(parallel == 1, 1.0, C[DEPTH, c])
                among = place_among_surfaces(surface_bins, surface_tiles, x, y, wide, C[DEPTH, c], thickness)
                if among == BEHIND:
                    footprint = -1.0
                elif among != BEFORE:
                    partly_hidden = thickness
            if footprint > 0.0:
                level, kind, slope, across = 0, ELLIPSE, 0.0, 0.0
                left, right, top, bottom = x, x, y, y
                if edge > 0.0:  # out of focus: an even disc
                    kind, across = SPHERE, footprint
                    P[i, NORM] = 1.0 / ti.max(rim_sum(x, y, footprint, edge), 1e-30)
                    left, right, top, bottom = x - wide, x + wide, y - wide, y + wide
                else:
                    if partly_hidden == 0.0:  # smaller framebuffers have no depths of surfaces
                        level, _footprint = choose_level(ti.sqrt(ti.max(mean - spread, 0.0)), -edge)
                    for k in range(level):  # less the variance that bilinear weights add
                        xx, xy, yy = 0.25 * xx, 0.25 * xy, 0.25 * yy
                        xx, yy = xx - COARSE_VARIANCE / KERNEL_VARIANCE, yy - COARSE_VARIANCE / KERNEL_VARIANCE
                    kind = ti.select(ti.max(abs(xy), abs(xx - yy)) < ROUND * (xx + yy), DISC, ELLIPSE)
                    scale, wider = 1.0 / ti.cast(1 << level, ti.f32), KERNEL_VARIANCE / ROUND_VARIANCE
                    x, y, footprint, slope = x * scale, y * scale, ti.sqrt(wider * xx), xy / xx
                    across = ti.sqrt(wider * (yy - xy * slope))
                    if kind == DISC:
                        footprint = ti.sqrt(0.5 * (xx + yy))
                        slope, across = 0.0, footprint
                    total = axis_sum(x, footprint) * axis_sum(y, footprint)
                    if kind == ELLIPSE:
                        total = _sum(x, y, footprint, across, slope)
                    P[i, NORM] = scale * scale / total
                    tall = across + abs(slope) * footprint
                    left, right, top, bottom = x - footprint, x + footprint, y - tall, y + tall
                P[i, X], P[i, Y], P[i, FOOTPRINT], P[i, EDGE] = x, y, footprint, edge
                P[i, DX], P[i, DY], P[i, SLOPE], P[i, ACROSS], P[i, THICKNESS] = 0.0, 0.0, slope, across, partly_hidden
                for e in ti.static((RED, GREEN, BLUE, ALPHA)):
                    P[i, e] = C[e, c]
                rounding = (1 << level) - 1
                w, h = ti.cast((width + rounding) >> level, ti.f32), ti.cast((height + rounding) >> level, ti.f32)
                left, right = ti.floor(ti.max(left, 0.0)), ti.floor(ti.min(right, w - 0.5))
                top, bottom = ti.floor(ti.max(top, 0.0)), ti.floor(ti.min(bottom, h - 0.5))
                if right >= left and bottom >= top:
                    headers[i, LEFT], headers[i, RIGHT] = ti.cast(left, ti.i16), ti.cast(right, ti.i16)
                    headers[i, TOP], headers[i, BOTTOM] = ti.cast(top, ti.i16), ti.cast(bottom, ti.i16)
                if kind == DISC and partly_hidden > 0.0:
                    kind = COVERED_DISC
                headers[i, LEVEL], headers[i, KIND] = ti.cast(level, ti.i16), ti.cast(kind, ti.i16)


@ti.func
def draw_ellipse(P: ti.template(), i, tile: ti.template(), x, y, top, bottom):
    """Blend an ellipse into a tile of SIDE x SIDE pixels; x and y are measured from the tile's corner.

    Seen along its length it is smaller than the disc: there its coverage could pass 1, where it is held.
    """
    inverse, per_height, slope, norm = 1.0 / P[i, FOOTPRINT], 1.0 / P[i, ACROSS], P[i, SLOPE], P[i, NORM]
    r, g, b, a = P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA]
    light, middle = ti.Vector([0.0] * (4 * SIDE)), ti.Vector([0.0] * (4 * SIDE))
    square, most = ti.Vector([0.0] * (4 * SIDE)), ti.Vector([0.0] * (4 * SIDE))
    for j in range(4 * SIDE):
        u, c = ti.cast(j >> 2, ti.f32) + 0.5 - x, j & 3
        light[j] = norm * ti.select(c == 0, r, ti.select(c == 1, g, ti.select(c == 2, b, a)))
        square[j], middle[j] = (u * inverse) * (u * inverse), y + slope * u - 0.5
        most[j] = ti.select(c == 3, 1.0, 1e38)
    coverage = norm * a
    for row in range(top, bottom):
        for j in range(4 * SIDE):
            v = (ti.cast(row, ti.f32) - middle[j]) * per_height
            w, old = _kernel(square[j] + v * v), tile[row * 4 * SIDE + j]
            tile[row * 4 * SIDE + j] = old * (1.0 - ti.min(w * coverage, 1.0)) + ti.min(w * light[j], most[j])


_motion_kernel, _shapes_kernel, write_ellipses = kernel(_of_motion), kernel(_of_shapes), kernel(_write_ellipses)


def ellipses_of_motion(projected, system, numbers: np.ndarray, seconds: float, most: float) -> np.ndarray:
    """(3, n) ellipses of projected discs that are swept along their velocity for some simulated seconds.

    numbers : of look_tables.kernel_numbers
    most : the largest ratio of length to width
    """
    n = projected.count
    ellipses = np.empty((3, max(n, 1)), np.float32)
    if n:
        _motion_kernel(system.floats, projected.channels, n, numbers, seconds, most, ellipses)
    return ellipses


def ellipses_of_shapes(projected, numbers: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """(3, n) ellipses of projected discs that are ellipsoids.

    numbers : of look_tables.kernel_numbers
    shapes : (n, 6) of neighbour_shapes
    """
    n = projected.count
    ellipses = np.empty((3, max(n, 1)), np.float32)
    if n:
        _shapes_kernel(shapes, n, numbers, ellipses)
    return ellipses
