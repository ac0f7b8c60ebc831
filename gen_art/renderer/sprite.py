"""A sprite: a point, a soft disc or a streak, as a row of 21 float32, and how its light is spread.

Its light is spread by weights that are divided by their sum over its whole footprint, so every sprite gives exactly its
energy wherever its middle lies between pixels; only the frame's border cuts.

Kernel of a disc, per axis: g(t) = (1 - 0.3125 t^2)^8 (1 - t^2)^2, t = distance / reach, reach = 3.3 standard deviations:
a Gaussian that ends softly. A streak is a disc swept along a segment: its profile along the longer axis is the
integral of the kernel between the ends, across it the kernel about the segment, with the covariance of the swept disc.

Large discs are smooth, so they move to films of a half, a quarter or an eighth of the size (`LEVEL`), which are laid over
the film with bilinear weights; their reach is shortened by what that adds.
"""

import numpy as np

from gen_art.runtime import ti

__all__ = ["AREA", "along", "coarsen", "finish", "profile", "profile_integral", "step"]

# columns of a sprite's row
(
    X,
    Y,
    REACH,
    DX,
    DY,
    RED,
    GREEN,
    BLUE,
    ALPHA,
    DEPTH,
    FIRST,
    LAST,
    LEFT,
    RIGHT,
    NORM_X,
    NORM_Y,
    TAIL,
    TAPER,
    SLOPE,
    ACROSS,
    LEVEL,
) = range(21)
COLUMNS = 21
SMALLEST = 1.5  # pixels of reach: a standard deviation of 0.45, or the kernel would alias
COARSE = 16.0  # pixels of reach from which a disc is drawn at half the size, then at a quarter, an eighth
COARSEST = 3
VARIANCE = 0.0903  # of the kernel of reach 1
THINNEST = 1.15  # the same for a streak, whose weights are integrals over pixels
WIDE = 64.0  # pixels of reach from which the kernel's sum is its integral (to 1e-6)


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
def finish(P: ti.template(), i, width, rows):
    """Fill in the pixels a sprite touches (clipped to the frame; LAST < FIRST: none) and its norms; x, y, reach, dx, dy
    and tail must be there.
    """
    x, y, reach, dx, dy = P[i, X], P[i, Y], P[i, REACH], P[i, DX], P[i, DY]
    left, right = ti.min(x, x - dx), ti.max(x, x - dx)
    low, high = ti.min(y, y - dy), ti.max(y, y - dy)
    if reach <= 0.0:
        left, right, low, high = x - 0.5, x + 0.5, y - 0.5, y + 0.5
    elif ti.max(abs(dx), abs(dy)) < 1e-3:
        left, right, low, high = x - reach, x + reach, y - reach, y + reach
        P[i, DX], P[i, DY] = 0.0, 0.0
        P[i, NORM_X], P[i, NORM_Y] = 1.0 / line_sum(x, reach), 1.0 / line_sum(y, reach)
    else:
        dm, dn, end = dx, dy, x
        upright = abs(dy) > abs(dx)
        if upright:
            dm, dn, end = dy, dx, y
        span = abs(dm)
        sign = dm / span
        margin = streak_margin(span, reach)
        slope, across = streak_slope(dm, dn, reach)
        P[i, SLOPE] = slope
        P[i, ACROSS] = ti.sqrt(ti.max(across * across - 1.0 / (12.0 * VARIANCE), 0.0))  # what a pixel's width adds
        start = end - dm
        total = 0.0
        first = ti.cast(ti.floor(ti.min(start, end) - margin), ti.i32)
        last = ti.cast(ti.floor(ti.max(start, end) + margin), ti.i32)
        for k in range(first, last + 1):
            total += along((ti.cast(k, ti.f32) + 0.5 - start) * sign, span, reach, P[i, TAIL])
        P[i, NORM_X] = 1.0 / ti.max(total, 1e-30)
        swing = ti.max(across, SMALLEST) + abs(slope) * margin + 0.5
        if upright:
            left, right, low, high = left - swing, right + swing, low - margin, high + margin
        else:
            left, right, low, high = left - margin, right + margin, low - swing, high + swing
    P[i, LEFT], P[i, RIGHT] = ti.floor(ti.max(left, 0.0)), ti.floor(ti.min(right, ti.cast(width, ti.f32) - 0.5))
    P[i, FIRST], P[i, LAST] = ti.floor(ti.max(low, 0.0)), ti.floor(ti.min(high, ti.cast(rows, ti.f32) - 0.5))
    if P[i, RIGHT] < P[i, LEFT]:
        P[i, LAST] = P[i, FIRST] - 1.0


@ti.func
def coarsen(P: ti.template(), i, chance):
    """Move a disc to the film of its size: energy, place and reach in that film's pixels. `chance` in 0..1, the sprite's
    own, spreads the size at which that happens, so that no edge shows where sprites grow past it.
    """
    level = 0
    limit = COARSE * (0.75 + 0.75 * chance)
    while level < COARSEST and P[i, REACH] >= limit:
        for c in ti.static((X, Y, REACH)):
            P[i, c] = P[i, c] * 0.5
        for c in ti.static((RED, GREEN, BLUE, ALPHA)):
            P[i, c] = P[i, c] * 0.25
        level += 1
        P[i, REACH] = ti.sqrt(P[i, REACH] * P[i, REACH] - 1.0 / (6.0 * VARIANCE))  # what bilinear weights add
    P[i, LEVEL] = ti.cast(level, ti.f32)
    return level
