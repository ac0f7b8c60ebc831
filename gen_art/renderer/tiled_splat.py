"""Sprites drawn into the framebuffer, added or composited over each other, in the same order every time.

The framebuffer is cut into bins of 32 x 32 pixels. Each sprite is listed in the bins it touches, in the order of drawing (a
counting sort over fixed chunks). A bin is drawn in tiles of 8 x 8 pixels, each by one thread in a local array, which lets the
compiler vectorise the blending. The result depends neither on the number of threads nor on any atomic sum.
Bins of discs, ellipses, streaks and their pieces alone are drawn by vector_splat.py, bins of images alone by picture_splat.py,
faster.

P : (n, 16) float rows of the sprites; headers : (n, 6) their integers; T : texels of the images

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from functools import cache

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.elliptic_splat import draw_ellipse
from gen_art.renderer.picture_tiles import BIN, TILE, TILES
from gen_art.renderer.piece_splat import draw_piece
from gen_art.renderer.sprite import (
    ACROSS,
    ALPHA,
    BLUE,
    BOTTOM,
    COSINE,
    COVERED_DISC,
    DISC,
    DX,
    DY,
    EDGE,
    ELLIPSE,
    FIRST_TEXEL,
    FOOTPRINT,
    GREEN,
    KIND,
    LEFT,
    LEVEL,
    LEVEL_SIDE,
    MIN_STREAK_FOOTPRINT,
    NORM,
    PICTURE,
    PIECE,
    POINT,
    RED,
    RIGHT,
    SINE,
    SLOPE,
    SPHERE,
    STREAK,
    TAIL,
    TAPER,
    THICKNESS,
    TOP,
    X,
    Y,
    profile,
    rim_profile,
    smooth_step,
    streak_profile,
)
from gen_art.renderer.sprite_image import read_texel
from gen_art.renderer.surfaces.hiding import visible_share

__all__ = ["CHUNKS", "count_bin_entries", "draw_kernel", "kind_bits", "list_bin_entries"]

CHUNKS = 16  # fixed, because the order of drawing must not depend on the number of threads
TILE_FLOATS = 4 * TILE  # floats in a row of a tile

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, I2 = (ti.types.ndarray(ti.i32, n) for n in (1, 2))
H2 = ti.types.ndarray(ti.i16, 2)


def kind_bits(kinds: frozenset) -> int:
    return sum(1 << kind for kind in kinds)


@ti.func
def _bins_of(headers: ti.template(), i, level, kinds):
    """First and last bin in each direction; an empty range for a sprite that is not visible, on this level or of these kinds."""
    y0, y1 = ti.cast(headers[i, TOP], ti.i32) // BIN, ti.cast(headers[i, BOTTOM], ti.i32) // BIN
    of_kind = (kinds >> ti.cast(headers[i, KIND], ti.i32)) & 1
    if headers[i, BOTTOM] < headers[i, TOP] or ti.cast(headers[i, LEVEL], ti.i32) != level or of_kind == 0:
        y0, y1 = 0, -1
    return ti.cast(headers[i, LEFT], ti.i32) // BIN, ti.cast(headers[i, RIGHT], ti.i32) // BIN, y0, y1


@ti.func
def _tiles_of(first, last, place):
    """First and last of the tiles along one side of bin `place` that pixels first..last touch."""
    start = place * BIN
    return (
        ti.max(ti.cast(first, ti.i32) - start, 0) // TILE,
        ti.min(ti.cast(last, ti.i32) - start, BIN - 1) // TILE,
    )


@ti.kernel
def _count_bin_entries(
    headers: H2,
    order: I1,
    n: ti.i32,
    level: ti.i32,
    kinds: ti.i32,
    chunk: ti.i32,
    across: ti.i32,
    counts: I2,
    kinds_there: I2,
):
    """Count the sprites in each bin, (chunks, bins), and find the kinds that are there, a bit for each."""
    ti.loop_config(block_dim=1)
    for c in range(CHUNKS):
        for j in range(c * chunk, ti.min((c + 1) * chunk, n)):
            x0, x1, y0, y1 = _bins_of(headers, order[j], level, kinds)
            for y in range(y0, y1 + 1):
                for x in range(x0, x1 + 1):
                    counts[c, y * across + x] = counts[c, y * across + x] + 1
                    kinds_there[c, y * across + x] |= 1 << ti.cast(headers[order[j], KIND], ti.i32)


@ti.kernel
def _list_bin_entries(
    headers: H2, order: I1, n: ti.i32, level: ti.i32, kinds: ti.i32, chunk: ti.i32, across: ti.i32, starts: I2, entries: I1,
    tile_masks: I1,
):  # fmt: skip
    """List each bin's sprites from starts[chunk, bin] on.

    kinds : the kinds to be listed, a bit for each (kind_bits)
    tile_masks : one bit for each of the bin's tiles that the sprite touches
    """
    ti.loop_config(block_dim=1)
    for c in range(CHUNKS):
        for j in range(c * chunk, ti.min((c + 1) * chunk, n)):
            i = order[j]
            x0, x1, y0, y1 = _bins_of(headers, i, level, kinds)
            for y in range(y0, y1 + 1):
                for x in range(x0, x1 + 1):
                    b = y * across + x
                    slot = starts[c, b]
                    u0, u1 = _tiles_of(headers[i, LEFT], headers[i, RIGHT], x)
                    v0, v1 = _tiles_of(headers[i, TOP], headers[i, BOTTOM], y)
                    row = (1 << (u1 + 1)) - (1 << u0)
                    bits = 0
                    for v in range(v0, v1 + 1):
                        bits |= row << (v * TILES)
                    entries[slot], tile_masks[slot] = i, bits
                    starts[c, b] = slot + 1


@ti.func
def _point(P: ti.template(), i, tile: ti.template(), x, y):
    """A bilinear dot of light; x and y are measured from the tile's corner."""
    x0, y0 = ti.floor(x - 0.5), ti.floor(y - 0.5)
    fx, fy = x - 0.5 - x0, y - 0.5 - y0
    r, g, b = P[i, RED], P[i, GREEN], P[i, BLUE]
    for v in ti.static(range(2)):
        row = ti.cast(y0, ti.i32) + v
        for u in ti.static(range(2)):
            column = ti.cast(x0, ti.i32) + u
            if row >= 0 and row < TILE and column >= 0 and column < TILE:
                w = (fx if u else 1.0 - fx) * (fy if v else 1.0 - fy)
                o = row * TILE_FLOATS + column * 4
                tile[o] += r * w
                tile[o + 1] += g * w
                tile[o + 2] += b * w


