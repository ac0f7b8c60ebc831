"""The developing kernel: thirty-two pixels at a time, each channel a vector.

Two of the widest vectors that processors have, so that each has something to do while it waits for the other.

Every number is a vector too, of a table: Taichi would lay out a scalar beside a vector as often as this has lanes, which
takes seconds to compile. Nor can it cast a vector: floats and whole numbers change into each other by way of a few vectors
of memory that two arrays share. A float of 2^23 + n or of 1.5 2^23 + n has the whole number n in its last bits.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from gen_art.renderer.resample import blend_weights
from gen_art.renderer.tone import GREY
from gen_art.runtime import aligned, kernel, ti

__all__ = ["NUMBERS", "SCRATCH", "TASKS", "WIDE", "Steps", "compiled", "table"]

WIDE = 32  # pixels of a turn
TASKS = 64  # runs of rows: each has memory of its own, which stays in the cache
SCRATCH = 64  # vectors of memory for a task: twice the places below

# run-time numbers, the two of dither whole ones
VIGNETTE, GRAIN, DITHER, MIDDLE, TOP, CODES, CONTRAST, DENSITY, VIBRANCY, WHITE = range(10)
LOW, HIGH, ABOVE, BELOW = 10, 11, 12, 16
BEFORE, AFTER = 20, 29
NUMBERS = 38

# sRGB's power branch, 1.055 x^(1/2.4) - 0.055 for x from 0.0031308 to 1, as a quartic over a cubic in sqrt(x): within 6e-7
_ABOVE = (13.2843061, 63.0982864, 28.2357181, 0.877431184, -0.050273701)
_BELOW = (20.2491496, 62.1299882, 22.0662748, 1.0)
_LEAST_ENCODED = 0.0031308
_ATANH = tuple(1 / (2 * k + 1) for k in range(4, -1, -1))
_TWICE_LOG2_E = 2.0 / math.log(2)
_POWER = tuple(math.log(2) ** k / math.factorial(k) for k in range(6, -1, -1))  # 2^x
_WHOLE = 8388608.0  # 2^23: what has its bits is whole
_ROUND = 12582912.0  # 1.5 2^23: adding it rounds, negative numbers too
_WHOLE_BITS, _ONE_BITS = 0x4B000000, 0x3F800000
# places in that memory: one for each change and channel
_LOG, _EXP, _NOISE, _CODE, _ROOT = 0, 9, 18, 22, 26
_LANES = tuple(float(k) for k in range(WIDE))
_AFTER = (*range(1, WIDE), WIDE - 1)
# which float of the twelve coarse pixels around each pixel's channel c of each pixel takes of its neighbour e
_NEAR = tuple(tuple(tuple(4 * (j // 4 + e) + c for j in range(WIDE)) for e in range(5)) for c in range(3))
_TAPS = tuple(tuple(float(w) for w in blend_weights()[:, e].tolist() * (WIDE // 4)) for e in range(5))

_FLOATS = (
    *_ABOVE, *_BELOW, *_ATANH, *_POWER,
    _LEAST_ENCODED, _TWICE_LOG2_E, _WHOLE + 127.0, _WHOLE + 510.0, _ROUND, -126.0, 0.0, 0.04, 0.0576,
    0.08, 0.15, 0.5, 0.52, 0.76, 1.0, 1.4142135, 1.5, 6.25, 12.92, 127.0, 1e-6, 1e-20, 1e-30, 1e12, GREY, 1.0 / GREY, 4.0 / 147.8,
)  # fmt: skip
_WORDS = (
    0x5F3759DF, 0x7FEB352D, 0x846CA68B, 0x7FFFFF, 0xFF00FF, 0xFFFF, _WHOLE_BITS, _ONE_BITS, 0, 1, 8, 10, 15, 16, 20, 23, 24, 255,
    1023,
)  # fmt: skip
_PLACE_OF_FLOAT = {number: NUMBERS + k for k, number in enumerate(dict.fromkeys(_FLOATS))}
_PLACE_OF_WORD = {number: NUMBERS + len(_PLACE_OF_FLOAT) + k for k, number in enumerate(_WORDS)}

F2 = ti.types.ndarray(ti.f32, 2)
FLOATS, WORDS = (ti.types.ndarray(ti.types.vector(WIDE, kind), 1) for kind in (ti.f32, ti.u32))
LIGHT = ti.types.ndarray(ti.types.vector(16, ti.f32), 1)
FOURS = ti.types.ndarray(ti.types.vector(4, ti.u32), 1)


class Steps(NamedTuple):
    """What a picture is developed with: only that is compiled, and loaded. Numbers are never in it."""

    strays: bool
    vignette: bool
    background: bool
    contrast: bool
    whole: str
    transparent: bool
    grain: bool
    deep: bool


def table(numbers: np.ndarray) -> np.ndarray:
    """(rows, WIDE): the run-time numbers, and after them those that never change, each a vector."""
    q = aligned((NUMBERS + len(_PLACE_OF_FLOAT) + len(_PLACE_OF_WORD), WIDE), np.float32)
    q[:NUMBERS] = numbers[:, None]
    for number, place in _PLACE_OF_FLOAT.items():
        q[place] = number
    for word, place in _PLACE_OF_WORD.items():
        q[place].view(np.uint32)[:] = word
    return q


def _f(number: float) -> int:
    return _PLACE_OF_FLOAT[number]


def _w(number: int) -> int:
    return _PLACE_OF_WORD[number]


for _function in (_f, _w):
    vars(_function)["_is_wrapped_kernel"] = True  # plain Python called while tracing: Taichi need not warn


@ti.func
def _within(x, low, high):
    """x held in a range; what is no number becomes `low`."""
    y = ti.select(x > low, x, low)
    return ti.select(y < high, y, high)


@ti.func
def _above(x, low):
    """x, or `low` where it is below: an instruction, where ti.max takes three."""
    return ti.select(x > low, x, low)


@ti.func
def _shares(x, y, z, Q: ti.template()):
    """1 / x, 1 / y and 1 / z by one division."""
    xy = x * y
    one = Q[_f(1.0)] / (xy * z)
    third = z * one
    return y * third, x * third, xy * one


@ti.func
def _horner(x, Q: ti.template(), coefficients: ti.template()):
    y = x * Q[_f(coefficients[0])] + Q[_f(coefficients[1])]
    for k in ti.static(range(2, len(coefficients))):
        y = y * x + Q[_f(coefficients[k])]
    return y


@ti.func
def _root(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o, rounds: ti.template()):
    """The square root of floats above 0, within 5e-6 of itself after two rounds, to rounding after three; two places of memory.

    Half the exponent, then Newton's method for 1 / sqrt(x): a third of the time that the processor's own root takes.
    """
    F[o] = x
    I[o + 1] = Z[_w(0x5F3759DF)] - (I[o] >> Z[_w(1)])
    r, half = F[o + 1], Q[_f(0.5)] * x
    for _ in ti.static(range(rounds)):
        r = r * (Q[_f(1.5)] - half * r * r)
    return x * r


@ti.func
def _encode(R, G, B, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o, deep: ti.template()):
    """sRGB-encoded light of three channels, 0..1, by one division."""
    x, y, z = _within(R, Q[_f(0.0)], Q[_f(1.0)]), _within(G, Q[_f(0.0)], Q[_f(1.0)]), _within(B, Q[_f(0.0)], Q[_f(1.0)])
    r = _root(_above(x, Q[_f(_LEAST_ENCODED)]), Q, Z, F, I, o + _ROOT, 2 + deep)
    g = _root(_above(y, Q[_f(_LEAST_ENCODED)]), Q, Z, F, I, o + _ROOT + 2, 2 + deep)
    b = _root(_above(z, Q[_f(_LEAST_ENCODED)]), Q, Z, F, I, o + _ROOT + 4, 2 + deep)
    fr, fg, fb = _shares(_horner(r, Q, _BELOW), _horner(g, Q, _BELOW), _horner(b, Q, _BELOW), Q)
    r, g, b = _horner(r, Q, _ABOVE) * fr, _horner(g, Q, _ABOVE) * fg, _horner(b, Q, _ABOVE) * fb
    low = Q[_f(_LEAST_ENCODED)]
    return (
        ti.select(x > low, r, x * Q[_f(12.92)]),
        ti.select(y > low, g, y * Q[_f(12.92)]),
        ti.select(z > low, b, z * Q[_f(12.92)]),
    )


@ti.func
def _hash(a, Z: ti.template()):
    h = (a ^ (a >> Z[_w(16)])) * Z[_w(0x7FEB352D)]
    h = (h ^ (h >> Z[_w(15)])) * Z[_w(0x846CA68B)]
    return h ^ (h >> Z[_w(16)])


@ti.func
def _log2(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """The logarithm of positive floats, by three places of the memory."""
    F[o] = x
    bits = I[o]
    I[o + 1] = (bits >> Z[_w(23)]) | Z[_w(_WHOLE_BITS)]
    I[o + 2] = (bits & Z[_w(0x7FFFFF)]) | Z[_w(_ONE_BITS)]
    e, m = F[o + 1] - Q[_f(_WHOLE + 127.0)], F[o + 2]
    big = m > Q[_f(1.4142135)]
    e, m = ti.select(big, e + Q[_f(1.0)], e), ti.select(big, m * Q[_f(0.5)], m)
    s = (m - Q[_f(1.0)]) / (m + Q[_f(1.0)])
    return e + s * _horner(s * s, Q, _ATANH) * Q[_f(_TWICE_LOG2_E)]


@ti.func
def _two_to(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """2^x for x from -126 to 127, by two places of the memory."""
    y = _within(x, Q[_f(-126.0)], Q[_f(127.0)])
    rounded = y + Q[_f(_ROUND)]
    F[o] = rounded
    I[o + 1] = (I[o] << Z[_w(23)]) + Z[_w(_ONE_BITS)]
    return _horner(y - (rounded - Q[_f(_ROUND)]), Q, _POWER) * F[o + 1]


@ti.func
def _contrasted(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o, c: ti.template()):
    light = _above(x * Q[_f(1.0 / GREY)], Q[_f(1e-30)])
    return Q[_f(GREY)] * _two_to(_log2(light, Q, Z, F, I, o + _LOG + 3 * c) * Q[CONTRAST], Q, Z, F, I, o + _EXP + 3 * c)


@ti.func
def _spread(low, middle, high, c: ti.template()):
    """Channel c of the light of twelve coarse pixels, over the pixels in their middle."""
    total, all = ti.Vector([0.0] * WIDE), (low, middle, high)
    for e in ti.static(range(5)):
        part = ti.Vector([all[k // 16][k % 16] for k in ti.static(_NEAR[c][e])])
        total += part * ti.Vector(_TAPS[e])
    return total


@ti.func
def _cubic(x, Q: ti.template(), k: ti.template()):
    return ((Q[k + 3] * x + Q[k + 2]) * x + Q[k + 1]) * x + Q[k]


@ti.func
def _mixed(r, g, b, Q: ti.template(), k: ti.template()):
    return Q[k] * r + Q[k + 1] * g + Q[k + 2] * b


@ti.func
def _over(v, sky, back, Q: ti.template()):
    """Light with the background behind it, dimmed by what shines over it."""
    return v + (Q[_f(1.0)] - _within(v, Q[_f(0.0)], Q[_f(1.0)])) * (sky * back)


@ti.func
def _coded(
    v,
    noise,
    Q: ti.template(),
    Z: ti.template(),
    F: ti.template(),
    I: ti.template(),
    o,
    c: ti.template(),
    deep: ti.template(),
):
    """The whole number of encoded light v among the last bits of the words that come back: of eight bits dithered by ten of
    `noise`, the light in 1024ths of a code and they being added up."""
    F[o + _CODE + c] = v * Q[TOP] + Q[_f(_ROUND)]
    code = I[o + _CODE + c]
    if ti.static(not deep):
        code = (code + ((noise >> Z[_w(10 * c)]) & Z[DITHER]) + Z[MIDDLE]) >> Z[_w(10)]
    return code


@ti.func
def _next(words):
    """Each lane the word of the lane after."""
    return ti.Vector([words[k] for k in ti.static(_AFTER)])


@cache
def compiled(steps: Steps):
    """The kernel of these steps."""

    @ti.kernel
    def develop_steps(
        film: LIGHT, stride: ti.i32, width: ti.i32, height: ti.i32, seen: ti.i32, coarse: LIGHT, across: ti.i32, blend: LIGHT,
        key: ti.i32, sky: F2, Q: FLOATS, Z: WORDS, F: FLOATS, I: WORDS, out: FOURS,
    ):  # fmt: skip
        """width : a multiple of WIDE, of which `seen` pixels are the picture     stride, across : vectors of four pixels a row

        blend : shares of five coarse rows for each of four rows, each a vector, times the stray light over the own
        Q, Z : one table     F, I : one memory, SCRATCH vectors a task     out : the picture's bytes
        """
        ti.loop_config(block_dim=1)
        for task in range(TASKS):
            for i in range(task * height // TASKS, (task + 1) * height // TASKS):
                lane = ti.Vector(_LANES)
                order = ti.Vector([ti.u32(k) for k in range(WIDE)])
                dy = (ti.cast(i, ti.f32) + 0.5) / ti.cast(height, ti.f32) * 2.0 - 1.0
                across_one = 2.0 / ti.cast(seen, ti.f32)
                take = _hash(order * Z[_w(0)] + ti.cast(key, ti.u32), Z)
                for t in range(width // WIDE):
                    at = t * WIDE
                    o = task * SCRATCH + (t & 1) * (
                        SCRATCH // 2
                    )  # by turns, lest Taichi takes them for constants of the loop
                    f = i * stride + 8 * t
                    eight = (
                        film[f],
                        film[f + 1],
                        film[f + 2],
                        film[f + 3],
                        film[f + 4],
                        film[f + 5],
                        film[f + 6],
                        film[f + 7],
                    )
                    R = ti.Vector([p[4 * j] for p in ti.static(eight) for j in range(4)])
                    G = ti.Vector([p[4 * j + 1] for p in ti.static(eight) for j in range(4)])
                    B = ti.Vector([p[4 * j + 2] for p in ti.static(eight) for j in range(4)])
                    A = ti.Vector([p[4 * j + 3] for p in ti.static(eight) for j in range(4)])
                    if ti.static(steps.strays):
                        low, middle, high = (
                            ti.Vector([0.0] * 16),
                            ti.Vector([0.0] * 16),
                            ti.Vector([0.0] * 16),
                        )  # the coarse rows, blended
                        for e in ti.static(range(5)):
                            row = ((i >> 2) + e) * across + 2 * t
                            weight = blend[5 * (i & 3) + e]
                            low += coarse[row] * weight
                            middle += coarse[row + 1] * weight
                            high += coarse[row + 2] * weight
                        R = R + _spread(low, middle, high, 0)
                        G = G + _spread(low, middle, high, 1)
                        B = B + _spread(low, middle, high, 2)
                    E = Q[_f(1.0)]
                    if ti.static(steps.vignette):
                        dx = (lane + (ti.cast(at, ti.f32) + 0.5)) * across_one - 1.0
                        edge = Q[_f(1.0)] + Q[VIGNETTE] * Q[_f(0.5)] * (dx * dx + dy * dy)
                        E = Q[_f(1.0)] / (edge * edge)
                        R, G, B = R * E, G * E, B * E
                    r, g, b = R, G, B
                    R, G, B = _mixed(r, g, b, Q, BEFORE), _mixed(r, g, b, Q, BEFORE + 3), _mixed(r, g, b, Q, BEFORE + 6)
                    if ti.static(steps.contrast):
                        R = _contrasted(R, Q, Z, F, I, o, 0)
                        G = _contrasted(G, Q, Z, F, I, o, 1)
                        B = _contrasted(B, Q, Z, F, I, o, 2)
                    if ti.static(steps.whole == "neutral"):  # Khronos PBR Neutral
                        least = ti.min(R, ti.min(G, B))
                        toe = ti.select(least < Q[_f(0.08)], least - Q[_f(6.25)] * least * least, Q[_f(0.04)])
                        peak = ti.max(R, ti.max(G, B)) - toe
                        peak = ti.select(peak > Q[_f(0.76)], peak, Q[_f(0.76)])
                        top = Q[_f(1.0)] - Q[_f(0.0576)] / (peak - Q[_f(0.52)])
                        keep = Q[_f(1.0)] / (Q[_f(0.15)] * (peak - top) + Q[_f(1.0)])
                        scale, white = top / peak * keep, top * (Q[_f(1.0)] - keep)
                        R, G, B = (R - toe) * scale + white, (G - toe) * scale + white, (B - toe) * scale + white
                    elif ti.static(steps.whole == "log"):  # log density; a logarithm to any base
                        R, G, B = (
                            _within(R, Q[_f(0.0)], Q[_f(1e12)]),
                            _within(G, Q[_f(0.0)], Q[_f(1e12)]),
                            _within(B, Q[_f(0.0)], Q[_f(1e12)]),
                        )
                        peak = ti.max(R, ti.max(G, ti.max(B, Q[_f(1e-20)])))
                        whole = Q[_f(1.0)] / _log2(Q[_f(1.0)] + Q[DENSITY] * Q[WHITE], Q, Z, F, I, o)
                        scale = _log2(Q[_f(1.0)] + Q[DENSITY] * peak, Q, Z, F, I, o + 3) * whole * Q[VIBRANCY] / peak
                        rest = whole * (Q[_f(1.0)] - Q[VIBRANCY])
                        R = R * scale + _log2(Q[_f(1.0)] + Q[DENSITY] * R, Q, Z, F, I, o + 6) * rest
                        G = G * scale + _log2(Q[_f(1.0)] + Q[DENSITY] * G, Q, Z, F, I, o + 9) * rest
                        B = B * scale + _log2(Q[_f(1.0)] + Q[DENSITY] * B, Q, Z, F, I, o + 12) * rest
                    else:  # N / D of each channel, by one division
                        r, g, b = _within(R, Q[LOW], Q[HIGH]), _within(G, Q[LOW], Q[HIGH]), _within(B, Q[LOW], Q[HIGH])
                        fr, fg, fb = _shares(_cubic(r, Q, BELOW), _cubic(g, Q, BELOW), _cubic(b, Q, BELOW), Q)
                        R, G, B = _cubic(r, Q, ABOVE) * fr, _cubic(g, Q, ABOVE) * fg, _cubic(b, Q, ABOVE) * fb
                    r, g, b = R, G, B
                    R, G, B = _mixed(r, g, b, Q, AFTER), _mixed(r, g, b, Q, AFTER + 3), _mixed(r, g, b, Q, AFTER + 6)
                    if ti.static(steps.background):  # which is seen as it is written
                        back = (Q[_f(1.0)] - _within(A, Q[_f(0.0)], Q[_f(1.0)])) * E
                        R, G, B = (
                            _over(R, sky[i, 0], back, Q),
                            _over(G, sky[i, 1], back, Q),
                            _over(B, sky[i, 2], back, Q),
                        )
                    if ti.static(steps.transparent):
                        A = _within(
                            ti.max(_within(A, Q[_f(0.0)], Q[_f(1.0)]), ti.max(R, ti.max(G, B))), Q[_f(1e-6)], Q[_f(1.0)]
                        )
                        R, G, B = R / A, G / A, B / A
                    R, G, B = _encode(R, G, B, Q, Z, F, I, o, steps.deep)
                    noise = _hash((order + ti.cast(i * 16384 + at, ti.u32)) ^ take, Z)
                    if ti.static(steps.grain):  # four bytes' mean: nearly normal, standard deviation 1
                        h = _hash(noise, Z)
                        two = (h & Z[_w(0xFF00FF)]) + ((h >> Z[_w(8)]) & Z[_w(0xFF00FF)])
                        I[o + _NOISE + 3] = ((two & Z[_w(0xFFFF)]) + (two >> Z[_w(16)])) | Z[_w(_WHOLE_BITS)]
                        n = (F[o + _NOISE + 3] - Q[_f(_WHOLE + 510.0)]) * (Q[GRAIN] * Q[_f(4.0 / 147.8)])
                        R = _within(R + n * R * (Q[_f(1.0)] - R), Q[_f(0.0)], Q[_f(1.0)])
                        G = _within(G + n * G * (Q[_f(1.0)] - G), Q[_f(0.0)], Q[_f(1.0)])
                        B = _within(B + n * B * (Q[_f(1.0)] - B), Q[_f(0.0)], Q[_f(1.0)])
                    x, y, z = (
                        _coded(R, noise, Q, Z, F, I, o, 0, steps.deep),
                        _coded(G, noise, Q, Z, F, I, o, 1, steps.deep),
                        _coded(B, noise, Q, Z, F, I, o, 2, steps.deep),
                    )
                    w = x
                    if ti.static(steps.transparent):
                        F[o + _CODE + 3] = A * Q[CODES] + Q[_f(_ROUND)]
                        w = I[o + _CODE + 3]
                    if ti.static(not steps.deep):
                        x, y, z = x & Z[_w(255)], (y & Z[_w(255)]) << Z[_w(8)], (z & Z[_w(255)]) << Z[_w(16)]
                        x = x | y | z
                        if ti.static(steps.transparent):
                            x = x | (w << Z[_w(24)])
                            for j in ti.static(range(WIDE // 4)):
                                out[(i * width + at) // 4 + j] = ti.Vector([x[4 * j + c] for c in range(4)])
                        else:  # the end of each word and the start of the next: three of four are used
                            x = (x >> ti.Vector([ti.u32(8 * (k % 4)) for k in range(WIDE)])) | (
                                _next(x) << ti.Vector([ti.u32(24 - 8 * (k % 4)) for k in range(WIDE)])
                            )
                            for j in ti.static(range(3 * WIDE // 16)):
                                out[(i * width + at) * 3 // 16 + j] = ti.Vector(
                                    [x[(4 * j + c) // 3 * 4 + (4 * j + c) % 3] for c in range(4)]
                                )
                    else:
                        x = (x & Z[_w(0xFFFF)]) | (y << Z[_w(16)])
                        z = z & Z[_w(0xFFFF)]
                        if ti.static(steps.transparent):
                            z = z | (w << Z[_w(16)])
                            for j in ti.static(range(WIDE // 2)):
                                out[(i * width + at) // 2 + j] = ti.Vector(
                                    [x[2 * j], z[2 * j], x[2 * j + 1], z[2 * j + 1]]
                                )
                        else:  # three words for two pixels
                            after = _next(x)
                            y = z | (after << Z[_w(16)])
                            z = (after >> Z[_w(16)]) | (_next(z) << Z[_w(16)])
                            for j in ti.static(range(3 * WIDE // 8)):
                                words = ti.Vector([ti.u32(0)] * 4)
                                for c in ti.static(range(4)):
                                    k = ti.static((4 * j + c) // 3 * 2)
                                    if ti.static((4 * j + c) % 3 == 0):
                                        words[c] = x[k]
                                    elif ti.static((4 * j + c) % 3 == 1):
                                        words[c] = y[k]
                                    else:
                                        words[c] = z[k]
                                out[(i * width + at) * 3 // 8 + j] = words

    return kernel(develop_steps, vectors=True)
