"""The token in the studio's address: kept in the user's cache folder, so that a page finds a studio that was started again."""

import os
import re
import secrets
from contextlib import suppress
from pathlib import Path

from gen_art.backend.runtime import cache_folder

__all__ = ["kept_token"]

_TOKEN = re.compile(r"[A-Za-z0-9_-]{32}")


def kept_token() -> str:
    """32 letters that only this user can read; new ones for each run where no folder can be written."""
    folder = cache_folder("cpu")
    if folder is None:
        return secrets.token_urlsafe(24)
    path = folder.parent / "studio-token"
    return _read(path) or _create(path)


def _read(path: Path) -> str | None:
    """The token of a file that nobody else can read; None if there is none."""
    with suppress(OSError, ValueError):
        text = path.read_text(encoding="ascii").strip()
        if _TOKEN.fullmatch(text) and (os.name == "nt" or not path.stat().st_mode & 0o077):
            return text
    return None


def _create(path: Path) -> str:
    token = secrets.token_urlsafe(24)
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:
            file.write(token)
    return token
