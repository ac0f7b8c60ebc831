"""`gen-art sheet`: cells that are what their stills are, in one process without compiling; a cell or the sheet made again."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gen_art.backend import runtime
from gen_art.output.read_recipe import read_recipe
from gen_art.output.recipe import KEY
from gen_art.output.sheet import GAP
from tests.preset.piece import TEXT

SHEET = ("sheet", "piece.yaml", "-o", "s.png", "--cell", "64x36", "--time", "0.5")


@pytest.fixture
def piece(tmp_path):
    """The test preset with drops that are seen."""
    path = tmp_path / "piece.yaml"
    look = "    look: {draw: disc, size: 0.3, emission: {color: white, intensity: 3}}\n"
    path.write_text(TEXT.replace("        tag: wet\n", f"        tag: wet\n{look}"), encoding="utf-8")
    return path


def digest(path) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def cell(path, column: int, row: int, size=(64, 36)) -> np.ndarray:
    """The pixels of a cell's picture, which lie behind a gap, and above the words."""
    sheet = np.asarray(Image.open(path))
    rows = max(1, len(read_recipe(path)["cells"]))
    pitch = size[0] + GAP, (sheet.shape[0] - GAP) // rows
    left, top = GAP + (column - 1) * pitch[0], GAP + (row - 1) * pitch[1]
    return sheet[top : top + size[1], left : left + size[0]]


def test_each_cell_is_its_still(gen_art, piece):
    assert gen_art(*SHEET, "--seeds", "4,5", "--vary", "knobs.push=6..12..3").status == 0
    for column, push in enumerate((6, 9, 12)):
        for row, seed in enumerate((4, 5)):
            name = f"{column}{row}.png"
            still = (
                "still",
                piece,
                "-o",
                name,
                "--time",
                "0.5",
                "--size",
                "64x36",
                "--seed",
                seed,
                "--set",
                f"knobs.push={push}",
            )
            assert gen_art(*still).status == 0
            assert np.array_equal(cell("s.png", column + 1, row + 1), np.asarray(Image.open(name)))
    pictures = [cell("s.png", c, r).tobytes() for c in (1, 2, 3) for r in (1, 2)]
    assert len(set(pictures)) == 6


def test_a_cell_in_full_size_has_the_bytes_of_its_still(gen_art, piece):
    small = ("--set", "camera.size=[96, 54]")
    assert gen_art(*SHEET, *small, "--vary", "knobs.push=6,12", "--vary", "knobs.life=1..2,3..4,5").status == 0
    assert gen_art("rerun", "s.png", "--cell", "2,1", "-o", "cell.png").status == 0
    still = (
        "still",
        piece,
        "-o",
        "still.png",
        "--time",
        "0.5",
        *small,
        "--set",
        "knobs.push=6",
        "--set",
        "knobs.life=3..4",
    )
    assert gen_art(*still).status == 0
    assert digest("cell.png") == digest("still.png")
    assert Image.open("cell.png").size == (96, 54)


@pytest.mark.parametrize(("extension", "share"), [("png", "0.4"), ("webp", "40%"), ("jpg", "0.4")])
def test_a_sheet_is_made_again(gen_art, piece, extension, share):
    name = f"s.{extension}"
    assert gen_art(*SHEET[:3], name, *SHEET[4:], "--mutate", share, "--count", "5").status == 0
    assert gen_art("rerun", name, "-o", f"again.{extension}").status == 0
    assert digest(name) == digest(f"again.{extension}")
    labels = [one["label"] for row in read_recipe(name)["cells"] for one in row]
    assert labels[0] == "as it is" and len(set(labels)) == 5 and all(label.startswith("push ") for label in labels[1:])


def test_nothing_is_compiled_between_cells(gen_art, piece):
    seen = []

    def told(event):
        seen.append(runtime.compilations())

    from gen_art.output.sheet import make_sheet
    from gen_art.preset.variations import grid_of, parse_vary

    rows = grid_of([parse_vary("knobs.push=6,8,10"), parse_vary("forces.drag.cd=0.2,0.5")])
    make_sheet("piece.yaml", "s.png", rows, size=(32, 18), time=0.5, progress=told)
    assert len(seen) == 6 and len(set(seen)) == 1


