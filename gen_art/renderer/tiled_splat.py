"""Sprites into the film, added or laid over each other, in the same order every time.

The film is cut into bins of 32 x 32 pixels; each sprite is listed in the bins it touches, in the order of drawing (a
counting sort over fixed chunks). A bin is drawn 8 x 8 pixels at a time, each such tile by one thread in a local array,
which is what lets the blending vectorise. Neither the number of threads nor any atomic sum enters the result.

Where sprites hide each other, the order of drawing is cut into SLICES, and in each of them the coarse films come first.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing: it must stand in an `if` of its own)
from functools import cache

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.sprite import (
    ACROSS,
    ALPHA,
    BLUE,
    DISC,
    DX,
    DY,
    EDGE,
    FIRST,
    GREEN,
    KIND,
    LAST,
    LEFT,
    LEVEL,
    NORM,
    PICTURE,
    POINT,
    REACH,
    RED,
    RIGHT,
    SLOPE,
    SPHERE,
    STREAK,
    TAIL,
    TAPER,
    THINNEST,
    X,
    Y,
    along,
    profile,
    rim,
    step,
)
from gen_art.renderer.sprite_image import read_texel

__all__ = ["count", "drawing", "lay", "list_bins"]

BIN = 32  # pixels along the side of a bin
TILE = 8  # pixels along the side of the local array
SIDE = BIN // TILE
CHUNKS = 16  # fixed: the order of drawing must not depend on the number of threads
LANE = 4 * TILE  # floats in a tile's row
SLICES = 24

F1, F2, I1, I2 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.i32, 1), (ti.i32, 2)))
H2 = ti.types.ndarray(ti.i16, 2)


@ti.func
def _bins(marks: ti.template(), i, level):
    """First and last bin in each direction; none for a sprite that is not seen, or not on this level."""
    y0, y1 = ti.cast(marks[i, FIRST], ti.i32) // BIN, ti.cast(marks[i, LAST], ti.i32) // BIN
    if marks[i, LAST] < marks[i, FIRST] or ti.cast(marks[i, LEVEL], ti.i32) != level:
        y0, y1 = 0, -1
    return ti.cast(marks[i, LEFT], ti.i32) // BIN, ti.cast(marks[i, RIGHT], ti.i32) // BIN, y0, y1


@ti.func
def _tiles(first, last, place):
    """First and last of the tiles along one side of bin `place` that pixels first..last touch."""
    start = place * BIN
    return (
        ti.max(ti.cast(first, ti.i32) - start, 0) // TILE,
        ti.min(ti.cast(last, ti.i32) - start, BIN - 1) // TILE,
    )


@ti.kernel
def _count(marks: H2, order: I1, n: ti.i32, level: ti.i32, chunk: ti.i32, across: ti.i32, counts: I2):
    ti.loop_config(block_dim=1)
    for c in range(CHUNKS):
        for j in range(c * chunk, ti.min((c + 1) * chunk, n)):
            x0, x1, y0, y1 = _bins(marks, order[j], level)
            for y in range(y0, y1 + 1):
                for x in range(x0, x1 + 1):
                    counts[c, y * across + x] = counts[c, y * across + x] + 1


@ti.kernel
def _list(
    marks: H2, order: I1, n: ti.i32, level: ti.i32, chunk: ti.i32, across: ti.i32, starts: I2, listed: I1, touched: I1
):
    """`touched`: one bit for each of the bin's tiles."""
    ti.loop_config(block_dim=1)
    for c in range(CHUNKS):
        for j in range(c * chunk, ti.min((c + 1) * chunk, n)):
            i = order[j]
            x0, x1, y0, y1 = _bins(marks, i, level)
            for y in range(y0, y1 + 1):
                for x in range(x0, x1 + 1):
                    b = y * across + x
                    at = starts[c, b]
                    u0, u1 = _tiles(marks[i, LEFT], marks[i, RIGHT], x)
                    v0, v1 = _tiles(marks[i, FIRST], marks[i, LAST], y)
                    row = (1 << (u1 + 1)) - (1 << u0)
                    bits = 0
                    for v in range(v0, v1 + 1):
                        bits |= row << (v * SIDE)
                    listed[at], touched[at] = i, bits
                    starts[c, b] = at + 1


@ti.func
def _point(P: ti.template(), i, tile: ti.template(), x, y):
    """A bilinear dot of light; x, y from the tile's corner."""
    x0, y0 = ti.floor(x - 0.5), ti.floor(y - 0.5)
    fx, fy = x - 0.5 - x0, y - 0.5 - y0
    r, g, b = P[i, RED], P[i, GREEN], P[i, BLUE]
    for v in ti.static(range(2)):
        row = ti.cast(y0, ti.i32) + v
        for u in ti.static(range(2)):
            column = ti.cast(x0, ti.i32) + u
            if row >= 0 and row < TILE and column >= 0 and column < TILE:
                w = (fx if u else 1.0 - fx) * (fy if v else 1.0 - fy)
                o = row * LANE + column * 4
                tile[o] += r * w
                tile[o + 1] += g * w
                tile[o + 2] += b * w


