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

from gen_art.backend.runtime import INDEX_MASK, aligned, kernel, threads, ti

__all__ = ["PAD", "WIDE", "Taps", "blend_weights", "mirrored", "columns", "resample", "ring", "steps", "variance"]

PAD = 2  # mirrored pixels on each side of a coarse picture, so that who blends its pixels need not ask where the border is
TAPS = 4  # coarse pixels that a fine one hands its light to
WIDE = 16  # floats of a vector: four pixels of RGBA
_FEW = 100_000  # pixels, of source and goal: waking other threads for fewer takes longer than they spare

F2, I1 = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 1)
FLOATS = ti.types.ndarray(ti.types.vector(WIDE, ti.f32), 1)

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
    """(4, 4): fine pixel 4 q + p takes weights[p] of four pixels of a quarter picture with its border, from q + p // 2 on."""
    p = np.arange(4)[:, None]
    return (4.0 * _FILTERS[4][p + 14 - 4 * (p // 2 + np.arange(4))]).astype(np.float32)


class Taps(NamedTuple):
    """Along one axis, result i is the sum over a of weights[i, a] times what stands at first[i] + a; beyond the end it is 0."""

    first: np.ndarray
    weights: np.ndarray

    def bordered(self) -> "Taps":
        """The same with PAD results more on each side, the mirrored ones."""
        n = len(self.first)
        i = mirrored(np.arange(-PAD, n + PAD), n)
        return Taps(np.ascontiguousarray(self.first[i]), np.ascontiguousarray(self.weights[i]))


class Columns(NamedTuple):
    """Taps along a row by whole vectors, for groups of four results.

    In most groups the windows lie as _WINDOWS says: each vector is loaded once, from the group's first on, and place[q] says
    where its weights begin. At a row's ends each result has a first vector of its own; their place is counted down from -1.
    """

    first: np.ndarray
    place: np.ndarray
    weights: np.ndarray


# (taps, pixels before a row's first): which vector each of four windows begins with, and how many vectors it takes
_WINDOWS = {
    (16, 0): ((0, 1, 2, 3), 5),
    (8, 0): ((0, 0, 1, 1), 3),
    (8, PAD): ((0, 1, 1, 2), 3),
    (4, 0): ((0, 0, 0, 0), 2),
    (4, PAD): ((0, 0, 0, 0), 3),
}


def _alone(taps: int) -> int:
    """Vectors that a window of taps takes, wherever it begins."""
    return (taps + 6) // 4


def _placed(lead: np.ndarray, weights: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Weights of groups, (n, 4, taps), from pixel `lead` (n, 4) of `count` vectors on: those that differ, and each group's."""
    wide = np.zeros((*lead.shape, 4 * count), np.float32)
    np.put_along_axis(wide, lead[..., None] + np.arange(weights.shape[2]), weights, axis=2)
    alike, which = np.unique(wide.reshape(len(lead), 16 * count), axis=0, return_inverse=True)
    return alike.reshape(-1, 4).repeat(4, axis=1), which.reshape(-1) * 4 * count


def columns(taps: Taps, left: int, room: int, across: int) -> Columns:
    """Of rows of `room` vectors, whose first pixel is number `left`, to rows of `across`; what lies beyond the taps is 0."""
    n, length = taps.weights.shape
    offsets, count = _WINDOWS[length, left]
    weights = np.pad(taps.weights, ((0, 4 * across - n), (0, 0))).reshape(across, 4, length)
    begin = np.pad(taps.first, (0, 4 * across - n), mode="edge").reshape(across, 4) + left
    base = (begin // 4 - offsets).min(axis=1, keepdims=True)
    lead = begin - 4 * (base + offsets)
    fits = (base[:, 0] >= 0) & (base[:, 0] + max(offsets) + count <= room) & (lead + length <= 4 * count).all(axis=1)
    first = np.where(fits[:, None], base, np.minimum(begin // 4, room - _alone(length)))
    shared, where = _placed(lead[fits], weights[fits], count)
    single, elsewhere = _placed((begin - 4 * first)[~fits], weights[~fits], _alone(length))
    place = np.zeros(across, np.int32)
    place[fits], place[~fits] = where, -1 - len(shared) - elsewhere
    table = aligned((len(shared) + len(single), WIDE), np.float32)
    table[: len(shared)], table[len(shared) :] = shared, single
    return Columns(first.reshape(-1).astype(np.int32), place, table)


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


def ring(taps: int, across: int, pixels: int) -> np.ndarray:
    """Memory for the rows that are needed at a time, of each turn: few, as where two meet, rows are resampled twice."""
    turns = 1 if pixels < _FEW else 2 * max(1, threads())
    return aligned((turns * taps * across, WIDE), np.float32)


# of two vectors, which numbers of each are added to which: the first half to the second, or pixels by turns
_HALVES = (
    (tuple(range(8)), tuple(range(8, 16))),
    tuple(tuple(8 * h + 4 * g + c for h in (0, 1) for c in range(4)) for g in (0, 1)),
)


@ti.func
def _added(v, w, how: ti.template()):
    """Half the numbers of each of two vectors added to the other half."""
    one, other = ti.static(_HALVES[how])
    return ti.Vector([v[k] for k in ti.static(one)] + [w[k] for k in ti.static(one)]) + ti.Vector(
        [v[k] for k in ti.static(other)] + [w[k] for k in ti.static(other)]
    )


@ti.func
def _taken(total, v, weights: ti.template(), w, k: ti.template(), count: ti.template()):
    """With v, the window's vector k, if it has one."""
    if ti.static(0 <= k < count):
        total += v * weights[w + k]
    return total


@ti.func
def _along(source: ti.template(), at, weights: ti.template(), place, count: ti.template()):
    o, w = at & INDEX_MASK, place & INDEX_MASK
    v = source[o] * weights[w]
    for k in ti.static(range(1, count)):
        v += source[o + k] * weights[w + k]
    return v


@cache
def _resampling(taps: int, left: int, alone: bool):
    """The kernel on all threads, or on the one that calls it: sooner done where there is little to do."""
    offsets, count = _WINDOWS[taps, left]
    single, loads = _alone(taps), max(offsets) + count

    @ti.kernel
    def resample_columns_and_rows(
        source: FLOATS, start: ti.i32, stride: ti.i32, last: ti.i32, first: I1, place: I1, wx: FLOATS, y: I1, wy: F2,
        own: ti.f32, goal: FLOATS, ring: FLOATS,
    ):  # fmt: skip
        high, across = y.shape[0], place.shape[0]
        turns = ring.shape[0] // (taps * across)
        ti.loop_config(serialize=alone, block_dim=1)
        for turn in range(turns):
            zero = ti.Vector([0.0] * WIDE)
            base, done = turn * taps * across, 0
            for r in range(turn * high // turns, (turn + 1) * high // turns):
                begin = y[r]
                for row in range(ti.max(begin, done), begin + taps):
                    o, p = start + ti.min(row, last) * stride, base + row % taps * across
                    for q in range(across):
                        w = place[q]
                        if w >= 0:
                            w &= INDEX_MASK
                            f = (o + first[4 * q]) & INDEX_MASK
                            v0, v1, v2, v3 = zero, zero, zero, zero
                            for k in ti.static(range(loads)):
                                v = source[f + k]
                                v0 = _taken(v0, v, wx, w, k - offsets[0], count)
                                v1 = _taken(v1, v, wx, w + count, k - offsets[1], count)
                                v2 = _taken(v2, v, wx, w + 2 * count, k - offsets[2], count)
                                v3 = _taken(v3, v, wx, w + 3 * count, k - offsets[3], count)
                            ring[p + q] = _added(_added(v0, v1, 0), _added(v2, v3, 0), 1)
                        else:
                            w = -1 - w
                            v0 = _along(source, o + first[4 * q], wx, w, single)
                            v1 = _along(source, o + first[4 * q + 1], wx, w + single, single)
                            v2 = _along(source, o + first[4 * q + 2], wx, w + 2 * single, single)
                            v3 = _along(source, o + first[4 * q + 3], wx, w + 3 * single, single)
                            ring[p + q] = _added(_added(v0, v1, 0), _added(v2, v3, 0), 1)
                done = begin + taps
                # row n of the ring has the weight of the row that stands in it
                weights = ti.Vector([wy[r, (n - begin) & (taps - 1)] for n in ti.static(range(taps))])
                for q in range(across):
                    o = (base + q) & INDEX_MASK
                    v = ring[o] * weights[0]
                    for n in ti.static(range(1, taps)):
                        v += ring[o + n * across] * weights[n]
                    if own != 0.0:
                        v += goal[r * across + q] * own
                    goal[r * across + q] = v

    return kernel(resample_columns_and_rows, vectors=True)


def resample(source: tuple, left: int, rows: Taps, along: Columns, own: float, goal: np.ndarray, ring: np.ndarray):
    """The kernel and the arguments of goal = own goal + source resampled, first its columns, then its rows.

    source : vectors, number of the first, vectors from row to row, number of the last row     goal : vectors
    left : pixels in the source before a row's first
    """
    taps, across = rows.weights.shape[1], len(along.place)
    launch = _resampling(taps, left, len(ring) == taps * across)
    return launch, (*source, *along, *rows, own, goal, ring)
