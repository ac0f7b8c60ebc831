"""The particles of a liquid in the bins of the picture that they touch, each bin's in their order and side by side in memory.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.picture_tiles import BIN
from gen_art.renderer.projected_particles import LIT_RADIUS
from gen_art.renderer.sprite import DEPTH, FOOTPRINT, X, Y
from gen_art.renderer.surfaces.scene_numbers import PARALLEL, ROWS, SCALE, WIDTH

__all__ = ["BIN", "ENTRY_FLOATS", "LEAST_REACH", "NEAREST", "ParticleBins", "outline"]

CHUNKS = 16  # fixed, because the order of a bin's particles must not depend on the number of threads
ENTRY_FLOATS = 4  # pixel (2), depth, radius (m)
LEAST_REACH = 1.2  # pixels: the least radius over which a particle's volume is spread
NEAREST = 1.02  # a particle nearer to the camera than this many radii is left out: the camera is in it

F1, F2, I1, I2 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.i32, 1), (ti.i32, 2)))


@ti.func
def outline(place, size, z, r, pixels, scale, parallel):
    """The first and the last place along one axis of the picture, in pixels, that a ball covers.

    place : of its middle; size : of the picture; z, r : depth and radius; pixels : per length at its depth
    """
    low, high = place - r * pixels, place + r * pixels
    if parallel < 0.5:
        x, square = (place - 0.5 * size) * z / scale, z * z - r * r
        reach = r * ti.sqrt(ti.max(x * x + square, 0.0))
        low, high = 0.5 * size + scale * (x * z - reach) / square, 0.5 * size + scale * (x * z + reach) / square
    return low, high


@ti.func
def _bins_of(N: ti.template(), C: ti.template(), A: ti.template(), i, spread):
    """First and last bin along both axes (4,) that a particle touches; none if the last is before the first."""
    z, r, scale, parallel = C[DEPTH, i], A[i, LIT_RADIUS], N[SCALE], N[PARALLEL]
    result = ti.Vector([0, -1, 0, -1])
    if C[FOOTPRINT, i] >= 0.0 and r > 0.0 and (parallel > 0.5 or z > NEAREST * r):
        pixel = ti.select(parallel > 0.5, 1.0, z) / scale
        reach = ti.max(r * spread, LEAST_REACH * pixel)
        if parallel < 0.5:
            reach = ti.min(reach, z / NEAREST)
        x0, x1 = outline(C[X, i], N[WIDTH], z, reach, 1.0 / pixel, scale, parallel)
        y0, y1 = outline(C[Y, i], N[ROWS], z, reach, 1.0 / pixel, scale, parallel)
        if x1 > -0.5 and y1 > -0.5 and x0 < N[WIDTH] + 0.5 and y0 < N[ROWS] + 0.5:
            result[0] = ti.cast(ti.max(x0 - 0.5, 0.0), ti.i32) // BIN
            result[1] = ti.cast(ti.min(x1 + 0.5, N[WIDTH] - 0.5), ti.i32) // BIN
            result[2] = ti.cast(ti.max(y0 - 0.5, 0.0), ti.i32) // BIN
            result[3] = ti.cast(ti.min(y1 + 0.5, N[ROWS] - 0.5), ti.i32) // BIN
    return result


@ti.kernel
def _count(N: F1, C: F2, A: F2, n: ti.i32, spread: ti.f32, across: ti.i32, counts: I2):
    ti.loop_config(block_dim=1)
    for chunk in range(CHUNKS):
        size = (n + CHUNKS - 1) // CHUNKS
        for i in range(chunk * size, ti.min((chunk + 1) * size, n)):
            box = _bins_of(N, C, A, i, spread)
            for y in range(box[2], box[3] + 1):
                for x in range(box[0], box[1] + 1):
                    counts[chunk, y * across + x] = counts[chunk, y * across + x] + 1


@ti.kernel
def _fill(
    N: F1, C: F2, A: F2, n: ti.i32, spread: ti.f32, across: ti.i32, starts: I2, entries: F2, particles: I1
):  # fmt: skip
    ti.loop_config(block_dim=1)
    for chunk in range(CHUNKS):
        size = (n + CHUNKS - 1) // CHUNKS
        for i in range(chunk * size, ti.min((chunk + 1) * size, n)):
            box = _bins_of(N, C, A, i, spread)
            for y in range(box[2], box[3] + 1):
                for x in range(box[0], box[1] + 1):
                    slot = starts[chunk, y * across + x]
                    entries[slot, 0], entries[slot, 1] = C[X, i], C[Y, i]
                    entries[slot, 2], entries[slot, 3] = C[DEPTH, i], A[i, LIT_RADIUS]
                    particles[slot] = i
                    starts[chunk, y * across + x] = slot + 1


_count_kernel, _fill_kernel = kernel(_count), kernel(_fill)


@dataclass(frozen=True, eq=False)
class ParticleBins:
    """Particles by the bins of the picture.

    across, down : bins along both axes
    starts : (bins + 1,) int32, the first entry of each bin
    entries : (n, ENTRY_FLOATS) float32
    particles : (n,) int32, which particle each entry is
    """

    across: int
    down: int
    starts: np.ndarray
    entries: np.ndarray
    particles: np.ndarray

    @classmethod
    def of(
        cls, numbers: np.ndarray, channels: np.ndarray, lit: np.ndarray, count: int, size, spread: float
    ) -> "ParticleBins":
        """The bins of projected particles.

        numbers : of scene_numbers
        channels, lit : of ProjectedParticles; count : of them in use
        size : (width, height) of the picture
        spread : how many of its radii around a particle count as touched
        """
        across, down = -(-size[0] // BIN), -(-size[1] // BIN)
        counts = np.zeros((CHUNKS, across * down), np.int32)
        if count:
            _count_kernel(numbers, channels, lit, count, spread, across, counts)
        by_bin = counts.T.reshape(-1)
        ends = np.cumsum(by_bin, dtype=np.int64)
        total = int(ends[-1])
        starts = np.ascontiguousarray((ends - by_bin).reshape(-1, CHUNKS).T, np.int32)
        firsts = np.append(starts[0], total).astype(np.int32)
        entries, particles = np.empty((max(total, 1), ENTRY_FLOATS), np.float32), np.empty(max(total, 1), np.int32)
        if total:
            _fill_kernel(numbers, channels, lit, count, spread, across, starts, entries, particles)
        return cls(across, down, firsts, entries, particles)
