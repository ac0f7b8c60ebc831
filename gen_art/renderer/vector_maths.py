"""Functions of whole vectors of floats and words for the tone map kernel, and the constants that they need.

Every constant is a vector too, a row of a table Q of floats that is also a table Z of words: Taichi would expand a scalar next
to a vector into as many scalars as the vector has lanes, which takes seconds to compile. Nor can Taichi cast a vector: floats
and integers are converted through memory, a few vectors that two arrays F and I share, from vector o on. A float of 2^23 + n
or of 1.5 2^23 + n holds the integer n in its last bits.
"""

import math

import numpy as np

from gen_art.backend.runtime import aligned, ti
from gen_art.renderer.tone_curves import GREY

__all__ = [
    "CONSTANTS", "HALF", "ONE", "ROUND", "TWO_23", "TWO_23_BITS", "WIDE", "ZERO", "clamp", "constant_table", "exp2",
    "float_index", "hash32", "log2", "max_with", "scramble", "srgb_encode", "word_index",
]  # fmt: skip

WIDE = 32  # lanes: two of the widest vectors of a processor, so that one can be processed while the other waits
TWO_23 = 8388608.0  # 2^23: a float of this size has no fractional bits
ROUND = 12582912.0  # 1.5 2^23: adding it rounds to an integer, for negative numbers too
TWO_23_BITS = 0x4B000000

# sRGB's power branch, 1.055 x^(1/2.4) - 0.055 for x from 0.0031308 to 1, as a quartic over a cubic in sqrt(x): within 6e-7
_SRGB_NUMERATOR = tuple(c / 20.2491496 for c in (13.2843061, 63.0982864, 28.2357181, 0.877431184, -0.050273701))
_SRGB_DENOMINATOR = tuple(c / 20.2491496 for c in (20.2491496, 62.1299882, 22.0662748, 1.0))
_SRGB_THRESHOLD_ROOT = 0.0031308**0.5
_RSQRT = (-0.31317578, 1.31580848, -2.19208957, 2.18945612)  # y^(-1/2) for y from 0.932 to 1.069, within 8e-7
_ATANH = tuple(1 / (2 * k + 1) for k in range(4, -1, -1))
_TWICE_LOG2_E = 2.0 / math.log(2)
_EXP2 = tuple(math.log(2) ** k / math.factorial(k) for k in range(6, -1, -1))  # 2^x
_ONE_BITS = 0x3F800000

# constants of the formulas here and of the kernel's
_FLOATS = (
    *_SRGB_NUMERATOR, *_SRGB_DENOMINATOR, *_ATANH, *_EXP2, *_RSQRT,
    _SRGB_THRESHOLD_ROOT, _TWICE_LOG2_E, TWO_23 + 127.0, TWO_23 + 510.0, ROUND, -126.0, 0.0, 0.04, 0.0576,
    0.08, 0.15, 0.5, 0.52, 0.76, 1.0, 1.4142135, 6.25, 12.92, 127.0, 1e-6, 1e-20, 1e-30, 1e12, GREY, 1.0 / GREY, 4.0 / 147.8,
)  # fmt: skip
_WORDS = (
    0x5F3759DF, 0x7FEB352D, 0x846CA68B, 0x7FFFFF, 0xFF00FF, 0xFF0000, 0xFFFF, 0xFF00, 0xFF, TWO_23_BITS, _ONE_BITS,
    0, 1, 2, 6, 8, 10, 12, 15, 16, 22, 23, 24,
)  # fmt: skip
_FLOAT_INDEX = {number: k for k, number in enumerate(dict.fromkeys(_FLOATS))}
_WORD_INDEX = {number: len(_FLOAT_INDEX) + k for k, number in enumerate(_WORDS)}
CONSTANTS = len(_FLOAT_INDEX) + len(_WORD_INDEX)  # rows that the constants take in a table


def constant_table(rows: int) -> np.ndarray:
    """(CONSTANTS + rows, WIDE) float32: the constants, each a vector, and room for `rows` others."""
    q = aligned((CONSTANTS + rows, WIDE), np.float32)
    for number, index in _FLOAT_INDEX.items():
        q[index] = number
    for word, index in _WORD_INDEX.items():
        q[index].view(np.uint32)[:] = word
    return q


def float_index(number: float) -> int:
    """The row of Q that holds a float constant."""
    return _FLOAT_INDEX[number]


def word_index(number: int) -> int:
    """The row of Z that holds a word constant."""
    return _WORD_INDEX[number]


ZERO, HALF, ONE = float_index(0.0), float_index(0.5), float_index(1.0)  # rows of Q

for _function in (float_index, word_index):
    vars(_function)["_is_wrapped_kernel"] = True  # plain Python called while tracing, about which Taichi would warn


