"""Taichi's errors about a user's kernel methods, as one sentence."""

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path

from taichi.lang.exception import TaichiCompilationError

from gen_art.errors import UsageError

__all__ = ["as_sentences"]

_PACKAGE = str(Path(__file__).resolve().parents[1])
_PLACE = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+), in (?P<function>\w+):\n(?P<code>[^\n]*)')


@contextlib.contextmanager
def as_sentences() -> Iterator[None]:
    """Turn an error in a user's function that a kernel of Gen Art calls into a UsageError that names its line."""
    try:
        yield
    except TaichiCompilationError as error:
        text = str(error)
        places = list(_PLACE.finditer(text))
        if not places or not places[0]["file"].startswith(_PACKAGE) or places[-1]["file"].startswith(_PACKAGE):
            raise
        place, reason = places[-1], " ".join(text.strip().splitlines()[-1].split())
        raise UsageError(
            f"{place['function']} cannot be compiled: {reason} ({place['file']}, line {place['line']}: {place['code'].strip()})"
        ) from None
