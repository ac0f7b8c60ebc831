"""The heat bath: normal velocities at its temperature, for any step; memory, spreading, equipartition, the ledger, bits."""

import math

import numpy as np
import pytest

import gen_art as ga

Langevin = ga.forces.Langevin
N = 8_000


def simulated(
    dt, *, n=N, integrator="leapfrog", precision="f64", ledger=False, forces=(), mass=1.0, seed=0, velocity=None, **bath
):
    bath = {"temperature": 2.0, "friction": 1.5, "boltzmann": 1.0, **bath}
    system = ga.ParticleSystem(
        position=np.zeros((n, 3)), velocity=velocity, mass=mass, integrator=integrator,
        forces=[Langevin(**bath), *forces],
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=dt, precision=precision, seed=seed, ledger=ledger)


def moments(v, variance):
    """(variance, skewness, kurtosis) of all components, each in standard errors from a normal distribution's."""
    x = v.ravel().astype(float) / math.sqrt(variance)
    n = len(x)
    return (
        (x.var() - 1) / math.sqrt(2 / n), (x**3).mean() / math.sqrt(15 / n), ((x**4).mean() - 3) / math.sqrt(96 / n)
    )  # fmt: skip


@pytest.mark.parametrize("integrator", ["leapfrog", "position_verlet", "semi_implicit_euler", "boris"])
@pytest.mark.parametrize("dt", [0.01, 0.5, 20.0])
def test_velocities_are_maxwells_whatever_the_step(integrator, dt):
    """Variance kT / m, skewness 0, kurtosis 3, to 4.5 standard errors; a bath an eighth hotter is found out."""
    sim = simulated(dt, integrator=integrator, mass=0.5)
    sim.step(max(1, round(12 / dt)))
    v = sim["s"].velocity
    assert np.abs(moments(v, 4.0)).max() < 4.5
    assert np.abs(moments(v, 4.5)).max() > 4.5
    assert np.abs(v.mean(0)).max() < 4.5 * 2 / math.sqrt(N)


def test_a_random_driver_is_no_bath():
    """The reason for langevin: eight waves and a damping leave a kurtosis far from 3."""
    driver = ga.forces.RandomDriver(strength=1.0, correlation_time=0.02)
    system = ga.ParticleSystem(position=np.zeros((2000, 3)), forces=[driver, ga.forces.Damping(1.0)])
    sim = ga.Simulation({"s": system}, dt=0.005, precision="f64")
    sim.step(1600)
    x = sim["s"].velocity.ravel()
    assert (x**4).mean() / (x**2).mean() ** 2 > 5


def test_memory_and_spreading():
    """<v(0) v(t)> = kT/m e^(-friction t); <x^2> = 2 kT / (m friction) (t - (1 - e^(-friction t)) / friction), from a thermal start."""
    r = np.random.default_rng(3)
    start = r.normal(size=(N, 3)) * math.sqrt(2.0)
    t, friction = 0.8, 1.5
    sim = simulated(0.02, velocity=start)
    sim.step(round(t / 0.02))
    v, x = sim["s"].velocity, sim["s"].position
    memory, error = (v * start).mean(), 2.0 * math.sqrt(2 / (3 * N))
    assert abs(memory - 2.0 * math.exp(-friction * t)) < 4.5 * error
    assert abs(memory - 2.0 * math.exp(-0.9 * friction * t)) > 4.5 * error  # the mutant: another friction
    spread = 2 * 2.0 / friction * (t - (1 - math.exp(-friction * t)) / friction)
    assert (x**2).mean() == pytest.approx(spread, rel=4.5 * math.sqrt(2 / (3 * N)) + (friction * 0.02) ** 2 / 12)


def test_equipartition_in_a_spring():
    """1/2 k <x^2> = 1/2 kT, to order 2 in the step."""
    sim = simulated(0.05, forces=[ga.forces.Spring(stiffness=3.0)])
    sim.step(400)
    assert (sim["s"].position ** 2).mean() * 3.0 == pytest.approx(
        2.0, rel=4.5 * math.sqrt(2 / (3 * N)) + 3.0 * 0.05**2 / 4
    )
    assert np.abs(moments(sim["s"].position, 2.0 / 3.0)[1:]).max() < 4.5


def test_components_particles_and_steps_are_independent():
    sim = simulated(1.0, n=5000, friction=30.0)  # after one step nothing is left of the velocities before
    steps = []
    for _ in range(4):
        sim.step(1)
        steps.append(sim["s"].velocity.copy())
    columns = np.array([v[:, c] for v in steps for c in range(3)])
    correlations = np.corrcoef(columns) - np.eye(12)
    assert np.abs(correlations).max() < 5 / math.sqrt(5000)
    neighbours = np.corrcoef(steps[0][:-1, 0], steps[0][1:, 0])[0, 1]
    assert abs(neighbours) < 5 / math.sqrt(5000)
    other = simulated(1.0, n=5000, friction=30.0, seed=1)
    other.step(1)
    assert abs(np.corrcoef(other["s"].velocity[:, 0], steps[0][:, 0])[0, 1]) < 5 / math.sqrt(5000)


def test_the_ledger_closes():
    """Heat in as work, heat out as dissipated; the same noise with and without a ledger."""
    sim, plain = (simulated(0.05, n=300, ledger=on) for on in (True, False))
    sim.step(100)
    plain.step(100)
    assert sim.digest() == plain.digest()
    account = sim.ledger()
    assert account.work["s.langevin"] > 100 and account.dissipated["s.langevin"] > 100
    assert abs(account.residual) < 1e-12 * account.scale
    assert np.abs(account.momentum_residual).max() < 1e-9


def test_the_bits_do_not_depend_on_batches_and_nearly_not_on_the_precision():
    whole, parts, single = simulated(0.1, n=100), simulated(0.1, n=100), simulated(0.1, n=100, precision="f32")
    whole.step(50)
    for k in (1, 7, 42):
        parts.step(k)
    single.step(50)
    assert whole.digest() == parts.digest()
    # 50 steps with errors of float32's logarithm and cosine, some eps of 2 m/s, and of 24 bits that both have
    assert np.abs(whole["s"].velocity - single["s"].velocity).max() < 50 * 20 * 2**-23 * 2


def test_what_a_bath_refuses():
    for integrator in ("rk4", "yoshida4"):
        with pytest.raises(ga.UsageError, match=f"langevin adds noise .* use leapfrog, .* not {integrator}"):
            simulated(0.1, n=1, integrator=integrator)
    with pytest.raises(ga.UsageError, match="friction must be above 0"):
        Langevin(friction=0)
    with pytest.raises(ga.UsageError, match="langevin is not relativistic"):
        ga.ParticleSystem(position=[[0, 0, 0]], forces=[Langevin()], integrator="boris", speed_of_light=3e8)
    with pytest.raises(ga.UsageError, match="whose noise is drawn once a step"):
        ga.adaptive(simulated(0.1, n=1), 1.0)


def test_it_is_a_key_of_a_preset():
    preset = ga.load_preset({
        "version": 1, "clock": {"duration": 1, "fps": 10, "step": "1/10"},
        "systems": {"dust": {
            "integrator": "leapfrog", "forces": {"langevin": {"temperature": 1, "friction": 2, "boltzmann": 1}},
            "emitters": {"all": {"count": 100, "shape": {"sphere": 1.0}}},
        }},
    })  # fmt: skip
    sim = ga.Simulation(preset)
    sim.step(10)
    assert sim["dust"].velocity.std() > 0.5
