"""The preset that the studio edits: its text, the values set since, its problems, undo and redo, and its file.

A value that is set is known at once to the next picture; the text takes it over when the change is done (`settle`), because
writing YAML with its comments takes longer than a picture.
"""

from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gen_art.errors import GenArtError, OutputError, PresetError, UsageError
from gen_art.files import beside
from gen_art.output.input_tables import controls_paths, input_tables
from gen_art.preset.load import PresetSource
from gen_art.preset.reader import MAX_BYTES, read_text
from gen_art.preset.shipped import find, presets_folder
from gen_art.preset.writing import changed_text, text_without

if TYPE_CHECKING:
    from gen_art.output.input_tables import InputTable
    from gen_art.preset.schema import Preset

__all__ = ["LARGEST_TEXT", "Document"]

LARGEST_TEXT = MAX_BYTES  # of a preset
MOST_UNDO = 500


class Document:
    """A preset's text and what has been set in it.

    file : what it was read from
    path : the file that it is saved to; None where it is shipped
    preset : the last one that was valid
    problems : [{line, column, path, text}] of the text and values as they are now; empty if they are valid
    """

    def __init__(self, name: str):
        self.file = find(name)
        self.path: Path | None = None if self.file.is_relative_to(presets_folder()) else self.file
        source = PresetSource.of(name)
        self.name, self.folder = source.name, source.folder
        self.text = self.saved_text = "\n".join(source.text.lines)
        self._source = source
        self._overrides: dict[str, Any] = {}
        self._undone: list[str] = []
        self._done: list[str] = []
        self.problems: list[dict] = []
        self._is_readable = True
        self.preset: Preset = source.load()

    @property
    def data(self) -> dict:
        """The plain data as written, with the values set since, `$knobs` as they stand."""
        from gen_art.preset.overrides import apply

        data = self._source.text.plain()
        apply(data, self._overrides)
        return data

    @property
    def is_saved(self) -> bool:
        """Whether the file holds the text as it is."""
        return self.text == self.saved_text and not self._overrides

    @property
    def state(self) -> dict:
        """What the page shows of it."""
        return {
            "name": self.name, "text": self.text, "data": self.data, "problems": self.problems, "saved": self.is_saved,
            "file": None if self.path is None else self.path.name, "steers": bool(input_tables(self.preset)),
            "undo": bool(self._done), "redo": bool(self._undone),
            "knobs": {
                name: {
                    "value": knob.value, "unit": knob.unit,
                    "range": None if knob.range is None else [knob.range.lo, knob.range.hi],
                }
                for name, knob in self.preset.knobs.items()
            },
        }  # fmt: skip

    def set(self, values: dict[str, Any]) -> list[dict]:
        """Set values by dotted path; the problems that they have, with which nothing is set.

        `settle` takes them into the text. Raises UsageError while the text cannot be read.
        """
        self._check_readable()
        before, problems = dict(self._overrides), self.problems
        for path, value in values.items():
            self._overrides.pop(path, None)
            self._overrides[path] = value
        if self._load():
            return []
        found, self._overrides, self.problems = self.problems, before, problems
        return found

    def settle(self) -> bool:
        """Take the values that were set into the text; whether there were any."""
        if not self._overrides:
            return False
        self._check_readable()
        text, self._overrides = changed_text(self.text, self._overrides), {}
        return self.write(text)

    def _check_readable(self) -> None:
        if not self._is_readable:
            raise UsageError("the text cannot be read as YAML: mend it before a control changes it")

    def remove(self, path: str) -> bool:
        """Remove a key with what is below it; whether the preset is valid without."""
        self._check_readable()
        self.settle()
        return self.write(text_without(self.text, path))

    def write(self, text: str) -> bool:
        """Replace the text; whether it is valid. The text before can be undone to."""
        if len(text.encode("utf-8", "replace")) > LARGEST_TEXT:
            raise UsageError(f"a preset has at most {LARGEST_TEXT:,} bytes")
        if text != self.text:
            self._done = [*self._done, self.text][-MOST_UNDO:]
            self._undone = []
        return self._take(text)

    def undo(self) -> bool:
        """Go back to the text before; whether it is valid."""
        if self._is_readable:
            self.settle()
        if not self._done:
            return not self.problems
        self._undone.append(self.text)
        return self._take(self._done.pop())

    def redo(self) -> bool:
        """Take back an undo; whether the text is valid. After values that were set since, there is nothing to take back."""
        if self._is_readable:
            self.settle()
        if not self._undone:
            return not self.problems
        self._done.append(self.text)
        return self._take(self._undone.pop())

    def reload(self) -> bool:
        """Read the file again, as it was changed elsewhere; whether it is valid. Raises OutputError if it is gone."""
        text = self._on_disk()
        if text == self.saved_text:  # it was saved from here, or only a file that it names has changed
            return self._take(self.text) if not self._overrides else self._load()
        self.saved_text = text
        self._overrides = {}
        return self.write(text)

    def _on_disk(self) -> str:
        try:
            return self.file.read_text(encoding="utf-8-sig")
        except (OSError, ValueError) as error:
            raise OutputError(f"cannot read {self.file.name}: {getattr(error, 'strerror', None) or error}") from error

    def save(self) -> Path:
        """Write the text to its file. Raises UsageError for a shipped preset, or while there are problems."""
        if self._is_readable:
            self.settle()
        path = self._own_path()
        if self.problems:
            raise UsageError("the preset has problems; correct them before it is saved")
        if path.is_file() and self._on_disk() not in (self.saved_text, self.text):
            raise UsageError(f"{path.name} was changed elsewhere and is not read again yet: save once more in a moment")
        with beside(path, True) as temporary:
            temporary.write_text(self.text, encoding="utf-8")
        self.saved_text = self.text
        return path

    def keep_inputs(self, tables: Sequence["InputTable"]) -> list[str]:
        """Write what was steered as .csv files beside the preset, and let its text name them; the names.

        The preset's own file stays as it is until `save`. Raises UsageError as `save` does, or where nothing was steered.
        """
        self._check_readable()
        self.settle()
        path = self._own_path()
        if not tables or len(tables[0].rows) < 2:
            raise UsageError("nothing was steered yet")
        paths = [controls_paths(self.data, table) for table in tables]
        names = _free_names(path, [table.kind.name for table in tables])
        for name, table in zip(names, tables):
            with beside(path.with_name(name), False) as temporary:
                temporary.write_text(table.text(), encoding="utf-8")
        if problems := self.set({key: name for name, keys in zip(names, paths) for key in keys}):
            raise UsageError("; ".join(one["text"] for one in problems))
        self.settle()
        return names

    def _own_path(self) -> Path:
        if self.path is None:
            raise UsageError(
                f"'{self.name}' is a preset of gen-art and cannot be saved: `gen-art new mine --from {self.name}` makes a copy "
                "of your own"
            )
        return self.path

    def _take(self, text: str) -> bool:
        self.text, self._overrides = text, {}
        self._is_readable = False
        try:
            parsed = read_text(text, f"{self.name}.yaml")
        except PresetError as error:
            self.problems = _listed(error)
            return False
        self._is_readable = not parsed.problems
        self._source = PresetSource(self.name, parsed, self.folder, parsed.plain())
        return self._load()

    def _load(self) -> bool:
        try:
            self.preset = self._source.load(self._overrides)
        except GenArtError as error:
            self.problems = _listed(error)
            return False
        self.problems = []
        return True


def _free_names(path: Path, kinds: Sequence[str]) -> list[str]:
    """Names of tables beside a preset that do not exist yet, of one number: flight_aircraft_1.csv."""
    parts = [kind if kinds.count(kind) == 1 else f"{kind}_{chr(ord('a') + k)}" for k, kind in enumerate(kinds)]
    for number in count(1):
        names = [f"{path.stem}_{part}_{number}.csv" for part in parts]
        if not any(path.with_name(name).exists() for name in names):
            break
    return names


def _listed(error: GenArtError) -> list[dict]:
    found: Sequence = getattr(error, "problems", None) or ()
    if not found:
        return [{"line": 0, "column": 0, "path": "", "text": str(error)}]
    from gen_art.preset.problems import dotted

    return [{"line": p.line, "column": p.column, "path": dotted(p.path), "text": p.text} for p in found]
