"""Light that strays in the lens: halos of all sizes, whose sum is the light they came from, wherever a point lies.

A chain of coarser pictures: the first has a quarter of the film's width and height, each further one half of the one before.
In one dimension coarse pixel i of scale s takes the weights f of the fine pixels around it; a fine pixel hands all it has to
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

__all__ = ["PAD", "Halo", "blend_weights", "levels", "stray_light"]

PAD = 2  # mirrored pixels on each side of a coarse picture, so that no weight asks where the border is
TAPS = 4  # coarse pixels that a fine one hands its light to
TILE = 64  # floats: 16 pixels of RGBA
ROWS = 8  # rows that one turn makes, with one row of scratch
NARROWEST, OCTAVES = 1 / 500, 7  # standard deviations of the halos: from a 500th of the picture's height, each twice the last

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, I2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i32, 2)


def _filter(scale: int) -> np.ndarray:
    """The weights f, of length 4 scale, sum 1."""
    bell = np.array([2, 5, 10, 16, 22, 26, 28, 26, 22, 16, 10, 5, 2] if scale == 4 else [1, 4, 8, 10, 8, 4, 1], np.float64)
    return np.convolve(np.full(scale, 1.0 / scale), bell / bell.sum())


_FILTERS = {4: _filter(4), 2: _filter(2)}


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
    """(4, 5): a fine pixel of phase p takes weights[p] of the first coarse picture's (padded) pixels q .. q + 4 at j = 4 q + p."""
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
    """How columns are made. The source's row is laid out by phase, pixel p at slot (p mod 2^shift) room + p div 2^shift + left;
    pass by pass, result q passes + pass is the sum over taps of weights[pass, tap, 4 q + channel] times the float at 4 q + channel
    + offset[pass, tap]."""

    shift: int
    room: int
    left: int
    offset: np.ndarray
    weights: np.ndarray


