"""The thread that makes the studio's pictures: it always works on the newest wish, and drops what is no longer wanted.

Everything that computes runs in this one thread. It is told what is wanted (`want`) and calls back with pictures and words.
"""

import math
import tempfile
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import Image

from gen_art.errors import GenArtError, UsageError
from gen_art.output.player import Player, Shown, Superseded
from gen_art.preset.load import load_preset
from gen_art.studio.steering import Steering

if TYPE_CHECKING:
    from gen_art.output.input_tables import InputTable
    from gen_art.preset.schema import Preset
    from gen_art.simulation import Simulation

__all__ = ["IN_FLIGHT", "Wish", "Worker", "final_picture"]

IN_FLIGHT = 2  # pictures that are on their way to the page; no more are made before it has shown them
REST = 0.15  # s without a change after which the picture is drawn in full
JPEG_QUALITY = 88
COARSE, COARSE_FROM = 2, 200  # while something moves, a picture of so many rows is drawn so much smaller


@dataclass(frozen=True)
class Wish:
    """What the page wants to see.

    preset : None before the first
    size : (width, height) of the picture at rest
    moving : whether somebody holds a slider or the camera
    diagnosed : whether energy and momentum are wanted with each picture
    """

    preset: "Preset | None" = None
    frame: int = 0
    size: tuple[int, int] = (640, 360)
    playing: bool = False
    moving: bool = False
    diagnosed: bool = False


