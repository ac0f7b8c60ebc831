"""A film drawn larger than its picture: each pixel is the mean of the pixels it was drawn as."""

import numpy as np

from gen_art.backend.runtime import kernel, ti

__all__ = ["box_averaged"]

PIXEL = ti.types.vector(4, ti.f32)
FILM = ti.types.ndarray(PIXEL, 1)


@ti.kernel
def _reduce(large: FILM, stride: ti.i32, times: ti.i32, width: ti.i32, height: ti.i32, small: FILM):
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


def box_averaged(film, times: int) -> np.ndarray:
    """(height, width, 4) float32: the film's pixels, `times` x `times` of them in one."""
    height, width = film.height // times, film.width // times
    small = np.empty((height * width, 4), np.float32)
    reduce_kernel(film.buffer.reshape(-1, 4), film.stride // 4, times, width, height, small)
    return small.reshape(height, width, 4)
