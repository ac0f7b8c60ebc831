"""Spheres that turn: angular momentum, sliding to rolling, rolling resistance; and what is said of overlaps at the start."""

import numpy as np
import pytest

import gen_art as ga

Contacts = ga.interactions.Contacts


def made(
    x,
    v,
    dt,
    mass=1.0,
    radius=0.1,
    turns=None,
    forces=(),
    fixed=None,
    precision="f64",
    integrator="position_verlet",
    **rules,
):
    turns = np.zeros((len(x), 3)) if turns is None else np.asarray(turns, float)
    system = ga.ParticleSystem(
        position=x, velocity=v, mass=mass, radius=radius, interactions=[Contacts(**rules)], integrator=integrator,
        forces=list(forces), fixed=fixed, attributes={f"spin_{c}": turns[:, k] for k, c in enumerate("xyz")},
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=dt, precision=precision)


def spins(sim):
    return np.stack([sim["s"].attribute(f"spin_{c}") for c in "xyz"], 1).astype(float)


def angular_momentum(sim):
    m, r = sim["s"].mass.astype(float), sim["s"].radius.astype(float)
    return sim.diagnostics().angular_momentum + ((0.4 * m * r * r)[:, None] * spins(sim)).sum(0)


@pytest.mark.parametrize("rolling", [0.0, 0.2])
@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-14), ("f32", 2e-6)])
def test_a_frictional_collision_keeps_momentum_and_angular_momentum(precision, tolerance, rolling):
    r = np.random.default_rng(2)
    spin = r.normal(size=(2, 3)) * 20
    sim = made(
        [[-0.16, 0.05, 0.02], [0.12, 0, 0]], [[1.0, 0, 0], [-0.5, 0.2, 0]], 2e-4, [1.0, 2.5], [0.1, 0.15], spin,
        precision=precision, restitution=0.6, friction=0.5, rolling=rolling, spin=True, duration=0.004,
    )  # fmt: skip
    start, first = angular_momentum(sim), sim.diagnostics()
    sim.step(500)
    end = sim.diagnostics()
    assert np.abs(spins(sim) - spin).min(axis=1).max() > 0.1  # both were turned
    assert np.abs(end.momentum - first.momentum).max() < tolerance
    assert np.abs(angular_momentum(sim) - start).max() < tolerance
    assert (
        np.abs(end.angular_momentum - first.angular_momentum).max() > 1e3 * tolerance
    )  # the orbital part alone is not kept


def on_a_plain(v, dt, turns=(0, 0, 0), r=0.1, big=2e4, **rules):
    """A sphere that rests on a fixed one so large that it is flat, and moves along x."""
    T = rules.pop("duration", 100 * dt)
    depth = 9.81 * T**2 / (np.pi**2 + np.log(rules.get("restitution", 0.3)) ** 2)
    return made(
        [[0, -big, 0], [0, r - depth, 0]], [[0, 0, 0], [v, 0, 0]], dt, 1.0, [big, r],
        [[0, 0, 0], turns], [ga.forces.Gravity((0, -9.81, 0))], [0],
        restitution=rules.pop("restitution", 0.3), duration=T, **rules,
    )  # fmt: skip


def test_a_sliding_sphere_comes_to_roll():
    """It slides by -mu g, is turned by 5 mu g / 2 r, and rolls at 5/7 of its first speed from t = 2 v0 / (7 mu g) on."""
    mu, v0, r, g = 0.2, 1.0, 0.1, 9.81
    end = 2 * v0 / (7 * mu * g)
    sim = on_a_plain(v0, end / 2000, friction=mu, spin=True)
    sim.step(1000)
    assert sim["s"].velocity[1, 0] == pytest.approx(v0 - mu * g * end / 2, rel=1e-3)
    assert spins(sim)[1, 2] == pytest.approx(-2.5 * mu * g / r * end / 2, rel=1e-3)
    sim.step(950)
    sliding = sim["s"].velocity[1, 0] + spins(sim)[1, 2] * r
    assert sliding == pytest.approx(0.025 * v0, rel=0.05)  # nearly there
    sim.step(1050)
    assert sim["s"].velocity[1, 0] == pytest.approx(5 / 7 * v0, rel=1e-3)
    assert sim["s"].velocity[1, 0] + spins(sim)[1, 2] * r == pytest.approx(0, abs=1e-3)


def test_a_spinning_sphere_drives_off():
    """Put down at rest with the spin w0 it ends at 2/7 w0 r."""
    r, w0 = 0.1, -30.0
    sim = on_a_plain(0.0, 4e-4, (0, 0, w0), friction=0.3, spin=True)
    sim.step(900)
    assert sim["s"].velocity[1, 0] == pytest.approx(-2 / 7 * w0 * r, rel=2e-3)


def test_rolling_resistance_slows_by_five_sevenths():
    """a = -5/7 rolling g for a sphere on a plain, whose R is its radius; it then stays."""
    v0, c, g, r = 0.2, 0.05, 9.81, 0.1
    sim = on_a_plain(v0, 4e-4, (0, 0, -v0 / r), friction=0.6, rolling=c)
    sim.step(700)
    assert sim["s"].velocity[1, 0] == pytest.approx(v0 - 5 / 7 * c * g * 0.28, rel=5e-3)
    sim.step(1300)
    assert abs(sim["s"].velocity[1, 0]) < 2e-3


def test_spin_can_be_given_in_yaml_and_is_part_of_the_state(tmp_path):
    preset = {
        "version": 1, "clock": {"duration": 1, "fps": 25, "step": 0.001},
        "systems": {"s": {
            "particle": {"radius": 0.08}, "integrator": "semi_implicit_euler",
            "interactions": {"contacts": {"friction": 0.4, "rolling": 0.02}},
            "emitters": {"crowd": {"count": 200, "shape": {"ball": 0.5}, "velocity": {"thermal": 0.5}}},
        }},
    }  # fmt: skip
    with pytest.warns(UserWarning, match="spheres overlap at the start"):
        sim = ga.Simulation(ga.load_preset(preset))
    sim.step(20)
    assert np.abs(spins(sim)).max() > 1
    sim.save(tmp_path / "a.gas")
    with pytest.warns(UserWarning, match="spheres overlap"):
        again = ga.Simulation.restore(tmp_path / "a.gas")
    sim.step(10)
    again.step(10)
    assert sim.digest() == again.digest()


def test_spin_needs_one_kick_a_step():
    with pytest.raises(
        ga.UsageError, match="spin is advanced once a step; give 's' semi_implicit_euler or position_verlet"
    ):
        made(np.eye(3), np.zeros((3, 3)), 1e-3, integrator="leapfrog", spin=True)


def test_overlaps_at_the_start_are_named():
    x = np.array([[0, 0, 0], [0.19, 0, 0], [1.0, 0, 0], [1.05, 0, 0], [3.0, 0, 0]])
    with pytest.warns(UserWarning, match=r"4 spheres overlap at the start, particles 2 and 3 the most, by 0\.15 m"):
        made(x, np.zeros((5, 3)), 1e-3)
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made(x * [2.0, 1, 1] + [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0.5, 0], [0, 0, 0]], np.zeros((5, 3)), 1e-3)
        made(x[:2], np.zeros((2, 3)), 1e-3, radius=0.0955)  # what a pile at rest sinks in is no news
