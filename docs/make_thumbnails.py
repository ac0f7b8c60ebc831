"""Draws the sheets of docs/images/: every force, shape, way of drawing, palette and tone map, under its name.

python docs/make_thumbnails.py [SHEET ...]      draws these sheets of docs/thumbnails.yaml, or all, in some minutes
"""

import os
import sys
import tempfile
import typing
from collections.abc import Mapping
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
from make_reference import built_in
from ruamel.yaml import YAML

from gen_art.output import job
from gen_art.preset.develop import DevelopSpec
from gen_art.preset.load import load_preset
from gen_art.preset.look import Look
from gen_art.preset.palettes import PALETTES
from gen_art.preset.shipped import presets_folder

FOLDER = Path(__file__).resolve().parent
SIZE = [240, 180]  # of a thumbnail, where its sheet names none
QUALITY = 82


def choices(model, field: str) -> list[str]:
    """The words that a field of a model allows."""
    return list(typing.get_args(model.model_fields[field].annotation))


def names() -> dict[str, list[str]]:
    """The names that each sheet must show."""
    return {
        "forces": built_in("forces"),
        "shapes": built_in("shapes"),
        "draw_modes": choices(Look, "draw"),
        "palettes": list(PALETTES),
        "tone_maps": choices(DevelopSpec, "tone"),
    }


def sheets() -> dict[str, dict]:
    return YAML(typ="safe").load(FOLDER / "thumbnails.yaml")


def scene(sheet: Mapping, name: str):
    """The preset of one thumbnail."""
    different = {sheet["key"]: name} if "key" in sheet else sheet["names"][name]
    label = {"text": name, "place": [0.04, 0.06], "size": 66, "fade": 0, "color": sheet.get("ink", "white")}
    return load_preset({"name": name, **sheet["preset"], "labels": [label]}, different)


def draw(kind: str, sheet: Mapping, scratch: Path) -> Path:
    """Draws the thumbnails of one sheet beside and below each other."""
    size, pictures = tuple(sheet.get("size", SIZE)), []
    for name in names()[kind]:
        path = scratch / f"{kind}_{name}.png"
        job.still(scene(sheet, name), path, size=size, threads=2)
        pictures.append(imageio.imread(path)[..., :3])
        print(f"{kind}: {name}", flush=True)
    columns, (width, height) = sheet["columns"], size
    rows = -(-len(pictures) // columns)
    whole = np.empty((rows * height, columns * width, 3), np.uint8)
    whole[:] = pictures[-1][-1, -1]
    for k, picture in enumerate(pictures):
        top, left = k // columns * height, k % columns * width
        whole[top : top + height, left : left + width] = picture
    out = FOLDER / "images" / f"{kind}.webp"
    imageio.imwrite(out, whole, quality=QUALITY, method=6)
    return out


def main(wanted: list[str]) -> int:
    known = sheets()
    if unknown := sorted(set(wanted) - set(known)):
        print(f"no such sheet: {', '.join(unknown)}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    os.chdir(presets_folder())  # the folder of the files that the scenes name
    with tempfile.TemporaryDirectory() as scratch:
        for kind in wanted or known:
            out = draw(kind, known[kind], Path(scratch))
            print(f"{out.relative_to(FOLDER.parent)} {out.stat().st_size / 1000:.0f} KB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
