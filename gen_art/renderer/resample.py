"""Pictures a whole number of times coarser or finer, whose sums and even light stay as they are for any size.

In one dimension coarse pixel i of scale s takes the weights f of the fine pixels around it; a fine pixel hands all it has
to the coarse ones (weights of one phase sum to 1), and what would fall beyond the border is mirrored back. With S the
matrix of those shares, R = S^T R' the share of the film a coarse pixel stands for (R' that of the finer picture), going
down is R^-1 S^T R' and going up is S.

f is a box of s pixels, which makes the weights of a phase sum to 1, convolved with a bell that keeps the coarse grid from
showing.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.runtime import kernel, ti

__all__ = [
    "PAD", "ROWS", "TAPS", "TILE", "Columns", "Rows", "blend_weights", "mirrored", "resample", "steps", "variance",
]  # fmt: skip

PAD = 2  # mirrored pixels on each side of a coarse picture, so that no weight asks where the border is
TAPS = 4  # coarse pixels that a fine one hands its light to
TILE = 64  # floats: 16 pixels of RGBA
ROWS = 8  # rows that one turn makes, with one row of scratch

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, I2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i32, 2)


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


@dataclass(frozen=True)
class Rows:
    """How rows are made from rows: the first one (before clamping), and the weights (n, taps)."""

    first: np.ndarray
    weights: np.ndarray


@dataclass(frozen=True)
class Columns:
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


def steps(n: int, scales: list[int]) -> list[tuple[int, Rows, Columns, Rows, Columns]]:
    """For each level along n pixels of the film: its length, going down to it, and coming up from it."""
    levels, share = [], np.ones(n)
    for scale in scales:
        m, length = -(-n // scale), TAPS * scale
        last, shares = _shares(n, scale)
        first = scale * np.arange(m) + (scale - length) // 2
        down = np.zeros((m, length))
        for t in range(TAPS):
            i = mirrored(last - t, m)
            np.add.at(down, (i, np.arange(n) - first[i]), shares[:, t] * share)
        share = down.sum(axis=1)
        down = (down / share[:, None]).astype(np.float32)
        room = m + 2 * PAD + TILE // 4
        a = np.arange(length) + (scale - length) // 2
        offset = ((a % scale) * room + a // scale + PAD)[None] * 4
        weights = np.zeros((1, length, _wide(4 * m)), np.float32)
        weights[0, :, : 4 * m] = np.repeat(down.T, 4, axis=1)
        columns = Columns(scale // 2, room, PAD, offset.astype(np.int32), weights)
        up = Rows((last - TAPS + 1 + PAD).astype(np.int32), np.ascontiguousarray(shares[:, ::-1], dtype=np.float32))
        end, phase = _shares(scale, scale)
        offset = (end[:, None] - TAPS + 1 + PAD + np.arange(TAPS)) * 4
        weights = np.repeat(phase[:, ::-1, None].astype(np.float32), _wide(4 * m), axis=2)
        wide = Columns(0, room, 0, offset.astype(np.int32), weights)
        levels.append((m, Rows(first.astype(np.int32), down), columns, up, wide))
        n = m
    return levels


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
                for k in range(ti.min(TILE // 4, width)):
                    p = at // 4 + k
                    slot = base + ((p & ((1 << shift) - 1)) * room + (p >> shift) + left) * 4
                    for c in ti.static(range(4)):
                        work[slot + c] = v[4 * k + c]
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
                    for k in range(ti.min(TILE, count - t * TILE) // 4):
                        e = goal_start + r * goal_stride + ((t * (TILE // 4) + k) * passes + p) * 4
                        for c in ti.static(range(4)):
                            if own == 0.0:
                                goal[e + c] = v[4 * k + c]
                            else:
                                goal[e + c] = goal[e + c] * own + v[4 * k + c]


resample = kernel(_resample)
