"""The render jobs: a film or an image sequence, and one still."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art.arguments import number, shown
from gen_art.errors import EncoderError, OutputError, UsageError
from gen_art.output.background import background
from gen_art.output.check import check_preset
from gen_art.output.options import check_options
from gen_art.output.partial_film import check_partial, partial_path
from gen_art.output.playback import Playback
from gen_art.output.progress import Report
from gen_art.output.recipe import make_recipe
from gen_art.output.stills import write_still
from gen_art.output.target import Target, check_size_of, check_writable, find_target
from gen_art.plugins import load_plugins
from gen_art.preset.clock import MOST_FRAMES
from gen_art.preset.drafting import drafted
from gen_art.preset.estimate import Estimate, refuse_if_too_large
from gen_art.renderer.fitting import fit_of
from gen_art.renderer.painter import check_size

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import TypeAlias

    from gen_art.preset.camera import Fit
    from gen_art.preset.schema import Preset

    AnyPreset: TypeAlias = Preset | str | Path | Mapping[str, Any]

__all__ = ["QUALITIES", "Plan", "check_target", "loaded", "picture_size", "plan_film", "plan_still", "render", "still"]

# quality -> factor on the width and height; all but "final" also choose the codec profile "preview"
QUALITIES = {"draft": 0.5, "preview": 1.0, "final": 1.0}


def picture_size(preset, size=None, scale=None, quality: str = "final", even: bool = False) -> tuple[int, int]:
    """(width, height) of a job's pictures: `size`, or the preset's, times `scale` and the factor of `quality`.

    even : round a scaled size to even numbers; a size that is not scaled stays as it is
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


def check_target(
    preset, out, *, size=None, scale=None, quality="final", overwrite=False, moving=True, transparent=False, frames=None,
    codec=None, profile=None, bits=None,
) -> tuple[Target, tuple[int, int]]:  # fmt: skip
    """(target, size) of a job; the options are those of `render`.

    Checks before anything is computed that the output can be written. Raises UsageError for a wrong extension, codec or
    size, OutputError for a path that exists or cannot be written.
    """
    target = find_target(
        out, moving=moving, name=preset.name, seed=preset.seed, transparent=transparent, codec=codec, profile=profile,
        bits=bits,
    )  # fmt: skip
    if target.film is not None and profile is None and quality != "final":
        target = replace(target, film=replace(target.film, profile="preview"))
    size = picture_size(preset, size, scale, quality, even=target.halved)
    check_size_of(target, size)
    if target.extension == ".exr":
        from gen_art.output.exr import check_exr

        check_exr()
    numbers = list(frames) if frames is not None else [0]
    if moving and not target.moving and not target.pattern and len(numbers) > 1:
        raise UsageError(
            f"{target.path.name} is one picture, and {len(numbers)} frames are asked for: write a pattern such as "
            f"{target.path.stem}_####{target.path.suffix}"
        )
    check_writable([target.frame(k) for k in numbers] if target.pattern else [target.path], overwrite)
    if target.film is not None:
        check_partial(partial_path(target.path), overwrite)
    return target, size


@dataclass(frozen=True)
class Plan:
    """A job that can be done: what it writes, the size of its pictures, and the preset that they are drawn of."""

    target: Target
    size: tuple[int, int]
    expected: Estimate
    drawn: "Preset"

    def with_fit(self, preset: "Preset", precision: str, threads: int | None) -> "Fit | None":
        """The fit of the camera in `preset`, the whole one, which the preset that is drawn then has too."""
        fit = fit_of(preset, self.size, precision, threads)
        self.drawn.fits.update(preset.fits)
        return fit


def plan_film(preset, out, *, precision: str, frames, quality: str = "final", **output) -> Plan:
    """The plan of a film or sequence: everything that can be refused before it is made."""
    check_preset(preset)
    target, size = check_target(preset, out, frames=frames, quality=quality, **output)
    until = preset.clock.preroll + frames[-1] * preset.clock.speed / preset.clock.fps
    coded = target.film.codec.memory if target.film else 0.0
    drawn = drafted(preset) if quality == "draft" else preset
    return Plan(target, size, refuse_if_too_large(drawn, precision, size, until, coded), drawn)


def plan_still(preset, out, time: float, *, precision: str, quality: str = "final", **output) -> Plan:
    """The plan of a still at film time `time`, s: everything that can be refused before it is made."""
    check_preset(preset)
    target, size = check_target(preset, out, moving=False, quality=quality, **output)
    steps = preset.clock.step_at(time)
    drawn = drafted(preset) if quality == "draft" else preset
    return Plan(target, size, refuse_if_too_large(drawn, precision, size, steps * preset.clock.step), drawn)


def _step_of_frame(playback: Playback, k: int) -> int:
    clock = playback.preset.clock
    return clock.preroll_steps + k * clock.steps_per_frame


def _tell(times: Callable[[dict], None] | None, playback: Playback) -> None:
    """Say where the time went."""
    if times is not None:
        times({"event": "times", "total": playback.stopwatch.total, **playback.stopwatch.seconds})


