"""The files that a picture of a preset depends on, found also while the preset is wrong or a file is missing."""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from gen_art.errors import GenArtError
from gen_art.files import Stamp, below, stamp
from gen_art.preset.reader import read_file

__all__ = ["dependencies"]


def dependencies(
    preset: Path, overrides: Mapping[str, Any] | None = None, plugins: Iterable[Path] = ()
) -> dict[Path, Stamp | None]:
    """The stamp of each file, None if it does not exist: the preset's, those that its texts could name, and the plugins.

    The stamps are from before the preset is read, so a file that is saved while a picture is made has another one afterwards.
    """
    stamps = {path: stamp(path) for path in (preset, *plugins)}
    texts: list[str] = list(_texts(overrides or {}))
    with contextlib.suppress(GenArtError):  # the preset cannot be read, and only its own file can change that
        texts += _texts(read_file(preset).plain())
    for text in dict.fromkeys(texts):
        if (file := _file(preset.parent, text)) is not None:
            stamps.setdefault(file, stamp(file))
    return stamps


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from _texts(item)


def _file(folder: Path, text: str) -> Path | None:
    """The file that a preset in this folder names by the text; None for text that can be no file's name."""
    suffix = Path(text).suffix[1:]
    if not suffix.isalnum() or suffix.isdigit() or not text.isprintable():
        return None
    with contextlib.suppress(GenArtError, OSError, ValueError):
        return below(folder, text)
    return None
