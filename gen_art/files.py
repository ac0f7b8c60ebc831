"""Files: output that appears whole under its name or not at all, never through a link that waits there."""

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from gen_art.errors import OutputError

__all__ = ["beside", "create", "replaces"]

# O_NOFOLLOW and O_NONBLOCK do not exist on Windows, which has neither such links nor pipes in folders
_CREATE = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


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
