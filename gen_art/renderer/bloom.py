"""Light that strays in the lens: halos of all sizes, whose sum is the light they came from, wherever a point lies.

A chain of coarser pictures, each further one half of the one before. The first has a quarter of a tall film's width and
height; a small film's has a half or all of them, so that its narrow halos are told apart too. In one dimension coarse
pixel i of scale s takes the weights f of the fine pixels around it; a fine pixel hands all it has to
the coarse ones (weights of one phase sum to 1), and what would fall beyond the border is mirrored back. With S the
matrix of those shares, R = S^T R' the share of the film a coarse pixel stands for (R' that of the finer picture),
going down is R^-1 S^T R' and going up is S: sums and even light stay as they are, for any size.

f is a box of s pixels, which makes the weights of a phase sum to 1, convolved with a bell that keeps the coarse grid from
showing: a point's halo changes by under 0.5 % of its peak with the point's place (a test holds it).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gen_art.runtime import kernel, ti

__all__ = ["TILE", "Halo", "blend_weights", "chain", "flat", "levels", "stray_light"]

PAD = 2  # mirrored pixels on each side of a coarse picture, so that no weight asks where the border is
TAPS = 4  # coarse pixels that a fine one hands its light to
TILE = 64  # floats: 16 pixels of RGBA
ROWS = 8  # rows that one turn makes, with one row of scratch
NARROWEST, OCTAVES = 1 / 500, 7  # the halos' standard deviations: from a 500th of the height, each twice the last
QUARTER, HALF = 800, 400  # rows from which the first picture has a quarter, or a half, of the film's

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, I2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i32, 2)


_BELLS = {4: [2, 5, 10, 16, 22, 26, 28, 26, 22, 16, 10, 5, 2], 2: [1, 4, 8, 10, 8, 4, 1], 1: [1, 3, 3, 1]}


def _filter(scale: int) -> np.ndarray:
    """The weights f, of length 4 scale, sum 1."""
    bell = np.array(_BELLS[scale], np.float64)
    return np.convolve(np.full(scale, 1.0 / scale), bell / bell.sum())


_FILTERS = {scale: _filter(scale) for scale in _BELLS}


def _variance(scale: int) -> float:
    f = _FILTERS[scale]
    return float(f @ (np.arange(len(f)) - (len(f) - 1) / 2) ** 2)


def _mirrored(i: np.ndarray, n: int) -> np.ndarray:
    """Indices folded into 0..n - 1 at the borders, as often as it takes."""
    i = np.mod(i, 2 * n)
    return np.where(i < n, i, 2 * n - 1 - i)


def _shares(n: int, scale: int):
    """For n fine pixels the last coarse pixel each hands light to, (n,), and its TAPS shares, from the last one back (n, 4)."""
    f = _FILTERS[scale]
    j = np.arange(n)
    last = (j + len(f) // 2 - scale // 2) // scale
    a = (j - scale * last)[:, None] + scale * np.arange(TAPS) + (len(f) - scale) // 2
    return last, scale * f[a]


def blend_weights() -> np.ndarray:
    """(4, 5): fine pixel 4 q + p takes weights[p] of the pixels q .. q + 4 of a quarter picture with its border."""
    f = _FILTERS[4]
    a = np.arange(4)[:, None] + 14 - 4 * np.arange(5)
    return np.where((a >= 0) & (a < 16), 4.0 * f[np.clip(a, 0, 15)], 0.0).astype(np.float32)


@dataclass(frozen=True)
class _Rows:
    """How rows are made from rows: the first one (before clamping), and the weights (n, taps)."""

    first: np.ndarray
    weights: np.ndarray


@dataclass(frozen=True)
class _Columns:
    """How columns are made. The source's row is laid out by phase: pixel p at slot (p mod 2^shift) room + p div 2^shift + left.
    Pass by pass, result q passes + pass is the sum over taps of weights[pass, tap, 4 q + channel] times the float at
    4 q + channel + offset[pass, tap]."""

    shift: int
    room: int
    left: int
    offset: np.ndarray
    weights: np.ndarray


def _wide(n: int) -> int:
    return -(-n // TILE) * TILE


def _steps(n: int, scales: list[int]) -> list[tuple[int, _Rows, _Columns, _Rows, _Columns]]:
    """For each level along n pixels of the film: its length, going down to it, and coming up from it."""
    steps, share = [], np.ones(n)
    for scale in scales:
        m, length = -(-n // scale), TAPS * scale
        last, shares = _shares(n, scale)
        first = scale * np.arange(m) + (scale - length) // 2
        down = np.zeros((m, length))
        for t in range(TAPS):
            i = _mirrored(last - t, m)
            np.add.at(down, (i, np.arange(n) - first[i]), shares[:, t] * share)
        share = down.sum(axis=1)
        down = (down / share[:, None]).astype(np.float32)
        room = m + 2 * PAD + TILE // 4
        a = np.arange(length) + (scale - length) // 2
        offset = ((a % scale) * room + a // scale + PAD)[None] * 4
        weights = np.zeros((1, length, _wide(4 * m)), np.float32)
        weights[0, :, : 4 * m] = np.repeat(down.T, 4, axis=1)
        columns = _Columns(scale // 2, room, PAD, offset.astype(np.int32), weights)
        up = _Rows((last - TAPS + 1 + PAD).astype(np.int32), np.ascontiguousarray(shares[:, ::-1], dtype=np.float32))
        end, phase = _shares(scale, scale)
        offset = (end[:, None] - TAPS + 1 + PAD + np.arange(TAPS)) * 4
        weights = np.repeat(phase[:, ::-1, None].astype(np.float32), _wide(4 * m), axis=2)
        wide = _Columns(0, room, 0, offset.astype(np.int32), weights)
        steps.append((m, _Rows(first.astype(np.int32), down), columns, up, wide))
        n = m
    return steps


@ti.kernel
def _resample(
    source: F1, start: ti.i32, stride: ti.i32, width: ti.i32, height: ti.i32, y: I1, wy: F2, shift: ti.i32, room: ti.i32,
    left: ti.i32, offset: I2, wx: F3, own: ti.f32, goal_start: ti.i32, goal_stride: ti.i32, across: ti.i32, high: ti.i32,
    work: F1, goal: F1,
):  # fmt: skip
    """goal (high, across) = own goal + source (height, width) resampled, first its rows, then its columns; strides in floats."""
    vertical, passes, horizontal = wy.shape[1], offset.shape[0], offset.shape[1]
    ti.loop_config(block_dim=1)
    for b in range((high + ROWS - 1) // ROWS):
        base = (b * room << shift) * 4
        for r in range(b * ROWS, ti.min((b + 1) * ROWS, high)):
            for t in range((width * 4 + TILE - 1) // TILE):
                at = ti.max(ti.min(t * TILE, width * 4 - TILE), 0)
                v = ti.Vector([0.0] * TILE)
                for a in range(vertical // 4):
                    o, w = ti.Vector([0] * 4), ti.Vector([0.0] * 4)
                    for g in ti.static(range(4)):
                        o[g] = start + ti.min(ti.max(y[r] + 4 * a + g, 0), height - 1) * stride + at
                        w[g] = wy[r, 4 * a + g]
                    for k in range(TILE):
                        total = v[k]
                        for g in ti.static(range(4)):
                            total += source[o[g] + k] * w[g]
                        v[k] = total
                for k in range(ti.min(TILE, width * 4)):
                    p = (at + k) >> 2
                    work[base + ((p & ((1 << shift) - 1)) * room + (p >> shift) + left) * 4 + (k & 3)] = v[k]
            for p in range(passes):
                count = (across - p + passes - 1) // passes * 4
                for t in range((count + TILE - 1) // TILE):
                    v = ti.Vector([0.0] * TILE)
                    for a in range(horizontal // 4):
                        o = ti.Vector([0] * 4)
                        for g in ti.static(range(4)):
                            o[g] = base + offset[p, 4 * a + g] + t * TILE
                        for k in range(TILE):
                            total = v[k]
                            for g in ti.static(range(4)):
                                total += work[o[g] + k] * wx[p, 4 * a + g, t * TILE + k]
                            v[k] = total
                    o = goal_start + r * goal_stride
                    for k in range(ti.min(TILE, count - t * TILE)):
                        e = o + (((t * TILE + k) >> 2) * passes + p) * 4 + (k & 3)
                        if own == 0.0:
                            goal[e] = v[k]
                        else:
                            goal[e] = goal[e] * own + v[k]


resample = kernel(_resample)


def _scales(height: int) -> tuple[list[int], list[float]]:
    """Each picture's scale to the one before, and the variance, in pixels of the film, of going down to it and up again."""
    scales, variances, size = [4 if height >= QUARTER else 2 if height >= HALF else 1], [0.0], 1
    widest = (NARROWEST * height * 2.0 ** (OCTAVES - 1)) ** 2
    while True:
        variances.append(variances[-1] + 2.0 * _variance(scales[-1]) * size**2)
        if variances[-1] >= widest:
            return scales, variances
        size *= scales[-1]
        scales.append(2)


