"""Checks of the arguments of public functions. Each raises a UsageError that names the argument and says what it must be.

Numbers, vectors and arrays may be quantities of astropy or pint, which are converted to the unit of the argument.
"""

import math
import os
from collections.abc import Iterable, Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np

from gen_art.errors import UsageError
from gen_art.quantities import in_words, plain

__all__ = ["array", "flag", "instances", "named", "number", "path", "shown", "text", "vector", "whole"]

_LONGEST = 60  # characters of a value in a message


def shown(value: Any) -> str:
    """A value for an error message, cut to a reasonable length; lists and arrays by their size, objects by their class."""
    if quantity := in_words(value):
        words = quantity
    elif isinstance(value, np.ndarray):
        words = f"an array of {value.dtype} with the shape {value.shape}"
    elif isinstance(value, (Mapping, list, tuple, set, frozenset)):
        words = f"a {'mapping' if isinstance(value, Mapping) else 'list'} of {len(value)}"
    elif value is None:
        words = "nothing"
    elif isinstance(value, bool):
        words = "true" if value else "false"
    elif isinstance(value, type):
        words = f"the class {value.__name__}"
    elif type(value).__repr__ is object.__repr__ or callable(value):
        words = f"an object of the class {type(value).__name__}"
    else:
        try:
            words = repr(value)
        except ValueError:  # an integer of more digits than Python prints
            words = "a number of thousands of digits"
    return words if len(words) <= _LONGEST else words[: _LONGEST - 3] + "..."


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, (bool, np.bool_))


def number(name: str, value: Any, unit: str = "", low: float = -math.inf, above: float = -math.inf) -> float:
    """The value as a finite float, in `unit` if it is a quantity, at least `low` and more than `above`."""
    value = plain(value, unit, name)
    try:
        result = float(value) if _is_number(value) else math.nan
    except OverflowError:
        result = math.nan
    if not math.isfinite(result) or result < low or result <= above:
        bound = f" of at least {low:g}" if low > -math.inf else f" above {above:g}" if above > -math.inf else ""
        raise UsageError(f"{name} must be a finite number{bound}{unit and ' ' + unit}, not {shown(value)}")
    return result


def whole(name: str, value: Any, low: int = -(2**63), high: int = 2**63 - 1) -> int:
    """The value as an int from `low` to `high`; a float without a fraction is one."""
    value, result = plain(value, "", name), None
    if _is_number(value) and (isinstance(value, Integral) or (math.isfinite(value) and value == int(value))):
        result = int(value)
    if result is None or not low <= result <= high:
        bounds = "" if low < -(2**62) else f" of at least {low}" if high > 2**62 else f" from {low:,} to {high:,}"
        raise UsageError(f"{name} must be a whole number{bounds}, not {shown(value)}")
    return result


def vector(name: str, value: Any, unit: str = "") -> tuple[float, float, float]:
    """Three finite numbers, in `unit` if they are a quantity."""
    value = plain(value, unit, name)
    try:
        if isinstance(value, (str, bytes, Mapping)):
            raise TypeError
        x, y, z = (number(name, component) for component in value)
    except (TypeError, ValueError):  # a UsageError is a ValueError
        raise UsageError(f"{name} must be three finite numbers [x, y, z], not {shown(value)}") from None
    return x, y, z


def array(name: str, value: Any, what: str, unit: str = "") -> np.ndarray:
    """The value as an array of finite float64.

    what : says in the message what the array must be: "numbers of the shape (n, 3)"
    unit : of the numbers, for a quantity
    """
    value = plain(value, unit, name)
    try:
        result = np.asarray(value)
        if result.dtype == object:  # integers that int64 does not hold, or no numbers at all
            if not all(_is_number(item) for item in result.flat):
                raise TypeError
        elif result.dtype.kind not in "fiu" and result.size:
            raise TypeError
        result = result.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{name} must be {what}, not {shown(value)}") from None
    if not np.isfinite(result).all():
        raise UsageError(f"{name} holds numbers that are not finite")
    return result


def path(name: str, value: Any) -> Path:
    """The value as a Path; it must be the name of a file."""
    if not isinstance(value, (str, os.PathLike)):
        raise UsageError(f"{name} must be the name of a file, not {shown(value)}")
    if "\0" in str(os.fspath(value)):
        raise UsageError(f"{name} must be the name of a file, and no name holds the character NUL")
    return Path(value)


def text(name: str, value: Any, what: str = "text") -> str:
    """The value, which must be text that is not empty."""
    if not isinstance(value, str) or not value:
        raise UsageError(f"{name} must be {what}, not {shown(value)}")
    return value


def flag(name: str, value: Any) -> bool:
    """The value as a bool."""
    if not isinstance(value, (bool, np.bool_)):
        raise UsageError(f"{name} must be True or False, not {shown(value)}")
    return bool(value)


def instances(name: str, value: Any, kind: type, example: str) -> list:
    """The members of an iterable, each an instance of `kind`."""
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        hint = f": write [{shown(value)}]" if isinstance(value, kind) else f", not {shown(value)}"
        raise UsageError(f"{name} must be a list of objects such as {example}{hint}")
    members = list(value)
    for member in members:
        if not isinstance(member, kind):
            raise UsageError(f"{name} must be a list of objects such as {example}, and {shown(member)} is none")
    return members


def named(name: str, value: Any, kind: type, example: str) -> dict:
    """A mapping of names, which are text, to instances of `kind`."""
    if not isinstance(value, Mapping):
        raise UsageError(f"{name} must be {example}, not {shown(value)}")
    for key, member in value.items():
        text(f"a name in {name}", key)
        if not isinstance(member, kind):
            raise UsageError(f"{name} must be {example}; '{key}' is {shown(member)}")
    return dict(value)
