"""What the developing kernel computes with whole vectors of floats and words, and the numbers that this takes.

Every number is a vector too, of a table Q of floats that is also a table Z of words: Taichi would lay out a scalar beside a
vector as often as this has lanes, which takes seconds to compile. Nor can it cast a vector: floats and whole numbers change
into each other by way of a few vectors of memory that two arrays F and I share, from vector o on. A float of 2^23 + n or of
1.5 2^23 + n has the whole number n in its last bits.
"""

import math

import numpy as np

from gen_art.backend.runtime import aligned, ti
from gen_art.renderer.tone_curves import GREY

__all__ = [
    "CONSTANTS", "ROUND", "WHOLE", "WHOLE_BITS", "WIDE", "above", "encode", "f", "hashed", "log2", "scrambled", "table", "two_to",
    "w", "within",
]  # fmt: skip

WIDE = 32  # lanes: two of the widest vectors that processors have, so that each has something to do while it waits for the other
WHOLE = 8388608.0  # 2^23: what has its bits is whole
ROUND = 12582912.0  # 1.5 2^23: adding it rounds, negative numbers too
WHOLE_BITS = 0x4B000000

# sRGB's power branch, 1.055 x^(1/2.4) - 0.055 for x from 0.0031308 to 1, as a quartic over a cubic in sqrt(x): within 6e-7
_ABOVE = tuple(c / 20.2491496 for c in (13.2843061, 63.0982864, 28.2357181, 0.877431184, -0.050273701))
_BELOW = tuple(c / 20.2491496 for c in (20.2491496, 62.1299882, 22.0662748, 1.0))
_LEAST_ROOT = 0.0031308**0.5
_LEFT = (-0.31317578, 1.31580848, -2.19208957, 2.18945612)  # y^(-1/2) for y from 0.932 to 1.069, within 8e-7
_ATANH = tuple(1 / (2 * k + 1) for k in range(4, -1, -1))
_TWICE_LOG2_E = 2.0 / math.log(2)
_POWER = tuple(math.log(2) ** k / math.factorial(k) for k in range(6, -1, -1))  # 2^x
_ONE_BITS = 0x3F800000

# of the formulas here and of the kernel's
_FLOATS = (
    *_ABOVE, *_BELOW, *_ATANH, *_POWER, *_LEFT,
    _LEAST_ROOT, _TWICE_LOG2_E, WHOLE + 127.0, WHOLE + 510.0, ROUND, -126.0, 0.0, 0.04, 0.0576,
    0.08, 0.15, 0.5, 0.52, 0.76, 1.0, 1.4142135, 6.25, 12.92, 127.0, 1e-6, 1e-20, 1e-30, 1e12, GREY, 1.0 / GREY, 4.0 / 147.8,
)  # fmt: skip
_WORDS = (
    0x5F3759DF, 0x7FEB352D, 0x846CA68B, 0x7FFFFF, 0xFF00FF, 0xFF0000, 0xFFFF, 0xFF00, 0xFF, WHOLE_BITS, _ONE_BITS,
    0, 1, 2, 6, 8, 10, 12, 15, 16, 22, 23, 24,
)  # fmt: skip
_PLACE_OF_FLOAT = {number: k for k, number in enumerate(dict.fromkeys(_FLOATS))}
_PLACE_OF_WORD = {number: len(_PLACE_OF_FLOAT) + k for k, number in enumerate(_WORDS)}
CONSTANTS = len(_PLACE_OF_FLOAT) + len(_PLACE_OF_WORD)  # rows of a table that are taken


def table(rows: int) -> np.ndarray:
    """(CONSTANTS + rows, WIDE) float32: the constants, each a vector, and room for so many others."""
    q = aligned((CONSTANTS + rows, WIDE), np.float32)
    for number, place in _PLACE_OF_FLOAT.items():
        q[place] = number
    for word, place in _PLACE_OF_WORD.items():
        q[place].view(np.uint32)[:] = word
    return q


def f(number: float) -> int:
    """Where a float stands in Q."""
    return _PLACE_OF_FLOAT[number]


def w(number: int) -> int:
    """Where a word stands in Z."""
    return _PLACE_OF_WORD[number]


