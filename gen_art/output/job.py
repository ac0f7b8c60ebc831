"""The jobs: a film or a sequence of frames, one still, and a picture made again from its recipe."""

import contextlib
import time as clocks
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from gen_art.errors import UsageError
from gen_art.output.recipe import make_recipe, read_recipe, verify
from gen_art.output.run import Run
from gen_art.output.stills import write_still
from gen_art.output.target import Target, beside, check_writable, find_target
from gen_art.renderer.develop import develop
from gen_art.renderer.frame import check_size

__all__ = ["QUALITIES", "check_target", "picture_size", "render", "rerun", "still"]

QUALITIES = {"draft": 0.5, "preview": 1.0, "final": 1.0}  # of the width and height; they also set the encoder's care
_WAITING = 3  # pictures that may wait for the encoder


def picture_size(preset, size=None, scale=None, quality: str = "final", even: bool = False) -> tuple[int, int]:
    """The size a job has: `size`, else the preset's own, times `scale` and what `quality` takes off.

    A size that was scaled is rounded to even numbers where `even` asks for it; a size that was given is not.
    """
    from gen_art.preset.camera import CameraSpec

    if quality not in QUALITIES:
        raise UsageError(f"quality is one of {', '.join(QUALITIES)}, not {quality!r}")
    width, height = check_size(size or (preset.camera.size if preset.camera else CameraSpec().size))
    factor = (scale or 1.0) * QUALITIES[quality]
    if factor == 1.0:
        return width, height
    unit = 2 if even else 1
    return check_size(tuple(max(unit, round(side * factor / unit) * unit) for side in (width, height)))


def check_target(preset, out, *, size=None, overwrite=False, moving=True, transparent=False, frames=None) -> Target:
    """Refuse what cannot be written before anything is computed: UsageError for an ending or size, OutputError for a
    path that exists or cannot be written.
    """
    size = check_size(size) if size else None
    target = find_target(out, moving=moving, name=preset.name, seed=preset.seed, size=size, transparent=transparent)
    numbers = list(frames) if frames is not None else [0]
    if moving and not target.moving and not target.pattern and len(numbers) > 1:
        raise UsageError(
            f"{target.path.name} is one picture, and {len(numbers)} frames are asked for: write a pattern such as "
            f"{target.path.stem}_####{target.path.suffix}"
        )
    check_writable([target.frame(k) for k in numbers] if target.pattern else [target.path], overwrite)
    return target


def _pictures(run: Run, frames, transparent: bool, bits: int = 8) -> Iterator[tuple[int, np.ndarray]]:
    clock = run.preset.clock
    for k in frames:
        film = run.film(clock.preroll_steps + k * clock.steps_per_frame)
        yield k, develop(film, run.preset.develop, frame=k, transparent=transparent, bits=bits)


def _loaded(plugins):
    from gen_art.plugins import load_plugin

    return tuple(p if hasattr(p, "sha256") else load_plugin(p) for p in plugins)


def _preset(preset, fps=None):
    from gen_art.preset.load import load_preset
    from gen_art.preset.schema import Preset

    if isinstance(preset, Preset) and fps is None:
        return preset
    return load_preset(preset, overrides={"clock.fps": fps} if fps is not None else None)


def _frames(frames, preset) -> range:
    if frames is None:
        return range(preset.clock.frames)
    chosen = range(frames, frames + 1) if isinstance(frames, int) else frames
    numbers = list(chosen)
    if not numbers:
        raise UsageError("no frames are asked for")
    if any(not isinstance(k, (int, np.integer)) or k < 0 for k in numbers) or numbers != sorted(set(numbers)):
        raise UsageError("frames are whole numbers from 0 on, in order")
    if numbers[-1] >= preset.clock.frames:
        last = preset.clock.frames - 1
        raise UsageError(
            f"frame {numbers[-1]} lies past the end: the film has frames 0 to {last}; a longer duration adds more"
        )
    return chosen


def _recipe_job(kind: str, **values) -> dict:
    return {"kind": kind, **values}


def render(
    preset, out, *, frames=None, size=None, scale=None, fps=None, quality="final", precision="f32", threads=None,
    overwrite=False, transparent=False, progress: Callable[[dict], None] | None = None, plugins=(), max_rate: int = 0,
) -> list[Path]:  # fmt: skip
    """Render a preset to a film (.mp4 .gif .webp) or a sequence (frame_####.png); gives the paths written.

    preset : a Preset, a name, a path or a mapping      frames : a range or one number; all of them when None
    size : (width, height), the preset's own when None      scale : a factor on it      fps : overrides the clock's
    quality : `draft` has half the width and height and a fast encoder, `preview` a faster one, `final` the careful one
    progress : called with {"event": "frame", "frame", "frames", "particles", "fps", "eta"} after each frame
    max_rate : bits a second that an .mp4 may take, 0 for what the quality takes
    Frame k is what `still` makes at film time k / fps. Raises the errors of gen_art.errors.
    """
    plugins = _loaded(plugins)
    preset = _preset(preset, fps)
    frames = _frames(frames, preset)
    moving = Path(str(out)).suffix.lower() in (".mp4",)
    size = picture_size(preset, size, scale, quality, even=moving)
    target = check_target(preset, out, size=size, overwrite=overwrite, transparent=transparent, frames=frames)
    report = _Report(progress, len(frames))
    job = {
        "size": list(size),
        "fps": preset.clock.fps,
        "quality": quality,
        "precision": precision,
        "transparent": transparent,
    }
    if not target.moving:
        run = Run(preset, size, precision, threads)
        paths = [target.frame(k) if target.pattern else target.path for k in frames]
        recipes = [
            make_recipe(preset, plugins=plugins, kind="still", time=k / preset.clock.fps, bits=8, **job) for k in frames
        ]
        with _behind(2) as submit:
            for (k, picture), path, recipe in zip(_pictures(run, frames, transparent), paths, recipes):
                submit(write_still, path, picture, recipe)
                report(k, run.particles)
        return paths
    from gen_art.output.video import film_writer  # a still does without the encoders

    recipe = make_recipe(
        preset, plugins=plugins, kind="film", frames=_span(frames), ending=target.ending, max_rate=max_rate, **job
    )
    run = Run(preset, size, precision, threads)
    with beside(target.path) as temporary:
        writer = film_writer(temporary, size, preset.clock.fps, recipe, quality, max_rate)
        try:
            with _behind(1) as submit:
                for k, picture in _pictures(run, frames, transparent):
                    submit(writer.add, picture)
                    report(k, run.particles)
            writer.close()
        except BaseException:
            with contextlib.suppress(Exception):
                writer.abort()
            raise
    return [target.path]


