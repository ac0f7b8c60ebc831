"""Discs, ellipses, streaks and their pieces drawn into the tiles of the framebuffer by whole vectors.

A tile of 8 x 8 pixels is sixteen vectors of four pixels (RGBA), which stay in the processor's registers from its first sprite to
its last. Weights are found for the eight pixels of a row, or of a column, at once. Sprites that no surface hides have the bits of
tiled_splat.py.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from functools import cache

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.lanes import LANES, all_lanes
from gen_art.renderer.picture_tiles import BIN, TILE, TILES
from gen_art.renderer.pixel_rows import (
    CENTRES,
    EDGES,
    larger,
    piece_row,
    row_of,
    row_profile,
    row_share,
    row_smooth_step,
    row_streak_profile,
    smaller,
)
from gen_art.renderer.sprite import (
    ACROSS,
    ALPHA,
    BLUE,
    BOTTOM,
    COVERED_DISC,
    DISC,
    DX,
    DY,
    ELLIPSE,
    FOOTPRINT,
    GREEN,
    KIND,
    MIN_STREAK_FOOTPRINT,
    NORM,
    PIECE,
    RED,
    SLOPE,
    STREAK,
    TAIL,
    TAPER,
    THICKNESS,
    TOP,
    X,
    Y,
)
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS

__all__ = ["VECTOR_KINDS", "draw_kernel"]

VECTOR_KINDS = frozenset({DISC, COVERED_DISC, ELLIPSE, STREAK, PIECE})
PIXELS = LANES // 4  # of a vector
PARTS = TILE // PIXELS  # vectors in a row of a tile
F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, H2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i16, 2)
FLOATS = ti.types.ndarray(ti.types.vector(LANES, ti.f32), 1)
_LIMITS = (1e38, 1e38, 1e38, 1.0) * PIXELS  # of the light and coverage that an ellipse adds


@ti.func
def _pixels(row, part: ti.template()):
    """The lanes of four pixels of a row, each in all four lanes of its pixel."""
    return ti.Vector([row[part * PIXELS + lane // 4] for lane in ti.static(range(LANES))])


@ti.func
def _light(P: ti.template(), i):
    """What a sprite adds to a vector of pixels where its weight is 1."""
    norm = P[i, NORM]
    return ti.Vector([P[i, RED] * norm, P[i, GREEN] * norm, P[i, BLUE] * norm, P[i, ALPHA] * norm] * PIXELS)


@ti.func
def _visible_share(solid: ti.template(), row: ti.template(), depth, thickness):
    """surfaces.hiding.visible_share of a row of pixels; solid : SUBPIXELS depths of each row of the tile."""
    per, share = row_of(1.0 / thickness), row_of(0.0)
    for s in ti.static(range(SUBPIXELS)):
        share += row_share((solid[row * SUBPIXELS + s] - row_of(depth)) * per + row_of(0.5))
    return share * row_of(1.0 / SUBPIXELS)


@ti.func
def _disc(P: ti.template(), i, tile: ti.template(), x, y):
    """tiled_splat._disc."""
    inverse = row_of(1.0 / P[i, FOOTPRINT])
    colour = ti.Vector([P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA]] * PIXELS)
    u, v = (ti.Vector(CENTRES) - row_of(x)) * inverse, (ti.Vector(CENTRES) - row_of(y)) * inverse
    across, down = row_profile(u * u) * row_of(P[i, NORM]), row_profile(v * v)
    weights = [_pixels(across, part) for part in ti.static(range(PARTS))]
    light = [weights[part] * colour for part in ti.static(range(PARTS))]
    coverage = [weights[part] * all_lanes(P[i, ALPHA]) for part in ti.static(range(PARTS))]
    for v in ti.static(range(TILE * PARTS)):
        w = all_lanes(down[v // PARTS])
        tile[v] = tile[v] + w * (light[v % PARTS] - tile[v] * coverage[v % PARTS])


@ti.func
def _ellipse(P: ti.template(), i, tile: ti.template(), x, y, first, last):
    """elliptic_splat.draw_ellipse."""
    light, coverage = _light(P, i), all_lanes(P[i, NORM] * P[i, ALPHA])
    u, per_height = ti.Vector(CENTRES) - row_of(x), row_of(1.0 / P[i, ACROSS])
    t, middle = u * row_of(1.0 / P[i, FOOTPRINT]), row_of(y) + row_of(P[i, SLOPE]) * u - row_of(0.5)
    square = t * t
    for row in ti.static(range(TILE)):
        if first <= row and row <= last:
            h = (row_of(float(row)) - middle) * per_height
            weights = row_profile(square + h * h)
            for part in ti.static(range(PARTS)):
                w, old = _pixels(weights, part), tile[row * PARTS + part]
                kept = old * (all_lanes(1.0) - smaller(w * coverage, all_lanes(1.0)))
                tile[row * PARTS + part] = kept + smaller(w * light, ti.Vector(_LIMITS))


@ti.func
def _streak(P: ti.template(), i, tile: ti.template(), x, y, first, last):
    """tiled_splat._streak."""
    light, dx, dy, taper = _light(P, i), P[i, DX], P[i, DY], P[i, TAPER]
    vertical = abs(dy) > abs(dx)
    dm, head_end, side = dx, x, y - 0.5 * dy
    if vertical:
        dm, head_end, side = dy, y, x - 0.5 * dx
    # a lane for each place along the longer axis
    span, c = abs(dm), ti.Vector(CENTRES) - row_of(head_end)
    along = c * row_of(ti.select(dm > 0.0, 1.0, -1.0)) + row_of(span)
    weight = row_streak_profile(along, span, P[i, FOOTPRINT], P[i, TAIL])
    centre = row_of(side) + row_of(P[i, SLOPE]) * (c + row_of(0.5 * dm))
    half_width = row_of(P[i, ACROSS]) * (row_of(taper) + row_of(1.0 - taper) * row_share(along * row_of(1.0 / span)))
    inverse = row_of(1.0) / larger(half_width, row_of(MIN_STREAK_FOOTPRINT))
    before = row_smooth_step((row_of(ti.max(first, 0)) - centre) * inverse)
    for row in ti.static(range(TILE)):
        if first <= row and row <= last:
            weights = row_of(0.0)
            if vertical:
                n, middle, per = ti.Vector(CENTRES), row_of(centre[row]), row_of(inverse[row])
                left, right = (n - row_of(0.5) - middle) * per, (n + row_of(0.5) - middle) * per
                weights = row_of(weight[row]) * (row_smooth_step(right) - row_smooth_step(left))
            else:
                after = row_smooth_step((row_of(row + 1.0) - centre) * inverse)
                weights = weight * (after - before)
                before = after
            for part in ti.static(range(PARTS)):
                tile[row * PARTS + part] = tile[row * PARTS + part] + light * _pixels(weights, part)


@ti.func
def _piece(P: ti.template(), i, tile: ti.template(), x, y, first, last):
    """piece_splat.draw_piece."""
    light, footprint, tail, taper = _light(P, i), P[i, FOOTPRINT], P[i, TAIL], P[i, TAPER]
    vertical = abs(P[i, DY]) > abs(P[i, DX])
    dm, head_m, head_n = P[i, DX], x, y
    if vertical:
        dm, head_m, head_n = P[i, DY], y, x
    span, sign = abs(dm), ti.select(dm > 0.0, 1.0, -1.0)
    slope = P[i, SLOPE] * sign
    stretch = ti.sqrt(1.0 + slope * slope)
    # a lane for each place along the longer axis
    c = ti.Vector(CENTRES) - row_of(head_m)
    along, centre = c * row_of(sign) + row_of(span), row_of(head_n) + row_of(P[i, SLOPE]) * c
    half_width = row_of(P[i, ACROSS]) * (row_of(taper) + row_of(1.0 - taper) * row_share(along / row_of(span)))
    half_width = larger(half_width, row_of(MIN_STREAK_FOOTPRINT))
    before = row_smooth_step((row_of(ti.max(first, 0)) - centre) / half_width)
    for row in ti.static(range(TILE)):
        if first <= row and row <= last:
            weights = row_of(0.0)
            if vertical:
                edges, place, half = ti.Vector(EDGES), along[row], half_width[row]
                weights = piece_row(edges, centre[row], place, half, slope, span, stretch, footprint, tail)
            else:
                after = row_smooth_step((row_of(row + 1.0) - centre) / half_width)
                foot = along * row_of(stretch) + (row_of(row + 0.5) - centre) * row_of(slope) / row_of(stretch)
                weights = (after - before) * row_streak_profile(foot, span * stretch, footprint, tail)
                before = after
            for part in ti.static(range(PARTS)):
                tile[row * PARTS + part] = tile[row * PARTS + part] + light * _pixels(weights, part)


@cache
def draw_kernel(kinds: frozenset, surfaces_hide: bool):
    """The kernel that draws sprites of these kinds, DISC for all discs, of which surfaces may hide a part."""
    discs_alone = kinds == {DISC}

    @ti.kernel
    def draw_vectors(
        P: F2, headers: H2, entries: I1, tile_masks: I1, firsts: I1, ends: I1, across: ti.i32, bins: ti.i32,
        framebuffer: FLOATS, stride: ti.i32, depths: F1, surfaces: F3, tile_depths: F3,
    ):  # fmt: skip
        """Draw each bin's sprites, entries[firsts[bin]] to entries[ends[bin] - 1].

        stride : vectors in a row of pixels
        depths : (n,) of the sprites
        surfaces, tile_depths : depths and tiles of SurfaceDepths
        """
        ti.loop_config(block_dim=1)
        for place in range(bins * TILES * TILES):
            bin, t = place // (TILES * TILES), place % (TILES * TILES)
            touched = 0
            for k in range(firsts[bin], ends[bin]):
                touched |= tile_masks[k] >> t
            if touched & 1:
                x0, y0 = (bin % across) * BIN + (t % TILES) * TILE, (bin // across) * BIN + (t // TILES) * TILE
                corner = y0 * stride + x0 // PIXELS
                tile = [all_lanes(0.0) for _ in ti.static(range(TILE * PARTS))]
                for v in ti.static(range(TILE * PARTS)):
                    tile[v] = framebuffer[corner + v // PARTS * stride + v % PARTS]
                low, high = 3e38, 3e38  # the least and the largest depth of surfaces in the tile
                solid = [row_of(0.0) for _ in ti.static(range(TILE * SUBPIXELS if surfaces_hide else 0))]
                before = [all_lanes(0.0) for _ in ti.static(range(TILE * PARTS if surfaces_hide else 0))]
                if ti.static(surfaces_hide):
                    across_tile, down_tile = x0 // TILE, y0 // TILE
                    if down_tile < tile_depths.shape[0] and across_tile < tile_depths.shape[1]:
                        low, high = tile_depths[down_tile, across_tile, 0], tile_depths[down_tile, across_tile, 1]
                    for v in ti.static(range(TILE)):
                        row = ti.min(y0 + v, surfaces.shape[0] - 1)
                        for s in ti.static(range(SUBPIXELS)):
                            solid[v * SUBPIXELS + s] = ti.Vector(
                                [
                                    surfaces[row, ti.min(x0 + column, surfaces.shape[1] - 1), s]
                                    for column in ti.static(range(TILE))
                                ]
                            )
                for k in range(firsts[bin], ends[bin]):
                    if (tile_masks[k] >> t) & 1:
                        i = entries[k]
                        x, y = P[i, X] - ti.cast(x0, ti.f32), P[i, Y] - ti.cast(y0, ti.f32)
                        kind, first, last = DISC, 0, TILE - 1
                        if ti.static(not discs_alone):
                            kind = ti.cast(headers[i, KIND], ti.i32)
                            first = ti.cast(headers[i, TOP], ti.i32) - y0
                            last = ti.cast(headers[i, BOTTOM], ti.i32) - y0
                        partly, wholly = 0, 0  # hidden
                        thickness, depth = 0.0, 0.0
                        if ti.static(surfaces_hide):
                            thickness, depth = P[i, THICKNESS], depths[i]
                            if thickness > 0.0 and depth + 0.5 * thickness > low:
                                partly, wholly = 1, ti.cast(depth - 0.5 * thickness >= high, ti.i32)
                                for v in ti.static(range(TILE * PARTS)):
                                    before[v] = tile[v]
                        if wholly == 0:
                            if ti.static(DISC in kinds):
                                if (kind == DISC) | (kind == COVERED_DISC):
                                    _disc(P, i, tile, x, y)
                            if ti.static(ELLIPSE in kinds):
                                if kind == ELLIPSE:
                                    _ellipse(P, i, tile, x, y, first, last)
                            if ti.static(STREAK in kinds):
                                if kind == STREAK:
                                    _streak(P, i, tile, x, y, first, last)
                            if ti.static(PIECE in kinds):
                                if kind == PIECE:
                                    _piece(P, i, tile, x, y, first, last)
                            if ti.static(surfaces_hide):
                                if partly == 1:
                                    for row in ti.static(range(TILE)):
                                        share = _visible_share(solid, row, depth, thickness)
                                        for v in ti.static(range(row * PARTS, row * PARTS + PARTS)):
                                            tile[v] = before[v] + (tile[v] - before[v]) * _pixels(share, v % PARTS)
                for v in ti.static(range(TILE * PARTS)):
                    framebuffer[corner + v // PARTS * stride + v % PARTS] = tile[v]

    return kernel(draw_vectors, vectors=True)