for _function in (f, w):
    vars(_function)["_is_wrapped_kernel"] = True  # plain Python called while tracing: Taichi need not warn


@ti.func
def within(x, low, high):
    """x held in a range; what is no number becomes `low`."""
    y = ti.select(x > low, x, low)
    return ti.select(y < high, y, high)


@ti.func
def above(x, low):
    """x, or `low` where it is below: an instruction, where ti.max takes three."""
    return ti.select(x > low, x, low)


@ti.func
def _horner(x, Q: ti.template(), coefficients: ti.template()):
    """A polynomial, highest power first."""
    y = Q[f(coefficients[0])]
    if ti.static(coefficients[0] == 1.0):
        y = x + Q[f(coefficients[1])]
    else:
        y = x * y + Q[f(coefficients[1])]
    for k in ti.static(range(2, len(coefficients))):
        y = y * x + Q[f(coefficients[k])]
    return y


@ti.func
def _root(x, whole, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """sqrt(x / whole) for x from 0 to whole, within 1e-6 of itself; two places of memory.

    1 / sqrt(x whole) by half the exponent and a cubic for what is left: a third of the time of the processor's own root.
    """
    z = x * whole
    F[o] = z
    I[o + 1] = Z[w(0x5F3759DF)] - (I[o] >> Z[w(1)])
    r = F[o + 1]
    return x * (r * _horner(z * r * r, Q, _LEFT))


@ti.func
def encode(R, G, B, whole, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """sRGB-encoded light R / whole, G / whole and B / whole, 0..1, by one division; six places of memory."""
    none, least = Q[f(0.0)], Q[f(_LEAST_ROOT)]
    r = _root(within(R, none, whole), whole, Q, Z, F, I, o)
    g = _root(within(G, none, whole), whole, Q, Z, F, I, o + 2)
    b = _root(within(B, none, whole), whole, Q, Z, F, I, o + 4)
    x, y, z = _horner(r, Q, _BELOW), _horner(g, Q, _BELOW), _horner(b, Q, _BELOW)
    xy = x * y
    one = Q[f(1.0)] / (xy * z)
    third = z * one
    return (
        ti.select(r > least, _horner(r, Q, _ABOVE) * (y * third), r * r * Q[f(12.92)]),
        ti.select(g > least, _horner(g, Q, _ABOVE) * (x * third), g * g * Q[f(12.92)]),
        ti.select(b > least, _horner(b, Q, _ABOVE) * (xy * one), b * b * Q[f(12.92)]),
    )


@ti.func
def scrambled(a, Z: ti.template()):
    """A hash whose lowest bits are not for use."""
    h = (a ^ (a >> Z[w(16)])) * Z[w(0x7FEB352D)]
    return (h ^ (h >> Z[w(15)])) * Z[w(0x846CA68B)]


@ti.func
def hashed(a, Z: ti.template()):
    h = scrambled(a, Z)
    return h ^ (h >> Z[w(16)])


@ti.func
def log2(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """The logarithm of positive floats, by three places of the memory."""
    F[o] = x
    bits = I[o]
    I[o + 1] = (bits >> Z[w(23)]) | Z[w(WHOLE_BITS)]
    I[o + 2] = (bits & Z[w(0x7FFFFF)]) | Z[w(_ONE_BITS)]
    e, m = F[o + 1] - Q[f(WHOLE + 127.0)], F[o + 2]
    big = m > Q[f(1.4142135)]
    e, m = ti.select(big, e + Q[f(1.0)], e), ti.select(big, m * Q[f(0.5)], m)
    s = (m - Q[f(1.0)]) / (m + Q[f(1.0)])
    return e + s * _horner(s * s, Q, _ATANH) * Q[f(_TWICE_LOG2_E)]


@ti.func
def two_to(x, Q: ti.template(), Z: ti.template(), F: ti.template(), I: ti.template(), o):
    """2^x for x from -126 to 127, by two places of the memory."""
    y = within(x, Q[f(-126.0)], Q[f(127.0)])
    rounded = y + Q[f(ROUND)]
    F[o] = rounded
    I[o + 1] = (I[o] << Z[w(23)]) + Z[w(_ONE_BITS)]
    return _horner(y - (rounded - Q[f(ROUND)]), Q, _POWER) * F[o + 1]
