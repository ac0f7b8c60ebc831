"""A sprite: a point, a soft disc, a streak, a sphere or a picture, as a row of float32, and how its light is spread.

Its light is spread by weights that are divided by their sum over its whole footprint, so every sprite gives exactly its
energy wherever its middle lies between pixels; only the frame's border cuts.

Kernel of a disc, per axis: g(t) = (1 - 0.3125 t^2)^8 (1 - t^2)^2, t = distance / reach, reach = 3.3 standard deviations:
a Gaussian that ends softly. A streak is a disc swept along a segment: its profile along the longer axis is the
integral of the kernel between the ends, across it the kernel about the segment, with the covariance of the swept disc.
A sphere, or what a lens draws of a point out of focus, is an even disc of radius `reach` whose rim falls over +-`edge`.

Large discs are smooth, so they move to films of a half, a quarter or an eighth of the size (`LEVEL`), which are laid over
the film with bilinear weights; their reach is shortened by what that adds.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti

__all__ = ["AREA", "along", "finish", "profile", "profile_integral", "rim", "step"]

# what is drawn
POINT, DISC, STREAK, SPHERE, PICTURE = range(5)
KINDS = {
    "pixel": POINT,
    "point": POINT,
    "disc": DISC,
    "streak": STREAK,
    "sphere": SPHERE,
    "picture": PICTURE,
}  # by `draw`
# a particle on the picture, channel by channel: the first eleven; then what drawing a sprite needs, a row each
X, Y, REACH, EDGE, DX, DY, RED, GREEN, BLUE, ALPHA, DEPTH = range(11)
COLUMNS = 11
SLOPE, ACROSS, NORM, TAIL, TAPER, _SPARE = range(10, 16)  # a row keeps its depth elsewhere: 64 bytes, a line of cache
ROW = 16
# whole numbers beside a row: the pixels it touches, the film it is drawn in, what it is
LEFT, RIGHT, FIRST, LAST, LEVEL, KIND = range(6)
MARKS = 6
HIDDEN, OUTSIDE = -1.0, -1e9  # the reach of what is not drawn, and where it is
SMALLEST = 1.5  # pixels of reach: a standard deviation of 0.45, or the kernel would alias
SOFTEST = 0.75  # pixels: the least half width of an even disc's rim
COARSE = 16.0  # pixels of reach from which a disc is drawn at half the size, then at a quarter, an eighth
COARSEST = 3
VARIANCE = 0.0903  # of the kernel of reach 1
THINNEST = 1.15  # the same for a streak, whose weights are integrals over pixels
WIDE = 64.0  # pixels of reach from which a kernel's sum is its integral (to 1e-6)

F1, F2, H2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i16, 2)


def profile_integral() -> float:
    """The integral of g over -1..1."""
    t = (np.arange(200_000) + 0.5) / 200_000
    return float(2.0 * np.mean((1.0 - 0.3125 * t * t) ** 8 * (1.0 - t * t) ** 2))


LENGTH = profile_integral()
AREA = LENGTH * LENGTH  # area under a disc of reach 1 and height 1


@ti.func
def profile(t):
    """g(t), 0 outside -1..1."""
    s = ti.min(t * t, 1.0)
    a = 1.0 - 0.3125 * s
    a2 = a * a
    a4 = a2 * a2
    b = 1.0 - s
    return a4 * a4 * (b * b)


@ti.func
def line_sum(middle, reach):
    """The sum of g over all pixel centres of one axis."""
    total = LENGTH * reach
    if reach < WIDE:
        total = 0.0
        first = ti.cast(ti.floor(middle - reach), ti.i32)
        last = ti.cast(ti.floor(middle + reach), ti.i32)
        for k in range(first, last + 1):
            total += profile((ti.cast(k, ti.f32) + 0.5 - middle) / reach)
    return total


@ti.func
def step(t):
    """A smooth step from 0 at t = -1 to 1 at t = 1, nearly the kernel's integral: its slope goes as (1 - t^2)^4."""
    u = ti.min(ti.max(t, -1.0), 1.0)
    s = u * u
    return 0.5 + u * (1.23046875 + s * (-1.640625 + s * (1.4765625 + s * (-0.703125 + s * 0.13671875))))


