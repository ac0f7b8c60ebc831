"""A preset that somebody steers in the page: its frames, no faster than the film and none left out."""

import time
from collections import deque
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from gen_art.output.check import check_preset
from gen_art.output.player import Shown
from gen_art.output.steered_run import Device, SteeredRun
from gen_art.preset.camera import CameraSpec
from gen_art.preset.estimate import refuse_if_too_large
from gen_art.renderer.following import living

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["Steering"]

PACE_FRAMES = 12  # over which the pace is measured
SLOW = 0.9  # of real time, below which the picture is drawn in half the size
FEWEST_ROWS = 120  # of a picture that was halved


class Steering:
    """A steered run that waits for the first touch, and then goes on at the pace of the film.

    size : (width, height) of the pictures, before they are halved
    precision, threads : as for Simulation
    Raises UsageError if there is nothing to steer; else the errors of Player.change.
    """

    def __init__(self, preset: "Preset", size: tuple[int, int], precision: str = "f32", threads: int | None = None):
        check_preset(preset)
        refuse_if_too_large(preset, precision, preset.camera.size if preset.camera else CameraSpec().size)
        self.preset, self.size, self._coarseness = preset, size, 1
        self.run = SteeredRun(preset.with_own_fits(), size, precision, threads)
        self._held: Mapping[str, float] = {}
        self._pointer: tuple[float, float] | None = None
        self._pointer_taken: tuple[float, float] | None = None
        self._is_touched = False
        self._has_picture = False
        self._due = 0.0
        self._moments: deque[float] = deque(maxlen=PACE_FRAMES + 1)

    def touch(self, held: Mapping[str, float], pointer: tuple[float, float] | None) -> None:
        """Take what the hands do from now on; see steered_run.Device. The first key or movement begins the run."""
        self._held, self._is_touched = held, self._is_touched or bool(held) or pointer is not None
        if pointer is not None:
            self._pointer = pointer

    @property
    def pause(self) -> float | None:
        """The seconds until the next frame is due; None while nothing is to be drawn."""
        if not self._has_picture:
            return 0.0
        if not self._is_touched or self.run.is_done:
            return None
        return max(0.0, self._due - time.monotonic())

    @property
    def pace(self) -> float | None:
        """Seconds of the film that are shown in a second; None before a few frames have been shown."""
        if len(self._moments) < PACE_FRAMES + 1:
            return None
        return PACE_FRAMES / self.run.preset.clock.fps / max(1e-9, self._moments[-1] - self._moments[0])

    def show(self, size: tuple[int, int]) -> Shown:
        """The next frame; the first time, the one that the film begins with."""
        self._fit_size(size)
        started = time.monotonic()
        if self._has_picture:
            self._due = max(started, self._due + 1.0 / self.run.preset.clock.fps)
            pointer = self._pointer
            self.run.advance(Device(self._held, None if pointer is self._pointer_taken else pointer))
            self._pointer_taken = pointer
            self._moments.append(started)
        picture = self.run.picture()
        self._has_picture = True
        sim = self.run.sim
        alive = sum(len(living(system, sim.time)) for system in sim.systems.values())
        return Shown(picture, self.run.frame, True, alive, {"draw": time.monotonic() - started, "develop": 0.0})

    def state(self) -> dict[str, Any]:
        """What the page shows of it beside the picture."""
        return {
            **self.run.instruments(), "pace": self.pace, "coarseness": self._coarseness, "begun": self._is_touched,
            "done": self.run.is_done, "seconds": self.run.frame / self.run.preset.clock.fps,
        }  # fmt: skip

    def _fit_size(self, size: tuple[int, int]) -> None:
        width, height = size
        twice = 2 * self._coarseness
        is_slow = self.pace is not None and self.pace < SLOW and min(size) // twice >= FEWEST_ROWS
        if size == self.size and not is_slow:
            return
        self.size, self._coarseness = size, twice if is_slow else self._coarseness
        self._moments.clear()
        self.run.resize((max(1, width // self._coarseness), max(1, height // self._coarseness)))
