"""Variations of a preset, for sheets and sweeps: seeds, values along one or two axes, and mutations of its knobs."""

import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from gen_art.errors import UsageError
from gen_art.preset.knobs import Knob
from gen_art.preset.overrides import split_path
from gen_art.preset.reader import read_value
from gen_art.preset.values import number, shown

__all__ = ["MOST", "Axis", "Variation", "grid_of", "in_rows", "mutations", "parse_seeds", "parse_vary"]

MOST = 10_000  # variations of one sheet or sweep
LARGEST_SEED = 2**63 - 1
_STEPS = re.compile(r"\s*([^,\[\]{}]+?)\.\.([^,\[\]{}]+?)\.\.(\d+)\s*")
_SEEDS = re.compile(r"\s*(\d{1,19})(?:\.\.(\d{1,19}))?\s*")


@dataclass(frozen=True)
class Variation:
    """One variation: what it changes, by dotted path ("seed" among them), and the words and names for it."""

    changes: dict[str, Any] = field(default_factory=dict)
    label: str = "as it is"

    @property
    def names(self) -> dict[str, str]:
        """For file names: the last word of each path -> its value as text."""
        return {_last_word(path): _text(value) for path, value in self.changes.items()}

    def __add__(self, other: "Variation") -> "Variation":
        return Variation({**self.changes, **other.changes}, f"{self.label}, {other.label}")


@dataclass(frozen=True)
class Axis:
    """The values that one dotted path takes."""

    path: str
    values: tuple

    @property
    def variations(self) -> list[Variation]:
        word = _last_word(self.path)
        return [Variation({self.path: value}, f"{word} {_text(value)}") for value in self.values]


def parse_vary(text: str) -> Axis:
    """`PATH=FIRST..LAST..COUNT`, evenly spaced, or `PATH=A,B,C`, each value as in YAML. Raises UsageError otherwise."""
    path, equals, written = text.partition("=")
    path = path.strip()
    help_text = "write a path and its values: knobs.heat=1200..1900..6 (first..last..how many), or knobs.heat=1200,1500"
    if not equals or not path or not written.strip():
        raise UsageError(f"--vary {shown(text)}: {help_text}")
    split_path(path)
    steps = _STEPS.fullmatch(written)
    if steps is None:
        if ".." in written and "," not in written:
            raise UsageError(f"--vary {shown(text)}: {help_text}")
        return Axis(path, tuple(read_value(part, f"--vary {path}") for part in _parts(written)))
    try:
        first, last, count = number(steps[1]), number(steps[2]), int(steps[3])
    except UsageError as error:
        raise UsageError(f"--vary {path}: {error}; {help_text}") from error
    if not 2 <= count <= MOST:
        raise UsageError(f"--vary {path}: {count} values are asked for; it can be 2 to {MOST:,}")
    return Axis(path, tuple(_plain(first + (last - first) * (k / (count - 1))) for k in range(count)))


def parse_seeds(text: str) -> Axis:
    """`0..15` (first..last) or `3,7,12`, as an axis of seeds. Raises UsageError otherwise."""
    seeds: list[int] = []
    for part in text.split(","):
        match = _SEEDS.fullmatch(part)
        if match is None:
            raise UsageError(f"--seeds {shown(text)}: write the first and last seed, 0..15, or each of them: 3,7,12")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            raise UsageError(f"--seeds {shown(text)}: seeds run from small to large: {last}..{first}")
        if last > LARGEST_SEED:
            raise UsageError(f"--seeds {shown(text)}: a seed is at most 2^63 - 1")
        if len(seeds) + last - first + 1 > MOST:
            raise _too_many(len(seeds) + last - first + 1)
        seeds += range(first, last + 1)
    return Axis("seed", tuple(seeds))


def grid_of(axes: Sequence[Axis]) -> list[list[Variation]]:
    """Rows of variations: of one axis a grid about as wide as high, of two a row for each value of the first.

    Raises UsageError for no axis, more than two, one path twice, or more than MOST variations.
    """
    if not 1 <= len(axes) <= 2:
        raise UsageError(f"{len(axes)} things vary: a grid has rows and columns, so name one or two")
    if len({axis.path for axis in axes}) < len(axes):
        raise UsageError(f"{axes[0].path} varies twice")
    number_of = 1
    for axis in axes:
        number_of *= len(axis.values)
    if number_of > MOST:
        raise _too_many(number_of)
    first = axes[0].variations
    if len(axes) == 1:
        return in_rows(first)
    return [[row + column for column in axes[1].variations] for row in first]


def in_rows(variations: Sequence[Variation]) -> list[list[Variation]]:
    """The variations row by row, in a grid that is about as wide as high."""
    columns = 1
    while columns * columns < len(variations):
        columns += 1
    return [list(variations[k : k + columns]) for k in range(0, len(variations), columns)]


def _too_many(count: int) -> UsageError:
    return UsageError(f"{count:,} variations are asked for; there can be {MOST:,}")


def mutations(knobs: Mapping[str, Knob], amount: float, count: int, seed: int) -> list[Variation]:
    """`count` variations of the knobs that are numbers; the first is the preset as it is.

    Each knob moves by up to `amount` (0..1) of the width of its range, within that range; one without a range by up to that
    share of its value. `seed` decides how, for each knob and variation by itself.
    Raises UsageError if no knob is a number, or a value is out of its range.
    """
    if not 0.0 < amount <= 1.0:
        raise UsageError(f"--mutate is a share of the knobs' ranges, above 0 and at most 1, not {amount:g}")
    if not 1 <= count <= MOST:
        raise UsageError(f"--count is 1 to {MOST:,}, not {count:,}")
    numbers = {name: knob for name, knob in knobs.items() if knob.number is not None}
    if not numbers:
        raise UsageError("--mutate changes the knobs that are numbers, and the preset has none: --vary names any value")
    found = [Variation()]
    for k in range(1, count):
        changes = {f"knobs.{name}": _moved(knob, amount, f"{seed}/{k}/{name}") for name, knob in numbers.items()}
        found.append(Variation(changes, ", ".join(f"{_last_word(p)} {_text(v)}" for p, v in changes.items())))
    return found


def _moved(knob: Knob, amount: float, seed: str) -> int | float:
    value = knob.number
    assert value is not None
    part = random.Random(seed).uniform(-amount, amount)  # a text as seed: the same on every system
    moved = value * (1.0 + part) if knob.range is None else value + part * (knob.range.hi - knob.range.lo)
    if knob.range is not None:
        moved = min(max(moved, knob.range.lo), knob.range.hi)
    return round(moved) if isinstance(knob.value, int) else float(f"{moved:.4g}")


def _plain(value: float) -> int | float:
    """A number without the digits of round-off, whole where it is."""
    value = float(f"{value:.12g}")
    return int(value) if value.is_integer() and abs(value) < 1e15 else value


def _parts(text: str) -> list[str]:
    """The parts of a text between commas that stand in no bracket and no quotes."""
    parts, depth, quote = [""], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        depth += (letter in "[{") - (letter in "]}") if not quote else 0
        if letter == "," and not depth and not quote:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _last_word(path: str) -> str:
    return path.rpartition(".")[2]


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else value if isinstance(value, str) else shown(value)
