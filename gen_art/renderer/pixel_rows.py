"""Weights of eight pixels of a row or of a column at once, by whole vectors; each has the bits of what sprite.py finds for one.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.sprite import KERNEL_VARIANCE

__all__ = [
    "CENTRES", "EDGES", "larger", "piece_row", "row_of", "row_profile", "row_share", "row_smooth_step",
    "row_streak_profile", "smaller",
]  # fmt: skip

CENTRES = tuple(k + 0.5 for k in range(TILE))  # of the pixels of a row or a column
EDGES = tuple(float(k) for k in range(TILE))  # their first coordinates


@ti.func
def row_of(x):
    """A vector with a lane for each pixel of a row, or of a column, and the same float in each."""
    return ti.Vector([ti.cast(x, ti.f32) for _ in ti.static(range(TILE))])


@ti.func
def smaller(x, y):
    return ti.select(x < y, x, y)


@ti.func
def larger(x, y):
    return ti.select(x > y, x, y)


@ti.func
def row_profile(square):
    """sprite.profile of each lane of a row, from its argument squared."""
    one = row_of(1.0)
    s = smaller(square, one)
    a = one - row_of(0.3125) * s
    a2 = a * a
    a4 = a2 * a2
    b = one - s
    return a4 * a4 * (b * b)


@ti.func
def row_smooth_step(t):
    """sprite.smooth_step of each lane of a row."""
    u = smaller(larger(t, row_of(-1.0)), row_of(1.0))
    s = u * u
    p = row_of(-0.703125) + s * row_of(0.13671875)
    for coefficient in ti.static((1.4765625, -1.640625, 1.23046875)):
        p = row_of(coefficient) + s * p
    return row_of(0.5) + u * p


@ti.func
def row_share(x):
    """Each lane of a row, between 0 and 1."""
    return smaller(larger(x, row_of(0.0)), row_of(1.0))


@ti.func
def row_streak_profile(along, span, footprint, tail):
    """sprite.streak_profile of each lane of a row."""
    value = row_of(0.0)
    if span < footprint * 0.3333333:
        t = (along - row_of(0.5 * span)) / row_of(
            ti.sqrt(footprint * footprint + span * span / (12.0 * KERNEL_VARIANCE))
        )
        value = row_profile(t * t)
    else:
        inverse = row_of(1.0 / footprint)
        value = larger(
            row_smooth_step(along * inverse) - row_smooth_step((along - row_of(span)) * inverse), row_of(0.0)
        )
    return value * (row_of(tail) + row_of(1.0 - tail) * row_share(along / row_of(span)))


@ti.func
def piece_row(n, centre, along, half_width, slope, span, stretch, footprint, tail):
    """sprite.piece_weight of a row of pixels across a piece, all at the same place along it.

    n : first coordinate of each pixel, across
    """
    middle, half = row_of(centre), row_of(half_width)
    across = row_smooth_step((n + row_of(1.0) - middle) / half) - row_smooth_step((n - middle) / half)
    foot = row_of(along * stretch) + (n + row_of(0.5) - middle) * row_of(slope) / row_of(stretch)
    return across * row_streak_profile(foot, span * stretch, footprint, tail)
