"""A preset's simulation and its painter together: the linear picture at any later film time.

What a picture needs of the time before it (trails, ribbons, the frames between two) happens at steps of the simulation that
are laid down by the preset alone, so a frame is the same whichever was asked for first.
"""

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from gen_art.errors import UsageError
from gen_art.renderer.aovs import render_aovs
from gen_art.renderer.auto_exposure import ages, meter, smooth
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter

__all__ = ["Playback"]

_HALF_LIVES = 16  # of a trail, that it begins before frame 0: what lies further back has faded


def _largest_divisor(of: int, wanted: int) -> int:
    return max(n for n in range(1, max(1, min(wanted, of)) + 1) if of % n == 0)


class Playback:
    """A simulation of a preset and its painter, from the start to any later film time."""

    def __init__(self, preset, size, precision: str, threads: int | None):
        from gen_art.simulation import Simulation

        self.preset = preset
        self.sim = Simulation(preset, precision=precision, threads=threads)
        self.camera = Camera.from_spec(preset.camera) if preset.camera else None
        self._shutter = self.camera.shutter if self.camera else 180.0
        self.painter = Painter(
            size, self.camera, {n: s.look for n, s in preset.systems.items()}, 0.0,
            preset.camera.supersample if preset.camera else 1,
        )  # fmt: skip
        self._precision = precision
        self._shows_acceleration = any(
            system.look is not None and system.look.goes_by("acceleration") for system in preset.systems.values()
        )
        self._done, self._seen = 0, -1
        self._trails, self._trail_step = self._plan_trails()
        self._subframe, self._subframes = self._plan_subframes()

    def _plan_trails(self) -> tuple[range, int]:
        """Steps at which trails are exposed: on the frames, and evenly between them."""
        clock, trails = self.preset.clock, [k.trail for k in self.painter.trails.values() if k.trail is not None]
        if not trails:
            return range(0), 1
        between = clock.steps_per_frame // _largest_divisor(clock.steps_per_frame, max(t.substeps for t in trails))
        longest = max(t.half_life for t in trails)
        exposures = math.ceil(_HALF_LIVES * longest * clock.speed / clock.step / between)
        first = max(clock.preroll_steps % between, clock.preroll_steps - exposures * between)
        return range(first + between, 2**62, between), between

    def _plan_subframes(self) -> tuple[int, int]:
        """Steps between two of a frame's subframes, and how many there are; one when the shutter is open less than a step."""
        clock = self.preset.clock
        steps = math.floor(self._shutter / 360.0 * clock.steps_per_frame + 1e-9)
        wanted = self.preset.camera.subframes if self.preset.camera else 1
        open_ = self._shutter / 360.0 * clock.speed / clock.fps
        if wanted == 1 or steps == 0:
            self.painter.shutter = open_
            return 0, 1
        number = _largest_divisor(steps, wanted)
        self.painter.shutter = open_ / number
        return steps // number, number

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
        return next(self.films([step]))[0]

    def films(self, steps: Sequence[int]) -> Iterator[tuple[np.ndarray, float]]:
        """The linear pictures after so many steps from the start, in order, each a view that is good until the next; and the
        stops each is to be developed with, beside the preset's own. Automatic exposure meters what lies before, on the way.
        """
        auto = self.preset.develop.auto_exposure
        if auto is None:
            yield from ((self._picture(step), 0.0) for step in steps)
            return
        wanted, levels = set(steps), {}
        for step in sorted(wanted | {earlier for shown in steps for earlier, _ in self._metered_for(shown)}):
            picture = self._picture(step)
            levels[step] = meter(picture)
            if step in wanted:
                values, back = zip(*((levels[earlier], age) for earlier, age in self._metered_for(step)))
                yield picture, smooth(values, back, auto)

    def _metered_for(self, step: int) -> list[tuple[int, float]]:
        """The pictures whose light a picture's exposure is made of: steps from the start, and seconds before it."""
        clock = self.preset.clock
        seconds = ages(self.preset.develop.auto_exposure, clock.fps)
        found = [(step - round(age * clock.fps) * clock.steps_per_frame, age) for age in seconds]
        return [(earlier, age) for earlier, age in found if earlier >= clock.preroll_steps or earlier == step]

    def _picture(self, step: int) -> np.ndarray:
        pictures: list[np.ndarray] = []
        stops: dict[int, list[Callable]] = {}

        def paint():
            picture = self.painter.paint(self.sim, self._film_time())
            if not pictures and self._subframes > 1:
                pictures.append(np.array(picture))
            elif pictures:
                pictures[0] += picture
            else:
                pictures.append(picture)

        for at, action in self._between(step):
            stops.setdefault(at, []).append(action)
        exposed = [step - k * self._subframe for k in range(self._subframes) if step >= k * self._subframe]
        for at in exposed:
            stops.setdefault(at, []).append(paint)
        for at in sorted(stops):
            self._advance(at - self._done)
            for action in stops[at]:
                action()
        self._seen = step
        return pictures[0] if len(exposed) == 1 else pictures[0] / np.float32(len(exposed))

    def layers(self) -> dict[str, np.ndarray]:
        """Depth and motion of the picture made last: see gen_art.renderer.aovs."""
        clock = self.preset.clock
        return render_aovs(self.painter, self.sim, self._film_time(), 1.0 / clock.fps, clock.speed / clock.fps)

    def _between(self, step: int) -> Iterator[tuple[int, Callable]]:
        """What is to be done after the steps that were seen and up to this one, kind by kind."""
        clock = self.preset.clock

        def expose():
            seconds = self._trail_step * clock.step / clock.speed
            self.painter.expose_trails(self.sim, self._film_time(), seconds, self._trail_step * clock.step)

        for at in _part(self._trails, self._seen, step):
            yield at, expose
        for name, history in self.painter.histories.items():
            every = max(1, round(history.ribbon.length / history.ribbon.points / clock.step))
            first = max(0, clock.preroll_steps // every - history.ribbon.points) * every

            def remember(name=name, history=history):
                history.remember(self.sim.systems[name], self.sim.time)

            for at in _part(range(first, 2**62, every), self._seen, step):
                yield at, remember

    def _advance(self, steps: int) -> None:
        if steps > 0:
            if self._shows_acceleration:
                if steps > 1:
                    self.sim.step(steps - 1)
                self.painter.remember_velocities(self.sim)
                steps, self._done = 1, self._done + steps - 1
            self.sim.step(steps)
            self._done += steps
        elif self._shows_acceleration and self._done == 0:  # nothing lies behind: the first step counts
            from gen_art.simulation import Simulation

            ahead = Simulation(self.preset, precision=self._precision)
            ahead.step(1)
            self.painter.remember_velocities(ahead)

    def _film_time(self) -> float:
        clock = self.preset.clock
        return (self._done - clock.preroll_steps) * clock.step / clock.speed

    @property
    def particles(self) -> int:
        return sum(int(system.count) for system in self.sim.systems.values())


def _part(steps: range, after: int, last: int) -> range:
    """Those of an endless range of steps in after + 1 .. last."""
    if not steps:
        return steps
    skipped = max(0, -(-(after + 1 - steps.start) // steps.step))
    return range(steps.start + skipped * steps.step, last + 1, steps.step)
