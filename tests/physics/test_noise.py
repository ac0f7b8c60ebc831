"""Curl noise: divergence-free, of unit strength, continuous in space and time."""

import numpy as np
import pytest

import gen_art as ga
from tests.physics.probe import probe, states


def velocity(x, time=0.3, precision="f64", **parameters):
    p = states(x.shape[1])
    p.position, p.time = x, time
    return probe(
        ga.forces.CurlNoise(**{"strength": 1.0, "scale": 1.0, "speed": 0.5, "octaves": 1, **parameters}), p, precision
    )[0]


def gradient(x, h=1e-5, **parameters):
    out = np.zeros((3, 3, x.shape[1]))
    for c in range(3):
        step = np.zeros((3, 1))
        step[c] = h
        rise = velocity(x + step, **parameters).astype(float) - velocity(x - step, **parameters)
        out[c] = rise / (2 * h)
    return out


@pytest.mark.parametrize("precision,h,tolerance", [("f64", 1e-5, 1e-6), ("f32", 2.0**-10, 2e-4)])
@pytest.mark.parametrize("octaves", [1, 3])
def test_divergence_is_nil(octaves, precision, h, tolerance):
    """By central differences. In float32, between places that it holds exactly, they round to 3 eps u / h = 2e-4, u = 1."""
    x = np.random.default_rng(0).uniform(-50, 50, (3, 2000))
    x = np.round(x / h) * h
    g = gradient(x, h, octaves=octaves, precision=precision)
    size = np.sqrt((g**2).sum((0, 1)).mean())
    assert np.abs(np.trace(g)).max() <= tolerance * size
    g[0, 0] *= 1.01  # the mutant: one slope one per cent off
    assert np.abs(np.trace(g)).max() > 1e-3 * size


def test_strength_is_the_root_mean_square():
    x = np.random.default_rng(1).uniform(-500, 500, (3, 1 << 17))
    for time in (0.0, 0.7, 1.0, 11.3):
        u = velocity(x, time)
        assert np.sqrt((u**2).sum(0).mean()) == pytest.approx(1.0, rel=0.01)
        assert np.abs(u.mean(1)).max() < 0.02
    octaves = velocity(x, octaves=3, gain=0.5)
    assert np.sqrt((octaves**2).sum(0).mean()) == pytest.approx(np.sqrt(1 + 0.25 + 0.0625), rel=0.02)


def test_it_is_continuous_in_time_across_ticks():
    x = np.random.default_rng(2).uniform(-50, 50, (3, 500))
    before, after = velocity(x, 2.0 - 1e-9, speed=1.0), velocity(x, 2.0 + 1e-9, speed=1.0)
    assert np.abs(after - before).max() < 1e-6
    assert np.abs(velocity(x, 3.0, speed=1.0) - before).max() > 0.5


def test_drift_carries_the_pattern_along():
    x = np.random.default_rng(3).uniform(-5, 5, (3, 100))
    moved = x + np.array([[1.0], [2.0], [0.0]]) * 0.3
    still = velocity(x, 0.0, speed=0.0)
    assert np.allclose(velocity(moved, 0.3, speed=0.0, drift=(1.0, 2.0, 0.0)), still, atol=1e-9)
