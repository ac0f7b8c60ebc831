"""Small sprites that only add light: straight into the film, without lists.

The film's rows are cut into bands, one for each thread; each thread goes through all particles and adds what falls into its
band. So a pixel takes its light in the order of the particles, whatever the number of bands is and wherever they are cut.
Pixels are vectors of four: read, added to and written as one.

Of points, a tile of particles is looked at by whole vectors, those of the band are listed, the film's memory that they touch is
asked for, and the list is gone through.
"""

from functools import lru_cache

import numpy as np

from gen_art.backend.intrinsics import HAS_PACK, pack, prefetch
from gen_art.backend.runtime import INDEX_MASK, aligned, kernel, threads, ti
from gen_art.renderer.shading import LANES
from gen_art.renderer.sprite import BLUE, GREEN, REACH, RED, X, Y, profile
from gen_art.renderer.vector_maths import ROUND, above, within

__all__ = ["FEW", "LARGEST", "discs", "pixels", "points"]

LARGEST = 4.0  # pixels of reach of a disc that is drawn here
TAPS = 10  # pixels that such a disc may touch along one side; `steps` below counts them
TILE = 32  # discs a turn: those of the band are counted out first, so that no branch is taken for each
SAMPLE = 4096  # particles that tell where to cut the rows
FEW = 32768  # no more particles are drawn as any other sprites: they are not worth kernels of their own

WIDE, PARTS = 32, 16  # numbers of a vector, vectors of a tile of points
POINTS = WIDE * PARTS
# what a band's memory holds of a tile of points: which places are its own, whether a point is the band's and where it lies, its
# pixels and their shares, and the list of places of those that are the band's
_SELF, _MINE, _COLUMN, _ROW, _PLACE, _LOWER, _A, _B, _C, _D, _LIST = (POINTS * k for k in range(11))
MEMORY = 11 * POINTS
_ORDER = tuple(range(WIDE))
_ROUND_BITS = 0x4B400000  # of ROUND, whose last bits a whole number added to it fills

PIXEL = ti.types.vector(4, ti.f32)
I1, F1, F2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)
FILM = ti.types.ndarray(PIXEL, 1)
FLOATS, WORDS = (ti.types.ndarray(ti.types.vector(WIDE, kind), 1) for kind in (ti.f32, ti.i32))


@ti.func
def _all(x, kind: ti.template()):
    return ti.Vector([ti.cast(x, kind) for _ in ti.static(range(WIDE))])


@ti.func
def _floor(x):
    """The whole number below each of a vector's, plus ROUND."""
    near = x + _all(ROUND, ti.f32)
    return ti.select(near - _all(ROUND, ti.f32) > x, near - _all(1.0, ti.f32), near)


@ti.func
def _inside(x, y, x_low, x_high, y_low, y_high, order, left):
    return (x >= x_low) & (x < x_high) & (y >= y_low) & (y < y_high) & (order < _all(left, ti.i32))


