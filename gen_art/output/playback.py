"""Plays a preset: its simulation and its painter give the linear picture at any later film time.

Trails, ribbons and motion blur need states from before a picture. The steps at which these states are recorded depend only
on the preset, so a frame does not depend on which frames were rendered before it.
"""

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import AdviceWarning, PresetError
from gen_art.output.stopwatch import Stopwatch
from gen_art.output.wait import Wait
from gen_art.renderer.aovs import render_aovs
from gen_art.renderer.auto_exposure import metered_stops, metering_ages, smoothed_exposure
from gen_art.renderer.axes import draw_axes
from gen_art.renderer.camera import Camera
from gen_art.renderer.fitting import fit_of
from gen_art.renderer.following import followed
from gen_art.renderer.labels import draw_labels
from gen_art.renderer.legend import draw_legends
from gen_art.renderer.painter import Painter
from gen_art.renderer.path_history import MOMENTS
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.tone_map import develop
from gen_art.simulation.no_effect import undrawn_systems

if TYPE_CHECKING:
    from gen_art.simulation import Simulation

__all__ = ["Playback", "largest_divisor"]

_HALF_LIVES = 16  # a trail starts this many half-lives before frame 0: light from earlier has faded
_ENDLESS = 2**62  # end of a range of steps without end


def largest_divisor(number: int, most: int) -> int:
    """The largest divisor of `number` that is at most `most`, or 1."""
    return max(n for n in range(1, max(1, min(most, number)) + 1) if number % n == 0)


