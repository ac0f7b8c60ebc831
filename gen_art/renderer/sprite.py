"""Sprites: a point, a soft disc, a streak, a sphere or an image, each a row of float32, and the kernels that spread its light.

The weights of a sprite are divided by their sum over its whole footprint. So every sprite gives exactly its energy,
wherever its centre lies between pixels; only the frame's border cuts light off.

Kernel of a disc, per axis: g(t) = (1 - 0.3125 t^2)^8 (1 - t^2)^2, t = distance / footprint, where the footprint (the distance
at which the kernel becomes 0) is 3.3 standard deviations: a Gaussian that ends smoothly.
A streak is a disc swept along a segment. Along its longer axis its profile is the integral of the kernel between the two ends;
across that axis it is the kernel about the segment, with the covariance of the swept disc.
A piece is a part of a curved streak: the same, but cut off at right angles, so that neighbours add up where they join.
A sphere is an even disc of radius `footprint` whose rim falls to 0 over +-`edge`. What a lens makes of a point out of focus is
drawn in the same way.

Large discs are smooth, so they are drawn into framebuffers of a half, a quarter or an eighth of the size (`LEVEL`). Those are
composited over the full-size one with bilinear weights; the discs' footprint is shortened by what these weights add.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.surfaces.hiding import BEFORE, BEHIND, place_among_surfaces

__all__ = ["AREA", "profile", "profile_integral", "rim_profile", "smooth_step", "streak_profile", "write_sprites"]

# kinds of sprites
# COVERED_DISC: a disc of which surfaces hide a part
POINT, DISC, STREAK, SPHERE, PICTURE, PIECE, ELLIPSE, COVERED_DISC = range(8)
KINDS = {
    "pixel": POINT,
    "point": POINT,
    "disc": DISC,
    "streak": STREAK,
    "sphere": SPHERE,
    "body": SPHERE,  # for shading alone: these three are drawn as surfaces
    "thread": SPHERE,
    "cloth": SPHERE,
    "surface": SPHERE,
    "picture": PICTURE,
}  # keys: the look's `draw`
# Channels of a projected particle: position (pixels), footprint (pixels), EDGE, movement (pixels), light times area,
# coverage times area, depth. EDGE is the half width of an even disc's rim; for other sprites, minus a random number in 0..1.
X, Y, FOOTPRINT, EDGE, DX, DY, RED, GREEN, BLUE, ALPHA, DEPTH = range(11)
CHANNELS = 11
# A sprite is a row of the same numbers (its depth is kept elsewhere) and of six more. 64 bytes are one cache line.
# THICKNESS is a sprite's extent along the line of sight if surfaces hide a part of it, otherwise 0.
SLOPE, ACROSS, NORM, TAIL, TAPER, THICKNESS = range(10, 16)
SPRITE_FLOATS = 16
# image sprites use some of these for other values
AGE, RANDOM = DX, DY  # channels: seconds, and a number in 0..1
COSINE, SINE, FIRST_TEXEL, LEVEL_SIDE = DX, DY, SLOPE, ACROSS  # numbers of the row: rotation and mipmap level
# integers of a sprite: the pixels it covers (clipped to the frame; BOTTOM < TOP: none), its framebuffer, its kind
LEFT, RIGHT, TOP, BOTTOM, LEVEL, KIND = range(6)
SPRITE_INTS = 6
HIDDEN, OUTSIDE = -1.0, -1e9  # footprint of a hidden particle, and the x of what is off the picture
FOOTPRINT_PER_RADIUS = 1.5  # a disc's footprint divided by its radius
MIN_FOOTPRINT = 1.5  # pixels of footprint: a standard deviation of 0.45; a narrower kernel would alias
MIN_RIM = 0.75  # pixels: smallest half width of an even disc's rim
LEVEL_FOOTPRINT = 8.0  # pixels of footprint from which a disc is drawn at half the size; from twice that, a quarter
MAX_LEVEL = 3
KERNEL_VARIANCE = 0.0903  # of the kernel of footprint 1
COARSE_VARIANCE = 3.0 / 16.0  # that the weights 3/4 and 1/4 add when a framebuffer is composited, in its pixels squared
MIN_STREAK_FOOTPRINT = 1.15  # MIN_FOOTPRINT for a streak, whose weights are integrals over pixels
INTEGRAL_FOOTPRINT = 64.0  # pixels of footprint from which a kernel's sum is its integral (to 1e-6)

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
H2 = ti.types.ndarray(ti.i16, 2)


def profile_integral() -> float:
    """The integral of g over -1..1."""
    integral = (np.poly1d([-0.3125, 0.0, 1.0]) ** 8 * np.poly1d([-1.0, 0.0, 1.0]) ** 2).integ()
    return float(integral(1.0) - integral(-1.0))


LENGTH = profile_integral()
AREA = LENGTH * LENGTH  # area under a disc of footprint 1 and height 1


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
def axis_sum(centre, footprint):
    """The sum of g over all pixel centres of one axis."""
    total = LENGTH * footprint
    if footprint < INTEGRAL_FOOTPRINT:
        total = 0.0
        first = ti.cast(ti.floor(centre - footprint), ti.i32)
        last = ti.cast(ti.floor(centre + footprint), ti.i32)
        for k in range(first, last + 1):
            total += profile((ti.cast(k, ti.f32) + 0.5 - centre) / footprint)
    return total


@ti.func
def smooth_step(t):
    """A smooth step from 0 at t = -1 to 1 at t = 1. Its slope is proportional to (1 - t^2)^4, close to the kernel."""
    u = ti.min(ti.max(t, -1.0), 1.0)
    s = u * u
    return 0.5 + u * (1.23046875 + s * (-1.640625 + s * (1.4765625 + s * (-0.703125 + s * 0.13671875))))


@ti.func
def streak_profile(a, span, footprint, tail):
    """A streak's brightness at distance `a` from its old end along the longer axis; span > 0 is its length there."""
    value = 0.0
    if span < footprint * 0.3333333:
        value = profile((a - 0.5 * span) / ti.sqrt(footprint * footprint + span * span / (12.0 * KERNEL_VARIANCE)))
    else:
        inverse = 1.0 / footprint
        value = ti.max(smooth_step(a * inverse) - smooth_step((a - span) * inverse), 0.0)
    return value * (tail + (1.0 - tail) * ti.min(ti.max(a / span, 0.0), 1.0))


