"""Bad input: a message that fits a screen, the right exit status, nothing written, at once."""

import pytest

from gen_art.commands.main import run
from tests.preset.piece import TEXT

BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 10)}]\n" for k in range(9)
)


def change(old, new):
    assert old in TEXT
    return TEXT.replace(old, new).encode()


# name -> the file's bytes (None: no file), the exit status, words of the message
FILES = {
    "unknown key": (change("rate: 200", "rte: 200"), 3, "bad.yaml:17:9: systems.drops.emitters.nozzle.rte: unknown key; did you mean 'rate'?"),
    "wrong type": (change("rate: 200", "rate: {a: 1}"), 3, "bad.yaml:17:9: systems.drops.emitters.nozzle.rate: must be a curve"),
    "text for a number": (change("rate: 200", "rate: fast"), 3, "bad.yaml:17:15: systems.drops.emitters.nozzle.rate: must be a number, not 'fast'"),
    "NaN": (change("cd: 0.5", "cd: .nan"), 3, "bad.yaml:11:14: forces.drag.cd: must be a finite number"),
    "infinity": (change("rate: 200", "rate: .inf"), 3, "must be a finite number, not .inf"),
    "overflow": (change("rate: 200", "rate: 1e999"), 3, "must be a finite number"),
    "negative rate": (change("rate: 200", "rate: -1"), 3, "systems.drops.emitters.nozzle.rate: must be at least 0, not -1"),
    "zero frames": (change("duration: 2", "duration: 0"), 3, "clock.duration: must be more than 0"),
    "newer version": (change("version: 1", "version: 2"), 3, "the preset has version 2"),
    "empty file": (b"", 3, "is empty"),
    "binary file": (b"\x7fELF\x02\x00\x00", 3, "is not a text file"),
    "random bytes": (bytes(range(128, 256)) * 20, 3, "is not a text file"),
    "huge file": (b"a: 1\n" * 300_000, 3, "is larger than"),
    "alias bomb": (BOMB.encode(), 3, "aliases expanded"),
    "deep nesting": (b"[" * 100_000, 3, "levels deep"),
    "deep indentation": (b"- " * 100_000, 3, "levels deep"),
    "deep mappings": (b"{a: " * 100_000, 3, "levels deep"),
    "tag": (change("rate: 200", "rate: !!python/object/apply:os.getcwd []"), 3, "YAML tags are not allowed"),
    "two documents": (TEXT.encode() + b"---\nversion: 1\n", 3, "one document"),
    "a list": (b"[1, 2]", 3, "a preset is a mapping"),
    "missing file": (None, 5, "bad.yaml: no such file"),
    "many problems": (change("systems:", "systems:\n" + "".join(f"  s{k}: {{a: 1}}\n" for k in range(50))), 3, "more; `gen-art validate`"),
    "a million million particles": (change("rate: 200", "rate: 1e12"), 4, "particles"),
    "a million million at once": (change("rate: 200", "count: 1e12"), 4, "1e+12 particles"),
}  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def _modules_loaded():
    """So that no file that an import writes is taken for one that a command wrote."""
    run(["schema"])


@pytest.fixture
def refused(gen_art, tmp_path):
    """Run a command that must fail: its error text; nothing may have been written."""

    def call(status, *arguments):
        before = sorted(tmp_path.rglob("*"))
        result = gen_art(*arguments)
        assert result.status == status, result.err
        assert not result.out
        assert sorted(tmp_path.rglob("*")) == before
        assert "Traceback" not in result.err
        assert len(result.err.splitlines()) <= 30
        assert max(map(len, result.err.splitlines())) <= 400
        return result.err

    return call


@pytest.mark.parametrize(
    "command", [["render", "-o", "film.mp4"], ["still", "-o", "a.png", "--time", "1"]], ids=["render", "still"]
)
@pytest.mark.parametrize("label", FILES)
def test_bad_files(refused, tmp_path, label, command):
    data, status, words = FILES[label]
    if data is not None:
        (tmp_path / "bad.yaml").write_bytes(data)
    assert words in refused(status, command[0], "bad.yaml", *command[1:])


