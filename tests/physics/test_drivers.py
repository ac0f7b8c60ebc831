"""Periodic and random driving, and gravity that weakens with height."""

import numpy as np
import pytest

import gen_art as ga
from tests.physics.probe import probe, states

F = ga.forces


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-3), ("f32", 2e-5)])
@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.7])
def test_driven_oscillator_has_its_amplitude_and_phase(ratio, precision, tolerance):
    """x'' + 2 zeta w0 x' + w0^2 x = A/m cos(w t): the steady state lags by atan2(2 zeta r, 1 - r^2), 90 degrees at w0.

    In float32 the driver's phase w t, up to 250 rad, is held to eps 250 = 1.5e-5; the damping forgets all other roundings.
    """
    m, w0, zeta, A = 1.3, 5.0, 0.15, 2.0
    w = ratio * w0
    period = 2 * np.pi / w
    dt = period / 400
    ball = ga.ParticleSystem(
        position=[[0, 0, 0]], mass=m, integrator="rk4",
        forces=[F.Spring(stiffness=m * w0**2), F.Damping(2 * zeta * w0), F.Driver(A, w / (2 * np.pi), 0.0, (1, 0, 0))],
    )  # fmt: skip
    sim = ga.Simulation({"b": ball}, dt=dt, precision=precision)
    sim.step(400 * round(20 / (zeta * w0) / period))
    x = []
    for _ in range(40):
        sim.step(10)
        x.append(float(sim["b"].position[0, 0]) * np.exp(-1j * w * sim.time))
    response = 2 * np.mean(x)
    exact = A / m / (w0**2 - w**2 + 2j * zeta * w0 * w)
    assert abs(response - exact) <= tolerance * abs(exact)
    assert np.angle(exact) == pytest.approx(-np.pi / 2) or ratio != 1.0
    assert abs(response.conjugate() - exact) > 0.1 * abs(exact)  # the mutant: a lead instead of a lag


def noise(times, n=20000, strength=1.4, saved_arrays=0.6, harmonics=8, seed=0):
    """The force (times, 3, n) on n particles, each with its key."""
    p, out = states(n, 5), []
    p.mass[:] = 1.0
    for t in times:
        p.time = t
        out.append(probe(F.RandomDriver(strength, saved_arrays, seed, harmonics), p)[0])
    return np.array(out)


def test_random_driver_has_its_mean_variance_and_memory():
    """Over 20,000 particles: mean 0, <F . F> = strength^2, and the correlation of the formula, from any time on."""
    for t0 in (0.0, 37.3):
        lags = np.array([0.0, 0.2, 0.6, 1.2])
        f = noise(t0 + lags)
        assert np.abs(f.mean((0, 2))).max() <= 0.02
        correlation = (f * f[0]).sum(1).mean(1)
        expected = 1.4**2 * np.exp(-np.pi / 4 * (lags / 0.6) ** 2)
        assert np.abs(correlation - expected).max() <= 0.02 * 1.4**2
        mutant = 1.4**2 * np.exp(-np.pi / 4 * (lags / 0.7) ** 2)  # another memory is told apart
        assert np.abs(correlation - mutant).max() > 0.05 * 1.4**2
        components = np.cov(f[1])
        assert np.allclose(components, np.eye(3) * 1.4**2 / 3, atol=0.02)
        kurtosis = (f[0] ** 4).mean() / (f[0] ** 2).mean() ** 2
        assert kurtosis == pytest.approx(3 - 3 / 16, abs=0.05)  # 8 harmonics: 3 (1 - 1 / (2 harmonics))


def test_another_seed_is_another_force():
    a, b = noise([0.3], 5000), noise([0.3], 5000, seed=1)
    assert abs((a * b).sum(1).mean()) <= 0.05 * 1.4**2


def test_short_memory_makes_particles_diffuse():
    """<v^2> = 2 strength^2 correlation_time t / m^2; and the run is the same at any time step that resolves it."""

    def run(dt):
        dust = ga.ParticleSystem(position=np.zeros((3000, 3)), mass=0.5, forces=[F.RandomDriver(0.8, 0.05)])
        sim = ga.Simulation({"d": dust}, dt=dt, precision="f64", seed=2)
        sim.step(round(1.0 / dt))
        return sim["d"].velocity

    v = run(0.01)
    expected = 2 * 0.8**2 * 0.05 * (1.0 - 2 * 0.05 / np.pi) / 0.25
    assert (v**2).sum(1).mean() == pytest.approx(expected, rel=0.12)  # few slow harmonics carry most of it
    assert np.abs(run(0.005) - v).max() <= 0.02 * np.abs(v).max()


@pytest.mark.parametrize("ground", ["flat", "globe"])
def test_throw_reaches_the_height_of_energy(ground):
    """v^2 / 2 = g R h / (R + h); straight up both grounds agree."""
    g, R, v = 9.81, 3.0, 6.0
    top = v * v * R / (2 * g * R - v * v)
    force = F.HeightGravity(g, R, (0, 1.0, 0), (0, 2.0, 0), ground)
    ball = ga.ParticleSystem(position=[[0, 1.0, 0]], velocity=[[0, v, 0]], forces=[force])
    sim = ga.Simulation({"b": ball}, dt=0.001, precision="f64")
    heights = []
    for _ in range(300):
        sim.step(10)
        heights.append(sim["b"].position[0, 1])
    assert max(heights) - 1.0 == pytest.approx(top, rel=1e-4)
    assert v * v / (2 * g) < 0.7 * top  # a uniform field would stop it far below


def test_globe_is_a_point_mass_outside_and_linear_inside():
    p = states()
    center = np.array((0.2, -0.1, 0.0))
    globe = F.HeightGravity(2.0, 1.1, tuple(center + (0, 1.1, 0)), (0, 1, 0), "globe")
    found, _, _, U = probe(globe, p)
    outside = np.linalg.norm(p.position - center[:, None], axis=0) > 1.1
    point, _, _, V = probe(F.PointGravity(tuple(center), 2.0 * 1.1**2), p)
    assert 5 < outside.sum() < 60
    assert np.allclose(found[:, outside], point[:, outside], rtol=1e-12)
    assert np.allclose(U[outside], V[outside], rtol=1e-12)
    assert np.allclose(found[:, ~outside], -2.0 / 1.1 * (p.position - center[:, None])[:, ~outside], atol=1e-12)
    h, push = 1e-5, found * p.mass
    for c in range(3):
        plus, minus = states(), states()
        plus.position[c] += h
        minus.position[c] -= h
        slope = (probe(globe, plus)[3] - probe(globe, minus)[3]) / (2 * h)
        assert np.abs(push[c] + slope).max() <= 1e-6 * np.abs(push).max()


def test_null_directions_are_sentences():
    for make in (lambda: F.Driver(direction=(0, 0, 0)), lambda: F.HeightGravity(up=(0, 0, 0))):
        with pytest.raises(ga.UsageError, match="null vector"):
            make()
