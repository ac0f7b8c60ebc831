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


CHILDREN = {
    "particle": {"radius": 0.01, "mass": 1, "lifetime": 0.3},
    "emitters": {"of_dead": {"from": {"event": "sparks.death"}, "count": 1}},
}


@pytest.mark.parametrize(
    "changes",
    [
        {"systems.children": CHILDREN},
        {"systems.sparks.interactions": {"contacts": {}}, "systems.sparks.integrator": "semi_implicit_euler"},
        {"systems.sparks.emitters.forever": {"count": 1, "lifetime": 1000}},
    ],
)
def test_births_that_something_depends_on_are_made(changes):
    """Mutants: parents or systems with interactions lack births; the shortest lifetime decides."""
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
