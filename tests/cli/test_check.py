"""`gen-art check`: exit statuses, and verdicts in the recipes of pictures."""

import json

import gen_art as ga
from gen_art.audit import expectations
from gen_art.output.read_recipe import read_recipe
from gen_art.output.recipe import version
from gen_art.preset.verdicts import verdict_of

YAML = """version: 1
clock: {duration: 4, fps: 30, step: 1/120}
forces: {spring: {stiffness: 9.8696}}
systems:
  bob:
    integrator: leapfrog
    emitters: {one: {count: 1, mass: 1, shape: {point: [1, 0, 0]}}}
    look: {draw: point}
expect: {energy: 1e-3}
"""


def test_the_verdict_travels_with_each_picture(gen_art, tmp_path):
    (tmp_path / "bob.yaml").write_text(YAML, encoding="utf-8")
    assert gen_art("still", "bob.yaml", "-o", "before.png", "--time", 0, "--size", "64x36").status == 0
    assert read_recipe("before.png")["expect"] == {"verdict": "not checked"}
    checked = gen_art("check", "bob.yaml")
    assert checked.status == 0 and "holds         energy stays within 0.001" in checked.out
    assert gen_art("still", "bob.yaml", "-o", "after.png", "--time", 0, "--size", "64x36").status == 0
    verdict = read_recipe("after.png")["expect"]
    assert verdict["verdict"] == "good" and 0 < verdict["claims"][0]["errors"][0] < 1e-3
    # a change of the picture only keeps it, a change of the motion does not
    moved = {"camera.position": [0, 0, 9], "seed": 8}
    assert verdict_of(ga.load_preset("bob.yaml", overrides=moved), version())["verdict"] == "good"
    assert verdict_of(ga.load_preset("bob.yaml", overrides={"forces.spring.stiffness": 9}), version()) == {
        "verdict": "not checked"
    }
    # a picture made again has the verdict of the first, checked here or not
    (tmp_path / "verdicts.json").unlink()
    assert gen_art("rerun", "after.png", "-o", "again.png").status == 0
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "after.png").read_bytes()
    (tmp_path / "verdicts.json").write_text("[1", encoding="utf-8")
    assert verdict_of(ga.load_preset("bob.yaml"), version()) == {"verdict": "not checked"}


def test_the_command(gen_art, tmp_path):
    (tmp_path / "bob.yaml").write_text(YAML, encoding="utf-8")
    (tmp_path / "euler.yaml").write_text(YAML.replace("leapfrog", "euler"), encoding="utf-8")
    (tmp_path / "bare.yaml").write_text(YAML.split("expect:")[0].replace("leapfrog", "euler"), encoding="utf-8")
    both = gen_art("check", "bob.yaml", "euler.yaml", "--no-keep")
    assert both.status == 3 and "1 of 2 presets are good" in both.out and "does not hold energy" in both.out
    assert not (tmp_path / "verdicts.json").exists()
    bare = gen_art("check", "bare.yaml")
    assert bare.status == 2 and "expects nothing" in bare.err
    marked = gen_art("check", "bare.yaml", "--expect", "bob.yaml", "--json")
    assert marked.status == 3 and json.loads(marked.out)["bare.yaml"]["claims"][0]["verdict"] == "does not hold"
    assert gen_art("check", "bob.yaml", "--expect", "bare.yaml").status == 2
    gen_art("check", "bob.yaml", "euler.yaml")
    kept = json.loads((tmp_path / "verdicts.json").read_text(encoding="utf-8"))
    assert {name: one["verdict"] for name, one in kept.items()} == {"bob": "good", "euler": "not good"}


def test_several_processes_find_what_one_does(gen_art, tmp_path):
    (tmp_path / "bob.yaml").write_text(YAML, encoding="utf-8")
    (tmp_path / "euler.yaml").write_text(YAML.replace("leapfrog", "euler"), encoding="utf-8")
    one, two = (gen_art("check", "bob.yaml", "euler.yaml", "--no-keep", "--workers", count) for count in (1, 2))
    assert one.status == two.status == 3 and one.out == two.out and "euler" in two.out
    (tmp_path / "bare.yaml").write_text(YAML.split("expect:")[0], encoding="utf-8")
    wrong = gen_art("check", "bare.yaml", "bob.yaml", "--workers", 2)
    assert wrong.status == 2 and "expects nothing" in wrong.err and "Traceback" not in wrong.err


def test_what_cannot_be_shared_or_stale_is_said(gen_art, tmp_path):
    (tmp_path / "bob.yaml").write_text(YAML, encoding="utf-8")
    for words in (("-", "bob.yaml", "--workers", 2), ("-", "--stale")):
        wrong = gen_art("check", *words)
        assert wrong.status == 2 and "can be read once only" in wrong.err
    both = gen_art("check", "bob.yaml", "--stale", "--expect", "bob.yaml")
    assert both.status == 2 and "leave one of them out" in both.err
    assert gen_art("check", "bob.yaml", "--workers", 0).status == 2


def test_stale_checks_what_has_changed(gen_art, tmp_path):
    bob = tmp_path / "bob.yaml"
    bob.write_text(YAML, encoding="utf-8")
    first = gen_art("check", "bob.yaml", "--stale")
    assert first.status == 0 and "holds" in first.out
    again = gen_art("check", "bob.yaml", "--stale")
    assert again.status == 0 and again.out.strip() == "every kept verdict is good, and of the present preset"
    bob.write_text(YAML.replace("9.8696", "9.8"), encoding="utf-8")
    assert "holds" in gen_art("check", "bob.yaml", "--stale").out
    bob.write_text(YAML.replace("leapfrog", "euler"), encoding="utf-8")
    assert gen_art("check", "bob.yaml", "--stale").status == gen_art("check", "bob.yaml", "--stale").status == 3


def test_no_verdict_is_kept_of_a_preset_that_was_saved_meanwhile(gen_art, tmp_path, monkeypatch):
    bob, whole_check = tmp_path / "bob.yaml", expectations.check
    bob.write_text(YAML, encoding="utf-8")

    def saved_meanwhile(preset, threads):
        bob.write_text(YAML.replace("9.8696", "9.8"), encoding="utf-8")
        return whole_check(preset, threads)

    monkeypatch.setattr(expectations, "check", saved_meanwhile)
    checked = gen_art("check", "bob.yaml")
    assert checked.status == 0 and "bob.yaml was changed while it was checked" in checked.err
    monkeypatch.undo()
    assert verdict_of(ga.load_preset(bob), version()) == {"verdict": "not checked"}