@ti.func
def along(a, span, reach, tail):
    """A streak's brightness at distance `a` from its old end along the longer axis (span > 0: its length there)."""
    value = 0.0
    if span < reach * 0.3333333:
        value = profile((a - 0.5 * span) / ti.sqrt(reach * reach + span * span / (12.0 * VARIANCE)))
    else:
        inverse = 1.0 / reach
        value = ti.max(step(a * inverse) - step((a - span) * inverse), 0.0)
    return value * (tail + (1.0 - tail) * ti.min(ti.max(a / span, 0.0), 1.0))


@ti.func
def streak_margin(span, reach):
    """How far a streak's light goes beyond its ends along the longer axis."""
    margin = reach
    if span < reach * 0.3333333:
        margin = ti.sqrt(reach * reach + span * span / (12.0 * VARIANCE))
    return margin


@ti.func
def streak_slope(dm, dn, reach):
    """Slope of the middle line and reach across, for a streak dm along its longer axis and dn across."""
    var = reach * reach * VARIANCE
    xx, xy, yy = var + dm * dm / 12.0, dm * dn / 12.0, var + dn * dn / 12.0
    return xy / xx, ti.sqrt(ti.max(yy - xy * xy / xx, 0.0) / VARIANCE)


@ti.func
def rim(distance, reach, edge):
    """An even disc's weight at a distance from its middle: 1 inside, falling to 0 over reach +- edge."""
    return 1.0 - step((distance - reach) / edge)


@ti.func
def _rim_sum(x, y, reach, edge):
    """The sum of `rim` over all pixel centres; for a large disc its integral."""
    total = 3.14159265 * (reach * reach + edge * edge / 11.0)
    whole = reach + edge
    if whole < WIDE:
        total = 0.0
        first, last = ti.cast(ti.floor(y - whole), ti.i32), ti.cast(ti.floor(y + whole), ti.i32)
        left, right = ti.cast(ti.floor(x - whole), ti.i32), ti.cast(ti.floor(x + whole), ti.i32)
        for k in range(first, last + 1):
            v = ti.cast(k, ti.f32) + 0.5 - y
            for m in range(left, right + 1):
                u = ti.cast(m, ti.f32) + 0.5 - x
                total += rim(ti.sqrt(u * u + v * v), reach, edge)
    return total


@ti.func
def _coarser(reach, chance):
    """The film a disc is drawn in, and its reach there. `chance` in 0..1, the sprite's own, spreads the size at which that
    happens, so that no edge shows where sprites grow past it.
    """
    level = 0
    limit = COARSE * (0.75 + 0.75 * chance)
    while level < COARSEST and reach >= limit:
        reach *= 0.5
        level += 1
        reach = ti.sqrt(reach * reach - 1.0 / (6.0 * VARIANCE))  # what bilinear weights add
    return level, reach


