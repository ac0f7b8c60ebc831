"""Text of recipes and presets: it names no path to write, opens no file elsewhere, and steers no terminal."""

import json
import re
import unicodedata
from pathlib import Path

import numpy as np
import pytest

from gen_art.commands.terminal import escaped
from gen_art.output.stills import write_still
from gen_art.output.target import find_target

COMMANDS = Path(__file__).parents[2] / "gen_art" / "commands"


@pytest.fixture(scope="module")
def recipe(tmp_path_factory):
    """A recipe of a small still."""
    from gen_art.output import job
    from gen_art.output.read_recipe import read_recipe
    from tests.output.piece import piece

    (path,) = job.still(piece(camera__size=[32, 18]), tmp_path_factory.mktemp("made") / "a.png", 0)
    return read_recipe(path)


@pytest.fixture
def picture(tmp_path, recipe):
    """A picture whose recipe has other values."""

    def write(**changes):
        return write_still(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), {**recipe, **changes})

    return write


@pytest.mark.parametrize(
    "name", ["/tmp/elsewhere", "../up", "..", "a/b", "a\\b", ".hidden", "", "c:x", "a\nb", "{seed}", "##", "x" * 300]
)
def test_a_name_in_a_recipe_is_no_path(gen_art, tmp_path, picture, name):
    path = picture(name=name)
    result = gen_art("rerun", path, "-o", "{preset}.png")
    assert result.status == 2 and "{preset}" in result.err and "bug" not in result.err
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_the_name_of_a_preset_is_a_name(gen_art, tmp_path, picture):
    assert find_target("out/{preset}_{seed}.png", moving=False, name="räder 2.b", seed=4).path == Path(
        "out/räder 2.b_4.png"
    )
    assert gen_art("rerun", picture(name="ok"), "-o", "{preset}.png").status == 0
    assert (tmp_path / "ok.png").is_file()


@pytest.mark.parametrize("place", ["/etc/hostname", "../secret", "link/secret", "/proc/self/mem", "a/../../secret", ""])
def test_rerun_reads_no_file_outside_the_folder(gen_art, tmp_path, picture, monkeypatch, place):
    """Neither whether it exists nor what its sha256 is shows in the answer, because it is not opened."""
    from gen_art.output import recipe as module

    inside, read = tmp_path / "in", []
    inside.mkdir()
    (tmp_path / "secret").write_text("x")
    (inside / "link").symlink_to(tmp_path)
    monkeypatch.setattr(module, "sha256", lambda path: read.append(path) or "0" * 64)
    path = picture(files=[{"path": place, "sha256": "0" * 64}])
    result = gen_art("rerun", path, "-o", "b.png", "--folder", inside)
    assert result.status == 2 and not read and not (tmp_path / "b.png").exists(), result.err


def test_rerun_reads_no_pipe_and_no_huge_file(gen_art, tmp_path, picture):
    import os

    os.mkfifo(tmp_path / "pipe")
    with open(tmp_path / "sparse", "wb") as file:
        file.truncate(20 * 2**30)
    for name, status, words in (("pipe", 2, "give --folder"), ("sparse", 5, "at most 1,073,741,824 are read")):
        result = gen_art("rerun", picture(files=[{"path": name, "sha256": "0" * 64}]), "-o", "b.png")
        assert result.status == status and words in result.err, result.err


@pytest.mark.parametrize(
    "changes",
    [{"size": [10**9, 4]}, {"size": [True, 4]}, {"time": float("1e400")}, {"kind": "film", "frames": [0, 5, 0]},
     {"kind": "film", "frames": [0, 10**15, 1]}, {"kind": "film", "frames": [3]}, {"kind": [1]}, {"gen_art": 3}, {"name": None},
     {"preset": {"a": [[[[[[3]]]]]]}}, {"preset": []}, {"max_rate": "x", "kind": "film", "frames": [0, 1, 1]}],
)  # fmt: skip
@pytest.mark.parametrize("command", [["rerun", "-o", "b.png"], ["show"], ["show", "--resolved"]], ids=" ".join)
def test_a_damaged_recipe_is_a_sentence(gen_art, tmp_path, recipe, monkeypatch, command, changes):
    from gen_art.output import stills

    monkeypatch.setattr(stills, "encode", lambda recipe: json.dumps(recipe))
    path = write_still(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), {**recipe, **changes})
    result = gen_art(command[0], path, *command[1:])
    assert "bug" not in result.err and "Traceback" not in result.err
    assert result.status in (2, 3, 5) or (command == ["show"] and "preset" in changes), result.err


