"""The slopes of waves in each pixel of a picture, found for sixteen pixels at a time before surfaces are drawn.

A pixel's slopes are those where the ray through its middle meets the level surface, whatever may lie before it.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import aligned, kernel, ti
from gen_art.renderer.lanes import LANES, all_lanes, lane_numbers
from gen_art.renderer.surfaces.scene_numbers import (
    CAMERA,
    FORWARD,
    PARALLEL,
    RIGHT,
    ROWS,
    SCALE,
    UP,
    WIDTH,
)
from gen_art.renderer.surfaces.water_waves import wave_slope

__all__ = ["NO_FIELD", "wave_field"]

F1, F2, I2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 2)
VECTORS = ti.types.ndarray(ti.types.vector(LANES, ti.f32), 4)

NO_FIELD = np.zeros((1, 1, 3, 1), np.float32)
_LEAST_STEEPNESS = 1e-4  # of a ray: as in pixel_steps


@ti.kernel
def _slopes(N: F1, W: F2, heights: F1, ranges: I2, result: VECTORS):
    """heights : of each surface; ranges : (surfaces, 3) first row, waves and uneven of wave_slope"""
    ti.loop_config(block_dim=1)
    for task in range(result.shape[0] * result.shape[1]):
        surface, row = task // result.shape[1], task % result.shape[1]
        down = (0.5 * N[ROWS] - (ti.cast(row, ti.f32) + 0.5)) / N[SCALE]
        height = heights[surface] - N[CAMERA + 1]
        sign, least = ti.select(height < 0.0, -1.0, 1.0), ti.static(_LEAST_STEEPNESS)
        # no ray of a row, nor of the rows beside it, meets the surface where those of its ends do not: they steepen evenly
        to_ends = ti.abs(N[RIGHT + 1]) * 0.5 * N[WIDTH] + ti.abs(N[UP + 1])
        steepest = to_ends / N[SCALE] + sign * (N[FORWARD + 1] + N[UP + 1] * down)
        blocks = ti.select(steepest > 0.0 or N[PARALLEL] > 0.5, result.shape[3], 0)
        for block in range(blocks):
            column = lane_numbers() + all_lanes(ti.cast(block * LANES, ti.f32) + 0.5 - 0.5 * N[WIDTH])
            across, none = column * all_lanes(1.0 / N[SCALE]), all_lanes(0.0)
            parallel = all_lanes(N[PARALLEL]) > all_lanes(0.5)
            offset = [across * all_lanes(N[RIGHT + c]) + all_lanes(N[UP + c] * down) for c in ti.static(range(3))]
            ray = [all_lanes(N[FORWARD + c]) + ti.select(parallel, none, offset[c]) for c in ti.static(range(3))]
            start = [ti.select(parallel, offset[c], none) for c in ti.static(range(3))]
            per_length = all_lanes(1.0) / ti.sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2])
            d = [ray[c] * per_length for c in ti.static(range(3))]
            # a ray that does not meet the surface counts as one that is almost level, for which no wave is left
            steepness = ti.max(d[1] * all_lanes(sign), all_lanes(least))
            t = (all_lanes(height) - start[1]) * all_lanes(sign) / steepness
            pixel = ti.select(parallel, all_lanes(1.0), t) * all_lanes(1.0 / N[SCALE])
            # from one pixel to the next, as pixel_steps finds it
            aside, upwards = all_lanes(sign * N[RIGHT + 1]) / steepness, all_lanes(sign * N[UP + 1]) / steepness
            place = [all_lanes(N[CAMERA + c]) + start[c] + d[c] * t for c in ti.static((0, 2))]
            east = [(all_lanes(N[RIGHT + c]) - d[c] * aside) * pixel for c in ti.static((0, 2))]
            south = [(all_lanes(N[UP + c]) - d[c] * upwards) * pixel for c in ti.static((0, 2))]
            found = wave_slope(
                W, ranges[surface, 0], ranges[surface, 1], ranges[surface, 2], all_lanes, place, east, south
            )
            for k in ti.static(range(3)):
                result[surface, row, k, block] = found[k]


_slopes_kernel = kernel(_slopes, vectors=True)


def wave_field(numbers: np.ndarray, rows: np.ndarray, heights, ranges, size: tuple[int, int]) -> np.ndarray:
    """(surfaces, rows, 3, columns or more) float32: what wave_slope gives in each pixel.

    numbers : of scene_numbers; rows : of SurfaceMaps.waves
    heights, ranges : of each surface: y, m; first row, waves and uneven of wave_slope
    size : (width, height) of the picture
    """
    blocks = -(-size[0] // LANES)
    result = aligned((len(heights), size[1], 3, blocks, LANES), np.float32)
    _slopes_kernel(numbers, rows, np.asarray(heights, np.float32), np.asarray(ranges, np.int32).reshape(-1, 3), result)
    return result.reshape(len(heights), size[1], 3, blocks * LANES)
