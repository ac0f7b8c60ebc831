"""Building blocks of the preset's models: strict, frozen, with messages for a person and JSON schema for an editor.

Field types: Number (`1/240` allowed), Positive, NotNegative, Fraction (0 to 1), Whole, Vector, RangeOf (`2..4`),
CurveOf, Words.
A unit goes in the field's description: `fps: Positive = about(30, "frames per second", unit="1/s")`.
"""

import math
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError, core_schema

from gen_art.errors import UsageError
from gen_art.preset.values import Curve, Range, number, shown, vector
from gen_art.registry import suggest

__all__ = [
    "CurveOf",
    "Fraction",
    "Model",
    "NotNegative",
    "Number",
    "Positive",
    "RangeOf",
    "Vector",
    "Whole",
    "Words",
    "about",
    "collected",
    "friendly",
    "parsed",
]


def about(default: Any = ..., text: str = "", *, unit: str = "", **more):
    """A pydantic Field with a description and, in the JSON schema, a unit."""
    extra: dict[str, Any] = {"unit": unit} if unit else {}
    return Field(default, description=f"{text} [{unit}]" if unit else text, json_schema_extra=extra or None, **more)


class parsed:
    """Annotation: values pass through `parse` (ValueError = a problem); `schema` describes them in the JSON schema."""

    def __init__(self, parse, schema: dict):
        self.parse, self.schema = parse, schema

    def __get_pydantic_core_schema__(self, source, handler):
        return core_schema.no_info_plain_validator_function(self.parse)

    def __get_pydantic_json_schema__(self, schema, handler):
        return dict(self.schema)


def bounded(minimum=-math.inf, maximum=math.inf, *, above: bool = False, whole: bool = False):
    """A parser of numbers in a closed range; `above` leaves the minimum itself out."""

    def check(value: float):
        if value < minimum or value > maximum or (above and value == minimum):
            low = f"more than {minimum:g}" if above else f"at least {minimum:g}"
            raise UsageError(
                f"must be {low}, not {value:g}"
                if maximum == math.inf
                else f"must be from {minimum:g} to {maximum:g}, not {value:g}"
            )
        return value

    def parse(value):
        result = check(number(value))
        if whole and result != int(result):
            raise UsageError(f"must be a whole number, not {result:g}")
        return int(result) if whole else result

    parse.check = check  # type: ignore[attr-defined]
    return parse


def bounded_range(minimum=-math.inf, maximum=math.inf, *, above: bool = False, whole: bool = False):
    """A parser of Ranges whose ends lie in a closed range."""
    check = bounded(minimum, maximum, above=above, whole=whole)

    def parse(value):
        result = Range.of(value)
        check(result.lo)
        check(result.hi)
        return result

    return parse


def _number_schema(**bounds) -> dict:
    return {"anyOf": [{"type": "number", **bounds}, {"type": "string", "pattern": r"^[^.]+(\.[0-9]+)?(/.+)?$|^\$"}]}


_RANGE_SCHEMA = {
    "anyOf": [{"type": "number"}, {"type": "string", "description": "a range 2..4, a fraction 1/4 or a $knob"}]
}
_VECTOR_SCHEMA = {"anyOf": [{"type": "array", "minItems": 3, "maxItems": 3}, {"type": "string", "pattern": r"^\$"}]}
_CURVE_SCHEMA = {"type": "array", "items": {"type": "array", "minItems": 2, "maxItems": 2}, "minItems": 1}
_WHOLE_SCHEMA = {"anyOf": [{"type": "integer"}, {"type": "string", "pattern": r"^\$"}]}

Number = Annotated[float, parsed(bounded(), _number_schema())]
Positive = Annotated[float, parsed(bounded(0, above=True), _number_schema(exclusiveMinimum=0))]
NotNegative = Annotated[float, parsed(bounded(0), _number_schema(minimum=0))]
Fraction = Annotated[float, parsed(bounded(0, 1), _number_schema(minimum=0, maximum=1))]
Whole = Annotated[int, parsed(bounded(-(2**63), 2**63 - 1, whole=True), _WHOLE_SCHEMA)]
Vector = Annotated[tuple[float, float, float], parsed(vector, _VECTOR_SCHEMA)]
RangeOf = Annotated[Range, parsed(Range.of, _RANGE_SCHEMA)]
PositiveRange = Annotated[Range, parsed(bounded_range(0, above=True), _RANGE_SCHEMA)]
NotNegativeRange = Annotated[Range, parsed(bounded_range(0), _RANGE_SCHEMA)]
CountRange = Annotated[Range, parsed(bounded_range(0, whole=True), _RANGE_SCHEMA)]
CurveOf = Annotated[Curve, parsed(Curve.of, _CURVE_SCHEMA)]


