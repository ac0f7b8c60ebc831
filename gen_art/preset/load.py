"""`load_preset`: from a name, a path, `-` or a mapping to a validated Preset."""

import secrets
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from gen_art.errors import UsageError
from gen_art.preset.files import FOLDER
from gen_art.preset.model import friendly
from gen_art.preset.overrides import apply, fill_knobs, plain
from gen_art.preset.problems import Problem, dotted, preset_error
from gen_art.preset.reader import Node, SourceText, read_bytes, read_file
from gen_art.preset.shipped import find, presets_folder
from gen_art.preset.values import number

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["load_preset", "open_source", "validate"]

_ABOUT_KEYS = ("unknown", "is neither a key", "a name may not", "particle.attributes declares")  # shown at the key


def open_source(preset: str | Path) -> tuple[SourceText, str]:
    """Read a preset's text with positions; also its name."""
    if str(preset) == "-":
        return read_bytes(sys.stdin.buffer.read(1_000_000), "<stdin>"), "stdin"
    path = find(str(preset))
    shipped = path.is_relative_to(presets_folder())
    return read_file(path, path.name if shipped else str(preset)), path.stem


def load_preset(
    preset: "str | Path | Mapping[str, Any] | Preset",
    overrides: Mapping[str, Any] | None = None,
    seed: int | str | None = None,
) -> "Preset":
    """A validated Preset.

    preset : a shipped name ("fire"), a path, "-" for standard input, or a mapping as YAML would hold it, which
        may have a `name` too
    overrides : dotted paths ({"clock.fps": 60}) or nested mappings, which merge
    seed : a whole number, or "random" for a fresh one

    Raises PresetError with every problem and its place, UsageError for a name or path that leads nowhere, OutputError
    when the file cannot be read.
    """
    from gen_art.preset.schema import Preset

    folder = FOLDER.get()
    if isinstance(preset, Preset):
        source, name, data, folder = _nowhere("preset"), preset.name, preset.resolved(), preset.folder
    elif isinstance(preset, Mapping):
        data = plain(preset)
        source, name = _nowhere("preset"), str(data.pop("name", "preset"))
    else:
        source, name = open_source(preset)
        data = source.plain()
        folder = Path() if str(preset) == "-" else find(str(preset)).parent
    set_paths = apply(data, overrides) if overrides else []
    if seed is not None:
        data["seed"] = secrets.randbelow(2**31) if seed == "random" else seed
        set_paths.append(("seed",))
    token = FOLDER.set(folder)
    try:
        return validate(data, name, source, set_paths)
    finally:
        FOLDER.reset(token)


def validate(data: dict, name: str, source: SourceText, set_paths: list[tuple]) -> "Preset":
    """The Preset of plain data; PresetError with every problem, each where it stands in `source` or at its `--set`."""
    from gen_art.preset.checks import references, unbound
    from gen_art.preset.registered import GRAVITATION
    from gen_art.preset.schema import Preset

    filled, found = fill_knobs(data)
    written = {"version": filled.get("version"), "seed": filled.get("seed", 0), **filled}
    made, listed = None, found[:]
    token = GRAVITATION.set(_gravitation(filled))
    try:
        made = Preset.model_validate(filled).keep(name, written)
    except ValidationError as error:
        listed += [(item["loc"], friendly(item)) for item in error.errors()]
    finally:
        GRAVITATION.reset(token)
    listed += references(filled)
    if made is not None:
        listed += unbound(made)
    problems = source.problems + [_located(data, source, set_paths, path, text) for path, text in listed]
    problems = _distinct(problems)
    if problems or made is None:
        raise preset_error(problems)
    return made


def _gravitation(data: dict) -> float | None:
    """`units.G` where the preset gives it; what is wrong with it, the schema says."""
    units = data.get("units")
    with suppress(UsageError):
        return number(units["G"]) if isinstance(units, dict) and "G" in units else None
    return None


def _nowhere(name: str) -> SourceText:
    return SourceText(name, [], Node(0, 0))


def _located(data: dict, source: SourceText, set_paths: list[tuple], path: tuple, text: str) -> Problem:
    """A Problem at the parts of `path` that exist: short forms leave out names that the schema's path has."""
    node: Any = data
    real: list = []
    for depth, part in enumerate(path):
        if (isinstance(node, dict) and part in node) or (
            isinstance(node, list) and isinstance(part, int) and part < len(node)
        ):
            node = node[part]
            real.append(part)
        elif depth == len(path) - 1 and text == "is missing":
            text = f"'{part}' is missing"
    here = tuple(real)
    for set_path in set_paths:
        if here[: len(set_path)] == set_path or (set_path[: len(here)] == here and not source.holds(here)):
            return Problem(here, text, "--set")
        if set_path[: len(here)] == here:
            text += f" (with {dotted(set_path)} set)"
    if not source.lines:
        return Problem(here, text, source.name)
    return source.problem(here, text, at_key=text.startswith(_ABOUT_KEYS))


def _distinct(problems: list[Problem]) -> list[Problem]:
    """In the order of the text, one problem for a place: what follows from a first one is left out."""
    seen, kept = set(), []
    for problem in sorted(problems, key=lambda p: (p.line, p.column)):
        words = problem.text if problem.text.endswith("is missing") or not problem.line else ""
        key = (problem.path if words else (), problem.line, problem.column, words)
        if key not in seen:
            seen.add(key)
            kept.append(problem)
    return kept
