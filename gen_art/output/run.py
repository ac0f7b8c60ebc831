"""A preset's simulation and its painter together: the linear picture at any later film time."""

import math

import numpy as np

from gen_art.errors import UsageError
from gen_art.renderer.camera import Camera
from gen_art.renderer.frame import Painter

__all__ = ["Run"]

_HALF_LIVES = 16  # of a trail, that it begins before frame 0: what lies further back has faded


class Run:
    """A simulation of a preset and its painter, from the start to any later film time."""

    def __init__(self, preset, size, precision: str, threads: int | None):
        from gen_art.simulation import Simulation

        self.preset, clock = preset, preset.clock
        self.sim = Simulation(preset, precision=precision, threads=threads)
        self.camera = Camera.from_spec(preset.camera) if preset.camera else None
        open_ = (self.camera.shutter if self.camera else 180.0) / 360.0 * clock.speed / clock.fps
        self.painter = Painter(size, self.camera, {n: s.look for n, s in preset.systems.items()}, open_)
        wanted = max((look.trail.substeps for look in self.painter.trails.values() if look.trail), default=1)
        per_frame = clock.steps_per_frame
        self._between = per_frame // max(n for n in range(1, min(wanted, per_frame) + 1) if per_frame % n == 0)
        longest = max((look.trail.half_life for look in self.painter.trails.values() if look.trail), default=0.0)
        exposures = math.ceil(_HALF_LIVES * longest * clock.speed / clock.step / self._between)
        self._first_exposure = max(0, clock.preroll_steps - exposures * self._between)
        self._done = 0

    def step_of(self, time: float) -> int:
        """The number of steps from the start to film time `time`; UsageError when it falls between steps."""
        clock = self.preset.clock
        exact = time * clock.speed / clock.step
        steps = round(exact)
        if not time >= 0.0 or abs(exact - steps) > 1e-6 * max(1.0, abs(exact)):
            nearest = max(steps, 0) * clock.step / clock.speed
            raise UsageError(f"film time {time:g} s falls between steps; the nearest is {nearest:.9g} s")
        return clock.preroll_steps + steps

    def film(self, step: int) -> np.ndarray:
        """The linear picture after `step` steps from the start (a view, good until the next)."""
        clock = self.preset.clock
        if self.painter.trails:
            self._advance(min(step, self._first_exposure) - self._done)
            while self._done < step:
                n = min(self._until_exposure(), step - self._done)
                self._advance(n)
                if self._until_exposure() == self._between:
                    seconds = self._between * clock.step / clock.speed
                    self.painter.expose_trails(self.sim, self._film_time(), seconds, self._between * clock.step)
        self._advance(step - self._done)
        return self.painter.paint(self.sim, self._film_time())

    def _until_exposure(self) -> int:
        """Steps to the next exposure of the trails: they lie on the frames and evenly between them."""
        return self._between - (self._done - self.preset.clock.preroll_steps) % self._between

    def _advance(self, steps: int) -> None:
        if steps > 0:
            self.sim.step(steps)
            self._done += steps

    def _film_time(self) -> float:
        clock = self.preset.clock
        return (self._done - clock.preroll_steps) * clock.step / clock.speed

    @property
    def particles(self) -> int:
        return sum(int(system.count) for system in self.sim.systems.values())
