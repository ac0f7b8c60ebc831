"""Pictures and films of simulations that a script advances itself: `ga.develop`, `ga.still` and `ga.Film`."""

import math
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art import arguments
from gen_art.arguments import shown
from gen_art.errors import EncoderError, OutputError, UsageError
from gen_art.output import job
from gen_art.output.formats import check_film_size, find_format
from gen_art.output.picture import Picture
from gen_art.output.playback import largest_divisor
from gen_art.output.stills import write_still
from gen_art.output.target import check_size_of, check_writable, find_target
from gen_art.preset.develop import DevelopSpec
from gen_art.preset.from_script import model_of
from gen_art.renderer import tone_map
from gen_art.renderer.painter import Painter, check_size
from gen_art.renderer.path_history import MOMENTS
from gen_art.renderer.render_frame import film_time_of, painter_of, render_frame

if TYPE_CHECKING:
    from gen_art.simulation import Simulation

__all__ = ["Film", "develop", "still"]

_DEVELOPED = "develop"  # the name of its keys in messages


def develop(
    linear: np.ndarray, *, bits: int = 8, transparent: bool = False, frame: int = 0, spec: DevelopSpec | None = None, **keys: Any
) -> Picture:  # fmt: skip
    """A picture (height, width, 3 or, transparent, 4), sRGB, of uint8 or, with bits=16, uint16. A notebook shows that of uint8.

    linear : (height, width, 4) linear premultiplied RGBA, as ga.render_frame returns it
    transparent : with a straight alpha channel
    frame : seed of dither and grain
    spec : the `develop` of a preset; or `keys`, those of `develop:` in YAML: tone="agx", exposure=1.0 (stops), bloom=0.1 ...
    Raises UsageError for light of another shape, or that is not finite, and for keys that cannot be meant.
    """
    if spec is not None and keys:
        raise UsageError(f"develop takes a spec, or its keys ({', '.join(keys)}), not both")
    if spec is not None and not isinstance(spec, DevelopSpec):
        raise UsageError(
            f"spec must be the `develop` of a preset, not {shown(spec)}; keys are written develop(linear, tone='agx')"
        )
    light = np.asarray(linear)
    if light.ndim != 3 or light.shape[2] != 4 or not light.size or not np.issubdtype(light.dtype, np.floating):
        raise UsageError(f"linear light is an array (height, width, 4) of floats, not {shown(linear)}")
    if not np.isfinite(light).all():
        raise UsageError("linear light must be finite: this has a NaN or an infinity")
    model = spec or model_of(DevelopSpec, _DEVELOPED, keys) or DevelopSpec()
    developed = tone_map.develop(np.ascontiguousarray(light, np.float32), model, frame, transparent, bits)
    return developed.view(Picture)


def still(
    source: Any, out: str | Path, time: float | None = None, *, size: tuple[int, int] | None = None, camera: Any = None,
    looks: Any = None, sky: Any = None, light: Any = None, ground: Any = None, develop: Any = None, overwrite: bool = False,
    transparent: bool = False, bits: int | None = None, **options: Any,
) -> Path:  # fmt: skip
    """Write one picture (.png .jpg .webp; .exr of a preset); returns its path.

    source : a simulation, drawn as it is now; or a preset, of which the picture at film time `time` (s) is made as
        `gen-art still` makes it, with its recipe inside
    size : (width, height); 1280 x 720, or the preset's, when None
    camera, looks, sky, light, ground : of a simulation, as for ga.render_frame
    develop : of a simulation, a mapping of the keys of `develop:`; the preset's when None
    options : of a preset: scale, fps, quality, precision, threads, progress, plugins
    Raises UsageError for options that do not fit the source, OutputError for a file that exists or cannot be written.
    """
    drawing = {"camera": camera, "looks": looks, "sky": sky, "light": light, "ground": ground, "develop": develop}
    if not hasattr(source, "members"):
        given = [name for name, value in drawing.items() if value is not None]
        if given:
            raise UsageError(
                f"{', '.join(given)}: a preset says this itself; change it by load_preset(..., overrides={{...}})"
            )
        return job.still(
            source, out, time, size=size, overwrite=overwrite, transparent=transparent, bits=bits, **options
        )[0]
    if time is not None or options:
        wrong = ", ".join((*(("time",) if time is not None else ()), *options))
        raise UsageError(f"{wrong}: a simulation is drawn as it is now; advance it to the time of the picture")
    target = find_target(arguments.path("out", out), moving=False, transparent=transparent, bits=bits)
    if target.extension == ".exr":
        raise UsageError(f"{target.path.name}: an .exr is made of a preset; ga.render_frame returns the linear light")
    size = check_size(size or (1280, 720))
    check_size_of(target, size)
    check_writable([target.path], overwrite)
    linear = render_frame(source, size, camera, sky, light, ground, looks)
    spec = _develop_of(source, develop)
    picture = tone_map.develop(linear, spec, 0, transparent, target.bits)
    target.path.parent.mkdir(parents=True, exist_ok=True)
    return write_still(target.path, picture, overwrite=overwrite)


