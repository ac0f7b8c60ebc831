"""Supersampling: a framebuffer larger than its picture, each pixel of which is the mean of a block.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti

__all__ = ["box_averaged"]

PIXEL = ti.types.vector(4, ti.f32)
PIXELS = ti.types.ndarray(PIXEL, 1)


@ti.kernel
def _reduce(large: PIXELS, stride: ti.i32, times: ti.i32, width: ti.i32, height: ti.i32, small: PIXELS):
    ti.loop_config(block_dim=4)
    for row in range(height):
        share = 1.0 / ti.cast(times * times, ti.f32)
        for column in range(width):
            total = PIXEL(0.0, 0.0, 0.0, 0.0)
            for k in range(times):
                for m in range(times):
                    total += large[(row * times + k) * stride + column * times + m]
            small[row * width + column] = total * share


reduce_kernel = kernel(_reduce)


def box_averaged(framebuffer, times: int) -> np.ndarray:
    """(height, width, 4) float32: the means of the framebuffer's pixels over blocks of `times` x `times`."""
    height, width = framebuffer.height // times, framebuffer.width // times
    small = np.empty((height * width, 4), np.float32)
    reduce_kernel(framebuffer.buffer.reshape(-1, 4), framebuffer.stride // 4, times, width, height, small)
    return small.reshape(height, width, 4)
