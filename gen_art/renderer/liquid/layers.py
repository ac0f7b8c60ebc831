"""What the particles of a liquid are in each pixel: the nearest of their spheres, and how much liquid the pixel's ray crosses.

A particle's sphere covers a pixel by as much as the sphere's outline is beyond the pixel's middle, so edges are smooth. Its
volume is spread over the ellipsoid's chord: the sum over all particles, divided by the share of space that spheres fill in the
liquid (packing.py), is the length of liquid along the ray. It is found for blocks of 2 x 2 pixels, being smooth.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.liquid.particle_bins import BIN, LEAST_REACH, NEAREST, ParticleBins, outline
from gen_art.renderer.surfaces.scene_numbers import PARALLEL, ROWS, SCALE, WIDTH
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["COLOURS", "PixelLayers", "SPREAD"]

COLOURS = 6  # albedo and emission
SPREAD = 2.0  # radii over which a particle's colour is spread

F1, F2, F3, I1 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.f32, 3), (ti.i32, 1)))


@ti.func
def _box(N: ti.template(), entries: ti.template(), e, radius, margin, side, ox, oy, width, rows):
    """(4,) first and last column and row of those of a bin's blocks whose middles a ball of this radius may cover.

    margin : pixels around it; side : pixels along a block; ox, oy : first pixel of the bin; width, rows : blocks in the bin
    """
    z = entries[e, 2]
    near, scale = radius, N[SCALE]
    if N[PARALLEL] < 0.5:
        near, scale = ti.min(radius, z / NEAREST), N[SCALE] / z
    x0, x1 = outline(entries[e, 0], N[WIDTH], z, near, scale, N[SCALE], N[PARALLEL])
    y0, y1 = outline(entries[e, 1], N[ROWS], z, near, scale, N[SCALE], N[PARALLEL])
    result = ti.Vector([0, 0, 0, 0])
    ends, origin, last = ti.Vector([x0, x1, y0, y1]), ti.Vector([ox, ox, oy, oy]), ti.Vector([width, width, rows, rows])
    for k in ti.static(range(4)):
        sign = ti.static(1.0 if k % 2 else -1.0)
        block = (ends[k] + sign * margin - ti.cast(origin[k], ti.f32)) / side - 0.5
        block = ti.min(ti.max(block, -1.0), ti.cast(BIN, ti.f32))
        if ti.static(k % 2):
            result[k] = ti.min(ti.max(ti.cast(ti.floor(block), ti.i32), -1), last[k] - 1)
        else:
            result[k] = ti.min(ti.max(ti.cast(ti.ceil(block), ti.i32), 0), last[k])
    return result


@ti.func
def _ray_past(N: ti.template(), entries: ti.template(), e, per_pixel, x, y):
    """How the ray through a place of the picture passes a particle.

    per_pixel : length of a pixel at its depth
    Returns the square of its distance from the middle, the depth of the point nearest to the middle, and 1 over the square of the
    length of the ray's direction per depth.
    """
    ex, ey = (x - entries[e, 0]) * per_pixel, (y - entries[e, 1]) * per_pixel
    past2, middle, inverse = ex * ex + ey * ey, entries[e, 2], 1.0
    if N[PARALLEL] < 0.5:
        per_depth = per_pixel / middle
        dx, dy = (x - 0.5 * N[WIDTH]) * per_depth, (y - 0.5 * N[ROWS]) * per_depth
        inverse = 1.0 / (1.0 + dx * dx + dy * dy)
        along = ex * dx + ey * dy
        past2 -= along * along * inverse
        middle -= along * inverse
    return past2, middle, inverse


@ti.kernel
def _find_layers(
    N: F1, across: ti.i32, down: ti.i32, starts: I1, entries: F2, per_volume: ti.f32, depth: F2, rim: F2, cover: F2,
    thickness: F2,
):  # fmt: skip
    """Fill the arrays of PixelLayers.

    rim : scratch, the nearest depth of outlines that reach a pixel and not its middle
    per_volume : 1 over the share of space that the spheres fill
    """
    ti.loop_config(block_dim=1)
    for bin in range(across * down):
        ox, oy = (bin % across) * BIN, (bin // across) * BIN
        width, rows = ti.min(ti.cast(N[WIDTH], ti.i32) - ox, BIN), ti.min(ti.cast(N[ROWS], ti.i32) - oy, BIN)
        half_width, half_rows = (width + 1) // 2, (rows + 1) // 2
        for v in range(rows):
            for u in range(width):
                depth[oy + v, ox + u], rim[oy + v, ox + u], cover[oy + v, ox + u] = NEVER, NEVER, 0.0
        for v in range(half_rows):
            for u in range(half_width):
                thickness[oy // 2 + v, ox // 2 + u] = 0.0
        for e in range(starts[bin], starts[bin + 1]):
            z, radius = entries[e, 2], entries[e, 3]
            pixels = ti.select(N[PARALLEL] > 0.5, N[SCALE], N[SCALE] / z)
            # a sphere smaller than a pixel covers it by its area
            drawn = ti.max(radius, 0.5 / pixels)
            share = ti.min((radius / drawn) ** 2, 1.0)
            outer2 = (drawn + 0.5 / pixels) ** 2
            box = _box(N, entries, e, drawn, 0.5, 1.0, ox, oy, width, rows)
            for row in range(oy + box[2], oy + box[3] + 1):
                for column in range(ox + box[0], ox + box[1] + 1):
                    past2, middle, inverse = _ray_past(
                        N, entries, e, 1.0 / pixels, ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5
                    )
                    if past2 < outer2 and (cover[row, column] < share or middle - drawn < depth[row, column]):
                        beyond = (drawn - ti.sqrt(ti.max(past2, 0.0))) * pixels + 0.5
                        nearest = middle - ti.sqrt(ti.max(drawn * drawn - past2, 0.0) * inverse)
                        cover[row, column] = ti.max(cover[row, column], ti.min(beyond, 1.0) * share)
                        if beyond >= 0.5:
                            depth[row, column] = ti.min(depth[row, column], nearest)
                        else:
                            rim[row, column] = ti.min(rim[row, column], nearest)
            # the liquid that it stands for: the chord of the sphere, or of a wider ellipsoid of the same volume
            drawn = ti.max(radius, LEAST_REACH / pixels)
            amount = 2.0 * radius * (radius / drawn) ** 2 * per_volume
            box = _box(N, entries, e, drawn, 0.0, 2.0, ox, oy, half_width, half_rows)
            for row in range(oy // 2 + box[2], oy // 2 + box[3] + 1):
                for column in range(ox // 2 + box[0], ox // 2 + box[1] + 1):
                    past2, middle, inverse = _ray_past(
                        N,
                        entries,
                        e,
                        1.0 / pixels,
                        2.0 * ti.cast(column, ti.f32) + 1.0,
                        2.0 * ti.cast(row, ti.f32) + 1.0,
                    )
                    inside = 1.0 - past2 / (drawn * drawn)
                    if inside > 0.0:
                        thickness[row, column] = thickness[row, column] + amount * ti.sqrt(inside)
        for v in range(rows):
            for u in range(width):
                if depth[oy + v, ox + u] >= NEVER:
                    depth[oy + v, ox + u] = rim[oy + v, ox + u]


@ti.kernel
def _spread_colours(
    N: F1, across: ti.i32, down: ti.i32, starts: I1, entries: F2, particles: I1, P: F2, depth: F2, colours: F3
):  # fmt: skip
    """Fill `colours`, (rows, columns, COLOURS + 1), with the mean of P, (particles, COLOURS), near each pixel's surface."""
    ti.loop_config(block_dim=1)
    for bin in range(across * down):
        ox, oy = (bin % across) * BIN, (bin // across) * BIN
        width, rows = ti.min(ti.cast(N[WIDTH], ti.i32) - ox, BIN), ti.min(ti.cast(N[ROWS], ti.i32) - oy, BIN)
        for v in range(rows):
            for u in range(width):
                for c in range(COLOURS + 1):
                    colours[oy + v, ox + u, c] = 0.0
        for e in range(starts[bin], starts[bin + 1]):
            z, radius, i = entries[e, 2], entries[e, 3], particles[e]
            pixels = ti.select(N[PARALLEL] > 0.5, N[SCALE], N[SCALE] / z)
            drawn = ti.max(radius * SPREAD, LEAST_REACH / pixels)
            box = _box(N, entries, e, drawn, 0.0, 1.0, ox, oy, width, rows)
            for row in range(oy + box[2], oy + box[3] + 1):
                for column in range(ox + box[0], ox + box[1] + 1):
                    past2, middle, _ = _ray_past(
                        N, entries, e, 1.0 / pixels, ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5
                    )
                    below = (middle - depth[row, column]) / drawn - 0.5
                    inside = 1.0 - past2 / (drawn * drawn) - below * below
                    if inside > 0.0:
                        weight = inside * inside
                        for c in range(COLOURS):
                            colours[row, column, c] = colours[row, column, c] + weight * P[i, c]
                        colours[row, column, COLOURS] = colours[row, column, COLOURS] + weight
        for v in range(rows):
            for u in range(width):
                weight = colours[oy + v, ox + u, COLOURS]
                if weight > 0.0:
                    for c in range(COLOURS):
                        colours[oy + v, ox + u, c] = colours[oy + v, ox + u, c] / weight


@ti.kernel
def _fill_inside(cover: F2):
    """Cover pixels wholly that spheres cover in parts, where the middles of the four neighbours are covered, too.

    Only what is half covered or more changes, and only that is asked for: the order of the pixels changes nothing.
    """
    ti.loop_config(block_dim=1)
    for row in range(cover.shape[0]):
        for column in range(cover.shape[1]):
            if cover[row, column] >= 0.5 and cover[row, column] < 1.0:
                open_sides = 0
                for k in ti.static(range(4)):
                    i = row + ti.static((1, -1, 0, 0)[k])
                    j = column + ti.static((0, 0, 1, -1)[k])
                    if i >= 0 and j >= 0 and i < cover.shape[0] and j < cover.shape[1]:
                        open_sides += ti.select(cover[i, j] < 0.5, 1, 0)
                if open_sides == 0:
                    cover[row, column] = 1.0


_find_kernel, _colours_kernel, _inside_kernel = map(kernel, (_find_layers, _spread_colours, _fill_inside))


class PixelLayers:
    """What a liquid is in each pixel of pictures of one size.

    depth : (rows, columns) float32, distance along the line of sight to the nearest sphere, NEVER where there is none
    cover : (rows, columns) the share of the pixel that it covers
    thickness : (rows / 2, columns / 2) m of liquid along the ray through the middle of 2 x 2 pixels
    colours : (rows, columns, COLOURS + 1) albedo and emission where they differ from particle to particle, or (1, 1, ...)
    """

    def __init__(self, size: tuple[int, int]):
        rows, columns = size[1], size[0]
        self.depth, self.cover, self._rim = (np.zeros((rows, columns), np.float32) for _ in range(3))
        self.thickness = np.zeros(((rows + 1) // 2, (columns + 1) // 2), np.float32)
        self.colours = np.zeros((1, 1, COLOURS + 1), np.float32)

    def find(self, numbers: np.ndarray, bins: ParticleBins, per_volume: float) -> None:
        """Fill depth, cover and thickness."""
        _find_kernel(
            numbers, bins.across, bins.down, bins.starts, bins.entries, per_volume, self.depth, self._rim, self.cover,
            self.thickness,
        )  # fmt: skip
        _inside_kernel(self.cover)

    def spread(self, numbers: np.ndarray, bins: ParticleBins, paints: np.ndarray) -> None:
        """Fill colours from those of the particles, (particles, COLOURS)."""
        if self.colours.shape[:2] != self.depth.shape:
            self.colours = np.zeros((*self.depth.shape, COLOURS + 1), np.float32)
        _colours_kernel(
            numbers, bins.across, bins.down, bins.starts, bins.entries, bins.particles, paints, self.depth, self.colours
        )
