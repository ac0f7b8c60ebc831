"""Models of a preset from what a script gives in their place."""

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from gen_art.errors import UsageError
from gen_art.preset.model import Model, friendly
from gen_art.preset.problems import dotted
from gen_art.preset.values import shown

__all__ = ["model_of"]

M = TypeVar("M", bound=Model)


def model_of(cls: type[M], key: str, value: Any, forms: tuple[type, ...] = (Mapping,)) -> M | None:
    """A model: itself, from a mapping of its keys as in YAML, or from a short form; None from None or False.

    key : its name in messages
    forms : types that it is made from
    Raises UsageError for anything else.
    """
    if value is None or value is False or isinstance(value, cls):
        return value or None
    if not isinstance(value, forms):
        raise UsageError(f"{key} must be a ga.{cls.__name__} or a mapping of its keys, not {shown(value)}")
    try:
        return cls.model_validate(dict(value) if isinstance(value, Mapping) else value)
    except ValidationError as error:
        problems = [f"{dotted((key, *problem['loc']))}: {friendly(problem)}" for problem in error.errors()]
        raise UsageError("; ".join(problems)) from None
