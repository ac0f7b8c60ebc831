"""list, show, validate, inspect, and the options that change a preset."""

import json
from pathlib import Path

import pytest

from gen_art.integrators import INTEGRATORS
from gen_art.preset.files import FOLDER
from gen_art.preset.load import load_preset
from gen_art.preset.reader import read_text
from gen_art.preset.registered import registry
from gen_art.preset.shipped import course_names, preset_names, presets_folder
from gen_art.preset.writing import changed_text, yaml_text
from tests.preset.piece import TEXT


def test_list_names_every_preset_with_what_it_shows(gen_art):
    lines = gen_art("list").out.splitlines()
    assert [line.split()[0] for line in lines] == preset_names()
    assert all(len(line.split()) > 3 for line in lines)


@pytest.mark.parametrize("what", ["forces", "shapes", "velocities", "emitters", "interactions", "colliders"])
def test_list_names_everything_that_yaml_takes(gen_art, what):
    lines = gen_art("list", what).out.splitlines()
    assert [line.split()[0] for line in lines] == sorted(registry(what))
    assert all(len(line.split()) > 2 for line in lines)


def test_list_integrators_palettes_and_course(gen_art):
    assert [line.split()[0] for line in gen_art("list", "integrators").out.splitlines()] == list(INTEGRATORS)
    assert "viridis" in gen_art("list", "palettes").out
    assert [line.split()[0] for line in gen_art("list", "course").out.splitlines()] == course_names()
    assert gen_art("list", "farces").status == 2


@pytest.mark.parametrize("name", [*preset_names(), *course_names()])
def test_new_copies_a_preset_and_its_files(gen_art, name, tmp_path):
    made = gen_art("new", tmp_path / "deep" / "mine", "--from", name)
    assert made.status == 0
    paths = [Path(line) for line in made.out.splitlines()]
    assert paths[0] == tmp_path / "deep" / "mine.yaml" and all(path.is_file() for path in paths)
    assert paths[0].read_text(encoding="utf-8") == (presets_folder() / f"{name}.yaml").read_text(encoding="utf-8")
    assert load_preset(paths[0]) == load_preset(name)


def test_new_starts_from_a_commented_preset_and_overwrites_nothing(gen_art, tmp_path):
    assert gen_art("new", tmp_path / "mine").status == 0
    text = (tmp_path / "mine.yaml").read_text(encoding="utf-8")
    assert text.count("#") > 10 and gen_art("validate", tmp_path / "mine.yaml").status == 0
    again = gen_art("new", tmp_path / "mine")
    assert again.status == 5 and "--overwrite replaces it" in again.err
    assert gen_art("new", tmp_path / "mine", "--overwrite").status == 0
    assert gen_art("new", tmp_path / "other", "--from", "piza").status == 2
    assert all(gen_art("new", name).status == 2 for name in ("", ".", "..", ".hidden"))
    assert gen_art("new", "mine/", "--from", "-").status == 2
    (tmp_path / "bubble.webp").write_bytes(b"mine")
    other = gen_art("new", tmp_path / "floating", "--from", "course/floating")
    assert other.status == 5 and "bubble.webp exists already" in other.err and not (tmp_path / "floating.yaml").exists()


def test_still_without_a_time_takes_the_gallery_s(gen_art, piece, tmp_path):
    said = gen_art("still", piece, "-o", tmp_path / "a.png", "--dry-run", "--set", "gallery.time=0.5")
    assert said.status == 0 and " at 0.5 s" in said.out
    said = gen_art("still", piece, "-o", tmp_path / "a.png", "--dry-run")
    assert said.status == 0 and f" at {load_preset(piece).clock.duration / 2:g} s" in said.out


def test_show_prints_the_text(gen_art, piece):
    assert gen_art("show", piece).out == TEXT


def test_show_resolved_fills_knobs_and_settings(gen_art, piece):
    result = gen_art(
        "show", piece, "--resolved", "--set", "knobs.push=4", "--seed", 9, "--fps", 60, "--duration", "1/2"
    )
    shown = json.loads(result.out)
    assert shown["systems"]["drops"]["emitters"]["nozzle"]["velocity"]["speed"] == 4
    assert shown["clock"]["fps"] == 60
    assert shown["clock"]["duration"] == 0.5
    assert load_preset(shown).seed == 9


def test_seed_random_differs(gen_art, piece):
    seeds = {json.loads(gen_art("show", piece, "--resolved", "--seed", "random").out)["seed"] for _ in range(3)}
    assert len(seeds) == 3