@ti.func
def _place(F: ti.template(), I: ti.template(), v, column, row, stride):
    """Which pixel of the film: column and row as whole numbers plus ROUND, of which memory makes words."""
    F[v + _COLUMN // WIDE], F[v + _ROW // WIDE] = column, row
    bits = _all(_ROUND_BITS, ti.i32)
    return (I[v + _ROW // WIDE] - bits) * stride + (I[v + _COLUMN // WIDE] - bits)


@ti.func
def _listed(own: ti.template(), scratch, m):
    """List where the tile's points that are the band's stand in its memory, by no branch; how many they are."""
    count = 0
    if ti.static(HAS_PACK):
        for part in range(PARTS):
            at = scratch + ti.cast(m + part * WIDE, ti.i64) * 4
            pack(at + 4 * _MINE, at + 4 * _SELF, scratch + ti.cast(m + _LIST, ti.i64) * 4, count)
    else:
        for j in range(POINTS):
            own[m + _LIST + count] = m + j
            count += own[m + _MINE + j]
    return count


@ti.func
def _ask(columns, pitch, first):
    """Ask for the columns of WIDE points. Processors see themselves what is read in order, but in each page anew."""
    at = columns + ti.cast(first, ti.i64) * 4
    for c in ti.static((X, Y, RED, GREEN, BLUE)):
        prefetch(at + c * pitch)
        prefetch(at + c * pitch + 64)


@ti.func
def _address(memory, place):
    return memory + ti.cast(place, ti.i64) * 16


@ti.func
def _light(red: ti.template(), green: ti.template(), blue: ti.template(), place):
    i = place & INDEX_MASK
    return ti.Vector([red[i], green[i], blue[i], 0.0])


@ti.func
def _add(film: ti.template(), place, light):
    o = place & INDEX_MASK
    film[o] = film[o] + light


@ti.kernel
def _pixels(
    columns: ti.i64, pitch: ti.i64, memory: ti.i64, scratch: ti.i64, x: FLOATS, y: FLOATS, red: F1, green: F1, blue: F1,
    n: ti.i32, film: FILM, stride: ti.i32, width: ti.i32, cuts: I1, bands: ti.i32, F: FLOATS, I: WORDS, own: I1,
):  # fmt: skip
    """Each point's light into the pixel that it lies in.

    columns, memory, scratch : where the columns lie, each `pitch` bytes after the one before, the film, and the bands' memory
    F, I, own : the bands' memory, MEMORY numbers each
    """
    ti.loop_config(block_dim=1)
    for band in range(bands):
        zero, w = _all(0.0, ti.f32), _all(width, ti.f32)
        low, high = _all(cuts[band], ti.f32), _all(cuts[band + 1], ti.f32)
        order, none, one, down = ti.Vector(_ORDER), _all(0, ti.i32), _all(1, ti.i32), _all(stride, ti.i32)
        home = _all(cuts[band] * stride, ti.i32)
        m = (band * MEMORY) & INDEX_MASK
        for tile in range((n + POINTS - 1) // POINTS):
            t = (tile * POINTS) & INDEX_MASK
            for part in range(PARTS):
                _ask(columns, pitch, t + POINTS + part * WIDE)
                a, b, at = x[t // WIDE + part], y[t // WIDE + part], m // WIDE + part
                here = _inside(a, b, zero, w, low, high, order, n - t - part * WIDE)
                I[at + _MINE // WIDE] = ti.select(here, one, none)
                I[at + _PLACE // WIDE] = ti.select(here, _place(F, I, at, _floor(a), _floor(b), down), home)
            count = _listed(own, scratch, m)
            for k in range(count):
                prefetch(_address(memory, own[(own[m + _LIST + k] & INDEX_MASK) + _PLACE]))
            for k in range(count // 4):
                q = (m + 4 * k) & INDEX_MASK
                i, j = own[q + _LIST] & INDEX_MASK, own[q + _LIST + 1] & INDEX_MASK
                o, p = own[q + _LIST + 2] & INDEX_MASK, own[q + _LIST + 3] & INDEX_MASK
                light_i, light_j = _light(red, green, blue, t - m + i), _light(red, green, blue, t - m + j)
                light_o, light_p = _light(red, green, blue, t - m + o), _light(red, green, blue, t - m + p)
                _add(film, own[i + _PLACE], light_i)
                _add(film, own[j + _PLACE], light_j)
                _add(film, own[o + _PLACE], light_o)
                _add(film, own[p + _PLACE], light_p)
            for k in range(count // 4 * 4, count):
                i = own[m + _LIST + k] & INDEX_MASK
                _add(film, own[i + _PLACE], _light(red, green, blue, t - m + i))


@ti.kernel
def _points(
    columns: ti.i64, pitch: ti.i64, memory: ti.i64, scratch: ti.i64, x: FLOATS, y: FLOATS, red: F1, green: F1, blue: F1,
    n: ti.i32, film: FILM, stride: ti.i32, width: ti.i32, cuts: I1, bands: ti.i32, F: FLOATS, I: WORDS, own: I1, shares: F1,
):  # fmt: skip
    """Bilinear dots: pixel centres within a pixel of the point get (1 - |dx|) (1 - |dy|) of its light.

    columns, memory, scratch : where the columns lie, each `pitch` bytes after the one before, the film, and the bands' memory
    F, I, own, shares : the bands' memory, MEMORY numbers each
    """
    ti.loop_config(block_dim=1)
    for band in range(bands):
        zero, half, whole, round = _all(0.0, ti.f32), _all(0.5, ti.f32), _all(1.0, ti.f32), _all(ROUND, ti.f32)
        w, last = _all(width, ti.f32), _all(ti.max(width - 2, 0), ti.f32)
        low, high = _all(cuts[band], ti.f32), _all(cuts[band + 1], ti.f32)
        order, none, one, down = ti.Vector(_ORDER), _all(0, ti.i32), _all(1, ti.i32), _all(stride, ti.i32)
        home = _all(cuts[band] * stride, ti.i32)
        m = (band * MEMORY) & INDEX_MASK
        for tile in range((n + POINTS - 1) // POINTS):
            t = (tile * POINTS) & INDEX_MASK
            for part in range(PARTS):
                _ask(columns, pitch, t + POINTS + part * WIDE)
                u, v, at = x[t // WIDE + part] - half, y[t // WIDE + part] - half, m // WIDE + part
                row = _floor(v)
                a, b = _floor(u) - round, row - round
                here = _inside(a, b, zero - whole, w, low - whole, high, order, n - t - part * WIDE)
                I[at + _MINE // WIDE] = ti.select(here, one, none)
                a = within(a, zero, last)  # two pixels of the row, of which one may get nothing
                p, q = a - u, a + whole - u
                left, right = above(whole - above(p, zero - p), zero), above(whole - above(q, zero - q), zero)
                # a row of another band weighs nothing here: this one is drawn in its place
                first, second = b >= low, b + whole < high
                top, bottom = ti.select(first, b + whole - v, zero), ti.select(second, v - b, zero)
                F[at + _A // WIDE], F[at + _B // WIDE] = left * top, right * top
                F[at + _C // WIDE], F[at + _D // WIDE] = left * bottom, right * bottom
                place = _place(F, I, at, a + round, row, down)
                I[at + _PLACE // WIDE] = ti.select(here, place + ti.select(first, none, down), home)
                I[at + _LOWER // WIDE] = ti.select(here, place + ti.select(second, down, none), home)
            count = _listed(own, scratch, m)
            for k in range(count):
                j = own[m + _LIST + k] & INDEX_MASK
                o, p = _address(memory, own[j + _PLACE]), _address(memory, own[j + _LOWER])
                prefetch(o)
                prefetch(o + 16)  # which may lie in the next 64 bytes
                prefetch(p)
                prefetch(p + 16)
            for k in range(count):
                j = own[m + _LIST + k] & INDEX_MASK
                o, p = own[j + _PLACE] & INDEX_MASK, own[j + _LOWER] & INDEX_MASK
                light = _light(red, green, blue, t - m + j)
                _add(film, o, light * shares[j + _A])
                _add(film, o + 1, light * shares[j + _B])
                _add(film, p, light * shares[j + _C])
                _add(film, p + 1, light * shares[j + _D])


@ti.kernel
def _discs(memory: ti.i64, C: F2, n: ti.i32, film: FILM, stride: ti.i32, width: ti.i32, cuts: I1, bands: ti.i32):
    """Soft discs of a reach of LARGEST at most, each by the weights of its columns and its rows."""
    ti.loop_config(block_dim=1)
    for band in range(bands):
        low, high = cuts[band], cuts[band + 1]
        for tile in range((n + TILE - 1) // TILE):
            which, mine = ti.Vector([0] * (TILE + LANES)), ti.Vector([0] * TILE)
            for j in range(TILE):
                i = tile * TILE + j
                reach = C[REACH, i]
                here = (C[Y, i] + reach >= ti.cast(low, ti.f32)) & (C[Y, i] - reach < ti.cast(high, ti.f32))
                mine[j] = ti.select(here & (reach > 0.0) & (reach <= LARGEST) & (i < n), 1, 0)
            count = 0
            for j in range(TILE):
                which[count] = j
                count += mine[j]
            for group in range((count + LANES - 1) // LANES):
                left, top, taps = ti.Vector([0] * LANES), ti.Vector([0] * LANES), ti.Vector([0] * LANES)
                x, y, inverse = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                sum_x, sum_y = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                # k, kept from the compiler: it takes a pixel as one vector where it cannot split it into four running offsets
                steps = ti.Vector([0, 1, 2, 3, 4, 5, 6, 7, 8, 9])
                across, down = ti.Vector([0.0] * (TAPS * LANES)), ti.Vector([0.0] * (TAPS * LANES))
                for j in range(LANES):
                    i = tile * TILE + which[group * LANES + j]
                    reach = ti.select(group * LANES + j < count, C[REACH, i], 1.0)
                    left[j], top[j] = (
                        ti.cast(ti.floor(C[X, i] - reach), ti.i32),
                        ti.cast(ti.floor(C[Y, i] - reach), ti.i32),
                    )
                    x[j], y[j] = C[X, i] - 0.5 - ti.cast(left[j], ti.f32), C[Y, i] - 0.5 - ti.cast(top[j], ti.f32)
                    inverse[j] = 1.0 / reach
                    taps[j] = ti.cast(ti.ceil(2.0 * reach), ti.i32) + 1
                for j in range(LANES):
                    for t in range(taps[j]):
                        o = (top[j] + t) * stride + left[j]
                        prefetch(_address(memory, o))
                        prefetch(_address(memory, o + taps[j] - 1))
                for t in range(TAPS):
                    for j in range(LANES):
                        u = profile((ti.cast(t, ti.f32) - x[j]) * inverse[j])
                        v = profile((ti.cast(t, ti.f32) - y[j]) * inverse[j])
                        across[t * LANES + j], down[t * LANES + j] = u, v
                        sum_x[j], sum_y[j] = sum_x[j] + u, sum_y[j] + v
                for j in range(ti.min(LANES, count - group * LANES)):
                    i = tile * TILE + which[group * LANES + j]
                    light = PIXEL(C[RED, i], C[GREEN, i], C[BLUE, i], 0.0) * (1.0 / (sum_x[j] * sum_y[j]))
                    first, last = ti.max(-left[j], 0), ti.min(taps[j], width - left[j])
                    for t in range(ti.max(low - top[j], 0), ti.min(taps[j], high - top[j])):
                        row = light * down[t * LANES + j]
                        o = (top[j] + t) * stride + left[j]
                        for k in range(first, last):
                            at = o + steps[k]
                            film[at] = film[at] + row * across[k * LANES + j]


_pixels_kernel, _points_kernel, _discs_kernel = (
    kernel(_pixels, vectors=True),
    kernel(_points, vectors=True),
    kernel(_discs),
)


def _cuts(columns: np.ndarray, n: int, rows: int, bands: int) -> np.ndarray:
    """The first row of each band and the end, so that each has about as many particles."""
    y = columns[Y, :n][:: max(1, n // SAMPLE)]
    y = np.sort(y[(y >= 0.0) & (y < rows)])
    inner = y[len(y) * np.arange(1, bands) // bands] if len(y) else np.arange(1, bands) * rows // bands
    return np.concatenate([[0], inner, [rows]]).astype(np.int32)


@lru_cache(2)
def _memory(bands: int) -> np.ndarray:
    """(bands * MEMORY / WIDE, WIDE) words, whose places each hold their own where POINTS of each band are read."""
    words = aligned((bands * MEMORY // WIDE, WIDE), np.int32)
    for m in range(0, bands * MEMORY, MEMORY):
        words.reshape(-1)[m + _SELF : m + _SELF + POINTS] = np.arange(m, m + POINTS)
    return words


def _where(columns: np.ndarray, n: int, film) -> tuple:
    """The film, and how its rows are cut."""
    bands = max(1, min(threads(), film.height))
    return film.buffer.reshape(-1, 4), film.stride // 4, film.width, _cuts(columns, n, film.height, bands), bands


def _by_vectors(columns: np.ndarray, n: int, film) -> tuple:
    """What the kernels of points take: where all lies, the columns, the film, the memory."""
    x, y = columns[X].reshape(-1, WIDE), columns[Y].reshape(-1, WIDE)
    *where, bands = _where(columns, n, film)
    words = _memory(bands)
    return (
        columns.ctypes.data, columns.strides[0], film.buffer.ctypes.data, words.ctypes.data,
        x, y, columns[RED], columns[GREEN], columns[BLUE], n,
        *where, bands,
        words.view(np.float32), words, words.reshape(-1),
    )  # fmt: skip


def pixels(columns: np.ndarray, n: int, film) -> None:
    """Add the first n columns (11, a multiple of WIDE), from runtime.aligned, to a film, each to one pixel."""
    _pixels_kernel(*_by_vectors(columns, n, film))


def points(columns: np.ndarray, n: int, film) -> None:
    """Add the first n columns (11, a multiple of WIDE), from runtime.aligned, to a film, each between four pixels."""
    arguments = _by_vectors(columns, n, film)
    _points_kernel(*arguments, arguments[-1].view(np.float32))


def discs(columns: np.ndarray, n: int, film) -> None:
    """Add those of the first n columns whose reach is up to LARGEST to a film, as soft discs."""
    _discs_kernel(film.buffer.ctypes.data, columns, n, *_where(columns, n, film))
