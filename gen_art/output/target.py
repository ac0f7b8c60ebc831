"""Where output goes: what an ending means, what may be written, and writing beside the final name."""

import contextlib
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from gen_art.errors import OutputError, UsageError
from gen_art.registry import suggest

__all__ = ["FILMS", "STILLS", "Target", "beside", "find_target"]

STILLS = (".png", ".jpg", ".jpeg", ".webp")
FILMS = (".mp4", ".gif", ".webp")
_LATER = (".mov", ".webm", ".exr")
_TRANSPARENT = (".png", ".webp")


@dataclass(frozen=True)
class Target:
    """A file, or a pattern with a run of # for the frame's number."""

    path: Path
    moving: bool
    pattern: bool

    @property
    def ending(self) -> str:
        return self.path.suffix.lower()

    def frame(self, k: int) -> Path:
        """The path of frame k of a pattern."""
        name = re.sub(r"#+", lambda run: f"{k:0{len(run[0])}d}", self.path.name, count=1)
        return self.path.with_name(name)


def find_target(out, *, moving: bool, name: str = "", seed: int = 0, size=None, transparent: bool = False) -> Target:
    """What `out` asks for. {preset} and {seed} are filled in.

    Raises UsageError for an ending that is unknown or cannot hold what is asked, and for an odd size where colour is halved.
    """
    text = str(out)
    if text in ("", "-"):
        raise UsageError("output is a file: give -o a path")
    path = Path(text.replace("{preset}", name).replace("{seed}", str(seed)))
    pattern = moving and "#" in path.name
    ending = path.suffix.lower()
    known = STILLS if pattern or not moving else tuple(dict.fromkeys(FILMS + STILLS))
    if ending not in known:
        if ending in _LATER:
            raise UsageError(f"{path.name}: '{ending}' is not available yet; there are {' '.join(known)}")
        what = (
            f"'{ending}' is no ending of a {'film or picture' if moving else 'picture'}" if ending else "has no ending"
        )
        raise UsageError(f"{path.name}: {what}{suggest(ending, known) if ending else ''}; there are {' '.join(known)}")
    is_film = moving and not pattern and ending in FILMS
    if transparent and ending not in _TRANSPARENT:
        raise UsageError(f"{path.name}: '{ending}' cannot be transparent; {' and '.join(_TRANSPARENT)} can")
    if size is not None and is_film and ending == ".mp4":
        check_even(size)
    if size is not None and ending == ".webp" and max(size) > 16383:
        raise UsageError(f"{path.name}: a WebP picture is at most 16383 pixels wide and high, not {size[0]}x{size[1]}")
    return Target(path, is_film, pattern)


def check_even(size) -> None:
    """UsageError, with the nearest sizes, unless both sides are even (yuv420p halves colour)."""
    width, height = size
    if width % 2 or height % 2:
        low = max(2, width - width % 2), max(2, height - height % 2)
        high = width + width % 2, height + height % 2
        raise UsageError(
            f"H.264 in yuv420p needs an even width and height, not {width}x{height}; "
            f"the nearest are {low[0]}x{low[1]} and {high[0]}x{high[1]}"
        )


def check_writable(paths, overwrite: bool) -> None:
    """OutputError for a file that exists (unless overwrite), a directory, or a folder that cannot be written."""
    for path in paths:
        if path.is_dir():
            raise OutputError(f"{path} is a directory")
        if path.exists() and not overwrite:
            raise OutputError(f"{path} exists already; --overwrite replaces it")
    for folder in {path.parent for path in paths}:
        first = folder
        while not first.exists() and first != first.parent:
            first = first.parent
        if not first.is_dir():
            raise OutputError(f"{first} is not a folder")
        if not os.access(first, os.W_OK | os.X_OK):
            raise OutputError(f"no permission to write in {first}")


@contextlib.contextmanager
def beside(path: Path) -> Iterator[Path]:
    """A temporary name beside `path`; renamed to it at the end, removed when something fails.

    Raises OutputError for what the system refuses (disk full, no permission).
    """
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
