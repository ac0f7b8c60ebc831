"""Mutual gravity: against NumPy, its sum, its energy, and systems that act on others."""

import numpy as np
import pytest

import gen_art as ga

G = ga.interactions.SelfGravity


def reference(x, m, soft, g):
    d = x[None] - x[:, None]
    s = (d**2).sum(2) + soft**2
    np.fill_diagonal(s, 1.0)
    w = g * m[None] / s**1.5
    np.fill_diagonal(w, 0.0)
    energy = -0.5 * g * (m[None] * m[:, None] / np.sqrt(s) * (1 - np.eye(len(m)))).sum()
    return (w[..., None] * d).sum(1), energy


def cloud(n=300, seed=0):
    r = np.random.default_rng(seed)
    return r.normal(size=(n, 3)), r.normal(size=(n, 3)) * 0.3, r.uniform(0.5, 2, n) / n


@pytest.mark.parametrize("soft", [0.0, 0.05])
@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-12), ("f32", 2e-5)])
def test_acceleration_and_energy(soft, precision, tolerance):
    x, _, m = cloud()
    a, energy = reference(x, m, soft, 1.7)
    h = 1e-6 if precision == "f64" else 1e-3
    sim = ga.Simulation(
        {"s": ga.ParticleSystem(position=x, mass=m, interactions=[G(G=1.7, softening=soft)], integrator="semi_implicit_euler")},
        dt=h, precision=precision,
    )  # fmt: skip
    assert sim.diagnostics().potential_energy == pytest.approx(energy, rel=tolerance)
    sim.step(1)
    found = sim["s"].velocity / h
    assert np.abs(found - a).max() <= tolerance * np.abs(a).max() + 1e-12
    assert np.abs(-found - a).max() > 0.1 * np.abs(a).max()
    force = (m[:, None] * found).sum(0)
    eps = np.finfo(np.float64 if precision == "f64" else np.float32).eps
    assert np.abs(force).max() <= 4 * eps * np.abs(m[:, None] * found).sum()


@pytest.mark.parametrize("integrator", ["leapfrog", "rk4", "yoshida4", "position_verlet"])
def test_two_bodies_keep_their_orbit(integrator):
    """Masses 1 and 3 at distance 1, G = 1: period 2 pi / sqrt(4), about a fixed centre of mass."""
    v = np.sqrt(4.0)
    pair = ga.ParticleSystem(
        position=[[0.75, 0, 0], [-0.25, 0, 0]], velocity=[[0, 0.75 * v, 0], [0, -0.25 * v, 0]], mass=[1, 3],
        interactions=[G(G=1.0)], integrator=integrator,
    )  # fmt: skip
    period = 2 * np.pi / 2.0
    sim = ga.Simulation({"s": pair}, dt=period / 2000, precision="f64")
    start = sim.diagnostics()
    sim.step(2000)
    assert np.abs(sim["s"].position - [[0.75, 0, 0], [-0.25, 0, 0]]).max() < 1e-4
    end = sim.diagnostics()
    assert end.energy == pytest.approx(start.energy, rel=1e-6)
    assert np.abs(end.momentum).max() < 2000 * 4 * np.finfo(float).eps
    assert np.allclose(end.angular_momentum, start.angular_momentum, atol=1e-10)


def test_escape_speed():
    """Thrown at the escape speed from a point mass the total energy is zero and the speed falls as sqrt(2 GM / r)."""
    ball = ga.ParticleSystem(
        position=[[1, 0, 0]],
        velocity=[[np.sqrt(2 * 3.0), 0, 0]],
        forces=[ga.forces.PointGravity(GM=3.0)],
        integrator="rk4",
    )
    sim = ga.Simulation({"b": ball}, dt=0.001, precision="f64")
    sim.step(20000)
    r = sim["b"].position[0, 0]
    assert r == pytest.approx((1 + 1.5 * np.sqrt(6.0) * 20) ** (2 / 3), rel=1e-6)
    assert sim["b"].velocity[0, 0] == pytest.approx(np.sqrt(6.0 / r), rel=1e-4)


def test_orbits_at_all_heights_keep_keplers_third_law():
    """T = 2 pi sqrt(a^3 / GM), on circles and on ellipses started at either end: half a turn later each stands opposite."""
    heights = [1.0, 1.7, 2.5]
    for e in (0.0, 0.4, -0.4):
        emitters = {
            f"at{k}": {"count": 1, "shape": {"point": [r, 0, 0]}, "velocity": {"orbit": 4, "eccentricity": e}}
            for k, r in enumerate(heights)
        }
        sim = ga.Simulation(ga.load_preset({
            "version": 1, "clock": {"duration": 8, "fps": 1000, "step": 0.001}, "forces": {"point_gravity": {"GM": 4}},
            "systems": {"s": {"integrator": "yoshida4", "emitters": emitters}},
        }), precision="f64")  # fmt: skip
        start = sim["s"].position[:, 0]
        assert sorted(start) == pytest.approx(heights)
        for k in np.argsort(start):  # the quickest first
            a = start[k] / (1 - e)
            half = np.pi * np.sqrt(a**3 / 4)
            steps = round((half - sim.time) / 0.001)
            sim.step(steps)
            s = sim["s"]
            x, v = s.position[k], s.velocity[k]
            there = x + v * (half - sim.time)  # less than half a step on
            assert np.allclose(there, [-a * (1 + e), 0, 0], atol=2e-5)
            later = x + v * (1.01 * half - sim.time)  # the mutant: a period 1% off
            assert np.linalg.norm(later - [-a * (1 + e), 0, 0]) > 1e-3