@ti.kernel
def _finish(
    C: F2, start: ti.i32, n: ti.i32, P: F2, marks: H2, depths: F1, base: ti.i32, width: ti.i32, rows: ti.i32,
    kind: ti.i32, tail: ti.f32, taper: ti.f32, least: ti.f32,
):  # fmt: skip
    """Rows base.. of the sprites from columns start..start + n: the pixels each touches (clipped to the frame; LAST < FIRST:
    none) and its norms. Those of a reach of `least` or less are left out.
    """
    ti.loop_config(block_dim=1)
    for block in range((n + 2047) // 2048):
        for k in range(block * 2048, ti.min((block + 1) * 2048, n)):
            i, c = base + k, start + k
            marks[i, FIRST], marks[i, LAST], marks[i, LEVEL], marks[i, KIND] = (
                ti.i16(1),
                ti.i16(0),
                ti.i16(0),
                ti.i16(kind),
            )
            depths[i] = C[DEPTH, c]
            x, y, reach, edge, dx, dy = C[X, c], C[Y, c], C[REACH, c], C[EDGE, c], C[DX, c], C[DY, c]
            if reach > least and reach >= 0.0:
                level, what = 0, kind
                left, right, low, high = x - 0.5, x + 0.5, y - 0.5, y + 0.5
                if edge > 0.0:
                    what = SPHERE
                    P[i, NORM] = 1.0 / ti.max(_rim_sum(x, y, reach, edge), 1e-30)
                    left, right, low, high = x - reach - edge, x + reach + edge, y - reach - edge, y + reach + edge
                elif reach > 0.0 and ti.max(abs(dx), abs(dy)) < 1e-3:
                    what = DISC
                    level, reach = _coarser(reach, -edge)
                    shrink = 1.0 / ti.cast(1 << level, ti.f32)
                    x, y = x * shrink, y * shrink
                    P[i, NORM] = shrink * shrink / (line_sum(x, reach) * line_sum(y, reach))
                    left, right, low, high = x - reach, x + reach, y - reach, y + reach
                elif reach > 0.0:
                    dm, dn, end = dx, dy, x
                    upright = abs(dy) > abs(dx)
                    if upright:
                        dm, dn, end = dy, dx, y
                    span = abs(dm)
                    sign = dm / span
                    margin = streak_margin(span, reach)
                    slope, across = streak_slope(dm, dn, reach)
                    P[i, SLOPE] = slope
                    P[i, ACROSS] = ti.sqrt(ti.max(across * across - 1.0 / (12.0 * VARIANCE), 0.0))  # a pixel adds this
                    begin = end - dm
                    total = 0.0
                    first = ti.cast(ti.floor(ti.min(begin, end) - margin), ti.i32)
                    last = ti.cast(ti.floor(ti.max(begin, end) + margin), ti.i32)
                    for m in range(first, last + 1):
                        total += along((ti.cast(m, ti.f32) + 0.5 - begin) * sign, span, reach, tail)
                    P[i, NORM] = 1.0 / ti.max(total, 1e-30)
                    swing = ti.max(across, SMALLEST) + abs(slope) * margin + 0.5
                    left, right, low, high = ti.min(x, x - dx), ti.max(x, x - dx), ti.min(y, y - dy), ti.max(y, y - dy)
                    if upright:
                        left, right, low, high = left - swing, right + swing, low - margin, high + margin
                    else:
                        left, right, low, high = left - margin, right + margin, low - swing, high + swing
                P[i, X], P[i, Y], P[i, REACH], P[i, EDGE], P[i, DX], P[i, DY] = x, y, reach, edge, dx, dy
                for e in ti.static((RED, GREEN, BLUE, ALPHA)):
                    P[i, e] = C[e, c]
                P[i, TAIL], P[i, TAPER] = tail, taper
                side = (1 << level) - 1
                w, h = ti.cast((width + side) >> level, ti.f32), ti.cast((rows + side) >> level, ti.f32)
                left, right = ti.floor(ti.max(left, 0.0)), ti.floor(ti.min(right, w - 0.5))
                low, high = ti.floor(ti.max(low, 0.0)), ti.floor(ti.min(high, h - 0.5))
                if right >= left and high >= low:
                    marks[i, LEFT], marks[i, RIGHT] = ti.cast(left, ti.i16), ti.cast(right, ti.i16)
                    marks[i, FIRST], marks[i, LAST] = ti.cast(low, ti.i16), ti.cast(high, ti.i16)
                marks[i, LEVEL], marks[i, KIND] = ti.cast(level, ti.i16), ti.cast(what, ti.i16)


finish = kernel(_finish)