def _develop_of(sim: "Simulation", given: Any) -> DevelopSpec:
    if given is None:
        return sim.preset.develop if sim.preset is not None else DevelopSpec()
    return model_of(DevelopSpec, _DEVELOPED, given) or DevelopSpec()


class Film:
    """A film of a simulation that a script advances between `add` and `add`.

        with ga.Film("x.mp4", size=(1280, 720), fps=30) as film:
            for k in range(90):
                sim.advance(1 / 30)
                film.add(sim)

    From the first `add` on, the film looks at the simulation between pictures, so that trails, ribbons, flashes and the paths of
    streaks are whole. At the end of the block the file gets its name; where an error ends the block, the finished part
    stays as NAME.partial.EXT.

    path : .mp4 .mov .webm .mkv .gif .webp
    size : (width, height)
    speed : simulated seconds for a second of film, by which trails fade, streaks are long and a camera's path goes; the
        preset's, or measured between the first two pictures, when None: their streaks and trails are then not whole
    camera, looks, sky, light, ground, develop : as for ga.still
    codec, profile, bits, transparent, overwrite : as for ga.render
    Raises UsageError for wrong options, OutputError and EncoderError as ga.render.
    """

    def __init__(
        self, path: str | Path, *, size: tuple[int, int] = (1280, 720), fps: float = 30.0, speed: float | None = None,
        camera: Any = None, looks: Mapping[str, Any] | None = None, sky: Any = None, light: Any = None, ground: Any = None,
        develop: Any = None, codec: str | None = None, profile: str | None = None, bits: int | None = None,
        transparent: bool = False, overwrite: bool = False,
    ) -> None:  # fmt: skip
        from gen_art.output.video import film_writer, partial_path  # imported here: a still needs no encoders

        self._size = check_size(size)
        self._fps = arguments.number("fps", fps, above=0.0)
        self._speed = None if speed is None else arguments.number("speed", speed, above=0.0)
        self._drawing = {"camera": camera, "looks": looks, "sky": sky, "light": light, "ground": ground}
        self._develop = develop
        self._film = find_format(
            arguments.path("path", path), codec=codec, profile=profile, bits=bits, transparent=transparent
        )
        check_film_size(self._film, self._size)
        self.path = Path(path)
        check_writable([self.path, partial_path(self.path)], overwrite)
        self.frames = 0
        self._sim: Simulation | None = None
        self._painter: Painter | None = None
        self._next: dict[str, int] = {}  # by what is kept between pictures, the step at which it is due
        self._first_time = self._last_time = 0.0
        self._writer = film_writer(self.path, self._size, self._fps, None, self._film, 0, overwrite)
        self._open = True

    def add(self, sim: "Simulation") -> None:
        """Add a picture of the simulation as it is now. All pictures of a film are of one simulation."""
        if not self._open:
            raise UsageError(f"{self.path.name} is closed: no more pictures can be added")
        if self._sim is None:
            self._begin(sim)
        elif sim is not self._sim:
            raise UsageError("all pictures of a film are of one simulation: make a second film")
        assert self._painter is not None
        if self._speed is None and self.frames == 1:
            self._set_speed((sim.time - self._last_time) * self._fps)
        linear = self._painter.paint(sim, self._film_time(sim))
        self._painter.remember_velocities(sim)
        spec = _develop_of(sim, self._develop)
        picture = tone_map.develop(linear, spec, self.frames, self._film.transparent, self._film.depth)
        self._writer.add(picture)
        self.frames += 1
        self._last_time = sim.time

    def close(self) -> None:
        """Write the film. Raises UsageError for one without pictures."""
        if not self._open:
            return
        self._end()
        if not self.frames:
            self._writer.abort()
            raise UsageError(f"{self.path.name}: a film has at least one picture; nothing was written")
        self._writer.close()

    def __enter__(self) -> "Film":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        if self._open:
            self._end()
            kept = self._writer.abort()
            if kept is not None and not isinstance(error, (EncoderError, OutputError)):
                error.add_note(str(kept))

    def _begin(self, sim: "Simulation") -> None:
        self._painter = painter_of(sim, self._size, transparent=self._film.transparent, **self._drawing)
        if self._speed is None and sim.preset is not None:
            self._speed = sim.preset.clock.speed
        self._sim, self._first_time = sim, sim.time
        if self._speed is not None:
            self._set_speed(self._speed)
        for name in (*self._painter.histories, *self._painter.paths, *self._painter.album.flashes):
            self._next[name] = sim.steps_done
        self.look(sim)
        sim.observe(self)

    def _set_speed(self, speed: float) -> None:
        assert self._painter is not None and self._sim is not None
        if not speed > 0.0:
            raise UsageError(
                "the simulation has not advanced between the film's first two pictures: give the film its speed"
            )
        self._speed = speed
        camera = self._painter.camera
        self._painter.shutter = (camera.shutter if camera else 180.0) / 360.0 * speed / self._fps
        if self._painter.trails:
            self._next["trails"] = self._sim.steps_done + self._interval("trails")

    def _film_time(self, sim: "Simulation") -> float:
        if self._speed is None:
            return 0.0
        if sim.preset is not None and self._speed == sim.preset.clock.speed:
            return film_time_of(sim)
        return (sim.time - self._first_time) / self._speed

    def _interval(self, what: str) -> int:
        """Steps between two moments at which something is kept."""
        assert self._painter is not None and self._sim is not None
        dt = self._sim.dt
        if what in self._painter.album.flashes:
            return max(1, round(self._painter.album.flashes[what].every / dt))
        if self._speed is None:
            return 1
        frame = self._speed / self._fps
        if what == "trails":
            substeps = max(look.trail.substeps for look in self._painter.trails.values() if look.trail is not None)
            steps = max(1, round(frame / dt))
            return steps // largest_divisor(steps, substeps)
        if what in self._painter.histories:
            ribbon = self._painter.histories[what].ribbon
            return max(1, round(ribbon.length / ribbon.points / dt))
        look = self._painter.looks[what]
        assert look is not None
        length = self._painter.shutter if look.length is None else look.length
        return max(1, math.ceil(length / dt / MOMENTS))

    def steps_left(self, done: int) -> int:
        """Of an observer: see gen_art.simulation.observer."""
        return max(1, min(self._next.values(), default=done + 2**31) - done)

    def look(self, sim: "Simulation") -> None:
        """Of an observer: keep what trails, ribbons, streaks and flashes need."""
        assert self._painter is not None
        for what, due in self._next.items():
            if sim.steps_done < due:
                continue
            interval = self._interval(what)
            if what == "trails":
                seconds = interval * sim.dt
                assert self._speed is not None
                self._painter.expose_trails(sim, self._film_time(sim), seconds / self._speed, seconds)
            elif what in self._painter.histories:
                self._painter.histories[what].remember(self._painter.particles(sim, what), sim.time)
            elif what in self._painter.album.flashes:
                self._painter.flash(sim, what, self._film_time(sim))
            else:
                self._painter.paths[what].remember(self._painter.particles(sim, what), sim.time)
            self._next[what] = sim.steps_done + interval

    def _end(self) -> None:
        self._open = False
        if self._sim is not None:
            self._sim.stop_observing(self)
