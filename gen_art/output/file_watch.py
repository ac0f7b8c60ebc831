"""Waits until one of some files is saved, deleted or put back.

The system says when something happens in the files' folders (through the package watchfiles, of the extra `studio`); what has
changed is told by the files' stamps. A missed message therefore only costs time: once a second the stamps are compared anyway.
"""

import threading
import time
import warnings
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from gen_art.files import Stamp, stamp
from gen_art.output.extras import check_installed

__all__ = ["FileWatch"]

_LOOK = 1.0  # s between two looks without a message
_QUIET = 0.05  # s without a change, after which a file counts as saved
_GONE = 0.3  # s after which a missing file counts as deleted: some editors delete a file and write it anew
_STEP, _LONGEST = 20, 200  # ms: messages are collected until a step without one, for this time at most


class FileWatch:
    """A watch over the files of `follow`. To be closed, also by `with`: a thread listens to the system."""

    def __init__(self) -> None:
        check_installed("watching files", "watchfiles")
        self._stamps: dict[Path, Stamp | None] = {}
        self._folders: frozenset[Path] = frozenset()
        self._woken, self._closed = threading.Event(), threading.Event()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._trouble: str | None = None
        self._lock = threading.Lock()  # between a `wait` that begins to listen and a `close`

    def follow(self, stamps: Mapping[Path, Stamp | None]) -> None:
        """Watch these files from now on. The stamps are those with which they were last read; None if there was no file."""
        self._stamps = dict(stamps)

    def wait(self) -> list[Path]:
        """Wait for a change; the files that have other stamps now. Empty once the watch is closed."""
        while not self._closed.is_set():
            self._listen()
            if self.changed():
                self._settle()
                if changed := self.changed():
                    return changed
            self._woken.wait(_LOOK)
            self._woken.clear()
            if self._trouble is not None:
                warnings.warn(f"{self._trouble}: changes are seen once a second", stacklevel=2)
                self._trouble = None
        return []

    def changed(self) -> list[Path]:
        """The files that have other stamps than those of `follow`."""
        return [path for path, before in self._stamps.items() if stamp(path) != before]

    def close(self) -> None:
        """End the watch, and a `wait` of another thread."""
        self._closed.set()
        self._woken.set()
        with self._lock:
            self._end_thread()

    def __enter__(self) -> "FileWatch":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _settle(self) -> None:
        """Wait until nothing changes any more: a program may still be writing, or about to put a file back."""
        seen = None
        while (now := {path: stamp(path) for path in self._stamps}) != seen:
            seen = now
            gone = any(now[path] is None and before is not None for path, before in self._stamps.items())
            time.sleep(_GONE if gone else _QUIET)

    def _listen(self) -> None:
        """Listen to the folders of the files, and of the files that links lead to."""
        places = {place for path in self._stamps for place in (path.absolute(), path.resolve())}
        folders = frozenset(_existing(place.parent) for place in places)
        with self._lock:
            if folders != self._folders and not self._closed.is_set():
                self._end_thread()
                self._folders, self._stop = folders, threading.Event()
                self._thread = threading.Thread(target=self._hear, args=(folders, self._stop), daemon=True)
                self._thread.start()

    def _hear(self, folders: frozenset[Path], stop: threading.Event) -> None:
        """Wake `wait` at each message of the system. In a thread, because signals end `wait` in the main thread at once."""
        from watchfiles import watch

        try:
            for _ in watch(
                *folders, watch_filter=None, debounce=_LONGEST, step=_STEP, stop_event=stop, rust_timeout=1000, recursive=False,
                ignore_permission_denied=True,
            ):  # fmt: skip
                self._woken.set()
        except Exception as error:  # as when the system has no more watches to give
            self._trouble = f"the system does not say when files are saved ({' '.join(str(error).split())})"
            self._woken.set()

    def _end_thread(self) -> None:
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None


def _existing(folder: Path) -> Path:
    """The folder, or the nearest one above it that exists."""
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    return folder
