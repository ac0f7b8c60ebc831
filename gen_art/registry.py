"""Registries of classes by name, and the typed parameters that a class declares.

A class with parameters is a `Parametric`: its annotations become constructor arguments, YAML keys, schema entries and
rows of the documentation. A `Registry` maps YAML names to classes.
"""

import difflib
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.quantities import plain

__all__ = ["Bounds", "Parameter", "Parametric", "Registry", "param", "suggest"]


@dataclass(frozen=True)
class Bounds:
    """The interval of the numbers that a parameter or a key may have.

    open_low, open_high : whether the end is excluded
    whole : whole numbers only
    All number ranges are checked here: of Python parameters, of registered classes in YAML, and of a preset's keys.
    """

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False
    whole: bool = False

    def check(self, value: float, unit: str = "") -> float:
        """The value. Raises UsageError if it is outside the bounds.

        unit : text after the bounds in the message, such as " degrees"
        """
        if not math.isfinite(value):
            raise UsageError(f"must be a finite number, not {value}")
        below = value < self.low or (self.open_low and value == self.low)
        above = value > self.high or (self.open_high and value == self.high)
        if below or above:
            raise UsageError(f"must be {self}{unit}, not {value:g}")
        if self.whole and value != int(value):
            raise UsageError(f"must be a whole number, not {value:g}")
        return value

    def __str__(self) -> str:
        if not (self.open_low or self.open_high) and -math.inf < self.low and self.high < math.inf:
            return f"from {self.low:g} to {self.high:g}"
        low = [f"{'more than' if self.open_low else 'at least'} {self.low:g}"] if self.low > -math.inf else []
        high = [f"{'less than' if self.open_high else 'at most'} {self.high:g}"] if self.high < math.inf else []
        return " and ".join(low + high)

    def schema(self) -> dict[str, float]:
        """The interval as keywords of JSON Schema."""
        out = {"exclusiveMinimum" if self.open_low else "minimum": self.low} if self.low > -math.inf else {}
        return out | ({"exclusiveMaximum" if self.open_high else "maximum": self.high} if self.high < math.inf else {})


@dataclass(frozen=True)
class Parameter:
    """One typed parameter. `kind` is float, int, range, vector, bool, choice, text, file, array or look; the bounds are closed.

    float, int, range (low, high) and vector (3 numbers) are run-time data of kernels; bool, choice and text are fixed when
    the kernel is generated; the class itself reads a file (a name, or the data); a look is for the renderer alone.
    """

    default: Any = None
    unit: str = ""
    minimum: float = -math.inf
    maximum: float = math.inf
    choices: tuple = ()
    doc: str = ""
    kind: str = "float"
    name: str = ""
    required: bool = False

    def check(self, value):
        """The value in its canonical Python form, a quantity in the parameter's unit. Raises UsageError for a wrong value."""
        value = plain(value, self.unit, self.name)
        if self.kind == "float":
            return self._in_range(arguments.number(self.name, value))
        if self.kind == "int":
            return self._in_range(arguments.whole(self.name, value))
        if self.kind == "range":
            pair = value if isinstance(value, (tuple, list)) else [getattr(value, end, value) for end in ("lo", "hi")]
            if len(pair) != 2:
                raise UsageError(f"{self.name} must be a number or a pair (low, high), not {arguments.shown(value)}")
            return tuple(self._in_range(arguments.number(self.name, end)) for end in pair)
        if self.kind == "vector":
            return tuple(self._in_range(component) for component in arguments.vector(self.name, value))
        if self.kind == "bool":
            return arguments.flag(self.name, value)
        if self.kind == "choice":
            if not isinstance(value, (str, int, float)) or value not in self.choices:
                choices = [str(choice) for choice in self.choices]
                near = suggest(value, choices) if isinstance(value, str) else ""
                raise UsageError(f"{self.name} must be one of {', '.join(choices)}; not {arguments.shown(value)}{near}")
            return value
        if self.kind == "text":
            return arguments.text(self.name, value)
        if self.kind == "look" and not (
            isinstance(value, (str, bool, Mapping, list, tuple)) or hasattr(value, "albedo")
        ):
            shown = arguments.shown(value)
            raise UsageError(
                f"{self.name} must be a ga.SurfaceLook, a mapping of its keys, a colour or true, not {shown}"
            )
        return value

    @property
    def bounds(self) -> Bounds:
        return Bounds(self.minimum, self.maximum)

    def _in_range(self, value):
        try:
            return self.bounds.check(value)
        except UsageError as error:
            raise UsageError(f"{self.name} {error}") from None

    @property
    def size(self) -> int:
        """The number of run-time numbers of the parameter."""
        return {"float": 1, "int": 1, "range": 2, "vector": 3}.get(self.kind, 0)


_REQUIRED = object()
T = TypeVar("T")


