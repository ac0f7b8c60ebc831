"""Colliders that turn about a pivot, and colliders whose impacts give birth."""

import numpy as np
import pytest

import gen_art as ga

from .test_colliders import FALL, FLOOR, C, G, R, closes, simulation


def test_what_sticks_to_a_turning_ball_goes_round_with_it():
    w = 2.0
    ball = C.Sphere((0, 0, 0), 1.0, action="stick", angular_velocity=(0, 0, w), pivot=(0, 0, 0), velocity=(0.5, 0, 0))
    sim = simulation([[0, 1.5, 0]], [[0, -5, 0]], [ball], forces=[], dt=0.01)
    sim.step(200)
    at, arm = np.array([0.5 * sim.time, 0, 0]), sim["s"].position[0] - [0.5 * sim.time, 0, 0]
    assert np.linalg.norm(arm) == pytest.approx(1 + R, rel=1e-9)
    assert np.allclose(sim["s"].velocity[0], np.cross([0, 0, w], arm) + [0.5, 0, 0], atol=1e-9)
    # it met the ball at some place and time, and its angle has grown by w since: two moments differ by w t
    before = np.arctan2(arm[1], arm[0])
    sim.step(50)
    after = sim["s"].position[0] - [0.5 * sim.time, 0, 0]
    assert (np.arctan2(after[1], after[0]) - before) % (2 * np.pi) == pytest.approx(w * 0.5, rel=1e-9)  # mutant: -w
    assert at[0] < 0.5 * sim.time
    closes(sim, 1e-10)


def test_friction_carries_what_lies_on_a_turntable_and_lets_go_of_what_lies_too_far_out():
    w, mu = 2.0, 0.5
    table = C.Plane(**FLOOR, friction=mu, angular_velocity=(0, w, 0))
    edge = mu * G / w**2  # where w^2 r is all that friction gives
    x = np.array([[0.5 * edge, R, 0], [1.5 * edge, R, 0]])
    sim = simulation(x, np.cross([0, w, 0], x), [table], dt=0.002)
    sim.step(1000)
    r = np.hypot(sim["s"].position[:, 0], sim["s"].position[:, 2])
    assert r[0] == pytest.approx(0.5 * edge, rel=2e-3)
    assert r[1] > 1.6 * edge
    angle = np.arctan2(-sim["s"].position[0, 2], sim["s"].position[0, 0])
    assert (angle - w * sim.time + np.pi) % (2 * np.pi) - np.pi == pytest.approx(0, abs=0.02)
    closes(sim, 1e-10)


@pytest.mark.parametrize("precision,tolerance", [("f64", 2e-4), ("f32", 2e-3)])
def test_a_turning_paddle_strikes_at_the_speed_it_has_there(precision, tolerance):
    w = 3.0
    paddle = C.Block((-1, -0.05, -1), (1, 0.05, 1), restitution=1.0, angular_velocity=(0, 0, w))
    sim = simulation([[0.5, 0.3, 0]], None, [paddle], forces=[], dt=1e-3, precision=precision)
    sim.step(400)
    v, start = sim["s"].velocity[0], np.array([0.5, 0.3, 0])
    # the upper face reaches it where the distance from the turning middle plane is its radius and half the thickness
    reach = np.hypot(0.5, 0.3)
    angle = np.arctan2(0.3, 0.5) - np.arcsin((0.05 + R) / reach)
    normal = np.array([-np.sin(angle), np.cos(angle), 0])
    struck = 2 * np.cross([0, 0, w], start).dot(normal) * normal
    assert np.allclose(v, struck, rtol=tolerance, atol=tolerance)
    assert not np.allclose(v, 0.5 * struck, rtol=0.1)  # the mutant: inelastic
    account = closes(sim, 1e-10 if precision == "f64" else 1e-5)
    assert account.work["s.block"] == pytest.approx(0.5 * struck.dot(struck), rel=10 * tolerance)


def test_nothing_passes_through_a_fast_blade():
    r = np.random.default_rng(1)
    x = np.stack([r.uniform(0.2, 0.9, 300), r.uniform(0.05, 0.9, 300), np.zeros(300)], 1)
    x = x[np.linalg.norm(x, axis=1) < 0.95]
    blade = C.Block((-1, -0.01, -1), (1, 0.01, 1), restitution=0.5, angular_velocity=(0, 0, 40.0))
    sim = simulation(x, None, [blade], forces=[], dt=0.02, ledger=False)
    sim.step(2)  # 1.6 rad: it has swept over all of them
    assert (np.linalg.norm(sim["s"].velocity, axis=1) > 1).all()


def test_a_wall_that_does_not_turn_keeps_its_bits():
    x = np.random.default_rng(0).uniform(-0.4, 0.4, (64, 3))
    still = [C.Box((-1, -1, -1), (1, 1, 1), restitution=0.5)]
    turns = [C.Box((-1, -1, -1), (1, 1, 1), restitution=0.5, angular_velocity=(0, 0, 1e-30))]
    runs = []
    for walls in (still, turns):
        sim = simulation(x, None, walls, forces=FALL, dt=0.02, ledger=False)
        sim.step(80)
        runs.append(sim["s"].position)
    assert np.allclose(*runs, atol=1e-9)


def test_turning_colliders_from_a_preset_and_back_from_a_snapshot(tmp_path):
    preset = ga.load_preset({
        "version": 1, "clock": {"duration": 1, "fps": 20, "step": 0.01}, "forces": {"gravity": [0, -9.81, 0]},
        "colliders": {"box": {"min": [-1, -1, -1], "max": [1, 1, 1], "angular_velocity": [0, 0, 60], "pivot": [0, 0, 0]}},
        "systems": {"a": {"emitters": {"e": {"count": 50, "shape": {"ball": 0.3}}}}},
    })  # fmt: skip
    sim = ga.Simulation(preset)
    assert sim["a"].composition.colliders[0].force.values["angular_velocity"][2] == pytest.approx(60)
    sim.step(50)
    sim.save(tmp_path / "s.gas")
    again = ga.Simulation.restore(tmp_path / "s.gas")
    sim.step(20)
    again.step(20)
    assert sim.digest() == again.digest()
