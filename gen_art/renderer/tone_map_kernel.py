"""The developing kernel: thirty-two pixels at a time, each channel a vector (vectors.py)."""

from functools import cache
from typing import NamedTuple

from gen_art.backend.runtime import INDEX_MASK, kernel, ti
from gen_art.renderer.resample import blend_weights
from gen_art.renderer.tone_curves import GREY
from gen_art.renderer.vector_maths import (
    CONSTANTS,
    ROUND,
    WHOLE,
    WHOLE_BITS,
    WIDE,
    above,
    encode,
    f,
    hashed,
    log2,
    scrambled,
    two_to,
    w,
    within,
)

__all__ = ["NUMBERS", "SCRATCH", "TASKS", "WIDE", "ToneMapSteps", "compiled"]

TASKS = 64  # runs of rows: each has memory of its own, which stays in the cache
SCRATCH = 64  # vectors of memory for a task: twice the places below
_LOG, _EXP, _NOISE, _CODE, _ROOT = 0, 9, 18, 22, 26  # places in that memory: one for each change and channel

# run-time numbers in the table, after the constants; DITHER is a word
VIGNETTE, GRAIN, DITHER, ROUNDING, TOP, CODES, CONTRAST, DENSITY, VIBRANCY, WHITE = range(CONSTANTS, CONSTANTS + 10)
LOW, HIGH, ABOVE, BELOW, BEFORE, AFTER = (CONSTANTS + k for k in (10, 11, 12, 16, 20, 29))
NUMBERS = 38