def levels(height: int, radius: float) -> np.ndarray:
    """Weights of the picture itself and of the chain's pictures, sum 1, so that the halos mean the same at any size.

    Halo k of OCTAVES has standard deviation 2^k height / 500 and weight (0.35 + 0.85 radius)^k; a deviation between those of two
    pictures of the chain is shared by them so that the variance is right.
    """
    variances = _scales(height)[1]
    halos = (0.35 + 0.85 * radius) ** np.arange(OCTAVES, dtype=np.float64)
    weights = np.zeros(len(variances))
    for k, weight in enumerate(halos / halos.sum()):
        variance = (NARROWEST * height * 2.0**k) ** 2
        low = int(np.searchsorted(variances, variance, side="right")) - 1
        low = min(low, len(variances) - 2)
        part = (variance - variances[low]) / (variances[low + 1] - variances[low])
        weights[low] += weight * (1.0 - part)
        weights[low + 1] += weight * part
    return weights.astype(np.float32)


@dataclass(frozen=True)
class _Picture:
    """A picture of the chain: its floats, whose end has room for a tile's reading beyond it, and its size without borders."""

    floats: np.ndarray
    width: int
    height: int

    @property
    def stride(self) -> int:
        return (self.width + 2 * PAD) * 4

    @property
    def whole(self) -> np.ndarray:
        """(height + 2 PAD, width + 2 PAD, 4)"""
        return self.floats[:-TILE].reshape(self.height + 2 * PAD, -1, 4)

    def mirror(self) -> None:
        """Fill the borders."""
        for side in (self.whole, self.whole.transpose(1, 0, 2)):
            n = len(side) - 2 * PAD
            beyond = np.array([-2, -1, n, n + 1])
            side[beyond + PAD] = side[_mirrored(beyond, n) + PAD]