def test_a_folder_as_a_preset(refused, tmp_path):
    (tmp_path / "folder.yaml").mkdir()
    assert "folder.yaml: is a folder" in refused(5, "render", "folder.yaml", "-o", "film.mp4")


def test_an_unknown_preset_is_suggested(refused, monkeypatch):
    monkeypatch.setattr("gen_art.preset.shipped.preset_names", lambda: ["fire", "smoke"])
    assert "there is no preset 'fier'; did you mean 'fire'?" in refused(2, "render", "fier", "-o", "film.mp4")


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["-o", "film.xyz"], 2, "'.xyz'"),
        (["-o", "film"], 2, "no extension"),
        (["-o", "film.mp4", "--frames", "9..0"], 2, "names no frame"),
        (["-o", "film.mp4", "--frames", "-1"], 2, "--frames"),
        (["-o", "film.mp4", "--frames", "a"], 2, "first..last..step"),
        (["-o", "film.mp4", "--duration", "0"], 2, "more than 0"),
        (["-o", "film.mp4", "--duration", "nan"], 2, "must be a number"),
        (["-o", "film.mp4", "--duration", "1e9"], 3, "frames, and may have 1,000,000 at most"),
        (["-o", "film.mp4", "--duration", "0.001"], 3, "makes no frame"),
        (["-o", "film.mp4", "--fps", "31"], 3, "the nearest fps is 30"),
        (["-o", "film.mp4", "--size", "1281x721"], 2, "1280x720 and 1282x722"),
        (["-o", "film.mp4", "--size", "0x720"], 2, "WIDTHxHEIGHT"),
        (["-o", "film.mp4", "--size", "big"], 2, "WIDTHxHEIGHT"),
        (["-o", "film.mp4", "--scale", "0%"], 2, "a percentage"),
        (["-o", "film.mp4", "--seed", "-4"], 2, "a whole number"),
        (["-o", "film.mp4", "--arch", "cuda"], 2, "runs on cpu only"),
        (["-o", "film.mp4", "--threads", "0"], 2, "--threads"),
        (["-o", "film.mp4", "--precision", "f16"], 2, "--precision"),
        (["-o", "film.mp4", "--transparent"], 2, "transparent"),
        (["-o", "piece.yaml/film.mp4"], 5, "is not a folder"),
        (["-o", "taken.mp4"], 5, "--overwrite replaces it"),
        (["-o", "taken_####.png", "--frames", "0..3"], 5, "taken_0002.png exists already"),
        (["-o", "film.mp4", "--plugin", "none.py"], 5, "none.py: No such file"),
    ],
)
def test_bad_arguments(refused, piece, tmp_path, arguments, status, words):
    for name in ("taken.mp4", "taken_0002.png"):
        (tmp_path / name).write_bytes(b"mine")
    assert words in refused(status, "render", piece.name, *arguments)
    assert (tmp_path / "taken.mp4").read_bytes() == b"mine"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1\nx = y\n", "bad.py:2: NameError: name 'y' is not defined"),
        ("def f(:\n", "bad.py:1: SyntaxError"),
        ("from gen_art.registry import suggest\nraise ValueError('no')\n", "bad.py:2: ValueError: no"),
    ],
)
def test_a_plugin_with_an_error_names_the_line(refused, piece, tmp_path, text, words):
    (tmp_path / "bad.py").write_text(text)
    assert words in refused(2, "render", piece.name, "-o", "film.mp4", "--plugin", "bad.py")


def test_rerun_of_what_is_no_picture(refused, piece, tmp_path):
    (tmp_path / "bare.png").write_bytes(b"not a picture")
    assert "bare.png" in refused(2, "rerun", "bare.png", "-o", "again.png")
    assert "none.png" in refused(5, "rerun", "none.png", "-o", "again.png")


def test_dry_run_checks_and_writes_nothing(gen_art, piece, tmp_path):
    result = gen_art("render", piece.name, "-o", "film.mp4", "--frames", "0..9", "--size", "64x36", "--dry-run")
    assert result.status == 0
    assert "film.mp4: 10 frames of 64x36" in result.out
    assert not (tmp_path / "film.mp4").exists()
    (tmp_path / "film.mp4").write_bytes(b"mine")
    assert gen_art("render", piece.name, "-o", "film.mp4", "--dry-run").status == 5
