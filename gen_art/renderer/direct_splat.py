"""Small sprites that only add light, drawn straight into the framebuffer without lists.

The framebuffer's rows are cut into bands, one for each thread. Each thread goes through all particles and adds the light that
falls into its band. So a pixel receives its light in the order of the particles, however many bands there are and wherever
they are cut. Pixels are vectors of four floats: read, added to and written as one.

Points are processed in tiles of POINTS particles. For each tile the kernel finds, by whole vectors, which points fall into the
band; lists them; prefetches the pixels that they touch; and goes through the list.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import lru_cache

import numpy as np

from gen_art.backend.intrinsics import HAS_PACK, pack, prefetch
from gen_art.backend.runtime import INDEX_MASK, aligned, kernel, threads, ti
from gen_art.renderer.shading import LANES
from gen_art.renderer.sprite import BLUE, FOOTPRINT, GREEN, RED, X, Y, profile
from gen_art.renderer.vector_maths import ROUND, clamp, max_with

__all__ = ["MAX_FOOTPRINT", "MIN_PARTICLES", "discs", "pixels", "points"]

MAX_FOOTPRINT = 4.0  # pixels: the largest footprint of a disc that is drawn here
TAPS = 10  # pixels that such a disc may touch along one side; `lane` in _discs counts them
TILE = 32  # discs per iteration; those of the band are listed first, so that there is no branch for each disc
CUT_SAMPLES = 4096  # particles sampled to choose where to cut the rows
MIN_PARTICLES = 32768  # up to this many particles are drawn as other sprites are: kernels of their own would not pay

WIDE, PARTS = 32, 16  # lanes of a vector, vectors in a tile of points
POINTS = WIDE * PARTS
# Sections of a band's memory, one number for each point of a tile: its index; 1 if the point is the band's; the
# conversion buffers; the upper and lower pixel index; the four weights; and the list of the points of the band
_INDEX, _MARK, _COLUMN, _ROW, _UPPER, _LOWER, _WEIGHT_00, _WEIGHT_01, _WEIGHT_10, _WEIGHT_11, _LIST = (
    POINTS * k for k in range(11)
)
MEMORY = 11 * POINTS
_ORDER = tuple(range(WIDE))
_ROUND_BITS = 0x4B400000  # bits of the float ROUND; an integer that was added to ROUND stands in its last bits

PIXEL = ti.types.vector(4, ti.f32)
I1, F1, F2 = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)
PIXELS = ti.types.ndarray(PIXEL, 1)
FLOATS, WORDS = (ti.types.ndarray(ti.types.vector(WIDE, kind), 1) for kind in (ti.f32, ti.i32))


@ti.func
def _floats(x):
    """A vector with the same float in each lane."""
    return ti.Vector([ti.cast(x, ti.f32) for _ in ti.static(range(WIDE))])


@ti.func
def _ints(x):
    """A vector with the same integer in each lane."""
    return ti.Vector([ti.cast(x, ti.i32) for _ in ti.static(range(WIDE))])


@ti.func
def _floor_plus_round(x):
    """floor of each component, plus ROUND."""
    rounded = x + _floats(ROUND)
    return ti.select(rounded - _floats(ROUND) > x, rounded - _floats(1.0), rounded)


@ti.func
def _inside_band(x, y, x_low, x_high, y_low, y_high, lane_index, remaining):
    return (x >= x_low) & (x < x_high) & (y >= y_low) & (y < y_high) & (lane_index < _ints(remaining))


@ti.func
def _pixel_index(F: ti.template(), I: ti.template(), v, column, row, stride):
    """The pixel index of integer column and row, each given plus ROUND. Storing floats and loading words converts them."""
    F[v + _COLUMN // WIDE], F[v + _ROW // WIDE] = column, row
    bits = _ints(_ROUND_BITS)
    return (I[v + _ROW // WIDE] - bits) * stride + (I[v + _COLUMN // WIDE] - bits)


@ti.func
def _list_marked(words: ti.template(), memory_address, m):
    """List the indices of the tile's points that are the band's, without a branch; returns how many they are."""
    count = 0
    if ti.static(HAS_PACK):
        for part in range(PARTS):
            at = memory_address + ti.cast(m + part * WIDE, ti.i64) * 4
            pack(at + 4 * _MARK, at + 4 * _INDEX, memory_address + ti.cast(m + _LIST, ti.i64) * 4, count)
    else:
        for j in range(POINTS):
            words[m + _LIST + count] = m + j
            count += words[m + _MARK + j]
    return count


@ti.func
def _prefetch_points(channels, pitch, first):
    """Prefetch the channels of WIDE points. The processor's own prefetching stops at each page of memory."""
    at = channels + ti.cast(first, ti.i64) * 4
    for c in ti.static((X, Y, RED, GREEN, BLUE)):
        prefetch(at + c * pitch)
        prefetch(at + c * pitch + 64)


