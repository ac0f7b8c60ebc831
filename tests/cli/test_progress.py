"""Progress: JSON lines, a bar, or nothing; always on standard error."""

import json

import pytest

import gen_art as ga
from gen_art.commands.progress import _clock, reporter

EVENT = {"event": "frame", "frame": 4, "frames": 10, "particles": 12345, "fps": 2.5, "eta": 75.2}


def test_json_is_one_object_a_line(capsys):
    with reporter("json") as report:
        report(EVENT)
        report({**EVENT, "frame": 5})
    captured = capsys.readouterr()
    assert [json.loads(line)["frame"] for line in captured.err.splitlines()] == [4, 5]
    assert not captured.out


def test_nothing_where_nobody_looks():
    with reporter("none") as report:
        assert report is None


TIMES = {"event": "times", "total": 12.34, "simulate": 4.1, "draw": 6.0, "develop": 1.2, "encode": 0.9}


@pytest.mark.parametrize("mode", ["auto", "rich"])
def test_the_times_of_the_stages_are_printed_at_the_end(mode, capsys):
    with reporter(mode) as report:
        report(EVENT)
        report(TIMES)
    captured = capsys.readouterr()
    assert (
        "12.3 s: simulated 4.1, drew 6.0, developed 1.2, waited for the encoder 0.9" in captured.err
        and not captured.out
    )


def test_a_film_says_where_its_time_went(tmp_path):
    events = []
    preset = {
        "version": 1,
        "clock": {"duration": 0.2, "fps": 10, "step": "1/100"},
        "systems": {"dots": {"emitters": {"one": {"count": 9}}}},
    }
    for name in ("film.mp4", "frame_##.png"):
        ga.render(preset, tmp_path / name, size=(64, 48), times=events.append)
        times = events[-1]
        stages = [times[stage] for stage in ("simulate", "draw", "develop", "encode")]
        assert times["event"] == "times" and min(stages) > 0 and sum(stages) <= times["total"]


def test_the_bar_shows_frame_particles_rate_and_time_left(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    with reporter("rich") as report:
        report(EVENT)
    captured = capsys.readouterr()
    assert not captured.out
    for words in ("5/10", "12,345 particles", "2.50 frames/s", "1:15 left"):
        assert words in captured.err


def test_time_left():
    assert [_clock(seconds) for seconds in (0, 59.6, 3661)] == ["0:00", "1:00", "1:01:01"]