def _write_picture(
    submit, playback: Playback, linear: np.ndarray, exposure: float, k: int, target: Target, path: Path, recipe: dict,
    overwrite: bool,
) -> None:  # fmt: skip
    """Write the linear picture of frame k through `submit`: developed and with its legends and labels, or unchanged to EXR."""
    if joules := playback.joules():
        recipe = {**recipe, "joules": joules}
    if target.extension == ".exr":
        from gen_art.output.exr import write_exr

        aovs = {name: np.array(values) for name, values in playback.aovs().items()}
        with playback.stopwatch.stage("encode"):
            stops = playback.preset.develop.exposure + exposure
            submit(write_exr, path, np.array(linear), aovs, target.bits, recipe, stops, overwrite)
    else:
        picture = playback.developed(linear, exposure, k, recipe["transparent"], target.bits)
        with playback.stopwatch.stage("encode"):
            submit(write_still, path, picture, recipe, overwrite)


def loaded(preset, fps=None, quality: str = "final") -> "Preset":
    """The preset of a job of this quality, as its recipe holds it: a draft has no supersample."""
    from gen_art.preset.load import load_preset
    from gen_art.preset.schema import Preset

    found = preset if isinstance(preset, Preset) else load_preset(preset)
    overrides: dict[str, float] = {} if fps is None else {"clock.fps": fps}
    if quality == "draft" and found.camera is not None and found.camera.supersample > 1:
        overrides["camera.supersample"] = 1
    return load_preset(found, overrides=overrides) if overrides else found


def _frame_numbers(frames, preset) -> Sequence[int]:
    if frames is None:
        return range(preset.clock.frames)
    if isinstance(frames, (str, bytes)) or not isinstance(frames, (int, np.integer, Iterable)):
        raise UsageError(f"frames must be a whole number or a range of them, not {shown(frames)}")
    numbers = list(islice([frames] if isinstance(frames, (int, np.integer)) else frames, MOST_FRAMES + 1))
    if not numbers:
        raise UsageError("no frames are asked for")
    if any(not isinstance(k, (int, np.integer)) or k < 0 for k in numbers) or numbers != sorted(set(numbers)):
        raise UsageError("frames must be whole numbers from 0 on, in order")
    if numbers[-1] >= preset.clock.frames:
        last = preset.clock.frames - 1
        raise UsageError(
            f"frame {numbers[-1]} lies past the end: the film has frames 0 to {last}; a longer duration adds more"
        )
    return numbers


def render(
    preset: "AnyPreset", out: str | Path, *, frames: Iterable[int] | int | None = None, size: tuple[int, int] | None = None,
    scale: float | None = None, fps: float | None = None, quality: str = "final", precision: str = "f32",
    threads: int | None = None, overwrite: bool = False, transparent: bool = False, codec: str | None = None,
    profile: str | None = None, bits: int | None = None, progress: Callable[[dict], None] | None = None,
    plugins: Sequence[Any] = (), max_rate: int = 0, times: Callable[[dict], None] | None = None,
) -> list[Path]:  # fmt: skip
    """Render a preset to a film (.mp4 .mov .webm .mkv .gif .webp) or a sequence (frame_####.png); returns the paths written.

    preset : a Preset, a name, a path or a mapping
    frames : a range or one number; all frames when None
    size : (width, height), pixels; the preset's when None
    scale : a factor on the size
    fps : frames a second, in place of the preset's clock.fps
    quality : `draft` halves the width and height, draws without `supersample`, and simulates a part of the particles of large
        systems of light and smoke (gen_art/preset/drafting.py); `draft` and `preview` use the codec profile `preview`
    codec : h264 h265 prores ffv1 vp9 av1; the default of the file extension when None
    profile : preview, web or master: from fast and small to slow and good
    bits : bits a channel; 8 or 10 where the codec has both, 16 for FFV1, .png and .exr, 32 for .exr
    progress : called with {"event": "frame", "frame", "frames", "particles", "fps", "eta"} after each frame, and where more than
        ten seconds pass before the first, with {"event": "wait", "steps", "of", "eta"}: steps done and in all, seconds left
    times : called at the end with {"event": "times", "total", "simulate", "draw", "develop", "encode"}, in seconds; "encode" is
        what the others waited for it
    max_rate : the most bits a second of H.264 and H.265; 0 for no limit beyond the profile
    Frame k is the picture that `still` makes at film time k / fps. Raises the errors of gen_art.errors; when a film fails,
    its finished part is kept as NAME.partial.EXT, and the error's message or note names that file.
    """
    check_options(
        out=out, size=size, scale=scale, fps=fps, quality=quality, precision=precision, threads=threads, bits=bits,
        plugins=plugins, progress=progress, codec=codec, profile=profile,
    )  # fmt: skip
    loaded_plugins = load_plugins(plugins)
    spec = loaded(preset, fps, quality)
    numbers = _frame_numbers(frames, spec)
    plan = plan_film(
        spec, out, precision=precision, size=size, scale=scale, quality=quality, overwrite=overwrite,
        transparent=transparent, frames=numbers, codec=codec, profile=profile, bits=bits,
    )  # fmt: skip
    target, size, fit = plan.target, plan.size, plan.with_fit(spec, precision, threads)
    report = Report(progress, len(numbers))
    job = {
        "bits": target.bits, "size": list(size), "fps": spec.clock.fps, "quality": quality, "precision": precision,
        "transparent": transparent, "fit": fit,
    }  # fmt: skip
    if target.film is not None:
        film = target.film
        recipe = make_recipe(
            spec, plugins=loaded_plugins, kind="film", frames=_first_last_step(numbers), ending=target.extension,
            codec=film.codec.name, profile=film.profile, max_rate=max_rate, **job,
        )  # fmt: skip
        _render_film(target, size, plan.drawn, recipe, precision, threads, numbers, report, overwrite, times)
        return [target.path]
    playback = Playback(plan.drawn, size, precision, threads, transparent, progress)
    paths = [target.frame(k) if target.pattern else target.path for k in numbers]
    recipes = [make_recipe(spec, plugins=loaded_plugins, kind="still", time=k / spec.clock.fps, **job) for k in numbers]
    with background() as submit:
        pictures = playback.pictures([_step_of_frame(playback, k) for k in numbers])
        for k, path, recipe, (linear, exposure) in zip(numbers, paths, recipes, pictures):
            _write_picture(submit, playback, linear, exposure, k, target, path, recipe, overwrite)
            report(k, playback.particles)
    _tell(times, playback)
    return paths


