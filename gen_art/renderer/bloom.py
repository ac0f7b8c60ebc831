"""Light that strays in the lens: halos of all sizes, whose sum is the light they came from, wherever a point lies.

A chain of coarser pictures (resample.py), each further one half of the one before. The first has a quarter of a tall film's
width and height; a small film's has a half or all of them, so that its narrow halos are told apart too. A point's halo
changes by under 1 % of its peak with the point's place.
"""

from functools import lru_cache

import numpy as np

from gen_art.backend.runtime import aligned
from gen_art.renderer.resample import PAD, WIDE, Taps, blend_weights, columns, resample, ring, steps, variance

__all__ = ["Halo", "chain", "flat", "levels", "stray_light"]

NARROWEST, OCTAVES = 1 / 500, 7  # the halos' standard deviations: from a 500th of the height, each twice the last
QUARTER, HALF = 800, 400  # rows from which the first picture has a quarter, or a half, of the film's


def _scales(height: int) -> tuple[list[int], list[float]]:
    """Each picture's scale to the one before, and the variance, in pixels of the film, of going down to it and up again."""
    scales, variances, size = [4 if height >= QUARTER else 2 if height >= HALF else 1], [0.0], 1
    widest = (NARROWEST * height * 2.0 ** (OCTAVES - 1)) ** 2
    while True:
        variances.append(variances[-1] + 2.0 * variance(scales[-1]) * size**2)
        if variances[-1] >= widest:
            return scales, variances
        size *= scales[-1]
        scales.append(2)


@lru_cache(8)
def levels(height: int, radius: float) -> np.ndarray:
    """Weights of the picture itself and of the chain's pictures, sum 1, so that the halos mean the same at any size.

    Halo k of OCTAVES has standard deviation 2^k height / 500 and weight (0.35 + 0.85 radius)^k; a deviation between those
    of two pictures of the chain is shared by them so that the variance is right.
    """
    variances = _scales(height)[1]
    halos = (0.35 + 0.85 * radius) ** np.arange(OCTAVES, dtype=np.float64)
    weights = np.zeros(len(variances))
    for k, weight in enumerate(halos / halos.sum()):
        wanted = (NARROWEST * height * 2.0**k) ** 2
        low = int(np.searchsorted(variances, wanted, side="right")) - 1
        low = min(low, len(variances) - 2)
        part = (wanted - variances[low]) / (variances[low + 1] - variances[low])
        weights[low] += weight * (1.0 - part)
        weights[low + 1] += weight * part
    return weights.astype(np.float32)


