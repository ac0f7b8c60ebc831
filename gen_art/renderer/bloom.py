"""Light that strays in the lens: halos of all sizes, whose sum is the light they came from, wherever a point lies.

A chain of coarser pictures (resample.py), each further one half of the one before. The first has a quarter of a tall film's
width and height; a small film's has a half or all of them, so that its narrow halos are told apart too. A point's halo
changes by under 1 % of its peak with the point's place.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gen_art.renderer.resample import PAD, ROWS, TILE, Columns, Rows, blend_weights, mirrored, resample, steps, variance
from gen_art.runtime import aligned

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


def _stride(width: int) -> int:
    return -(-(width + 2 * PAD) // 4) * 16


@dataclass(frozen=True)
class _Picture:
    """A picture of the chain: its floats, whose end has room for a tile's reading beyond it, and its size without borders.

    Rows begin where whole vectors can be loaded: the stride, in floats, is a multiple of sixteen.
    """

    floats: np.ndarray
    width: int
    height: int

    @property
    def stride(self) -> int:
        return _stride(self.width)

    @property
    def whole(self) -> np.ndarray:
        """(height + 2 PAD, width + 2 PAD, 4)"""
        rows = self.floats[:-TILE].reshape(self.height + 2 * PAD, -1, 4)
        return rows[:, : self.width + 2 * PAD]

    def mirror(self) -> None:
        """Fill the borders."""
        for side in (self.whole, self.whole.transpose(1, 0, 2)):
            n = len(side) - 2 * PAD
            beyond = np.array([-2, -1, n, n + 1])
            side[beyond + PAD] = side[mirrored(beyond, n) + PAD]


def _picture(width: int, height: int) -> _Picture:
    return _Picture(aligned((height + 2 * PAD) * _stride(width) + TILE, np.float32), width, height)


class Halo:
    """The chain for one size of film: its tables and buffers, used again for each picture."""

    def __init__(self, width: int, height: int):
        self.size, self.scales = (width, height), _scales(height)[0]
        self._across, self._down = steps(width, self.scales), steps(height, self.scales)
        self.pictures: list[_Picture] = []
        self._work = []
        for (m, _, down, _, up), (n, *_), scale in zip(self._across, self._down, self.scales, strict=True):
            self.pictures.append(_picture(m, n))
            # buffers of their own: what lies between the phases is never written, and stays zero
            rows = ((n, down), (scale * n, up))
            self._work.append([np.zeros((-(-h // ROWS) * c.room << c.shift) * 4, np.float32) for h, c in rows])
        self._full = None if self.scales[0] == 4 else _picture(width, height)

    def _go(self, goal: _Picture, source, start, stride, size, rows: Rows, columns: Columns, own, work):
        resample(
            source, start, stride, *size, rows.first, rows.weights, columns.shift, columns.room, columns.left,
            columns.offset, columns.weights, own, PAD * (goal.stride + 4), goal.stride, goal.width, goal.height, work,
            goal.floats,
        )  # fmt: skip

    def _up(self, k: int, goal: _Picture, own: float):
        source = self.pictures[k]
        size = source.width + 2 * PAD, source.height + 2 * PAD
        up, wide = self._down[k][3], self._across[k][4]
        self._go(goal, source.floats, 0, source.stride, size, up, wide, own, self._work[k][1])

    def spread(self, film: np.ndarray, stride: int, radius: float) -> tuple[float, _Picture]:
        """The film's stray light: the share that stays where it is, and the first picture.

        film : flat float32 RGBA, `stride` floats a row, at least TILE. The picture holds the rest, as bright as it is to be seen.
        """
        weights = levels(self.size[1], radius)
        source, start, step, size = film, 0, stride, self.size
        for k, goal in enumerate(self.pictures):
            rows, columns = self._down[k][1], self._across[k][2]
            self._go(goal, source, start, step, size, rows, columns, 0.0, self._work[k][0])
            goal.mirror()
            source, step, size = goal.floats, goal.stride, (goal.width, goal.height)
            start = PAD * (step + 4)
        np.multiply(source, weights[-1], out=source)
        for k in range(len(self.pictures) - 1, 0, -1):
            self._up(k, self.pictures[k - 1], float(weights[k]))
            self.pictures[k - 1].mirror()
        return float(weights[0]), self.pictures[0]

    def bloomed(self, film: np.ndarray, strength: float, radius: float) -> np.ndarray:
        """(height, width, 4): the film of a small size with `strength` of its light spread; a buffer that is used again."""
        own, _ = self.spread(*flat(film, TILE // 4), radius)
        inner = self._full.whole[PAD:-PAD, PAD:-PAD]
        inner[:] = film
        np.multiply(self.pictures[0].floats, strength, out=self.pictures[0].floats)
        self._up(0, self._full, 1.0 + strength * (own - 1.0))
        inner[..., 3] = film[..., 3]
        return inner


@lru_cache(2)
def chain(width: int, height: int) -> Halo:
    """The chain for this size, kept from picture to picture."""
    return Halo(width, height)


def flat(film: np.ndarray, least: int) -> tuple[np.ndarray, int]:
    """The film as flat float32, at least so many pixels wide, and the floats from row to row; copied only where it must be."""
    film = np.asarray(film, dtype=np.float32)
    height, width, _ = film.shape
    if width < least:
        film, width = np.pad(film, ((0, 0), (0, least - width), (0, 0))), least
    row = film.strides[0] // 4
    if film.strides[1:] != (16, 4) or film.strides[0] % 16 or row < 4 * width or film.ctypes.data % 16:
        whole = aligned(film.shape, np.float32)
        whole[:] = film
        film, row = whole, 4 * width
    length = (height - 1) * row + 4 * width
    return np.lib.stride_tricks.as_strided(film, (length,), (4,), writeable=False), row


def stray_light(film: np.ndarray, radius: float) -> np.ndarray:
    """The film's light spread over halos of all sizes, (height, width, 4) float32, alpha left as it is.

    `develop` does the last step of a tall film in its own kernel; here it is NumPy's.
    """
    height, width = film.shape[:2]
    halo = chain(width, height)
    if halo.scales[0] != 4:
        return halo.bloomed(np.asarray(film, np.float32), 1.0, radius).copy()
    own, coarse = halo.spread(*flat(film, TILE // 4), radius)
    weights = blend_weights()

    def up(picture, n):
        j = np.arange(n)
        return sum(picture[j // 4 + e] * weights[j % 4, e][:, None, None] for e in range(5))

    rows = up(coarse.whole, height)
    return own * film + up(rows.transpose(1, 0, 2), width).transpose(1, 0, 2)
