"""The presets of the course: each says what it shows, loads, runs and draws."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.preset.load import load_preset
from gen_art.preset.shipped import course_names, presets_folder

_STEPS, _TRIES = 24, 40


def test_there_are_some_and_they_go_by_their_name():
    assert {"course/bouncing_balls", "course/obstacles", "course/gas_in_a_box"} <= set(course_names())
    assert load_preset("course/bouncing_balls").name == "bouncing_balls"
    with pytest.raises(ga.UsageError, match="did you mean 'course/obstacles'"):
        load_preset("course/obstacle")


@pytest.mark.parametrize("name", course_names())
def test_it_says_what_it_shows(name):
    first, second, third = (presets_folder() / f"{name}.yaml").read_text(encoding="utf-8").splitlines()[:3]
    assert first.startswith("# ") and len(first.split()) > 5
    assert second.startswith("# Physics: ")
    assert third.startswith("# Change first: ")


@pytest.mark.parametrize("name", course_names())
def test_it_runs_and_draws(name):
    """From the start until something can be seen, in a tiny frame."""
    piece = load_preset(name)
    sim = ga.Simulation(piece)
    for _ in range(_TRIES):
        sim.step(_STEPS)
        light = ga.render_frame(sim, size=(64, 36))
        assert np.isfinite(light).all()
        if light[..., :3].max() > 0:
            break
    else:
        raise AssertionError(f"nothing to be seen after {sim.time:g} s")
    for system in piece.systems:
        assert np.isfinite(sim[system].position).all()
