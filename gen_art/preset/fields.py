"""The types of a preset's keys: numbers with bounds, ranges, curves, vectors, words, colours and gradients.

fps: Positive = about(30, "frames per second", unit="1/s")
fov: Annotated[float, Within(0, 170, open_low=True, open_high=True)] = about(40, "angle of view", unit="degrees")
"""

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator, PlainSerializer, WithJsonSchema
from pydantic_core import core_schema

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient, srgb
from gen_art.preset.palettes import names
from gen_art.preset.values import Curve, Range, number, shown, vector
from gen_art.registry import Bounds

__all__ = [
    "MOST_LIGHT", "MOST_SIZE", "Brightness", "ColourValue", "CountRange", "CurveValue", "Fraction", "GradientValue",
    "NotNegative", "NotNegativeRange", "Number", "Parsed", "Positive", "PositiveRange", "RangeValue", "Size", "SizeRange",
    "Vector", "Whole", "Within", "Words",
]  # fmt: skip


class Parsed:
    """Annotation of a key whose values are read by a function.

    parse : makes the value from plain data; a ValueError becomes a problem of the preset
    schema : JSON schema of the plain data
    plain : makes plain data from a value, for the defaults in the JSON schema
    """

    def __init__(self, parse: Callable[[Any], Any], schema: dict, plain: Callable[[Any], Any] | None = None):
        self.parse, self.schema, self.plain = parse, schema, plain

    def __get_pydantic_core_schema__(self, source, handler):
        written = core_schema.plain_serializer_function_ser_schema(self.plain) if self.plain else None
        return core_schema.no_info_plain_validator_function(self.parse, serialization=written)

    def __get_pydantic_json_schema__(self, schema, handler):
        return dict(self.schema)


class Within(Parsed):
    """Annotation: a number within bounds; `1/240` and `1e-3` are numbers.

    whole : whole numbers only
    """

    def __init__(self, low=-math.inf, high=math.inf, *, open_low=False, open_high=False, whole: bool = False):
        bounds = Bounds(low, high, open_low, open_high, whole)
        kind = "integer" if whole else "number"
        text = r"^\$" if whole else r"^[^.]+(\.[0-9]+)?(/.+)?$|^\$"
        schema = {"anyOf": [{"type": kind, **bounds.schema()}, {"type": "string", "pattern": text}]}
        super().__init__(lambda value: (int if whole else float)(bounds.check(number(value))), schema)


class _RangeWithin(Parsed):
    """Annotation: a range `2..4` or a number, both ends within bounds."""

    def __init__(self, low=-math.inf, high=math.inf, *, open_low: bool = False, whole: bool = False):
        bounds = Bounds(low, high, open_low=open_low, whole=whole)

        def parse(value) -> Range:
            result = Range.of(value)
            bounds.check(result.lo)
            bounds.check(result.hi)
            return result

        text = {"type": "string", "description": "a range 2..4, a fraction 1/4 or a $knob"}
        super().__init__(parse, {"anyOf": [{"type": "number"}, text]}, str)


def _words(value) -> tuple[str, ...]:
    words = (value,) if isinstance(value, str) else value
    if not isinstance(words, (list, tuple)) or not all(isinstance(word, str) and word for word in words):
        raise UsageError(f"must be a word or a list of words, not {shown(value)}")
    return tuple(words)


def _checked_colour(value):
    srgb(value)
    return tuple(value) if isinstance(value, list) else value


_VECTOR = {"anyOf": [{"type": "array", "minItems": 3, "maxItems": 3}, {"type": "string", "pattern": r"^\$"}]}
_CURVE = {"type": "array", "items": {"type": "array", "minItems": 2, "maxItems": 2}, "minItems": 1}
_WORDS = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}

Number = Annotated[float, Within()]
Positive = Annotated[float, Within(0, open_low=True)]
NotNegative = Annotated[float, Within(0)]
# the renderer squares sizes, and sums and squares light, in float32, whose largest number is 3.4e38
MOST_SIZE, MOST_LIGHT = 1e18, 1e18
Size = Annotated[float, Within(0, MOST_SIZE, open_low=True)]
SizeRange = Annotated[Range, _RangeWithin(0, MOST_SIZE)]
Brightness = Annotated[float, Within(0, MOST_LIGHT)]
Fraction = Annotated[float, Within(0, 1)]
Whole = Annotated[int, Within(-(2**63), 2**63 - 1, whole=True)]
RangeValue = Annotated[Range, _RangeWithin()]
PositiveRange = Annotated[Range, _RangeWithin(0, open_low=True)]
NotNegativeRange = Annotated[Range, _RangeWithin(0)]
CountRange = Annotated[Range, _RangeWithin(0, 1e14, whole=True)]  # sums of counts are 64-bit integers
Vector = Annotated[tuple[float, float, float], Parsed(vector, _VECTOR, list)]
CurveValue = Annotated[Curve, Parsed(Curve.of, _CURVE, lambda curve: [list(point) for point in curve.points])]
Words = Annotated[tuple[str, ...], Parsed(_words, _WORDS)]
GradientValue = Annotated[
    Gradient,
    BeforeValidator(Gradient.of),
    PlainSerializer(Gradient.written),
    WithJsonSchema(
        {
            "type": ["string", "array"],
            "description": "a colour, a palette, a list of colours or of [position, colour]",
            "anyOf": [{"enum": names()}, {"type": "string"}, {"type": "array"}],
        }
    ),
]
ColourValue = Annotated[
    Any,
    BeforeValidator(_checked_colour),
    PlainSerializer(lambda colour: list(colour) if isinstance(colour, tuple) else colour),
    WithJsonSchema({"type": ["string", "array"]}),
]
