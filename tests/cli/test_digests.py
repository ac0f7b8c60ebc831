"""`gen-art digests`: what it writes, and how it compares."""

import copy
import json

from gen_art.audit.digests import differences, state_digests
from tests.output.piece import piece


def test_digests_say_where_two_results_part():
    ours = state_digests([piece()], steps=(0, 1, 3))
    assert ours["processor"] and set(ours["digests"]["small"]) == {"f32", "f64"}
    moments = ours["digests"]["small"]["f32"]
    assert list(moments) == ["0", "1", "3"] and set(moments["1"]) == {"sparks", "puff"}
    assert moments["0"]["puff"] != moments["1"]["puff"] != moments["3"]["puff"]
    assert differences(ours, state_digests([piece()], steps=(0, 1, 3))) == []
    other = copy.deepcopy(ours)
    other["digests"]["small"]["f32"]["1"]["puff"] = other["digests"]["small"]["f32"]["3"]["puff"] = "0"
    assert differences(ours, other) == ["small f32: puff differs from step 1 on"]


def test_the_command_writes_and_compares(gen_art, tmp_path):
    preset = tmp_path / "p.yaml"
    preset.write_text(
        "version: 1\nclock: {duration: 1, step: 1/60}\nsystems: {a: {emitters: {e: {count: 9}}, look: {draw: point}}}\n",
        encoding="utf-8",
    )
    assert gen_art("digests", preset, "-o", "a.json").status == 0
    held = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert held["digests"].keys() == {"p"}
    same = gen_art("digests", preset, "--compare", "a.json")
    assert same.status == 0 and "0 systems differ" in same.out
    held["digests"]["p"]["f64"]["16"]["a"] = "0"
    (tmp_path / "b.json").write_text(json.dumps(held), encoding="utf-8")
    other = gen_art("digests", preset, "--compare", "b.json")
    assert other.status == 1 and "p f64: a differs from step 16 on" in other.out
    assert gen_art("digests", preset, "-o", "a.json").status == 5
    assert gen_art("digests", preset).status == 2
    (tmp_path / "c.json").write_text("[1]", encoding="utf-8")
    wrong = gen_art("digests", preset, "--compare", "c.json")
    assert wrong.status == 2 and "holds no digests" in wrong.err
    assert gen_art("digests", preset, "--compare", "none.json").status == 5
