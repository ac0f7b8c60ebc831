"""Quantities of astropy and pint, numbers with a unit, as the plain numbers that Gen Art computes with.

A quantity is known by its methods, so that neither library is needed, or imported, without one.
"""

from typing import Any

import numpy as np

from gen_art.errors import UsageError

__all__ = ["in_words", "plain", "units_of"]

_PLAIN = (float, int, str, bool, type(None), np.ndarray)  # most values: they are no quantities
_SPELLING = {"degrees": "deg"}  # of our units that a library spells otherwise


def plain(value: Any, unit: str, name: str) -> Any:
    """A quantity as the number or array that it is in `unit`; a list or tuple with its quantities so; any other value itself.

    unit : as of a parameter, "m/s^2"; "" for a number without a unit; of "m/s or m/s^2" the one that fits
    name : of the argument, for the message
    Raises UsageError for a quantity that cannot be converted. Angles are no plain numbers: 1 rad/s is not 1/s.
    """
    if type(value) in _PLAIN:
        return value
    if isinstance(value, (list, tuple)):
        members = [plain(member, unit, name) for member in value]
        changed = any(new is not old for new, old in zip(members, value))
        return (tuple(members) if isinstance(value, tuple) else members) if changed else value
    convert = _from_astropy if _is_of_astropy(value) else _from_pint if _is_of_pint(value) else None
    if convert is None:
        return value
    for candidate in units_of(unit):
        try:
            number = convert(value, candidate)
        except (TypeError, ValueError, AttributeError):  # other dimensions, or a unit that the library does not know
            continue
        return number[()] if isinstance(number, np.ndarray) else number  # an array of no dimension is a number
    if not unit:
        raise UsageError(f"{name} is a number without a unit, not {in_words(value)}")
    raise UsageError(f"{name} is in {unit}, and {in_words(value)} cannot be converted to it")


def units_of(unit: str) -> list[str]:
    """The units that a parameter of this unit may have, as astropy and pint both spell them."""
    out = []
    for one in unit.split(" or "):
        for ours, theirs in _SPELLING.items():
            one = one.replace(ours, theirs)
        out.append(one)
    return out


def in_words(value: Any) -> str:
    """A quantity for an error message, an array by its shape; an empty text for anything else."""
    if _is_of_astropy(value):
        number, unit = value.value, value.unit
    elif _is_of_pint(value):
        number, unit = value.magnitude, value.units
    else:
        return ""
    if np.ndim(number):
        return f"an array in {unit or 'no unit'} with the shape {np.shape(number)}"
    return f"{number} {unit}".strip()


def _is_of_astropy(value: Any) -> bool:
    return hasattr(type(value), "to_value") and hasattr(type(value), "unit")


def _is_of_pint(value: Any) -> bool:
    return hasattr(type(value), "m_as") and hasattr(type(value), "dimensionality")


def _from_astropy(value: Any, unit: str) -> Any:
    if unit == "K":
        from astropy.units import temperature  # it is there: the value is its

        return value.to_value(unit, equivalencies=temperature())  # from degrees Celsius too
    return value.to_value(unit)


def _from_pint(value: Any, unit: str) -> Any:
    kind = type(value)
    if _angles(kind(1, value.units)) != _angles(kind(1, unit)):  # to pint they are plain numbers, and 60 rpm is 6.28 Hz
        raise ValueError
    return value.m_as(unit)


def _angles(value: Any) -> float:
    """The power of the radian in the unit of a quantity of pint."""
    return dict(value.to_root_units().unit_items()).get("radian", 0)
