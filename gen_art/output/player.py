"""Plays a preset for the studio and for notebooks: any frame, in any size, soon after any change.

What a change needs is decided by the paths that it touches: the picture developed again, drawn again, or the motion computed
again. While somebody turns a knob of the motion, the particles go on from where they are with the new values (`is_exact` is
then False); `settle` computes the motion anew from its start, a slice at a time. Snapshots of frames that were passed make
going back quick.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import DivergedError, OutputError, UsageError
from gen_art.output.check import check_preset
from gen_art.output.playback import Playback
from gen_art.preset.camera import CameraSpec
from gen_art.preset.estimate import refuse_if_too_large
from gen_art.renderer.fitting import fit_of
from gen_art.renderer.following import living
from gen_art.renderer.painter import Painter
from gen_art.renderer.survey import Moment, survey
from gen_art.simulation import Simulation

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["Player", "Shown", "Superseded"]

SLICE = 0.05  # s that is computed between two looks at whether there is something better to do
SNAPSHOT_PAUSE = (
    0.5  # s of computing between two snapshots, at least, and WRITTEN times as long as writing the last one took
)
WRITTEN = 4.0
MOST_SNAPSHOTS = 512_000_000  # bytes of all of them
DEVELOPED = ("develop", "labels", "axes", "gallery", "expect")  # keys that change nothing before the linear picture
DRAWN = ("camera", "sky", "light", "ground", "shadows", "wormhole", "black_hole")  # keys that change no motion
DRAWN_PARTS = ("look", "looks")  # of a system


class Superseded(Exception):
    """A picture is not wanted any more: what it was computed for has changed."""


@dataclass(frozen=True)
class Shown:
    """A picture of a frame.

    picture : (height, width, 3) uint8
    is_exact : whether it is the frame of the preset as it is, not one whose motion began with other values
    seconds : that it took, by stage
    """

    picture: np.ndarray
    frame: int
    is_exact: bool
    particles: int
    seconds: dict[str, float]


@dataclass(frozen=True)
class _Light:
    """The linear picture that was drawn last, and what it is of."""

    frame: int
    size: tuple[int, int]
    with_history: bool
    linear: np.ndarray
    exposure: float


class Player:
    """The pictures of a preset that changes.

    precision, threads : as for Simulation
    superseded : asked between slices of a long computation; where it says yes, `Superseded` is raised, and what was computed
        is kept
    Its files lie in a folder of its own until `close`. Each picture of `show` is drawn by `playback` of `sim`.
    """

    def __init__(
        self, precision: str = "f32", threads: int | None = None, superseded: Callable[[], bool] = lambda: False
    ):
        self.precision, self.threads = precision, threads
        self.preset: Preset | None = None
        self.sim: Simulation | None = None
        self.is_exact = True
        self.playback: Playback | None = None
        self._superseded = superseded
        self._folder = tempfile.TemporaryDirectory(prefix="gen-art-studio-")
        self._painter: Painter | None = None  # the last one, whose surfaces may rest
        self._light: _Light | None = None
        self._surveyed: tuple[dict, list[Moment]] | None = None  # (plain data, what `camera.frame` goes by)
        self._snapshots: dict[int, Path] = {}  # by steps done
        self._computed, self._pause = 0.0, 0.0  # s since the last snapshot, and until the next

    @property
    def frames(self) -> int:
        """The frames of the film."""
        return self.preset.clock.frames if self.preset is not None else 0

    @property
    def fps(self) -> float:
        """Frames of a second of the film."""
        return self.preset.clock.fps if self.preset is not None else 30.0

    def close(self) -> None:
        self._folder.cleanup()

    def forget(self) -> None:
        """Start anew at the next change, also with an equal preset: its files or plugins are others."""
        self.preset = self.sim = self.playback = self._painter = self._light = self._surveyed = None
        self._drop_snapshots()

    def change(self, preset: "Preset") -> str:
        """Go on with this preset; what that needs: "nothing", "develop", "draw" or "motion".

        Raises PresetError for one of which no picture can be made, MemoryRefused for one that does not fit into memory; the
        one before then stays.
        """
        before = self.preset
        if before is not None and (before is preset or before == preset):
            return "nothing"
        check_preset(preset)
        need = "motion" if before is None else _need(before, preset)
        if need == "motion":  # nothing else changes the number of particles
            refuse_if_too_large(preset, self.precision, preset.camera.size if preset.camera else CameraSpec().size)
        self.preset = preset = preset.with_own_fits()
        if need == "develop":
            if self.playback is not None:
                self.playback.preset = preset
            return need
        self.playback = self._light = None
        if need == "motion":
            self._drop_snapshots()
            self.is_exact = not self._carry_over(same_clock=before is not None and before.clock == preset.clock)
        return need

    def show(self, frame: int, size: tuple[int, int], with_history: bool = True) -> Shown:
        """The picture of a frame, from 0 on. Raises the errors of gen_art.errors.

        with_history : with all of its trails, ribbons, flashes and motion blur, for which frames before it may be played
            again
        """
        assert self.preset is not None
        frame = min(max(0, frame), self.preset.clock.frames - 1)
        started = time.perf_counter()
        light = self._light
        if light is None or (light.frame, light.size) != (frame, size) or with_history > light.with_history:
            step = self._step_of(frame)
            playback = self._playback_before(step, size, with_history)
            linear, exposure = next(playback.pictures([step]))
            light = self._light = _Light(frame, size, with_history, np.array(linear), exposure)
            self._computed += time.perf_counter() - started
            self._keep_snapshot()
        assert self.playback is not None
        drawn = time.perf_counter()
        picture = self.playback.developed(light.linear, light.exposure, frame)
        seconds = {"draw": drawn - started, "develop": time.perf_counter() - drawn}
        sim = self.playback.sim
        alive = sum(len(living(system, sim.time)) for system in sim.systems.values())
        return Shown(picture[..., :3], frame, self.is_exact, alive, seconds)

    def settle(self, frame: int, size: tuple[int, int]) -> Iterator[float]:
        """Compute the motion of a frame from its start, a slice at each turn; yields the part that is done, 0..1.

        Afterwards the pictures are exact. A caller that has something better to do drops the iterator.
        """
        if self.is_exact:
            return
        assert self.preset is not None
        anew, step = self._start(), self._step_of(frame)
        target = self._plan(anew, size).begins_at(step)
        while anew.steps_done < target:
            self._slice(anew, target)
            yield anew.steps_done / target
        self.sim, self.is_exact = anew, True
        self.playback = self._light = None

    def _step_of(self, frame: int) -> int:
        assert self.preset is not None
        return self.preset.clock.preroll_steps + frame * self.preset.clock.steps_per_frame

    def _playback_before(self, step: int, size: tuple[int, int], with_history: bool) -> Playback:
        """A Playback that can play on to a step, with all that the step's picture needs."""
        assert self.preset is not None
        playback = self.playback
        if playback is not None and playback.painter.shown_size == size and playback.sim.steps_done < step:
            first = playback.begins_at(step) if with_history else step - self.preset.clock.steps_per_frame
            if first <= playback.sim.steps_done and (not with_history or playback.begun <= first):
                return playback
        self.playback = self._light = None
        if self.sim is None:
            self.sim, self.is_exact = self._nearest(step), True
        self._fit(size, with_history)
        first = self._plan(self.sim, size).begins_at(step) if with_history else step
        if self.sim.steps_done > first:
            if not self.is_exact and self.sim.steps_done <= step:
                first = self.sim.steps_done  # there is no state before this one: what follows has its history alone
            else:
                self.sim, self.is_exact = self._nearest(first), True
        while self.sim.steps_done < first:
            self._slice(self.sim, first)
            self._keep_snapshot()
            if self._superseded():
                raise Superseded
        if first < step:
            self._keep_snapshot()
        self.playback = self._plan(self.sim, size)
        if self._painter is not None:
            self.playback.painter.keep_surfaces_of(self._painter)
        self._painter = self.playback.painter
        return self.playback

    def _plan(self, sim: Simulation, size: tuple[int, int]) -> Playback:
        return Playback(self.preset, size, self.precision, self.threads, sim=sim)

    def _fit(self, size: tuple[int, int], at_rest: bool) -> None:
        """Find the fit of `camera.frame`. While something moves it goes by what was surveyed before the change."""
        assert self.preset is not None
        if self.preset.camera is None or self.preset.camera.frame is None:
            return
        data = self.preset.resolved()
        if self._surveyed is None or (at_rest and self.is_exact and self._surveyed[0] != data):
            self._surveyed = data, survey(self.preset, self.precision, self.threads)
        self.preset.fits.clear()
        fit_of(self.preset, size, self.precision, self.threads, self._surveyed[1])

    def _start(self) -> Simulation:
        assert self.preset is not None
        return Simulation(self.preset, precision=self.precision, threads=self.threads)

    def _nearest(self, step: int) -> Simulation:
        """The simulation at the latest snapshot that is not after `step`, or at its start."""
        earlier = [at for at in self._snapshots if at <= step]
        return Simulation.restore(self._snapshots[max(earlier)], self.preset) if earlier else self._start()

    def _slice(self, sim: Simulation, target: int) -> None:
        """Advance a simulation towards a step for about SLICE seconds."""
        started, count = time.perf_counter(), 1
        while sim.steps_done < target:
            sim.step(min(count, target - sim.steps_done))
            count = min(2 * count, 16)
            if time.perf_counter() >= started + SLICE:
                break
        self._computed += time.perf_counter() - started

    def _carry_over(self, same_clock: bool) -> bool:
        """Let the particles go on under the preset of now; whether they can, or the motion has to start anew."""
        carried, self.sim = self.sim, None
        if carried is None or carried.steps_done == 0 or not same_clock:
            return False
        assert self.preset is not None
        try:
            self.sim = carried.continued(self.preset)
        except (UsageError, DivergedError):  # its systems are others, or its numbers left the finite ones
            return False
        return True

    def _keep_snapshot(self) -> None:
        assert self.sim is not None
        step = self.sim.steps_done
        if not self.is_exact or self._computed < self._pause or step in self._snapshots:
            return
        path, started = Path(self._folder.name) / f"{step}.gas", time.perf_counter()
        with suppress(OutputError):  # without room for it, going back takes longer
            self.sim.save(path)
            if path.stat().st_size > MOST_SNAPSHOTS // 3:
                path.unlink()
            else:
                self._snapshots[step] = path
        self._computed = 0.0
        self._pause = max(SNAPSHOT_PAUSE, WRITTEN * (time.perf_counter() - started))
        while sum(one.stat().st_size for one in self._snapshots.values()) > MOST_SNAPSHOTS:
            steps = sorted(self._snapshots)  # the one whose neighbours are nearest to each other is missed least
            least = min(range(1, len(steps) - 1), key=lambda k: steps[k + 1] - steps[k - 1])
            self._snapshots.pop(steps[least]).unlink(missing_ok=True)

    def _drop_snapshots(self) -> None:
        for path in self._snapshots.values():
            path.unlink(missing_ok=True)
        self._snapshots = {}


