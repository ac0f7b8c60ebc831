"""Elementary functions of NumPy arrays in float64 that give the same bits on every processor.

NumPy's own sin, cos, exp and log take the fastest code that the processor has, and their last bits differ between processors.
These use sums, products and divisions alone, each of which IEEE 754 rounds in one way.
Accuracy over the stated ranges: 1e-15, relative (exp, expm1, log) or absolute (sin, cos).
Source: see gen_art/maths/series.py.
"""

import numpy as np

from gen_art.maths.blocks import in_blocks
from gen_art.maths.series import ATANH, COS, EXP, EXPM1, HALF_PI, LN2, SIN

__all__ = ["arctan2", "arctanh", "cos", "exp", "expm1", "log", "median", "sin"]

_HALVINGS = 3  # tan(pi / 32) < 0.1: twelve terms of the series then leave 1e-26
_ARCTAN = tuple((-1) ** k / (2 * k + 1) for k in range(11, -1, -1))


def _horner(x: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    y = x * coefficients[0] + coefficients[1]
    for c in coefficients[2:]:
        y = y * x + c
    return y


@in_blocks
def _sine(x, quarter: int) -> np.ndarray:
    """sin(x + quarter pi/2)."""
    x = np.asarray(x, np.float64)
    n = np.floor(x * 0.6366197723675814 + 0.5)
    a, b, c = HALF_PI[True]
    r = ((x - n * a) - n * b) - n * c
    k = n.astype(np.int64) + quarter
    square = r * r
    y = np.where(k & 1, _horner(square, COS[True]), r * _horner(square, SIN[True]))
    return np.where(k & 2, -y, y)


def sin(x) -> np.ndarray:
    """Sine of x in radians; abs(x) up to 1e8."""
    return _sine(x, 0)


def cos(x) -> np.ndarray:
    """Cosine of x in radians; abs(x) up to 1e8."""
    return _sine(x, 1)


@in_blocks
def exp(x) -> np.ndarray:
    """e^x; 0 below -708, and above 709 the value there."""
    x = np.asarray(x, np.float64)
    y = np.clip(x, -708.0, 709.0)
    n = np.floor(y * 1.4426950408889634 + 0.5)
    a, b = LN2[True]
    r = (y - n * a) - n * b
    return np.where(x < -708.0, 0.0, np.ldexp(_horner(r, EXP[True]), n.astype(np.int32)))


@in_blocks
def expm1(x) -> np.ndarray:
    """e^x - 1, without cancellation near 0; x up to 709."""
    y = np.clip(np.asarray(x, np.float64), -708.0, 709.0)
    n = np.floor(y * 1.4426950408889634 + 0.5)
    a, b = LN2[True]
    r = (y - n * a) - n * b
    scale = np.ldexp(1.0, n.astype(np.int32))
    return scale * r * _horner(r, EXPM1[True]) + (scale - 1.0)


@in_blocks
def log(x) -> np.ndarray:
    """Natural logarithm of x > 0."""
    m, e = np.frexp(np.asarray(x, np.float64))
    small = m < 0.7071067811865476
    m, n = np.where(small, 2 * m, m), np.where(small, e - 1, e)
    s = (m - 1) / (m + 1)
    a, b = LN2[True]
    return n * a + (n * b + 2 * s * _horner(s * s, ATANH[True]))


def arctanh(x) -> np.ndarray:
    """The inverse of tanh, for abs(x) < 1."""
    x = np.asarray(x, np.float64)
    return 0.5 * log((1 + x) / (1 - x))


@in_blocks
def arctan2(y, x) -> np.ndarray:
    """The angle of (x, y), rad, -pi to pi; 0 at the origin. Accurate to 1e-15 absolute."""
    y, x = np.asarray(y, np.float64), np.asarray(x, np.float64)
    small, large = np.minimum(np.abs(x), np.abs(y)), np.maximum(np.abs(x), np.abs(y))
    t = small / np.where(large > 0, large, 1.0)
    for _ in range(_HALVINGS):  # arctan t = 2 arctan(t / (1 + sqrt(1 + t^2)))
        t = t / (1 + np.sqrt(1 + t * t))
    angle = 2.0**_HALVINGS * t * _horner(t * t, _ARCTAN)
    angle = np.where(np.abs(y) > np.abs(x), np.pi / 2 - angle, angle)
    angle = np.where(x < 0, np.pi - angle, angle)
    return np.where(y < 0, -angle, angle)


def median(x: np.ndarray) -> float:
    """The median of one number or more, none of them NaN. np.median imports masked arrays at its first call: 30 ms."""
    ordered = np.sort(x, axis=None)
    return 0.5 * (float(ordered[(len(ordered) - 1) // 2]) + float(ordered[len(ordered) // 2]))
