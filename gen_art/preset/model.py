"""The base class of a preset's models. They are frozen, report all problems at once and have a JSON schema for editors."""

from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from gen_art.errors import UsageError
from gen_art.preset.values import shown
from gen_art.registry import suggest

__all__ = ["Model", "about", "collected", "friendly"]


def about(default: Any = ..., text: str = "", *, unit: str = "", **more):
    """A pydantic Field with a description and, in the JSON schema, a unit."""
    extra: dict[str, Any] = {"unit": unit} if unit else {}
    return Field(default, description=f"{text} [{unit}]" if unit else text, json_schema_extra=extra or None, **more)


class Model(BaseModel):
    """Base of every part of a preset: frozen. An unknown key is reported with the other problems, with a suggestion."""

    model_config = ConfigDict(frozen=True, extra="ignore", arbitrary_types_allowed=True)

    short_form: ClassVar[dict | None] = None  # JSON schema of the short form that `from_short` reads

    @classmethod
    def known_keys(cls) -> list[str] | None:
        """The keys that YAML may have here (aliases instead of Python names); None if any key is allowed."""
        if cls.model_config.get("extra") == "allow":
            return None
        return [field.alias or name for name, field in cls.model_fields.items()]

    @classmethod
    def from_short(cls, value):
        """Hook: the mapping that a short form stands for. A model that overrides it also sets `short_form`."""
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
        reference = handler(schema)
        body = handler.resolve_ref_schema(reference)
        body.setdefault("additionalProperties", False)
        cls.describe(body["properties"])
        if cls.short_form is not None:
            mapping = dict(body)
            body.clear()
            body |= {"description": mapping.pop("description", ""), "anyOf": [mapping, cls.short_form]}
        return reference

    @classmethod
    def describe(cls, properties: dict) -> None:
        """Hook: change the JSON schema's properties, in place."""


def collected(problems) -> ValidationError:
    """One ValidationError of (path, text) pairs. When a validator raises it, the paths are appended to the outer path."""
    return ValidationError.from_exception_data(
        "preset",
        [
            InitErrorDetails(type=PydanticCustomError("problem", "{text}", {"text": text}), loc=tuple(path), input=None)
            for path, text in problems
        ],
    )


def friendly(error) -> str:
    """The message of one pydantic error, in this package's words."""
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
