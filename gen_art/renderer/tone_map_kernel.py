"""The tone map kernel: from linear light to the picture's bytes, thirty-two pixels at a time, each channel a vector.

See vector_maths.py for the arrays Q, Z, F and I.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache
from typing import NamedTuple

from gen_art.backend.runtime import INDEX_MASK, kernel, ti
from gen_art.renderer.resample import blend_weights
from gen_art.renderer.tone_curves import GREY
from gen_art.renderer.vector_maths import (
    CONSTANTS,
    HALF,
    ONE,
    ROUND,
    TWO_23,
    TWO_23_BITS,
    WIDE,
    ZERO,
    clamp,
    exp2,
    float_index,
    hash32,
    log2,
    max_with,
    scramble,
    srgb_encode,
    word_index,
)

__all__ = ["NUMBERS", "SCRATCH", "TASKS", "WIDE", "ToneMapSteps", "tone_map_kernel"]

TASKS = 64  # runs of rows; each has memory of its own, which stays in the cache
SCRATCH = 64  # vectors of memory for a task: two sets of the places below
_LOG, _EXP, _NOISE, _CODE, _ROOT = 0, 9, 18, 22, 26  # places in that memory, one for each conversion and channel

# rows of the run-time numbers in the table, after the constants; DITHER is a word
VIGNETTE, GRAIN, DITHER, ROUNDING, TOP, CODES, CONTRAST, DENSITY, VIBRANCY, WHITE = range(CONSTANTS, CONSTANTS + 10)
LOW, HIGH, NUMERATOR, DENOMINATOR, BEFORE, AFTER = (CONSTANTS + k for k in (10, 11, 12, 16, 20, 29))
NUMBERS = 38

_LANES = tuple(float(k) for k in range(WIDE))
_NEXT_LANE = (*range(1, WIDE), WIDE - 1)
# [c][e]: which float of the twelve coarse pixels around it a pixel's channel c takes from its neighbour e
_COARSE_INDEX = tuple(
    tuple(tuple(4 * (j // 4 + j % 4 // 2 + e) + c for j in range(WIDE)) for e in range(4)) for c in range(3)
)
_BLOOM_WEIGHTS = tuple(tuple(float(w) for w in blend_weights()[:, e].tolist() * (WIDE // 4)) for e in range(4))

F2 = ti.types.ndarray(ti.f32, 2)
FLOATS, WORDS = (ti.types.ndarray(ti.types.vector(WIDE, kind), 1) for kind in (ti.f32, ti.u32))
PIXELS = ti.types.ndarray(ti.types.vector(16, ti.f32), 1)
OUTPUT = ti.types.ndarray(ti.types.vector(4, ti.u32), 1)


class ToneMapSteps(NamedTuple):
    """The steps that a picture is developed with: only their code is compiled and loaded. Numbers are never part of it."""

    bloom: bool
    vignette: bool
    background: bool
    contrast: bool
    tone: str  # neutral, log, or empty: by cubics
    transparent: bool
    grain: bool
    sixteen_bit: bool


@ti.func
def _apply_contrast(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o, c: ti.template()):
    light = max_with(x * Q[float_index(1.0 / GREY)], Q[float_index(1e-30)])
    return Q[float_index(GREY)] * exp2(
        log2(light, Q, Z, F, I, o + _LOG + 3 * c) * Q[CONTRAST], Q, Z, F, I, o + _EXP + 3 * c
    )


@ti.func
def _upsample(low, middle, high, c: ti.template()):
    """Channel c of the bloom of twelve coarse pixels, at the pixels in their middle."""
    total, all = ti.Vector([0.0] * WIDE), (low, middle, high)
    for e in ti.static(range(4)):
        part = ti.Vector([all[k // 16][k % 16] for k in ti.static(_COARSE_INDEX[c][e])])
        total += part * ti.Vector(_BLOOM_WEIGHTS[e])
    return total


@ti.func
def _cubic(x, Q: ti.template(), k: ti.template()):
    """The cubic whose coefficients, lowest power first, are the rows of Q from k on."""
    return ((Q[k + 3] * x + Q[k + 2]) * x + Q[k + 1]) * x + Q[k]


@ti.func
def _matrix_row(r, g, b, Q: ti.template(), k: ti.template()):
    """Row of a 3x3 matrix whose three numbers are the rows of Q from k on, times the colour."""
    return Q[k] * r + Q[k + 1] * g + Q[k + 2] * b


@ti.func
def _composite_over(light, denominator, background, transparency, Q: ti.template()):
    """Light composited over the background, which is dimmed by how bright the light is and by `transparency`."""
    return light + (denominator - clamp(light, Q[ZERO], denominator)) * (background * transparency)


@ti.func
def _encode(
    light, noise, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o, c: ti.template(),
    sixteen_bit: ti.template(),
):  # fmt: skip
    """sRGB-encoded light as words.

    sixteen_bit : the code stands in the last 16 bits. Otherwise it stands in byte c and the other bytes are 0; it is the sum
    of the light in 1024ths of a code and of ten bits of `noise`
    """
    F[o + _CODE + c] = light * Q[TOP] + Q[ROUNDING]
    code = I[o + _CODE + c]
    if ti.static(not sixteen_bit):
        code += (noise >> Z[word_index(10 * c + 2)]) & Z[DITHER]
        if ti.static(c == 0):
            code = (code >> Z[word_index(10)]) & Z[word_index(0xFF)]
        elif ti.static(c == 1):
            code = (code >> Z[word_index(2)]) & Z[word_index(0xFF00)]
        else:
            code = (code << Z[word_index(6)]) & Z[word_index(0xFF0000)]
    return code


@ti.func
def _next_lane(words):
    """In each lane, the word of the following lane."""
    return ti.Vector([words[k] for k in ti.static(_NEXT_LANE)])


@cache
def tone_map_kernel(steps: ToneMapSteps):
    """The kernel of these steps."""

    @ti.kernel
    def develop_steps(
        linear: PIXELS, stride: ti.i32, width: ti.i32, height: ti.i32, visible_width: ti.i32, coarse: PIXELS, across: ti.i32,
        bloom_weights: PIXELS, frame: ti.i32, background: F2, Q: FLOATS, Z: WORDS, F: FLOATS, I: WORDS, out: OUTPUT,
    ):  # fmt: skip
        """Develop a picture.

        width : pixels, a multiple of WIDE, of which the first `visible_width` are the picture
        stride, across : vectors of four pixels in a row of `linear`, and of `coarse`
        coarse : the first picture of the bloom pyramid
        bloom_weights : weights of four coarse rows for each of four rows, each a vector, times bloom over remaining light
        Q, Z : one table
        F, I : one memory, SCRATCH vectors a task
        out : the picture's bytes
        """
        ti.loop_config(block_dim=1)
        for task in range(TASKS):
            for i in range(task * height // TASKS, (task + 1) * height // TASKS):
                lane = ti.Vector(_LANES)
                lane_index = ti.Vector([ti.u32(k) for k in range(WIDE)])
                dy = (ti.cast(i, ti.f32) + 0.5) / ti.cast(height, ti.f32) * 2.0 - 1.0
                x_scale = 2.0 / ti.cast(visible_width, ti.f32)
                frame_hash = hash32(lane_index * Z[word_index(0)] + ti.cast(frame, ti.u32), Z)
                for t in range(width // WIDE):
                    at = t * WIDE
                    # two places in turn; with one, Taichi would take what is loaded from it for a constant of the loop
                    o = (task * SCRATCH + (t & 1) * (SCRATCH // 2)) & INDEX_MASK
                    first = (i * stride + 8 * t) & INDEX_MASK
                    block = (
                        linear[first], linear[first + 1], linear[first + 2], linear[first + 3],
                        linear[first + 4], linear[first + 5], linear[first + 6], linear[first + 7],
                    )  # fmt: skip
                    R = ti.Vector([p[4 * j] for p in ti.static(block) for j in range(4)])
                    G = ti.Vector([p[4 * j + 1] for p in ti.static(block) for j in range(4)])
                    B = ti.Vector([p[4 * j + 2] for p in ti.static(block) for j in range(4)])
                    A = ti.Vector([p[4 * j + 3] for p in ti.static(block) for j in range(4)])
                    if ti.static(steps.bloom):
                        # the weighted sum of four coarse rows
                        low, middle, high = ti.Vector([0.0] * 16), ti.Vector([0.0] * 16), ti.Vector([0.0] * 16)
                        for e in ti.static(range(4)):
                            row = (((i + 2 >> 2) + e) * across + 2 * t) & INDEX_MASK
                            weight = bloom_weights[4 * (i & 3) + e]
                            low += coarse[row] * weight
                            middle += coarse[row + 1] * weight
                            high += coarse[row + 2] * weight
                        R = R + _upsample(low, middle, high, 0)
                        G = G + _upsample(low, middle, high, 1)
                        B = B + _upsample(low, middle, high, 2)
                    vignette_factor, denominator = Q[ONE], Q[ONE]  # the light is R, G, B divided by `denominator`
                    if ti.static(steps.vignette):
                        dx = (lane + (ti.cast(at, ti.f32) + 0.5)) * x_scale - 1.0
                        falloff = Q[ONE] + Q[VIGNETTE] * Q[HALF] * (dx * dx + dy * dy)
                        vignette_factor = Q[ONE] / (falloff * falloff)
                        R, G, B = R * vignette_factor, G * vignette_factor, B * vignette_factor
                    r, g, b = R, G, B
                    R = _matrix_row(r, g, b, Q, BEFORE)
                    G = _matrix_row(r, g, b, Q, BEFORE + 3)
                    B = _matrix_row(r, g, b, Q, BEFORE + 6)
                    if ti.static(steps.contrast):
                        R = _apply_contrast(R, Q, Z, F, I, o, 0)
                        G = _apply_contrast(G, Q, Z, F, I, o, 1)
                        B = _apply_contrast(B, Q, Z, F, I, o, 2)
                    if ti.static(steps.tone == "neutral"):  # Khronos PBR Neutral
                        minimum = ti.min(R, ti.min(G, B))
                        offset = ti.select(
                            minimum < Q[float_index(0.08)],
                            minimum - Q[float_index(6.25)] * minimum * minimum,
                            Q[float_index(0.04)],
                        )
                        peak = ti.max(R, ti.max(G, B)) - offset
                        peak = ti.select(peak > Q[float_index(0.76)], peak, Q[float_index(0.76)])
                        compressed_peak = Q[ONE] - Q[float_index(0.0576)] / (peak - Q[float_index(0.52)])
                        desaturation = Q[ONE] / (Q[float_index(0.15)] * (peak - compressed_peak) + Q[ONE])
                        scale = compressed_peak / peak * desaturation
                        white = compressed_peak * (Q[ONE] - desaturation)
                        R = (R - offset) * scale + white
                        G = (G - offset) * scale + white
                        B = (B - offset) * scale + white
                    elif ti.static(steps.tone == "log"):  # log density; a logarithm to any base
                        R = clamp(R, Q[ZERO], Q[float_index(1e12)])
                        G = clamp(G, Q[ZERO], Q[float_index(1e12)])
                        B = clamp(B, Q[ZERO], Q[float_index(1e12)])
                        peak = ti.max(R, ti.max(G, ti.max(B, Q[float_index(1e-20)])))
                        log_scale = Q[ONE] / log2(Q[ONE] + Q[DENSITY] * Q[WHITE], Q, Z, F, I, o)
                        scale = log2(Q[ONE] + Q[DENSITY] * peak, Q, Z, F, I, o + 3) * log_scale * Q[VIBRANCY] / peak
                        channel_scale = log_scale * (Q[ONE] - Q[VIBRANCY])
                        R = R * scale + log2(Q[ONE] + Q[DENSITY] * R, Q, Z, F, I, o + 6) * channel_scale
                        G = G * scale + log2(Q[ONE] + Q[DENSITY] * G, Q, Z, F, I, o + 9) * channel_scale
                        B = B * scale + log2(Q[ONE] + Q[DENSITY] * B, Q, Z, F, I, o + 12) * channel_scale
                    else:  # N / D of each channel over one common denominator; the encoding divides by it
                        r, g, b = clamp(R, Q[LOW], Q[HIGH]), clamp(G, Q[LOW], Q[HIGH]), clamp(B, Q[LOW], Q[HIGH])
                        x, y, z = _cubic(r, Q, DENOMINATOR), _cubic(g, Q, DENOMINATOR), _cubic(b, Q, DENOMINATOR)
                        yz = y * z
                        R = _cubic(r, Q, NUMERATOR) * yz
                        G = _cubic(g, Q, NUMERATOR) * (x * z)
                        B = _cubic(b, Q, NUMERATOR) * (x * y)
                        denominator = x * yz
                    r, g, b = R, G, B
                    R = _matrix_row(r, g, b, Q, AFTER)
                    G = _matrix_row(r, g, b, Q, AFTER + 3)
                    B = _matrix_row(r, g, b, Q, AFTER + 6)
                    if ti.static(steps.background):  # the background's colours are display light: they take no tone map
                        transparency = (Q[ONE] - clamp(A, Q[ZERO], Q[ONE])) * vignette_factor
                        R = _composite_over(R, denominator, background[i, 0], transparency, Q)
                        G = _composite_over(G, denominator, background[i, 1], transparency, Q)
                        B = _composite_over(B, denominator, background[i, 2], transparency, Q)
                    if ti.static(steps.transparent):
                        A = clamp(A, Q[ZERO], Q[ONE]) * denominator
                        A = clamp(ti.max(A, ti.max(R, ti.max(G, B))), Q[float_index(1e-6)] * denominator, denominator)
                        A, denominator = A / denominator, A
                    R, G, B = srgb_encode(R, G, B, denominator, Q, Z, F, I, o + _ROOT)
                    noise = scramble((lane_index + ti.cast(i * 16384 + at, ti.u32)) ^ frame_hash, Z)
                    if ti.static(steps.grain):  # the mean of four random bytes: nearly normal, standard deviation 1
                        bits = hash32(noise, Z)
                        odd_bytes = (bits >> Z[word_index(8)]) & Z[word_index(0xFF00FF)]
                        pairs = (bits & Z[word_index(0xFF00FF)]) + odd_bytes
                        total = (pairs & Z[word_index(0xFFFF)]) + (pairs >> Z[word_index(16)])
                        I[o + _NOISE + 3] = total | Z[word_index(TWO_23_BITS)]
                        n = (F[o + _NOISE + 3] - Q[float_index(TWO_23 + 510.0)]) * (
                            Q[GRAIN] * Q[float_index(4.0 / 147.8)]
                        )
                        R = clamp(R + n * R * (Q[ONE] - R), Q[ZERO], Q[ONE])
                        G = clamp(G + n * G * (Q[ONE] - G), Q[ZERO], Q[ONE])
                        B = clamp(B + n * B * (Q[ONE] - B), Q[ZERO], Q[ONE])
                    x = _encode(R, noise, Q, Z, F, I, o, 0, steps.sixteen_bit)
                    y = _encode(G, noise, Q, Z, F, I, o, 1, steps.sixteen_bit)
                    z = _encode(B, noise, Q, Z, F, I, o, 2, steps.sixteen_bit)
                    a = x
                    if ti.static(steps.transparent):
                        F[o + _CODE + 3] = A * Q[CODES] + Q[float_index(ROUND)]
                        a = I[o + _CODE + 3]
                    if ti.static(not steps.sixteen_bit):
                        x = x | y | z
                        if ti.static(steps.transparent):
                            x = x | (a << Z[word_index(24)])
                            for j in ti.static(range(WIDE // 4)):
                                out[(((i * width + at) // 4) & INDEX_MASK) + j] = ti.Vector(
                                    [x[4 * j + c] for c in range(4)]
                                )
                        else:  # the end of each word and the start of the next; three lanes of four are used
                            x = (x >> ti.Vector([ti.u32(8 * (k % 4)) for k in range(WIDE)])) | (
                                _next_lane(x) << ti.Vector([ti.u32(24 - 8 * (k % 4)) for k in range(WIDE)])
                            )
                            for j in ti.static(range(3 * WIDE // 16)):
                                out[(((i * width + at) * 3 // 16) & INDEX_MASK) + j] = ti.Vector(
                                    [x[(4 * j + c) // 3 * 4 + (4 * j + c) % 3] for c in range(4)]
                                )
                    else:
                        x = (x & Z[word_index(0xFFFF)]) | (y << Z[word_index(16)])
                        z = z & Z[word_index(0xFFFF)]
                        if ti.static(steps.transparent):
                            z = z | (a << Z[word_index(16)])
                            for j in ti.static(range(WIDE // 2)):
                                out[(((i * width + at) // 2) & INDEX_MASK) + j] = ti.Vector(
                                    [x[2 * j], z[2 * j], x[2 * j + 1], z[2 * j + 1]]
                                )
                        else:  # three words for two pixels
                            next_x = _next_lane(x)
                            y = z | (next_x << Z[word_index(16)])
                            z = (next_x >> Z[word_index(16)]) | (_next_lane(z) << Z[word_index(16)])
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