_LANES = tuple(float(k) for k in range(WIDE))
_AFTER = (*range(1, WIDE), WIDE - 1)
# which float of the twelve coarse pixels around each pixel's channel c of each pixel takes of its neighbour e
_NEAR = tuple(tuple(tuple(4 * (j // 4 + j % 4 // 2 + e) + c for j in range(WIDE)) for e in range(4)) for c in range(3))
_TAPS = tuple(tuple(float(w) for w in blend_weights()[:, e].tolist() * (WIDE // 4)) for e in range(4))

F2 = ti.types.ndarray(ti.f32, 2)
FLOATS, WORDS = (ti.types.ndarray(ti.types.vector(WIDE, kind), 1) for kind in (ti.f32, ti.u32))
LIGHT = ti.types.ndarray(ti.types.vector(16, ti.f32), 1)
FOURS = ti.types.ndarray(ti.types.vector(4, ti.u32), 1)


class ToneMapSteps(NamedTuple):
    """What a picture is developed with: only that is compiled, and loaded. Numbers are never in it."""

    strays: bool
    vignette: bool
    background: bool
    contrast: bool
    tone: str  # neutral, log, or nothing: by cubics
    transparent: bool
    grain: bool
    deep: bool


@ti.func
def _contrasted(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o, c: ti.template()):
    light = above(x * Q[f(1.0 / GREY)], Q[f(1e-30)])
    return Q[f(GREY)] * two_to(log2(light, Q, Z, F, I, o + _LOG + 3 * c) * Q[CONTRAST], Q, Z, F, I, o + _EXP + 3 * c)


@ti.func
def _spread(low, middle, high, c: ti.template()):
    """Channel c of the light of twelve coarse pixels, over the pixels in their middle."""
    total, all = ti.Vector([0.0] * WIDE), (low, middle, high)
    for e in ti.static(range(4)):
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
def _over(v, whole, sky, back, Q: ti.template()):
    """Light with the background behind it, dimmed by what shines over it."""
    return v + (whole - within(v, Q[f(0.0)], whole)) * (sky * back)


@ti.func
def _coded(
    v, noise, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o, c: ti.template(), deep: ti.template()
):  # fmt: skip
    """Encoded light v as words. `deep`: its whole number in the last 16 bits. Else byte c, the others 0, of the sum of the
    light in 1024ths of a code and of ten bits of `noise`."""
    F[o + _CODE + c] = v * Q[TOP] + Q[ROUNDING]
    code = I[o + _CODE + c]
    if ti.static(not deep):
        code += (noise >> Z[w(10 * c + 2)]) & Z[DITHER]
        if ti.static(c == 0):
            code = (code >> Z[w(10)]) & Z[w(0xFF)]
        elif ti.static(c == 1):
            code = (code >> Z[w(2)]) & Z[w(0xFF00)]
        else:
            code = (code << Z[w(6)]) & Z[w(0xFF0000)]
    return code


@ti.func
def _next(words):
    """Each lane the word of the lane after."""
    return ti.Vector([words[k] for k in ti.static(_AFTER)])


@cache
def compiled(steps: ToneMapSteps):
    """The kernel of these steps."""

    @ti.kernel
    def develop_steps(
        film: LIGHT, stride: ti.i32, width: ti.i32, height: ti.i32, seen: ti.i32, coarse: LIGHT, across: ti.i32, blend: LIGHT,
        key: ti.i32, sky: F2, Q: FLOATS, Z: WORDS, F: FLOATS, I: WORDS, out: FOURS,
    ):  # fmt: skip
        """width : a multiple of WIDE, of which `seen` pixels are the picture     stride, across : vectors of four pixels a row

        blend : shares of four coarse rows for each of four rows, each a vector, times the stray light over the own
        Q, Z : one table     F, I : one memory, SCRATCH vectors a task     out : the picture's bytes
        """
        ti.loop_config(block_dim=1)
        for task in range(TASKS):
            for i in range(task * height // TASKS, (task + 1) * height // TASKS):
                lane = ti.Vector(_LANES)
                order = ti.Vector([ti.u32(k) for k in range(WIDE)])
                dy = (ti.cast(i, ti.f32) + 0.5) / ti.cast(height, ti.f32) * 2.0 - 1.0
                across_one = 2.0 / ti.cast(seen, ti.f32)
                take = hashed(order * Z[w(0)] + ti.cast(key, ti.u32), Z)
                for t in range(width // WIDE):
                    at = t * WIDE
                    # by turns, lest Taichi takes them for constants of the loop
                    o = (task * SCRATCH + (t & 1) * (SCRATCH // 2)) & INDEX_MASK
                    begin = (i * stride + 8 * t) & INDEX_MASK
                    eight = (
                        film[begin], film[begin + 1], film[begin + 2], film[begin + 3],
                        film[begin + 4], film[begin + 5], film[begin + 6], film[begin + 7],
                    )  # fmt: skip
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
                        for e in ti.static(range(4)):
                            row = (((i + 2 >> 2) + e) * across + 2 * t) & INDEX_MASK
                            weight = blend[4 * (i & 3) + e]
                            low += coarse[row] * weight
                            middle += coarse[row + 1] * weight
                            high += coarse[row + 2] * weight
                        R = R + _spread(low, middle, high, 0)
                        G = G + _spread(low, middle, high, 1)
                        B = B + _spread(low, middle, high, 2)
                    E, whole = Q[f(1.0)], Q[f(1.0)]  # the light is R / whole, G / whole, B / whole
                    if ti.static(steps.vignette):
                        dx = (lane + (ti.cast(at, ti.f32) + 0.5)) * across_one - 1.0
                        edge = Q[f(1.0)] + Q[VIGNETTE] * Q[f(0.5)] * (dx * dx + dy * dy)
                        E = Q[f(1.0)] / (edge * edge)
                        R, G, B = R * E, G * E, B * E
                    r, g, b = R, G, B
                    R, G, B = _mixed(r, g, b, Q, BEFORE), _mixed(r, g, b, Q, BEFORE + 3), _mixed(r, g, b, Q, BEFORE + 6)
                    if ti.static(steps.contrast):
                        R = _contrasted(R, Q, Z, F, I, o, 0)
                        G = _contrasted(G, Q, Z, F, I, o, 1)
                        B = _contrasted(B, Q, Z, F, I, o, 2)
                    if ti.static(steps.tone == "neutral"):  # Khronos PBR Neutral
                        least = ti.min(R, ti.min(G, B))
                        toe = ti.select(least < Q[f(0.08)], least - Q[f(6.25)] * least * least, Q[f(0.04)])
                        peak = ti.max(R, ti.max(G, B)) - toe
                        peak = ti.select(peak > Q[f(0.76)], peak, Q[f(0.76)])
                        top = Q[f(1.0)] - Q[f(0.0576)] / (peak - Q[f(0.52)])
                        keep = Q[f(1.0)] / (Q[f(0.15)] * (peak - top) + Q[f(1.0)])
                        scale, white = top / peak * keep, top * (Q[f(1.0)] - keep)
                        R, G, B = (R - toe) * scale + white, (G - toe) * scale + white, (B - toe) * scale + white
                    elif ti.static(steps.tone == "log"):  # log density; a logarithm to any base
                        R, G, B = (
                            within(R, Q[f(0.0)], Q[f(1e12)]),
                            within(G, Q[f(0.0)], Q[f(1e12)]),
                            within(B, Q[f(0.0)], Q[f(1e12)]),
                        )
                        peak = ti.max(R, ti.max(G, ti.max(B, Q[f(1e-20)])))
                        full = Q[f(1.0)] / log2(Q[f(1.0)] + Q[DENSITY] * Q[WHITE], Q, Z, F, I, o)
                        scale = log2(Q[f(1.0)] + Q[DENSITY] * peak, Q, Z, F, I, o + 3) * full * Q[VIBRANCY] / peak
                        rest = full * (Q[f(1.0)] - Q[VIBRANCY])
                        R = R * scale + log2(Q[f(1.0)] + Q[DENSITY] * R, Q, Z, F, I, o + 6) * rest
                        G = G * scale + log2(Q[f(1.0)] + Q[DENSITY] * G, Q, Z, F, I, o + 9) * rest
                        B = B * scale + log2(Q[f(1.0)] + Q[DENSITY] * B, Q, Z, F, I, o + 12) * rest
                    else:  # N / D of each channel, brought to one denominator, which is divided by in the end
                        r, g, b = within(R, Q[LOW], Q[HIGH]), within(G, Q[LOW], Q[HIGH]), within(B, Q[LOW], Q[HIGH])
                        x, y, z = _cubic(r, Q, BELOW), _cubic(g, Q, BELOW), _cubic(b, Q, BELOW)
                        yz = y * z
                        R, G, B = _cubic(r, Q, ABOVE) * yz, _cubic(g, Q, ABOVE) * (x * z), _cubic(b, Q, ABOVE) * (x * y)
                        whole = x * yz
                    r, g, b = R, G, B
                    R, G, B = _mixed(r, g, b, Q, AFTER), _mixed(r, g, b, Q, AFTER + 3), _mixed(r, g, b, Q, AFTER + 6)
                    if ti.static(steps.background):  # which is seen as it is written
                        back = (Q[f(1.0)] - within(A, Q[f(0.0)], Q[f(1.0)])) * E
                        R, G, B = (
                            _over(R, whole, sky[i, 0], back, Q),
                            _over(G, whole, sky[i, 1], back, Q),
                            _over(B, whole, sky[i, 2], back, Q),
                        )
                    if ti.static(steps.transparent):
                        A = within(A, Q[f(0.0)], Q[f(1.0)]) * whole
                        A = within(ti.max(A, ti.max(R, ti.max(G, B))), Q[f(1e-6)] * whole, whole)
                        A, whole = A / whole, A
                    R, G, B = encode(R, G, B, whole, Q, Z, F, I, o + _ROOT)
                    noise = scrambled((order + ti.cast(i * 16384 + at, ti.u32)) ^ take, Z)
                    if ti.static(steps.grain):  # four bytes' mean: nearly normal, standard deviation 1
                        h = hashed(noise, Z)
                        two = (h & Z[w(0xFF00FF)]) + ((h >> Z[w(8)]) & Z[w(0xFF00FF)])
                        I[o + _NOISE + 3] = ((two & Z[w(0xFFFF)]) + (two >> Z[w(16)])) | Z[w(WHOLE_BITS)]
                        n = (F[o + _NOISE + 3] - Q[f(WHOLE + 510.0)]) * (Q[GRAIN] * Q[f(4.0 / 147.8)])
                        R = within(R + n * R * (Q[f(1.0)] - R), Q[f(0.0)], Q[f(1.0)])
                        G = within(G + n * G * (Q[f(1.0)] - G), Q[f(0.0)], Q[f(1.0)])
                        B = within(B + n * B * (Q[f(1.0)] - B), Q[f(0.0)], Q[f(1.0)])
                    x, y, z = (
                        _coded(R, noise, Q, Z, F, I, o, 0, steps.deep),
                        _coded(G, noise, Q, Z, F, I, o, 1, steps.deep),
                        _coded(B, noise, Q, Z, F, I, o, 2, steps.deep),
                    )
                    a = x
                    if ti.static(steps.transparent):
                        F[o + _CODE + 3] = A * Q[CODES] + Q[f(ROUND)]
                        a = I[o + _CODE + 3]
                    if ti.static(not steps.deep):
                        x = x | y | z
                        if ti.static(steps.transparent):
                            x = x | (a << Z[w(24)])
                            for j in ti.static(range(WIDE // 4)):
                                out[(((i * width + at) // 4) & INDEX_MASK) + j] = ti.Vector(
                                    [x[4 * j + c] for c in range(4)]
                                )
                        else:  # the end of each word and the start of the next: three of four are used
                            x = (x >> ti.Vector([ti.u32(8 * (k % 4)) for k in range(WIDE)])) | (
                                _next(x) << ti.Vector([ti.u32(24 - 8 * (k % 4)) for k in range(WIDE)])
                            )
                            for j in ti.static(range(3 * WIDE // 16)):
                                out[(((i * width + at) * 3 // 16) & INDEX_MASK) + j] = ti.Vector(
                                    [x[(4 * j + c) // 3 * 4 + (4 * j + c) % 3] for c in range(4)]
                                )
                    else:
                        x = (x & Z[w(0xFFFF)]) | (y << Z[w(16)])
                        z = z & Z[w(0xFFFF)]
                        if ti.static(steps.transparent):
                            z = z | (a << Z[w(16)])
                            for j in ti.static(range(WIDE // 2)):
                                out[(((i * width + at) // 2) & INDEX_MASK) + j] = ti.Vector(
                                    [x[2 * j], z[2 * j], x[2 * j + 1], z[2 * j + 1]]
                                )
                        else:  # three words for two pixels
                            after = _next(x)
                            y = z | (after << Z[w(16)])
                            z = (after >> Z[w(16)]) | (_next(z) << Z[w(16)])
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
                                out[(((i * width + at) * 3 // 8) & INDEX_MASK) + j] = words

    return kernel(develop_steps, vectors=True)
