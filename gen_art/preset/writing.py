"""Writes presets as YAML text: an existing text with some values changed, or plain data."""

import io
from collections.abc import Mapping
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from gen_art.errors import UsageError
from gen_art.preset.overrides import apply, split_path

__all__ = ["changed_text", "text_without", "yaml_text"]

_WIDTH = 100_000  # so that no line of the author's is broken
_SHORT = 100  # mappings and lists up to this many characters are written on one line


def _yaml() -> YAML:
    yaml = YAML()
    yaml.brace_single_entry_mapping_in_flow_sequence = True  # [{box: 1}, ...] stays as it was written
    yaml.preserve_quotes = True
    yaml.width = _WIDTH
    yaml.indent(mapping=2, sequence=4, offset=2)
    return yaml


def _written(data) -> str:
    out = io.StringIO()
    _yaml().dump(data, out)
    return out.getvalue()


def changed_text(text: str, overrides: Mapping[str, Any]) -> str:
    """The text of a valid preset with values set (by dotted paths, as in `--set`); comments, order and layout stay.

    Raises UsageError for a path that does not exist.
    """
    data = _yaml().load(text)
    apply(data, {path: _laid_out(value) for path, value in overrides.items()}, convert=False)
    return _written(data)


def text_without(text: str, path: str) -> str:
    """The text of a preset without the key at a dotted path and what is below it; the rest stays as it is.

    Raises UsageError for a path that does not exist.
    """
    data = _yaml().load(text)
    *parents, last = split_path(path)
    node = data
    try:
        for part in parents:
            node = node[part]
        del node[last]
    except (KeyError, IndexError, TypeError):
        raise UsageError(f"{path} is not in the preset") from None
    return _written(data)


def yaml_text(data: Mapping[str, Any]) -> str:
    """Plain data as YAML, with short mappings and lists on one line."""
    out = CommentedMap()
    for key, value in data.items():
        out[key] = _laid_out(value)
    return _written(out)


def _laid_out(value: Any) -> Any:
    if isinstance(value, Mapping):
        node: Any = CommentedMap((key, _laid_out(item)) for key, item in value.items())
    elif isinstance(value, (list, tuple)):
        node = CommentedSeq(_laid_out(item) for item in value)
    else:
        return value
    if len(str(value)) <= _SHORT:
        node.fa.set_flow_style()
    return node
