"""Film files opened through FFmpeg. A name is always a file's: never a protocol, an address or a list of other files."""

from pathlib import Path
from typing import BinaryIO

import av

__all__ = ["open_film", "read_film"]

# the reader is chosen by the extension: by content, FFmpeg would also take a text that lists other files or addresses
_READERS = {".mp4": "mov", ".mov": "mov", ".webm": "matroska", ".mkv": "matroska", ".gif": "gif"}


def read_film(source: Path | BinaryIO, extension: str | None = None):
    """An open container of the film at a path, or of an open file with that file extension, which is read from its start."""
    if isinstance(source, Path):
        form = _READERS.get((extension or source.suffix).lower())
        return av.open(_name(source), format=form, options={"protocol_whitelist": "file"}, metadata_errors="replace")
    source.seek(0)
    return av.open(source, format=_READERS[extension or ""])


def open_film(target, muxer: str, recipe: str | None, options: dict[str, str]):
    """A container to write to a path or a file, with the recipe as its comment. Bit-exact: no dates or library versions."""
    place = _name(target) if isinstance(target, Path) else target
    container = av.open(place, "w", format=muxer, options={"fflags": "+bitexact", **options})
    if recipe is not None:
        container.metadata["comment"] = recipe
    return container


def _name(path: Path) -> str:
    """The path for FFmpeg, which would take the part before a colon for a protocol: `12:30.mp4`."""
    return f"file:{path}"