def test_a_mutation_by_another_seed_is_another(gen_art, piece):
    for seed in (1, 2):
        assert (
            gen_art(*SHEET[:3], f"{seed}.png", *SHEET[4:], "--mutate", "0.4", "--count", "3", "--seed", seed).status
            == 0
        )
    pushes = [[one["label"] for one in read_recipe(f"{seed}.png")["cells"][0]] for seed in (1, 2)]
    assert pushes[0] != pushes[1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "say what varies"),
        (("--count", "3"), "give --mutate too"),
        (("--mutate", "300%"), "'300%': write a percentage from 1% to 100%: 20%"),
        (("--mutate", "much"), "'much': write a percentage"),
        (("--mutate", "0.2", "--seeds", "1,2"), "leave out --seeds and --vary"),
        (("--seeds", "0..20000"), "20,001 variations are asked for; there can be 10,000"),
        (("--vary", "knobs.pus=1,2"), "there is no knob 'pus'; did you mean 'push'"),
        (("--vary", "knobs.push=1,2", "--vary", "knobs.push=3,4"), "knobs.push varies twice"),
        (("--vary", "knobs.push=1,2", "--vary", "seed=3,4", "--seeds", "1,2"), "3 things vary"),
        (("--seeds", "0..999", "--cell", "1280x720"), "at most 16000 are made"),
    ],
)
def test_wrong_arguments(gen_art, piece, arguments, words):
    result = gen_art(*SHEET[:4], *arguments)
    assert result.status == 2 and words in result.err and not Path("s.png").exists()


def test_a_wrong_variation_is_named(gen_art, piece):
    result = gen_art(*SHEET, "--vary", "forces.drag.cd=0.5,-1")
    assert result.status == 3 and "this is the variation with cd -1" in result.err and "Traceback" not in result.err
    assert gen_art(*SHEET[:3], "s.exr", "--seeds", "1,2").status == 2
    assert gen_art(*SHEET[:3], "s.mp4", "--seeds", "1,2").status == 2


def test_wrong_cells(gen_art, piece):
    assert gen_art(*SHEET, "--seeds", "1..3").status == 0
    for text in ("3,2", "1,9"):
        result = gen_art("rerun", "s.png", "--cell", text, "-o", "x.png")
        assert (
            result.status == 2
            and f"there is no cell {text}: the sheet has 2 columns and 2 rows, 3 cells in all" in result.err
        )
    for text in ("0,1", "3", "a,b"):
        assert gen_art("rerun", "s.png", "--cell", text, "-o", "x.png").status == 2
    assert gen_art("still", piece, "-o", "still.png", "--time", "0.5", "--size", "64x36").status == 0
    assert "still.png is no sheet" in gen_art("rerun", "still.png", "--cell", "1,1", "-o", "x.png").err
    assert gen_art(*SHEET, "--seeds", "1..3").status == 5, "it exists already"


@pytest.mark.parametrize(
    "damage",
    [
        lambda recipe: recipe.update(cells=[]),
        lambda recipe: recipe["cells"][0][0].update(changes=[["seed", 3]]),
        lambda recipe: recipe["cells"][0][0].update(changes=[[["sede"], 3]]),
        lambda recipe: recipe["cells"][0][0].update(changes=[[[{}], 3]]),
        lambda recipe: recipe["cells"][0][0].update(time=-1.0),
    ],
)
def test_a_damaged_recipe_is_a_sentence(gen_art, piece, damage):
    from PIL import PngImagePlugin

    assert gen_art(*SHEET, "--seeds", "1,2").status == 0
    recipe = read_recipe("s.png")
    damage(recipe)
    text = PngImagePlugin.PngInfo()
    text.add_itxt(KEY, json.dumps(recipe))
    Image.open("s.png").save("damaged.png", pnginfo=text)
    result = gen_art("rerun", "damaged.png", "--cell", "1,1", "-o", "x.png")
    assert result.status == 2 and "the recipe is damaged" in result.err
