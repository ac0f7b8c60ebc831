"""Pictures a whole number of times coarser or finer, whose sums and even light stay as they are for any size.

In one dimension coarse pixel i of scale s takes the weights f of the fine pixels around it; a fine pixel hands all it has
to the coarse ones (weights of one phase sum to 1), and what would fall beyond the border is mirrored back. With S the
matrix of those shares, R = S^T R' the share of the film a coarse pixel stands for (R' that of the finer picture), going
down is R^-1 S^T R' and going up is S.

f is a box of s pixels, which makes the weights of a phase sum to 1, convolved with a bell that keeps the coarse grid from
showing.

Rows are blended first, then columns, a pixel (RGBA) at a time; whole vectors hold four pixels.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from gen_art.runtime import aligned, kernel, ti

__all__ = ["PAD", "WIDE", "Taps", "blend_weights", "mirrored", "resample", "scratch", "steps", "variance"]

PAD = 2  # mirrored pixels on each side of a coarse picture, so that who blends its pixels need not ask where the border is
TAPS = 4  # coarse pixels that a fine one hands its light to
WIDE = 16  # floats of a vector: four pixels of RGBA
_FEW = 10000  # pixels, for which other threads are not woken
_ROWS = 8  # rows that one turn makes, with one row of scratch

F2, I1 = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 1)
FLOATS, PIXELS = (ti.types.ndarray(ti.types.vector(n, ti.f32), 1) for n in (WIDE, 4))

_BELLS = {4: [2, 5, 10, 16, 22, 26, 28, 26, 22, 16, 10, 5, 2], 2: [1, 4, 8, 10, 8, 4, 1], 1: [1, 3, 3, 1]}


def _filter(scale: int) -> np.ndarray:
    """The weights f, of length 4 scale, sum 1."""
    bell = np.array(_BELLS[scale], np.float64)
    return np.convolve(np.full(scale, 1.0 / scale), bell / bell.sum())


_FILTERS = {scale: _filter(scale) for scale in _BELLS}


def variance(scale: int) -> float:
    f = _FILTERS[scale]
    return float(f @ (np.arange(len(f)) - (len(f) - 1) / 2) ** 2)


def mirrored(i: np.ndarray, n: int) -> np.ndarray:
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


class Taps(NamedTuple):
    """Along one axis, result i is the sum over a of weights[i, a] times what stands at first[i] + a; beyond the end it is 0."""

    first: np.ndarray
    weights: np.ndarray

    def bordered(self) -> "Taps":
        """The same with PAD results more on each side, the mirrored ones."""
        n = len(self.first)
        i = mirrored(np.arange(-PAD, n + PAD), n)
        return Taps(np.ascontiguousarray(self.first[i]), np.ascontiguousarray(self.weights[i]))

    def columns(self, left: int) -> "Taps":
        """The same by whole vectors of a row whose first pixel is number `left`: first vectors, and (n count, WIDE) weights."""
        n, length = self.weights.shape
        begin, lead = np.divmod(self.first + left, 4)
        wide = np.zeros((n, -(-(length + 3) // 4) * 4))
        np.put_along_axis(wide, lead[:, None] + np.arange(length), self.weights, axis=1)
        weights = aligned((wide.size // 4, WIDE), np.float32)
        weights[:] = wide.repeat(4, axis=1).reshape(-1, WIDE)
        return Taps(begin.astype(np.int32), weights)


def _taps(result: np.ndarray, place: np.ndarray, weight: np.ndarray, first: np.ndarray, length: int) -> Taps:
    """Of contributions `weight` from `place` to `result`."""
    weights = np.zeros((len(first), length))
    np.add.at(weights, (result, place - first[result]), weight)
    return Taps(first.astype(np.int32), weights)


def steps(n: int, scales: list[int]) -> list[tuple[int, Taps, Taps]]:
    """For each level along n pixels of the film: its length, going down to it, and coming up from it."""
    levels, share = [], np.ones(n)
    for scale in scales:
        m, length = -(-n // scale), TAPS * scale
        last, shares = _shares(n, scale)
        fine = np.repeat(np.arange(n), TAPS)
        coarse = mirrored(last[:, None] - np.arange(TAPS), m).reshape(-1)
        begin = scale * np.arange(m) + (scale - length) // 2
        down = _taps(coarse, fine, (shares * share[:, None]).reshape(-1), np.clip(begin, 0, max(n - length, 0)), length)
        share = down.weights.sum(axis=1)
        down = Taps(down.first, (down.weights / share[:, None]).astype(np.float32))
        up = _taps(fine, coarse, shares.reshape(-1), np.clip(last - TAPS + 1, 0, max(m - TAPS, 0)), TAPS)
        levels.append((m, down, Taps(up.first, up.weights.astype(np.float32))))
        n = m
    return levels


def scratch(across: int, high: int) -> tuple[int, int]:
    """How many vectors one turn needs for rows of `across` vectors, and how many all turns of `high` rows do."""
    room = across + 4 * TAPS  # the columns of a picture narrower than their taps
    return room, -(-high // _ROWS) * room


@cache
def _resampling(alone: bool):
    """The kernel on all threads, or on the one that calls it: sooner done where there is little to do."""

    @ti.kernel
    def resample_rows_and_columns(
        source: FLOATS, start: ti.i32, stride: ti.i32, across: ti.i32, last: ti.i32, y: I1, wy: F2, x: I1, wx: FLOATS,
        own: ti.f32, goal_start: ti.i32, goal_stride: ti.i32, work: FLOATS, room: ti.i32, goal: PIXELS,
    ):  # fmt: skip
        high, wide = y.shape[0], x.shape[0]
        count = wx.shape[0] // wide
        ti.loop_config(serialize=alone, block_dim=1)
        for b in range((high + _ROWS - 1) // _ROWS):
            base = b * room
            for r in range(b * _ROWS, ti.min((b + 1) * _ROWS, high)):
                for t in range(across // 4):
                    v0, v1, v2, v3 = (
                        ti.Vector([0.0] * WIDE),
                        ti.Vector([0.0] * WIDE),
                        ti.Vector([0.0] * WIDE),
                        ti.Vector([0.0] * WIDE),
                    )
                    for a in range(wy.shape[1]):
                        n = wy.shape[1] - 1 - a  # what is farthest in memory first
                        o, weight = start + ti.min(y[r] + n, last) * stride + 4 * t, wy[r, n]
                        v0 += source[o] * weight
                        v1 += source[o + 1] * weight
                        v2 += source[o + 2] * weight
                        v3 += source[o + 3] * weight
                    o = base + 4 * t
                    work[o], work[o + 1], work[o + 2], work[o + 3] = v0, v1, v2, v3
                for q in range(wide):
                    o = base + x[q]
                    v = work[o] * wx[q * count] + work[o + 1] * wx[q * count + 1]
                    for k in range(2, count):
                        v += work[o + k] * wx[q * count + k]
                    e = goal_start + r * goal_stride + q
                    one, two = ti.Vector([v[c] for c in range(4)]), ti.Vector([v[4 + c] for c in range(4)])
                    three, four = ti.Vector([v[8 + c] for c in range(4)]), ti.Vector([v[12 + c] for c in range(4)])
                    p = (one + two) + (three + four)
                    if own != 0.0:
                        p += goal[e] * own
                    goal[e] = p

    return kernel(resample_rows_and_columns, vectors=True)


def resample(source: tuple, rows: Taps, columns: Taps, own: float, goal: tuple, work: np.ndarray, room: int):
    """The kernel and the arguments of goal = own goal + source resampled, first its rows, then its columns.

    source : vectors, number of the first, vectors from row to row and in a row, a multiple of four, number of the last row
    goal : number of the first pixel, pixels from row to row, pixels     work : `room` vectors a turn
    """
    launch = _resampling(len(columns.first) * len(rows.first) < _FEW)
    return launch, (*source, *rows, *columns, own, *goal[:2], work, room, goal[2])
