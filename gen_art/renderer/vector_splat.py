"""Discs, ellipses and streaks drawn into the tiles of the framebuffer by whole vectors.

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
    KERNEL_VARIANCE,
    KIND,
    MIN_STREAK_FOOTPRINT,
    NORM,
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

VECTOR_KINDS = frozenset({DISC, COVERED_DISC, ELLIPSE, STREAK})
PIXELS = LANES // 4  # of a vector
PARTS = TILE // PIXELS  # vectors in a row of a tile
F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, H2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i16, 2)
FLOATS = ti.types.ndarray(ti.types.vector(LANES, ti.f32), 1)
_CENTRES = tuple(k + 0.5 for k in range(TILE))  # of the pixels of a row or a column
_LIMITS = (1e38, 1e38, 1e38, 1.0) * PIXELS  # of the light and coverage that an ellipse adds


@ti.func
def _row(x):
    """A vector with a lane for each pixel of a row, or of a column, and the same float in each."""
    return ti.Vector([ti.cast(x, ti.f32) for _ in ti.static(range(TILE))])


@ti.func
def _pixels(row, part: ti.template()):
    """The lanes of four pixels of a row, each in all four lanes of its pixel."""
    return ti.Vector([row[part * PIXELS + lane // 4] for lane in ti.static(range(LANES))])


@ti.func
def _smaller(x, y):
    return ti.select(x < y, x, y)


@ti.func
def _larger(x, y):
    return ti.select(x > y, x, y)


@ti.func
def _profile(square):
    """sprite.profile of each lane of a row, from its argument squared."""
    one = _row(1.0)
    s = _smaller(square, one)
    a = one - _row(0.3125) * s
    a2 = a * a
    a4 = a2 * a2
    b = one - s
    return a4 * a4 * (b * b)


@ti.func
def _smooth_step(t):
    """sprite.smooth_step of each lane of a row."""
    u = _smaller(_larger(t, _row(-1.0)), _row(1.0))
    s = u * u
    p = _row(-0.703125) + s * _row(0.13671875)
    for coefficient in ti.static((1.4765625, -1.640625, 1.23046875)):
        p = _row(coefficient) + s * p
    return _row(0.5) + u * p


@ti.func
def _share(x):
    """Each lane of a row, between 0 and 1."""
    return _smaller(_larger(x, _row(0.0)), _row(1.0))


@ti.func
def _streak_profile(along, span, footprint, tail):
    """sprite.streak_profile of each lane of a row."""
    value = _row(0.0)
    if span < footprint * 0.3333333:
        t = (along - _row(0.5 * span)) / _row(ti.sqrt(footprint * footprint + span * span / (12.0 * KERNEL_VARIANCE)))
        value = _profile(t * t)
    else:
        inverse = _row(1.0 / footprint)
        value = _larger(_smooth_step(along * inverse) - _smooth_step((along - _row(span)) * inverse), _row(0.0))
    return value * (_row(tail) + _row(1.0 - tail) * _share(along / _row(span)))


@ti.func
def _light(P: ti.template(), i):
    """What a sprite adds to a vector of pixels where its weight is 1."""
    norm = P[i, NORM]
    return ti.Vector([P[i, RED] * norm, P[i, GREEN] * norm, P[i, BLUE] * norm, P[i, ALPHA] * norm] * PIXELS)


@ti.func
def _visible_share(solid: ti.template(), row: ti.template(), depth, thickness):
    """surfaces.hiding.visible_share of a row of pixels; solid : SUBPIXELS depths of each row of the tile."""
    per, share = _row(1.0 / thickness), _row(0.0)
    for s in ti.static(range(SUBPIXELS)):
        share += _share((solid[row * SUBPIXELS + s] - _row(depth)) * per + _row(0.5))
    return share * _row(1.0 / SUBPIXELS)


@ti.func
def _disc(P: ti.template(), i, tile: ti.template(), x, y):
    """tiled_splat._disc."""
    inverse = _row(1.0 / P[i, FOOTPRINT])
    colour = ti.Vector([P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA]] * PIXELS)
    u, v = (ti.Vector(_CENTRES) - _row(x)) * inverse, (ti.Vector(_CENTRES) - _row(y)) * inverse
    across, down = _profile(u * u) * _row(P[i, NORM]), _profile(v * v)
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
    u, per_height = ti.Vector(_CENTRES) - _row(x), _row(1.0 / P[i, ACROSS])
    t, middle = u * _row(1.0 / P[i, FOOTPRINT]), _row(y) + _row(P[i, SLOPE]) * u - _row(0.5)
    square = t * t
    for row in ti.static(range(TILE)):
        if first <= row and row <= last:
            h = (_row(float(row)) - middle) * per_height
            weights = _profile(square + h * h)
            for part in ti.static(range(PARTS)):
                w, old = _pixels(weights, part), tile[row * PARTS + part]
                kept = old * (all_lanes(1.0) - _smaller(w * coverage, all_lanes(1.0)))
                tile[row * PARTS + part] = kept + _smaller(w * light, ti.Vector(_LIMITS))


@ti.func
def _streak(P: ti.template(), i, tile: ti.template(), x, y, first, last):
    """tiled_splat._streak."""
    light, dx, dy, taper = _light(P, i), P[i, DX], P[i, DY], P[i, TAPER]
    vertical = abs(dy) > abs(dx)
    dm, head_end, side = dx, x, y - 0.5 * dy
    if vertical:
        dm, head_end, side = dy, y, x - 0.5 * dx
    # a lane for each place along the longer axis
    span, c = abs(dm), ti.Vector(_CENTRES) - _row(head_end)
    along = c * _row(ti.select(dm > 0.0, 1.0, -1.0)) + _row(span)
    weight = _streak_profile(along, span, P[i, FOOTPRINT], P[i, TAIL])
    centre = _row(side) + _row(P[i, SLOPE]) * (c + _row(0.5 * dm))
    half_width = _row(P[i, ACROSS]) * (_row(taper) + _row(1.0 - taper) * _share(along * _row(1.0 / span)))
    inverse = _row(1.0) / _larger(half_width, _row(MIN_STREAK_FOOTPRINT))
    before = _smooth_step((_row(ti.max(first, 0)) - centre) * inverse)
    for row in ti.static(range(TILE)):
        if first <= row and row <= last:
            weights = _row(0.0)
            if vertical:
                n, middle, per = ti.Vector(_CENTRES), _row(centre[row]), _row(inverse[row])
                left, right = (n - _row(0.5) - middle) * per, (n + _row(0.5) - middle) * per
                weights = _row(weight[row]) * (_smooth_step(right) - _smooth_step(left))
            else:
                after = _smooth_step((_row(row + 1.0) - centre) * inverse)
                weights = weight * (after - before)
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
                solid = [_row(0.0) for _ in ti.static(range(TILE * SUBPIXELS if surfaces_hide else 0))]
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
                            if ti.static(surfaces_hide):
                                if partly == 1:
                                    for row in ti.static(range(TILE)):
                                        share = _visible_share(solid, row, depth, thickness)
                                        for v in ti.static(range(row * PARTS, row * PARTS + PARTS)):
                                            tile[v] = before[v] + (tile[v] - before[v]) * _pixels(share, v % PARTS)
                for v in ti.static(range(TILE * PARTS)):
                    framebuffer[corner + v // PARTS * stride + v % PARTS] = tile[v]

    return kernel(draw_vectors, vectors=True)
