"""Pieces of curved streaks, drawn into a tile.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.sprite import (
    ACROSS,
    BLUE,
    DX,
    DY,
    FOOTPRINT,
    GREEN,
    NORM,
    RED,
    SLOPE,
    TAIL,
    TAPER,
    piece_half_width,
    piece_weight,
    smooth_step,
)

__all__ = ["draw_piece"]


@ti.func
def draw_piece(P: ti.template(), i, tile: ti.template(), x, y, left, right, top, bottom, side):
    """Draw a piece column by column along its longer axis, as `piece_shape` sums its weights.

    tile : side x side pixels of four floats
    x, y : the head, from the tile's corner
    left, right, top, bottom : first column and row that it touches, and the ends of both
    """
    footprint, slope, across, tail, taper = P[i, FOOTPRINT], P[i, SLOPE], P[i, ACROSS], P[i, TAIL], P[i, TAPER]
    dm, head_m, head_n = P[i, DX], x, y
    low, high, low_n, high_n = left, right, top, bottom  # limits along and across
    step_m, step_n = 4, 4 * side
    if abs(P[i, DY]) > abs(P[i, DX]):
        dm, head_m, head_n = P[i, DY], y, x
        low, high, low_n, high_n = top, bottom, left, right
        step_m, step_n = 4 * side, 4
    span, sign = abs(dm), ti.select(dm > 0.0, 1.0, -1.0)
    r, g, b = P[i, RED] * P[i, NORM], P[i, GREEN] * P[i, NORM], P[i, BLUE] * P[i, NORM]
    for m in range(low, high):
        c = ti.cast(m, ti.f32) + 0.5 - head_m
        along = c * sign + span
        centre, half_width = head_n + slope * c, piece_half_width(across, taper, along / span)
        first = ti.max(ti.cast(ti.floor(centre - half_width), ti.i32), low_n)
        last = ti.min(ti.cast(ti.floor(centre + half_width), ti.i32), high_n - 1)
        below = smooth_step((ti.cast(first, ti.f32) - centre) / half_width)
        for n in range(first, last + 1):
            w, above = piece_weight(
                along, ti.cast(n, ti.f32), centre, half_width, below, slope * sign, span, footprint, tail
            )
            below = above
            o = m * step_m + n * step_n
            tile[o] += r * w
            tile[o + 1] += g * w
            tile[o + 2] += b * w
