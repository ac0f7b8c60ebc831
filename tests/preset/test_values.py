"""Numbers, ranges and curves as a preset writes them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen_art.errors import UsageError
from gen_art.preset.values import Curve, Range, number, vector

# Taichi, once started, makes the processor flush subnormal numbers to zero
FINITE = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=False)


@pytest.mark.parametrize(("text", "value"), [("1/240", 1 / 240), (" 3 ", 3.0), ("-.5", -0.5), ("1e-3", 1e-3), (7, 7.0)])
def test_number(text, value):
    assert number(text) == value


@pytest.mark.parametrize(
    "bad", ["", "x", "1/0", "1//2", "nan", "inf", "1e999", math.nan, math.inf, True, None, [1], 10**400]
)
def test_number_refuses(bad):
    with pytest.raises(UsageError, match="number"):
        number(bad)


@pytest.mark.parametrize(
    ("text", "lo", "hi"),
    [
        ("2..4", 2, 4),
        ("-3..5", -3, 5),
        ("-3..-1", -3, -1),
        (".5..1", 0.5, 1),
        ("1/4..1/2", 0.25, 0.5),
        (3, 3, 3),
        ("1e3..2e3", 1e3, 2e3),
    ],
)
def test_range(text, lo, hi):
    assert Range.of(text) == Range(lo, hi)


@pytest.mark.parametrize("bad", ["..2", "2..", "a..b", "2..nan", "1..2..3"])
def test_range_refuses(bad):
    with pytest.raises(UsageError):
        Range.of(bad)


def test_range_the_wrong_way_round_says_how_to_write_it():
    with pytest.raises(UsageError, match=r"write 2\.\.4"):
        Range.of("4..2")


@given(FINITE, FINITE)
def test_range_survives_its_own_text(a, b):
    whole = Range(min(a, b), max(a, b))
    assert Range.of(str(whole)) == whole


def test_vector():
    assert vector([1, "1/2", -3]) == (1.0, 0.5, -3.0)
    for bad in ([1, 2], [1, 2, math.nan], "123", {"x": 1}, 5):
        with pytest.raises(UsageError):
            vector(bad)


def test_curve_is_linear_between_keys_and_constant_outside():
    curve = Curve.of([[0, 1], [1, 3], [2, 0]])
    assert [curve(x) for x in (-1, 0, 0.5, 1, 1.5, 2, 9)] == [1, 1, 2, 3, 1.5, 0, 0]


def test_curve_integral():
    curve = Curve.of({"curve": [[0, 1], [1, 3], [2, 0]]})
    assert curve.integral(-1, 3) == pytest.approx(1 + 2 + 1.5 + 0)


@pytest.mark.parametrize("bad", [[], [[0, 1], [0, 2]], [[1, 0], [0, 0]], [[0]], [0, 1], "abc", [[0, math.inf]]])
def test_curve_refuses(bad):
    with pytest.raises(UsageError):
        Curve.of(bad)
