"""Plugins: Python files of the user that register forces and emitters when they are loaded."""

import hashlib
import importlib.util
import io
import linecache
import sys
import traceback
import types
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from gen_art import arguments
from gen_art.errors import GenArtError, OutputError, UsageError

__all__ = ["Plugin", "load_plugin", "load_plugins", "unload_plugin"]


@dataclass(frozen=True)
class Plugin:
    """A loaded plugin: its path, and the sha256 of its text, which is stored in recipes."""

    path: Path
    sha256: str

    @property
    def name(self) -> str:
        return self.path.name


_loaded: dict[str, Plugin] = {}


def load_plugin(path: str | Path) -> Plugin:
    """Run a Python file, which registers its `@ga.force` and `@ga.emitter` classes. The same text runs once a process.

    Raises OutputError when it cannot be read, and UsageError with the line for an error in it.
    """
    path = arguments.path("plugin", path)
    if str(path) == "-":
        raise UsageError("a plugin must be a file, not standard input, because its source is read again")
    try:
        text = path.read_bytes()
    except OSError as error:
        raise OutputError(f"plugin {path}: {error.strerror or error}") from None
    except ValueError:
        raise UsageError(f"plugin {str(path)!r}: no file can have this name") from None
    digest = hashlib.sha256(text).hexdigest()
    if digest in _loaded:
        return _loaded[digest]
    if path.suffix != ".py":
        raise UsageError(f"plugin {path}: is not a Python file (its name must end with .py)")
    name = _module_name(path, digest)
    module = types.ModuleType(name)
    module.__file__ = str(path.resolve())
    sys.modules[name] = module
    try:
        # exec runs exactly the text that was hashed, and writes no bytecode beside the user's file
        code = compile(text, module.__file__, "exec")
        _keep_source(module.__file__, text)
        exec(code, module.__dict__)
    except Exception as error:
        del sys.modules[name]
        raise UsageError(f"plugin {_place(path, error)}{_message(error)}") from error
    plugin = _loaded[digest] = Plugin(path, digest)
    return plugin


def load_plugins(plugins: Iterable[Plugin | str | Path]) -> tuple[Plugin, ...]:
    """Each of them loaded; those that are loaded already stay as they are."""
    return tuple(plugin if isinstance(plugin, Plugin) else load_plugin(plugin) for plugin in plugins)


def unload_plugin(plugin: Plugin) -> None:
    """Forget that a plugin has been loaded, so that its text runs again. What it has registered stays registered."""
    if _loaded.pop(plugin.sha256, None) is not None:
        sys.modules.pop(_module_name(plugin.path, plugin.sha256), None)


def _module_name(path: Path, digest: str) -> str:
    return f"gen_art_plugin_{path.stem}_{digest[:8]}"


def _keep_source(file: str, text: bytes) -> None:
    """Make this text the source of the file for the life of the process, also when the file is saved again.

    Kernels are compiled from their source when they first run, and by then the file may have other lines.
    """
    source = importlib.util.decode_source(text)
    lines = io.StringIO(source if source.endswith("\n") else source + "\n").readlines()
    linecache.cache[file] = (
        len(source),
        None,
        lines,
        file,
    )  # without a time, linecache does not look at the file again


def _place(path: Path, error: Exception) -> str:
    """`swirl.py:12: `, with the last line of the plugin in the error's traceback."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"{path}:{error.lineno}: "
    here = str(path.resolve())
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == here]
    return f"{path}:{lines[-1]}: " if lines else f"{path}: "


def _message(error: Exception) -> str:
    if isinstance(error, GenArtError):
        return str(error)
    return f"{type(error).__name__}: {error.msg if isinstance(error, SyntaxError) else error}"
