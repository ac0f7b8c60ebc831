"""Changes a preset before it is validated: dotted paths (`systems.flame.emitters.base.rate`) and `$knobs`."""

import re
from collections.abc import Mapping
from typing import Any

from gen_art.errors import UsageError
from gen_art.preset.knobs import Knob, is_described, value_of
from gen_art.preset.problems import dotted
from gen_art.preset.reader import read_value
from gen_art.preset.values import shown
from gen_art.quantities import in_words
from gen_art.registry import suggest

__all__ = ["apply", "fill_knobs", "parse_setting", "plain", "split_path"]

_NAMED = ("systems", "emitters", "choose", "knobs")  # mappings whose keys are names that the preset defines
_PART = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


def parse_setting(text: str) -> tuple[str, Any]:
    """`a.b=VALUE` -> (`a.b`, value), where VALUE is YAML. Raises UsageError for other text."""
    path, equals, value = text.partition("=")
    if not equals or not path.strip():
        raise UsageError(
            f"--set {shown(text)}: write a path, an equals sign and a value: systems.flame.emitters.base.rate=500"
        )
    return path.strip(), read_value(value, f"--set {path.strip()}")


def plain(value: Any, depth: int = 0) -> Any:
    """A Python value as plain data: tuples and arrays become lists, NumPy numbers become Python numbers."""
    if depth > 100:
        raise UsageError("a preset is nested more than 100 levels deep")
    if isinstance(value, Mapping):
        return {str(key): plain(item, depth + 1) for key, item in value.items()}
    if quantity := in_words(value):
        raise UsageError(f"the keys of a preset hold plain numbers, not {quantity}")
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(item, depth + 1) for item in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if type(value).__module__ == "gen_art.preset.values":
        return str(value) if hasattr(value, "lo") else plain(value.points, depth + 1)
    raise UsageError(f"a preset holds numbers, text, lists and mappings, not {type(value).__name__}")


def apply(data: dict, overrides: Mapping[str, Any], convert: bool = True) -> list[tuple]:
    """Set each override in `data`, in place; returns the paths that were set.

    A dotted key replaces the old value; a nested mapping is merged with it key by key.
    convert : turn the values into plain data first
    Raises UsageError for a path that does not exist, with the nearest name.
    """
    set_paths: list[tuple] = []
    for key, value in overrides.items():
        path = split_path(str(key))
        _set(data, path, plain(value) if convert else value, merge="." not in str(key), set_paths=set_paths)
    return set_paths


def split_path(text: str) -> tuple:
    """`a.b[2]` -> ("a", "b", 2). Raises UsageError for other text."""
    path = tuple(int(m[2]) if m[2] else m[1] for m in _PART.finditer(text))
    if not path or dotted(path) != text:
        raise UsageError(f"{shown(text)} is not a path: write keys with dots between, systems.flame.emitters.base.rate")
    return path


def _set(data: dict, path: tuple, value: Any, merge: bool, set_paths: list[tuple]) -> None:
    node: Any = data
    for depth, part in enumerate(path[:-1]):
        node = _enter(node, path, depth, part)
    last, here = path[-1], path[:-1]
    if isinstance(node, list):
        node[_index(node, here, last)] = value
        set_paths.append(path)
    elif not isinstance(node, dict):
        raise UsageError(f"{dotted(path)}: {_not_a_mapping(here, node)}")
    elif merge and isinstance(value, dict) and isinstance(node.get(last), dict):
        for key, item in value.items():
            _set(data, (*path, key), item, True, set_paths)
    else:
        if here == ("knobs",):
            if last not in node:
                raise UsageError(f"{dotted(path)}: there is no knob '{last}'{suggest(last, node)}")
            if is_described(node[last]) and not is_described(value):  # its range and unit stay
                node, last, path = node[last], "value", (*path, "value")
        node[last] = value
        set_paths.append(path)


def _enter(node: Any, path: tuple, depth: int, part) -> Any:
    """The child on a path. A missing mapping is added, but a missing name is an error."""
    here = path[:depth]
    if isinstance(node, list):
        return node[_index(node, here, part)]
    if not isinstance(node, dict):
        raise UsageError(f"{dotted(path)}: {_not_a_mapping(here, node)}")
    if node.get(part) is None:
        if here and here[-1] in _NAMED:
            names = suggest(part, node) or ("; there are " + ", ".join(node) if node else "")
            raise UsageError(f"{dotted(path)}: there is no '{part}' in {dotted(here)}{names}")
        node[part] = {}
    return node[part]


def _index(node: list, here: tuple, part) -> int:
    text = str(part)
    if not text.isdigit() or int(text) >= len(node):
        raise UsageError(f"{dotted(here)} is a list of {len(node)}; {shown(part)} is not an index of it")
    return int(text)


def _not_a_mapping(here: tuple, node: Any) -> str:
    if isinstance(node, str) and node.startswith("$"):
        return f"{dotted(here)} is the knob {node}; set knobs.{node[1:]} instead"
    return f"{dotted(here)} is {shown(node)} and has no keys; set {dotted(here)} as a whole"


def fill_knobs(data: dict) -> tuple[dict, dict[str, Knob], list[tuple[tuple, str]]]:
    """(the data without `knobs:` and with each `$name` replaced by its knob's value, the knobs, problems)."""
    written = data.get("knobs")
    problems: list[tuple[tuple, str]] = []
    if written is None:
        written = {}
    if not isinstance(written, dict):
        problems.append((("knobs",), f"must be a mapping of names to values, not {shown(written)}"))
        written = {}
    knobs = {}
    for name, entry in written.items():
        try:
            knobs[name] = Knob.of(entry)
        except UsageError as error:
            problems.append((("knobs", name), str(error)))
            knobs[name] = Knob(value_of(entry))
        place, value = ("knobs", name, "value") if is_described(entry) else ("knobs", name), knobs[name].value
        if isinstance(value, str) and value.startswith("$"):
            problems.append((place, "a knob must have a value, not another knob"))
        elif knobs[name].range is not None and knobs[name].number is None:
            problems.append((place, f"has a range, so it must be a number, not {shown(value)}"))

    def fill(value: Any, path: tuple) -> Any:
        if isinstance(value, dict):
            return {key: fill(item, (*path, key)) for key, item in value.items()}
        if isinstance(value, list):
            return [fill(item, (*path, k)) for k, item in enumerate(value)]
        if isinstance(value, str) and value.startswith("$"):
            if value[1:] in knobs:
                return plain(knobs[value[1:]].value)
            names = [f"${knob}" for knob in knobs]
            near = suggest(value, names) or ("; there are " + ", ".join(names) if names else "")
            problems.append((path, f"there is no knob {shown(value)}{near}"))
        return value

    return {key: fill(item, (key,)) for key, item in data.items() if key != "knobs"}, knobs, problems
