"""The tour, the recipes and docs/porting.md do what they say: their files are valid, their commands and scripts run, at a small size."""

import importlib
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gen_art.commands.main import run

DOCS = Path(__file__).resolve().parent.parent / "docs"
SIZE = "128x72"


def _module(name: str):
    sys.path.insert(0, str(DOCS))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(DOCS))


page_examples = _module("page_examples")
PAGES = {page.relative_to(DOCS).with_suffix("").as_posix(): page for page in page_examples.pages()}


def small(words: list[str]) -> list[str]:
    """A command at a small size and, of a film, only two pictures."""
    words = list(words)
    if words[0] not in ("still", "render"):
        return words
    if "--size" in words:
        del words[words.index("--size") : words.index("--size") + 2]
    return [*words, "--size", SIZE, "--progress", "none", *(["--frames", "0..1"] if words[0] == "render" else [])]


@pytest.mark.parametrize("name", PAGES)
def test_what_a_page_says_works(name, tmp_path, monkeypatch, capsys):
    """No warning, status 0, and a picture with something on it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))  # a script may import the page's own files
    page = page_examples.examples(PAGES[name])
    assert page.files and page.commands, "a page of the tour and a recipe has something to run"
    page_examples.write_files(PAGES[name], tmp_path)
    for words in page.commands:
        made = tmp_path / words[words.index("-o") + 1] if "-o" in words else None
        if made is not None and made.is_file():
            made.unlink()  # the same name at another size
        assert run(small(words)) == 0, capsys.readouterr().err
        assert "warning" not in capsys.readouterr().err
        if made is not None and made.suffix == ".png" and "--dry-run" not in words:
            with Image.open(made) as picture:
                light = np.asarray(picture.convert("L"), float)
            assert light.max() > 60 and light.std() > 2, words
    for k, script in enumerate(page.scripts):
        file = tmp_path / f"script_{k}.py"
        file.write_text(script, encoding="utf-8")
        runpy.run_path(str(file), run_name="__main__")
    for file in page.files:
        sys.modules.pop(Path(file).stem, None)


def test_the_tour_has_twelve_pages_that_lead_to_each_other():
    tour = [name for name in PAGES if name.startswith("tour/")]
    assert [int(Path(name).name[:2]) for name in tour] == list(range(1, 13))
    for name, following in zip(tour, tour[1:]):
        text = PAGES[name].read_text(encoding="utf-8")
        assert "**Try next:**" in text and f"]({Path(following).name}.md)" in text, name


def test_every_page_that_shows_a_picture_has_it_small():
    shown = sorted((DOCS / "images" / folder) for folder in ("tour", "recipes"))
    pictures = [path for folder in shown for path in folder.iterdir()]
    texts = "\n".join(page.read_text(encoding="utf-8") for page in PAGES.values())
    assert pictures and all(path.relative_to(DOCS).as_posix() in texts for path in pictures)
    assert sum(path.stat().st_size for path in pictures) < 400_000
    for path in pictures:
        with Image.open(path) as picture:
            assert picture.size == (640, 360)


def test_a_page_whose_example_is_wrong_is_noticed(tmp_path, monkeypatch, capsys):
    """The mutant: a misspelt key in a page's file."""
    text = PAGES["tour/01_first_picture"].read_text(encoding="utf-8").replace("drag:", "darg:")
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    page_examples.write_files(page, tmp_path)
    assert run(small(page_examples.examples(page).commands[0])) == 3
    assert "did you mean 'drag'" in capsys.readouterr().err
