"""Reads YAML text to plain data, with the line and column of every key and value.

The parser's events are composed here one by one. No object is constructed from a tag, depth and size are limited while
scanning, aliases count with their expanded size, and all problems of a file are collected.
"""

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

from ruamel.yaml import YAML
from ruamel.yaml import events as yaml_events
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.scanner import Scanner, ScannerError

from gen_art.errors import GenArtError, OutputError
from gen_art.preset.problems import Problem, preset_error

__all__ = ["SourceText", "read_bytes", "read_file", "read_text", "read_value", "MAX_BYTES", "MAX_DEPTH", "MAX_VALUES"]

MAX_BYTES = 500_000
MAX_DEPTH = 40
MAX_VALUES = 10_000

_LINE_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_WORDS: dict[str, bool | None] = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
_WORDS |= dict.fromkeys(("true", "True", "TRUE"), True) | dict.fromkeys(("false", "False", "FALSE"), False)


@dataclass(slots=True)
class Node:
    """A value with its place.

    line, column : where it starts, counted from 0
    value : a dict or list of Nodes, or a plain value
    keys : line and column of each key of a mapping
    size : number of values inside
    """

    line: int
    column: int
    value: object = None
    keys: dict[str, tuple[int, int]] = field(default_factory=dict)
    size: int = 1

    def plain(self):
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value


@dataclass(slots=True)
class SourceText:
    """The text of a preset, as nodes with their places.

    name : of the file
    lines : the text's lines
    root : the whole as a Node
    problems : those found while reading
    """

    name: str
    lines: list[str]
    root: Node
    problems: list[Problem] = field(default_factory=list)

    @property
    def title(self) -> str:
        """The comment in the first line; "" where there is none."""
        first = self.lines[0] if self.lines else ""
        return first.lstrip("# ").strip() if first.startswith("#") else ""

    def plain(self):
        return self.root.plain()

    def holds(self, path: tuple) -> bool:
        """Whether the text has a value at `path`."""
        node = self.root
        for part in path:
            if not (isinstance(node.value, dict) and part in node.value) and not (
                isinstance(node.value, list) and isinstance(part, int) and part < len(node.value)
            ):
                return False
            node = node.value[part]
        return True

    def problem(self, path: tuple, text: str, at_key: bool = False) -> Problem:
        """A Problem at the value of `path`, or at its key; if the path does not exist, at the part of it that does."""
        node, place = self.root, (self.root.line, self.root.column)
        for depth, part in enumerate(path):
            last = depth == len(path) - 1
            if isinstance(node.value, dict) and part in node.value:
                key, node = node.keys[part], node.value[part]
                place = key if (last and at_key) or isinstance(node.value, dict) else (node.line, node.column)
            elif isinstance(node.value, list) and isinstance(part, int) and part < len(node.value):
                node = node.value[part]
                place = (node.line, node.column)
        return self.at(place, path, text)

    def at(self, place: tuple[int, int], path: tuple, text: str) -> Problem:
        line, column = place
        shown = self.lines[line] if line < len(self.lines) else ""
        return Problem(path, text, self.name, line + 1, column + 1, shown)


class _Unreadable(Exception):
    """Reading cannot go on; the message is the problem."""


class _BoundedScanner(Scanner):
    """Refuses deep nesting while scanning, before the parser spends time on it."""

    def fetch_flow_collection_start(self, *args, **kwargs):
        if len(self.flow_context) >= MAX_DEPTH:
            raise ScannerError(None, None, f"nested more than {MAX_DEPTH} levels deep", self.reader.get_mark())
        return super().fetch_flow_collection_start(*args, **kwargs)

    def add_indent(self, column):
        if len(self.indents) > 2 * MAX_DEPTH:
            raise ScannerError(None, None, f"nested more than {MAX_DEPTH} levels deep", self.reader.get_mark())
        return super().add_indent(column)