@ti.func
def streak_margin(span, footprint):
    """Distance by which a streak's light extends beyond its ends along the longer axis."""
    margin = footprint
    if span < footprint * 0.3333333:
        margin = ti.sqrt(footprint * footprint + span * span / (12.0 * KERNEL_VARIANCE))
    return margin


@ti.func
def streak_slope(dm, dn, footprint):
    """Slope of the centre line and footprint across it, for a streak that moves dm along its longer axis and dn across."""
    var = footprint * footprint * KERNEL_VARIANCE
    xx, xy, yy = var + dm * dm / 12.0, dm * dn / 12.0, var + dn * dn / 12.0
    return xy / xx, ti.sqrt(ti.max(yy - xy * xy / xx, 0.0) / KERNEL_VARIANCE)


@ti.func
def piece_weight(along, n, centre, half_width, below, slope, span, footprint, tail):
    """A piece's weight in a pixel: across it as a streak's, along it by the place of the pixel's foot on the segment.

    along : distance along the longer axis of the pixel's middle from the old end, positive towards the head
    n, centre : first coordinate of the pixel and that of the middle line, across
    below : the smooth step at n, which is returned for the next pixel with the weight
    """
    above = smooth_step((n + 1.0 - centre) / half_width)
    stretch = ti.sqrt(1.0 + slope * slope)
    foot = along * stretch + (n + 0.5 - centre) * slope / stretch
    return (above - below) * streak_profile(foot, span * stretch, footprint, tail), above


@ti.func
def piece_shape(x, y, dx, dy, footprint, tail, taper):
    """A piece's slope, half width across at its head, sum of weights, and how far its light reaches from its ends."""
    dm, dn, head_m, head_n = dx, dy, x, y
    vertical = abs(dy) > abs(dx)
    if vertical:
        dm, dn, head_m, head_n = dy, dx, y, x
    span, sign, slope = abs(dm), ti.select(dm > 0.0, 1.0, -1.0), dn / dm
    stretch = ti.sqrt(1.0 + slope * slope)
    # less the variance that a pixel's width adds
    across = ti.sqrt(ti.max((footprint * stretch) ** 2 - 1.0 / (12.0 * KERNEL_VARIANCE), 0.0))
    margin, half = streak_margin(span * stretch, footprint), ti.max(across, MIN_STREAK_FOOTPRINT)
    reach_m = (margin + abs(slope) * half) / stretch + 1.0
    reach_n = half + abs(slope) * reach_m + 1.0
    total = 0.0
    first = ti.cast(ti.floor(ti.min(head_m, head_m - dm) - reach_m), ti.i32)
    last = ti.cast(ti.floor(ti.max(head_m, head_m - dm) + reach_m), ti.i32)
    for m in range(first, last + 1):
        c = ti.cast(m, ti.f32) + 0.5 - head_m
        along = c * sign + span
        centre, half_width = head_n + slope * c, piece_half_width(across, taper, along / span)
        n0, n1 = ti.floor(centre - half_width), ti.floor(centre + half_width)
        below = smooth_step((n0 - centre) / half_width)
        for n in range(ti.cast(n0, ti.i32), ti.cast(n1, ti.i32) + 1):
            w, above = piece_weight(
                along, ti.cast(n, ti.f32), centre, half_width, below, slope * sign, span, footprint, tail
            )
            below = above
            total += w
    reach_x, reach_y = reach_m, reach_n
    if vertical:
        reach_x, reach_y = reach_n, reach_m
    return slope, across, total, reach_x, reach_y


