"""The keys of `clock:`: film time, simulated time and the time step, which must be commensurate."""

import math

from pydantic import model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import NotNegative, Positive
from gen_art.preset.model import Model, about, collected

__all__ = ["MOST_FRAMES", "MOST_STEPS", "Clock"]

MOST_FRAMES = 1_000_000  # nine hours of film at 30 frames a second
MOST_STEPS_A_FRAME = 1_000_000
MOST_STEPS = 1_000_000_000  # an empty step takes some 10 microseconds: hours at the least
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
        with_room = {  # ratios as floats, which may be infinite: whole numbers are made of them below
            "steps a frame": (self.speed / self.fps / self.step, MOST_STEPS_A_FRAME, "step", "a longer step"),
            "frames": (self.duration * self.fps, MOST_FRAMES, "duration", "a shorter duration or a lower fps"),
            "steps before frame 0": (self.preroll / self.step, MOST_STEPS, "preroll", "a shorter preroll, or a longer step"),
            "steps in all": (
                (self.preroll + self.duration * self.speed) / self.step, MOST_STEPS, "duration",
                "a shorter duration, or a longer step",
            ),
        }  # fmt: skip
        for what, (number, most, key, remedy) in with_room.items():
            if not number <= most:
                raise _problem(
                    key, f"the film would have {number:.3g} {what}, and may have {most:,} at most: give {remedy}"
                )
        per_frame = with_room["steps a frame"][0]
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

    def step_at(self, time: float) -> int:
        """The number of steps from the start to film time `time`, s.

        Raises UsageError for a time between two steps, or too late.
        """
        exact = time * self.speed / self.step
        if not 0.0 <= exact <= MOST_STEPS:
            raise UsageError(
                f"film time {time:g} s is {exact:.3g} steps of {self.step:g} s after the start, and {MOST_STEPS:,} at most are "
                "taken: give an earlier time, or a longer step"
            )
        steps = round(exact)
        if abs(exact - steps) > 1e-6 * max(1.0, abs(exact)):
            nearest = steps * self.step / self.speed
            raise UsageError(f"film time {time:g} s falls between steps; the nearest is {nearest:.9g} s")
        return self.preroll_steps + steps

    @property
    def simulated(self) -> float:
        """Simulated time from the start of the preroll to the last frame, seconds."""
        return self.preroll + (self.frames - 1) * self.speed / self.fps
