"""The long proofs: the galaxy over its whole piece, a Plummer sphere in equilibrium, an orbit over ten thousand periods."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.preset.load import load_preset


def galaxy(disc, bulge, precision, steps):
    """The bodies of the galaxy preset in its halo (the massless grains do not act on them), and the ledger."""
    plain = load_preset("galaxy").resolved()
    plain["systems"] = {"bodies": plain["systems"]["bodies"]}
    plain["systems"]["bodies"]["emitters"]["disc"]["count"] = disc
    plain["systems"]["bodies"]["emitters"]["bulge"]["count"] = bulge
    sim = ga.Simulation(load_preset(plain), precision=precision, ledger=True)
    start = sim.diagnostics()
    worst = 0.0
    for _ in range(0, steps, 20):
        sim.step(20)
        worst = max(worst, abs(sim.diagnostics().energy / start.energy - 1))
    return sim, start, worst


def momentum_is_the_halos_impulse(sim, start, eps):
    account, end = sim.ledger(), sim.diagnostics()
    moved = sim["bodies"].mass @ np.abs(sim["bodies"].velocity)
    change = end.momentum - start.momentum
    assert np.abs(change - account.impulse["bodies.hernquist"]).max() <= 100 * eps * moved.max()
    assert np.abs(account.impulse["bodies.self_gravity"]).max() <= 100 * eps * moved.max()
    return change


def test_a_small_galaxy_keeps_its_account():
    sim, start, worst = galaxy(600, 200, "f64", 80)
    assert worst < 1e-3
    momentum_is_the_halos_impulse(sim, start, np.finfo(float).eps)


@pytest.mark.proof
def test_the_whole_galaxy_keeps_its_energy_over_the_piece():
    """16,000 bodies, preroll and six film seconds, in float32 as it is rendered: energy within 1e-3, halo included."""
    clock = load_preset("galaxy").clock
    sim, start, worst = galaxy(12000, 4000, "f32", clock.preroll_steps + clock.frames * clock.steps_per_frame)
    assert worst < 1e-3
    momentum_is_the_halos_impulse(sim, start, np.finfo(np.float32).eps)
    # it holds together: half of the mass stays inside the half-mass radius it began with, within a tenth
    r = np.linalg.norm(sim["bodies"].position, axis=1)
    fresh = ga.Simulation(sim.preset)
    r0 = np.linalg.norm(fresh["bodies"].position, axis=1)
    assert np.median(r) == pytest.approx(np.median(r0), rel=0.1)


def plummer(n, seed=1):
    """A Plummer sphere in standard units (G = M = 1, a = 1), velocities from its distribution function."""
    r = np.random.default_rng(seed)
    radius = (r.uniform(size=n) ** (-2 / 3) - 1) ** -0.5
    q = []
    while len(q) < n:
        x, y = r.uniform(size=4 * n), r.uniform(size=4 * n) * 0.1
        q += list(x[y < x * x * (1 - x * x) ** 3.5])
    speed = np.array(q[:n]) * np.sqrt(2) * (1 + radius**2) ** -0.25

    def directions():
        d = r.normal(size=(n, 3))
        return d / np.linalg.norm(d, axis=1)[:, None]

    x, v = radius[:, None] * directions(), speed[:, None] * directions()
    return x - x.mean(0), v - v.mean(0)


@pytest.mark.proof
def test_plummer_sphere_stays_in_equilibrium():
    """2T/|W| = 1 within 2%, W = sum m x.a; 10, 50 and 90% radii steady within 3% over 10 dynamical times; dE/E < 1e-3."""
    n = 32768
    x, v = plummer(n)
    gravity = ga.interactions.SelfGravity(G=1.0, softening=0.02)
    stars = ga.ParticleSystem(position=x, velocity=v, mass=1 / n, interactions=[gravity])
    sim = ga.Simulation({"stars": stars}, dt=1 / 64)
    start = sim.diagnostics()

    def radii():
        return np.quantile(np.linalg.norm(sim["stars"].position, axis=1), [0.1, 0.5, 0.9])

    def virial():
        sources = np.ascontiguousarray(
            np.concatenate([sim.systems["stars"].floats[:3, :n], np.full((1, n), 1 / n)]).astype("f4")
        )
        a = np.zeros((3, n + 64), "f4")
        gravity.accelerate(sim.systems["stars"].floats, n, sources, a, "f32")
        W = (sim["stars"].position.T * a[:, :n]).sum() / n
        return 2 * sim.diagnostics().kinetic_energy / abs(W)

    before = radii()
    assert virial() == pytest.approx(1, abs=0.02)
    sim.advance(10.0)  # the dynamical time sqrt(a^3 / GM) is 1
    assert virial() == pytest.approx(1, abs=0.02)
    assert np.allclose(radii(), before, rtol=0.03)
    assert sim.diagnostics().energy == pytest.approx(start.energy, rel=1e-3)


@pytest.mark.proof
@pytest.mark.parametrize("integrator", ["leapfrog", "yoshida4"])
def test_symplectic_drift_is_bounded_over_ten_thousand_periods(integrator):
    """Kepler with e = 0.9: the energy error of the last periods is no larger than of the first; rk4's grows."""

    def errors(name, periods, per_period=2000):
        star = ga.ParticleSystem(
            position=[[0.1, 0, 0]],
            velocity=[[0, np.sqrt(1.9 / 0.1), 0]],
            forces=[ga.forces.PointGravity(GM=1.0)],
            integrator=name,
        )
        sim = ga.Simulation({"star": star}, dt=2 * np.pi / per_period, precision="f64")
        found = []
        for first, count in ((0, 20), (periods - 20, 20)):
            sim.step(first * per_period - sim.steps_done)
            worst = 0.0
            for _ in range(count * 40):
                sim.step(per_period // 40)
                worst = max(worst, abs(sim.diagnostics().energy / -0.5 - 1))
            found.append(worst)
        return found

    first, last = errors(integrator, 10_000)
    assert last <= 1.5 * first
    first, last = errors("rk4", 500)  # the mutant: a scheme that is not symplectic drifts
    assert last > 5 * first
