"""Initial conditions of a galaxy: where the stars are, and how fast, against the formulas they are drawn from."""

import numpy as np
import pytest

import gen_art as ga

N = 20_000


def born(emitter, values):
    preset = ga.load_preset(
        {
            "version": 1,
            "units": {"G": 4.30091e-6},
            "clock": {"duration": 1, "fps": 10, "step": 0.1},
            "systems": {"s": {"emitters": {"e": {"count": N, emitter: values}}}},
        }
    )
    return ga.Simulation(preset, precision="f64")["s"]


def deviation(values, cumulative):
    """Kolmogorov-Smirnov's D sqrt(n): 1.95 is passed by chance once in a thousand."""
    expected = cumulative(np.sort(values))
    k = np.arange(len(values))
    return np.sqrt(len(values)) * max(
        np.abs(expected - k / len(values)).max(), np.abs((k + 1) / len(values) - expected).max()
    )


def test_hernquist_sphere():
    stars, a, edge = born("hernquist_sphere", {}), 0.5, 20.0
    r = np.linalg.norm(stars.position, axis=1)
    inside = (edge / (1 + edge)) ** 2
    assert deviation(r, lambda x: (x / (x + a)) ** 2 / inside) < 1.95
    assert deviation(r, lambda x: (x / (x + 1.05 * a)) ** 2 / inside) > 1.95  # the mutant: another scale
    assert stars.mass.sum() == pytest.approx(inside * 1e10, rel=1e-12)
    directions = stars.position / r[:, None]
    assert np.abs(directions.mean(0)).max() < 4 / np.sqrt(3 * N)
    # isotropic: as fast towards the centre as in either direction across
    radial = (stars.velocity * directions).sum(1)
    across = (stars.velocity**2).sum(1) - radial**2
    assert 2 * (radial**2).mean() == pytest.approx(across.mean(), rel=0.05)


def test_exponential_disc():
    values = {"toomre_q": 0.2, "thickness": 0.3}
    stars, scale, edge = born("exponential_disc", values), 3.0, 6.0
    x, v = stars.position, stars.velocity
    R = np.hypot(x[:, 0], x[:, 2])
    inside = 1 - (1 + edge) * np.exp(-edge)
    assert deviation(R, lambda y: (1 - (1 + y / scale) * np.exp(-y / scale)) / inside) < 1.95
    assert deviation(x[:, 1], lambda z: 0.5 * (1 + np.tanh(z / 0.3))) < 1.95
    assert stars.mass.sum() == pytest.approx(inside * 4e10, rel=1e-6)
    # turns about +y at nearly the circular speed of the three parts: Q is small
    turning = (x[:, 2] * v[:, 0] - x[:, 0] * v[:, 2]) / R
    ring = np.abs(R - 8) < 0.3
    assert turning[ring].mean() == pytest.approx(224, rel=0.02)
    assert np.abs(((x[:, 0] * v[:, 0] + x[:, 2] * v[:, 2]) / R)[ring].mean()) < 2


def test_massless_discs_have_no_mass():
    assert (born("exponential_disc", {"massless": True}).mass == 0).all()
