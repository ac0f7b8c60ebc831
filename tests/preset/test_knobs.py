"""Knobs with a range and a unit beside the plain ones: values, overrides, problems, and the text that is written back."""

import jsonschema
import pytest

from gen_art.errors import PresetError, UsageError
from gen_art.preset.knobs import Knob
from gen_art.preset.load import PresetSource, load_preset
from gen_art.preset.schema import json_schema
from gen_art.preset.shipped import course_names, preset_names
from gen_art.preset.values import Range
from gen_art.preset.writing import changed_text
from tests.preset.piece import TEXT

DESCRIBED = TEXT.replace("push: 9", "push: {value: 9, range: 2..20, unit: m/s}")


def described(tmp_path, text=DESCRIBED):
    path = tmp_path / "piece.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_described_knob_stands_for_its_value(tmp_path):
    preset = load_preset(described(tmp_path))
    assert preset == load_preset(described(tmp_path, TEXT))
    assert preset.knobs["push"] == Knob(9, Range(2.0, 20.0), "m/s") and preset.knobs["life"] == Knob("1..2")
    assert str(preset.knobs["push"]) == "9 m/s (2..20)"
    assert preset.knobs["push"].number == 9.0 and preset.knobs["life"].number is None
    assert load_preset(preset).knobs == {}, "filled in, and gone"


@pytest.mark.parametrize("overrides", [{"knobs.push": 12}, {"knobs": {"push": 12}}, {"knobs.push.value": 12}])
def test_setting_it_keeps_its_range_and_unit(tmp_path, overrides):
    preset = load_preset(described(tmp_path), overrides)
    assert preset.knobs["push"] == Knob(12, Range(2.0, 20.0), "m/s")
    assert preset == load_preset(described(tmp_path, TEXT), {"knobs.push": 12})
    assert "push: {value: 12, range: 2..20, unit: m/s}" in changed_text(DESCRIBED, overrides)


def test_values_outside_the_range_are_allowed_and_the_range_can_be_set(tmp_path):
    assert load_preset(described(tmp_path), {"knobs.push": 50}).knobs["push"].number == 50.0
    assert load_preset(described(tmp_path), {"knobs.push.range": "1..90"}).knobs["push"].range == Range(1.0, 90.0)


@pytest.mark.parametrize(
    ("knob", "words"),
    [
        ("{value: 9, rang: 2..20}", "'rang' is unknown; did you mean 'range'?"),
        ("{value: 9, range: 3}", "has two ends"),
        ("{value: 9, range: 20..2}", "from small to large"),
        ("{value: 1..2, range: 2..20}", "has a range, so it must be a number, not '1..2'"),
        ("{value: 9, unit: 3}", "the unit of a knob is text, not 3"),
        ("{value: $life}", "a knob must have a value, not another knob"),
    ],
)
def test_problems_have_their_place(tmp_path, knob, words):
    with pytest.raises(PresetError) as caught:
        load_preset(described(tmp_path, TEXT.replace("push: 9", f"push: {knob}")))
    problem = caught.value.problems[0]
    assert words in problem.text and problem.line == 6 and problem.path[:2] == ("knobs", "push")


def test_a_problem_of_a_value_that_was_set_says_so(tmp_path):
    with pytest.raises(PresetError) as caught:
        load_preset(described(tmp_path), {"knobs.push": "fast"})
    assert "--set" in str(caught.value)
    with pytest.raises(UsageError, match="there is no knob 'pus'; did you mean 'push'"):
        load_preset(described(tmp_path), {"knobs.pus": 3})


def test_a_source_is_read_once_and_loaded_many_times(tmp_path):
    path = described(tmp_path)
    source = PresetSource.of(path)
    path.unlink()
    assert [source.load({"knobs.push": k}).knobs["push"].value for k in (3, 4)] == [3, 4]
    assert source.load().knobs["push"].value == 9 and source.load(seed=8).seed == 8
    assert PresetSource.of(source) is source


def test_every_shipped_range_holds_its_value_and_the_schema_accepts_both_forms():
    found = 0
    for name in [*preset_names(), *course_names()]:
        for knob in load_preset(name).knobs.values():
            if knob.range is not None:
                found += 1
                assert knob.number is not None and knob.range.lo <= knob.number <= knob.range.hi, name
    assert found > 20
    schema = {"type": "object", "properties": {"knobs": json_schema()["properties"]["knobs"]}}
    for knob in (3, "1..2", [1, 2], {"point": 1}, {"value": 3}, {"value": 3, "range": "1..4", "unit": "m"}):
        jsonschema.validate({"knobs": {"a": knob}}, schema)
    for knob in ({"value": 3, "range": 4}, {"value": 3, "unit": 1}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({"knobs": {"a": knob}}, schema)
