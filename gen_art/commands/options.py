"""Options that several commands share, and the types of their values."""

import functools
import re
from typing import Any

import click

__all__ = [
    "CELL",
    "FRAMES",
    "NOT_NEGATIVE",
    "POSITIVE",
    "SCALE",
    "SIZE",
    "TIME",
    "TRANSPARENT",
    "film_options",
    "grid",
    "load",
    "one_picture_options",
    "picture_options",
    "preset_options",
    "process_options",
    "run_options",
    "size_options",
    "source",
    "vary_options",
]


class _Word(click.Choice):
    """One of several words; the error for another word suggests the nearest."""

    def convert(self, value, parameter, context):
        from gen_art.registry import suggest

        if value not in self.choices:
            self.fail(
                f"'{value}' is unknown{suggest(value, self.choices)}; there are {', '.join(self.choices)}",
                parameter,
                context,
            )
        return value


class _Frames(click.ParamType):
    """`12`, `0..89` or `0..99..10` (first..last..step) as a range of frame numbers."""

    name = "frames"

    def convert(self, value, parameter, context):
        if isinstance(value, range):
            return value
        match = re.fullmatch(r"(\d{1,9})(?:\.\.(\d{1,9}))?(?:\.\.(\d{1,9}))?", value.strip())
        if not match:
            self.fail(f"{value!r}: write 12, 0..89 or 0..99..10 (first..last..step)", parameter, context)
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if step < 1 or last < first:
            self.fail(f"{value!r} names no frame: first..last..step, with last at least first", parameter, context)
        return range(first, last + 1, step)


class _Size(click.ParamType):
    """`1280x720` as (1280, 720)."""

    name = "WxH"

    def convert(self, value, parameter, context):
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*(\d{1,6})\s*[xX×]\s*(\d{1,6})\s*", value)
        if not match or not all(1 <= int(side) <= 16384 for side in match.groups()):
            self.fail(f"{value!r}: write WIDTHxHEIGHT in pixels, 1x1 to 16384x16384: 1280x720", parameter, context)
        return int(match[1]), int(match[2])


class _Percent(click.ParamType):
    """`50%` or `0.5` as 0.5, from `low` to `high`."""

    name = "percent"

    def __init__(self, low: float, high: float, example: str):
        self._low, self._high, self._example = low, high, example

    def convert(self, value, parameter, context):
        if isinstance(value, float):
            return value
        match = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(%?)\s*", value)
        scale = float(match[1]) / (100 if match[2] else 1) if match else 0.0
        if not self._low <= scale <= self._high:
            self.fail(
                f"{value!r}: write a percentage from {self._low:.0%} to {self._high:.0%}: {self._example}",
                parameter,
                context,
            )
        return scale


class _Seed(click.ParamType):
    """A whole number, or `random`."""

    name = "seed"

    def convert(self, value, parameter, context):
        if value == "random" or isinstance(value, int):
            return value
        if not re.fullmatch(r"\d{1,19}", value) or int(value) >= 2**63:
            self.fail(f"{value!r}: write a whole number from 0 to 2^63 - 1, or random", parameter, context)
        return int(value)


class _Number(click.ParamType):
    """A finite number above 0, such as `1/2`.

    zero : 0 is allowed too
    """

    name = "number"

    def __init__(self, zero: bool = False):
        self.zero = zero

    def convert(self, value, parameter, context):
        from gen_art.preset.values import number

        try:
            result = number(value)
        except ValueError as error:
            self.fail(str(error), parameter, context)
        if result < 0 or (result == 0 and not self.zero):
            self.fail(f"must be {'at least' if self.zero else 'more than'} 0, not {result:g}", parameter, context)
        return result


class _Cell(click.ParamType):
    """`3,2` as (3, 2): column and row of a sheet, from 1 on."""

    name = "column,row"

    def convert(self, value, parameter, context):
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*(\d{1,5})\s*,\s*(\d{1,5})\s*", value)
        if not match or not int(match[1]) or not int(match[2]):
            self.fail(
                f"{value!r}: write the column and the row, from 1 on, as the sheet has them: 3,2", parameter, context
            )
        return int(match[1]), int(match[2])


CELL = _Cell()
FRAMES, SIZE, SEED = _Frames(), _Size(), _Seed()
SCALE, SHARE = _Percent(0.01, 16.0, "50%"), _Percent(0.01, 1.0, "20%")
POSITIVE, NOT_NEGATIVE = _Number(), _Number(zero=True)


def _arch(context, parameter, value):
    if value != "cpu":
        raise click.BadParameter(f"'{value}' is not available yet: this version runs on cpu only", context, parameter)
    return value


def _stack(*decorators):
    def decorate(function):
        return functools.reduce(lambda f, decorator: decorator(f), reversed(decorators), function)

    return decorate


# the preset, and changes of it
preset_options = _stack(
    click.option("--seed", type=SEED, help="Seed of all random numbers; 'random' chooses one."),
    click.option(
        "--set", "settings", multiple=True, metavar="PATH=VALUE", help="Change a value of the preset (repeatable)."
    ),
    click.option("--fps", type=POSITIVE, help="Frames per second of film."),
    click.option("--duration", type=POSITIVE, help="Length of the film in seconds."),
    click.option(
        "--plugin", "plugins", multiple=True, metavar="FILE.py", help="Load forces and emitters from a Python file."
    ),
)

