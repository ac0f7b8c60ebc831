"""Plugins that are edited while the process goes on: the classes of a saved file replace those of the file before."""

from collections.abc import Iterable
from pathlib import Path

from gen_art.files import sha256
from gen_art.plugins import Plugin, load_plugin, unload_plugin
from gen_art.preset.registered import KINDS, registry

__all__ = ["LivePlugins"]


class LivePlugins:
    """The plugins at these paths. Made before any of them is loaded, because it notes what is registered without them.

    What a plugin has registered is replaced as a whole, so a class that was renamed or deleted in the file is gone. Other effects
    of a plugin stay: the modules that it imports are not loaded again.
    """

    def __init__(self, paths: Iterable[str | Path]):
        self.paths = tuple(Path(path) for path in paths)
        self._without = {kind: dict(registry(kind).classes) for kind in KINDS}
        self._loaded: tuple[Plugin, ...] | None = None

    def load(self) -> tuple[Plugin, ...]:
        """The plugins as their files are now; they run again only if one of them has other text.

        Raises the errors of `load_plugin`; none of the plugins is then registered.
        """
        if self._loaded is not None and all(sha256(p) == plugin.sha256 for p, plugin in zip(self.paths, self._loaded)):
            return self._loaded
        self._unload(self._loaded or ())
        loaded: list[Plugin] = []
        try:
            for path in self.paths:
                loaded.append(load_plugin(path))
        except BaseException:
            self._unload(loaded)
            raise
        self._loaded = tuple(loaded)
        return self._loaded

    def _unload(self, plugins: Iterable[Plugin]) -> None:
        for plugin in plugins:
            unload_plugin(plugin)
        for kind, classes in self._without.items():
            registry(kind).classes.clear()
            registry(kind).classes.update(classes)
        self._loaded = None
