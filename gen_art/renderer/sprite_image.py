"""Sprites that are pictures: an image as a chain of halved ones, and where each particle's lies.

The image is linear and premultiplied, padded to a square and scaled to a side that is a power of two. A sprite reads the level
with one to two texels a pixel, bilinear; its weights are divided by the sum of the coverage it reads, so it gives its energy
exactly.
"""

import math
from functools import lru_cache

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.errors import UsageError
from gen_art.maths.elementary import cos, sin
from gen_art.renderer.colour import to_linear
from gen_art.renderer.sprite import (
    ACROSS,
    ALPHA,
    BLUE,
    DEPTH,
    DX,
    DY,
    FIRST,
    GREEN,
    KIND,
    LAST,
    LEFT,
    LEVEL,
    NORM,
    PICTURE,
    REACH,
    RED,
    RIGHT,
    SLOPE,
    X,
    Y,
)

__all__ = ["NO_TEXELS", "finish_pictures", "read_texel", "texels"]

SIDE = 512  # texels of the largest level
NO_TEXELS = np.zeros((1, 4), np.float32)

F1, F2, H2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i16, 2)


@lru_cache(16)
def texels(place) -> tuple[np.ndarray, float]:
    """The chain of an image file, (n, 4) float32 from the largest level to one texel, and its mean coverage.

    Raises UsageError for a file that cannot be read, or that covers nothing.
    """
    from PIL import Image

    try:
        with Image.open(place) as picture:
            picture.thumbnail((SIDE, SIDE), Image.Resampling.BOX)
            bare = picture.mode in ("L", "RGB")
            pixels = np.asarray(picture.convert("RGBA"), np.float64) / 255.0
    except (OSError, ValueError, SyntaxError) as error:
        raise UsageError(f"{place}: cannot be read as a picture ({error})") from error
    colour, cover = to_linear(pixels[..., :3]), pixels[..., 3:]
    if bare:  # without transparency what is bright covers
        cover = colour.max(axis=2, keepdims=True)
        colour = colour / np.maximum(cover, 1e-9)
    height, width = pixels.shape[:2]
    square = np.zeros((max(height, width),) * 2 + (4,), np.float32)
    top, left = (len(square) - height) // 2, (len(square) - width) // 2
    square[top : top + height, left : left + width] = np.concatenate([colour * cover, cover], axis=2)
    side = 1 << round(math.log2(len(square)))
    level = np.stack(
        [np.asarray(Image.fromarray(square[..., c]).resize((side, side), Image.Resampling.BILINEAR)) for c in range(4)],
        2,
    ).astype(np.float64)
    mean = float(level[..., 3].mean())
    if mean == 0.0:
        raise UsageError(f"{place}: is transparent all over")
    chain = [level]
    while len(chain[-1]) > 1:
        half = len(chain[-1]) // 2
        chain.append(chain[-1].reshape(half, 2, half, 2, 4).mean(axis=(1, 3)))
    return np.concatenate([c.reshape(-1, 4) for c in chain]).astype(np.float32), mean


@ti.func
def read_texel(T: ti.template(), start, side, u, v, c):
    """Channel c of a level at u, v in texels from its corner; nothing outside."""
    x, y = ti.floor(u - 0.5), ti.floor(v - 0.5)
    fx, fy = u - 0.5 - x, v - 0.5 - y
    i, j = ti.cast(x, ti.i32), ti.cast(y, ti.i32)
    total = 0.0
    for k in ti.static(range(4)):
        a, b = i + k % 2, j + k // 2
        w = (fx if k % 2 else 1.0 - fx) * (fy if k // 2 else 1.0 - fy)
        inside = (a >= 0) & (b >= 0) & (a < side) & (b < side)
        total += ti.select(inside, w, 0.0) * T[start + ti.select(inside, b * side + a, 0), c]
    return total


@ti.kernel
def _finish(
    C: F2, n: ti.i32, T: F2, first: ti.i32, largest: ti.i32, turn: ti.f32, scatter: ti.f32, spin: ti.f32, spread: ti.f32,
    P: F2, marks: H2, depths: F1, base: ti.i32, width: ti.i32, rows: ti.i32,
):  # fmt: skip
    """Rows base.. of n pictures; columns DX and DY hold the particle's age and a number in 0..1 of its own."""
    ti.loop_config(block_dim=1)
    for block in range((n + 511) // 512):
        for c in range(block * 512, ti.min((block + 1) * 512, n)):
            i = base + c
            marks[i, FIRST], marks[i, LAST], marks[i, LEVEL] = ti.i16(1), ti.i16(0), ti.i16(0)
            marks[i, KIND] = ti.i16(PICTURE)
            depths[i] = C[DEPTH, c]
            x, y, half = C[X, c], C[Y, c], C[REACH, c]
            if half > 0.0:
                own = C[DY, c]
                again = own * 157.0
                angle = turn + scatter * own + (spin + spread * (again - ti.floor(again))) * C[DX, c]
                a, b = cos(angle), sin(angle)
                start, side = first, largest
                while side > 1 and ti.cast(side, ti.f32) >= 4.0 * half:
                    start, side = start + side * side, side // 2
                wide = half * (abs(a) + abs(b)) * (1.0 + 1.0 / ti.cast(side, ti.f32))
                texel = ti.cast(side, ti.f32) * 0.5
                total = 0.0
                for k in range(ti.cast(ti.floor(y - wide), ti.i32), ti.cast(ti.floor(y + wide), ti.i32) + 1):
                    q = (ti.cast(k, ti.f32) + 0.5 - y) / half
                    for m in range(ti.cast(ti.floor(x - wide), ti.i32), ti.cast(ti.floor(x + wide), ti.i32) + 1):
                        p = (ti.cast(m, ti.f32) + 0.5 - x) / half
                        total += read_texel(
                            T, start, side, (1.0 + p * a - q * b) * texel, (1.0 + p * b + q * a) * texel, 3
                        )
                P[i, X], P[i, Y], P[i, REACH], P[i, DX], P[i, DY] = x, y, half, a, b
                for e in ti.static((RED, GREEN, BLUE, ALPHA)):
                    P[i, e] = C[e, c]
                P[i, SLOPE], P[i, ACROSS] = ti.cast(start, ti.f32), ti.cast(side, ti.f32)
                P[i, NORM] = 1.0 / ti.max(total, 1e-30)
                w, h = ti.cast(width, ti.f32), ti.cast(rows, ti.f32)
                left, right = ti.floor(ti.max(x - wide, 0.0)), ti.floor(ti.min(x + wide, w - 0.5))
                low, high = ti.floor(ti.max(y - wide, 0.0)), ti.floor(ti.min(y + wide, h - 0.5))
                if right >= left and high >= low and total > 0.0:
                    marks[i, LEFT], marks[i, RIGHT] = ti.cast(left, ti.i16), ti.cast(right, ti.i16)
                    marks[i, FIRST], marks[i, LAST] = ti.cast(low, ti.i16), ti.cast(high, ti.i16)


finish_pictures = kernel(_finish)