def _need(before: "Preset", after: "Preset") -> str:
    """What has to be done when a preset becomes another: "develop", "draw" or "motion"."""
    entries = [{name: system.ledger_entries for name, system in preset.systems.items()} for preset in (before, after)]
    if entries[0] != entries[1]:
        return "motion"
    old, new = before.resolved(), after.resolved()
    changed = [key for key in {**old, **new} if old.get(key) != new.get(key)]
    # automatic exposure is metered in linear pictures of earlier frames
    need = "develop" if before.develop.auto_exposure == after.develop.auto_exposure else "draw"
    for key in changed:
        if key in DEVELOPED:
            continue
        if not (
            key in DRAWN or (key in ("systems", "clock") and _only_drawn(key, old.get(key) or {}, new.get(key) or {}))
        ):
            return "motion"
        need = "draw"
    return need


def _only_drawn(key: str, old: dict, new: dict) -> bool:
    """Whether a change of the systems, or of the clock, changes no motion."""
    if key == "clock":
        return {**old, "duration": None} == {**new, "duration": None}
    if list(old) != list(new):
        return False

    def moving(system: dict) -> dict:
        return {part: value for part, value in system.items() if part not in DRAWN_PARTS}

    return all(moving(old[name]) == moving(new[name]) for name in old)
