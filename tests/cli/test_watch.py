"""`gen-art watch`: a picture that follows its files. What is edited comes from a script, but for the tests that start a process."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gen_art import plugins
from gen_art.backend import runtime
from gen_art.forces.base import FORCES
from gen_art.output import file_watch
from tests.output.test_live_plugins import text as plugin_text

ROOT = Path(__file__).resolve().parents[2]
TEXT = """\
version: 1
seed: 3
clock: {duration: 1, fps: 20, step: 1/40}
forces: {gravity: [0, -1, 0]}
systems:
  dots:
    emitters: {all: {count: 40, shape: {sphere: 1}}}
    look: {draw: disc, width: 0.4, emission: {color: white, intensity: 4}}
camera: {position: [0, 0, 6], target: [0, 0, 0]}
"""
OPTIONS = ("--size", "48x27", "--time", "0.5", "--progress", "none")


@pytest.fixture(autouse=True)
def _no_plugins(monkeypatch):
    monkeypatch.setattr(FORCES, "classes", dict(FORCES.classes))
    monkeypatch.setattr(plugins, "_loaded", {})


@pytest.fixture
def preset(tmp_path):
    path = tmp_path / "my.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


@pytest.fixture
def watch(gen_art, monkeypatch):
    """Run `gen-art watch` with steps, each called in place of a wait, which must have changed a file; then comes Ctrl+C."""

    def run(*arguments, steps=()):
        script = iter(steps)

        class Scripted(file_watch.FileWatch):
            def wait(self):
                for step in script:
                    step()
                    changed = self.changed()
                    assert changed
                    return changed
                raise KeyboardInterrupt

        monkeypatch.setattr(file_watch, "FileWatch", Scripted)
        result = gen_art("watch", *arguments, *OPTIONS)
        assert next(script, None) is None, result.err
        return result

    return run


def pixels(path) -> bytes:
    """What a picture shows; its file also holds the recipe."""
    with Image.open(path) as image:
        return image.convert("RGB").tobytes()


class Pictures:
    """The pixels of my.png after each step of a script, None where there is no file, and how many kernels were compiled by then."""

    def __init__(self, path):
        self.path, self.seen, self.compiled = path, [], []

    def then(self, change):
        def step():
            self.note()
            change()

        return step

    def note(self):
        self.seen.append(pixels(self.path) if self.path.exists() else None)
        self.compiled.append(runtime.compilations())


@pytest.fixture
def pictures(tmp_path):
    return Pictures(tmp_path / "my.png")


def edit(path, old, new):
    def change():
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")

    return change


def lines(result) -> list[str]:
    """The lines without their times: `my.png: my.yaml changed`."""
    for line in result.out.splitlines():
        assert re.fullmatch(r"\d\d:\d\d:\d\d .*, \d+\.\d s", line), line
    return [line[9:].rpartition(",")[0] for line in result.out.splitlines()]


NOWHERE_ELSE = '''\
import gen_art as ga
from gen_art import ti


@ga.force("nowhere_else")
class NowhereElse(ga.Force):
    """A push along x. a = strength x; strength in m/s^2."""

    strength: float = ga.param(3.0, unit="m/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        return ti.Vector([q.strength, 0.0, 0.0])
'''


def test_a_saved_number_makes_the_picture_again_and_compiles_nothing(watch, preset, pictures):
    plugin = preset.parent / "nowhere_else.py"  # a force of its own, which no other test of this process has compiled
    plugin.write_text(NOWHERE_ELSE, encoding="utf-8")
    number, force = edit(preset, "[0, -1, 0]", "[0, 9, 0]"), edit(preset, "forces: {", "forces: {nowhere_else: {}, ")
    result = watch("my.yaml", "-o", "my.png", "--plugin", plugin, steps=[pictures.then(number), pictures.then(force)])
    pictures.note()
    assert (result.status, result.err) == (130, "\ngen-art: stopped\n")
    assert lines(result) == ["my.png: first picture", *["my.png: my.yaml changed"] * 2]
    assert len(set(pictures.seen)) == 3
    first, same, more = pictures.compiled
    assert first == same < more  # the other way round: a new force does compile kernels


def test_the_picture_is_that_of_still(watch, gen_art, preset, pictures):
    watch(
        "my.yaml",
        "-o",
        "my.png",
        "--set",
        "forces.gravity=[0,-3,0]",
        "--seed",
        "8",
        steps=[edit(preset, "width: 0.4", "width: 0.5")],
    )
    still = gen_art("still", "my.yaml", "-o", "still.png", "--set", "forces.gravity=[0,-3,0]", "--seed", "8", *OPTIONS)
    assert still.status == 0
    assert (preset.parent / "still.png").read_bytes() == pictures.path.read_bytes()


def test_a_wrong_preset_keeps_the_picture_and_the_watch_goes_on(watch, preset, pictures):
    wrong, mend = edit(preset, "seed: 3", "seeed: 3"), edit(preset, "seeed: 3", "seed: 4")
    broken, whole = edit(preset, "version: 1", "version: ["), edit(preset, "version: [", "version: 1")
    result = watch("my.yaml", "-o", "my.png", steps=[pictures.then(change) for change in (wrong, mend, broken, whole)])
    pictures.note()
    first, kept, mended, kept_again, last = pictures.seen
    assert first == kept != mended == kept_again
    assert last == mended
    assert "my.yaml:2:1: seeed: unknown key; did you mean 'seed'?" in result.err and result.status == 130
    assert lines(result) == ["my.png: first picture", *["my.png: my.yaml changed"] * 2]


def test_a_preset_that_is_wrong_from_the_start_is_waited_for(watch, preset, pictures):
    preset.write_text("version: 1\n", encoding="utf-8")
    result = watch("my.yaml", "-o", "my.png", steps=[pictures.then(lambda: preset.write_text(TEXT, encoding="utf-8"))])
    assert (
        pictures.seen == [None]
        and lines(result) == ["my.png: my.yaml changed"]
        and "'systems' is missing" in result.err
    )


def test_a_preset_that_is_deleted_is_waited_for(watch, preset, pictures):
    back = pictures.then(lambda: preset.write_text(TEXT, encoding="utf-8"))
    result = watch("my.yaml", "-o", "my.png", steps=[pictures.then(preset.unlink), back])
    assert pictures.seen[0] == pictures.seen[1] == pixels(pictures.path)
    assert "my.yaml is gone; watching goes on when it is back\n" in result.err and len(lines(result)) == 2


def test_a_picture_that_the_preset_names_is_read_again(watch, preset, pictures):
    spark = preset.parent / "spark.png"

    def save(*colour):
        return lambda: Image.fromarray(np.full((8, 8, 3), colour, np.uint8)).save(spark)

    save(255, 0, 0)()
    edit(preset, "draw: disc", "draw: picture, picture: spark.png")()
    steps = [pictures.then(change) for change in (save(0, 0, 255), spark.unlink, save(255, 0, 0))]
    result = watch("my.yaml", "-o", "my.png", steps=steps)
    pictures.note()
    red, blue, kept, again = pictures.seen
    assert red == again != blue == kept
    assert "there is no such file" in result.err
    assert lines(result) == ["my.png: first picture", *["my.png: spark.png changed"] * 2]


def test_a_plugin_is_loaded_again(watch, preset, pictures):
    """Each picture is that of a process that has only seen the plugin as it is; a wrong plugin is a sentence."""
    edit(preset, "forces: {", "forces: {test_push: 1, ")()
    plugin = preset.parent / "push.py"

    def save(text):
        return lambda: plugin.write_text(text, encoding="utf-8")

    uncompiled = plugin_text().replace("1.0 * q.strength", "nowhere * q.strength")
    save(plugin_text())()
    changes = [plugin_text("-3.0", above="\n# a line more\n"), plugin_text() + "1 / 0\n", uncompiled, plugin_text()]
    result = watch("my.yaml", "-o", "my.png", "--plugin", "push.py", steps=[pictures.then(save(t)) for t in changes])
    pictures.note()
    first, pushed, kept, kept_again, last = pictures.seen
    assert first == last != pushed == kept == kept_again
    assert "push.py:14: ZeroDivisionError: division by zero" in result.err
    assert "acceleration cannot be compiled: " in result.err and "nowhere" in result.err and "bug" not in result.err
    save(changes[0])()
    command = [sys.executable, str(ROOT / "cli.py"), "still", "my.yaml", "-o", "still.png", "--plugin", "push.py"]
    subprocess.run([*command, *OPTIONS], cwd=preset.parent, check=True)
    assert pixels(preset.parent / "still.png") == pushed


def test_a_picture_that_gen_art_has_not_made_is_kept(watch, preset, pictures):
    Image.new("RGB", (4, 4)).save(pictures.path)
    before = pictures.path.read_bytes()
    refused = watch("my.yaml", "-o", "my.png")
    assert (
        refused.status == 5
        and refused.err == "gen-art: my.png exists, and gen-art has not made it; --overwrite replaces it\n"
    )
    assert pictures.path.read_bytes() == before
    assert len(lines(watch("my.yaml", "-o", "my.png", "--overwrite"))) == 1
    assert len(lines(watch("my.yaml", "-o", "my.png"))) == 1  # gen-art has made this one


def test_each_name_with_the_seed_is_looked_at_before_it_is_replaced(watch, preset, tmp_path):
    other = tmp_path / "4.png"
    Image.new("RGB", (4, 4)).save(other)
    before = other.read_bytes()
    result = watch(
        "my.yaml", "-o", "{seed}.png", steps=[edit(preset, "seed: 3", "seed: 4"), edit(preset, "seed: 4", "seed: 5")]
    )
    assert lines(result) == ["3.png: first picture", "5.png: my.yaml changed"]
    assert other.read_bytes() == before and "4.png exists" in result.err


def test_a_random_seed_is_drawn_once(watch, preset, pictures):
    touch = pictures.then(lambda: preset.write_text(TEXT + "# saved\n", encoding="utf-8"))
    watch("my.yaml", "-o", "my.png", "--seed", "random", steps=[touch])
    pictures.note()
    assert pictures.seen[0] == pictures.seen[1]


def test_the_picture_is_no_file_that_the_preset_reads(watch, preset):
    picture = preset.parent / "my.png"
    Image.new("RGB", (4, 4), "red").save(picture)
    before = picture.read_bytes()
    edit(preset, "draw: disc", "draw: picture, picture: my.png")()
    result = watch("my.yaml", "-o", "my.png", "--overwrite")
    assert "my.png is a file that the preset reads" in result.err and picture.read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["-", "-o", "my.png"], 2, "standard input"),
        (["none.yaml", "-o", "my.png"], 5, "cannot read none.yaml"),
        (["nonsense", "-o", "my.png"], 2, "there is no preset 'nonsense'"),
        (["my.yaml", "-o", "my.mp4"], 2, "'.mp4' is not a picture extension"),
        (["my.yaml", "-o", "my.jpg", "--bits", "16"], 2, "8 bits a channel"),
        (["my.yaml", "-o", "my.png", "--plugin", "none.py"], 5, "cannot read none.py"),
        (["my.yaml", "-o", "my.png", "--set", "seed"], 2, "an equals sign"),
        (["my.yaml"], 2, "Missing option '-o'"),
    ],
)
def test_wrong_usage_ends_at_once(watch, preset, arguments, status, words):
    result = watch(*arguments)
    assert result.status == status and words in result.err and not result.out


def test_without_the_package_it_says_what_to_install(watch, preset, monkeypatch):
    monkeypatch.setitem(sys.modules, "watchfiles", None)
    result = watch("my.yaml", "-o", "my.png")
    assert result.status == 2 and result.err.endswith("pip install watchfiles\n") and result.err.count("\n") == 1


@pytest.mark.parametrize(
    ("number", "status", "last"), [(signal.SIGINT, 130, "stopped"), (signal.SIGTERM, 143, "terminated")]
)
def test_a_process_follows_its_file_until_a_signal(preset, number, status, last):
    command = [sys.executable, str(ROOT / "cli.py"), "watch", "my.yaml", "-o", "my.png", *OPTIONS]
    process = subprocess.Popen(command, cwd=preset.parent, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        assert "my.png: first picture" in process.stdout.readline()
        edit(preset, "seed: 3", "seed: 4")()
        assert "my.png: my.yaml changed" in process.stdout.readline()
        preset.unlink()
        assert process.stdout.readline() == "my.yaml is gone; watching goes on when it is back\n"
        new = preset.with_suffix(".new")
        new.write_text(TEXT, encoding="utf-8")
        os.replace(new, preset)
        assert "my.png: my.yaml changed" in process.stdout.readline()
        process.send_signal(number)
        assert process.stdout.read().strip() == f"gen-art: {last}"
        assert process.wait() == status
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    assert sorted(path.name for path in preset.parent.iterdir()) == ["my.png", "my.yaml"]