@ti.func
def _address(framebuffer_address, index):
    return framebuffer_address + ti.cast(index, ti.i64) * 16


@ti.func
def _light_of(red: ti.template(), green: ti.template(), blue: ti.template(), index):
    i = index & INDEX_MASK
    return ti.Vector([red[i], green[i], blue[i], 0.0])


@ti.func
def _add(framebuffer: ti.template(), index, light):
    o = index & INDEX_MASK
    framebuffer[o] = framebuffer[o] + light


@ti.kernel
def _pixels(
    channels: ti.i64, pitch: ti.i64, framebuffer_address: ti.i64, memory_address: ti.i64, x: FLOATS, y: FLOATS,
    red: F1, green: F1, blue: F1, n: ti.i32, framebuffer: PIXELS, stride: ti.i32, width: ti.i32, edges: I1, bands: ti.i32,
    F: FLOATS, I: WORDS, words: I1,
):  # fmt: skip
    """Add each point's light to the pixel that contains it.

    channels, framebuffer_address, memory_address : addresses of the channels (each `pitch` bytes after the one before), of the
    framebuffer and of the bands' memory
    edges : first row of each band, and the end
    F, I, words : the bands' memory, MEMORY numbers each, as vectors of floats, vectors of words, words
    """
    ti.loop_config(block_dim=1)
    for band in range(bands):
        zero, w = _floats(0.0), _floats(width)
        low, high = _floats(edges[band]), _floats(edges[band + 1])
        lane_index, none, one, stride_v = ti.Vector(_ORDER), _ints(0), _ints(1), _ints(stride)
        unused_pixel = _ints(edges[band] * stride)
        m = (band * MEMORY) & INDEX_MASK
        for tile in range((n + POINTS - 1) // POINTS):
            t = (tile * POINTS) & INDEX_MASK
            for part in range(PARTS):
                _prefetch_points(channels, pitch, t + POINTS + part * WIDE)
                a, b, at = x[t // WIDE + part], y[t // WIDE + part], m // WIDE + part
                inside = _inside_band(a, b, zero, w, low, high, lane_index, n - t - part * WIDE)
                I[at + _MARK // WIDE] = ti.select(inside, one, none)
                index = _pixel_index(F, I, at, _floor_plus_round(a), _floor_plus_round(b), stride_v)
                I[at + _UPPER // WIDE] = ti.select(inside, index, unused_pixel)
            count = _list_marked(words, memory_address, m)
            for k in range(count):
                prefetch(_address(framebuffer_address, words[(words[m + _LIST + k] & INDEX_MASK) + _UPPER]))
            for k in range(count // 4):
                q = (m + 4 * k) & INDEX_MASK
                i, j = words[q + _LIST] & INDEX_MASK, words[q + _LIST + 1] & INDEX_MASK
                o, p = words[q + _LIST + 2] & INDEX_MASK, words[q + _LIST + 3] & INDEX_MASK
                light_i, light_j = _light_of(red, green, blue, t - m + i), _light_of(red, green, blue, t - m + j)
                light_o, light_p = _light_of(red, green, blue, t - m + o), _light_of(red, green, blue, t - m + p)
                _add(framebuffer, words[i + _UPPER], light_i)
                _add(framebuffer, words[j + _UPPER], light_j)
                _add(framebuffer, words[o + _UPPER], light_o)
                _add(framebuffer, words[p + _UPPER], light_p)
            for k in range(count // 4 * 4, count):
                i = words[m + _LIST + k] & INDEX_MASK
                _add(framebuffer, words[i + _UPPER], _light_of(red, green, blue, t - m + i))


@ti.kernel
def _points(
    channels: ti.i64, pitch: ti.i64, framebuffer_address: ti.i64, memory_address: ti.i64, x: FLOATS, y: FLOATS,
    red: F1, green: F1, blue: F1, n: ti.i32, framebuffer: PIXELS, stride: ti.i32, width: ti.i32, edges: I1, bands: ti.i32,
    F: FLOATS, I: WORDS, words: I1, floats: F1,
):  # fmt: skip
    """Bilinear dots: pixel centres within a pixel of the point get (1 - |dx|) (1 - |dy|) of its light.

    channels, framebuffer_address, memory_address : addresses of the channels (each `pitch` bytes after the one before), of the
    framebuffer and of the bands' memory
    edges : first row of each band, and the end
    F, I, words, floats : the bands' memory, MEMORY numbers each, as vectors of floats, vectors of words, words and floats
    """
    ti.loop_config(block_dim=1)
    for band in range(bands):
        zero, half, whole, round = _floats(0.0), _floats(0.5), _floats(1.0), _floats(ROUND)
        w, last = _floats(width), _floats(ti.max(width - 2, 0))
        low, high = _floats(edges[band]), _floats(edges[band + 1])
        lane_index, none, one, stride_v = ti.Vector(_ORDER), _ints(0), _ints(1), _ints(stride)
        unused_pixel = _ints(edges[band] * stride)
        m = (band * MEMORY) & INDEX_MASK
        for tile in range((n + POINTS - 1) // POINTS):
            t = (tile * POINTS) & INDEX_MASK
            for part in range(PARTS):
                _prefetch_points(channels, pitch, t + POINTS + part * WIDE)
                u, v, at = x[t // WIDE + part] - half, y[t // WIDE + part] - half, m // WIDE + part
                row = _floor_plus_round(v)
                a, b = _floor_plus_round(u) - round, row - round
                inside = _inside_band(a, b, zero - whole, w, low - whole, high, lane_index, n - t - part * WIDE)
                I[at + _MARK // WIDE] = ti.select(inside, one, none)
                a = clamp(a, zero, last)  # two neighbouring pixels of the row, one of which may have weight 0
                p, q = a - u, a + whole - u
                left = max_with(whole - max_with(p, zero - p), zero)
                right = max_with(whole - max_with(q, zero - q), zero)
                # a row of another band has weight 0 here; the band's own row is used in its place
                first, second = b >= low, b + whole < high
                top, bottom = ti.select(first, b + whole - v, zero), ti.select(second, v - b, zero)
                F[at + _WEIGHT_00 // WIDE], F[at + _WEIGHT_01 // WIDE] = left * top, right * top
                F[at + _WEIGHT_10 // WIDE], F[at + _WEIGHT_11 // WIDE] = left * bottom, right * bottom
                index = _pixel_index(F, I, at, a + round, row, stride_v)
                I[at + _UPPER // WIDE] = ti.select(inside, index + ti.select(first, none, stride_v), unused_pixel)
                I[at + _LOWER // WIDE] = ti.select(inside, index + ti.select(second, stride_v, none), unused_pixel)
            count = _list_marked(words, memory_address, m)
            for k in range(count):
                j = words[m + _LIST + k] & INDEX_MASK
                o = _address(framebuffer_address, words[j + _UPPER])
                p = _address(framebuffer_address, words[j + _LOWER])
                prefetch(o)
                prefetch(o + 16)  # the next pixel may lie in the next 64 bytes
                prefetch(p)
                prefetch(p + 16)
            for k in range(count):
                j = words[m + _LIST + k] & INDEX_MASK
                o, p = words[j + _UPPER] & INDEX_MASK, words[j + _LOWER] & INDEX_MASK
                light = _light_of(red, green, blue, t - m + j)
                _add(framebuffer, o, light * floats[j + _WEIGHT_00])
                _add(framebuffer, o + 1, light * floats[j + _WEIGHT_01])
                _add(framebuffer, p, light * floats[j + _WEIGHT_10])
                _add(framebuffer, p + 1, light * floats[j + _WEIGHT_11])


@ti.kernel
def _discs(
    framebuffer_address: ti.i64, C: F2, n: ti.i32, framebuffer: PIXELS, stride: ti.i32, width: ti.i32, edges: I1,
    bands: ti.i32,
):  # fmt: skip
    """Soft discs with a footprint of MAX_FOOTPRINT at most, each by the weights of its columns and of its rows."""
    ti.loop_config(block_dim=1)
    for band in range(bands):
        low, high = edges[band], edges[band + 1]
        for tile in range((n + TILE - 1) // TILE):
            listed, marks = ti.Vector([0] * (TILE + LANES)), ti.Vector([0] * TILE)
            for j in range(TILE):
                i = tile * TILE + j
                footprint = C[FOOTPRINT, i]
                inside = (C[Y, i] + footprint >= ti.cast(low, ti.f32)) & (C[Y, i] - footprint < ti.cast(high, ti.f32))
                marks[j] = ti.select(inside & (footprint > 0.0) & (footprint <= MAX_FOOTPRINT) & (i < n), 1, 0)
            count = 0
            for j in range(TILE):
                listed[count] = j
                count += marks[j]
            for group in range((count + LANES - 1) // LANES):
                left, top, taps = ti.Vector([0] * LANES), ti.Vector([0] * LANES), ti.Vector([0] * LANES)
                x, y, inverse = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                sum_x, sum_y = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
                # the numbers 0..9 as data: with constants the compiler splits each pixel's vector into four running offsets
                lane = ti.Vector([0, 1, 2, 3, 4, 5, 6, 7, 8, 9])
                horizontal, vertical = ti.Vector([0.0] * (TAPS * LANES)), ti.Vector([0.0] * (TAPS * LANES))
                for j in range(LANES):
                    i = tile * TILE + listed[group * LANES + j]
                    footprint = ti.select(group * LANES + j < count, C[FOOTPRINT, i], 1.0)
                    left[j] = ti.cast(ti.floor(C[X, i] - footprint), ti.i32)
                    top[j] = ti.cast(ti.floor(C[Y, i] - footprint), ti.i32)
                    x[j], y[j] = C[X, i] - 0.5 - ti.cast(left[j], ti.f32), C[Y, i] - 0.5 - ti.cast(top[j], ti.f32)
                    inverse[j] = 1.0 / footprint
                    taps[j] = ti.cast(ti.ceil(2.0 * footprint), ti.i32) + 1
                for j in range(LANES):
                    for t in range(taps[j]):
                        o = (top[j] + t) * stride + left[j]
                        prefetch(_address(framebuffer_address, o))
                        prefetch(_address(framebuffer_address, o + taps[j] - 1))
                for t in range(TAPS):
                    for j in range(LANES):
                        u = profile((ti.cast(t, ti.f32) - x[j]) * inverse[j])
                        v = profile((ti.cast(t, ti.f32) - y[j]) * inverse[j])
                        horizontal[t * LANES + j], vertical[t * LANES + j] = u, v
                        sum_x[j], sum_y[j] = sum_x[j] + u, sum_y[j] + v
                for j in range(ti.min(LANES, count - group * LANES)):
                    i = tile * TILE + listed[group * LANES + j]
                    light = PIXEL(C[RED, i], C[GREEN, i], C[BLUE, i], 0.0) * (1.0 / (sum_x[j] * sum_y[j]))
                    first, last = ti.max(-left[j], 0), ti.min(taps[j], width - left[j])
                    for t in range(ti.max(low - top[j], 0), ti.min(taps[j], high - top[j])):
                        row = light * vertical[t * LANES + j]
                        o = (top[j] + t) * stride + left[j]
                        for k in range(first, last):
                            at = o + lane[k]
                            framebuffer[at] = framebuffer[at] + row * horizontal[k * LANES + j]


_pixels_kernel, _points_kernel = kernel(_pixels, vectors=True), kernel(_points, vectors=True)
_discs_kernel = kernel(_discs)


def _band_edges(channels: np.ndarray, n: int, rows: int, bands: int) -> np.ndarray:
    """The first row of each band and the end, chosen so that each band has about as many particles."""
    y = channels[Y, :n][:: max(1, n // CUT_SAMPLES)]
    y = np.sort(y[(y >= 0.0) & (y < rows)])
    inner = y[len(y) * np.arange(1, bands) // bands] if len(y) else np.arange(1, bands) * rows // bands
    return np.concatenate([[0], inner, [rows]]).astype(np.int32)


@lru_cache(2)
def _band_memory(bands: int) -> np.ndarray:
    """(bands * MEMORY / WIDE, WIDE) words; the _INDEX section of each band holds the indices of its own words."""
    words = aligned((bands * MEMORY // WIDE, WIDE), np.int32)
    for m in range(0, bands * MEMORY, MEMORY):
        words.reshape(-1)[m + _INDEX : m + _INDEX + POINTS] = np.arange(m, m + POINTS)
    return words


def _target_arguments(channels: np.ndarray, n: int, framebuffer) -> tuple:
    """The kernels' arguments for the framebuffer and its bands."""
    bands = max(1, min(threads(), framebuffer.height))
    edges = _band_edges(channels, n, framebuffer.height, bands)
    return framebuffer.buffer.reshape(-1, 4), framebuffer.stride // 4, framebuffer.width, edges, bands


def _point_arguments(channels: np.ndarray, n: int, framebuffer) -> tuple:
    """The arguments that both kernels of points take."""
    x, y = channels[X].reshape(-1, WIDE), channels[Y].reshape(-1, WIDE)
    *target, bands = _target_arguments(channels, n, framebuffer)
    words = _band_memory(bands)
    return (
        channels.ctypes.data, channels.strides[0], framebuffer.buffer.ctypes.data, words.ctypes.data,
        x, y, channels[RED], channels[GREEN], channels[BLUE], n,
        *target, bands,
        words.view(np.float32), words, words.reshape(-1),
    )  # fmt: skip


def pixels(channels: np.ndarray, n: int, framebuffer) -> None:
    """Add the first n particles to a framebuffer, each to one pixel.

    channels : (11, a multiple of WIDE), from runtime.aligned
    """
    _pixels_kernel(*_point_arguments(channels, n, framebuffer))


def points(channels: np.ndarray, n: int, framebuffer) -> None:
    """Add the first n particles to a framebuffer, each to four pixels.

    channels : (11, a multiple of WIDE), from runtime.aligned
    """
    arguments = _point_arguments(channels, n, framebuffer)
    _points_kernel(*arguments, arguments[-1].view(np.float32))


def discs(channels: np.ndarray, n: int, framebuffer) -> None:
    """Add those of the first n particles with a footprint of up to MAX_FOOTPRINT to a framebuffer, as soft discs."""
    _discs_kernel(framebuffer.buffer.ctypes.data, channels, n, *_target_arguments(channels, n, framebuffer))