def read_file(path: Path, name: str | None = None) -> SourceText:
    """Read a preset file. Raises OutputError when it cannot be read, PresetError when it is not text."""
    try:
        if path.is_dir():
            raise OutputError(f"{name or path}: is a folder, not a preset file")
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise OutputError(f"{name or path}: no such file") from None
    except GenArtError:
        raise
    except (OSError, ValueError) as error:
        raise OutputError(f"{name or path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    return read_bytes(data, name or str(path))


def read_bytes(data: bytes, name: str) -> SourceText:
    """Decode and read. Raises PresetError for data that is too large or not UTF-8 text."""
    if len(data) > MAX_BYTES:
        raise preset_error([Problem((), f"is larger than {MAX_BYTES // 1000} KB: not a preset", name)])
    try:
        text = data.decode("utf-8-sig")
        if "\0" in text:
            raise ValueError
    except ValueError:  # also UnicodeDecodeError
        raise preset_error([Problem((), "is not a text file (a preset is YAML in UTF-8)", name)]) from None
    return read_text(text, name)


def read_text(text: str, name: str) -> SourceText:
    """Read YAML text. Raises PresetError for syntax errors; other problems are collected in `.problems`."""
    source = _compose(text, name)
    if source.root.value is None and not source.problems:
        raise preset_error([Problem((), "is empty: a preset starts with `version: 1`", name)])
    if not isinstance(source.root.value, dict):
        problem = source.at(
            (source.root.line, source.root.column), (), "a preset is a mapping of keys: `version: 1`, ..."
        )
        raise preset_error([*source.problems, problem])
    return source


def read_value(text: str, name: str):
    """One YAML value, as in `--set`; a leading # begins a colour here, not a comment."""
    if text.lstrip().startswith("#"):
        return text.strip()
    source = _compose(text, name)
    if source.problems:
        raise preset_error(source.problems)
    return source.plain()


def _compose(text: str, name: str) -> SourceText:
    source = SourceText(name, _LINE_BREAK.split(text), Node(0, 0))
    composer = _Composer(source)
    yaml = YAML(typ="safe", pure=True)
    yaml.Scanner = _BoundedScanner
    try:
        for event in yaml.parse(text):
            composer.take(event)
    except _Unreadable as error:
        raise preset_error([*source.problems, source.at(composer.place, (), str(error))]) from None
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = (mark.line, mark.column) if mark else (0, 0)
        raise preset_error([*source.problems, source.at(place, (), _syntax(error))]) from None
    except YAMLError as error:
        before = text[: getattr(error, "position", 0)]
        place = (before.count("\n"), len(before) - before.rfind("\n") - 1)
        raise preset_error([source.at(place, (), "not YAML: a character that is not allowed in text")]) from None
    return source


def _syntax(error: MarkedYAMLError) -> str:
    words = " ".join(str(error.problem or "cannot be read as YAML").split())
    if "nested more than" in words:
        return words
    context = " ".join(str(error.context or "").split())
    return f"not YAML: {context + ': ' if context else ''}{words}"


class _Composer:
    """Builds nodes from parser events, on an explicit stack instead of by recursion."""

    def __init__(self, source: SourceText):
        self.source = source
        self.stack: list[tuple[Node, str | None]] = []  # open collections; of a mapping the key whose value comes next
        self.anchors: dict[str, Node] = {}
        self.open_anchors: list[str | None] = []
        self.documents = 0
        self.total = 0
        self.place = (0, 0)

    def take(self, event) -> None:
        mark = event.start_mark
        self.place = (mark.line, mark.column)
        if isinstance(event, yaml_events.DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                raise _Unreadable("a preset file must have one document; `---` starts a second one")
        elif isinstance(event, yaml_events.ScalarEvent):
            self._refuse_tag(event)
            self._add(Node(*self.place, self._scalar(event)), event.anchor)
        elif isinstance(event, (yaml_events.MappingStartEvent, yaml_events.SequenceStartEvent)):
            self._refuse_tag(event)
            if len(self.stack) >= MAX_DEPTH:
                raise _Unreadable(f"nested more than {MAX_DEPTH} levels deep")
            self._open(Node(*self.place, {} if isinstance(event, yaml_events.MappingStartEvent) else []), event.anchor)
        elif isinstance(event, (yaml_events.MappingEndEvent, yaml_events.SequenceEndEvent)):
            self._close()
        elif isinstance(event, yaml_events.AliasEvent):
            self._alias(event.anchor)

    def _path(self) -> tuple:
        return tuple(
            key if isinstance(node.value, dict) else len(node.value)  # type: ignore[arg-type]
            for node, key in self.stack
            if key is not None or isinstance(node.value, list)
        )

    def _add_problem(self, text: str, path: tuple | None = None) -> None:
        self.source.problems.append(self.source.at(self.place, self._path() if path is None else path, text))
        if len(self.source.problems) > 100:
            raise _Unreadable("too many problems to go on")

    def _refuse_tag(self, event) -> None:
        if event.tag is not None:
            self._add_problem(f"YAML tags are not allowed here ({str(event.tag)[:40]}); write the plain value")

    def _scalar(self, event):
        text = event.value
        if event.style is not None:  # quoted or a block: always text
            return text
        if text in _WORDS:
            return _WORDS[text]
        if _INTEGER.fullmatch(text):
            return int(text) if len(text) <= 300 else math.inf
        if _FLOAT.fullmatch(text):
            return float(text)
        if _NOT_FINITE.fullmatch(text):
            self._add_problem(f"must be a finite number, not {text}")
            return 1.0
        return text

    def _count(self, size: int) -> None:
        self.total += size
        if self.total > MAX_VALUES:
            raise _Unreadable(f"has more than {MAX_VALUES:,} values with aliases expanded: not a preset")

    def _alias(self, anchor: str) -> None:
        if anchor in self.open_anchors:
            raise _Unreadable(f"the alias *{anchor} is inside its own anchor")
        node = self.anchors.get(anchor)
        if node is None:
            raise _Unreadable(f"the alias *{anchor} has no anchor &{anchor} before it")
        self._add(node, None)

    def _add(self, node: Node, anchor: str | None) -> None:
        self._count(node.size)
        if anchor:
            self.anchors[anchor] = node
        if not self.stack:
            self.source.root = node
            return
        parent, key = self.stack[-1]
        if isinstance(parent.value, list):
            parent.value.append(node)
        elif key is None:
            self._key(parent, node)
            return
        else:
            parent.value[key] = node  # type: ignore[index]
            self.stack[-1] = (parent, None)
        parent.size += node.size

    def _key(self, parent: Node, node: Node) -> None:
        if isinstance(node.value, (dict, list)):
            raise _Unreadable("a key must be a word")
        key = _key_text(node.value)
        if key in parent.keys:
            line = parent.keys[key][0] + 1
            self._add_problem(f"the key is given twice (first in line {line})", (*self._path(), key))
        else:
            parent.keys[key] = self.place
        self.stack[-1] = (parent, key)

    def _open(self, node: Node, anchor: str | None) -> None:
        if self.stack and isinstance(self.stack[-1][0].value, dict) and self.stack[-1][1] is None:
            raise _Unreadable("a key must be a word")
        self._count(1)
        self.stack.append((node, None))
        self.open_anchors.append(anchor)

    def _close(self) -> None:
        node, _ = self.stack.pop()
        anchor = self.open_anchors.pop()
        self.total -= node.size  # its values were counted already; _add counts the whole node
        self._add(node, anchor)


def _key_text(value) -> str:
    if value is None:
        return "null"
    return str(value).lower() if isinstance(value, bool) else str(value)
