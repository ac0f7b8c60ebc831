"""Knobs: the named values of a preset that an artist turns first, with the range and unit that a slider needs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gen_art.errors import UsageError
from gen_art.preset.values import Range, number, shown
from gen_art.registry import suggest

__all__ = ["Knob", "is_described", "value_of"]

_KEYS = ("value", "range", "unit")


@dataclass(frozen=True)
class Knob:
    """A knob: `heat: 1500`, or `heat: {value: 1500, range: 900..2200, unit: K}`.

    value : plain data, as YAML has it
    range : the values worth trying, for sliders and mutations; other values are allowed. None where it is not written
    unit : as text, or ""
    """

    value: Any
    range: Range | None = None
    unit: str = ""

    @classmethod
    def of(cls, written: Any) -> "Knob":
        """The knob of what stands in YAML. Raises UsageError for a description that cannot be meant."""
        if not is_described(written):
            return cls(written)
        for key in written:
            if key not in _KEYS:
                raise UsageError(f"'{key}' is unknown{suggest(key, _KEYS)}; a knob has {', '.join(_KEYS)}")
        unit = written.get("unit", "")
        if not isinstance(unit, str):
            raise UsageError(f"the unit of a knob is text, not {shown(unit)}")
        if "range" not in written:
            return cls(written["value"], None, unit)
        extent = Range.of(written["range"])
        if extent.constant:
            raise UsageError(f"the range of a knob has two ends, such as 900..2200, not {shown(written['range'])}")
        return cls(written["value"], extent, unit)

    @property
    def number(self) -> float | None:
        """The value as a number; None if it is something else."""
        try:
            return number(self.value)
        except UsageError:
            return None

    @property
    def value_text(self) -> str:
        """The value as text; a list or a mapping by its size."""
        return shown(self.value) if isinstance(self.value, (list, dict)) else f"{self.value}"

    @property
    def range_text(self) -> str:
        """The range as in YAML, or ""."""
        return f"{self.range.lo:g}..{self.range.hi:g}" if self.range else ""

    def __str__(self) -> str:
        words = f"{self.value_text} {self.unit}" if self.unit else self.value_text
        return f"{words} ({self.range_text})" if self.range else words


def is_described(written: Any) -> bool:
    """Whether a knob is written as a mapping with `value`."""
    return isinstance(written, Mapping) and "value" in written


def value_of(written: Any) -> Any:
    """The value of a knob that is written one way or the other."""
    return written["value"] if is_described(written) else written
