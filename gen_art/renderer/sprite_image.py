"""Image sprites: an image as a mipmap chain, and the sprite rows of particles drawn with it.

The image is linear and premultiplied, padded to a square and scaled to a side that is a power of two. A sprite reads the level
that has one to two texels a pixel, with bilinear weights. Its weights are divided by the sum of the coverage it reads, so it
gives its energy exactly.

The one-letter names in kernels are in docs/glossary.md.
"""

import math

import numpy as np

from gen_art.backend.runtime import aligned, kernel, ti
from gen_art.errors import UsageError
from gen_art.files import cached_by_file
from gen_art.maths.elementary import cos, sin
from gen_art.pictures import read_picture
from gen_art.renderer.colour import bytes_to_linear
from gen_art.renderer.mipmap import mipmap_chain
from gen_art.renderer.sprite import (
    AGE,
    ALPHA,
    BLUE,
    BOTTOM,
    COSINE,
    DEPTH,
    FIRST_TEXEL,
    FOOTPRINT,
    GREEN,
    KIND,
    LEFT,
    LEVEL,
    LEVEL_SIDE,
    NORM,
    PICTURE,
    RANDOM,
    RED,
    RIGHT,
    SINE,
    THICKNESS,
    TOP,
    X,
    Y,
)
from gen_art.renderer.surfaces.hiding import BEFORE, BEHIND, place_among_surfaces

__all__ = ["NO_TEXELS", "read_texel", "texels", "write_image_sprites"]

SIDE = 1024  # texels of the largest level
LARGE = 128.0  # pixels of half a side, from which on the sum over pixels is the integral, to a thousandth
NO_TEXELS = aligned((1, 4), np.float32)

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
H2 = ti.types.ndarray(ti.i16, 2)


@cached_by_file(16)
def texels(place) -> tuple[np.ndarray, float, tuple[float, float]]:
    """Of an image file: its mipmap chain, its mean coverage, and its width and height as parts of the square.

    The chain is (n, 4) float32, from the largest level to one texel.

    Raises UsageError for a file that cannot be read, or that is transparent everywhere.
    """
    from PIL import Image

    picture = Image.fromarray(read_picture(place, str(place)))
    picture.thumbnail((SIDE, SIDE), Image.Resampling.BOX)
    opaque = picture.mode in ("L", "RGB")
    pixels = np.asarray(picture.convert("RGBA"))
    colour, coverage = bytes_to_linear(pixels[..., :3]), pixels[..., 3:] / 255.0
    if opaque:  # an image without alpha: its brightness is its coverage
        coverage = colour.max(axis=2, keepdims=True)
        colour = colour / np.maximum(coverage, 1e-9)
    height, width = pixels.shape[:2]
    longest = max(height, width)
    rows, first, left = np.zeros((height, longest, 4), np.float32), (longest - height) // 2, (longest - width) // 2
    np.multiply(colour, coverage, out=rows[:, left : left + width, :3], casting="same_kind")
    rows[:, left : left + width, 3:] = coverage
    side = 1 << round(math.log2(longest))
    if side != longest:
        square = np.zeros((longest, longest, 4), np.float32)
        square[first : first + height] = rows
        channels = [Image.fromarray(square[..., c]).resize((side, side), Image.Resampling.BILINEAR) for c in range(4)]
        rows, first = np.stack([np.asarray(channel) for channel in channels], 2), 0
    mean_coverage = float(rows[..., 3].sum(dtype=np.float64) / (side * side))
    if mean_coverage == 0.0:
        raise UsageError(f"{place}: is transparent all over")
    return mipmap_chain(rows, first), mean_coverage, (width / longest, height / longest)