class Playback:
    """A simulation of a preset and its painter, which together play the preset forwards.

    transparent : leave out the preset's sky, so that the pictures keep their alpha
    tell : called with how long the first picture takes, where that is long; see gen_art.output.wait
    sim : a simulation of the preset to go on with from where it is; a new one when None. Trails, ribbons, flashes and
        subframes then hold only what comes after
    """

    def __init__(
        self, preset, size, precision: str, threads: int | None, transparent: bool = False,
        tell: Callable[[dict], None] | None = None, sim: "Simulation | None" = None,
    ):  # fmt: skip
        from gen_art.simulation import Simulation

        self.preset = preset
        for sentence in undrawn_systems(preset):
            warnings.warn(sentence, AdviceWarning, stacklevel=2)
        fit = fit_of(preset, size, precision, threads)
        self.sim = Simulation(preset, precision=precision, threads=threads) if sim is None else sim
        self.camera = Camera.from_spec(preset.camera, fit) if preset.camera else None
        self._shutter = self.camera.shutter if self.camera else 180.0
        dome = SkyDome.of(preset.sky) if preset.sky is not None else None
        self.painter = Painter(
            size, self.camera, preset.looks, 0.0,
            preset.camera.supersample if preset.camera else 1,
            Scene.of(preset, self.sim.members.values(), dome, self.sim.preset.colliders if self.sim.preset else None),
            transparent,
        )  # fmt: skip
        self._precision = precision
        self._shows_acceleration = any(
            look is not None and look.goes_by("acceleration") for look in preset.looks.values()
        )
        self._first_step = 0 if sim is None else sim.steps_done
        self._last_shown = -1 if sim is None else sim.steps_done
        self._last_flashed = self._first_step - 1  # the step up to which flashes have been taken
        self._is_new = sim is None  # and nothing has been shown
        self._tell = tell
        self._levels: dict[int, float] = {}  # by step: what the pictures were metered at, for automatic exposure
        self.stopwatch = Stopwatch()
        self._trail_steps, self._trail_interval = self._plan_trails()
        self._subframe_interval, self._subframes = self._plan_subframes()
        self._path_steps = {name: self._plan_path(name) for name in self.painter.paths}
        self._flash_steps = {
            name: max(1, round(flashes.every / preset.clock.step))
            for name, flashes in self.painter.album.flashes.items()
        }

    def _plan_trails(self) -> tuple[range, int]:
        """(steps at which trails are exposed, their distance): on the frames, and evenly between them."""
        clock, trails = self.preset.clock, [k.trail for k in self.painter.trails.values() if k.trail is not None]
        if not trails:
            return range(0), 1
        interval = clock.steps_per_frame // largest_divisor(clock.steps_per_frame, max(t.substeps for t in trails))
        longest = max(t.half_life for t in trails)
        exposures = math.ceil(_HALF_LIVES * longest * clock.speed / clock.step / interval)
        first = max(clock.preroll_steps % interval, clock.preroll_steps - exposures * interval)
        return range(first + interval, _ENDLESS, interval), interval

    def _plan_subframes(self) -> tuple[int, int]:
        """(steps between two subframes of a frame, number of subframes); one subframe if the shutter is open under a step."""
        clock = self.preset.clock
        steps = math.floor(self._shutter / 360.0 * clock.steps_per_frame + 1e-9)
        wanted = self.preset.camera.subframes if self.preset.camera else 1
        exposure_time = self._shutter / 360.0 * clock.speed / clock.fps
        if wanted == 1 or steps == 0:
            self.painter.shutter = exposure_time
            return 0, 1
        number = largest_divisor(steps, wanted)
        self.painter.shutter = exposure_time / number
        return steps // number, number

    def _plan_path(self, name: str) -> tuple[int, int]:
        """(steps between two moments of a streak's path that are remembered, steps before a picture at which they begin)."""
        clock, look = self.preset.clock, self.painter.looks[name]
        assert look is not None
        exposure = self._trail_interval * clock.step if look.trail is not None else 0.0
        length = max(self.painter.shutter, exposure) if look.length is None else look.length
        steps = math.ceil(length / clock.step - 1e-9)
        interval = max(1, -(-steps // MOMENTS))
        return interval, steps + interval

    @property
    def begun(self) -> int:
        """The number of steps that its simulation had done when this playback began."""
        return self._first_step

    def begins_at(self, step: int) -> int:
        """The step from which a picture after `step` steps must be played to be the film's, with all of its trails and blur."""
        clock = self.preset.clock
        auto, first = self.preset.develop.auto_exposure, step
        if auto is not None:
            first -= round(max(metering_ages(auto, clock.fps)) * clock.fps) * clock.steps_per_frame
        first -= (self._subframes - 1) * self._subframe_interval
        reaches = [reach for _, reach in self._path_steps.values()]
        for history in self.painter.histories.values():
            reaches.append(math.ceil(history.ribbon.length / clock.step) + 1)
        for name, flashes in self.painter.album.flashes.items():
            reaches.append((flashes.number + 1) * self._flash_steps[name])
        if self._trail_interval and self.painter.trails:
            longest = max(look.trail.half_life for look in self.painter.trails.values() if look.trail is not None)
            faded = math.ceil(_HALF_LIVES * longest * clock.speed / clock.step)
            first -= faded + self._trail_interval
        if self._shows_acceleration:
            reaches.append(1)
        return max(0, first - max(reaches, default=0))

    def step_of(self, time: float) -> int:
        """The number of steps from the start to film time `time`. Raises UsageError for a time between two steps."""
        return self.preset.clock.step_at(time)

    def picture(self, step: int) -> np.ndarray:
        """The linear picture after `step` steps from the start: a view that the next picture overwrites."""
        return next(self.pictures([step]))[0]

    def pictures(self, steps: Sequence[int]) -> Iterator[tuple[np.ndarray, float]]:
        """(linear picture, exposure in stops) after each of these numbers of steps, which must be in order.

        Each picture is a view that the next one overwrites. The stops are added to the preset's exposure; for automatic
        exposure, earlier pictures are rendered and metered too.
        """
        if self._is_new and len(steps):
            self._leave_out_births(steps[0])
        auto = self.preset.develop.auto_exposure
        if auto is None:
            yield from ((self._picture(step), 0.0) for step in steps)
            return
        wanted, levels = set(steps), self._levels
        metered = {earlier for shown in steps for earlier, _ in self._metered_steps(shown)}
        for step in sorted(wanted | metered - levels.keys()):
            picture = self._picture(step)
            levels[step] = metered_stops(picture)
            if step in wanted:
                values, ages = zip(*((levels[earlier], age) for earlier, age in self._metered_steps(step)))
                yield picture, smoothed_exposure(values, ages, auto)

    def _leave_out_births(self, step: int) -> None:
        """Leave out particles that are dead before anything of the first picture, after `step` steps, is shown."""
        from gen_art.simulation.unneeded_births import leave_out_births

        begins = self.begins_at(step)
        if self.painter.trails:
            begins = min(begins, max(0, self._trail_steps.start - self._trail_interval))
        leave_out_births(self.sim, begins)
        self._is_new = False

    def _metered_steps(self, step: int) -> list[tuple[int, float]]:
        """The pictures that set a picture's automatic exposure: (steps from the start, s before the picture)."""
        clock = self.preset.clock
        ages = metering_ages(self.preset.develop.auto_exposure, clock.fps)
        metered = [(step - round(age * clock.fps) * clock.steps_per_frame, age) for age in ages]
        first = max(clock.preroll_steps, self._first_step)
        return [(earlier, age) for earlier, age in metered if earlier >= first or earlier == step]

    def _picture(self, step: int) -> np.ndarray:
        pictures: list[np.ndarray] = []
        actions: dict[int, list[Callable]] = {}  # by step

        def paint():
            self.sim.check_finite()
            picture = self.painter.paint(self.sim, self._film_time())
            if not pictures and self._subframes > 1:
                pictures.append(np.array(picture))
            elif pictures:
                pictures[0] += picture
            else:
                pictures.append(picture)

        for at, action in self._due_actions(step):
            actions.setdefault(at, []).append(action)
        interval = self._subframe_interval
        painted = [
            at for at in (step - k * interval for k in range(self._subframes)) if at >= self._first_step or at == step
        ]
        for at in painted:
            actions.setdefault(at, []).append(paint)
        wait = Wait(self._tell, step) if self._tell is not None and self._last_shown < 0 else None
        for at in sorted(actions):
            with self.stopwatch.stage("simulate"):
                self._advance(at - self.sim.steps_done, wait)
            with self.stopwatch.stage("draw"):
                for action in actions[at]:
                    action()
        self._last_shown = self._last_flashed = step
        return pictures[0] if len(painted) == 1 else pictures[0] / np.float32(len(painted))

    def developed(
        self, linear: np.ndarray, exposure: float, frame: int, transparent: bool = False, bits: int = 8
    ) -> np.ndarray:
        """The finished picture of the last linear one: (height, width, 3 or 4) uint8 or uint16, with legends, axes and labels.

        exposure : stops, as `pictures` gives them
        frame : its number, for the dither
        """
        with self.stopwatch.stage("develop"):
            picture = develop(
                linear, self.preset.develop, frame=frame, transparent=transparent, bits=bits, exposure=exposure
            )
            self.draw_over(picture)
        return picture

    def draw_over(self, picture: np.ndarray) -> None:
        """Draw the legends, axes and labels of the last picture into it, after development.

        picture : (height, width, 3 or 4) uint8 or uint16, sRGB, with straight alpha if it has four channels
        Raises PresetError for a total of a legend that is not finite.
        """
        self.joules()
        taken = draw_legends(picture, self.painter.legends(self.sim))
        if self.preset.axes is not None or self.preset.labels:
            time = self._film_time()
            view = self.painter.view(self.sim, time)
            if self.preset.axes is not None:
                draw_axes(picture, self.preset.axes, view, self.preset.units.length)
            draw_labels(picture, self.preset.labels, view, time, self._followed(), taken)

    def _followed(self) -> dict[str, np.ndarray]:
        """(3,) by name, the mean position of the living particles of the systems that labels follow."""
        means = {}
        for name in {label.follow for label in self.preset.labels if label.follow is not None}:
            if (subject := followed(self.sim, name)) is not None:
                means[name] = subject.position
        return means

    def joules(self) -> list[dict]:
        """The joules that the last picture's looks go by, for its recipe: system, entry as in YAML, total and unit.

        Raises PresetError for a total that is not finite.
        """
        entries = []
        for name, totals in self.sim.joules().items():
            for entry, total in totals.items():
                if not math.isfinite(total):
                    raise PresetError(
                        f"{entry.title} in system '{name}' is {total} J: a mass or a speed is too large for its square in float32"
                    )
                unit = self.preset.units.energy
                entries.append({"system": name, "by": entry.plain, "total": total, "unit": unit})
        return entries

    def aovs(self) -> dict[str, np.ndarray]:
        """Layers of depth, motion and surfaces of the last picture: see gen_art.renderer.aovs."""
        clock = self.preset.clock
        return render_aovs(self.painter, self.sim, self._film_time(), 1.0 / clock.fps, clock.speed / clock.fps)

    def _due_actions(self, step: int) -> Iterator[tuple[int, Callable]]:
        """(step, action) of the trails, ribbons and flashes, for the steps after the last picture up to this one."""
        clock = self.preset.clock

        def expose():
            seconds = self._trail_interval * clock.step / clock.speed
            self.painter.expose_trails(self.sim, self._film_time(), seconds, self._trail_interval * clock.step)

        for at in _steps_between(self._trail_steps, self._last_shown, step):
            yield at, expose
        for name, history in self.painter.histories.items():
            interval = max(1, round(history.ribbon.length / history.ribbon.points / clock.step))
            earliest = max(step - (self._subframes - 1) * self._subframe_interval, clock.preroll_steps)
            first = max(0, earliest // interval - history.ribbon.points) * interval

            def remember(name=name, history=history):
                history.remember(self.painter.particles(self.sim, name), self.sim.time)

            for at in _steps_between(range(first, _ENDLESS, interval), self._last_shown, step):
                yield at, remember
        for name, (interval, reach) in self._path_steps.items():

            def remember_path(name=name):
                self.painter.paths[name].remember(self.painter.particles(self.sim, name), self.sim.time)

            if name in self.painter.trails:
                first = self._trail_steps.start - reach
            else:
                first = step - (self._subframes - 1) * self._subframe_interval - reach
            first = -(-max(0, first) // interval) * interval
            for at in _steps_between(range(first, _ENDLESS, interval), self._last_shown, step):
                yield at, remember_path

        for name, interval in self._flash_steps.items():

            def flash(name=name):
                self.painter.flash(self.sim, name, self._film_time())

            kept = self.painter.album.flashes[name].number + 1
            earliest = step - (self._subframes - 1) * self._subframe_interval - clock.preroll_steps
            first = clock.preroll_steps + max(0, earliest // interval - kept) * interval
            for at in _steps_between(range(first, _ENDLESS, interval), self._last_flashed, step):
                yield at, flash

    def _advance(self, steps: int, wait: Wait | None = None) -> None:
        step = self.sim.step if wait is None else partial(wait.advance, self.sim.step)
        if steps > 0:
            if self._shows_acceleration:
                if steps > 1:
                    step(steps - 1)
                self.painter.remember_velocities(self.sim)
                steps = 1
            step(steps)
        elif self._shows_acceleration and self.sim.steps_done == 0:
            # before the first step the acceleration comes from the first step of a second simulation
            from gen_art.simulation import Simulation

            probe = Simulation(self.preset, precision=self._precision, advice="none")
            probe.step(1)
            self.painter.remember_velocities(probe)

    def _film_time(self) -> float:
        clock = self.preset.clock
        return (self.sim.steps_done - clock.preroll_steps) * clock.step / clock.speed

    @property
    def particles(self) -> int:
        return sum(int(system.count) for system in self.sim.systems.values())


def _steps_between(steps: range, after: int, last: int) -> range:
    """The members of an endless range from after + 1 to last, both included."""
    if not steps:
        return steps
    skipped = max(0, -(-(after + 1 - steps.start) // steps.step))
    return range(steps.start + skipped * steps.step, last + 1, steps.step)
