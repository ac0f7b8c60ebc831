"""Pictures resampled by whole factors, so that their sums and even light are preserved at any size.

In one dimension, coarse pixel i of scale s takes the weights f of the fine pixels around it. A fine pixel gives all of its
light to coarse ones (the weights of one phase sum to 1); what would fall beyond the border is mirrored back. With S the matrix
of those shares, and R = S^T R' the share of the full picture that a coarse pixel stands for (R' that of the finer picture),
going down is R^-1 S^T R' and going up is S.

f is a box of s pixels, which makes the weights of a phase sum to 1, convolved with a bell that hides the coarse grid.

The pixels of a row are combined first, then the rows, a pixel (RGBA) at a time; whole vectors hold four pixels.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from gen_art.backend.runtime import INDEX_MASK, aligned, kernel, threads, ti

__all__ = [
    "PAD", "WIDE", "Taps", "VectorTaps", "blend_weights", "level_taps", "mirrored", "resample", "ring_buffer", "variance",
    "vector_taps",
]  # fmt: skip

PAD = 2  # mirrored pixels on each side of a coarse picture, so that upsampling needs no test for the border
TAPS = 4  # coarse pixels that a fine pixel gives its light to
WIDE = 16  # floats of a vector: four pixels of RGBA
_SMALL = 100_000  # pixels of source and target below which one thread is faster than several

F2, I1 = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 1)
FLOATS = ti.types.ndarray(ti.types.vector(WIDE, ti.f32), 1)

_BELLS = {4: [2, 5, 10, 16, 22, 26, 28, 26, 22, 16, 10, 5, 2], 2: [1, 4, 8, 10, 8, 4, 1], 1: [1, 3, 3, 1]}


def _filter(scale: int) -> np.ndarray:
    """The weights f, of length 4 scale, sum 1."""
    bell = np.array(_BELLS[scale], np.float64)
    return np.convolve(np.full(scale, 1.0 / scale), bell / bell.sum())


_FILTERS = {scale: _filter(scale) for scale in _BELLS}


def variance(scale: int) -> float:
    """Variance of the filter of a scale, in fine pixels squared."""
    f = _FILTERS[scale]
    return float(f @ (np.arange(len(f)) - (len(f) - 1) / 2) ** 2)


def mirrored(i: np.ndarray, n: int) -> np.ndarray:
    """Indices mirrored into 0..n - 1 at the borders, as often as needed."""
    i = np.mod(i, 2 * n)
    return np.where(i < n, i, 2 * n - 1 - i)


def _shares(n: int, scale: int):
    """For n fine pixels: the last coarse pixel that each gives light to, (n,), and its TAPS shares from there back, (n, 4)."""
    f = _FILTERS[scale]
    j = np.arange(n)
    last = (j + len(f) // 2 - scale // 2) // scale
    a = (j - scale * last)[:, None] + scale * np.arange(TAPS) + (len(f) - scale) // 2
    return last, scale * f[a]


def blend_weights() -> np.ndarray:
    """(4, 4): fine pixel 4 q + p takes weights[p] of four pixels of a bordered quarter picture, from q + p // 2 on."""
    p = np.arange(4)[:, None]
    return (4.0 * _FILTERS[4][p + 14 - 4 * (p // 2 + np.arange(4))]).astype(np.float32)


class Taps(NamedTuple):
    """Resampling along one axis: result i is the sum over a of weights[i, a] source[first[i] + a], 0 beyond the end."""

    first: np.ndarray
    weights: np.ndarray

    def bordered(self) -> "Taps":
        """The same with PAD more results on each side, the mirrored ones."""
        n = len(self.first)
        i = mirrored(np.arange(-PAD, n + PAD), n)
        return Taps(np.ascontiguousarray(self.first[i]), np.ascontiguousarray(self.weights[i]))


class VectorTaps(NamedTuple):
    """Taps along a row by whole vectors, for groups of four results.

    In most groups the four windows lie as _WINDOWS says: each vector is loaded once, from the group's `first` on, and
    weights_start[q] is where the group's weights begin. At a row's ends each result has a first vector of its own; the
    weights_start of such a group is -1 minus the beginning.
    """

    first: np.ndarray
    weights_start: np.ndarray
    weights: np.ndarray


# (taps, pixels before a row's first): the vector that each of four windows begins with, and how many vectors one takes
_WINDOWS = {
    (16, 0): ((0, 1, 2, 3), 5),
    (8, 0): ((0, 0, 1, 1), 3),
    (8, PAD): ((0, 1, 1, 2), 3),
    (4, 0): ((0, 0, 0, 0), 2),
    (4, PAD): ((0, 0, 0, 0), 3),
}


def _window_vectors(taps: int) -> int:
    """How many vectors a window of taps can span, wherever it begins."""
    return (taps + 6) // 4


def _unique_weights(offset: np.ndarray, weights: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The distinct weights of groups, and where each group's begin.

    offset : (n, 4) pixel of `count` vectors at which each window begins
    weights : (n, 4, taps)
    """
    padded = np.zeros((*offset.shape, 4 * count), np.float32)
    np.put_along_axis(padded, offset[..., None] + np.arange(weights.shape[2]), weights, axis=2)
    unique, group = np.unique(padded.reshape(len(offset), 16 * count), axis=0, return_inverse=True)
    return unique.reshape(-1, 4).repeat(4, axis=1), group.reshape(-1) * 4 * count


def vector_taps(taps: Taps, border: int, source_vectors: int, row_vectors: int) -> VectorTaps:
    """Taps from rows of `source_vectors` vectors, with `border` pixels before the first, to rows of `row_vectors` vectors.

    Results beyond the taps are 0.
    """
    n, length = taps.weights.shape
    offsets, count = _WINDOWS[length, border]
    weights = np.pad(taps.weights, ((0, 4 * row_vectors - n), (0, 0))).reshape(row_vectors, 4, length)
    window_start = np.pad(taps.first, (0, 4 * row_vectors - n), mode="edge").reshape(row_vectors, 4) + border
    base = (window_start // 4 - offsets).min(axis=1, keepdims=True)
    offset = window_start - 4 * (base + offsets)
    regular = (base[:, 0] >= 0) & (base[:, 0] + max(offsets) + count <= source_vectors)
    regular &= (offset + length <= 4 * count).all(axis=1)
    longest = _window_vectors(length)
    first = np.where(regular[:, None], base, np.minimum(window_start // 4, source_vectors - longest))
    shared, shared_start = _unique_weights(offset[regular], weights[regular], count)
    single, single_start = _unique_weights((window_start - 4 * first)[~regular], weights[~regular], longest)
    weights_start = np.zeros(row_vectors, np.int32)
    weights_start[regular], weights_start[~regular] = shared_start, -1 - len(shared) - single_start
    table = aligned((len(shared) + len(single), WIDE), np.float32)
    table[: len(shared)], table[len(shared) :] = shared, single
    return VectorTaps(first.reshape(-1).astype(np.int32), weights_start, table)


def _taps(result: np.ndarray, source: np.ndarray, weight: np.ndarray, first: np.ndarray, length: int) -> Taps:
    """Taps of contributions `weight` from index `source` to index `result`."""
    weights = np.zeros((len(first), length))
    np.add.at(weights, (result, source - first[result]), weight)
    return Taps(first.astype(np.int32), weights)


def level_taps(n: int, scales: list[int]) -> list[tuple[int, Taps, Taps]]:
    """For each level along n pixels of the picture: its length, the taps down to it, and the taps up from it."""
    levels, weight = [], np.ones(n)
    for scale in scales:
        m, length = -(-n // scale), TAPS * scale
        last, shares = _shares(n, scale)
        fine = np.repeat(np.arange(n), TAPS)
        coarse = mirrored(last[:, None] - np.arange(TAPS), m).reshape(-1)
        window_start = scale * np.arange(m) + (scale - length) // 2
        first = np.clip(window_start, 0, max(n - length, 0))
        down = _taps(coarse, fine, (shares * weight[:, None]).reshape(-1), first, length)
        weight = down.weights.sum(axis=1)
        down = Taps(down.first, (down.weights / weight[:, None]).astype(np.float32))
        up = _taps(fine, coarse, shares.reshape(-1), np.clip(last - TAPS + 1, 0, max(m - TAPS, 0)), TAPS)
        levels.append((m, down, Taps(up.first, up.weights.astype(np.float32))))
        n = m
    return levels


def ring_buffer(taps: int, row_vectors: int, pixels: int) -> np.ndarray:
    """Memory for the rows that are needed at a time, for each strip of the target.

    There are few strips, because the rows at the border of two are resampled twice.
    """
    strips = 1 if pixels < _SMALL else 2 * max(1, threads())
    return aligned((strips * taps * row_vectors, WIDE), np.float32)


# which floats of two vectors _add_halves adds to which: the first half to the second, or alternate pixels
_HALVES = (
    (tuple(range(8)), tuple(range(8, 16))),
    tuple(tuple(8 * h + 4 * g + c for h in (0, 1) for c in range(4)) for g in (0, 1)),
)


@ti.func
def _add_halves(v, w, halves: ti.template()):
    """A vector of the sums of one half of each vector with its other half."""
    first_half, second = ti.static(_HALVES[halves])
    return ti.Vector([v[k] for k in ti.static(first_half)] + [w[k] for k in ti.static(first_half)]) + ti.Vector(
        [v[k] for k in ti.static(second)] + [w[k] for k in ti.static(second)]
    )


@ti.func
def _accumulate(total, v, weights: ti.template(), w, k: ti.template(), count: ti.template()):
    """Add v times its weights, v being vector k of the window; nothing if the window has no vector k."""
    if ti.static(0 <= k < count):
        total += v * weights[w + k]
    return total


@ti.func
def _weighted_sum(source: ti.template(), at, weights: ti.template(), weights_start, count: ti.template()):
    o, w = at & INDEX_MASK, weights_start & INDEX_MASK
    v = source[o] * weights[w]
    for k in ti.static(range(1, count)):
        v += source[o + k] * weights[w + k]
    return v


@cache
def _resampling(taps: int, border: int):
    """The kernel for windows of `taps` pixels of a source with `border` pixels before a row's first."""
    offsets, count = _WINDOWS[taps, border]
    single, loads = _window_vectors(taps), max(offsets) + count

    @ti.kernel
    def resample_columns_and_rows(
        source: FLOATS, start: ti.i32, stride: ti.i32, last: ti.i32, first: I1, weights_start: I1, wx: FLOATS, y: I1, wy: F2,
        target_weight: ti.f32, target: FLOATS, ring_buffer: FLOATS,
    ):  # fmt: skip
        height, row_vectors = y.shape[0], weights_start.shape[0]
        strips = ring_buffer.shape[0] // (taps * row_vectors)
        ti.loop_config(block_dim=1)
        for strip in range(strips):
            zero = ti.Vector([0.0] * WIDE)
            base, next_row = strip * taps * row_vectors, 0
            for r in range(strip * height // strips, (strip + 1) * height // strips):
                window_start = y[r]
                for row in range(ti.max(window_start, next_row), window_start + taps):
                    o, p = start + ti.min(row, last) * stride, base + row % taps * row_vectors
                    for q in range(row_vectors):
                        w = weights_start[q]
                        if w >= 0:
                            w &= INDEX_MASK
                            f = (o + first[4 * q]) & INDEX_MASK
                            v0, v1, v2, v3 = zero, zero, zero, zero
                            for k in ti.static(range(loads)):
                                v = source[f + k]
                                v0 = _accumulate(v0, v, wx, w, k - offsets[0], count)
                                v1 = _accumulate(v1, v, wx, w + count, k - offsets[1], count)
                                v2 = _accumulate(v2, v, wx, w + 2 * count, k - offsets[2], count)
                                v3 = _accumulate(v3, v, wx, w + 3 * count, k - offsets[3], count)
                            ring_buffer[p + q] = _add_halves(_add_halves(v0, v1, 0), _add_halves(v2, v3, 0), 1)
                        else:
                            w = -1 - w
                            v0 = _weighted_sum(source, o + first[4 * q], wx, w, single)
                            v1 = _weighted_sum(source, o + first[4 * q + 1], wx, w + single, single)
                            v2 = _weighted_sum(source, o + first[4 * q + 2], wx, w + 2 * single, single)
                            v3 = _weighted_sum(source, o + first[4 * q + 3], wx, w + 3 * single, single)
                            ring_buffer[p + q] = _add_halves(_add_halves(v0, v1, 0), _add_halves(v2, v3, 0), 1)
                next_row = window_start + taps
                # row n of the ring buffer has the weight of the picture's row that stands in it
                weights = ti.Vector([wy[r, (n - window_start) & (taps - 1)] for n in ti.static(range(taps))])
                for q in range(row_vectors):
                    o = (base + q) & INDEX_MASK
                    v = ring_buffer[o] * weights[0]
                    for n in ti.static(range(1, taps)):
                        v += ring_buffer[o + n * row_vectors] * weights[n]
                    if target_weight != 0.0:
                        v += target[r * row_vectors + q] * target_weight
                    target[r * row_vectors + q] = v

    return kernel(resample_columns_and_rows, vectors=True)


def resample(
    source: tuple, border: int, column_taps: Taps, row_taps: VectorTaps, target_weight: float, target: np.ndarray,
    ring_buffer: np.ndarray,
):  # fmt: skip
    """The kernel and its arguments for: target = target_weight * target + resampled source, first along rows, then along columns.

    source : (vectors, index of the first, vectors from row to row, index of the last row)
    border : pixels in the source before a row's first
    column_taps : along the columns
    row_taps : along the rows
    target : vectors
    """
    taps = column_taps.weights.shape[1]
    resample_kernel = _resampling(taps, border)
    return resample_kernel, (*source, *row_taps, *column_taps, target_weight, target, ring_buffer)
