"""Bloom (veiling glare): light scattered in the lens, as halos of all sizes. Their sum is the light they came from.

A pyramid of coarser pictures (resample.py), each after the first half the size of the one before. The first has a quarter of a
tall picture's width and height; for a small picture it has a half or all of them, so that its narrow halos remain distinct. A
point's halo changes by less than 1 % of its peak with the position of the point.
"""

from functools import lru_cache

import numpy as np

from gen_art.backend.runtime import aligned
from gen_art.renderer import resample
from gen_art.renderer.resample import PAD, WIDE, Taps, blend_weights

__all__ = ["BloomPyramid", "as_vectors", "bloom_pyramid", "glare", "level_weights"]

MIN_SIGMA, OCTAVES = (
    1 / 500,
    7,
)  # the halos' standard deviations: from a 500th of the height up, each twice the one before
QUARTER_ROWS, HALF_ROWS = 800, 400  # rows from which the first level has a quarter, or a half, of the picture's size


def _scales(height: int) -> tuple[list[int], list[float]]:
    """Each level's scale to the one before, and the variance, in pixels of the picture, of going down to it and up again."""
    scales, variances, size = [4 if height >= QUARTER_ROWS else 2 if height >= HALF_ROWS else 1], [0.0], 1
    widest = (MIN_SIGMA * height * 2.0 ** (OCTAVES - 1)) ** 2
    while True:
        variances.append(variances[-1] + 2.0 * resample.variance(scales[-1]) * size**2)
        if variances[-1] >= widest:
            return scales, variances
        size *= scales[-1]
        scales.append(2)


@lru_cache(8)
def level_weights(height: int, radius: float) -> np.ndarray:
    """Weights of the picture itself and of the pyramid's levels, with sum 1, that make the halos mean the same at any size.

    Halo k of OCTAVES has standard deviation 2^k height / 500 and weight (0.35 + 0.85 radius)^k. A halo whose deviation lies
    between those of two levels is shared by them so that its variance is right.
    """
    variances = _scales(height)[1]
    halo_weights = (0.35 + 0.85 * radius) ** np.arange(OCTAVES, dtype=np.float64)
    weights = np.zeros(len(variances))
    for k, weight in enumerate(halo_weights / halo_weights.sum()):
        wanted = (MIN_SIGMA * height * 2.0**k) ** 2
        low = int(np.searchsorted(variances, wanted, side="right")) - 1
        low = min(low, len(variances) - 2)
        fraction = (wanted - variances[low]) / (variances[low + 1] - variances[low])
        weights[low] += weight * (1.0 - fraction)
        weights[low + 1] += weight * fraction
    return weights.astype(np.float32)