@ti.func
def piece_half_width(across, taper, head):
    """Half the width across at a part of the length: 0 at the old end, 1 at the head."""
    return ti.max(across * (taper + (1.0 - taper) * ti.min(ti.max(head, 0.0), 1.0)), MIN_STREAK_FOOTPRINT)


@ti.func
def rim_profile(distance, footprint, edge):
    """An even disc's weight at a distance from its centre: 1 inside, falling to 0 over footprint +- edge."""
    return 1.0 - smooth_step((distance - footprint) / edge)


@ti.func
def rim_sum(x, y, footprint, edge):
    """The sum of `rim_profile` over all pixel centres; for a large disc its integral."""
    total = 3.14159265 * (footprint * footprint + edge * edge / 11.0)
    outer = footprint + edge
    if outer < INTEGRAL_FOOTPRINT:
        total = 0.0
        first, last = ti.cast(ti.floor(y - outer), ti.i32), ti.cast(ti.floor(y + outer), ti.i32)
        left, right = ti.cast(ti.floor(x - outer), ti.i32), ti.cast(ti.floor(x + outer), ti.i32)
        for k in range(first, last + 1):
            v = ti.cast(k, ti.f32) + 0.5 - y
            for m in range(left, right + 1):
                u = ti.cast(m, ti.f32) + 0.5 - x
                total += rim_profile(ti.sqrt(u * u + v * v), footprint, edge)
    return total


@ti.func
def choose_level(footprint, random):
    """The level (framebuffer of 1 / 2^level of the size) in which a disc is drawn, and its footprint there.

    random : in 0..1, the sprite's own. It spreads the size at which sprites change level, so that no edge shows where they grow.
    """
    level = 0
    limit = LEVEL_FOOTPRINT * (0.85 + 0.75 * random)
    while level < MAX_LEVEL and footprint >= limit:
        footprint *= 0.5
        level += 1
        # less the variance that bilinear weights add
        footprint = ti.sqrt(footprint * footprint - COARSE_VARIANCE / KERNEL_VARIANCE)
    return level, footprint