def still(
    preset, out, time: float, *, size=None, scale=None, fps=None, quality="final", precision="f32", threads=None,
    overwrite=False, transparent=False, bits: int = 8, progress: Callable[[dict], None] | None = None, plugins=(),
) -> list[Path]:  # fmt: skip
    """One picture (.png .jpg .webp) at film time `time` in seconds; `bits` 16 makes a 16-bit PNG. See `render`."""
    plugins = _loaded(plugins)
    preset = _preset(preset, fps)
    size = picture_size(preset, size, scale, quality)
    target = check_target(preset, out, size=size, overwrite=overwrite, moving=False, transparent=transparent)
    if bits not in (8, 16) or (bits == 16 and target.ending != ".png"):
        raise UsageError(f"{target.path.name}: a picture has 8 bits a channel, or 16 as .png; not {bits}")
    run = Run(preset, size, precision, threads)
    film = run.film(run.step_of(float(time)))
    frame = round(float(time) * preset.clock.fps)
    picture = develop(film, preset.develop, frame=frame, transparent=transparent, bits=bits)
    recipe = make_recipe(
        preset, plugins=plugins, kind="still", time=float(time), bits=bits, size=list(size), fps=preset.clock.fps,
        quality=quality, precision=precision, transparent=transparent,
    )  # fmt: skip
    write_still(target.path, picture, recipe)
    _Report(progress, 1)(0, run.particles)
    return [target.path]


def rerun(picture, out, *, threads=None, overwrite=False, progress=None, plugins=()) -> list[Path]:
    """Make a picture or film again from the recipe inside it: the same bytes, when `out` has the same ending.

    Raises UsageError when there is no recipe, or when version, plugins or files are not those it was made with.
    Plugins are run only if they are given: a picture names none of its own accord.
    """
    recipe = read_recipe(picture)
    plugins = _loaded(plugins)
    verify(recipe, plugins)
    preset = _preset({**recipe["preset"], "name": recipe["name"]})
    common = {
        "size": tuple(recipe["size"]), "precision": recipe["precision"], "transparent": recipe["transparent"],
        "threads": threads, "overwrite": overwrite, "progress": progress, "plugins": plugins,
    }  # fmt: skip
    if recipe["kind"] == "film":
        first, last, step = recipe["frames"]
        frames = range(first, last + 1, step)
        return _again(render, recipe, preset, out, frames=frames, max_rate=recipe.get("max_rate", 0), **common)
    return _again(still, recipe, preset, out, recipe["time"], bits=recipe.get("bits", 8), **common)


def _again(job, recipe: dict, preset, out, *args, **common) -> list[Path]:
    """Run a job whose size is already scaled, with the quality's other effects."""
    scale = 1.0 / QUALITIES[recipe["quality"]]
    return job(preset, out, *args, quality=recipe["quality"], scale=scale, **common)


def _span(frames) -> list[int]:
    numbers = list(frames)
    step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
    return [int(numbers[0]), int(numbers[-1]), int(step)]


class _Report:
    """Progress events with the rate so far and the seconds left."""

    def __init__(self, progress, frames: int):
        self._progress, self._frames, self._done, self._start = progress, frames, 0, clocks.perf_counter()

    def __call__(self, frame: int, particles: int) -> None:
        self._done += 1
        if self._progress is None:
            return
        rate = self._done / max(clocks.perf_counter() - self._start, 1e-9)
        self._progress(
            {
                "event": "frame",
                "frame": self._done - 1,
                "number": int(frame),
                "frames": self._frames,
                "particles": particles,
                "fps": rate,
                "eta": (self._frames - self._done) / rate,
            }
        )


@contextlib.contextmanager
def _behind(workers: int) -> Iterator[Callable]:
    """Run calls behind the main thread, a few at most waiting; the first error is raised where the next call is made."""
    with ThreadPoolExecutor(workers, thread_name_prefix="gen-art-output") as pool:
        waiting: list = []

        def submit(function, *args) -> None:
            while len(waiting) >= _WAITING:
                waiting.pop(0).result()
            waiting.append(pool.submit(function, *args))

        try:
            yield submit
            for one in waiting:
                one.result()
        finally:
            for one in waiting:
                one.cancel()