def _picture(width: int, height: int) -> _Picture:
    return _Picture(np.zeros((height + 2 * PAD) * (width + 2 * PAD) * 4 + TILE, np.float32), width, height)


class Halo:
    """The chain for one size of film: its tables and buffers, used again for each picture."""

    def __init__(self, width: int, height: int):
        self.size, self.scales = (width, height), _scales(height)[0]
        self._across, self._down = _steps(width, self.scales), _steps(height, self.scales)
        self.pictures: list[_Picture] = []
        self._work = []
        for (m, _, down, _, up), (n, *_), scale in zip(self._across, self._down, self.scales, strict=True):
            self.pictures.append(_picture(m, n))
            # buffers of their own: what lies between the phases is never written, and stays zero
            rows = ((n, down), (scale * n, up))
            self._work.append([np.zeros((-(-h // ROWS) * c.room << c.shift) * 4, np.float32) for h, c in rows])
        self._full = None if self.scales[0] == 4 else _picture(width, height)

    def _go(self, goal: _Picture, source, start, stride, size, rows: _Rows, columns: _Columns, own, work):
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

    def spread(self, film: np.ndarray, stride: int, radius: float) -> tuple[float, np.ndarray]:
        """The film's stray light: the share that stays where it is, and the first picture with its borders (h, w, 4).

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
        return float(weights[0]), self.pictures[0].whole

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
    if film.strides[1:] != (16, 4) or film.strides[0] % 16 or row < 4 * width:
        film, row = np.ascontiguousarray(film), 4 * width
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

    rows = up(coarse, height)
    return own * film + up(rows.transpose(1, 0, 2), width).transpose(1, 0, 2)