def param(
    default: Any = _REQUIRED, *, unit: str = "", min: float = -math.inf, max: float = math.inf, choices: Sequence[Any] = (),
    doc: str = "", kind: str | None = None,
) -> Any:  # fmt: skip
    """Declare a parameter of a Force, Emitter or other Parametric class.

    default : its value when left out; without a default the parameter is required
    unit : shown in the documentation, and what quantities of astropy and pint are converted to; "rad" is written in degrees
        in YAML
    min, max : closed range
    choices : the allowed values
    doc : its meaning
    kind : in place of the kind that follows from the annotation (float, int, bool, str, tuple for a vector); "range" is a
    number or (low, high)
    """
    if kind is not None:
        arguments.text("kind", kind)
    for key, bound in (("min", min), ("max", max)):
        if not (isinstance(bound, float) and math.isinf(bound)):
            arguments.number(key, bound)
    if isinstance(choices, str) or not isinstance(choices, Sequence):
        raise UsageError(f"choices must be a list of values, not {arguments.shown(choices)}")
    missing = default is _REQUIRED
    return Parameter(None if missing else default, unit, min, max, tuple(choices), doc, kind or "", required=missing)


_KINDS = {float: "float", int: "int", bool: "bool", tuple: "vector", str: "text", object: "array"}


class Parametric:
    """A class whose annotated `param(...)` attributes are its constructor's arguments, in order of declaration."""

    name: ClassVar[str] = ""
    parameters: ClassVar[dict[str, Parameter]] = {}
    tabled: bool = False  # whether `table()` gives further run-time numbers, which kernels read as q.table(k)

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        parameters = dict(cls.parameters)
        for key, annotation in inspect.get_annotations(cls).items():
            declared = cls.__dict__.get(key)
            if not isinstance(declared, Parameter):
                continue
            kind = declared.kind or ("choice" if declared.choices else _KINDS.get(annotation, "array"))
            parameters[key] = Parameter(**{**declared.__dict__, "kind": kind, "name": key})
            setattr(cls, key, _NotAnAttribute(key, cls.__name__))
        cls.parameters = parameters

    def __init__(self, *args, **kwargs):
        names = list(self.parameters)
        if len(args) > len(names):
            raise UsageError(f"{type(self).__name__} takes at most {len(names)} arguments ({', '.join(names)})")
        given = dict(zip(names, args))
        for key, value in kwargs.items():
            if key not in self.parameters:
                raise UsageError(f"{type(self).__name__} has no parameter '{key}'{suggest(key, names)}")
            if key in given:
                raise UsageError(f"{type(self).__name__} got '{key}' twice")
            given[key] = value
        self.values: dict[str, Any] = {}
        for key, parameter in self.parameters.items():
            if key not in given and parameter.required:
                raise UsageError(f"{type(self).__name__} needs '{key}'")
            value = given.get(key, parameter.default)
            if value is None and parameter.default is None and not parameter.required:
                self.values[key] = None  # an optional parameter that is left out
                continue
            try:
                self.values[key] = parameter.check(value)
            except UsageError as error:
                raise UsageError(f"{type(self).__name__}: {error}") from None
        self.prepare()

    def prepare(self):
        """Hook: check the parameters together and derive further numbers, in `self.values`."""

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.values.items())})"

    @classmethod
    def layout(cls) -> tuple[tuple[str, int, int], ...]:
        """(name, offset, size) of each run-time number in the class's slice of the parameter array."""
        out, offset = [], 0
        for key, parameter in cls.parameters.items():
            if parameter.size:
                out.append((key, offset, parameter.size))
                offset += parameter.size
        return tuple(out)

    def numbers(self) -> list[float]:
        """The run-time numbers, in the order of `layout`."""
        out = []
        for key, _, size in self.layout():
            value = self.values[key]
            out += [0.0 if value is None else float(value)] if size == 1 else [float(c) for c in value or (0.0,) * size]
        return out


@dataclass
class _NotAnAttribute:
    """Raises an error for `self.strength`, which would compile the number into the kernel, and says what to write instead."""

    key: str
    owner: str

    def __get__(self, instance, owner=None):
        if instance is None:
            return self
        raise AttributeError(
            f"self.{self.key} would be a constant of the compiled kernel: write q.{self.key} in a kernel, "
            f"or .values['{self.key}'] in Python ({self.owner})"
        )

    def __set__(self, instance, value):
        raise AttributeError(f"{self.owner}.{self.key} can be set only when the object is made")


@dataclass
class Registry:
    """Name -> class, for one kind of thing (force, emitter, ...)."""

    kind: str
    classes: dict[str, type] = field(default_factory=dict)

    def __call__(self, name: str) -> Callable[[type[T]], type[T]]:
        """Class decorator: register under `name`."""
        arguments.text(f"the name of a {self.kind}", name, f'text: write @ga.{self.kind}("name")')

        def add(cls: type[T]) -> type[T]:
            if name in self.classes and self.classes[name].__qualname__ != cls.__qualname__:
                raise UsageError(f"a {self.kind} named '{name}' exists already")
            if not (cls.__doc__ or "").strip():
                raise UsageError(f"the {self.kind} '{name}' needs a docstring: formula, units, source")
            vars_of: Any = cls
            vars_of.name = name
            self.classes[name] = cls
            return cls

        return add

    def __getitem__(self, name: str) -> type:
        try:
            return self.classes[name]
        except KeyError:
            raise UsageError(f"unknown {self.kind} '{name}'{suggest(name, self.classes)}") from None

    def __contains__(self, name) -> bool:
        return name in self.classes

    def __iter__(self):
        return iter(self.classes)


def suggest(word: str, words) -> str:
    """`; did you mean 'rate'?` if one of `words` is similar, otherwise an empty text."""
    close = difflib.get_close_matches(str(word), [str(w) for w in words], n=1, cutoff=0.6)
    return f"; did you mean '{close[0]}'?" if close else ""