def test_a_recipe_that_is_nested_too_deep_is_a_sentence(gen_art, tmp_path, monkeypatch):
    from gen_art.output import stills

    for depth in (500, 100_000):
        nested = '{"format":1,"preset":' + "[" * depth + "]" * depth + "}"
        monkeypatch.setattr(stills, "encode", lambda recipe, text=nested: text)
        path = write_still(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), {})
        for command in (["show", path], ["rerun", path, "-o", "b.png"]):
            result = gen_art(*command)
            assert result.status == 2 and "bug" not in result.err, result.err


STEERING = "\x1b]0;title\x07\x1b[2J\x9b31m\r\u202e\u2066\u2028\x7f"


def test_text_of_a_recipe_does_not_steer_the_terminal(gen_art, tmp_path, picture, recipe):
    for changes in ({"name": STEERING}, {"gen_art": STEERING}, {"files": [{"path": STEERING, "sha256": "0" * 64}]},
                    {"plugins": [{"name": STEERING, "sha256": "0" * 64}]}, {"preset": {STEERING: STEERING}},
                    {"preset": {**recipe["preset"], STEERING: 3}}, {"format": STEERING}):  # fmt: skip
        path = picture(**changes)
        for command in (
            ["rerun", path, "-o", "{preset}.jpg"],
            ["show", path],
            ["show", path, "--resolved"],
            ["show", path, "--seed", "3"],
        ):
            result = gen_art(*command)
            assert result.status != 1 or "bug" not in result.err, result.err
            assert not _steering(result.out + result.err)


def test_text_of_a_preset_does_not_steer_the_terminal(gen_art, tmp_path):
    from tests.preset.piece import TEXT

    escape = "\\e]0;title\\a\\e[2J\\x9B31m\\u202E"
    texts = [TEXT.replace("rate: 200", f'"r{escape}": 200'), TEXT.replace("rate: 200", f'rate: "{escape}"'),
             TEXT.replace("nozzle", f'"n{escape}"'), TEXT + f'unknown: "{escape}"\n', TEXT.replace("rate: 200", "rate: \x1b[2J")]  # fmt: skip
    for text in texts:
        (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
        for command in (
            ["validate"],
            ["inspect"],
            ["inspect", "--json"],
            ["show"],
            ["show", "--resolved"],
            ["render", "-o", "a.mp4", "--dry-run"],
        ):
            result = gen_art(command[0], "a.yaml", *command[1:])
            assert "bug" not in result.err, result.err
            assert not _steering(result.out + result.err)
            if "--json" in command and not result.status:
                json.loads(result.out)


def _steering(text: str) -> str:
    return "".join(
        c for c in text if unicodedata.category(c) in ("Cc", "Zl", "Zp", "Cs") and c not in "\n\t"
    ) + "".join(
        c
        for c in text
        if unicodedata.bidirectional(c) in ("LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI")
    )


def test_every_control_character_is_escaped():
    everything = "".join(map(chr, range(0x3000)))
    assert not _steering(escaped(everything)) and escaped("a\tb\n→é") == "a\tb\n→é"
    assert json.loads(f'"{escaped(STEERING)}"') == STEERING


def test_commands_print_in_one_place():
    for path in COMMANDS.glob("*.py"):
        printing = re.findall(r"click\.s?echo|(?<![\w.])print\(|std(?:out|err)\.write|console\.print", path.read_text())
        allowed = {"terminal.py": ["click.echo"], "progress.py": ["print("]}  # progress: numbers as ASCII JSON
        assert printing == allowed.get(path.name, []), path
