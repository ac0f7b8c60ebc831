"""list, show, validate, inspect, and the options that change a preset."""

import json

import pytest

from gen_art.preset.load import load_preset
from gen_art.preset.shipped import preset_names
from tests.preset.piece import TEXT


def test_list_names_every_preset_with_what_it_shows(gen_art):
    lines = gen_art("list").out.splitlines()
    assert [line.split()[0] for line in lines] == preset_names()
    assert all(len(line.split()) > 3 for line in lines)


def test_show_prints_the_text(gen_art, piece):
    assert gen_art("show", piece).out == TEXT


def test_show_resolved_fills_knobs_and_settings(gen_art, piece):
    result = gen_art("show", piece, "--set", "knobs.push=4", "--seed", 9, "--fps", 60, "--duration", "1/2")
    shown = json.loads(result.out)
    assert shown["systems"]["drops"]["emitters"]["nozzle"]["velocity"]["speed"] == 4
    assert shown["clock"]["fps"] == 60
    assert shown["clock"]["duration"] == 0.5
    assert load_preset(shown).seed == 9


def test_seed_random_differs(gen_art, piece):
    seeds = {json.loads(gen_art("show", piece, "--seed", "random").out)["seed"] for _ in range(3)}
    assert len(seeds) == 3


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
    assert "<stdin>:1:10: version: this preset is written for version 3" in result.err


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
        ("clock..fps=3", 2, "is no path"),
        ("clock.fps=[1", 3, "--set clock.fps:1:"),
        ("clock.fps=fast", 3, "--set: clock.fps: must be a number, not 'fast'"),
    ],
)
def test_settings_that_cannot_be_meant(gen_art, piece, setting, status, words):
    result = gen_art("show", piece, "--set", setting)
    assert result.status == status
    assert words in result.err
    assert not result.out
