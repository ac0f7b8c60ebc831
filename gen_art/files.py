"""Files: output that appears whole under its name or not at all, and reading files that are regular and not too large."""

import contextlib
import hashlib
import os
import secrets
import stat
from collections.abc import Callable, Iterator
from functools import lru_cache, wraps
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO, TypeAlias, TypeVar

from gen_art.errors import OutputError, UsageError

__all__ = [
    "LARGEST_INPUT",
    "Stamp",
    "beside",
    "below",
    "cached_by_file",
    "check_input",
    "create",
    "replaces",
    "sha256",
    "stamp",
]

# O_NOFOLLOW and O_NONBLOCK do not exist on Windows, which has neither such links nor pipes in folders
_CREATE = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


Stamp: TypeAlias = tuple[int, int, int]
T = TypeVar("T")
LARGEST_INPUT = 2**30  # bytes of a file that is read; a grid of the most vectors has 0.4 GB


def below(folder: Path, name: str) -> Path:
    """The path of the file `name` in `folder` or below it. Raises UsageError for a name that leads elsewhere, also by a link."""
    parts = PurePosixPath(name.replace("\\", "/"))
    if not parts.parts or parts.is_absolute() or ".." in parts.parts or ":" in name or "\0" in name:
        raise UsageError(f"{name!r}: a preset's files must be in its own folder or below")
    place = folder / parts
    try:
        inside = place.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # links in a circle
        inside = False
    if not inside:
        raise UsageError(f"{name!r}: leads out of the preset's folder")
    return place


def check_input(path: Path) -> None:
    """Raise OutputError unless `path` is a regular file of at most LARGEST_INPUT bytes that exists."""
    try:
        found = os.stat(path)
    except (OSError, ValueError) as error:
        raise OutputError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error
    if not stat.S_ISREG(found.st_mode):
        raise OutputError(f"cannot read {path}: it is not a regular file")
    if found.st_size > LARGEST_INPUT:
        raise OutputError(f"cannot read {path}: it has {found.st_size:,} bytes; at most {LARGEST_INPUT:,} are read")


def sha256(path: Path) -> str:
    """Hex digest of a file. Raises OutputError when it cannot be read."""
    check_input(path)
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error


def stamp(path: Path) -> Stamp | None:
    """(time of the last change in ns, bytes, number on its disk) of a file: another one once it is saved. None without a file."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def cached_by_file(most: int) -> Callable[[Callable[..., T]], Callable[..., T]]:
    """Like `lru_cache(most)`, for a function whose first argument is a file's path; once the file is saved, it is read again."""

    def decorate(function: Callable[..., T]) -> Callable[..., T]:
        @lru_cache(most)
        def read(saved: Stamp | None, path: Path, *args: Any) -> T:
            return function(path, *args)

        @wraps(function)
        def cached(path: Path, *args: Any) -> T:
            return read(stamp(path), path, *args)

        return cached

    return decorate


def create(path: Path) -> BinaryIO:
    """A file that did not exist, open for reading and writing without a buffer. Raises FileExistsError for anything at `path`."""
    return os.fdopen(os.open(path, _CREATE, 0o666), "r+b", buffering=0)


def replaces(path: Path) -> OutputError:
    """The error for output that would replace what is at `path`."""
    return OutputError(f"{path} exists already; --overwrite replaces it")


@contextlib.contextmanager
def beside(path: Path, overwrite: bool = True) -> Iterator[Path]:
    """Yield a temporary file in the folder of `path`; it is renamed to `path` at the end, or removed after an error.

    Its name is random and the file is created by this call, so it is nobody else's, whatever lies in the folder.
    overwrite : replace what is at `path` by then; a link itself is replaced, not the file it leads to
    Raises OutputError when the operating system refuses (disk full, no permission).
    """
    temporary = path.with_name(f".gen-art-{secrets.token_hex(8)}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        create(temporary).close()
        yield temporary
        _rename(temporary, path, overwrite)
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _rename(temporary: Path, path: Path, overwrite: bool) -> None:
    if not overwrite:
        try:
            os.link(temporary, path)  # unlike a rename, it fails where something is
            return
        except FileExistsError:
            raise replaces(path) from None
        except OSError:  # a file system without hard links
            if os.path.lexists(path):
                raise replaces(path) from None
    os.replace(temporary, path)
