"""Births that no picture shows are left out, and every picture keeps its bits."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset
from gen_art.simulation.unneeded_births import leave_out_births

BASE = {
    "version": 1, "seed": 6, "clock": {"duration": 4, "fps": 20, "step": "1/100", "preroll": 1},
    "forces": {"gravity": [0, -3, 0], "curl_noise": {"strength": 2, "scale": 0.5, "speed": 1}},
    "systems": {"sparks": {
        "particle": {"radius": 0.02, "mass": 1, "lifetime": "0.3..0.5"},
        "colliders": {"plane": {"point": [0, -0.3, 0], "action": "kill"}},
        "emitters": {
            "jet": {"rate": 900, "velocity": {"cone": [0, 1, 0], "angle": 20, "speed": "1..2"}},
            "burst": {"at": [2.35, 3.9], "count": 40, "lifetime": 0.7, "velocity": {"sphere": 1}},
        },
        "look": {"draw": "disc", "emission": {"color": {"by": "id", "range": "0..4000", "gradient": ["red", "blue"]}}},
    }},
    "camera": {"position": [0, 0, 4], "target": [0, 0.3, 0]},
}  # fmt: skip
RIBBON = {"draw": "streak", "width": 0.01, "ribbon": {"length": 0.4, "points": 12}}
TRAIL = {"draw": "point", "trail": {"half_life": 0.02}}
CASES = {
    "plain": {},
    "subframes": {
        "camera.shutter": 360,
        "camera.subframes": 5,
        "systems.sparks.particle.lifetime": 0.5,
        "systems.sparks.emitters.burst.lifetime": 0.5,
    },
    "ribbons": {"systems.sparks.look": RIBBON},
    "trails": {"systems.sparks.look": TRAIL},
    "exposure": {"develop": {"auto_exposure": {"half_life": 0.2}}},
}


def pictures(preset, steps, sim=None) -> list[np.ndarray]:
    playback = Playback(preset, (96, 54), "f32", None, sim=sim)
    return [np.append(linear, stops) for linear, stops in playback.pictures(steps)]


@pytest.mark.parametrize("case", CASES)
def test_pictures_keep_their_bits(case, monkeypatch):
    """Mutants: ids begin at 0; a trail's, the shutter's or the metering's time is forgotten; a lifetime is taken as shorter."""
    preset = load_preset(BASE, overrides=CASES[case])
    steps = [preset.clock.step_at(time) for time in (2.9, 2.95, 3.5)]
    few = pictures(preset, steps)
    monkeypatch.setattr(Playback, "_leave_out_births", lambda self, step: None)
    for a, b in zip(few, pictures(preset, steps), strict=True):
        assert np.array_equal(a, b) and a.max() > 0


def test_the_state_is_that_of_all_births():
    preset = load_preset(BASE)
    whole, short = ga.Simulation(preset), ga.Simulation(preset)
    assert leave_out_births(short, 300) == ["sparks"]
    assert short["sparks"].count == 0 and short.systems["sparks"].next_id > 1500
    for sim in (whole, short):
        sim.step(300)
    assert short.digest() == whole.digest()
    short.step(50)
    whole.step(50)
    assert short.digest() == whole.digest()


FAMILY = {  # the last children live 0.5 s after their parents, of which the sparks live up to 0.7 s and the shells 0.4 s
    "systems.shells": {
        "particle": {"radius": 0.02, "mass": 1, "lifetime": 0.4},
        "emitters": {"jet": {"rate": 60, "velocity": {"sphere": 1}}},
        "look": {"draw": "disc", "emission": {"color": {"by": "id", "range": "0..400", "gradient": ["red", "blue"]}}},
    },
    "systems.children": {
        "particle": {"radius": 0.02, "mass": 1, "lifetime": "0.1..0.3"},
        "emitters": {
            "of_dead": {"from": {"event": "shells.death"}, "count": "1..6", "velocity": {"sphere": 1}},
            "on_path": {"from": {"event": "sparks.path", "inherit": "none"}, "rate": 9},
        },
        "look": {"draw": "disc", "emission": {"color": {"by": "random", "gradient": ["red", "blue"]}}},
    },
    "systems.grandchildren": {
        "particle": {"radius": 0.02, "mass": 1, "lifetime": 0.2},
        "emitters": {"of_dead": {"from": {"event": "children.death"}, "count": 2, "velocity": {"sphere": 1}}},
        "look": {"draw": "disc", "emission": {"color": "green"}},
    },
}
DEEP = {"systems.grandchildren.particle.lifetime": 1.1}
BY_ID = {"systems.children.look.emission.color": {"by": "id", "range": "0..4000", "gradient": ["red", "blue"]}}