@ti.func
def _disc(P: ti.template(), i, tile: ti.template(), x, y, top, bottom):
    footprint, norm = P[i, FOOTPRINT], P[i, NORM]
    r, g, b, a = P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA]
    inverse = 1.0 / footprint
    light, coverage, down = ti.Vector([0.0] * TILE_FLOATS), ti.Vector([0.0] * TILE_FLOATS), ti.Vector([0.0] * TILE)
    for j in range(TILE_FLOATS):
        c = j & 3
        w = profile((ti.cast(j >> 2, ti.f32) + 0.5 - x) * inverse) * norm
        light[j] = w * ti.select(c == 0, r, ti.select(c == 1, g, ti.select(c == 2, b, a)))
        coverage[j] = w * a
    for row in range(TILE):
        down[row] = profile((ti.cast(row, ti.f32) + 0.5 - y) * inverse)
    for row in range(top, bottom):
        wy = down[row]
        for j in range(TILE_FLOATS):
            old = tile[row * TILE_FLOATS + j]
            tile[row * TILE_FLOATS + j] = old + wy * (light[j] - old * coverage[j])


@ti.func
def _sphere(P: ti.template(), i, tile: ti.template(), x, y, top, bottom):
    """An even disc with a soft rim. Where it hides, a pixel keeps what was there times the part that the disc does not cover."""
    footprint, edge, norm = P[i, FOOTPRINT], P[i, EDGE], P[i, NORM]
    r, g, b, a = P[i, RED] * norm, P[i, GREEN] * norm, P[i, BLUE] * norm, P[i, ALPHA] * norm
    for row in range(top, bottom):
        v = ti.cast(row, ti.f32) + 0.5 - y
        for j in range(TILE_FLOATS):
            u, c = ti.cast(j >> 2, ti.f32) + 0.5 - x, j & 3
            w = rim_profile(ti.sqrt(u * u + v * v), footprint, edge)
            old = tile[row * TILE_FLOATS + j]
            light = ti.select(c == 0, r, ti.select(c == 1, g, ti.select(c == 2, b, a)))
            tile[row * TILE_FLOATS + j] = old * (1.0 - ti.min(w * a, 1.0)) + w * light


