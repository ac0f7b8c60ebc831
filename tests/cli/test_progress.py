"""Progress: JSON lines, a bar, or nothing; always on standard error."""

import json

import pytest

from gen_art.commands.progress import _clock, reporter

EVENT = {"event": "frame", "frame": 4, "frames": 10, "particles": 12345, "fps": 2.5, "eta": 75.2}


def test_json_is_one_object_a_line(capsys):
    with reporter("json") as report:
        report(EVENT)
        report({**EVENT, "frame": 5})
    captured = capsys.readouterr()
    assert [json.loads(line)["frame"] for line in captured.err.splitlines()] == [4, 5]
    assert not captured.out


@pytest.mark.parametrize("mode", ["none", "auto"])
def test_nothing_where_nobody_looks(mode):
    with reporter(mode) as report:
        assert report is None


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