@pytest.mark.parametrize("changes", [{}, DEEP, BY_ID], ids=["short", "deep", "by id"])
def test_pictures_of_families_keep_their_bits(changes, monkeypatch):
    """Mutants: the children's time is left out of their parents' or the parents' of the children's; children whose looks go by
    `id` lack births; the events of a step too many are left out."""
    preset = load_preset(BASE, overrides=FAMILY | changes)
    steps = [preset.clock.step_at(time) for time in (2.3, 2.35)]
    few = pictures(preset, steps)
    monkeypatch.setattr(Playback, "_leave_out_births", lambda self, step: None)
    for a, b in zip(few, pictures(preset, steps), strict=True):
        assert np.array_equal(a, b) and a.max() > 0


@pytest.mark.parametrize(
    "changes, shortened",
    [
        ({}, ["sparks", "shells", "children", "grandchildren"]),
        (DEEP, ["sparks", "shells", "children", "grandchildren"]),
        (BY_ID, ["grandchildren"]),
        ({"systems.grandchildren.particle.lifetime": 1000}, []),
        (
            {"systems.children.interactions": {"contacts": {}}, "systems.children.integrator": "semi_implicit_euler"},
            ["grandchildren"],
        ),
    ],
)
def test_families_lack_the_births_that_nothing_shows(changes, shortened):
    sim = ga.Simulation(load_preset(BASE, overrides=FAMILY | changes), advice="none")
    assert leave_out_births(sim, 330) == shortened


def test_events_of_the_past_make_no_children():
    """Most births are not even made: of grandchildren those of 0.2 s of 2.9. Mutant: an emitter's beginning is not looked at."""
    preset = load_preset(BASE, overrides=FAMILY)
    whole, short = (ga.Simulation(preset, advice="none") for _ in range(2))
    leave_out_births(short, 330)
    for sim in (whole, short):
        sim.step(330)
    for name in preset.systems:
        a, b = whole[name].state, short[name].state
        alive, kept = a.alive(whole.time), b.alive(short.time)
        assert np.array_equal(a.floats[:, : a.count][:, alive], b.floats[:, : b.count][:, kept]) and alive.any()
    assert short["children"].state.next_id < whole["children"].state.next_id / 3
    assert short["grandchildren"].state.next_id < whole["grandchildren"].state.next_id / 8


@pytest.mark.parametrize(
    "changes",
    [
        {"systems.sparks.interactions": {"contacts": {}}, "systems.sparks.integrator": "semi_implicit_euler"},
        {"systems.sparks.emitters.forever": {"count": 1, "lifetime": 1000}},
    ],
)
def test_births_that_something_depends_on_are_made(changes):
    """Mutants: systems with interactions lack births; the shortest lifetime decides."""
    sim = ga.Simulation(load_preset(BASE, overrides=changes), advice="none")
    assert leave_out_births(sim, 300) == []


def test_a_ledger_and_a_simulation_that_has_begun_keep_all_births():
    preset = load_preset(BASE)
    assert leave_out_births(ga.Simulation(preset, ledger=True), 300) == []
    begun = ga.Simulation(preset)
    begun.step(1)
    assert leave_out_births(begun, 300) == []


def test_a_playback_that_goes_on_with_a_simulation_leaves_nothing_out(monkeypatch):
    """Mutant: it leaves births out, which a later step of the simulation may show."""
    sim = ga.Simulation(load_preset(BASE))
    monkeypatch.setattr("gen_art.simulation.unneeded_births.leave_out_births", None)
    pictures(sim.preset, [300], sim=sim)