@ti.func
def _streak(P: ti.template(), i, tile: ti.template(), x, y, dx, dy, top, bottom):
    """Draw a streak column by column along its longer axis.

    Across that axis, a pixel's weight is the rise of the smooth step over its width, so the weights sum to 1.
    """
    footprint, slope, across = P[i, FOOTPRINT], P[i, SLOPE], P[i, ACROSS]
    vertical = abs(dy) > abs(dx)
    dm, head_end, side = dx, x, y - 0.5 * dy
    low, high, low_n, high_n = 0, TILE, top, bottom  # limits along and across
    step_m, step_n = 4, TILE_FLOATS
    if vertical:
        dm, head_end, side = dy, y, x - 0.5 * dx
        low, high, low_n, high_n = top, bottom, 0, TILE
        step_m, step_n = TILE_FLOATS, 4
    span = abs(dm)
    sign = ti.select(dm > 0.0, 1.0, -1.0)
    r, g, b = P[i, RED] * P[i, NORM], P[i, GREEN] * P[i, NORM], P[i, BLUE] * P[i, NORM]
    tail, taper, per_span = P[i, TAIL], P[i, TAPER], 1.0 / span
    weight, centre, half_width = ti.Vector([0.0] * TILE), ti.Vector([0.0] * TILE), ti.Vector([0.0] * TILE)
    for m in range(TILE):
        c = ti.cast(m, ti.f32) + 0.5 - head_end
        weight[m] = streak_profile(c * sign + span, span, footprint, tail)
        centre[m] = side + slope * (c + 0.5 * dm)
        head = ti.min(ti.max((c * sign + span) * per_span, 0.0), 1.0)
        half_width[m] = ti.max(across * (taper + (1.0 - taper) * head), MIN_STREAK_FOOTPRINT)
    for m in range(low, high):
        if weight[m] > 0.0:
            weight_m, inverse = weight[m], 1.0 / half_width[m]
            first = ti.max(ti.cast(ti.floor(centre[m] - half_width[m]), ti.i32), low_n)
            last = ti.min(ti.cast(ti.floor(centre[m] + half_width[m]), ti.i32), high_n - 1)
            before = smooth_step((ti.cast(first, ti.f32) - centre[m]) * inverse)
            for n in range(first, last + 1):
                after = smooth_step((ti.cast(n + 1, ti.f32) - centre[m]) * inverse)
                w = weight_m * (after - before)
                before = after
                o = m * step_m + n * step_n
                tile[o] += r * w
                tile[o + 1] += g * w
                tile[o + 2] += b * w


@ti.func
def _picture(P: ti.template(), T: ti.template(), i, tile: ti.template(), x, y, top, bottom):
    """A rotated image. See sprite.py for the numbers of its row that differ from other sprites'."""
    norm, inverse, a, b = P[i, NORM], 1.0 / P[i, FOOTPRINT], P[i, COSINE], P[i, SINE]
    start, side = ti.cast(P[i, FIRST_TEXEL], ti.i32), ti.cast(P[i, LEVEL_SIDE], ti.i32)
    texel = P[i, LEVEL_SIDE] * 0.5
    light = ti.Vector([P[i, RED] * norm, P[i, GREEN] * norm, P[i, BLUE] * norm, P[i, ALPHA] * norm])
    for row in range(top, bottom):
        q = (ti.cast(row, ti.f32) + 0.5 - y) * inverse
        for column in range(TILE):
            p = (ti.cast(column, ti.f32) + 0.5 - x) * inverse
            u, v = (1.0 + p * a - q * b) * texel, (1.0 + p * b + q * a) * texel
            if ti.min(u, v) > -0.5 and ti.max(u, v) < P[i, LEVEL_SIDE] + 0.5:
                o = row * TILE_FLOATS + column * 4
                opacity = ti.min(read_texel(T, start, side, u, v, 3) * light[3], 1.0)
                for c in ti.static(range(4)):
                    tile[o + c] = tile[o + c] * (1.0 - opacity) + light[c] * read_texel(T, start, side, u, v, c)


@ti.func
def _copy(tile: ti.template(), before: ti.template()):
    for j in range(TILE * TILE_FLOATS):
        before[j] = tile[j]


