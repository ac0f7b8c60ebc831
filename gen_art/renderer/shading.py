"""From particles to columns: where each is on the picture, how large, in what colour, with what light.

One kernel for all looks, LANES particles at a time in local arrays, which is what lets it vectorise.
"""

import numpy as np

from gen_art.backend.runtime import aligned, kernel, ti
from gen_art.maths.elementary import exp
from gen_art.particles.rows import CHARGE, LIFETIME, MASS, PX, PY, PZ, RADIUS, VX, VY, VZ
from gen_art.renderer.colour import TABLE
from gen_art.renderer.look_tables import (
    ALBEDO,
    AREA_OF,
    AXES,
    BLEND,
    COLOR,
    CONSERVE,
    DUTY,
    EMITS,
    FALLOFF,
    FAR,
    FILM_TIME,
    FOCUS,
    FOG_BLUE,
    FOG_GREEN,
    FOG_RATE,
    FOG_RED,
    FOG_START,
    INTENSITY,
    KELVIN,
    KIND,
    LENS,
    LIT,
    NEAR,
    OPACITY,
    ORTHOGRAPHIC,
    POSITION,
    QUANTITIES,
    RAMPS,
    RANDOM,
    RAW,
    RIBBON,
    ROWS,
    SCALE,
    SHUTTER,
    SIZE,
    SIZE_MODE,
    SIZE_VALUE,
    SNAP,
    SOFT,
    STROBE_HI,
    STROBE_LO,
    TIME,
    WEIGHT,
    WIDTH,
    LookTables,
)
from gen_art.renderer.sprite import (
    ALPHA,
    AREA,
    BLUE,
    COLUMNS,
    DEPTH,
    DISC,
    DX,
    DY,
    EDGE,
    GREEN,
    HIDDEN,
    OUTSIDE,
    PICTURE,
    POINT,
    REACH,
    RED,
    SMALLEST,
    SOFTEST,
    SPHERE,
    STREAK,
    VARIANCE,
    X,
    Y,
)  # fmt: skip

__all__ = ["Columns", "shade"]

LANES = 8
BLOCK = 2048  # particles a parallel turn
REFERENCE_ROWS = 720.0  # a "pixel" of a preset is 1/720 of the picture's height
BOKEH = 0.25 / VARIANCE  # reach squared that gives the variance of an even disc of radius 1
# half widths of an even disc's rim that keep the second moment: of a sharp disc seen out of focus by 1, of a soft one's reach
SHARP_RIM, SOFT_RIM = (0.2 / VARIANCE) ** 0.5, 0.8**0.5
CONE = (1.0 + VARIANCE) / (1.0 + 6.0 * VARIANCE + 0.021)  # and radius squared, of discs of nearly one size: all rim

F64, U2, I1, L1, F1, F2, F3 = (
    ti.types.ndarray(d, n)
    for d, n in ((ti.f64, 1), (ti.u32, 2), (ti.i32, 1), (ti.i64, 1), (ti.f32, 1), (ti.f32, 2), (ti.f32, 3))
)


@ti.func
def unit(low, high, channel):
    """A number in 0..1 from a particle's key: PCG's output permutation over a mix of the words."""
    s = (low ^ ti.u32(channel)) * ti.u32(747796405) + ti.u32(2891336453)
    s = s ^ (high * ti.u32(277803737))
    s = s * ti.u32(747796405) + ti.u32(2891336453)
    w = ((s >> ((s >> ti.u32(28)) + ti.u32(4))) ^ s) * ti.u32(277803737)
    w = (w >> ti.u32(22)) ^ w
    return ti.cast(w >> ti.u32(8), ti.f32) * (1.0 / 16777216.0)


@ti.func
def _clip(p, q, low, high):
    """Liang and Barsky's step: the part [low, high] of a segment with p * t <= q."""
    if p < 0.0:
        low = ti.max(low, q / p)
    elif p > 0.0:
        high = ti.min(high, q / p)
    elif q < 0.0:
        high = -1.0
    return low, high


@ti.func
def _lanes(value):
    return ti.Vector([value] * LANES)


