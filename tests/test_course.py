"""The presets of the course: each says what it shows, loads, runs and draws."""

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.output.job import still
from gen_art.preset.load import load_preset
from gen_art.preset.shipped import course_names, presets_folder


def test_there_are_some_and_they_go_by_their_name():
    assert {"course/bouncing_balls", "course/obstacles", "course/gas_in_a_box"} <= set(course_names())
    assert load_preset("course/bouncing_balls").name == "bouncing_balls"
    with pytest.raises(ga.UsageError, match="did you mean 'course/bouncing_balls'"):
        load_preset("course_bouncing_balls")


@pytest.mark.parametrize("name", course_names())
def test_it_says_what_it_shows(name):
    first, second, third = (presets_folder() / f"{name}.yaml").read_text(encoding="utf-8").splitlines()[:3]
    assert first.startswith("# ") and len(first.split()) > 5
    assert second.startswith("# Physics: ")
    assert third.startswith("# Change first: ")


@pytest.mark.proof  # most pieces have kernels of their own, whose compilation takes a quarter of an hour in all
@pytest.mark.filterwarnings("error::gen_art.errors.AdviceWarning")
@pytest.mark.parametrize("name", course_names())
def test_it_runs_and_draws(name, tmp_path):
    """A still of early in its film, tiny: lights up, and not everywhere alike."""
    piece = load_preset(name)
    step = piece.clock.step
    if piece.clock.preroll > max(0.5, step):
        piece = load_preset(name, overrides={"clock.preroll": max(1, int(0.5 / step)) * step})
    still(piece, tmp_path / "a.png", min(0.2, piece.clock.duration / 2), size=(64, 36))
    with Image.open(tmp_path / "a.png") as picture:
        light = np.asarray(picture.convert("L"), float)
    assert light.max() > 12 and light.std() > 0.5


def test_every_system_of_the_page_is_shown_and_proved():
    """docs/course.md: what it names is there, and no piece is missing from it."""
    root = Path(__file__).resolve().parent.parent
    page = (root / "docs" / "course.md").read_text(encoding="utf-8")
    assert set(re.findall(r"`(course/\w+)`", page)) == set(course_names())
    scripts = re.findall(r"`(\w+\.py)`", page)
    assert scripts and all((root / "examples" / name).is_file() for name in scripts)
    folders = (root / "tests" / name for name in ("physics", "render"))
    tests = "\n".join(path.read_text(encoding="utf-8") for folder in folders for path in folder.glob("test_*.py"))
    named = re.findall(r"`test_\w+\.py::(test_\w+)`", page)
    assert len(named) > 60 and not [name for name in named if f"\ndef {name}(" not in tests]
    rows = [line for line in page.splitlines() if line.startswith("|")][2:]
    assert all(line.count("|") == 5 and line.split("|")[3].strip() for line in rows)