class _PyramidLevel:
    """One level of the pyramid, with PAD pixels around it.

    pixels : all floats, (n, 4); vectors : the same as whole vectors; bordered : (height + 2 PAD, width + 2 PAD, 4), a view
    Rows begin where whole vectors can be loaded: the stride, in pixels, is a multiple of sixteen.
    """

    def __init__(self, width: int, height: int):
        self.width, self.height = width, height
        self.stride = (
            -(-(width + 2 * PAD + 8) // 16) * 16
        )  # eight: the tone map's last block of a row may lie half beside the picture
        self.pixels = aligned(((height + 2 * PAD) * self.stride, 4), np.float32)
        self.vectors = self.pixels.reshape(-1, WIDE)
        self.bordered = self.pixels.reshape(-1, self.stride, 4)[:, : width + 2 * PAD]


class BloomPyramid:
    """The pyramid for one size of picture: its tables and buffers, reused for each picture."""

    def __init__(self, width: int, height: int):
        self.size, self.scales = (width, height), _scales(height)[0]
        across, down = resample.level_taps(width, self.scales), resample.level_taps(height, self.scales)
        self.levels = [_PyramidLevel(m, n) for (m, *_), (n, *_) in zip(across, down, strict=True)]
        self._full = None if self.scales[0] == 4 else _PyramidLevel(width, height)
        self._down = [(down[k][1].bordered(), across[k][1].bordered()) for k in range(len(down))]
        self._up = [(down[k][2].bordered(), across[k][2].bordered()) for k in range(len(down))]
        first = self.levels[0]
        column_taps, row_taps = self._down[0]
        pixels = width * height + len(first.pixels)
        self._first_taps = resample.vector_taps(row_taps, 0, -(-width // 32) * 8, first.stride // 4)
        self._first_buffer = resample.ring_buffer(column_taps.weights.shape[1], first.stride // 4, pixels)
        self._steps: tuple[float, list] = (-1.0, [])

    def _resample_from(self, k: int, target: _PyramidLevel, column_taps: Taps, row_taps: Taps, target_weight: float):
        """A function that computes `target` from level k, adding it to `target_weight` times what `target` holds."""
        source, row_vectors = self.levels[k], target.stride // 4
        source_vectors = source.stride // 4
        layout = source.vectors, PAD * source_vectors, source_vectors, source.height - 1
        buffer = resample.ring_buffer(
            column_taps.weights.shape[1], row_vectors, len(source.pixels) + len(target.pixels)
        )
        vector_taps = resample.vector_taps(row_taps, PAD, source_vectors, row_vectors)
        kernel, arguments = resample.resample(
            layout, PAD, column_taps, vector_taps, target_weight, target.vectors, buffer
        )
        return kernel.bound(*arguments)

    def _level_steps(self, radius: float) -> list:
        """Functions that compute all levels from the first one, and then the first one's halo light from them."""
        weights, last = level_weights(self.size[1], radius), len(self.levels) - 1
        coarsest = self.levels[-1].pixels
        steps = [self._resample_from(k, self.levels[k + 1], *self._down[k + 1], 0.0) for k in range(last)]
        steps.append(lambda: np.multiply(coarsest, weights[-1], out=coarsest))
        return steps + [
            self._resample_from(k, self.levels[k - 1], *self._up[k], float(weights[k])) for k in range(last, 0, -1)
        ]

    def scatter(self, linear: np.ndarray, stride: int, radius: float) -> tuple[float, _PyramidLevel]:
        """Scatter the picture's light: returns the share that is not scattered, and the first level, which holds the rest.

        linear : RGBA in whole vectors, `stride` of them in a row
        The first level is as bright as it will be seen.
        """
        if self._steps[0] != radius:
            self._steps = radius, self._level_steps(radius)
        layout = linear, 0, stride, self.size[1] - 1
        kernel, arguments = resample.resample(
            layout, 0, self._down[0][0], self._first_taps, 0.0, self.levels[0].vectors, self._first_buffer
        )
        kernel(*arguments)
        for step in self._steps[1]:
            step()
        return float(level_weights(self.size[1], radius)[0]), self.levels[0]

    def with_bloom(self, linear: np.ndarray, strength: float, radius: float) -> np.ndarray:
        """(height, width, 4): a small picture with `strength` of its light scattered, in a buffer that is reused."""
        unscattered, first = self.scatter(*as_vectors(linear), radius)
        assert self._full is not None  # only where the first level is not a quarter
        interior = self._full.bordered[PAD:-PAD, PAD:-PAD]
        interior[:] = linear
        np.multiply(first.pixels, strength, out=first.pixels)
        self._resample_from(0, self._full, *self._up[0], 1.0 + strength * (unscattered - 1.0))()
        interior[..., 3] = linear[..., 3]
        return interior


@lru_cache(2)
def bloom_pyramid(width: int, height: int) -> BloomPyramid:
    """The pyramid for this size, kept from picture to picture."""
    return BloomPyramid(width, height)


def as_vectors(linear: np.ndarray) -> tuple[np.ndarray, int]:
    """The picture as whole vectors of four pixels, and how many there are from row to row; copied only if necessary."""
    linear = np.asarray(linear, dtype=np.float32)
    height, width, _ = linear.shape
    row = linear.strides[0] // 64
    if linear.strides[0] % 64 or linear.strides[1:] != (16, 4) or linear.ctypes.data % 64 or width % 32:
        row = -(-width // 32) * 8
        padded = aligned((height, 4 * row, 4), np.float32)
        padded[:, :width] = linear
        linear, width = padded, 4 * row
    length = (height - 1) * row + width // 4
    return np.lib.stride_tricks.as_strided(linear, (length, WIDE), (64, 4), writeable=False), row


def glare(linear: np.ndarray, radius: float) -> np.ndarray:
    """The picture's light scattered over halos of all sizes, (height, width, 4) float32; alpha stays as it is.

    `develop` does the last step of a tall picture in its own kernel; here NumPy does it.
    """
    height, width = linear.shape[:2]
    pyramid = bloom_pyramid(width, height)
    if pyramid.scales[0] != 4:
        return pyramid.with_bloom(np.asarray(linear, np.float32), 1.0, radius).copy()
    unscattered, coarse = pyramid.scatter(*as_vectors(linear), radius)
    weights = blend_weights()

    def up(level, n):
        j = np.arange(n)
        return sum(level[(j + 2) // 4 + e] * weights[j % 4, e][:, None, None] for e in range(4))

    rows = up(coarse.bordered, height)
    return unscattered * linear + up(rows.transpose(1, 0, 2), width).transpose(1, 0, 2)
