"""How much of a sprite surfaces hide, in kernels.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.picture_tiles import BIN, TILE

__all__ = ["BEFORE", "BEHIND", "PARTLY", "place_among_surfaces", "visible_share"]

BEFORE, PARTLY, BEHIND = 0, 1, 2


@ti.func
def visible_share(depths: ti.template(), row, column, depth, thickness):
    """The share of a sprite's light in a pixel that surfaces do not hide.

    depth, thickness : of the sprite, along the line of sight
    """
    total = 0.0
    for s in range(depths.shape[2]):
        before = (depths[row, column, s] - depth) / ti.max(thickness, 1e-30) + 0.5
        total += ti.min(ti.max(before, 0.0), 1.0)
    return total / ti.cast(depths.shape[2], ti.f32)


@ti.func
def _least_and_largest(bounds: ti.template(), side, x, y, reach):
    """The least and the largest depth in the squares of `side` pixels that a sprite touches."""
    x0 = ti.max(ti.cast(ti.floor((x - reach) / side), ti.i32), 0)
    x1 = ti.min(ti.cast(ti.floor((x + reach) / side), ti.i32), bounds.shape[1] - 1)
    y0 = ti.max(ti.cast(ti.floor((y - reach) / side), ti.i32), 0)
    y1 = ti.min(ti.cast(ti.floor((y + reach) / side), ti.i32), bounds.shape[0] - 1)
    low, high = 3e38, -3e38
    for j in range(y0, y1 + 1):
        for i in range(x0, x1 + 1):
            low, high = ti.min(low, bounds[j, i, 0]), ti.max(high, bounds[j, i, 1])
    return low, high


@ti.func
def place_among_surfaces(bins: ti.template(), tiles: ti.template(), x, y, reach, depth, thickness):
    """BEFORE all surfaces in the squares of pixels that a sprite touches, BEHIND them all, or PARTLY hidden.

    bins, tiles : of SurfaceDepths; small sprites are placed by tiles
    x, y, reach : middle and largest half extent in pixels
    """
    low, high = 0.0, 0.0
    if reach <= BIN / 2:
        low, high = _least_and_largest(tiles, TILE, x, y, reach)
    else:
        low, high = _least_and_largest(bins, BIN, x, y, reach)
    result = PARTLY
    if depth + 0.5 * thickness <= low:
        result = BEFORE
    elif depth - 0.5 * thickness >= high:
        result = BEHIND
    return result
