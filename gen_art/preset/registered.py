"""Registered classes (forces, shapes, velocities, interactions, scripted emitters) as values in a preset.

All are written `name: VALUE`, where VALUE is a mapping of parameters, or the value of the first parameter. Angles (unit
"rad") are written in degrees; a constant `G` that is left out is that of `units:`. Registries are looked up when a preset is
read, so the classes of plugins are included.
"""

import importlib
import math
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from typing import Any

from pydantic import ValidationError
from pydantic_core import core_schema

from gen_art.errors import UsageError
from gen_art.preset.files import inside
from gen_art.preset.model import collected, friendly
from gen_art.preset.surface import SurfaceLook
from gen_art.preset.values import Range, number, shown, vector
from gen_art.registry import Bounds, Parameter, Parametric, Registry, suggest

__all__ = ["GRAVITATION", "KINDS", "Many", "One", "build", "class_schema", "parameters", "registry"]

GRAVITATION: ContextVar[float | None] = ContextVar("units.G", default=None)  # units.G of the preset that is being read

_REGISTRIES = {  # kind -> package with the built-in classes, module and name of the registry
    "forces": ("gen_art.forces", "gen_art.forces.base", "FORCES"),
    "interactions": ("gen_art.interactions", "gen_art.interactions.base", "INTERACTIONS"),
    "colliders": ("gen_art.colliders", "gen_art.colliders.base", "COLLIDERS"),
    "shapes": ("gen_art.emitters", "gen_art.emitters.base", "SHAPES"),
    "velocities": ("gen_art.emitters", "gen_art.emitters.base", "VELOCITIES"),
    "emitters": ("gen_art.emitters", "gen_art.emitters.base", "EMITTERS"),
}
KINDS = tuple(_REGISTRIES)


def registry(kind: str) -> Registry:
    """The registry of `forces`, `interactions`, `colliders`, `shapes`, `velocities` or `emitters`, with all built-in classes."""
    package, module, name = _REGISTRIES[kind]
    importlib.import_module(package)
    return getattr(importlib.import_module(module), name)


def is_field(cls: type) -> bool:
    """Whether a force can be a term of a medium, that is, has a vector at every position and time."""
    return callable(getattr(cls, "acceleration", None))


def parameters(cls: type[Parametric]) -> dict[str, Parameter]:
    """The parameters that YAML may set (a drag's `medium` is the system's, never a value)."""
    return {name: parameter for name, parameter in cls.parameters.items() if name != "medium"}


def in_degrees(parameter: Parameter) -> bool:
    return parameter.unit == "rad"


def _within(parameter: Parameter, value: float) -> float:
    """The value in the object's unit. Raises UsageError, in YAML's unit, when it is out of range."""
    if not in_degrees(parameter):
        return parameter.bounds.check(value)
    in_yaml = Bounds(math.degrees(parameter.minimum), math.degrees(parameter.maximum))
    return math.radians(in_yaml.check(value, " degrees"))


def _value(parameter: Parameter, value: Any) -> Any:
    """One parameter's value from its YAML form. Raises UsageError for a wrong value."""
    kind = parameter.kind
    if value is None and parameter.default is None and not parameter.required:
        return None
    if kind == "float":
        return _within(parameter, number(value))
    if kind == "int":
        whole = number(value)
        if whole != int(whole):
            raise UsageError(f"must be a whole number, not {whole:g}")
        return int(_within(parameter, int(whole)))
    if kind == "vector":
        return tuple(_within(parameter, component) for component in vector(value))
    if kind == "range":
        ends = Range.of(value)
        return Range(_within(parameter, ends.lo), _within(parameter, ends.hi))
    if kind == "bool" and not isinstance(value, bool):
        raise UsageError(f"must be true or false, not {shown(value)}")
    if kind == "choice" and value not in parameter.choices:
        choices = [str(choice) for choice in parameter.choices]
        raise UsageError(f"must be one of {', '.join(choices)}; not {shown(value)}{suggest(str(value), choices)}")
    if kind == "file":
        return inside(value)
    if kind == "look":
        return None if value is False else SurfaceLook.model_validate(value)
    if kind == "text" and not isinstance(value, str):
        raise UsageError(f"must be text, not {shown(value)}")
    return value


def _as_mapping(cls: type[Parametric], value: Any) -> dict:
    """A short form as a mapping: a list of vectors gives the first parameters in order, other values the first one."""
    names = parameters(cls)
    if isinstance(value, dict):
        return value
    if not names:
        if value in (None, True):
            return {}
        raise UsageError(f"has no parameters: write `{cls.name}: {{}}`")
    if value is None:
        return {}
    first, *_ = names.values()
    if first.kind == "vector" and isinstance(value, (list, tuple)) and value and isinstance(value[0], (list, tuple)):
        if len(value) > len(names):
            raise UsageError(f"has at most {len(names)} values ({', '.join(names)}), not {len(value)}")
        return dict(zip(names, value))
    return {first.name: value}


