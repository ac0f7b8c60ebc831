"""Makes a picture, film or sheet again from the recipe inside it, or one cell of a sheet in full size."""

import tempfile
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from gen_art.errors import UsageError
from gen_art.output.job import QUALITIES, render, still
from gen_art.output.read_recipe import read_recipe
from gen_art.output.recipe import find_files, verify
from gen_art.output.sheet import cell_preset, write_sheet
from gen_art.plugins import load_plugins
from gen_art.preset.camera import Fit
from gen_art.preset.files import FOLDER
from gen_art.preset.load import load_preset
from gen_art.preset.shipped import presets_folder
from gen_art.renderer.fitting import fit_key

__all__ = ["rerun"]


def rerun(
    picture: str | Path, out: str | Path, *, threads: int | None = None, overwrite: bool = False,
    progress: Callable[[dict], None] | None = None, plugins: Sequence[Any] = (), folder: str | Path | None = None,
    other_version: bool = False, cell: tuple[int, int] | None = None,
) -> list[Path]:  # fmt: skip
    """Make a picture, film or sheet again from the recipe inside it: the same bytes if `out` has the same file extension.

    This needs the version of gen-art that made the picture, its plugins, and the files that its preset names (the recipe
    holds the small ones).

    plugins : the recipe's plugins, with the same bytes; a plugin runs only if it is given here
    folder : the folder of the preset's files; when None they are looked for in the current folder, the picture's folder, the
    shipped presets and the recipe
    other_version : accept a picture of another version, with a warning; the bytes may differ
    cell : (column, row) of the cell of a sheet, from 1 on, to make in the preset's full size
    Raises UsageError when there is no recipe, or when the version, the plugins or the files are not the original ones.
    """
    recipe = read_recipe(picture)
    plugins = load_plugins(plugins)
    warning = verify(recipe, plugins, other_version)
    if warning:
        warnings.warn(warning, stacklevel=2)
    if cell is not None and recipe["kind"] != "sheet":
        raise UsageError(f"{picture} is no sheet: leave out the cell")
    folders = (Path(), Path(picture).parent, presets_folder()) if folder is None else (Path(folder),)
    with tempfile.TemporaryDirectory(prefix="gen-art-") as scratch:
        token = FOLDER.set(find_files(recipe, folders, Path(scratch) if folder is None else None))
        try:
            again = _of_sheet(recipe, cell) if recipe["kind"] == "sheet" else _of_recipe(recipe, picture, out)
        finally:
            FOLDER.reset(token)
        return again(out, threads=threads, overwrite=overwrite, progress=progress, plugins=plugins)


def _of_sheet(recipe: dict, cell: tuple[int, int] | None) -> Callable[..., list[Path]]:
    """The job that makes a sheet, or one of its cells in full size, again."""
    if cell is not None:
        preset, time = cell_preset(recipe, *cell)
        return partial(still, preset, time=time, precision=recipe["precision"])
    rows = [[cell_preset(recipe, c + 1, r + 1) for c in range(len(row))] for r, row in enumerate(recipe["cells"])]
    labels = [[entry["label"] for entry in row] for row in recipe["cells"]]
    return partial(write_sheet, rows, labels, size=tuple(recipe["size"]), precision=recipe["precision"])


def _of_recipe(recipe: dict, picture, out) -> Callable[..., list[Path]]:
    """The job that makes a picture or film again, with the recipe's quality and with its size, which that has scaled already."""
    preset = load_preset({**recipe["preset"], "name": recipe["name"]}).take_verdict(recipe)
    if recipe.get("fit") is not None:
        fit = Fit(tuple(recipe["fit"]["move"]), recipe["fit"]["factor"])
        preset.fits[fit_key(recipe["size"], recipe["precision"])] = fit
    same_extension = Path(str(out)).suffix.lower() == recipe.get("ending", Path(picture).suffix.lower())
    common = {
        "size": tuple(recipe["size"]), "scale": 1.0 / QUALITIES.get(recipe["quality"], 1.0), "quality": recipe["quality"],
        "precision": recipe["precision"], "transparent": recipe["transparent"],
        "bits": recipe.get("bits") if same_extension else None,
    }  # fmt: skip
    if recipe["kind"] != "film":
        return partial(still, preset, time=recipe["time"], **common)
    first, last, step = recipe["frames"]
    codec = recipe.get("codec") if same_extension else None
    return partial(
        render, preset, frames=range(first, last + 1, step), codec=None if codec in ("gif", "webp") else codec,
        profile=recipe.get("profile"), max_rate=recipe.get("max_rate", 0), **common,
    )  # fmt: skip
