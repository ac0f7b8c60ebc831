"""Colliders whose impacts give birth: `action: emit` and `from: SYSTEM.impact`."""

import numpy as np
import pytest

import gen_art as ga

G, R = 9.81, 0.01


def rain(count=1, restitution=0.6, action="emit", height=1.0, **more):
    return ga.load_preset({
        "version": 1, "clock": {"duration": 4, "fps": 20, "step": 0.01},
        "forces": {"gravity": [0, -G, 0]},
        "systems": {
            "drops": {
                "colliders": {"plane": {"normal": [0, 1, 0], "restitution": restitution, "action": action}},
                "emitters": {"cloud": {"count": count, "shape": {"point": [0, height + R, 0]}, "velocity": [1, 0, 0]}},
            },
            "splash": {
                "emitters": {"crown": {"from": "drops.impact", "count": 3, "velocity": {"cone": [0, 1, 0], "speed": 2}, **more}},
            },
        },
    })  # fmt: skip


@pytest.mark.parametrize("precision,tolerance", [("f64", 2e-3), ("f32", 2e-3)])
def test_each_impact_gives_birth_where_and_when_it_happens(precision, tolerance):
    e = 0.6
    sim = ga.Simulation(rain(), precision=precision)
    sim.step(400)
    # flights of theory: the first of sqrt(2 h / g), then 2 e^k times it, until a hop ends within a step
    first = np.sqrt(2 / G)
    impacts = first + np.concatenate([[0], np.cumsum(2 * first * e ** np.arange(1, 12))])
    hops = 2 * first * e ** np.arange(1, 12)
    expected = impacts[: 1 + int((hops > 2 * 0.01).sum())]
    births = np.unique(np.round(sim.time - sim["splash"].age, 5))
    assert abs(len(births) - len(expected)) <= 1  # the last hop is as long as a step
    m = min(len(births), len(expected)) - 1
    assert np.allclose(births[:m], expected[:m], atol=1e-4)
    assert sim["splash"].count == 3 * len(births)
    assert not np.allclose(births[:m] + 0.01, expected[:m], atol=1e-4)  # the mutant: at the end of the step
    sim.step(200)
    assert sim["splash"].count == 3 * len(births)  # what lies on the ground strikes no more


def test_children_start_on_the_surface_and_take_the_velocity_after_the_bounce():
    sim = ga.Simulation(
        rain(**{"from": {"event": "drops.impact", "inherit": "velocity"}, "velocity": [0, 0, 0]}), precision="f64"
    )
    t = np.sqrt(2 / G)
    steps = int(t / 0.01) + 1
    sim.step(steps)
    age = sim.time - t
    v = 0.6 * np.sqrt(2 * G)
    assert sim["splash"].count == 3
    assert np.allclose(sim["splash"].age, age, atol=1e-9)
    assert np.allclose(sim["splash"].position, [t + age, R + v * age - G * age**2 / 2, 0], atol=3 * G * 0.01**2)


def test_a_bounce_tells_nothing_unless_asked_and_impacts_need_someone_who_tells():
    with pytest.raises(ga.PresetError, match="no collider of 'drops' has action: emit"):
        ga.Simulation(rain(action="bounce"))
    loud, still = rain(count=20), rain(count=20)
    a, b = ga.Simulation(loud, ledger=True), ga.Simulation(still)
    a.step(100)
    b.step(100)
    assert a.digest() == b.digest()  # the ledger leaves the bits alone


def test_a_frame_does_not_depend_on_what_was_seen_before(tmp_path):
    a, b = ga.Simulation(rain(count=30)), ga.Simulation(rain(count=30))
    a.step(120)
    for _ in range(3):
        b.step(20)
    b.save(tmp_path / "s.gas")
    c = ga.Simulation.restore(tmp_path / "s.gas")
    c.step(60)
    assert a.digest() == c.digest()
