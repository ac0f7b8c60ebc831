"""`load_preset`: a validated Preset from a name, a path, `-` or a mapping. `PresetSource` is read once and loaded many times."""

import os
import secrets
import sys
from collections.abc import Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass
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
from gen_art.preset.values import number, shown

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["PresetSource", "load_preset", "open_source", "validate"]

# beginnings of problems that are shown at the key, not at the value
_KEY_PROBLEMS = ("unknown", "is neither a key", "a name may not", "particle.attributes declares")


def open_source(preset: str | Path) -> tuple[SourceText, str]:
    """(text of a preset with positions, name of the preset)."""
    if str(preset) == "-":
        if sys.stdin is None:
            raise UsageError("the preset is to be read from standard input, which is closed")
        return read_bytes(sys.stdin.buffer.read(1_000_000), "<stdin>"), "stdin"
    path = find(str(preset))
    shipped = path.is_relative_to(presets_folder())
    return read_file(path, path.name if shipped else str(preset)), path.stem


@dataclass(frozen=True)
class PresetSource:
    """What a preset is read from, read once, so that it can be loaded many times with other values.

    text : its lines and their places
    folder : of the files that it names
    written : its plain data before overrides and knobs are filled in
    """

    name: str
    text: SourceText
    folder: Path
    written: dict

    @classmethod
    def of(cls, preset: "str | Path | Mapping[str, Any] | Preset | PresetSource") -> "PresetSource":
        """The source of a preset: what `load_preset` takes. Raises its errors."""
        from gen_art.preset.schema import Preset

        if isinstance(preset, PresetSource):
            return preset
        if not isinstance(preset, (str, os.PathLike, Mapping, Preset)):
            raise UsageError(f"a preset is a name, a path, a mapping or a Preset, not {shown(preset)}")
        if isinstance(preset, Preset):
            return cls(preset.name, _nowhere("preset"), preset.folder, preset.resolved())
        if isinstance(preset, Mapping):
            data = plain(preset)
            return cls(str(data.pop("name", "preset")), _nowhere("preset"), FOLDER.get(), data)
        text, name = open_source(preset)
        return cls(name, text, Path() if str(preset) == "-" else find(str(preset)).parent, text.plain())

    def load(self, overrides: Mapping[str, Any] | None = None, seed: int | str | None = None) -> "Preset":
        """The validated Preset; the arguments are those of `load_preset`."""
        if overrides is not None and not isinstance(overrides, Mapping):
            raise UsageError(f"overrides must be a mapping of paths to values, not {shown(overrides)}")
        data = deepcopy(self.written)
        set_paths = apply(data, overrides) if overrides else []
        if seed is not None:
            data["seed"] = secrets.randbelow(2**31) if isinstance(seed, str) and seed == "random" else plain(seed)
            set_paths.append(("seed",))
        token = FOLDER.set(self.folder)
        try:
            return validate(data, self.name, self.text, set_paths)
        finally:
            FOLDER.reset(token)


def load_preset(
    preset: "str | Path | Mapping[str, Any] | Preset",
    overrides: Mapping[str, Any] | None = None,
    seed: int | str | None = None,
) -> "Preset":
    """A validated Preset.

    preset : a shipped name ("fire"), a path, "-" for standard input, or a mapping as in YAML, which may also have a `name`
    overrides : dotted paths ({"clock.fps": 60}) or nested mappings, which are merged
    seed : a whole number, or "random" for a random one

    Raises PresetError with every problem and its place, UsageError for a name or path that does not exist, OutputError
    when the file cannot be read.
    """
    return PresetSource.of(preset).load(overrides, seed)


def validate(data: dict, name: str, source: SourceText, set_paths: list[tuple]) -> "Preset":
    """The Preset of plain data. Raises PresetError with every problem and its place in `source` or its `--set`."""
    from gen_art.preset.expect import unknown_quantities
    from gen_art.preset.labels import too_wide
    from gen_art.preset.references import references, unbooked, unbound
    from gen_art.preset.registered import GRAVITATION
    from gen_art.preset.schema import Preset

    filled, knobs, found = fill_knobs(data)
    written = {"version": filled.get("version"), "seed": filled.get("seed", 0), **filled}
    preset = None
    token = GRAVITATION.set(_gravitation(filled))
    try:
        preset = Preset.model_validate(filled).keep(name, source.title, written, knobs)
    except ValidationError as error:
        found += [(item["loc"], friendly(item)) for item in error.errors()]
    finally:
        GRAVITATION.reset(token)
    found += references(filled)
    if preset is not None:
        found += [*unbound(preset), *unbooked(preset), *unknown_quantities(preset), *too_wide(preset)]
    problems = source.problems + [_located(data, source, set_paths, path, text) for path, text in found]
    problems = _distinct(problems)
    if problems or preset is None:
        raise preset_error(problems)
    return preset


def _gravitation(data: dict) -> float | None:
    """`units.G` of the preset, or None; the schema reports problems with it."""
    units = data.get("units")
    with suppress(UsageError):
        return number(units["G"]) if isinstance(units, dict) and "G" in units else None
    return None


def _nowhere(name: str) -> SourceText:
    return SourceText(name, [], Node(0, 0))


def _located(data: dict, source: SourceText, set_paths: list[tuple], path: tuple, text: str) -> Problem:
    """A Problem at the parts of `path` that exist in the data: a short form leaves out names of the schema's path."""
    node: Any = data
    existing: list = []
    for depth, part in enumerate(path):
        if (isinstance(node, dict) and part in node) or (
            isinstance(node, list) and isinstance(part, int) and part < len(node)
        ):
            node = node[part]
            existing.append(part)
        elif depth == len(path) - 1 and text == "is missing":
            text = f"'{part}' is missing"
    here = tuple(existing)
    for set_path in set_paths:
        if here[: len(set_path)] == set_path or (set_path[: len(here)] == here and not source.holds(here)):
            return Problem(here, text, "--set")
        if set_path[: len(here)] == here:
            text += f" (with {dotted(set_path)} set)"
    if not source.lines:
        return Problem(here, text, source.name)
    return source.problem(here, text, at_key=text.startswith(_KEY_PROBLEMS))


def _distinct(problems: list[Problem]) -> list[Problem]:
    """The problems in the order of the text, one for each place: further ones there usually follow from the first."""
    seen, kept = set(), []
    for problem in sorted(problems, key=lambda p: (p.line, p.column)):
        words = problem.text if problem.text.endswith("is missing") or not problem.line else ""
        key = (problem.path if words else (), problem.line, problem.column, words)
        if key not in seen:
            seen.add(key)
            kept.append(problem)
    return kept
