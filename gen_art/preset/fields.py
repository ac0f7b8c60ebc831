"""The types of a look's values: numbers with bounds by pydantic, ranges, curves, gradients and colours."""

from typing import Annotated, Any

from pydantic import BeforeValidator, PlainSerializer, WithJsonSchema

from gen_art.preset.colour_names import Gradient, srgb
from gen_art.preset.palettes import names
from gen_art.preset.values import Curve, Range, number, vector

__all__ = ["ColourValue", "CurveValue", "GradientValue", "Number", "RangeValue", "Vector"]


def _schema(**schema):
    return WithJsonSchema(schema)


def _colour_before(value):
    srgb(value)
    return tuple(value) if isinstance(value, list) else value


_numbers = {"type": ["number", "string"]}
Number = Annotated[float, BeforeValidator(number), _schema(**_numbers)]
Vector = Annotated[
    tuple[float, float, float],
    BeforeValidator(vector),
    PlainSerializer(list),
    _schema(type="array", items=_numbers, minItems=3, maxItems=3),
]
RangeValue = Annotated[Range, BeforeValidator(Range.of), PlainSerializer(str), _schema(**_numbers)]
CurveValue = Annotated[
    Curve,
    BeforeValidator(Curve.of),
    PlainSerializer(lambda c: [list(p) for p in c.points]),
    _schema(type="array", items={"type": "array", "items": _numbers, "minItems": 2, "maxItems": 2}),
]
GradientValue = Annotated[
    Gradient,
    BeforeValidator(Gradient.of),
    PlainSerializer(Gradient.written),
    _schema(
        type=["string", "array"],
        description="a colour, a palette, a list of colours or of [position, colour]",
        anyOf=[{"enum": names()}, {"type": "string"}, {"type": "array"}],
    ),
]
ColourValue = Annotated[
    Any,
    BeforeValidator(_colour_before),
    PlainSerializer(lambda c: list(c) if isinstance(c, tuple) else c),
    _schema(type=["string", "array"]),
]