def build(cls: type[Parametric], value: Any) -> Parametric:
    """An instance from its YAML form. Raises ValidationError with every problem under its key."""
    try:
        given = _as_mapping(cls, value)
    except UsageError as error:
        raise collected([((), str(error))]) from None
    known = parameters(cls)
    problems: list[tuple[tuple, str]] = []
    values: dict[str, Any] = {}
    if "G" in known and GRAVITATION.get() is not None:
        values["G"] = GRAVITATION.get()
    for key, item in given.items():
        if key not in known:
            problems.append(((key,), f"unknown key{suggest(key, known)}"))
            continue
        try:
            values[key] = _value(known[key], item)
        except UsageError as error:
            problems.append(((key,), str(error)))
        except ValidationError as error:
            problems += [((key, *item["loc"]), friendly(item)) for item in error.errors()]
    problems += [((key,), "is missing") for key, p in known.items() if p.required and key not in given]
    if not problems:
        try:
            return cls(**values)
        except UsageError as error:
            problems.append(((), str(error).removeprefix(f"{cls.__name__}: ")))
    raise collected(problems)


def _under(key, error: ValidationError) -> Iterator[tuple[tuple, str]]:
    """The problems of `build`, with `key` added in front of their paths."""
    for item in error.errors():
        yield (*(key if isinstance(key, tuple) else (key,)), *item["loc"]), item["ctx"]["text"]


class Many:
    """Annotation for `forces: {gravity: ..., drag: ...}`: a tuple of instances; a list of mappings gives several of a name.

    The tuple is ordered by name, not as in the file, because floating-point sums depend on the order.
    """

    def __init__(self, kind: str, accept: Callable[[type], bool] = lambda cls: True):
        self.kind, self.accept = kind, accept

    def names(self) -> list[str]:
        classes = registry(self.kind)
        return [name for name in classes if self.accept(classes[name])]

    def _elsewhere(self, name: str) -> str:
        """A hint for a name that belongs under another key."""
        for kind in ("forces", "interactions", "colliders"):
            if kind != self.kind and name in registry(kind):
                singular = registry(kind).kind
                return f"; it is {'an' if singular[0] in 'aeiou' else 'a'} {singular}, and goes under {kind}:"
        return ""

    def validate(self, value: Any) -> tuple:
        if isinstance(value, tuple) and all(isinstance(item, Parametric) for item in value):
            return value
        if value is None:
            return ()
        if not isinstance(value, dict):
            raise UsageError(f"must be a mapping of {self.kind}, not {shown(value)}")
        names, problems, instances = self.names(), [], []
        for name in sorted(value):
            if name not in names:
                hint = (
                    self._elsewhere(name)
                    or suggest(name, names)
                    or f"; there are {', '.join(sorted(names))}; is a --plugin missing?"
                )
                problems.append(((name,), f"unknown {registry(self.kind).kind}{hint}"))
                continue
            cls, item = registry(self.kind)[name], value[name]
            several = isinstance(item, list) and item and all(isinstance(part, dict) for part in item)
            for key, part in [((name, k), part) for k, part in enumerate(item)] if several else [((name,), item)]:
                try:
                    instances.append(build(cls, part))
                except ValidationError as error:
                    problems += _under(key, error)
        if problems:
            raise collected(problems)
        return tuple(instances)

    def __get_pydantic_core_schema__(self, source, handler):
        return core_schema.no_info_plain_validator_function(self.validate)

    def __get_pydantic_json_schema__(self, schema, handler):
        classes = registry(self.kind)
        schemas = {name: class_schema(classes[name]) for name in sorted(self.names())}
        return {
            "type": "object",
            "additionalProperties": False,
            "properties": {
                name: {**schema, "anyOf": [*schema["anyOf"], {"type": "array", "items": schema["anyOf"][0]}]}
                for name, schema in schemas.items()
            },
        }