@ti.func
def _hide(tile: ti.template(), before: ti.template(), surfaces: ti.template(), ox, oy, depth, thickness):
    """Take back what a sprite changed in the pixels where surfaces hide it; `before` is the tile without the sprite."""
    for p in range(TILE * TILE):
        row, column = oy + p // TILE, ox + p % TILE
        if row < surfaces.shape[0] and column < surfaces.shape[1]:
            share = visible_share(surfaces, row, column, depth, thickness)
            for c in ti.static(range(4)):
                tile[4 * p + c] = before[4 * p + c] + (tile[4 * p + c] - before[4 * p + c]) * share


@cache
def draw_kernel(kinds: frozenset, surfaces_hide: bool):
    """The kernel that draws sprites of these kinds, of which surfaces may hide a part.

    Code for what a picture does not hold is neither compiled nor loaded.
    """

    @ti.kernel
    def draw(
        P: F2, T: F2, headers: H2, entries: I1, tile_masks: I1, firsts: I1, ends: I1, across: ti.i32, bins: ti.i32,
        framebuffer: F1, stride: ti.i32, depths: F1, surfaces: F3,
    ):  # fmt: skip
        """Draw each bin's sprites, entries[firsts[bin]] to entries[ends[bin] - 1]."""
        ti.loop_config(block_dim=1)
        for place in range(
            bins * TILES * TILES
        ):  # one tile per iteration, not one bin: compiling takes a third of the time
            bin, t = place // (TILES * TILES), place % (TILES * TILES)
            if ends[bin] > firsts[bin]:
                ox, oy = (bin % across) * BIN + (t % TILES) * TILE, (bin // across) * BIN + (t // TILES) * TILE
                tile = ti.Vector([0.0] * (TILE * TILE_FLOATS))
                before = ti.Vector([0.0] * (TILE * TILE_FLOATS if surfaces_hide else 1))
                for row in range(TILE):
                    for j in range(TILE_FLOATS):
                        tile[row * TILE_FLOATS + j] = framebuffer[(oy + row) * stride + ox * 4 + j]
                for k in range(firsts[bin], ends[bin]):
                    if (tile_masks[k] >> t) & 1:
                        i = entries[k]
                        kind = ti.cast(headers[i, KIND], ti.i32)
                        top = ti.max(ti.cast(headers[i, TOP], ti.i32) - oy, 0)
                        bottom = ti.min(ti.cast(headers[i, BOTTOM], ti.i32) - oy + 1, TILE)
                        x, y = P[i, X] - ti.cast(ox, ti.f32), P[i, Y] - ti.cast(oy, ti.f32)
                        if ti.static(surfaces_hide):
                            if P[i, THICKNESS] > 0.0:
                                _copy(tile, before)
                        if ti.static(POINT in kinds):
                            if kind == POINT:
                                _point(P, i, tile, x, y)
                        if ti.static(DISC in kinds or COVERED_DISC in kinds):
                            if kind == DISC or kind == COVERED_DISC:  # noqa: SIM109 - no kernel knows tuples
                                _disc(P, i, tile, x, y, top, bottom)
                        if ti.static(STREAK in kinds):
                            if kind == STREAK:
                                _streak(P, i, tile, x, y, P[i, DX], P[i, DY], top, bottom)
                        if ti.static(ELLIPSE in kinds):
                            if kind == ELLIPSE:
                                draw_ellipse(P, i, tile, x, y, top, bottom)
                        if ti.static(PIECE in kinds):
                            if kind == PIECE:
                                left = ti.max(ti.cast(headers[i, LEFT], ti.i32) - ox, 0)
                                right = ti.min(ti.cast(headers[i, RIGHT], ti.i32) - ox + 1, TILE)
                                draw_piece(P, i, tile, x, y, left, right, top, bottom, TILE)
                        if ti.static(SPHERE in kinds):
                            if kind == SPHERE:
                                _sphere(P, i, tile, x, y, top, bottom)
                        if ti.static(PICTURE in kinds):
                            if kind == PICTURE:
                                _picture(P, T, i, tile, x, y, top, bottom)
                        if ti.static(surfaces_hide):
                            if P[i, THICKNESS] > 0.0:
                                _hide(tile, before, surfaces, ox, oy, depths[i], P[i, THICKNESS])
                for row in range(TILE):
                    for j in range(TILE_FLOATS):
                        framebuffer[(oy + row) * stride + ox * 4 + j] = tile[row * TILE_FLOATS + j]

    return kernel(draw)


count_bin_entries, list_bin_entries = map(kernel, (_count_bin_entries, _list_bin_entries))
