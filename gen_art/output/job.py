"""The jobs: a film or a sequence of frames, one still, and a picture made again from its recipe."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from gen_art.errors import EncoderError, OutputError, UsageError
from gen_art.output.background import background
from gen_art.output.playback import Playback
from gen_art.output.read_recipe import read_recipe
from gen_art.output.recipe import make_recipe, verify
from gen_art.output.report import Report
from gen_art.output.stills import write_still
from gen_art.output.target import Target, check_size_of, check_writable, find_target
from gen_art.preset.files import FOLDER
from gen_art.preset.shipped import presets_folder
from gen_art.renderer.painter import check_size
from gen_art.renderer.tone_map import develop

__all__ = ["QUALITIES", "check_target", "picture_size", "render", "rerun", "still"]

QUALITIES = {"draft": 0.5, "preview": 1.0, "final": 1.0}  # of the width and height; they also set the encoder's care


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


MOST_FRAMES = 10_000_000


def check_target(
    preset, out, *, size=None, scale=None, quality="final", overwrite=False, moving=True, transparent=False, frames=None,
    codec=None, profile=None, bits=None,
) -> tuple[Target, tuple[int, int]]:  # fmt: skip
    """What a job writes, and its size; see `render` for the words.

    Refuses what cannot be written before anything is computed: UsageError for an ending, a codec or a size, OutputError
    for a path that exists or cannot be written.
    """
    target = find_target(
        out, moving=moving, name=preset.name, seed=preset.seed, transparent=transparent, codec=codec, profile=profile,
        bits=bits,
    )  # fmt: skip
    if target.film is not None and profile is None and quality != "final":
        target = replace(target, film=replace(target.film, profile="preview"))
    shape = picture_size(preset, size, scale, quality, even=target.halved)
    check_size_of(target, shape)
    if target.ending == ".exr":
        from gen_art.output.exr import check_exr

        check_exr()
    if frames is not None and len(frames) > MOST_FRAMES:
        raise UsageError(
            f"{len(frames):,} frames are asked for, and {MOST_FRAMES:,} are the most at a time: name them by --frames"
        )
    numbers = list(frames) if frames is not None else [0]
    if moving and not target.moving and not target.pattern and len(numbers) > 1:
        raise UsageError(
            f"{target.path.name} is one picture, and {len(numbers)} frames are asked for: write a pattern such as "
            f"{target.path.stem}_####{target.path.suffix}"
        )
    check_writable([target.frame(k) for k in numbers] if target.pattern else [target.path], overwrite)
    return target, shape


def _step(run: Playback, k: int) -> int:
    clock = run.preset.clock
    return clock.preroll_steps + k * clock.steps_per_frame


def _write_picture(
    submit, run: Playback, film: np.ndarray, exposure: float, k: int, target: Target, path: Path, recipe: dict
) -> None:
    """Write the film's light at frame k through `submit`: developed, or as EXR as it is."""
    spec = run.preset.develop
    if target.ending == ".exr":
        from gen_art.output.exr import write_exr

        layers = {name: np.array(values) for name, values in run.layers().items()}
        submit(write_exr, path, np.array(film), layers, target.bits, recipe, spec.exposure + exposure)
    else:
        picture = develop(film, spec, frame=k, transparent=recipe["transparent"], bits=target.bits, exposure=exposure)
        submit(write_still, path, picture, recipe)


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


def render(
    preset, out, *, frames=None, size=None, scale=None, fps=None, quality="final", precision="f32", threads=None,
    overwrite=False, transparent=False, codec=None, profile=None, bits=None,
    progress: Callable[[dict], None] | None = None, plugins=(), max_rate: int = 0,
) -> list[Path]:  # fmt: skip
    """Render a preset to a film (.mp4 .mov .webm .mkv .gif .webp) or a sequence (frame_####.png); gives the paths written.

    preset : a Preset, a name, a path or a mapping      frames : a range or one number; all of them when None
    size : (width, height), the preset's own when None      scale : a factor on it      fps : overrides the clock's
    quality : `draft` has half the width and height; it and `preview` take the profile `preview`
    codec : h264 h265 prores ffv1 vp9 av1, by the ending when None      profile : preview, web or master, the encoder's care
    bits : a channel; 8 or 10 where the codec has both, 16 for FFV1, .png and .exr, 32 for .exr
    progress : called with {"event": "frame", "frame", "frames", "particles", "fps", "eta"} after each frame
    max_rate : bits a second that H.264 and H.265 may take, 0 for what the profile takes
    Frame k is what `still` makes at film time k / fps. Raises the errors of gen_art.errors; what was finished of a film
    that fails is kept as NAME.partial.EXT, and the error's message or note names it.
    """
    plugins = _loaded(plugins)
    preset = _preset(preset, fps)
    frames = _frames(frames, preset)
    target, size = check_target(
        preset, out, size=size, scale=scale, quality=quality, overwrite=overwrite, transparent=transparent, frames=frames,
        codec=codec, profile=profile, bits=bits,
    )  # fmt: skip
    report = Report(progress, len(frames))
    job = {
        "bits": target.bits, "size": list(size), "fps": preset.clock.fps, "quality": quality, "precision": precision,
        "transparent": transparent,
    }  # fmt: skip
    if target.film is not None:
        film = target.film
        recipe = make_recipe(
            preset, plugins=plugins, kind="film", frames=_span(frames), ending=target.ending, codec=film.codec.name,
            profile=film.profile, max_rate=max_rate, **job,
        )  # fmt: skip
        _render_film(target, size, preset, recipe, precision, threads, frames, report)
        return [target.path]
    run = Playback(preset, size, precision, threads)
    paths = [target.frame(k) if target.pattern else target.path for k in frames]
    recipes = [make_recipe(preset, plugins=plugins, kind="still", time=k / preset.clock.fps, **job) for k in frames]
    with background() as submit:
        films = run.films([_step(run, k) for k in frames])
        for k, path, recipe, (light, exposure) in zip(frames, paths, recipes, films):
            _write_picture(submit, run, light, exposure, k, target, path, recipe)
            report(k, run.particles)
    return paths