class One:
    """Annotation for `velocity: {cone: [0, 1, 0], angle: 5}`: one registered name, with its other parameters beside it.

    bare : the class that a plain vector stands for (the constant velocity, the point)
    """

    def __init__(self, kind: str, bare: str):
        self.kind, self.bare = kind, bare

    def validate(self, value: Any) -> Any:
        if isinstance(value, Parametric):
            return value
        classes = registry(self.kind)
        if isinstance(value, (list, tuple)) and self.bare in classes:
            return build(classes[self.bare], value)
        known = f"one of {', '.join(sorted(classes))}"
        if not isinstance(value, dict) or not value:
            if isinstance(value, str) and value in classes:
                return build(classes[value], {})
            raise UsageError(f"must be a vector or {known}, not {shown(value)}")
        named = [key for key in value if key in classes]
        if not named:
            first = next(iter(value))
            raise collected([((first,), f"unknown {classes.kind}{suggest(first, classes) or '; ' + known}")])
        name, *others = named
        cls = classes[name]
        if others and not set(others) <= set(parameters(cls)):
            raise UsageError(f"has both {name} and {others[0]}: choose one")
        siblings = {key: item for key, item in value.items() if key != name}
        try:
            try:
                first = _as_mapping(cls, value[name])
            except UsageError as error:
                raise collected([((name,), str(error))]) from None
            return build(cls, {**first, **siblings})
        except ValidationError as error:
            raise collected(
                [
                    (((name, *path) if path and path[0] not in siblings else path), text)
                    for path, text in _under((), error)
                ]
            ) from None

    def __get_pydantic_core_schema__(self, source, handler):
        return core_schema.no_info_plain_validator_function(self.validate)

    def __get_pydantic_json_schema__(self, schema, handler):
        classes = registry(self.kind)
        options: list[dict] = [{"type": "array", "description": f"short for {self.bare}"}]
        for name in sorted(classes):
            forms = class_schema(classes[name])
            mapping = forms["anyOf"][0]
            options.append(
                {
                    "type": "object",
                    "description": forms["description"],
                    "required": [name],
                    "additionalProperties": False,
                    "properties": {**mapping["properties"], name: {"anyOf": forms["anyOf"]}},
                }
            )
        return {"anyOf": options}


def _inlined(schema: dict) -> dict:
    """A model's JSON schema with its definitions in the places that refer to them."""
    definitions = schema.get("$defs", {})

    def resolved(part):
        if isinstance(part, dict):
            if "$ref" in part:
                return resolved(definitions[part["$ref"].rpartition("/")[2]])
            return {key: resolved(value) for key, value in part.items() if key != "$defs"}
        return [resolved(value) for value in part] if isinstance(part, list) else part

    return resolved(schema)


def _parameter_schema(parameter: Parameter) -> dict:
    convert = math.degrees if in_degrees(parameter) else float
    schema: dict[str, Any] = {}
    if parameter.kind in ("float", "int", "vector", "range"):
        schema = {"type": "integer" if parameter.kind == "int" else "number"}
        schema |= {"minimum": convert(parameter.minimum)} if parameter.minimum > -math.inf else {}
        schema |= {"maximum": convert(parameter.maximum)} if parameter.maximum < math.inf else {}
        if parameter.kind == "vector":
            schema = {"type": "array", "items": {"anyOf": [schema, {"type": "string"}]}, "minItems": 3, "maxItems": 3}
        text = {
            "type": "string",
            "description": "a fraction 1/4, a $knob" + (", a range 2..4" * (parameter.kind == "range")),
        }
        schema = {"anyOf": [schema, text]}
    elif parameter.kind == "bool":
        schema = {"type": "boolean"}
    elif parameter.kind == "choice":
        schema = {"enum": list(parameter.choices)}
    elif parameter.kind in ("text", "file"):
        schema = {"type": "string"}
    elif parameter.kind == "look":
        schema = _inlined(SurfaceLook.model_json_schema())
    unit = "degrees" if in_degrees(parameter) else parameter.unit
    description = " ".join(part for part in (parameter.doc, f"[{unit}]" if unit else "") if part)
    schema |= {"description": description} if description else {}
    schema |= {"unit": unit} if unit else {}
    if parameter.default is not None:
        default = parameter.default
        if in_degrees(parameter):
            degrees = [round(math.degrees(part), 9) for part in (default if isinstance(default, tuple) else (default,))]
            default = degrees if isinstance(default, tuple) else degrees[0]
        schema["default"] = str(Range.of(default)) if parameter.kind == "range" else default
    return schema


def class_schema(cls: type[Parametric]) -> dict:
    """The JSON schema of one registered class: a mapping of its parameters first, then the short forms."""
    known = parameters(cls)
    mapping: dict[str, Any] = {
        "type": "object",
        "additionalProperties": False,
        "properties": {name: _parameter_schema(parameter) for name, parameter in known.items()},
    }
    required = [name for name, parameter in known.items() if parameter.required]
    if required:
        mapping["required"] = required
    forms = [mapping]
    if known:
        forms.append(_parameter_schema(next(iter(known.values()))))
        forms.append({"type": "array", "items": {"type": "array"}})
    description = " ".join((cls.__doc__ or "").strip().split("\n\n")[0].split())
    return {"description": description, "anyOf": forms}
