"""One mechanism turns registered classes into preset values; here on a registry of its own."""

import math

import pytest
from pydantic import ValidationError

from gen_art.preset import registered
from gen_art.preset.registered import Many, One, build, class_schema
from gen_art.registry import Parametric, Registry, param

THINGS = Registry("thing")


@THINGS("push")
class Push(Parametric):
    """A push along x. F = strength x."""

    strength: float = param(1.0, unit="N", min=0, max=10, doc="how hard")
    times: int = param(1, min=1)


@THINGS("turn")
class Turn(Parametric):
    """A turn about an axis."""

    axis: tuple = param((0.0, 1.0, 0.0))
    angle: float = param(0.0, unit="rad", min=0, max=math.pi)
    speed: tuple = param((1.0, 2.0), unit="m/s", kind="range")
    way: str = param("left", choices=("left", "right"))


@THINGS("span")
class Span(Parametric):
    """From one point to another."""

    start: tuple = param(unit="m")
    end: tuple = param((1.0, 0.0, 0.0), unit="m")


@pytest.fixture(autouse=True)
def things(monkeypatch):
    monkeypatch.setattr(registered, "registry", lambda kind: THINGS)


def problems(call, value):
    with pytest.raises(ValidationError) as caught:
        call(value)
    return {".".join(map(str, e["loc"])): e.get("ctx", {}).get("text", e["msg"]) for e in caught.value.errors()}


def test_the_short_form_is_the_first_parameter():
    assert build(Push, 3).values == {"strength": 3.0, "times": 1}
    assert build(Push, {"times": 2}).values == {"strength": 1.0, "times": 2}
    assert build(Push, None).values["strength"] == 1.0


def test_a_list_of_vectors_is_the_first_parameters_in_order():
    assert build(Span, [[0, 0, 0], [0, "1/2", 0]]).values == {"start": (0, 0, 0), "end": (0, 0.5, 0)}
    assert build(Span, [1, 2, 3]).values["start"] == (1, 2, 3)


def test_angles_are_degrees_and_ranges_are_ranges():
    made = build(Turn, {"angle": 90, "speed": "2..4"})
    assert made.values["angle"] == pytest.approx(math.pi / 2)
    assert made.values["speed"] == (2.0, 4.0)


def test_every_problem_has_its_path():
    found = problems(lambda v: build(Turn, v), {"angle": 270, "sped": 3, "way": "lft", "axis": [1, 2]})
    assert found["angle"] == "must be from 0 to 180 degrees, not 270"
    assert "did you mean 'speed'" in found["sped"]
    assert "did you mean 'left'" in found["way"]
    assert "three numbers" in found["axis"]
    assert problems(lambda v: build(Span, v), {"end": [0, 0, 0]}) == {"start": "is missing"}
    assert "whole number" in problems(lambda v: build(Push, v), {"times": 1.5})["times"]


def test_many_is_in_the_order_of_names_whatever_the_file_says():
    many = Many("things")
    one, other = {"push": 2, "turn": {"angle": 5}}, {"turn": {"angle": 5}, "push": 2}
    assert [repr(t) for t in many.validate(one)] == [repr(t) for t in many.validate(other)]
    assert len(many.validate({"push": [{"strength": 1}, {"strength": 2}]})) == 2


def test_many_names_what_is_unknown():
    assert "did you mean 'push'" in problems(Many("things").validate, {"psh": 1})["psh"]
    assert "strength" in next(iter(problems(Many("things").validate, {"push": -1})))


def test_one_takes_its_parameters_from_beside_the_name():
    one = One("things", bare="span")
    made = one.validate({"turn": [1, 0, 0], "angle": 5, "speed": 3})
    assert made.values["axis"] == (1, 0, 0)
    assert made.values["speed"] == (3.0, 3.0)
    assert one.validate([0, 1, 2]).values["start"] == (0, 1, 2)
    assert one.validate({"turn": {"angle": 180}}).values["angle"] == pytest.approx(math.pi)


def test_one_says_what_is_wrong_and_where():
    one = One("things", bare="span")
    assert set(problems(one.validate, {"turn": [1, 0, 0], "angel": 5})) == {"angel"}
    assert set(problems(one.validate, {"turn": {"angle": 999}})) == {"turn.angle"}
    assert "did you mean 'turn'" in problems(one.validate, {"trun": 1})["trun"]
    for bad in ({}, 5, "left", {"push": 1, "turn": 1}):
        with pytest.raises(ValueError, match=r"must be a vector|has both"):
            one.validate(bad)


def test_the_schema_of_a_class_speaks_yaml():
    schema = class_schema(Turn)
    angle = schema["anyOf"][0]["properties"]["angle"]
    assert angle["unit"] == "degrees"
    assert angle["anyOf"][0]["maximum"] == pytest.approx(180)
    assert schema["anyOf"][0]["properties"]["way"]["enum"] == ["left", "right"]
    assert schema["anyOf"][0]["properties"]["speed"]["default"] == "1.0..2.0"
    assert class_schema(Span)["anyOf"][0]["required"] == ["start"]