def _words(value) -> tuple[str, ...]:
    words = (value,) if isinstance(value, str) else value
    if not isinstance(words, (list, tuple)) or not all(isinstance(word, str) and word for word in words):
        raise UsageError(f"must be a word or a list of words, not {shown(value)}")
    return tuple(words)


Words = Annotated[
    tuple[str, ...],
    parsed(_words, {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}),
]


class Model(BaseModel):
    """Base of every part of a preset: frozen, and an unknown key is a problem beside the others, with a suggestion."""

    model_config = ConfigDict(frozen=True, extra="ignore", arbitrary_types_allowed=True)

    short_form: ClassVar[dict | None] = None  # JSON schema of what `from_short` widens

    @classmethod
    def known_keys(cls) -> list[str] | None:
        """The keys YAML may use here (aliases win over Python names); None where any may stand."""
        if cls.model_config.get("extra") == "allow":
            return None
        return [field.alias or name for name, field in cls.model_fields.items()]

    @classmethod
    def from_short(cls, value):
        """The mapping that a short form stands for; a model with one says so here, and in `short_form`."""
        return value

    @model_validator(mode="wrap")
    @classmethod
    def _collect(cls, data, handler):
        if isinstance(data, cls):
            return data
        data = cls.from_short(data)
        if not isinstance(data, dict):
            raise UsageError(f"must be a mapping of keys, not {shown(data)}")
        known = cls.known_keys()
        unknown = [] if known is None else [key for key in data if key not in known]
        problems = [((key,), f"unknown key{suggest(key, known)}") for key in unknown]
        try:
            result = handler(data)
        except ValidationError as error:
            raise collected([*problems, *((e["loc"], friendly(e)) for e in error.errors())]) from None
        if problems:
            raise collected(problems)
        return result

    @classmethod
    def __get_pydantic_json_schema__(cls, schema, handler):
        made = handler(schema)
        body = handler.resolve_ref_schema(made)
        body.setdefault("additionalProperties", False)
        cls.describe(body["properties"])
        if cls.short_form is not None:
            whole = dict(body)
            body.clear()
            body |= {"description": whole.pop("description", ""), "anyOf": [whole, cls.short_form]}
        return made

    @classmethod
    def describe(cls, properties: dict) -> None:
        """Hook: change the JSON schema's properties, in place."""


def collected(problems) -> ValidationError:
    """One ValidationError from (path, text) pairs; raised in a validator, its paths continue the outer one."""
    return ValidationError.from_exception_data(
        "preset",
        [
            InitErrorDetails(type=PydanticCustomError("problem", "{text}", {"text": text}), loc=tuple(path), input=None)
            for path, text in problems
        ],
    )


def friendly(error) -> str:
    """The text of one pydantic error as a sentence about the value."""
    kind, context, value = error["type"], error.get("ctx", {}), error.get("input")
    if kind == "problem":
        return context["text"]
    if kind == "missing":
        return "is missing"
    if kind == "extra_forbidden":
        return "unknown key"
    if kind in ("value_error", "assertion_error"):
        return str(context["error"])
    if kind in ("model_type", "dict_type", "model_attributes_type", "mapping_type"):
        return f"must be a mapping of keys, not {shown(value)}"
    if kind == "too_short":
        return f"needs at least {context['min_length']} entry"
    if kind in ("string_type", "bool_type", "bool_parsing", "list_type", "tuple_type"):
        wanted = {"s": "text", "b": "true or false", "l": "a list", "t": "a list"}[kind[0]]
        return f"must be {wanted}, not {shown(value)}"
    if kind in ("int_type", "float_type", "int_parsing", "float_parsing"):
        return f"must be a number, not {shown(value)}"
    if kind in ("literal_error", "enum"):
        choices = [c.strip().strip("'") for c in context["expected"].replace(" or ", ", ").split(",")]
        return f"must be one of {', '.join(choices)}; not {shown(value)}{suggest(str(value), choices)}"
    bound = {"greater_than": ("gt", "more than"), "greater_than_equal": ("ge", "at least")}
    bound |= {"less_than": ("lt", "less than"), "less_than_equal": ("le", "at most")}
    if kind in bound:
        key, words = bound[kind]
        return f"must be {words} {context[key]:g}, not {shown(value)}"
    return error["msg"][:1].lower() + error["msg"][1:]
