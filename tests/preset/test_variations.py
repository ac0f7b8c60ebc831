"""Axes, seeds and mutations: what `--vary`, `--seeds` and `--mutate` mean."""

import pytest

from gen_art.errors import UsageError
from gen_art.preset.knobs import Knob
from gen_art.preset.values import Range
from gen_art.preset.variations import Axis, grid_of, in_rows, mutations, parse_seeds, parse_vary

KNOBS = {
    "heat": Knob(1500, Range(1200.0, 1900.0), "K"),
    "free": Knob(4.0),
    "shape": Knob({"disc": 1}),
    "life": Knob("1..2"),
}


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("knobs.heat=1200..1900..3", (1200, 1550, 1900)),
        ("knobs.heat=0..1..5", (0, 0.25, 0.5, 0.75, 1)),
        ("knobs.heat=0.1..0.3..3", (0.1, 0.2, 0.3)),
        ("knobs.heat=-1..1..2", (-1, 1)),
        ("knobs.heat=3..1..3", (3, 2, 1)),
        ("clock.step=1/120..1/60..2", (0.00833333333333, 0.0166666666667)),
        ("knobs.heat=5", (5,)),
        ("knobs.heat=5,7.5", (5, 7.5)),
        ("life=1..2,3..4", ("1..2", "3..4")),
        ("a.wind=[0, 1, 0],[1, 0, 0]", ([0, 1, 0], [1, 0, 0])),
        ("a.color=red,'#ffaa00'", ("red", "#ffaa00")),
    ],
)
def test_values_of_an_axis(text, values):
    axis = parse_vary(text)
    assert axis.values == values and axis.path == text.partition("=")[0]
    assert all(type(a) is type(b) for a, b in zip(axis.values, values))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("heat", "write a path and its values"),
        ("=1..2..3", "write a path"),
        ("heat=", "write a path"),
        ("heat=1..2", "how many"),
        ("heat=a..b..3", "must be a number, not 'a'"),
        ("heat=1..2..1", "it can be 2 to 10,000"),
        ("heat=1..2..20000", "it can be 2 to 10,000"),
        ("he at]=1,2", "is not a path"),
    ],
)
def test_wrong_axes(text, words):
    with pytest.raises(UsageError, match=words):
        parse_vary(text)


def test_seeds():
    assert parse_seeds("3..6") == Axis("seed", (3, 4, 5, 6)) and parse_seeds("9,2..3").values == (9, 2, 3)
    for text, words in (
        ("a", "first and last seed"),
        ("3..1", "from small to large: 1..3"),
        ("", "write"),
        ("0..99999", "100,000 variations"),
    ):
        with pytest.raises(UsageError, match=words):
            parse_seeds(text)


def test_a_grid_of_two_axes_has_the_first_down_and_the_second_across():
    rows = grid_of([parse_seeds("1,2"), parse_vary("knobs.heat=10,20,30")])
    assert [len(row) for row in rows] == [3, 3]
    assert rows[1][2].changes == {"seed": 2, "knobs.heat": 30} and rows[1][2].label == "seed 2, heat 30"
    assert rows[1][2].names == {"seed": "2", "heat": "30"}


def test_a_grid_of_one_axis_is_about_square():
    assert [[len(row) for row in in_rows(list(range(n)))] for n in (1, 2, 4, 5, 9, 16)] == [
        [1],
        [2],
        [2, 2],
        [3, 2],
        [3] * 3,
        [4] * 4,
    ]


def test_wrong_grids():
    one, many = Axis("a", (1, 2)), Axis("b", tuple(range(6000)))
    for axes, words in (
        ([], "0 things vary"),
        ([one, one], "a varies twice"),
        ([one, many], "12,000 variations"),
        ([one, many, one], "3 things"),
    ):
        with pytest.raises(UsageError, match=words):
            grid_of(axes)


def test_mutations_stay_in_the_ranges_and_the_first_is_the_preset():
    found = mutations(KNOBS, 0.5, 200, seed=3)
    assert found[0].changes == {} and found[0].label == "as it is"
    heats = [one.changes["knobs.heat"] for one in found[1:]]
    free = [one.changes["knobs.free"] for one in found[1:]]
    assert all(set(one.changes) == {"knobs.heat", "knobs.free"} for one in found[1:])
    assert 1200 == min(heats) < max(heats) and max(heats) <= 1850, "1500 +- 350, cut at the range"
    assert 2.0 <= min(free) < 2.2 and 5.8 < max(free) <= 6.0
    assert len(set(heats)) > 100


def test_mutations_follow_the_seed_and_not_each_other():
    assert mutations(KNOBS, 0.2, 9, 1) == mutations(KNOBS, 0.2, 9, 1) != mutations(KNOBS, 0.2, 9, 2)
    assert mutations(KNOBS, 0.2, 9, 1)[:4] == mutations(KNOBS, 0.2, 4, 1), "more of them change none of the first"
    fewer = mutations({"heat": KNOBS["heat"]}, 0.2, 9, 1)
    assert [one.changes.get("knobs.heat") for one in fewer] == [
        one.changes.get("knobs.heat") for one in mutations(KNOBS, 0.2, 9, 1)
    ]


def test_wrong_mutations():
    for arguments, words in (
        ((KNOBS, 1.5, 4, 0), "at most 1, not 1.5"), ((KNOBS, 0.0, 4, 0), "above 0"), ((KNOBS, 0.2, 0, 0), "--count is 1 to"),
        (({"life": Knob("1..2")}, 0.2, 4, 0), "the preset has none"),
    ):  # fmt: skip
        with pytest.raises(UsageError, match=words):
            mutations(*arguments)


def test_a_knob_that_is_a_whole_number_stays_one():
    found = mutations({"count": Knob(8, Range(1.0, 20.0)), "free": Knob(100)}, 0.5, 50, seed=1)
    assert all(isinstance(value, int) for one in found for value in one.changes.values())
    assert len({one.changes["knobs.count"] for one in found[1:]}) > 5