@pytest.mark.parametrize("exponent", [1, 0, -1, -2])
def test_nearly_circular_orbits_in_power_laws_breathe_in_their_time(exponent):
    """a = -k r^n: a circle at v^2 = k r^(n+1), and about it r goes in and out at sqrt(3 + n) of the frequency of the turn."""
    k, r, e = 2.0, 1.3, 1e-3
    v = np.sqrt(k * r ** (exponent + 1))
    period = 2 * np.pi * r / v / np.sqrt(3 + exponent)
    grain = ga.ParticleSystem(
        position=[[r, 0, 0], [r * (1 + e), 0, 0]], velocity=[[0, v, 0], [0, v / (1 + e), 0]],
        forces=[ga.forces.CentralForce(strength=k, exponent=exponent)], integrator="yoshida4",
    )  # fmt: skip
    sim = ga.Simulation({"s": grain}, dt=period / 800, precision="f64")
    breath = []  # of the second, whose angular momentum is that of the circle
    for _ in range(10):
        sim.step(80)
        distance = np.linalg.norm(sim["s"].position, axis=1) / r - 1
        assert abs(distance[0]) < 1e-4
        breath.append(distance[1])
    turn = 2 * np.pi * np.arange(1, 11) / 10
    assert np.abs(np.array(breath) / e - np.cos(turn)).max() < 0.02
    assert (
        np.abs(np.array(breath) / e - np.cos(turn * np.sqrt((2.9 + exponent) / (3 + exponent)))).max() > 0.04
    )  # mutant


def test_sources_act_without_reaction():
    x, v, m = cloud(50)
    alone = ga.Simulation(
        {"stars": ga.ParticleSystem(position=x, velocity=v, mass=m, interactions=[G(G=1.0, softening=0.1)])},
        dt=0.01,
        precision="f64",
    )
    probes = np.random.default_rng(3).normal(size=(40, 3)) * 2
    both = ga.Simulation(
        {
            "dust": ga.ParticleSystem(position=probes, mass=0.0, interactions=[G(G=1.0, softening=0.1, sources="stars")]),
            "stars": ga.ParticleSystem(position=x, velocity=v, mass=m, interactions=[G(G=1.0, softening=0.1)]),
        },
        dt=0.01, precision="f64",
    )  # fmt: skip
    alone.step(20)
    both.step(20)
    assert np.array_equal(alone["stars"].position, both["stars"].position)
    # the dust follows the field of the moving stars: the same as massless members of the group
    group = ga.ParticleSystem(
        position=np.concatenate([x, probes]), velocity=np.concatenate([v, 0 * probes]),
        mass=np.concatenate([m, np.zeros(40)]), interactions=[G(G=1.0, softening=0.1)],
    )  # fmt: skip
    sim = ga.Simulation({"all": group}, dt=0.01, precision="f64")
    sim.step(20)
    assert np.allclose(sim["all"].position[50:], both["dust"].position, atol=1e-13)


def test_joined_systems_need_one_integrator():
    x, _, _ = cloud(5)
    with pytest.raises(ga.UsageError, match="same integrator"):
        ga.Simulation(
            {
                "a": ga.ParticleSystem(position=x, interactions=[G(sources="b")], integrator="rk4"),
                "b": ga.ParticleSystem(position=x, integrator="leapfrog"),
            },
            dt=0.01,
        )
    with pytest.raises(ga.UsageError, match="did you mean 'b'"):
        ga.Simulation(
            {"a": ga.ParticleSystem(position=x, interactions=[G(sources="bb")]), "b": ga.ParticleSystem(position=x)},
            dt=0.01,
        )


def test_freeman_and_hernquist_circular_speeds():
    """The galaxy of the preset turns at 224 km/s at 8 kpc; the disc alone has Freeman's curve with its peak at 2.15 scales."""
    disc = ga.emitters.galaxies.ExponentialDisc()
    R = np.linspace(0.1, 20, 4000)
    speed = np.sqrt(disc.circular_speed_squared(R))
    assert np.interp(8.0, R, speed) == pytest.approx(224, rel=0.01)
    alone = ga.emitters.galaxies.ExponentialDisc(bulge_mass=0.0, halo_mass=0.0)
    assert R[np.argmax(alone.circular_speed_squared(R))] == pytest.approx(2.15 * 3, rel=0.01)


def test_bessel_products():
    """Against their integral: I0 K0 - I1 K1 at y, from the standard integral representations."""
    from gen_art.emitters.galaxies import bessel_products

    t = np.linspace(0, 20, 400001)
    for y in (0.01, 0.3, 1.0, 1.9, 2.1, 3.7, 3.8, 6.0):
        with np.errstate(over="ignore"):
            k0 = np.trapezoid(np.exp(-y * np.cosh(t)), t)
            k1 = np.trapezoid(np.exp(-y * np.cosh(t)) * np.cosh(t), t)
        a = np.linspace(0, np.pi, 20001)
        i0, i1 = (
            np.trapezoid(np.exp(y * np.cos(a)), a) / np.pi,
            np.trapezoid(np.exp(y * np.cos(a)) * np.cos(a), a) / np.pi,
        )
        assert bessel_products(np.array([y]))[0] == pytest.approx(i0 * k0 - i1 * k1, rel=3e-6)


def test_auto_takes_the_tree_for_many_pairs():
    """Mutants: another number of pairs; the method that was asked for left out."""
    assert [ga.interactions.SelfGravity(softening=0.1).by_tree(14_000**2 + more) for more in (0, 1)] == [False, True]
    assert not ga.interactions.SelfGravity(method="direct").by_tree(10**12)
    assert ga.interactions.SelfGravity(method="tree").by_tree(4)
