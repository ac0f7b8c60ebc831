"""The output path: its format by file extension, and whether it may be written."""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gen_art.errors import OutputError, UsageError
from gen_art.files import replaces
from gen_art.output.formats import EXTENSIONS, Format, check_film_size, find_format
from gen_art.registry import suggest

__all__ = ["FILMS", "STILLS", "Target", "check_size_of", "check_writable", "find_target"]

FILMS = EXTENSIONS
STILLS: Mapping[str, tuple[int, ...]] = {  # extension -> bits a channel, the default first
    ".png": (8, 16),
    ".jpg": (8,),
    ".jpeg": (8,),
    ".webp": (8,),
    ".exr": (16, 32),
}
_TRANSPARENT = (".png", ".webp", ".exr")


@dataclass(frozen=True)
class Target:
    """An output file, or a pattern in which a run of # stands for the frame's number.

    film : the film's format; None for pictures
    bits : bits a channel
    """

    path: Path
    pattern: bool
    film: Format | None
    bits: int

    @property
    def moving(self) -> bool:
        """Whether it is a film."""
        return self.film is not None

    @property
    def halved(self) -> bool:
        """Whether the width and height must be even."""
        return self.film is not None and self.film.halved

    @property
    def extension(self) -> str:
        return self.path.suffix.lower()

    def frame(self, k: int) -> Path:
        """The path of frame k of a pattern."""
        name = re.sub(r"#+", lambda run: f"{k:0{len(run[0])}d}", self.path.name, count=1)
        return self.path.with_name(name)


def find_target(
    out, *, moving: bool, name: str = "", seed: int = 0, transparent: bool = False, codec: str | None = None,
    profile: str | None = None, bits: int | None = None,
) -> Target:  # fmt: skip
    """The Target of the path `out`, in which {preset} and {seed} are replaced by `name` and `seed`.

    moving : whether it may be a film or a pattern
    codec, profile, bits : see gen_art.output.formats
    Raises UsageError for an extension that is unknown or does not support the other options.
    """
    text = str(out)
    if text in ("", "-"):
        raise UsageError("output is a file: give -o a path")
    if "\0" in text:
        raise UsageError("the name of an output file cannot contain the character 0")
    if "{preset}" in text and not _is_name(name):
        raise UsageError(
            f"{{preset}}: the preset's name {name!r} cannot be part of a path; write a name in place of {{preset}}"
        )
    path = Path(text.replace("{preset}", name).replace("{seed}", str(seed)))
    pattern = moving and "#" in path.name
    extension = path.suffix.lower()
    known = tuple(STILLS) if pattern or not moving else tuple(dict.fromkeys((*FILMS, *STILLS)))
    if extension not in known:
        problem = "the file name has no extension"
        if extension:
            kind = "a film or picture" if moving else "a picture"
            problem = f"'{extension}' is not {kind} extension{suggest(extension, known)}"
        raise UsageError(f"{path.name}: {problem}; there are {' '.join(known)}")
    if moving and not pattern and extension in FILMS:
        film = find_format(path, codec=codec, profile=profile or "web", bits=bits, transparent=transparent)
        return Target(path, False, film, film.bits)
    if codec is not None or profile is not None:
        raise UsageError(f"{path.name}: codec and profile are options for films; {' '.join(FILMS)} are films")
    depths = STILLS[extension]
    if bits is not None and bits not in depths:
        others = " and ".join(f"{e} {' or '.join(map(str, d))}" for e, d in STILLS.items() if len(d) > 1)
        raise UsageError(f"{path.name}: a picture has 8 bits a channel, {others}; not {bits}")
    if transparent and extension not in _TRANSPARENT:
        raise UsageError(f"{path.name}: '{extension}' cannot be transparent; {' '.join(_TRANSPARENT)} can")
    return Target(path, pattern, None, bits or depths[0])


def _is_name(text: str) -> bool:
    """Whether a name from a file is the name of one file or folder, and no path, pattern or placeholder."""
    return (
        bool(text)
        and text.isprintable()
        and text[0] != "."
        and not set(text) & set('/\\:*?"<>|#{}')
        and len(text) < 200
    )


def check_size_of(target: Target, size) -> None:
    """Raise UsageError for a size that the target's format cannot have."""
    if target.film is not None:
        check_film_size(target.film, size)
    elif target.extension == ".webp" and max(size) > 16383:
        raise UsageError(
            f"{target.path.name}: a WebP picture is at most 16383 pixels wide and high, not {size[0]}x{size[1]}"
        )


def check_writable(paths, overwrite: bool) -> None:
    """Raise OutputError for a file that exists (unless overwrite), a directory, or a folder that cannot be written."""
    for path in paths:
        if path.is_dir():
            raise OutputError(f"{path} is a directory")
        if os.path.lexists(path) and not overwrite:
            raise replaces(path)
    for folder in {path.parent for path in paths}:
        first = folder
        while not os.path.lexists(first) and first != first.parent:
            first = first.parent
        if not first.is_dir():
            raise OutputError(f"{first} is not a folder")
        if not os.access(first, os.W_OK | os.X_OK):
            raise OutputError(f"no permission to write in {first}")