def _render_film(
    target: Target, size, preset, recipe: dict, precision: str, threads, frames, report: Report, overwrite: bool,
    times: Callable[[dict], None] | None,
) -> None:  # fmt: skip
    from gen_art.output.video import film_writer  # imported here because a still does not need the encoders

    film = target.film
    assert film is not None
    writer = film_writer(target.path, size, preset.clock.fps, recipe, film, recipe["max_rate"], overwrite)
    try:
        playback = Playback(preset, size, precision, threads, film.transparent, report.tell)
        for k, (linear, exposure) in zip(frames, playback.pictures([_step_of_frame(playback, k) for k in frames])):
            picture = playback.developed(linear, exposure, k, film.transparent, film.depth)
            with playback.stopwatch.stage("encode"):
                writer.add(picture)
            report(k, playback.particles)
        with playback.stopwatch.stage("encode"):
            writer.close()
        _tell(times, playback)
    except BaseException as error:
        kept = writer.abort()
        if kept is None:
            raise
        if isinstance(error, (EncoderError, OutputError)):
            raise type(error)(f"{error}; {kept}") from error
        error.add_note(str(kept))
        raise


def still(
    preset: "AnyPreset", out: str | Path, time: float | None = None, *, size: tuple[int, int] | None = None,
    scale: float | None = None, fps: float | None = None, quality: str = "final", precision: str = "f32",
    threads: int | None = None, overwrite: bool = False, transparent: bool = False, bits: int | None = None,
    progress: Callable[[dict], None] | None = None, plugins: Sequence[Any] = (),
) -> list[Path]:  # fmt: skip
    """Render one picture (.png .jpg .webp .exr). The other options are those of `render`.

    time : film time, s; the preset's `gallery.time` when None
    bits : bits a channel; 16 makes a 16-bit PNG, 32 a float EXR
    """
    check_options(
        out=out, size=size, scale=scale, fps=fps, quality=quality, precision=precision, threads=threads, bits=bits,
        plugins=plugins, progress=progress, time=time,
    )  # fmt: skip
    loaded_plugins = load_plugins(plugins)
    spec = loaded(preset, fps, quality)
    time = spec.poster_time if time is None else number("time", time, "s", low=0.0)
    plan = plan_still(
        spec, out, time, precision=precision, size=size, scale=scale, quality=quality, overwrite=overwrite,
        transparent=transparent, bits=bits,
    )  # fmt: skip
    target, size, fit = plan.target, plan.size, plan.with_fit(spec, precision, threads)
    playback = Playback(plan.drawn, size, precision, threads, transparent, progress)
    linear, exposure = next(playback.pictures([playback.step_of(float(time))]))
    frame = round(float(time) * spec.clock.fps)
    recipe = make_recipe(
        spec, plugins=loaded_plugins, kind="still", time=float(time), bits=target.bits, size=list(size),
        fps=spec.clock.fps, quality=quality, precision=precision, transparent=transparent,
        fit=fit,
    )  # fmt: skip
    _write_picture(_call, playback, linear, exposure, frame, target, target.path, recipe, overwrite)
    Report(progress, 1)(0, playback.particles)
    return [target.path]


def _call(function, *args) -> None:
    function(*args)


def _first_last_step(frames) -> list[int]:
    numbers = list(frames)
    step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
    return [int(numbers[0]), int(numbers[-1]), int(step)]
