"""The partial film `NAME.partial.EXT`: its name, and its file, which is locked until the final film is whole.

It lies beside the final film. GIF and WebP are made from all frames at once, so their partial films are lossless Matroska:
`NAME.partial.gif.mkv` and `NAME.partial.webp.mkv`. No two films have the same one.
"""

import contextlib
import os
import stat
from pathlib import Path
from types import ModuleType

from gen_art.errors import OutputError
from gen_art.files import create

fcntl: ModuleType | None = None
with contextlib.suppress(ImportError):  # Windows has no fcntl: the file is then not locked
    import fcntl

__all__ = ["PartialFilm", "check_partial", "partial_path"]

# a pipe without a writer opens at once
_LOOK = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


def partial_path(path: Path) -> Path:
    """The path of the partial film of the film at `path`."""
    made_from_all = path.suffix.lower() in (".gif", ".webp")
    return path.with_name(f"{path.stem}.partial{path.suffix}{'.mkv' if made_from_all else ''}")


def check_partial(path: Path, overwrite: bool) -> None:
    """Raise OutputError when the partial film at `path` is being written, or exists (unless overwrite)."""
    with _existing(path) as old:
        _check(path, old, overwrite)


class PartialFilm:
    """The file of a partial film: created, locked, and removed only if it is still the one at its path.

    path : of the partial film
    file : open for reading and writing, without a buffer
    Raises OutputError when another render writes it, or when something is at the path (unless overwrite).
    """

    def __init__(self, path: Path, overwrite: bool):
        self.path = path
        while True:
            with contextlib.suppress(FileExistsError):
                self.file = create(path)
                break
            _remove_old(path, overwrite)
        if not _lock(self.file.fileno()):  # another render took the new file for an old one
            self.file.close()
            raise _busy(path)

    def remove(self) -> None:
        """Delete the file, but not another one that has taken its place."""
        if _is_at(self.file.fileno(), self.path):
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the file, which ends the lock."""
        self.file.close()


def _busy(path: Path) -> OutputError:
    return OutputError(f"{path} is being written by another render")


@contextlib.contextmanager
def _existing(path: Path):
    """The descriptor of the file at `path`; None for nothing, a link, or what cannot be opened."""
    try:
        old = os.open(path, _LOOK)
    except OSError:
        yield None
        return
    try:
        yield old
    finally:
        os.close(old)


def _check(path: Path, old: int | None, overwrite: bool) -> None:
    if old is not None and not _lock(old):
        raise _busy(path)
    if os.path.lexists(path) and not overwrite and not (old is not None and _is_empty(old)):
        raise OutputError(
            f"{path} exists already: it may be the film that an earlier render left when it was stopped; "
            "rename it, or --overwrite replaces it"
        )


def _remove_old(path: Path, overwrite: bool) -> None:
    """Remove what is at `path`. Of several processes that do so, one holds the lock of the file that it removes."""
    with _existing(path) as old:
        _check(path, old, overwrite)
        if old is None or _is_at(old, path):
            path.unlink(missing_ok=True)


def _lock(file: int) -> bool:
    """Lock an open file; False while another one holds the lock. A file system without locks locks nothing."""
    if fcntl is not None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            pass
    return True


def _is_empty(file: int) -> bool:
    """Whether it is a file without a byte, which a render leaves that is killed before its first segment."""
    found = os.fstat(file)
    return stat.S_ISREG(found.st_mode) and found.st_size == 0


def _is_at(file: int, path: Path) -> bool:
    """Whether the open file is the one at `path`."""
    try:
        return os.path.samestat(os.fstat(file), os.lstat(path))
    except OSError:
        return False