@ti.func
def _disc(P: ti.template(), i, tile: ti.template(), x, y, top, bottom):
    reach, norm = P[i, REACH], P[i, NORM]
    r, g, b, a = P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA]
    inverse = 1.0 / reach
    light, veil, down = ti.Vector([0.0] * LANE), ti.Vector([0.0] * LANE), ti.Vector([0.0] * TILE)
    for j in range(LANE):
        c = j & 3
        w = profile((ti.cast(j >> 2, ti.f32) + 0.5 - x) * inverse) * norm
        light[j] = w * ti.select(c == 0, r, ti.select(c == 1, g, ti.select(c == 2, b, a)))
        veil[j] = w * a
    for row in range(TILE):
        down[row] = profile((ti.cast(row, ti.f32) + 0.5 - y) * inverse)
    for row in range(top, bottom):
        wy = down[row]
        for j in range(LANE):
            under = tile[row * LANE + j]
            tile[row * LANE + j] = under + wy * (light[j] - under * veil[j])


@ti.func
def _sphere(P: ti.template(), i, tile: ti.template(), x, y, top, bottom):
    """An even disc with a soft rim; where it hides, what is under a pixel stays by the part it does not cover."""
    reach, edge, norm = P[i, REACH], P[i, EDGE], P[i, NORM]
    r, g, b, a = P[i, RED] * norm, P[i, GREEN] * norm, P[i, BLUE] * norm, P[i, ALPHA] * norm
    for row in range(top, bottom):
        v = ti.cast(row, ti.f32) + 0.5 - y
        for j in range(LANE):
            u, c = ti.cast(j >> 2, ti.f32) + 0.5 - x, j & 3
            w = rim(ti.sqrt(u * u + v * v), reach, edge)
            under = tile[row * LANE + j]
            light = ti.select(c == 0, r, ti.select(c == 1, g, ti.select(c == 2, b, a)))
            tile[row * LANE + j] = under * (1.0 - ti.min(w * a, 1.0)) + w * light


@ti.func
def _streak(P: ti.template(), i, tile: ti.template(), x, y, dx, dy, top, bottom):
    """Column by column along the longer axis; across it each pixel gets the step's rise over its width, which sums to 1."""
    reach, slope, across = P[i, REACH], P[i, SLOPE], P[i, ACROSS]
    upright = abs(dy) > abs(dx)
    dm, end, side = dx, x, y - 0.5 * dy
    low, high, low_n, high_n = 0, TILE, top, bottom  # the limits along and across
    step_m, step_n = 4, LANE
    if upright:
        dm, end, side = dy, y, x - 0.5 * dx
        low, high, low_n, high_n = top, bottom, 0, TILE
        step_m, step_n = LANE, 4
    span = abs(dm)
    sign = ti.select(dm > 0.0, 1.0, -1.0)
    r, g, b = P[i, RED] * P[i, NORM], P[i, GREEN] * P[i, NORM], P[i, BLUE] * P[i, NORM]
    tail, taper, per_span = P[i, TAIL], P[i, TAPER], 1.0 / span
    weight, middle, wide = ti.Vector([0.0] * TILE), ti.Vector([0.0] * TILE), ti.Vector([0.0] * TILE)
    for m in range(TILE):
        c = ti.cast(m, ti.f32) + 0.5 - end
        weight[m] = along(c * sign + span, span, reach, tail)
        middle[m] = side + slope * (c + 0.5 * dm)
        head = ti.min(ti.max((c * sign + span) * per_span, 0.0), 1.0)
        wide[m] = ti.max(across * (taper + (1.0 - taper) * head), THINNEST)
    for m in range(low, high):
        if weight[m] > 0.0:
            w0, inverse = weight[m], 1.0 / wide[m]
            first = ti.max(ti.cast(ti.floor(middle[m] - wide[m]), ti.i32), low_n)
            last = ti.min(ti.cast(ti.floor(middle[m] + wide[m]), ti.i32), high_n - 1)
            before = step((ti.cast(first, ti.f32) - middle[m]) * inverse)
            for n in range(first, last + 1):
                after = step((ti.cast(n + 1, ti.f32) - middle[m]) * inverse)
                w = w0 * (after - before)
                before = after
                o = m * step_m + n * step_n
                tile[o] += r * w
                tile[o + 1] += g * w
                tile[o + 2] += b * w