def test_show_keeps_the_text_and_changes_the_values(gen_art):
    """Every line but those of the values that are set, comments included."""
    before = gen_art("show", "fire").out.splitlines()
    after = gen_art("show", "fire", "--set", "knobs.heat=1900", "--seed", 4, "--fps", 60).out.splitlines()
    changed = {a: b for a, b in zip(before, after, strict=True) if a != b}
    assert len(changed) == 3
    assert any("heat: {value: 1900," in b and a.split("#")[1] == b.split("#")[1] for a, b in changed.items())
    assert gen_art("show", "fire", "--set", "knobs.heet=1").status == 2


@pytest.mark.parametrize("name", [*preset_names(), *course_names()])
def test_show_of_a_changed_preset_is_that_preset(gen_art, name, tmp_path):
    path = presets_folder() / f"{name}.yaml"
    text = changed_text(path.read_text(encoding="utf-8"), {"seed": 77})
    written = path.parent / "changed.yaml"  # only its name: the folder is that of the side files
    token = FOLDER.set(path.parent)
    try:
        data = read_text(text, str(written)).plain()
        assert load_preset(data) == load_preset(path, seed=77)
        again = read_text(yaml_text(load_preset(path, seed=77).resolved()), "again.yaml").plain()
        assert load_preset(again) == load_preset(path, seed=77)
    finally:
        FOLDER.reset(token)


def test_show_prints_the_preset_inside_a_picture(gen_art, piece, tmp_path):
    picture = tmp_path / "a.png"
    assert gen_art("still", piece, "-o", picture, "--size", "32x18", "--set", "knobs.push=4").status == 0
    result = gen_art("show", picture)
    assert result.status == 0 and result.out.startswith(f"# {Path(piece).stem}, from a.png, made by gen-art ")
    inside = read_text(result.out, "inside.yaml").plain()
    assert load_preset(inside) == load_preset(piece, overrides={"knobs.push": 4})
    assert gen_art("show", tmp_path / "none.png").status == 5


def test_validate(gen_art, piece, tmp_path):
    assert gen_art("validate", piece).status == 0
    bad = tmp_path / "bad.yaml"
    bad.write_text(TEXT.replace("rate: 200", "rte: 200").replace("seed: 5", "sed: 5"), encoding="utf-8")
    result = gen_art("validate", piece, bad)
    assert result.status == 3
    assert result.out == f"{piece}: ok\n"
    assert f"{bad}:17:9: systems.drops.emitters.nozzle.rte: unknown key; did you mean 'rate'?" in result.err
    assert f"{bad}:5:1: sed: unknown key; did you mean 'seed'?" in result.err


def test_validate_reads_standard_input(gen_art, monkeypatch):
    class Stdin:
        class buffer:
            read = staticmethod(lambda size=-1: b"version: 3\n")

    monkeypatch.setattr("sys.stdin", Stdin)
    result = gen_art("validate", "-")
    assert result.status == 3
    assert "<stdin>:1:10: version: the preset has version 3" in result.err


def test_inspect(gen_art, piece):
    text = gen_art("inspect", piece).out
    assert "60 frames" in text
    assert "drops" in text
    facts = json.loads(gen_art("inspect", piece, "--json", "--size", "640x360").out)
    assert facts["size"] == [640, 360]
    assert facts["systems"]["drops"]["peak"] == pytest.approx(300, rel=0.1)
    assert facts["systems"]["drops"]["should_hold"] == []
    assert "drag" in facts["systems"]["drops"]["booked"]["energy"]
    assert facts["resolved"]["version"] == 1


def test_inspect_says_what_holds(gen_art, piece):
    calm = ["--set", "systems.drops.inherit_forces=false", "--set", "systems.drops.particle.lifetime=null"]
    alone = ["--set", "systems.drops.emitters.nozzle={count: 5, tag: wet}"]
    facts = json.loads(gen_art("inspect", piece, "--json", *calm, *alone).out)
    assert facts["systems"]["drops"]["should_hold"] == ["energy", "momentum", "angular momentum", "mass", "charge"]


@pytest.mark.parametrize(
    ("setting", "status", "words"),
    [
        ("systems.drops.emitters.nozzle.rte=5", 3, "did you mean 'rate'?"),
        ("systems.drips.particle.mass=5", 2, "did you mean 'drops'?"),
        ("knobs.psh=5", 2, "did you mean 'push'?"),
        ("systems.drops.emitters.nozzle.velocity.speed.x=5", 2, "is the knob $push"),
        ("clock.fps", 2, "an equals sign"),
        ("clock..fps=3", 2, "is not a path"),
        ("clock.fps=[1", 3, "--set clock.fps:1:"),
        ("clock.fps=fast", 3, "--set: clock.fps: must be a number, not 'fast'"),
    ],
)
def test_settings_that_cannot_be_meant(gen_art, piece, setting, status, words):
    result = gen_art("show", piece, "--set", setting)
    assert result.status == status
    assert words in result.err
    assert not result.out
