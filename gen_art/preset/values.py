"""The values of a preset's keys: numbers (`1/240`), ranges (`2..4`), vectors and curves."""

import bisect
import math
import re
from dataclasses import dataclass
from numbers import Real

from gen_art.arguments import shown
from gen_art.errors import UsageError

__all__ = ["Range", "Curve", "number", "vector", "shown"]

_NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
_FRACTION = re.compile(rf"\s*({_NUMBER})\s*(?:/\s*({_NUMBER})\s*)?")


def number(value) -> float:
    """A finite float from a number or from text such as `0.5`, `1e-3` or `1/240`.

    Raises UsageError for anything else: booleans, NaN, infinity, a zero divisor, words.
    """
    if isinstance(value, str):
        match = _FRACTION.fullmatch(value)
        if not match:
            raise UsageError(f"must be a number, not {shown(value)}")
        result, divisor = float(match[1]), float(match[2]) if match[2] else 1.0
        if divisor == 0:
            raise UsageError(f"must be a number, and {value.strip()} divides by zero")
        result /= divisor
    elif isinstance(value, bool) or not isinstance(value, Real):
        raise UsageError(f"must be a number, not {shown(value)}")
    else:
        try:
            result = float(value)
        except OverflowError:
            result = math.inf
    if not math.isfinite(result):
        raise UsageError(f"must be a finite number, not {shown(value)}")
    return result


def vector(value) -> tuple[float, float, float]:
    """Three finite floats from a sequence `[x, y, z]`. Raises UsageError otherwise."""
    if isinstance(value, (str, bytes, dict)) or not hasattr(value, "__len__") or len(value) != 3:
        raise UsageError(f"must be three numbers [x, y, z], not {shown(value)}")
    x, y, z = (number(component) for component in value)
    return x, y, z


@dataclass(frozen=True, slots=True)
class Range:
    """Uniform random values from lo to hi, drawn once for each particle; a constant if lo == hi. Written `2..4`, or `2`.

    Raises UsageError unless both ends are finite and lo <= hi.
    """

    lo: float
    hi: float

    def __post_init__(self):
        lo, hi = number(self.lo), number(self.hi)
        if lo > hi:
            raise UsageError(f"a range runs from small to large: write {hi:.12g}..{lo:.12g}")
        object.__setattr__(self, "lo", lo)
        object.__setattr__(self, "hi", hi)

    @classmethod
    def of(cls, value) -> "Range":
        """A Range from a Range, a number, `1/240`, `2..4` or a pair (lo, hi) in Python."""
        if isinstance(value, Range):
            return value
        if isinstance(value, tuple) and len(value) == 2:
            return cls(*value)
        if isinstance(value, str) and ".." in value:
            lo, _, hi = value.partition("..")
            if not lo.strip() or not hi.strip():
                raise UsageError(f"must be a number or a range such as 2..4, not {shown(value)}")
            return cls(number(lo), number(hi))
        constant = number(value)
        return cls(constant, constant)

    @property
    def constant(self) -> bool:
        return self.lo == self.hi

    @property
    def mean(self) -> float:
        return 0.5 * (self.lo + self.hi)

    def __str__(self) -> str:
        return f"{self.lo!r}" if self.constant else f"{self.lo!r}..{self.hi!r}"


@dataclass(frozen=True, slots=True)
class Curve:
    """A piecewise linear function through keys ((x, y), ...) with strictly increasing x; constant outside its keys.

    Raises UsageError if there are no keys, if keys are not pairs of finite numbers, or if x does not increase.
    """

    points: tuple[tuple[float, float], ...]

    def __post_init__(self):
        keys = []
        for key in self.points:
            if isinstance(key, (str, bytes, dict)) or not hasattr(key, "__len__") or len(key) != 2:
                raise UsageError(f"a curve's keys are pairs [x, y], not {shown(key)}")
            keys.append((number(key[0]), number(key[1])))
        if not keys:
            raise UsageError("a curve needs at least one key [x, y]")
        for (before, _), (after, _) in zip(keys, keys[1:]):
            if after <= before:
                raise UsageError(f"a curve's x must increase from key to key: {after:g} follows {before:g}")
        object.__setattr__(self, "points", tuple(keys))

    @classmethod
    def of(cls, value) -> "Curve":
        """A Curve from a Curve, a list of pairs, or `{curve: [[x, y], ...]}`."""
        if isinstance(value, Curve):
            return value
        if isinstance(value, dict) and set(value) == {"curve"}:
            value = value["curve"]
        if not isinstance(value, (list, tuple)):
            raise UsageError(f"must be a curve [[x, y], ...], not {shown(value)}")
        return cls(tuple(value))

    def __call__(self, x: float) -> float:
        keys = self.points
        if x <= keys[0][0]:
            return keys[0][1]
        if x >= keys[-1][0]:
            return keys[-1][1]
        right = bisect.bisect_right(keys, (x, math.inf))
        (x0, y0), (x1, y1) = keys[right - 1], keys[right]
        return y0 + (y1 - y0) * ((x - x0) / (x1 - x0))

    def integral(self, start: float, stop: float) -> float:
        """The exact integral from start to stop (trapezoids between keys)."""
        inside = [x for x, _ in self.points if start < x < stop]
        xs = [start, *inside, stop]
        return math.fsum(0.5 * (self(a) + self(b)) * (b - a) for a, b in zip(xs, xs[1:]))

    @property
    def minimum(self) -> float:
        return min(y for _, y in self.points)

    @property
    def maximum(self) -> float:
        return max(y for _, y in self.points)