@ti.func
def _picture(P: ti.template(), T: ti.template(), i, tile: ti.template(), x, y, top, bottom):
    """An image, turned: DX and DY are the cosine and sine, SLOPE and ACROSS the level's first texel and side."""
    norm, inverse, a, b = P[i, NORM], 1.0 / P[i, REACH], P[i, DX], P[i, DY]
    start, side, texel = ti.cast(P[i, SLOPE], ti.i32), ti.cast(P[i, ACROSS], ti.i32), P[i, ACROSS] * 0.5
    light = ti.Vector([P[i, RED] * norm, P[i, GREEN] * norm, P[i, BLUE] * norm, P[i, ALPHA] * norm])
    for row in range(top, bottom):
        q = (ti.cast(row, ti.f32) + 0.5 - y) * inverse
        for column in range(TILE):
            p = (ti.cast(column, ti.f32) + 0.5 - x) * inverse
            u, v = (1.0 + p * a - q * b) * texel, (1.0 + p * b + q * a) * texel
            if ti.min(u, v) > -0.5 and ti.max(u, v) < P[i, ACROSS] + 0.5:
                o = row * LANE + column * 4
                hidden = ti.min(read_texel(T, start, side, u, v, 3) * light[3], 1.0)
                for c in ti.static(range(4)):
                    tile[o + c] = tile[o + c] * (1.0 - hidden) + light[c] * read_texel(T, start, side, u, v, c)


@cache
def drawing(kinds: frozenset):
    """The kernel that draws sprites of these kinds: what a picture does not hold need not be compiled, nor loaded."""

    @ti.kernel
    def draw(
        P: F2, T: F2, marks: H2, listed: I1, touched: I1, bounds: I1, across: ti.i32, bins: ti.i32, film: F1,
        stride: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for place in range(bins * SIDE * SIDE):  # one tile, not one bin, a turn: the compiler takes a third of the time
            bin, t = place // (SIDE * SIDE), place % (SIDE * SIDE)
            if bounds[bin + 1] > bounds[bin]:
                ox, oy = (bin % across) * BIN + (t % SIDE) * TILE, (bin // across) * BIN + (t // SIDE) * TILE
                tile = ti.Vector([0.0] * (TILE * LANE))
                for row in range(TILE):
                    for j in range(LANE):
                        tile[row * LANE + j] = film[(oy + row) * stride + ox * 4 + j]
                for k in range(bounds[bin], bounds[bin + 1]):
                    if (touched[k] >> t) & 1:
                        i = listed[k]
                        kind = ti.cast(marks[i, KIND], ti.i32)
                        top = ti.max(ti.cast(marks[i, FIRST], ti.i32) - oy, 0)
                        bottom = ti.min(ti.cast(marks[i, LAST], ti.i32) - oy + 1, TILE)
                        x, y = P[i, X] - ti.cast(ox, ti.f32), P[i, Y] - ti.cast(oy, ti.f32)
                        if ti.static(POINT in kinds):
                            if kind == POINT:
                                _point(P, i, tile, x, y)
                        if ti.static(DISC in kinds):
                            if kind == DISC:
                                _disc(P, i, tile, x, y, top, bottom)
                        if ti.static(STREAK in kinds):
                            if kind == STREAK:
                                _streak(P, i, tile, x, y, P[i, DX], P[i, DY], top, bottom)
                        if ti.static(SPHERE in kinds):
                            if kind == SPHERE:
                                _sphere(P, i, tile, x, y, top, bottom)
                        if ti.static(PICTURE in kinds):
                            if kind == PICTURE:
                                _picture(P, T, i, tile, x, y, top, bottom)
                for row in range(TILE):
                    for j in range(LANE):
                        film[(oy + row) * stride + ox * 4 + j] = tile[row * LANE + j]

    return kernel(draw)


@ti.kernel
def _lay(
    coarse: F1,
    cw: ti.i32,
    ch: ti.i32,
    cs: ti.i32,
    film: F1,
    stride: ti.i32,
    across: ti.i32,
    busy: I1,
    n: ti.i32,
    over: ti.i32,
):
    """Lay a film of half the size over (or under) another, in the bins listed as busy."""
    ti.loop_config(block_dim=1)
    for k in range(n):
        x0, y0 = (busy[k] % across) * BIN, (busy[k] // across) * BIN
        for y in range(y0, y0 + BIN):
            j = y >> 1
            ja, jb = ti.min(j, ch - 1) * cs, ti.min(ti.max(j - 1 + 2 * (y & 1), 0), ch - 1) * cs
            for x in range(x0, x0 + BIN):
                i = x >> 1
                ia, ib = ti.min(i, cw - 1) * 4, ti.min(ti.max(i - 1 + 2 * (x & 1), 0), cw - 1) * 4
                v = ti.Vector([0.0, 0.0, 0.0, 0.0])
                for c in ti.static(range(4)):
                    v[c] = 0.5625 * coarse[ja + ia + c] + 0.1875 * (coarse[ja + ib + c] + coarse[jb + ia + c])
                    v[c] += 0.0625 * coarse[jb + ib + c]
                o = y * stride + x * 4
                u = ti.Vector([film[o], film[o + 1], film[o + 2], film[o + 3]])
                if over == 1:
                    u = u * (1.0 - v[3]) + v
                else:
                    u = v * (1.0 - u[3]) + u
                for c in ti.static(range(4)):
                    film[o + c] = u[c]


count, list_bins, lay = (kernel(k) for k in (_count, _list, _lay))
