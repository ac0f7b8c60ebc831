"""Converts pictures to an encoder's frames: BT.709 luma and chroma in limited range, or unchanged RGB.

    Y' = 0.2126 R' + 0.7152 G' + 0.0722 B'      Cb = (B' - Y') / 1.8556      Cr = (R' - Y') / 1.5748
    codes of n bits: 2^(n-8) (16 + 219 Y'), 2^(n-8) (128 + 224 Cb), rounded                    (ITU-R BT.709-6)

R'G'B' are the picture's sRGB-encoded values, on 0..1. 4:2:0 chroma is sited as in MPEG-2, which players expect: on the even
columns (weights 1 2 1), between the rows. In transparent pictures it is weighted by alpha, so that invisible pixels do not
tint visible ones.

The one-letter names in kernels are in docs/glossary.md.
"""

import av
import numpy as np
from av.video.reformatter import ColorPrimaries, ColorRange, ColorTrc

from gen_art.backend.runtime import kernel, ti

__all__ = ["MATRIX_BT709", "MATRIX_RGB", "film_frame", "tag"]

MATRIX_RGB, MATRIX_BT709 = 0, 1
N1 = ti.types.ndarray(ndim=1)


@ti.func
def _luma(r, g, b):
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


@ti.kernel
def _convert(
    picture: N1, width: ti.i32, height: ti.i32, channels: ti.template(), half: ti.template(), unit: ti.f32,
    code: ti.f32, opaque: ti.f32, luma: N1, cb: N1, cr: N1, alpha: N1, row: ti.i32, chroma_row: ti.i32,
    alpha_row: ti.i32,
):  # fmt: skip
    ti.loop_config(block_dim=4)
    for i in range(height >> half):
        for k in ti.static(range(1 + half)):
            y = (i << half) + k
            for x in range(width):
                o = (y * width + x) * channels
                value = _luma(
                    ti.cast(picture[o], ti.f32), ti.cast(picture[o + 1], ti.f32), ti.cast(picture[o + 2], ti.f32)
                )
                luma[y * row + x] = ti.cast(code * (16.0 + 219.0 * unit * value) + 0.5, ti.i32)
                if ti.static(channels == 4):
                    alpha[y * alpha_row + x] = ti.cast(ti.cast(picture[o + 3], ti.f32) * unit * opaque + 0.5, ti.i32)
        for j in range(width >> half):
            r, g, b, total = 0.0, 0.0, 0.0, 0.0
            for k in ti.static(range(1 + half)):
                for d in ti.static(range(1 + 2 * half)):
                    x = ti.max((j << half) + d - half, 0)  # the right neighbour of an even column is always inside
                    o = (((i << half) + k) * width + x) * channels
                    weight = 1.0 + float(d & half)
                    if ti.static(channels == 4):
                        weight *= ti.cast(picture[o + 3], ti.f32) + 1e-3
                    r += weight * ti.cast(picture[o], ti.f32)
                    g += weight * ti.cast(picture[o + 1], ti.f32)
                    b += weight * ti.cast(picture[o + 2], ti.f32)
                    total += weight
            scale = 224.0 * unit / total
            value = _luma(r, g, b)
            cb[i * chroma_row + j] = ti.cast(code * (128.0 + scale * (b - value) / 1.8556) + 0.5, ti.i32)
            cr[i * chroma_row + j] = ti.cast(code * (128.0 + scale * (r - value) / 1.5748) + 0.5, ti.i32)


convert_kernel = kernel(_convert)


def _plane(frame: av.VideoFrame, k: int, dtype) -> tuple[np.ndarray, int]:
    """(the values of plane k as one writable array, number of values from one line to the next)."""
    plane = frame.planes[k]
    return np.frombuffer(memoryview(plane), dtype), plane.line_size // np.dtype(dtype).itemsize


def film_frame(picture: np.ndarray, pixels: str, bits: int) -> av.VideoFrame:
    """A frame of pixel format `pixels` with `bits` a channel.

    picture : (height, width, 3 or 4), uint8 or uint16, straight alpha; may be overwritten afterwards
    This runs a Taichi kernel: call it from the thread that runs the other kernels.
    """
    height, width, channels = picture.shape
    frame = av.VideoFrame(width, height, pixels)
    if "yuv" in pixels:
        _fill_yuv(frame, picture, bits, "420" in pixels)
    elif pixels.startswith("gbr"):
        for k, channel in enumerate((1, 2, 0, 3)[:channels]):
            values, row = _plane(frame, k, np.uint16)
            values.reshape(height, row)[:, :width] = picture[..., channel]
    else:
        values, row = _plane(frame, 0, np.uint8)
        packed = values.reshape(height, row)[:, : width * 4].reshape(height, width, 4)
        packed[..., :3] = picture[..., 2::-1]
        packed[..., 3] = picture[..., 3] if channels == 4 else 255
    tag(frame, "yuv" not in pixels)
    return frame


def _fill_yuv(frame: av.VideoFrame, picture: np.ndarray, bits: int, halved: bool) -> None:
    height, width, channels = picture.shape
    dtype = np.uint8 if bits == 8 else np.uint16
    luma, row = _plane(frame, 0, dtype)
    cb, chroma_row = _plane(frame, 1, dtype)
    cr, _ = _plane(frame, 2, dtype)
    alpha, alpha_row = _plane(frame, 3, dtype) if channels == 4 else (luma, 0)
    convert_kernel(
        np.ascontiguousarray(picture).reshape(-1), width, height, channels, int(halved),
        1.0 / float(np.iinfo(picture.dtype).max), 2.0 ** (bits - 8), 2.0**bits - 1.0,
        luma, cb, cr, alpha, row, chroma_row, alpha_row,
    )  # fmt: skip


def tag(target, rgb: bool) -> None:
    """Set the colour tags of a frame or an encoder: BT.709 in limited range, or full-range sRGB for RGB."""
    target.color_range = ColorRange.JPEG if rgb else ColorRange.MPEG
    target.colorspace = MATRIX_RGB if rgb else MATRIX_BT709
    target.color_primaries = ColorPrimaries.BT709
    target.color_trc = ColorTrc.IEC61966_2_1 if rgb else ColorTrc.BT709
