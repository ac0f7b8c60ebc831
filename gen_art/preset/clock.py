"""The keys of `clock:`: film time, simulated time and the time step, which must be commensurate."""

import math

from pydantic import model_validator

from gen_art.preset.fields import NotNegative, Positive
from gen_art.preset.model import Model, about, collected

__all__ = ["Clock"]

_TOLERANCE = 1e-9  # relative, for rounding in numbers such as 1/240


def nearly_whole(ratio: float) -> int | None:
    """The whole number that a ratio equals up to rounding, or None."""
    nearest = round(ratio)
    return nearest if abs(ratio - nearest) <= _TOLERANCE * max(1.0, abs(ratio)) else None


def _problem(key: str, text: str):
    return collected([((key,), text)])


class Clock(Model):
    """Frame k is film time k / fps; its simulated time is speed k / fps, a whole number of steps after the preroll."""

    duration: Positive = about(..., "length of the film", unit="s")
    fps: Positive = about(30.0, "frames per second of film", unit="1/s")
    step: Positive = about(..., "time step dt, in simulated time", unit="s")
    speed: Positive = about(1.0, "simulated time per second of film")
    preroll: NotNegative = about(0.0, "simulated time before frame 0", unit="s")

    @model_validator(mode="after")
    def _commensurate(self):
        per_frame = self.speed / self.fps / self.step
        if not math.isfinite(per_frame) or per_frame > 1e9:
            raise _problem(
                "step", f"a frame would take {per_frame:.3g} steps: step is too short for this speed and fps"
            )
        if not nearly_whole(per_frame):
            low, high = max(1, math.floor(per_frame)), math.ceil(per_frame)
            nearest = min((self.speed / (n * self.step) for n in (low, high)), key=lambda fps: abs(fps - self.fps))
            raise _problem(
                "fps",
                f"a frame falls between steps: speed / fps = {self.speed / self.fps:.6g} is {per_frame:.6g} steps of "
                f"{self.step:.6g}; the nearest fps is {nearest:.9g}",
            )
        if nearly_whole(self.preroll / self.step) is None:
            nearest = round(self.preroll / self.step) * self.step
            raise _problem("preroll", f"preroll must be a whole number of steps; the nearest is {nearest:.9g}")
        if self.frames < 1:
            raise _problem(
                "duration", f"a duration of {self.duration:g} s at {self.fps:g} frames a second makes no frame"
            )
        return self

    @property
    def frames(self) -> int:
        """The number of frames of the film."""
        return math.floor(self.duration * self.fps * (1 + _TOLERANCE) + 1e-9)

    @property
    def steps_per_frame(self) -> int:
        return round(self.speed / self.fps / self.step)

    @property
    def preroll_steps(self) -> int:
        return round(self.preroll / self.step)

    @property
    def simulated(self) -> float:
        """Simulated time from the start of the preroll to the last frame, seconds."""
        return self.preroll + (self.frames - 1) * self.speed / self.fps