def _render_film(target: Target, size, preset, recipe: dict, precision: str, threads, frames, report: Report) -> None:
    from gen_art.output.video import film_writer  # a still does without the encoders

    film = target.film
    assert film is not None
    writer = film_writer(target.path, size, preset.clock.fps, recipe, film, recipe["max_rate"])
    try:
        run = Playback(preset, size, precision, threads)
        for k, (light, exposure) in zip(frames, run.films([_step(run, k) for k in frames])):
            picture = develop(
                light, preset.develop, frame=k, transparent=film.transparent, bits=film.depth, exposure=exposure
            )
            writer.add(picture)
            report(k, run.particles)
        writer.close()
    except BaseException as error:
        kept = writer.abort()
        if kept is None:
            raise
        if isinstance(error, (EncoderError, OutputError)):
            raise type(error)(f"{error}; {kept}") from error
        error.add_note(str(kept))
        raise


def still(
    preset, out, time: float, *, size=None, scale=None, fps=None, quality="final", precision="f32", threads=None,
    overwrite=False, transparent=False, bits: int | None = None, progress: Callable[[dict], None] | None = None,
    plugins=(),
) -> list[Path]:  # fmt: skip
    """One picture (.png .jpg .webp .exr) at film time `time` in seconds. See `render`.

    bits : a channel; 16 makes a 16-bit PNG, 32 a float EXR
    """
    plugins = _loaded(plugins)
    preset = _preset(preset, fps)
    target, size = check_target(
        preset, out, size=size, scale=scale, quality=quality, overwrite=overwrite, moving=False, transparent=transparent,
        bits=bits,
    )  # fmt: skip
    run = Playback(preset, size, precision, threads)
    film, exposure = next(run.films([run.step_of(float(time))]))
    frame = round(float(time) * preset.clock.fps)
    recipe = make_recipe(
        preset, plugins=plugins, kind="still", time=float(time), bits=target.bits, size=list(size), fps=preset.clock.fps,
        quality=quality, precision=precision, transparent=transparent,
    )  # fmt: skip
    _write_picture(_at_once, run, film, exposure, frame, target, target.path, recipe)
    Report(progress, 1)(0, run.particles)
    return [target.path]


def _at_once(function, *args) -> None:
    function(*args)


def rerun(picture, out, *, threads=None, overwrite=False, progress=None, plugins=(), folder=None) -> list[Path]:
    """Make a picture or film again from the recipe inside it: the same bytes, when `out` has the same ending.

    folder : where the files lie that its preset names; the current folder, the picture's and the shipped presets' when None
    Raises UsageError when there is no recipe, or when version, plugins or files are not those it was made with.
    Plugins are run only if they are given: a picture names none of its own accord.
    """
    recipe = read_recipe(picture)
    plugins = _loaded(plugins)
    folders = (Path(), Path(picture).parent, presets_folder()) if folder is None else (Path(folder),)
    token = FOLDER.set(verify(recipe, plugins, folders))
    try:
        preset = _preset({**recipe["preset"], "name": recipe["name"]})
    finally:
        FOLDER.reset(token)
    common = {
        "size": tuple(recipe["size"]), "precision": recipe["precision"], "transparent": recipe["transparent"],
        "threads": threads, "overwrite": overwrite, "progress": progress, "plugins": plugins,
    }  # fmt: skip
    same = Path(str(out)).suffix.lower() == recipe.get("ending", Path(picture).suffix.lower())
    bits = recipe.get("bits") if same else None
    if recipe["kind"] == "film":
        first, last, step = recipe["frames"]
        frames = range(first, last + 1, step)
        codec = recipe.get("codec") if same else None
        return _again(
            render, recipe, preset, out, frames=frames, bits=bits, codec=None if codec in ("gif", "webp") else codec,
            profile=recipe.get("profile"), max_rate=recipe.get("max_rate", 0), **common,
        )  # fmt: skip
    return _again(still, recipe, preset, out, recipe["time"], bits=bits, **common)


def _again(job, recipe: dict, preset, out, *args, **common) -> list[Path]:
    """Run a job whose size is already scaled, with the quality's other effects."""
    scale = 1.0 / QUALITIES.get(recipe["quality"], 1.0)
    return job(preset, out, *args, quality=recipe["quality"], scale=scale, **common)


def _span(frames) -> list[int]:
    numbers = list(frames)
    step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
    return [int(numbers[0]), int(numbers[-1]), int(step)]
