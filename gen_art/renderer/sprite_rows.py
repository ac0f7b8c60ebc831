"""Sprites from projected particles: the kernel that finds which pixels each covers, and what its weights are divided by.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.pixel_rows import EDGES, piece_row, row_of
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
    FOOTPRINT,
    FOOTPRINT_PER_RADIUS,
    GREEN,
    HIDDEN,
    KERNEL_VARIANCE,
    KIND,
    LEFT,
    LENGTH,
    LEVEL,
    LEVEL_FOOTPRINT,
    MIN_FOOTPRINT,
    MIN_STREAK_FOOTPRINT,
    NORM,
    PIECE,
    RED,
    RIGHT,
    SLOPE,
    SPHERE,
    STREAK,
    TAIL,
    TAPER,
    THICKNESS,
    TOP,
    X,
    Y,
    piece_half_width,
    profile,
    rim_profile,
    streak_profile,
)
from gen_art.renderer.surfaces.hiding import BEFORE, BEHIND, place_among_surfaces

__all__ = ["axis_sum", "choose_level", "rim_sum", "write_sprites"]

MAX_LEVEL = 3
INTEGRAL_FOOTPRINT = 64.0  # pixels of footprint from which a kernel's sum is its integral (to 1e-6)

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, H2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i16, 2)


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
    total, leaning = 0.0, slope * sign
    first = ti.cast(ti.floor(ti.min(head_m, head_m - dm) - reach_m), ti.i32)
    last = ti.cast(ti.floor(ti.max(head_m, head_m - dm) + reach_m), ti.i32)
    for m in range(first, last + 1):
        c = ti.cast(m, ti.f32) + 0.5 - head_m
        along = c * sign + span
        centre, half_width = head_n + slope * c, piece_half_width(across, taper, along / span)
        n0 = ti.floor(centre - half_width)
        pixels = ti.cast(ti.floor(centre + half_width) - n0, ti.i32) + 1
        for row in range((pixels + TILE - 1) // TILE):  # beyond its half width a piece has no weight
            n = ti.Vector(EDGES) + row_of(n0 + ti.cast(row * TILE, ti.f32))
            weights = piece_row(n, centre, along, half_width, leaning, span, stretch, footprint, tail)
            for k in ti.static(range(TILE)):
                total += weights[k]
    reach_x, reach_y = reach_m, reach_n
    if vertical:
        reach_x, reach_y = reach_n, reach_m
    return slope, across, total, reach_x, reach_y


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
    kinds: I1, ends: F2, min_footprint: ti.f32, surface_bins: F3, surface_tiles: F3, pixel: ti.f32, parallel: ti.i32,
):  # fmt: skip
    """Fill sprite rows base.. from particles start..start + n: the covered pixels, and the norm of the weights.

    C : (11, n) channels of the projected particles
    P : (n, 16) float rows of the sprites
    headers : (n, 6) integers of the sprites
    kinds : (n,), or (1,) for all
    ends : (2, n), or (2, 1) for all: a streak's brightness and width at its old end, divided by those at its head
    min_footprint : particles with a footprint of this many pixels or less are left out
    surface_bins, surface_tiles, pixel, parallel : of SurfaceDepths; no rows where no surfaces are drawn
    """
    ti.loop_config(block_dim=1)
    for block in range((n + 2047) // 2048):
        for k in range(block * 2048, ti.min((block + 1) * 2048, n)):
            i, c = base + k, start + k
            kind, own = kinds[ti.min(c, kinds.shape[0] - 1)], ti.min(c, ends.shape[1] - 1)
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


write_sprites = kernel(_write_sprites, vectors=True)
