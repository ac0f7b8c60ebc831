"""Sheets: many variations of a preset as small pictures side by side in one picture, each with its words below it.

A sheet's recipe holds the preset of its first cell and what each cell changes in it, so that `rerun` makes the sheet, or one
cell in full size, again.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image, ImageDraw

from gen_art.errors import PresetError, UsageError
from gen_art.font import drawable, font
from gen_art.output.changes import apply_changes, changes_between
from gen_art.output.check import check_preset
from gen_art.output.job import picture_size
from gen_art.output.options import check_options
from gen_art.output.playback import Playback
from gen_art.output.progress import Report
from gen_art.output.recipe import make_recipe
from gen_art.output.stills import write_still
from gen_art.output.target import check_writable, find_target
from gen_art.plugins import load_plugins
from gen_art.preset.estimate import refuse_if_too_large
from gen_art.preset.load import PresetSource, load_preset

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset
    from gen_art.preset.variations import Variation

__all__ = ["cell_preset", "make_sheet", "presets_of", "write_sheet"]

CELL_WIDTH = 320  # pixels, when no size is given
GAP = 8  # pixels around each cell
LARGEST = 16_000  # pixels of a sheet's side
PAPER, INK = (24, 25, 28), (226, 226, 222)
LETTERS = 1 / 22  # size of the words in widths of a cell
LEAST_LETTERS = 9  # pixels


def make_sheet(
    preset, out: str | Path, rows: Sequence[Sequence["Variation"]], *, time: float | None = None,
    size: tuple[int, int] | None = None, precision: str = "f32", threads: int | None = None, overwrite: bool = False,
    progress: Callable[[dict], None] | None = None, plugins: Sequence = (), overrides: Mapping[str, Any] | None = None,
) -> list[Path]:  # fmt: skip
    """Write a sheet (.png .jpg .webp) of variations of `preset`; returns the paths written.

    rows : of variations, each row with at most as many as the first
    time : film time of each picture, s; each variation's `gallery.time` when None
    size : (width, height) of a cell in pixels; the preset's, scaled to a width of 320, when None
    overrides : changes of all variations, by dotted path
    Raises the errors of gen_art.errors; that of a variation which is no valid preset names the cell.
    """
    check_options(
        out=out, size=size, precision=precision, threads=threads, plugins=plugins, progress=progress, time=time
    )
    presets = presets_of(PresetSource.of(preset), rows, overrides or {})
    labels = [[variation.label for variation in row] for row in rows]
    cells = [[(one, one.poster_time if time is None else float(time)) for one in row] for row in presets]
    return write_sheet(
        cells, labels, out, size=size, precision=precision, threads=threads, overwrite=overwrite, progress=progress,
        plugins=load_plugins(plugins),
    )  # fmt: skip


def presets_of(
    source: PresetSource, rows: Sequence[Sequence["Variation"]], overrides: Mapping[str, Any]
) -> list[list["Preset"]]:
    """The preset of each variation. Raises PresetError, or UsageError, with a note that names the variation which is wrong."""
    presets: list[list[Preset]] = []
    for row in rows:
        presets.append([])
        for variation in row:
            try:
                presets[-1].append(source.load({**overrides, **variation.changes}))
            except (PresetError, UsageError) as error:
                error.add_note(f"this is the variation with {variation.label}")
                raise
    return presets


def write_sheet(
    rows: Sequence[Sequence[tuple["Preset", float]]], labels: Sequence[Sequence[str]], out, *, size=None, precision="f32",
    threads=None, overwrite=False, progress=None, plugins=(),
) -> list[Path]:  # fmt: skip
    """Draw the cells, (preset, film time) row by row, and write the sheet with its recipe. Options as for `make_sheet`."""
    first = rows[0][0][0]
    target = find_target(out, moving=False, name=first.name, seed=first.seed)
    if target.extension == ".exr":
        raise UsageError(f"{target.path.name}: a sheet has words in it and is a .png, .jpg or .webp")
    check_writable([target.path], overwrite)
    if size is None:
        size = picture_size(first, None, CELL_WIDTH / picture_size(first)[0])
    page = _Page(size, len(rows), max(map(len, rows)))
    for preset, time in (cell for row in rows for cell in row):
        check_preset(preset)
        refuse_if_too_large(preset, precision, size, preset.clock.step_at(time) * preset.clock.step)
    report = Report(progress, sum(map(len, rows)))
    cells: list[list[dict]] = []
    for r, (row, words) in enumerate(zip(rows, labels)):
        cells.append([])
        for c, ((preset, time), label) in enumerate(zip(row, words)):
            playback = Playback(preset, size, precision, threads)
            linear, exposure = next(playback.pictures([playback.step_of(time)]))
            page.put(
                r, c, playback.developed(linear, exposure, round(time * preset.clock.fps)), f"{c + 1},{r + 1}  {label}"
            )
            cells[-1].append(
                {"label": label, "time": time, "changes": changes_between(first.resolved(), preset.resolved())}
            )
            report(r * len(rows[0]) + c, playback.particles)
    files = list(dict.fromkeys(file for row in rows for preset, _ in row for file in preset.files))
    recipe = make_recipe(
        first, files=files, plugins=plugins, kind="sheet", cells=cells, size=list(size), quality="final", precision=precision,
        transparent=False,
    )  # fmt: skip
    write_still(target.path, page.pixels, recipe, overwrite)
    return [target.path]


def cell_preset(recipe: dict, column: int, row: int) -> tuple["Preset", float]:
    """(preset, film time) of a cell of a sheet's recipe; the first column and row are 1.

    Raises UsageError for a cell that the sheet does not have.
    """
    cells = recipe["cells"]
    if not (1 <= row <= len(cells) and 1 <= column <= len(cells[row - 1])):
        raise UsageError(
            f"there is no cell {column},{row}: the sheet has {max(map(len, cells))} columns and {len(cells)} rows, "
            f"{sum(map(len, cells))} cells in all"
        )
    cell = cells[row - 1][column - 1]
    return load_preset({**apply_changes(recipe["preset"], cell["changes"]), "name": recipe["name"]}), cell["time"]


class _Page:
    """The sheet while it is filled: cells of one size with a line of words below each."""

    def __init__(self, size: tuple[int, int], rows: int, columns: int):
        self._size = size
        self._letters = max(LEAST_LETTERS, round(size[0] * LETTERS))
        self._pitch = size[0] + GAP, size[1] + GAP + math.ceil(1.6 * self._letters)
        width, height = GAP + columns * self._pitch[0], GAP + rows * self._pitch[1]
        if max(width, height) > LARGEST:
            raise UsageError(
                f"a sheet of {rows} rows of {columns} cells of {size[0]}x{size[1]} has {width}x{height} pixels; "
                f"at most {LARGEST} are made: give a smaller --size"
            )
        self.pixels = np.empty((height, width, 3), np.uint8)
        self.pixels[:] = PAPER

    def put(self, row: int, column: int, picture: np.ndarray, words: str) -> None:
        """Lay a picture and its words into a cell."""
        width, height = self._size
        left, top = GAP + column * self._pitch[0], GAP + row * self._pitch[1]
        self.pixels[top : top + height, left : left + width] = picture[..., :3]
        line = Image.new("RGB", (width, self._pitch[1] - height - GAP), PAPER)
        letters, words = _fitting(drawable(words), width, self._letters)
        ImageDraw.Draw(line).text((0, 0.2 * self._letters), words, fill=INK, font=letters)
        self.pixels[top + height : top + height + line.height, left : left + width] = np.asarray(line)


def _fitting(words: str, width: int, size: int):
    """(font, words) with smaller letters, and then fewer of them, until they fit the width."""
    while size > LEAST_LETTERS and font(size).getlength(words) > width:
        size -= 1
    letters = font(size)
    if letters.getlength(words) <= width:
        return letters, words
    while words and letters.getlength(words + "...") > width:
        words = words[:-1]
    return letters, words + "..."
