"""Images drawn into bins of the framebuffer that hold nothing else, by whole pixels (RGBA), with the formulas of tiled_splat.py.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import INDEX_MASK, kernel, ti
from gen_art.renderer.picture_tiles import BIN
from gen_art.renderer.sprite import (
    ALPHA,
    BLUE,
    BOTTOM,
    COSINE,
    FIRST_TEXEL,
    FOOTPRINT,
    GREEN,
    LEFT,
    LEVEL_SIDE,
    NORM,
    RED,
    RIGHT,
    SINE,
    THICKNESS,
    TOP,
    X,
    Y,
)
from gen_art.renderer.surfaces.hiding import visible_share

__all__ = ["draw_pictures"]

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, H2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i16, 2)
PIXELS = ti.types.ndarray(ti.types.vector(4, ti.f32), 1)


@ti.func
def _four(x):
    return ti.Vector([ti.cast(x, ti.f32) for _ in ti.static(range(4))])


@ti.func
def _texel(T: ti.template(), start, side, u, v):
    """(4,) of a mipmap level at (u, v), in texels from its corner; 0 outside."""
    x, y = ti.floor(u - 0.5), ti.floor(v - 0.5)
    fx, fy = u - 0.5 - x, v - 0.5 - y
    i, j, total = ti.cast(x, ti.i32), ti.cast(y, ti.i32), _four(0.0)
    for k in ti.static(range(4)):
        a, b = i + k % 2, j + k // 2
        w = (fx if k % 2 else 1.0 - fx) * (fy if k // 2 else 1.0 - fy)
        inside = (a >= 0) & (b >= 0) & (a < side) & (b < side)
        total += _four(ti.select(inside, w, 0.0)) * T[(start + ti.select(inside, b * side + a, 0)) & INDEX_MASK]
    return total


@ti.kernel
def _draw_pictures(
    P: F2, T: PIXELS, headers: H2, entries: I1, firsts: I1, ends: I1, across: ti.i32, bins: ti.i32, framebuffer: PIXELS,
    stride: ti.i32, depths: F1, surfaces: F3,
):  # fmt: skip
    """Draw each bin's images, entries[firsts[bin]] to entries[ends[bin] - 1]; stride : pixels in a row of the framebuffer"""
    ti.loop_config(block_dim=1)
    for line in range(bins * BIN):
        bin = line // BIN
        row, first_column = (bin // across) * BIN + line % BIN, (bin % across) * BIN
        for k in range(firsts[bin], ends[bin]):
            i = entries[k]
            if row >= ti.cast(headers[i, TOP], ti.i32) and row <= ti.cast(headers[i, BOTTOM], ti.i32):
                norm, inverse, a, b = P[i, NORM], 1.0 / P[i, FOOTPRINT], P[i, COSINE], P[i, SINE]
                start, side = ti.cast(P[i, FIRST_TEXEL], ti.i32), ti.cast(P[i, LEVEL_SIDE], ti.i32)
                texel, thickness = P[i, LEVEL_SIDE] * 0.5, P[i, THICKNESS]
                light = ti.Vector([P[i, RED] * norm, P[i, GREEN] * norm, P[i, BLUE] * norm, P[i, ALPHA] * norm])
                q = (ti.cast(row, ti.f32) + 0.5 - P[i, Y]) * inverse
                left = ti.max(ti.cast(headers[i, LEFT], ti.i32), first_column)
                right = ti.min(ti.cast(headers[i, RIGHT], ti.i32), first_column + BIN - 1)
                for column in range(left, right + 1):
                    p = (ti.cast(column, ti.f32) + 0.5 - P[i, X]) * inverse
                    u, v = (1.0 + p * a - q * b) * texel, (1.0 + p * b + q * a) * texel
                    if ti.min(u, v) > -0.5 and ti.max(u, v) < P[i, LEVEL_SIDE] + 0.5:
                        place = (row * stride + column) & INDEX_MASK
                        shown = light * _texel(T, start, side, u, v)
                        if ti.max(ti.max(shown[0], shown[1]), ti.max(shown[2], shown[3])) > 0.0:
                            before, share = framebuffer[place], 1.0
                            if thickness > 0.0 and row < surfaces.shape[0] and column < surfaces.shape[1]:
                                share = visible_share(surfaces, row, column, depths[i], thickness)
                            framebuffer[place] = before + (shown - before * _four(ti.min(shown[3], 1.0))) * _four(share)


draw_pictures = kernel(_draw_pictures, vectors=True)
