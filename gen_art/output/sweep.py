"""Sweeps: a film or picture of each of many variations of a preset, one after the other, in one process.

Each file gets its name when it is whole. A sweep that was stopped is run again by the same command: what it has made, by the
recipe inside, is left as it is.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gen_art.errors import GenArtError, UsageError
from gen_art.files import sha256
from gen_art.output import job
from gen_art.output.read_recipe import read_recipe
from gen_art.output.recipe import version
from gen_art.output.sheet import presets_of
from gen_art.output.target import FILMS
from gen_art.preset.load import PresetSource
from gen_art.registry import suggest

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset
    from gen_art.preset.variations import Variation

__all__ = ["Unit", "is_of", "plan_sweep", "sweep"]

FILM_OPTIONS = ("codec", "profile")
_FIELD = re.compile(r"\{([^{}]*)\}")
_UNFIT = re.compile(r"[^\w.+-]+")  # in a value that becomes part of a file's name


@dataclass(frozen=True)
class Unit:
    """One film or picture of a sweep.

    options : those of `render` or `still`, without the file
    is_made : whether its file is there already, made of this preset in the same way
    """

    preset: "Preset"
    path: Path
    label: str
    is_film: bool
    options: dict[str, Any]
    is_made: bool


def plan_sweep(
    source: Any, out: str, rows: Sequence[Sequence["Variation"]], *, overrides: Mapping[str, Any] | None = None,
    overwrite: bool = False, time: float | None = None, frames: Sequence[int] | None = None, plugins: Sequence = (),
    **options: Any,
) -> list[Unit]:  # fmt: skip
    """The units of a sweep; everything that can be refused is refused here, before anything is made.

    time : of pictures; the moment of each preset when None
    frames : of films; all when None
    options : further ones of `render` or `still`
    out : a path with {seed}, {preset}, {number}, a knob, or the last word of a path that varies: 'out/{seed}_{heat}.mp4'
    Raises UsageError for a pattern that gives two units one name, PresetError for a variation that is no valid preset,
    OutputError for a file that exists and is not of this sweep, unless `overwrite`.
    """
    variations = [variation for row in rows for variation in row]
    presets = [preset for row in presets_of(PresetSource.of(source), rows, overrides or {}) for preset in row]
    if (time is not None and any(options.get(key) for key in ("codec", "profile"))) or (
        time is not None and frames is not None
    ):
        raise UsageError(
            "--frames, --codec and --profile are of films, and --time is of pictures: give one or the other"
        )
    if "#" in Path(out).name:
        raise UsageError(f"-o {out}: a sweep makes films or single pictures, not a picture for each frame")
    units: list[Unit] = []
    seen: dict[Path, str] = {}
    digits = len(str(len(presets)))
    for number, (variation, preset) in enumerate(zip(variations, presets), 1):
        path = Path(_named(out, variation, preset, number, digits))
        if path in seen:
            raise UsageError(
                f"{path} would be the file of two variations, {seen[path]} and {variation.label}: name what varies in -o, "
                f"such as {{{next(iter(variation.names), 'number')}}}"
            )
        seen[path] = variation.label
        is_film = path.suffix.lower() in FILMS and time is None
        if is_film:
            given = {**options, "frames": range(preset.clock.frames) if frames is None else frames}
        else:
            given = {
                **{k: v for k, v in options.items() if k not in FILM_OPTIONS},
                "time": preset.poster_time if time is None else time,
            }
        is_made = path.is_file() and not overwrite and is_of(path, preset, is_film, given, plugins)
        if not is_made:
            (job.plan_film if is_film else job.plan_still)(preset, path, overwrite=overwrite, **given)
        units.append(Unit(preset, path, variation.label, is_film, given, is_made))
    return units


def sweep(
    units: Sequence[Unit], *, threads: int | None = None, overwrite: bool = False, plugins: Sequence = (),
    progress: Callable[[dict], None] | None = None, begin: Callable[[int, Unit], None] | None = None,
) -> list[Path]:  # fmt: skip
    """Make the units that are not made yet, in order; returns the paths of all.

    begin : called with the number, from 0 on, and the unit that is begun
    """
    for k, unit in enumerate(units):
        if unit.is_made:
            continue
        if begin is not None:
            begin(k, unit)
        make = job.render if unit.is_film else job.still
        make(
            unit.preset,
            unit.path,
            threads=threads,
            overwrite=overwrite,
            plugins=plugins,
            progress=progress,
            **unit.options,
        )
    return [unit.path for unit in units]


def _named(out: str, variation: "Variation", preset: "Preset", number: int, digits: int) -> str:
    """The path of a unit, which is the one of this number, from 1 on."""
    words = [path.rpartition(".")[2] for path in variation.changes]
    for word in words:
        if words.count(word) > 1:
            raise UsageError(f"two things that vary are both called '{word}', so {{{word}}} cannot name one of them")
    knobs = {name: str(knob.value) for name, knob in preset.knobs.items()}
    names = {
        **knobs,
        "preset": preset.name,
        "seed": str(preset.seed),
        "number": f"{number:0{digits}d}",
        **variation.names,
    }

    def fill(match: re.Match) -> str:
        if match[1] not in names:
            known = ", ".join(f"{{{name}}}" for name in names)
            raise UsageError(f"-o {out}: nothing is called {{{match[1]}}}{suggest(match[1], names)}; there are {known}")
        return _UNFIT.sub("_", names[match[1]]).strip("_") or "_"

    return _FIELD.sub(fill, out)


def is_of(path: Path, preset: "Preset", is_film: bool, options: Mapping[str, Any], plugins: Sequence) -> bool:
    """Whether the recipe inside a file says that it was made of this preset in this way."""
    try:
        recipe = read_recipe(path)
    except GenArtError:
        return False
    given = {key: value for key, value in options.items() if key not in ("time", "precision")}
    target, size = job.check_target(preset, path, moving=is_film, overwrite=True, **given)
    quality = options.get("quality", "final")
    wanted = {
        "kind": "film" if is_film else "still", "preset": job.loaded(preset, quality=quality).resolved(),
        "gen_art": version(), "size": list(size), "quality": quality, "precision": options.get("precision", "f32"),
        "transparent": options.get("transparent", False), "bits": target.bits,
        "plugins": [{"name": plugin.name, "sha256": plugin.sha256} for plugin in plugins],
    }  # fmt: skip
    if target.film is not None:
        frames = options["frames"]
        wanted["frames"] = [frames[0], frames[-1], frames[1] - frames[0] if len(frames) > 1 else 1]
        wanted |= {"codec": target.film.codec.name, "profile": target.film.profile}
    else:
        wanted["time"] = options["time"]
    files = {str(file): sha256(file.place) for file in preset.files}
    made_of = {file["path"]: file["sha256"] for file in recipe.get("files", ())}
    return files == made_of and all(recipe.get(key) == value for key, value in wanted.items())
