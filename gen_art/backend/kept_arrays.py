"""Arrays that take long to work out and depend on few numbers, kept in the cache folder from one process to the next."""

import contextlib
import hashlib
import io
import sys
from collections.abc import Callable
from functools import wraps

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.fingerprint import Unknown, fingerprint

__all__ = ["kept"]

_FORMAT = 1  # of the files; another number makes all of them anew


def kept(function: Callable[..., tuple[np.ndarray, ...]]) -> Callable[..., tuple[np.ndarray, ...]]:
    """The same function, which must depend on its arguments alone, with results that are kept in the cache folder.

    A result is known by the text (`repr`) of the arguments, the digest of all code that the function reaches
    (gen_art/backend/fingerprint.py), and the versions of Python and NumPy. Nothing is kept before Taichi has started.
    """

    @wraps(function)
    def lookup(*args) -> tuple[np.ndarray, ...]:
        files = runtime.kept_files()
        key = None if files is None else _key(function, args)
        if files is None or key is None:
            return function(*args)
        content = files.read(key)
        arrays = None if content is None else _arrays(content)
        if arrays is None:
            arrays = function(*args)
            files.write(key, _content(arrays))
        return arrays

    return lookup


def _key(function, args: tuple) -> str | None:
    try:
        digest = fingerprint(function).digest
    except Unknown:
        return None
    words = _FORMAT, sys.implementation.cache_tag, np.__version__, digest, args
    return hashlib.sha256(repr(words).encode()).hexdigest()


def _content(arrays: tuple[np.ndarray, ...]) -> bytes:
    file = io.BytesIO()
    for array in arrays:
        np.lib.format.write_array(file, np.ascontiguousarray(array), allow_pickle=False)
    return file.getvalue()


def _arrays(content: bytes) -> tuple[np.ndarray, ...] | None:
    """The arrays of a file; None if it is of another kind."""
    file, arrays = io.BytesIO(content), []
    with contextlib.suppress(ValueError, EOFError):
        while file.tell() < len(content):
            arrays.append(np.lib.format.read_array(file, allow_pickle=False))
        return tuple(arrays)
    return None