@ti.func
def clamp(x, low, high):
    """x limited to low..high; NaN becomes `low`."""
    y = ti.select(x > low, x, low)
    return ti.select(y < high, y, high)


@ti.func
def max_with(x, low):
    """The larger of x and `low`. One instruction, where ti.max takes three."""
    return ti.select(x > low, x, low)


@ti.func
def _horner(x, Q: ti.template(), coefficients: ti.template()):
    """A polynomial of x, highest power first."""
    y = Q[float_index(coefficients[0])]
    if ti.static(coefficients[0] == 1.0):
        y = x + Q[float_index(coefficients[1])]
    else:
        y = x * y + Q[float_index(coefficients[1])]
    for k in ti.static(range(2, len(coefficients))):
        y = y * x + Q[float_index(coefficients[k])]
    return y


@ti.func
def _sqrt_of_ratio(x, denominator, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """sqrt(x / denominator) for x from 0 to `denominator`, with a relative error of 1e-6. Uses two places of the memory.

    1 / sqrt(x denominator) is found by halving the exponent and by a cubic for the rest: a third of the time of the processor's
    square root.
    """
    z = x * denominator
    F[o] = z
    I[o + 1] = Z[word_index(0x5F3759DF)] - (I[o] >> Z[word_index(1)])
    r = F[o + 1]
    return x * (r * _horner(z * r * r, Q, _RSQRT))


@ti.func
def srgb_encode(R, G, B, denominator, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """The sRGB encoding of light R / denominator, G / denominator and B / denominator, each in 0..1, with one division.

    Uses six places of the memory.
    """
    zero, threshold = Q[ZERO], Q[float_index(_SRGB_THRESHOLD_ROOT)]
    r = _sqrt_of_ratio(clamp(R, zero, denominator), denominator, Q, Z, F, I, o)
    g = _sqrt_of_ratio(clamp(G, zero, denominator), denominator, Q, Z, F, I, o + 2)
    b = _sqrt_of_ratio(clamp(B, zero, denominator), denominator, Q, Z, F, I, o + 4)
    x, y, z = _horner(r, Q, _SRGB_DENOMINATOR), _horner(g, Q, _SRGB_DENOMINATOR), _horner(b, Q, _SRGB_DENOMINATOR)
    xy = x * y
    inverse = Q[ONE] / (xy * z)
    inverse_z = z * inverse
    return (
        ti.select(r > threshold, _horner(r, Q, _SRGB_NUMERATOR) * (y * inverse_z), r * r * Q[float_index(12.92)]),
        ti.select(g > threshold, _horner(g, Q, _SRGB_NUMERATOR) * (x * inverse_z), g * g * Q[float_index(12.92)]),
        ti.select(b > threshold, _horner(b, Q, _SRGB_NUMERATOR) * (xy * inverse), b * b * Q[float_index(12.92)]),
    )


@ti.func
def scramble(a, Z: ti.template()):
    """A hash of 32 bits whose lowest bits are of poor quality."""
    h = (a ^ (a >> Z[word_index(16)])) * Z[word_index(0x7FEB352D)]
    return (h ^ (h >> Z[word_index(15)])) * Z[word_index(0x846CA68B)]


@ti.func
def hash32(a, Z: ti.template()):
    """A hash of 32 bits, all of good quality."""
    h = scramble(a, Z)
    return h ^ (h >> Z[word_index(16)])


@ti.func
def log2(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """The logarithm to base 2 of positive floats. Uses three places of the memory."""
    F[o] = x
    bits = I[o]
    I[o + 1] = (bits >> Z[word_index(23)]) | Z[word_index(TWO_23_BITS)]
    I[o + 2] = (bits & Z[word_index(0x7FFFFF)]) | Z[word_index(_ONE_BITS)]
    e, m = F[o + 1] - Q[float_index(TWO_23 + 127.0)], F[o + 2]
    upper_half = m > Q[float_index(1.4142135)]
    e, m = ti.select(upper_half, e + Q[ONE], e), ti.select(upper_half, m * Q[HALF], m)
    s = (m - Q[ONE]) / (m + Q[ONE])
    return e + s * _horner(s * s, Q, _ATANH) * Q[float_index(_TWICE_LOG2_E)]


@ti.func
def exp2(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """2^x for x from -126 to 127. Uses two places of the memory."""
    y = clamp(x, Q[float_index(-126.0)], Q[float_index(127.0)])
    rounded = y + Q[float_index(ROUND)]
    F[o] = rounded
    I[o + 1] = (I[o] << Z[word_index(23)]) + Z[word_index(_ONE_BITS)]
    return _horner(y - (rounded - Q[float_index(ROUND)]), Q, _EXP2) * F[o + 1]