@ti.kernel
def _shade(
    S: ti.types.ndarray(ndim=2), birth: F64, key: U2, id: L1, source: I1, tag_rows: I1, push: F1, n: ti.i32, C: F2, A: F2,
    ramps: F2, curves: F2, colours: F3, Q: F64,
):  # fmt: skip
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        kind, scale = ti.cast(Q[KIND], ti.i32), ti.cast(Q[SCALE], ti.f32)
        parallel = Q[ORTHOGRAPHIC] > 0.5
        near, far = ti.cast(Q[NEAR], ti.f32), ti.cast(Q[FAR], ti.f32)
        width, rows = ti.cast(Q[WIDTH], ti.f32), ti.cast(Q[ROWS], ti.f32)
        pushes = push.shape[0]
        for tile in range(block * BLOCK // LANES, ti.min((block + 1) * BLOCK, n + LANES - 1) // LANES):
            i0 = tile * LANES
            right, above, ahead = _lanes(0.0), _lanes(0.0), _lanes(0.0)
            goes, climbs, comes = _lanes(0.0), _lanes(0.0), _lanes(0.0)
            px, py, dx, dy, per = _lanes(0.0), _lanes(0.0), _lanes(0.0), _lanes(0.0), _lanes(0.0)
            part = _lanes(0.0)  # of the streak that is in the frame; 0 for what is not drawn
            quantity = ti.Vector([0.0] * ((QUANTITIES + RAMPS) * LANES))
            for j in range(LANES):
                i = i0 + j
                x = ti.cast(ti.cast(S[PX, i], ti.f64) - Q[POSITION], ti.f32)
                y = ti.cast(ti.cast(S[PY, i], ti.f64) - Q[POSITION + 1], ti.f32)
                z = ti.cast(ti.cast(S[PZ, i], ti.f64) - Q[POSITION + 2], ti.f32)
                u, v, w = ti.cast(S[VX, i], ti.f32), ti.cast(S[VY, i], ti.f32), ti.cast(S[VZ, i], ti.f32)
                a = ti.Vector([ti.cast(Q[AXES + k], ti.f32) for k in range(9)])
                right[j], goes[j] = a[0] * x + a[1] * y + a[2] * z, a[0] * u + a[1] * v + a[2] * w
                above[j], climbs[j] = a[3] * x + a[4] * y + a[5] * z, a[3] * u + a[4] * v + a[5] * w
                ahead[j], comes[j] = a[6] * x + a[7] * y + a[8] * z, a[6] * u + a[7] * v + a[8] * w
                age, life = ti.cast(Q[TIME] - birth[i], ti.f32), ti.cast(S[LIFETIME, i], ti.f32)
                mass, squared = ti.cast(S[MASS, i], ti.f32), u * u + v * v + w * w
                x, y, z = ti.cast(S[PX, i], ti.f32), ti.cast(S[PY, i], ti.f32), ti.cast(S[PZ, i], ti.f32)
                quantity[j], quantity[LANES + j] = age / ti.max(life, 1e-30), age
                quantity[2 * LANES + j], quantity[3 * LANES + j] = ti.sqrt(squared), 0.5 * mass * squared
                quantity[4 * LANES + j], quantity[5 * LANES + j] = ti.cast(S[CHARGE, i], ti.f32), mass
                quantity[6 * LANES + j], quantity[7 * LANES + j] = ti.cast(S[RADIUS, i], ti.f32), ti.cast(id[i], ti.f32)
                quantity[9 * LANES + j] = ti.sqrt(x * x + y * y + z * z)
                quantity[10 * LANES + j], quantity[11 * LANES + j], quantity[12 * LANES + j] = x, y, z
                quantity[13 * LANES + j] = push[ti.min(i, pushes - 1)]
                visible = (i < n) & (age >= 0.0) & (age < life) & (ahead[j] < far)
                visible = visible & ((ahead[j] >= near) | (kind == STREAK))
                part[j] = ti.select(visible, 1.0, 0.0)
            if kind == STREAK:
                for j in range(LANES):
                    if part[j] > 0.0:
                        lapse = ti.min(ti.cast(Q[SHUTTER], ti.f32), ti.max(quantity[LANES + j], 0.0))
                        head = ti.Vector([right[j], above[j], ahead[j]])
                        old = head - ti.Vector([goes[j], climbs[j], comes[j]]) * lapse
                        begins, ends = _clip(head[2] - old[2], head[2] - near, 0.0, 1.0)
                        part[j] = 0.0
                        if ends > begins:
                            back = head + (old - head) * ends
                            head = head + (old - head) * begins
                            here, there = scale, scale
                            if not parallel:
                                here, there = scale / head[2], scale / back[2]
                            hx, hy = 0.5 * width + head[0] * here, 0.5 * rows - head[1] * here
                            ox, oy = hx - (0.5 * width + back[0] * there), hy - (0.5 * rows - back[1] * there)
                            low, high = 0.0, 1.0
                            run = ti.Vector([ox, -ox, oy, -oy])
                            room = ti.Vector([hx + width, 2.0 * width - hx, hy + rows, 2.0 * rows - hy])
                            for e in range(4):
                                low, high = _clip(run[e], room[e], low, high)
                            if high > low:
                                px[j], py[j] = hx - ox * low, hy - oy * low
                                dx[j], dy[j] = ox * (high - low), oy * (high - low)
                                part[j] = (ends - begins) * (high - low)
                            per[j], ahead[j] = here, head[2]
            else:
                for j in range(LANES):
                    per[j] = ti.select(parallel, scale, scale / ti.select(part[j] > 0.0, ahead[j], 1.0))
                    px[j], py[j] = 0.5 * width + right[j] * per[j], 0.5 * rows - above[j] * per[j]
            # the six tables, each by its quantity
            place = ti.Vector([0.0] * (RAMPS * LANES))
            value = ti.Vector([0.0] * (3 * LANES))
            for k in range(RAMPS):
                if ramps[k, 2] == 0.0:  # a constant, which takes no place in its table
                    if k < 3:
                        for j in range(LANES):
                            value[k * LANES + j] = curves[k, 0]
                else:
                    slot = ti.cast(ramps[k, 0], ti.i32) * LANES
                    channel = ti.cast(ramps[k, 3], ti.i32)
                    if channel >= 0:
                        for j in range(LANES):
                            quantity[slot + j] = ti.cast(S[channel, i0 + j], ti.f32)
                    if slot == RANDOM * LANES:
                        for j in range(LANES):
                            quantity[slot + j] = unit(key[0, i0 + j], key[1, i0 + j], 11)
                    for j in range(LANES):
                        t = ti.min(ti.max((quantity[slot + j] - ramps[k, 1]) * ramps[k, 2], 0.0), 1.0)
                        place[k * LANES + j] = t * (TABLE - 1.0)
                    if k < 3:
                        for j in range(LANES):
                            t = place[k * LANES + j]
                            at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                            first = curves[k, at]
                            value[k * LANES + j] = first + (curves[k, at + 1] - first) * (t - ti.cast(at, ti.f32))
            # size in pixels, the area its light is worth, what hides it
            half, area, light, fog = _lanes(0.0), _lanes(0.0), _lanes(0.0), _lanes(1.0)
            through, cover = _lanes(0.0), _lanes(0.0)
            mode = ti.cast(Q[SIZE_MODE], ti.i32)
            pixel = rows / REFERENCE_ROWS
            for j in range(LANES):
                size = ti.select(mode == 0, quantity[6 * LANES + j], ti.cast(Q[SIZE_VALUE], ti.f32))
                size *= value[SIZE * LANES + j]
                half[j] = size * ti.select(mode == 2, pixel, per[j])
                dot = pixel * value[SIZE * LANES + j]
                a = ti.cast(Q[AREA_OF], ti.f32) * half[j] * half[j]
                a = ti.select((kind == POINT) & (mode < 2), dot * dot, a)
                swept = ti.sqrt(dx[j] * dx[j] + dy[j] * dy[j]) * ti.sqrt(ti.cast(Q[AREA_OF], ti.f32)) * half[j]
                a = ti.select(Q[RIBBON] > 0.5, swept, a)
                area[j] = ti.select(Q[RAW] > 0.5, width * rows, a)
                faint = ti.cast(Q[FALLOFF], ti.f32) / ti.max(ahead[j] * ahead[j], 1e-30)
                faint = ti.select((Q[FALLOFF] > 0.0) & (not parallel), faint, 1.0)
                light[j] = value[INTENSITY * LANES + j] * ti.cast(Q[WEIGHT], ti.f32) * faint
                light[j] *= ti.select((Q[RIBBON] > 0.5) & (part[j] > 0.0), 1.0, part[j])
                shrink = ti.cast(Q[CONSERVE], ti.f32) * per[j] / ti.max(half[j], 1e-30)
                through[j] = value[OPACITY * LANES + j] * ti.select(Q[CONSERVE] > 0.0, shrink * shrink, 1.0)
            if Q[STROBE_HI] > 0.0:
                for j in range(LANES):
                    one, two = key[0, i0 + j], key[1, i0 + j]
                    f = Q[STROBE_LO] + (Q[STROBE_HI] - Q[STROBE_LO]) * ti.cast(unit(one, two, 5), ti.f64)
                    turn = Q[FILM_TIME] * f + ti.cast(unit(one, two, 6), ti.f64)
                    light[j] *= ti.select(turn - ti.floor(turn) < Q[DUTY], 1.0, 0.0)
            if Q[BLEND] > 0.5:
                for j in range(LANES):
                    hidden = ti.select(Q[BLEND] > 1.5, 1.0, 1.0 - exp(-through[j]))
                    cover[j] = ti.select(part[j] > 0.0, hidden * area[j], 0.0)
            if Q[FOG_RATE] > 0.0:
                for j in range(LANES):
                    mist = ti.max(ahead[j] - ti.cast(Q[FOG_START], ti.f32), 0.0) * ti.cast(Q[FOG_RATE], ti.f32)
                    fog[j] = exp(-mist)
            # colour, and the light that a lamp would leave on it
            red, green, blue = _lanes(0.0), _lanes(0.0), _lanes(0.0)
            if Q[EMITS] > 0.5:
                glows = ti.Vector([0.0] * (3 * LANES))  # a black body's colour
                for c in ti.static(range(3)):
                    for j in range(LANES):
                        glows[c * LANES + j] = colours[0, 0, c]
                if ramps[KELVIN, 2] > 0.0:
                    for j in range(LANES):
                        t = place[KELVIN * LANES + j]
                        at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                        for c in ti.static(range(3)):
                            first = colours[0, at, c]
                            glows[c * LANES + j] = first + (colours[0, at + 1, c] - first) * (t - ti.cast(at, ti.f32))
                for j in range(LANES):
                    t, row, strength = place[COLOR * LANES + j], tag_rows[source[i0 + j]], light[j] * area[j]
                    at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                    f = t - ti.cast(at, ti.f32)
                    c, d, e = colours[row, at, 0], colours[row, at, 1], colours[row, at, 2]
                    red[j] = (c + (colours[row, at + 1, 0] - c) * f) * glows[j] * strength
                    green[j] = (d + (colours[row, at + 1, 1] - d) * f) * glows[LANES + j] * strength
                    blue[j] = (e + (colours[row, at + 1, 2] - e) * f) * glows[2 * LANES + j] * strength
            if Q[BLEND] > 0.5:
                for j in range(LANES):
                    t = place[ALBEDO * LANES + j]
                    at = ti.min(ti.cast(t, ti.i32), TABLE - 2)
                    f, strength = t - ti.cast(at, ti.f32), cover[j] * fog[j]
                    c, d, e = colours[1, at, 0], colours[1, at, 1], colours[1, at, 2]
                    c = (c + (colours[1, at + 1, 0] - c) * f) * strength
                    d = (d + (colours[1, at + 1, 1] - d) * f) * strength
                    e = (e + (colours[1, at + 1, 2] - e) * f) * strength
                    mist = cover[j] * (1.0 - fog[j])
                    red[j] = red[j] * fog[j] + mist * ti.cast(Q[FOG_RED], ti.f32)
                    green[j] = green[j] * fog[j] + mist * ti.cast(Q[FOG_GREEN], ti.f32)
                    blue[j] = blue[j] * fog[j] + mist * ti.cast(Q[FOG_BLUE], ti.f32)
                    if Q[LIT] > 0.5:
                        place[j], place[LANES + j], place[2 * LANES + j] = c, d, e
                        breadth = half[j] / per[j] * SOFT
                        place[3 * LANES + j] = ti.select(part[j] > 0.0, through[j] * AREA * breadth * breadth, 0.0)
                    else:
                        red[j], green[j], blue[j] = red[j] + c, green[j] + d, blue[j] + e
            else:
                for j in range(LANES):
                    red[j], green[j], blue[j] = red[j] * fog[j], green[j] * fog[j], blue[j] * fog[j]
            # what a sprite shows: reach and edge, with the lens; what is out of the frame or gives nothing is hidden
            shown, edge = _lanes(0.0), _lanes(0.0)
            for j in range(LANES):
                circle = ti.cast(Q[LENS], ti.f32) * abs(scale / ti.cast(Q[FOCUS], ti.f32) - per[j])
                reach = half[j] * SOFT
                dot = (kind == POINT) & (mode < 2)
                soft = ti.select(dot, SMALLEST, ti.sqrt(reach * reach + SMALLEST * SMALLEST))
                s = ti.sqrt(soft * soft + circle * circle * BOKEH)
                e = -unit(key[0, i0 + j], key[1, i0 + j], 21)  # spreads the size at which it moves to a coarser film
                if (kind <= DISC) & (circle > soft):  # an even disc; a smaller one only widens the sprite
                    s, e = circle, SOFT_RIM * soft
                elif dot & (Q[LENS] == 0.0):
                    s = 0.0
                elif kind == SPHERE:
                    s = ti.max(ti.max(half[j], circle), ti.sqrt((half[j] * half[j] + circle * circle) * CONE))
                    e = ti.max(ti.min(SHARP_RIM * ti.min(half[j], circle), s), SOFTEST)
                elif kind == PICTURE:
                    s, e = ti.sqrt(half[j] * half[j] + 1.0 + circle * circle), 0.0
                    dx[j], dy[j] = quantity[LANES + j], unit(key[0, i0 + j], key[1, i0 + j], 31)
                shown[j], edge[j] = s, e
                beyond = (ti.max(s, 1.0) + e) * 1.5 + ti.select(kind == STREAK, ti.max(abs(dx[j]), abs(dy[j])), 0.0)
                seen = (part[j] > 0.0) & (px[j] > -beyond) & (px[j] < width + beyond)
                seen = seen & (py[j] > -beyond) & (py[j] < rows + beyond)
                gives = (cover[j] > 0.0) | (red[j] + green[j] + blue[j] > 0.0) | (Q[LIT] > 0.5)
                shown[j] = ti.select(seen & gives, shown[j], HIDDEN)
            for j in range(ti.min(LANES, n - i0)):
                i = i0 + j
                at = ti.select(Q[SNAP] > 0.5, ti.floor(px[j]) + 0.5, px[j])
                C[X, i] = ti.select(shown[j] == HIDDEN, OUTSIDE, at)
                C[Y, i] = ti.select(Q[SNAP] > 0.5, ti.floor(py[j]) + 0.5, py[j])
                C[DX, i], C[DY, i] = dx[j], dy[j]
                C[REACH, i], C[EDGE, i], C[DEPTH, i] = shown[j], edge[j], ahead[j]
                C[RED, i], C[GREEN, i], C[BLUE, i], C[ALPHA, i] = red[j], green[j], blue[j], cover[j]
            if Q[LIT] > 0.5:
                for j in range(ti.min(LANES, n - i0)):
                    i = i0 + j
                    for c in ti.static(range(3)):
                        A[i, c], A[i, 4 + c] = ti.cast(S[c, i], ti.f32), place[c * LANES + j]
                    A[i, 3], A[i, 7] = place[3 * LANES + j], half[j] / per[j]


shade_kernel = kernel(_shade)


NO_ACCELERATION = np.zeros(1, np.float32)


class Columns:
    """One system's particles on the picture: `rows` (11, capacity) float32, of which `count` are in use;
    reused. There is always room for a whole tile at the end.
    """

    def __init__(self):
        self.rows = np.zeros((COLUMNS, 0), np.float32)
        self.lit = np.zeros((1, 8), np.float32)
        self.count = 0

    def reserve(self, n: int, lit: bool) -> None:
        if n > self.rows.shape[1]:
            self.rows = aligned((COLUMNS, (n + n // 8) // 32 * 32 + 32), np.float32)
        if lit and n > len(self.lit):
            self.lit = np.empty((n + n // 8, 8), np.float32)
        self.count = n

    @property
    def used(self) -> np.ndarray:
        return self.rows[:, : self.count]


def shade(columns: Columns, system, shading: LookTables, q: np.ndarray, acceleration=None) -> None:
    """Fill the columns from a system. For a lit look `columns.lit` (n, 8) holds position, extinction cross section,
    albedo times cover, whose light is still to be added, and radius. acceleration : (n,) m/s^2, 0 unless given
    """
    n = int(system.count)
    columns.reserve(n, q[LIT] > 0.5)
    if n:
        shade_kernel(
            system.floats, system.birth, system.key, system.id, system.source, shading.rows(system.sources),
            NO_ACCELERATION if acceleration is None else acceleration, n,
            columns.rows, columns.lit, shading.ramps, shading.curves, shading.colours, q,
        )  # fmt: skip
