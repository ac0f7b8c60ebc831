"""The simulation before the first picture says how long it takes, where that is long."""

import numpy as np
import pytest

from gen_art.output import wait as module
from gen_art.output.playback import Playback
from gen_art.output.wait import Wait
from gen_art.preset.load import load_preset


@pytest.fixture
def clock(monkeypatch):
    """A clock that only what is called moves."""
    now = [0.0]
    monkeypatch.setattr(module.time, "perf_counter", lambda: now[0])
    return now


def events_of(clock, parts, seconds, first=0.0) -> tuple[list[dict], list[int]]:
    """(events, numbers of steps of each call) of a simulation whose steps take so many seconds; its first one `first` more."""
    events: list[dict] = []
    calls: list[int] = []

    def step(n):
        clock[0] += n * seconds + (first if not calls else 0.0)
        calls.append(n)

    wait = Wait(events.append, sum(parts))
    for part in parts:
        wait.advance(step, part)
    return events, calls


def test_a_short_wait_says_nothing(clock):
    events, calls = events_of(clock, [90], 0.1)
    assert events == [] and sum(calls) == 90


def test_a_long_wait_is_told_about_once_a_second_until_it_ends(clock):
    events, calls = events_of(clock, [40, 80], 0.5, first=30.0)
    assert sum(calls) == 120
    assert events[0]["of"] == 120 and events[0]["eta"] == pytest.approx(0.5 * (120 - events[0]["steps"]))
    left = [event["eta"] for event in events]
    assert left == sorted(left, reverse=True) and left[-1] <= 0.5  # the time of the first step is no pace
    assert 50 <= len(events) <= 70


def test_quick_steps_are_called_together(clock):
    _, calls = events_of(clock, [1_000_000], 1e-5)
    assert sum(calls) == 1_000_000 and len(calls) < 60


def test_telling_changes_no_bits():
    """Steps in parts give the same picture."""
    preset = load_preset("smoke", overrides={"knobs.rate": 20000, "clock.preroll": 1})
    pictures = [
        np.array(Playback(preset, (64, 36), "f32", None, tell=tell).picture(preset.clock.preroll_steps + 3))
        for tell in (None, lambda event: None)
    ]
    np.testing.assert_array_equal(*pictures)