class Worker(threading.Thread):
    """Makes pictures until `stop`.

    deliver : called with (header, bytes of a JPEG)
    tell : called with messages: {"type": "status", ...}, {"type": "warning", "text"}, {"type": "error", "text"},
        {"type": "steering", "on"}
    """

    def __init__(
        self, deliver: Callable[[dict, bytes], None], tell: Callable[[dict], None], precision: str = "f32",
        threads: int | None = None,
    ):  # fmt: skip
        super().__init__(name="studio", daemon=True)
        self._deliver, self._tell = deliver, tell
        self._precision, self._threads = precision, threads
        self._changed = threading.Condition()
        self._wish = Wish()
        self._version = 0  # of the wish
        self._credits = IN_FLIGHT
        self._jobs: list[Callable[[], None]] = []
        self._stopping = False
        self._frame = self._wished_frame = 0
        self._seen = self._failed = -1  # versions of the wish: the one worked on, and one that ended in an error
        self._changed_at = 0.0
        self._settling: Iterator[float] | None = None
        self._settling_frame = 0
        self._due = 0.0  # when the next frame of a playing film is
        self._is_whole = False  # the last picture: drawn in full, with its trails
        self._steering: Steering | None = None

    def want(self, **changes: Any) -> None:
        """Change the wish."""
        with self._changed:
            self._wish = replace(self._wish, **changes)
            self._version += 1
            self._changed.notify()

    def shown(self) -> None:
        """The page has shown a picture."""
        with self._changed:
            self._credits = min(IN_FLIGHT, self._credits + 1)
            self._changed.notify()

    def reconnected(self) -> None:
        """Another page has come: nothing is on its way to it, and it has seen nothing."""
        with self._changed:
            self._credits = IN_FLIGHT
            self._version += 1
            self._changed.notify()

    def renew(self, preset: "Preset") -> None:
        """Make everything anew, of this preset: the files that it names, or the plugins, are others."""
        with self._changed:
            self._jobs.append(self._forget)
            self.want(preset=preset, moving=False)

    def _forget(self) -> None:
        self._player.forget()
        self._settling = None

    def do(self, job: Callable[[], None]) -> None:
        """Run a job in this thread, before the next picture."""
        with self._changed:
            self._jobs.append(job)
            self._changed.notify()

    def steer(self, preset: "Preset") -> None:
        """Let somebody steer this preset from its start, until `leave` or another preset."""
        self.want(preset=preset, playing=False, moving=False)
        self.do(lambda: self._begin_steering(preset))

    def touch(self, held: Mapping[str, float], pointer: tuple[float, float] | None) -> None:
        """What the hands do from now on, while somebody steers; see gen_art.output.steered_run.Device."""
        with self._changed:
            if self._steering is not None:
                self._steering.touch(held, pointer)
                self._changed.notify()

    def leave(self) -> None:
        """End the steering."""
        self.do(self._end_steering)

    def steered_tables(self, take: "Callable[[list[InputTable]], None]") -> None:
        """Call `take` in this thread with the tables of inputs as they are; there are none while nobody steers."""

        def give() -> None:
            take(self._steering.run.tables if self._steering is not None else [])

        self.do(give)

    def stop(self) -> None:
        with self._changed:
            self._stopping = True
            self._changed.notify()

    def run(self) -> None:
        warnings.showwarning = self._warn  # of this process, which is the studio's alone
        self._player = Player(self._precision, self._threads, self._is_superseded)
        try:
            while not self._stopping:
                self._turn()
        finally:
            self._player.close()

    def _warn(self, message, category, filename, lineno, file=None, line=None) -> None:
        if issubclass(category, UserWarning):
            self._tell({"type": "warning", "text": str(message)})

    def _is_superseded(self) -> bool:
        return self._stopping or bool(self._jobs) or self._version != self._seen

    def _turn(self) -> None:
        """Wait until there is something to do, and do it."""
        with self._changed:
            job = self._jobs.pop(0) if self._jobs else None
            step, pause = (job, None) if job is not None else self._next_step()
            if step is None:
                if not self._stopping:
                    self._changed.wait(pause)
                return
        try:
            step()
        except Superseded:
            pass
        except GenArtError as error:
            self._fail(str(error), job is None)
        except Exception as error:
            traceback.print_exc()
            self._fail(f"this is a bug: {type(error).__name__}: {error}", job is None)

    def _fail(self, words: str, of_picture: bool) -> None:
        if of_picture:
            self._failed = self._seen  # the next picture is that of another wish
        self._tell({"type": "error", "text": words})

    def _next_step(self) -> tuple[Callable[[], None] | None, float | None]:
        """(what to do now, or None; then how many seconds to wait at most)."""
        wish, now = self._wish, time.monotonic()
        if self._stopping or wish.preset is None or self._failed == self._version or self._credits <= 0:
            return None, None
        if self._steering is not None:
            if wish.preset is not self._steering.preset:
                return self._drop_steering, None
            pause = self._steering.pause
            return (None, pause) if pause is None or pause > 0.0 else (self._show_steered, None)
        if self._seen != self._version:
            self._take_wish()
            return self._draw_now, None
        if self._settling is not None and not wish.moving:  # a film does not begin with the motion of before
            return self._settle, None
        if wish.playing:
            if now < self._due:
                return None, self._due - now
            self._due = max(
                now, self._due + 1.0 / self._player.fps
            )  # no faster than the film, and no hurry after a pause
            self._frame = (self._frame + 1) % max(1, self._player.frames)
            return self._draw_now, None
        if wish.moving:
            return None, None
        rest = self._changed_at + REST - now
        if rest > 0.0:
            return None, rest
        if not self._player.is_exact:
            return self._settle, None
        return (None, None) if self._is_whole else (self._draw_whole, None)

    def _take_wish(self) -> None:
        wish = self._wish
        if not wish.playing or wish.frame != self._wished_frame:
            self._frame = wish.frame
        self._wished_frame = wish.frame
        self._seen, self._changed_at, self._is_whole = self._version, time.monotonic(), False
        self._due = self._changed_at

    def _draw_now(self) -> None:
        """The picture as soon as it can be: small while something moves, and without the trails of frames before."""
        wish = self._wish
        assert wish.preset is not None
        if self._player.change(wish.preset) == "motion" or self._frame != self._settling_frame:
            self._settling = None
        width, height = wish.size
        if wish.moving and min(width, height) >= COARSE_FROM:
            width, height = width // COARSE, height // COARSE
        self._show(self._frame, (width, height), with_history=wish.playing)

    def _draw_whole(self) -> None:
        self._show(self._frame, self._wish.size, with_history=True)
        self._is_whole = True

    def _begin_steering(self, preset: "Preset") -> None:
        self._end_steering()
        self._tell({"type": "status", "anew": 0.0})
        try:
            self._steering = Steering(preset, self._wish.size, self._precision, self._threads)
        finally:
            self._tell({"type": "status", "anew": None})
        self._tell({"type": "steering", "on": True})

    def _end_steering(self) -> None:
        if self._steering is None:
            return
        self._steering = None
        with self._changed:
            self._version += 1  # the picture of before is wanted again
        self._tell({"type": "steering", "on": False})

    def _drop_steering(self) -> None:
        self._end_steering()
        self._tell({"type": "said", "text": "the preset has changed, which ended the steering", "stays": True})

    def _show_steered(self) -> None:
        assert self._steering is not None
        self._seen = self._version
        try:
            shown = self._steering.show(self._wish.size)
        except GenArtError:
            self._end_steering()
            raise
        self._send(shown, self._steering.run.sim, self._steering.run.frames, self._steering.state())

    def _settle(self) -> None:
        """One slice of the motion computed anew."""
        if self._settling is None:
            self._settling, self._settling_frame = self._player.settle(self._frame, self._wish.size), self._frame
        part = next(self._settling, None)
        self._tell({"type": "status", "anew": part})
        if part is None:
            self._settling = None

    def _show(self, frame: int, size: tuple[int, int], with_history: bool) -> None:
        shown = self._player.show(frame, size, with_history)
        self._send(shown, self._player.sim, self._player.frames)

    def _send(self, shown: Shown, sim: "Simulation | None", frames: int, steered: dict | None = None) -> None:
        data = BytesIO()
        Image.fromarray(shown.picture).save(data, "JPEG", quality=JPEG_QUALITY, subsampling=0)
        height, width = shown.picture.shape[:2]
        header = {
            "type": "picture", "version": self._seen, "frame": shown.frame, "frames": frames, "width": width,
            "height": height, "exact": shown.is_exact, "particles": shown.particles, "seconds": shown.seconds,
        }  # fmt: skip
        if steered is not None:
            header["steered"] = steered
        if self._wish.diagnosed and sim is not None:
            sums = sim.diagnostics()
            momentum = math.hypot(*(float(x) for x in sums.momentum))
            header["diagnostics"] = {"energy": float(sums.energy), "momentum": momentum, "count": int(sums.count)}
        with self._changed:
            self._credits -= 1
        self._deliver(header, data.getvalue())


def final_picture(preset: "Preset", frame: int, precision: str, threads: int | None, plugins) -> tuple[str, bytes]:
    """(file name, bytes) of a frame as `gen-art still` writes it. Raises UsageError for a frame past the end."""
    from gen_art.output import job

    if frame >= preset.clock.frames:
        raise UsageError(f"frame {frame} lies past the end: the film has frames 0 to {preset.clock.frames - 1}")
    with tempfile.TemporaryDirectory(prefix="gen-art-studio-") as folder:
        path = Path(folder) / f"{preset.name}.png"
        job.still(
            load_preset(preset), path, frame / preset.clock.fps, precision=precision, threads=threads, plugins=plugins
        )
        return path.name, path.read_bytes()