@ti.func
def read_texel(T: ti.template(), start, side, u, v, c):
    """Channel c of a mipmap level at (u, v), in texels from its corner; 0 outside."""
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
def _write_image_sprites(
    C: F2, n: ti.i32, T: F2, first: ti.i32, largest: ti.i32, only: ti.i32, wide: ti.f32, high: ti.f32,
    angle0: ti.f32, angle_range: ti.f32, spin0: ti.f32, spin_range: ti.f32,
    P: F2, headers: H2, depths: F1, base: ti.i32, width: ti.i32, frame_height: ti.i32,
    surface_bins: F3, surface_tiles: F3, pixel: ti.f32, parallel: ti.i32,
):  # fmt: skip
    """Fill sprite rows base.. from n projected particles whose look is an image.

    C : (11, n) channels of the particles; AGE and RANDOM stand in the channels DX and DY
    T : (m, 4) texels; the chain begins at row `first` with a level of `largest` x `largest` and ends at row `only`, their mean
    wide, high : width and height of the image as parts of the square
    surface_bins, surface_tiles, pixel, parallel : of SurfaceDepths
    angle0, angle_range : radians, a particle's angle at birth is angle0 + angle_range * its random number
    spin0, spin_range : radians/s, the same for its rate of rotation
    """
    ti.loop_config(block_dim=1)
    for block in range((n + 511) // 512):
        for c in range(block * 512, ti.min((block + 1) * 512, n)):
            i = base + c
            headers[i, TOP], headers[i, BOTTOM], headers[i, LEVEL] = ti.i16(1), ti.i16(0), ti.i16(0)
            headers[i, KIND] = ti.i16(PICTURE)
            depths[i] = C[DEPTH, c]
            x, y, half_side = C[X, c], C[Y, c], C[FOOTPRINT, c]
            P[i, THICKNESS] = 0.0
            if surface_bins.shape[0] > 0 and half_side > 0.0:
                thickness = half_side * pixel * ti.select(parallel == 1, 1.0, C[DEPTH, c])
                among = place_among_surfaces(surface_bins, surface_tiles, x, y, 1.5 * half_side, C[DEPTH, c], thickness)
                if among == BEHIND:
                    half_side = 0.0
                elif among != BEFORE:
                    P[i, THICKNESS] = thickness
            if half_side > 0.0:
                random = C[RANDOM, c]
                second_random = random * 157.0
                spin = spin0 + spin_range * (second_random - ti.floor(second_random))
                angle = angle0 + angle_range * random + spin * C[AGE, c]
                a, b = cos(angle), sin(angle)
                start, side = first, largest
                while side > 1 and ti.cast(side, ti.f32) >= 4.0 * half_side:
                    start, side = start + side * side, side // 2
                texel = ti.cast(side, ti.f32) * 0.5
                # filters carry light up to 2.5 texels past the image's border, and half a texel past the square's
                u, v = ti.min(wide + 2.5 / texel, 1.0 + 0.5 / texel), ti.min(high + 2.5 / texel, 1.0 + 0.5 / texel)
                across, down = half_side * (abs(a) * u + abs(b) * v), half_side * (abs(b) * u + abs(a) * v)
                # of its coverage: of a large image the integral, of a small one the sum over its pixels
                total = T[only, 3] * 4.0 * half_side * half_side
                if half_side < LARGE:
                    total = 0.0
                    for k in range(ti.cast(ti.floor(y - down), ti.i32), ti.cast(ti.floor(y + down), ti.i32) + 1):
                        q = (ti.cast(k, ti.f32) + 0.5 - y) / half_side
                        for m in range(
                            ti.cast(ti.floor(x - across), ti.i32), ti.cast(ti.floor(x + across), ti.i32) + 1
                        ):
                            p = (ti.cast(m, ti.f32) + 0.5 - x) / half_side
                            total += read_texel(
                                T, start, side, (1.0 + p * a - q * b) * texel, (1.0 + p * b + q * a) * texel, 3
                            )
                P[i, X], P[i, Y], P[i, FOOTPRINT], P[i, COSINE], P[i, SINE] = x, y, half_side, a, b
                for e in ti.static((RED, GREEN, BLUE, ALPHA)):
                    P[i, e] = C[e, c]
                P[i, FIRST_TEXEL], P[i, LEVEL_SIDE] = ti.cast(start, ti.f32), ti.cast(side, ti.f32)
                P[i, NORM] = 1.0 / ti.max(total, 1e-30)
                w, h = ti.cast(width, ti.f32), ti.cast(frame_height, ti.f32)
                left, right = ti.floor(ti.max(x - across, 0.0)), ti.floor(ti.min(x + across, w - 0.5))
                top, bottom = ti.floor(ti.max(y - down, 0.0)), ti.floor(ti.min(y + down, h - 0.5))
                if right >= left and bottom >= top and total > 0.0:
                    headers[i, LEFT], headers[i, RIGHT] = ti.cast(left, ti.i16), ti.cast(right, ti.i16)
                    headers[i, TOP], headers[i, BOTTOM] = ti.cast(top, ti.i16), ti.cast(bottom, ti.i16)


write_image_sprites = kernel(_write_image_sprites)
