"""`acceleration` of a system is the sum of all forces on its particles now, and reading it changes nothing.

The independent measure is the change of the velocities over a very short step of a copy, in float64.
"""

import numpy as np
import pytest

import gen_art as ga
from tests.physics.test_copy import CASES

F, I = ga.forces, ga.interactions
N, LIGHT = 40, 3.0


def moving(**parts):
    rng = np.random.default_rng(7)
    return ga.ParticleSystem(
        position=rng.normal(0, 1, (N, 3)), velocity=rng.normal(0, 0.4, (N, 3)), mass=rng.uniform(0.5, 2, N),
        charge=rng.uniform(-1, 1, N), radius=0.02, **parts,
    )  # fmt: skip


def by_difference(make, dt):
    """The change of velocity in a step over its length, and the acceleration before it."""
    system = make()
    sim = ga.Simulation({"s": system}, dt=dt, precision="f64", advice="none")
    before, velocity = system.acceleration, system.velocity
    sim.step(1)
    return (system.velocity - velocity) / dt, before


SYSTEMS = {
    "fields": lambda: moving(forces=[F.Gravity(), F.CurlNoise(strength=2.0), F.PointGravity(GM=3.0, softening=0.3)]),
    "drag in wind": lambda: moving(forces=[F.Damping(0.7), F.Drag(linear=0.2, quadratic=0.3)], medium=ga.Medium(wind=(3, 0, 1))),
    "charges": lambda: moving(
        forces=[F.MagneticField((0, 0.5, 2)), F.ElectricField((1, 0, 0)), F.Damping(0.4)], integrator="boris"
    ),
    "gravity": lambda: moving(interactions=[I.SelfGravity(G=1.0, softening=0.2), I.PairForce(strength=-2.0, exponent=-1, softening=0.3)]),
    "fast": lambda: moving(
        forces=[F.MagneticField((0, 0, 2)), F.ElectricField((5, 1, 0))], integrator="boris", speed_of_light=LIGHT
    ),
    "verlet": lambda: moving(forces=[F.Gravity()], interactions=[I.SelfGravity(G=1.0, softening=0.2)],
                             integrator="position_verlet"),
    "blocks": lambda: moving(interactions=[I.SelfGravity(G=9.0, softening=0.1, levels=4)]),
}  # fmt: skip


@pytest.mark.parametrize("name", SYSTEMS)
def test_it_is_the_change_of_velocity_over_a_short_step(name):
    errors = []
    for dt in (1e-3, 1e-4):
        change, now = by_difference(SYSTEMS[name], dt)
        assert now.shape == (N, 3) and not now.flags.writeable and np.abs(now).max() > 0.1
        errors.append(np.abs(change - now).max())
    # the mean over the step differs from its start by half the step times the jerk; of 1 m/s, float64 keeps 2e-16 / 1e-4
    assert errors[1] < 0.2 * errors[0] or errors[1] < 1e-10


def test_formulas():
    gravity, field = np.array([0.0, -9.81, 0.0]), np.array([0.0, 0.5, 2.0])
    system = moving(forces=[F.Gravity(gravity), F.Damping(0.7), F.MagneticField(field)], integrator="boris")
    ga.Simulation({"s": system}, dt=0.01, precision="f64", advice="none").step(3)
    v, ratio = system.velocity, (system.charge / system.mass)[:, None]
    expected = gravity - 0.7 * v + ratio * np.cross(v, field)
    np.testing.assert_allclose(system.acceleration, expected, rtol=1e-13, atol=1e-13)


def test_a_fast_charge_is_harder_to_turn_along_its_way():
    v, E = 0.8 * LIGHT, 2.0
    system = ga.ParticleSystem(
        position=np.zeros((2, 3)), velocity=[[v, 0, 0], [0, v, 0]], charge=1.0, mass=1.0, forces=[F.ElectricField((E, 0, 0))],
        integrator="boris", speed_of_light=LIGHT,
    )  # fmt: skip
    ga.Simulation({"s": system}, dt=1e-3, precision="f64", advice="none")
    gamma = 1 / 0.6
    np.testing.assert_allclose(system.acceleration, [[E / gamma**3, 0, 0], [E / gamma, 0, 0]], rtol=1e-13, atol=1e-13)


def test_fixed_particles_have_none():
    system = ga.ParticleSystem(position=np.zeros((3, 3)), fixed=[1], forces=[F.Gravity()])
    ga.Simulation({"s": system}, dt=0.01)
    assert np.array_equal(system.acceleration[:, 1] < 0, [True, False, True]) and not system.acceleration[1].any()


@pytest.mark.filterwarnings("ignore::gen_art.AdviceWarning")
@pytest.mark.parametrize("case", CASES)
def test_reading_changes_no_bit(case):
    read, left = CASES[case](), CASES[case]()
    for _ in range(6):
        for system in read.members.values():
            if any(one.implicit for one in system.interactions):
                with pytest.raises(ga.UsageError, match=r"is solved over a whole step: compare the velocities"):
                    _ = system.acceleration
            else:
                found = system.acceleration
                assert found.shape == system.position.shape and np.isfinite(found).all()
        read.step(3)
        left.step(3)
    assert read.digest() == left.digest()


def test_it_needs_a_simulation():
    with pytest.raises(ga.UsageError, match="not part of a simulation"):
        _ = moving().acceleration