# how the process runs; the picture does not depend on it
process_options = _stack(
    click.option("--arch", default="cpu", callback=_arch, expose_value=False, show_default=True, help="Backend."),
    click.option(
        "--threads", type=click.IntRange(1, 1024), help="Number of threads; the picture does not depend on it."
    ),
    click.option(
        "--progress",
        type=_Word(["auto", "rich", "json", "none"]),
        default="auto",
        show_default=True,
        help="How progress is shown on standard error.",
    ),
)

# how the simulation is computed
run_options = _stack(
    click.option("--precision", type=_Word(["f32", "f64"]), default="f32", show_default=True, help="Float type."),
    process_options,
)

# the size and quality of the picture
size_options = _stack(
    click.option("--size", type=SIZE, help="Width and height in pixels: 1280x720."),
    click.option("--scale", type=SCALE, help="Scale the preset's size: 50%."),
    click.option(
        "--quality",
        type=_Word(["draft", "preview", "final"]),
        default="final",
        show_default=True,
        help="draft halves the size, leaves supersample out and simulates a part of the particles of large systems; draft and "
        "preview encode films faster.",
    ),
)

TRANSPARENT = click.option("--transparent", is_flag=True, help="Leave the background out, if the format supports it.")

# how a picture is made
picture_options = _stack(
    size_options,
    click.option("--overwrite", is_flag=True, help="Replace output that exists."),
    TRANSPARENT,
    click.option("--dry-run", is_flag=True, help="Check everything and print what would be made, but write nothing."),
)


BITS = _Word(["8", "10", "16", "32"])
TIME = click.option("--time", type=NOT_NEGATIVE, help="Film time in seconds; the preset's gallery.time when left out.")

# the one picture of a command
one_picture_options = _stack(
    click.option("-o", "--output", "out", required=True, metavar="OUT", help="The picture: .png .jpg .webp .exr."),
    TIME,
    click.option(
        "--bits", type=BITS, help="Bits a channel: 8, or 16 as .png; 16 (half, default) or 32 (float) as .exr."
    ),
)

# how a film is encoded
film_options = _stack(
    click.option(
        "--codec",
        type=_Word(["h264", "h265", "prores", "ffv1", "vp9", "av1"]),
        help="Codec of a film; the default of its file extension when left out.",
    ),
    click.option(
        "--profile",
        type=_Word(["preview", "web", "master"]),
        help="Quality of the encoder; web when left out, or preview with --quality draft or preview.",
    ),
    click.option("--bits", type=BITS, help="Bits a channel: 8 or 10 in films, 16 in .mkv and .png, 16 or 32 in .exr."),
)


# what differs from one picture of a sheet, or film of a sweep, to the next
vary_options = _stack(
    click.option("--seeds", metavar="SEEDS", help="The seeds: 0..15, or 3,7,12."),
    click.option(
        "--vary", multiple=True, metavar="PATH=VALUES",
        help="A value of the preset (once or twice): PATH=FIRST..LAST..COUNT, or PATH=A,B,C.",
    ),
    click.option("--mutate", type=SHARE, metavar="SHARE", help="Change all knobs by up to this share: 20%."),
    click.option("--count", type=click.IntRange(1, 10_000), help="Number of mutations; 16 when left out."),
)  # fmt: skip


def grid(source, changes, seeds, vary, mutate, count):
    """Rows of the variations of a PresetSource; --seeds comes first, so with --vary it has a row for each value.

    changes : those of all variations, by path
    """
    from gen_art.preset.variations import grid_of, in_rows, mutations, parse_seeds, parse_vary

    if mutate is not None:
        if seeds or vary:
            raise click.UsageError("--mutate changes all knobs by itself: leave out --seeds and --vary")
        first = source.load(changes)
        return in_rows(mutations(first.knobs, mutate, count or 16, first.seed))
    if count is not None:
        raise click.UsageError("--count is the number of mutations: give --mutate too")
    if seeds is None and not vary:
        raise click.UsageError("say what varies: --seeds 0..15, or --vary knobs.NAME=FIRST..LAST..COUNT")
    return grid_of([*([parse_seeds(seeds)] if seeds is not None else []), *map(parse_vary, vary)])


def overrides(settings, fps=None, duration=None) -> dict[str, Any]:
    """The values that --set, --fps and --duration set, by dotted path."""
    from gen_art.preset.overrides import parse_setting

    values = dict(parse_setting(setting) for setting in settings)
    return values | {f"clock.{k}": v for k, v in (("fps", fps), ("duration", duration)) if v is not None}


def source(preset, seed=None, settings=(), fps=None, duration=None, plugins=()):
    """(PresetSource, changes by path, plugins) of a command that loads a preset many times."""
    from gen_art.plugins import load_plugin
    from gen_art.preset.load import PresetSource

    loaded = tuple(load_plugin(path) for path in plugins)
    found, changes = PresetSource.of(preset), overrides(settings, fps, duration)
    if seed is not None:
        changes["seed"] = found.load(changes, seed).seed
    return found, changes, loaded


def load(preset, *, seed=None, settings=(), fps=None, duration=None, plugins=()):
    """(Preset with the options as overrides, plugins). Plugins are loaded first, because they may register keys."""
    from gen_art.plugins import load_plugin
    from gen_art.preset.load import load_preset

    loaded = tuple(load_plugin(path) for path in plugins)
    return load_preset(preset, overrides=overrides(settings, fps, duration), seed=seed), loaded