class _ChainLevel:
    """A picture of the chain with PAD pixels around it: its size, its floats and, of these, the pixels and the vectors.

    Rows begin where whole vectors can be loaded: the stride, in pixels, is a multiple of sixteen.
    """

    def __init__(self, width: int, height: int):
        self.width, self.height = width, height
        self.stride = -(-(width + 2 * PAD + 8) // 16) * 16  # eight: of a film's last turn, which may be half beside it
        self.pixels = aligned(((height + 2 * PAD) * self.stride, 4), np.float32)
        self.vectors = self.pixels.reshape(-1, WIDE)
        self.whole = self.pixels.reshape(-1, self.stride, 4)[:, : width + 2 * PAD]


class Halo:
    """The chain for one size of film: its tables and buffers, used again for each picture."""

    def __init__(self, width: int, height: int):
        self.size, self.scales = (width, height), _scales(height)[0]
        across, down = steps(width, self.scales), steps(height, self.scales)
        self.pictures = [_ChainLevel(m, n) for (m, *_), (n, *_) in zip(across, down, strict=True)]
        self._full = None if self.scales[0] == 4 else _ChainLevel(width, height)
        self._down = [(down[k][1].bordered(), across[k][1].bordered()) for k in range(len(down))]
        self._up = [(down[k][2].bordered(), across[k][2].bordered()) for k in range(len(down))]
        first = self.pictures[0]
        self._across = -(-width // 32) * 8
        self._columns = columns(self._down[0][1], 0, self._across, first.stride // 4)
        self._memory = ring(self._down[0][0].weights.shape[1], first.stride // 4, width * height + len(first.pixels))
        self._rest: tuple[float, list] = (-1.0, [])

    def _from(self, k: int, goal: _ChainLevel, rows: Taps, along: Taps, own: float):
        """A function that makes `goal` from picture k."""
        source, across = self.pictures[k], goal.stride // 4
        room = source.stride // 4
        whole = source.vectors, PAD * room, room, source.height - 1
        memory = ring(rows.weights.shape[1], across, len(source.pixels) + len(goal.pixels))
        launch, arguments = resample(whole, PAD, rows, columns(along, PAD, room, across), own, goal.vectors, memory)
        return launch.bound(*arguments)

    def _between(self, radius: float) -> list:
        """What makes all pictures of the first one, and it of them, as functions."""
        weights, last = levels(self.size[1], radius), len(self.pictures) - 1
        coarsest = self.pictures[-1].pixels
        ways = [self._from(k, self.pictures[k + 1], *self._down[k + 1], 0.0) for k in range(last)]
        ways.append(lambda: np.multiply(coarsest, weights[-1], out=coarsest))
        return ways + [self._from(k, self.pictures[k - 1], *self._up[k], float(weights[k])) for k in range(last, 0, -1)]

    def spread(self, film: np.ndarray, stride: int, radius: float) -> tuple[float, _ChainLevel]:
        """The film's stray light: the share that stays where it is, and the first picture.

        film : RGBA in whole vectors, `stride` a row. The picture holds the rest, as bright as it is to be seen.
        """
        if self._rest[0] != radius:
            self._rest = radius, self._between(radius)
        whole = film, 0, stride, self.size[1] - 1
        launch, arguments = resample(
            whole, 0, self._down[0][0], self._columns, 0.0, self.pictures[0].vectors, self._memory
        )
        launch(*arguments)
        for way in self._rest[1]:
            way()
        return float(levels(self.size[1], radius)[0]), self.pictures[0]

    def bloomed(self, film: np.ndarray, strength: float, radius: float) -> np.ndarray:
        """(height, width, 4): the film of a small size with `strength` of its light spread; a buffer that is used again."""
        own, first = self.spread(*flat(film), radius)
        inner = self._full.whole[PAD:-PAD, PAD:-PAD]
        inner[:] = film
        np.multiply(first.pixels, strength, out=first.pixels)
        self._from(0, self._full, *self._up[0], 1.0 + strength * (own - 1.0))()
        inner[..., 3] = film[..., 3]
        return inner


@lru_cache(2)
def chain(width: int, height: int) -> Halo:
    """The chain for this size, kept from picture to picture."""
    return Halo(width, height)


def flat(film: np.ndarray) -> tuple[np.ndarray, int]:
    """The film as whole vectors of four pixels, and how many lie from row to row; copied only where it must be."""
    film = np.asarray(film, dtype=np.float32)
    height, width, _ = film.shape
    row = film.strides[0] // 64
    if film.strides[0] % 64 or film.strides[1:] != (16, 4) or film.ctypes.data % 64 or width % 32:
        row = -(-width // 32) * 8
        whole = aligned((height, 4 * row, 4), np.float32)
        whole[:, :width] = film
        film, width = whole, 4 * row
    length = (height - 1) * row + width // 4
    return np.lib.stride_tricks.as_strided(film, (length, WIDE), (64, 4), writeable=False), row


def stray_light(film: np.ndarray, radius: float) -> np.ndarray:
    """The film's light spread over halos of all sizes, (height, width, 4) float32, alpha left as it is.

    `develop` does the last step of a tall film in its own kernel; here it is NumPy's.
    """
    height, width = film.shape[:2]
    halo = chain(width, height)
    if halo.scales[0] != 4:
        return halo.bloomed(np.asarray(film, np.float32), 1.0, radius).copy()
    own, coarse = halo.spread(*flat(film), radius)
    weights = blend_weights()

    def up(picture, n):
        j = np.arange(n)
        return sum(picture[(j + 2) // 4 + e] * weights[j % 4, e][:, None, None] for e in range(4))

    rows = up(coarse.whole, height)
    return own * film + up(rows.transpose(1, 0, 2), width).transpose(1, 0, 2)