@ti.kernel
def _write_sprites(
    C: F2, start: ti.i32, n: ti.i32, P: F2, headers: H2, depths: F1, base: ti.i32, width: ti.i32, height: ti.i32,
    kind: ti.i32, ends: F2, min_footprint: ti.f32, surface_bins: F3, surface_tiles: F3, pixel: ti.f32, parallel: ti.i32,
):  # fmt: skip
    """Fill sprite rows base.. from particles start..start + n: the covered pixels, and the norm of the weights.

    C : (11, n) channels of the projected particles
    P : (n, 16) float rows of the sprites
    headers : (n, 6) integers of the sprites
    ends : (2, n), or (2, 1) for all: a streak's brightness and width at its old end, divided by those at its head
    min_footprint : particles with a footprint of this many pixels or less are left out
    surface_bins, surface_tiles, pixel, parallel : of SurfaceDepths; no rows where no surfaces are drawn
    """
    ti.loop_config(block_dim=1)
    for block in range((n + 2047) // 2048):
        for k in range(block * 2048, ti.min((block + 1) * 2048, n)):
            i, c = base + k, start + k
            own = ti.min(c, ends.shape[1] - 1)
            tail, taper = ends[0, own], ends[1, own]
            headers[i, TOP], headers[i, BOTTOM], headers[i, LEVEL], headers[i, KIND] = (
                ti.i16(1),
                ti.i16(0),
                ti.i16(0),
                ti.i16(kind),
            )
            depths[i] = C[DEPTH, c]
            x, y, footprint, edge, dx, dy = C[X, c], C[Y, c], C[FOOTPRINT, c], C[EDGE, c], C[DX, c], C[DY, c]
            partly_hidden = 0.0
            if surface_bins.shape[0] > 0 and footprint > min_footprint and footprint >= 0.0:
                wide = ti.max(footprint + ti.max(edge, 0.0), 1.0)
                thickness = wide / FOOTPRINT_PER_RADIUS * pixel * ti.select(parallel == 1, 1.0, C[DEPTH, c])
                reach = wide + ti.select((kind == STREAK) | (kind == PIECE), ti.max(abs(dx), abs(dy)), 0.0)
                among = place_among_surfaces(surface_bins, surface_tiles, x, y, reach, C[DEPTH, c], thickness)
                if among == BEHIND:
                    footprint = HIDDEN
                elif among != BEFORE:
                    partly_hidden = thickness
            if footprint > min_footprint and footprint >= 0.0:
                level, drawn_kind = 0, kind
                left, right, top, bottom = x - 0.5, x + 0.5, y - 0.5, y + 0.5
                if edge > 0.0:
                    drawn_kind = SPHERE
                    P[i, NORM] = 1.0 / ti.max(rim_sum(x, y, footprint, edge), 1e-30)
                    left, right = x - footprint - edge, x + footprint + edge
                    top, bottom = y - footprint - edge, y + footprint + edge
                elif footprint > 0.0 and ti.max(abs(dx), abs(dy)) < 1e-3:
                    drawn_kind = COVERED_DISC
                    if partly_hidden == 0.0:  # smaller framebuffers have no depths of surfaces
                        drawn_kind = DISC
                        level, footprint = choose_level(footprint, -edge)
                    scale = 1.0 / ti.cast(1 << level, ti.f32)
                    x, y = x * scale, y * scale
                    P[i, NORM] = scale * scale / (axis_sum(x, footprint) * axis_sum(y, footprint))
                    left, right, top, bottom = x - footprint, x + footprint, y - footprint, y + footprint
                elif footprint > 0.0 and kind == PIECE:
                    slope, across, total, reach_x, reach_y = piece_shape(x, y, dx, dy, footprint, tail, taper)
                    P[i, SLOPE], P[i, ACROSS], P[i, NORM] = slope, across, 1.0 / ti.max(total, 1e-30)
                    left, right = ti.min(x, x - dx) - reach_x, ti.max(x, x - dx) + reach_x
                    top, bottom = ti.min(y, y - dy) - reach_y, ti.max(y, y - dy) + reach_y
                elif footprint > 0.0:
                    dm, dn, head = dx, dy, x
                    vertical = abs(dy) > abs(dx)
                    if vertical:
                        dm, dn, head = dy, dx, y
                    span = abs(dm)
                    sign = dm / span
                    margin = streak_margin(span, footprint)
                    slope, across = streak_slope(dm, dn, footprint)
                    P[i, SLOPE] = slope
                    # less the variance that a pixel's width adds
                    P[i, ACROSS] = ti.sqrt(ti.max(across * across - 1.0 / (12.0 * KERNEL_VARIANCE), 0.0))
                    old_end = head - dm
                    total = 0.0
                    first = ti.cast(ti.floor(ti.min(old_end, head) - margin), ti.i32)
                    last = ti.cast(ti.floor(ti.max(old_end, head) + margin), ti.i32)
                    for m in range(first, last + 1):
                        total += streak_profile((ti.cast(m, ti.f32) + 0.5 - old_end) * sign, span, footprint, tail)
                    P[i, NORM] = 1.0 / ti.max(total, 1e-30)
                    half_height = ti.max(across, MIN_FOOTPRINT) + abs(slope) * margin + 0.5
                    left, right = ti.min(x, x - dx), ti.max(x, x - dx)
                    top, bottom = ti.min(y, y - dy), ti.max(y, y - dy)
                    if vertical:
                        left, right = left - half_height, right + half_height
                        top, bottom = top - margin, bottom + margin
                    else:
                        left, right = left - margin, right + margin
                        top, bottom = top - half_height, bottom + half_height
                P[i, X], P[i, Y], P[i, FOOTPRINT], P[i, EDGE], P[i, DX], P[i, DY] = x, y, footprint, edge, dx, dy
                for e in ti.static((RED, GREEN, BLUE, ALPHA)):
                    P[i, e] = C[e, c]
                P[i, TAIL], P[i, TAPER], P[i, THICKNESS] = tail, taper, partly_hidden
                rounding = (1 << level) - 1
                w, h = ti.cast((width + rounding) >> level, ti.f32), ti.cast((height + rounding) >> level, ti.f32)
                left, right = ti.floor(ti.max(left, 0.0)), ti.floor(ti.min(right, w - 0.5))
                top, bottom = ti.floor(ti.max(top, 0.0)), ti.floor(ti.min(bottom, h - 0.5))
                if right >= left and bottom >= top:
                    headers[i, LEFT], headers[i, RIGHT] = ti.cast(left, ti.i16), ti.cast(right, ti.i16)
                    headers[i, TOP], headers[i, BOTTOM] = ti.cast(top, ti.i16), ti.cast(bottom, ti.i16)
                headers[i, LEVEL], headers[i, KIND] = ti.cast(level, ti.i16), ti.cast(drawn_kind, ti.i16)


write_sprites = kernel(_write_sprites)