def _wide(n: int) -> int:
    return -(-n // TILE) * TILE


def _steps(n: int, depth: int) -> list[tuple[int, _Rows, _Columns, _Rows, _Columns]]:
    """For each level along n pixels of the film: its length, going down to it, and coming up from it."""
    steps, share = [], np.ones(n)
    for k in range(depth):
        scale = 2 if k else 4
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
        columns = _Columns(2 if scale == 4 else 1, room, PAD, offset.astype(np.int32), weights)
        up = _Rows((last - TAPS + 1 + PAD).astype(np.int32), np.ascontiguousarray(shares[:, ::-1], dtype=np.float32))
        phase = np.array([_shares(2, 2)[1][p, ::-1] for p in range(2)], np.float32)
        steps.append((
            m, _Rows(first.astype(np.int32), down), columns, up,
            _Columns(0, m + 2 * PAD + TILE // 4, 0, (np.arange(TAPS) + np.arange(2)[:, None]).astype(np.int32) * 4,
                     np.repeat(phase[:, :, None], _wide(4 * m), axis=2)),
        ))  # fmt: skip
        n = m
    return steps


@ti.kernel
def _resample(
    source: F1, start: ti.i32, stride: ti.i32, width: ti.i32, height: ti.i32, y: I1, wy: F2, shift: ti.i32, room: ti.i32,
    left: ti.i32, offset: I2, wx: F3, own: ti.f32, goal_start: ti.i32, goal_stride: ti.i32, across: ti.i32, high: ti.i32,
    work: F1, goal: F1,
):  # fmt: skip
    """goal (high, across) = own * goal + source (height, width) resampled, first its rows, then its columns; strides in floats."""
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


def levels(height: int, radius: float) -> np.ndarray:
    """Weights of the picture itself and of the chain's pictures, sum 1, so that the halos mean the same at any size.

    Halo k of OCTAVES has standard deviation 2^k height / 500 and weight (0.35 + 0.85 radius)^k; a deviation between those of two
    pictures of the chain is shared by them so that the variance is right.
    """
    variances = [0.0, 2.0 * _variance(4)]
    widest = (NARROWEST * height * 2.0 ** (OCTAVES - 1)) ** 2
    while variances[-1] < widest:
        variances.append(variances[-1] + 2.0 * _variance(2) * 4.0 ** len(variances))
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


class Halo:
    """The chain for one size of film: its tables and buffers, used again for each picture."""

    def __init__(self, width: int, height: int):
        self.size, self.depth = (width, height), len(levels(height, 0.0)) - 1
        self._across, self._down = _steps(width, self.depth), _steps(height, self.depth)
        self.pictures = []
        self._work = []
        for (m, _, down, _, up), (n, *_) in zip(self._across, self._down, strict=True):
            self.pictures.append(np.zeros((n + 2 * PAD, m + 2 * PAD, 4), np.float32))
            # of their own: what lies between the phases is never written, and stays zero
            self._work.append([np.zeros((-(-h // ROWS) * c.room << c.shift) * 4, np.float32) for h, c in ((n, down), (2 * n, up))])

    def _go(self, k: int, source, start, stride, width, height, rows, columns, own, across, high, work):
        picture = self.pictures[k]
        line = picture.shape[1] * 4
        resample(
            source, start, stride, width, height, rows.first, rows.weights, columns.shift, columns.room, columns.left, columns.offset,
            columns.weights, own, PAD * (line + 4), line, across, high, work, picture.reshape(-1),
        )  # fmt: skip
        for side in (picture, picture.transpose(1, 0, 2)):
            n = len(side) - 2 * PAD
            beyond = np.array([-2, -1, n, n + 1])
            side[beyond + PAD] = side[_mirrored(beyond, n) + PAD]

    def spread(self, film: np.ndarray, stride: int, radius: float) -> tuple[float, np.ndarray]:
        """The film's stray light: the share that stays where it is, and the first coarse picture with its borders (h, w, 4).

        film : flat float32 RGBA, `stride` floats a row. The coarse picture holds the rest, as bright as it is to be seen.
        """
        weights = levels(self.size[1], radius)
        source, start, step, (width, height) = film, 0, stride, self.size
        for k in range(self.depth):
            (across, _, columns, _, _), (high, rows, _, _, _) = self._across[k], self._down[k]
            self._go(k, source, start, step, width, height, rows, columns, 0.0, across, high, self._work[k][0])
            source, step = self.pictures[k].reshape(-1), self.pictures[k].shape[1] * 4
            start, width, height = PAD * (step + 4), across, high
        self.pictures[-1] *= weights[-1]
        for k in range(self.depth - 1, 0, -1):
            source = self.pictures[k]
            self._go(
                k - 1, source.reshape(-1), 0, source.shape[1] * 4, source.shape[1], source.shape[0], self._down[k][3],
                self._across[k][4], float(weights[k]), self._across[k - 1][0], self._down[k - 1][0], self._work[k][1],
            )  # fmt: skip
        return float(weights[0]), self.pictures[0]


@lru_cache(2)
def chain(width: int, height: int) -> Halo:
    """The chain for this size, kept from picture to picture."""
    return Halo(width, height)


def stray_light(film: np.ndarray, radius: float) -> np.ndarray:
    """The film's light spread over halos of all sizes, (height, width, 4) float32, in NumPy from the first coarse picture on.

    `develop` does the same last step in its kernel.
    """
    height, width = film.shape[:2]
    wide = np.pad(np.asarray(film, np.float32), ((0, 0), (0, max(TILE // 4 - width, 0)), (0, 0)))
    own, coarse = chain(width, height).spread(wide.reshape(-1), wide.shape[1] * 4, radius)
    weights = blend_weights()

    def up(picture, n):
        j = np.arange(n)
        return sum(picture[j // 4 + e] * weights[j % 4, e][:, None, None] for e in range(5))

    rows = up(coarse, height)
    return own * film + up(rows.transpose(1, 0, 2), width).transpose(1, 0, 2)
