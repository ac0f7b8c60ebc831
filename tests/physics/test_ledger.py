"""The ledger closes: what remains is the scheme's error, of the scheme's order in float64."""

import numpy as np
import pytest

import gen_art as ga
from tests.physics.test_births import BURST, preset

F = ga.forces
N = 60


def system(integrator, forces, medium=None, interactions=(), charge=0.0):
    r = np.random.default_rng(0)
    return ga.ParticleSystem(
        position=r.normal(size=(N, 3)), velocity=r.normal(size=(N, 3)), mass=r.uniform(0.5, 2, N), charge=charge,
        forces=forces, medium=medium, interactions=list(interactions), integrator=integrator,
    )  # fmt: skip


CASES = {
    "gravity": lambda: dict(forces=[F.Gravity()]),
    "spring": lambda: dict(forces=[F.Spring(stiffness=3.0)]),
    "wind": lambda: dict(forces=[F.Gravity(), F.Drag(0.1, 0.05)], medium=ga.Medium(wind=(2, 0, 0))),
    "turbulence": lambda: dict(forces=[F.Damping(1.0)], medium=ga.Medium(curl_noise={"strength": 2.0, "octaves": 3})),
    "two media": lambda: dict(
        forces=[F.Drag(0.1, 0.05), F.Damping(0.5, ga.Medium(wind=(0, 1, 0)))], medium=ga.Medium(wind=(2, 0, 0))
    ),
    "push": lambda: dict(forces=[F.CurlNoise(2.0, 1.0, 1.0, 3), F.ThermalLift()]),
    "bottle": lambda: dict(forces=[F.MagneticMirror(1.0), F.ElectricField((0.3, 0, 0))], charge=1.0),
    "mutual": lambda: dict(forces=[], interactions=[ga.interactions.SelfGravity(G=0.05, softening=0.3)]),
}
# the order of the residual at dt -> dt/2: None where the scheme closes to round-off
ORDERS = {
    ("gravity", "leapfrog"): None, ("gravity", "rk4"): None, ("gravity", "euler"): 1,
    ("spring", "leapfrog"): 2, ("spring", "rk4"): 5, ("spring", "euler"): 1,
    ("wind", "leapfrog"): 2, ("wind", "rk4"): 4, ("wind", "euler"): 1, ("wind", "position_verlet"): None,
    ("turbulence", "position_verlet"): None, ("turbulence", "euler"): 1,
    ("two media", "position_verlet"): None, ("two media", "rk4"): 4,
    ("push", "leapfrog"): None, ("push", "position_verlet"): None,
    ("bottle", "boris"): None,
    ("mutual", "leapfrog"): 2, ("mutual", "position_verlet"): 2, ("mutual", "rk4"): 4,
}  # fmt: skip


def ledger(case, integrator, dt, precision="f64"):
    sim = ga.Simulation({"s": system(integrator, **CASES[case]())}, dt=dt, precision=precision, ledger=True)
    sim.step(round(0.5 / dt))
    return sim, sim.ledger()


@pytest.mark.parametrize("case,integrator", ORDERS)
def test_residual_falls_with_the_order_of_the_scheme(case, integrator):
    order = ORDERS[case, integrator]
    accounts = [ledger(case, integrator, dt)[1] for dt in (0.01, 0.005)]
    scale = accounts[0].scale
    for account in accounts:
        assert np.abs(account.momentum_residual).max() <= 1e-13 * N * 10
    if order is None:
        assert abs(accounts[1].residual) <= 1e-13 * scale
    else:
        assert abs(accounts[1].residual) > 1e-14 * scale
        assert np.log2(abs(accounts[0].residual / accounts[1].residual)) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("case", ["wind", "turbulence", "mutual", "bottle"])
def test_float32_has_a_stated_floor(case):
    integrator = "boris" if case == "bottle" else "position_verlet"
    exact, single = ledger(case, integrator, 0.01)[1], ledger(case, integrator, 0.01, "f32")[1]
    floor = 2e-6  # of the energy that moved, after 50 steps
    assert abs(single.residual - exact.residual) <= floor * single.scale


def test_the_account_says_who_did_what():
    sim, account = ledger("wind", "position_verlet", 0.01)
    assert set(account.work) == {"s.drag"} and account.work["s.drag"] > 0  # the wind drives the particles
    assert account.dissipated["s.drag"] > 0
    mass = sim["s"].mass.sum()
    assert np.allclose(account.impulse["s.gravity"], (0, -9.81 * mass * 0.5, 0), rtol=1e-12)
    assert account.work.total == account.work["s.drag"]
    unbooked = account.residual + account.work.total  # the mutant: work not booked
    assert abs(unbooked) > 1e-3 * account.scale


def test_it_leaves_the_bits_alone():
    for case, integrator in (
        ("wind", "leapfrog"),
        ("mutual", "rk4"),
        ("bottle", "boris"),
        ("turbulence", "position_verlet"),
    ):
        with_books, _ = ledger(case, integrator, 0.01, "f32")
        without = ga.Simulation({"s": system(integrator, **CASES[case]())}, dt=0.01)
        without.step(50)
        assert with_books.digest() == without.digest(), case


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-12), ("f32", 6e-6)])
def test_births_deaths_and_bursts_close_to_round_off(precision, tolerance):
    """Born and died at their exact times inside steps, children included. In float32 45 steps round by eps twice each."""
    sim = ga.Simulation(preset(BURST, 0.01, forces={"gravity": [0, -9.81, 0]}), precision=precision, ledger=True)
    start = sim.diagnostics()  # the shell of time 0 is there from the start
    sim.step(45)
    account = sim.ledger()
    assert account.born["stars.burst.round"].count == 40 and account.born["stars.burst.odd"].count > 13
    assert account.died["shells.m"].count == 3 and account.died["glitter.g"].count > 100
    assert abs(account.residual) <= tolerance * account.scale
    assert np.abs(account.momentum_residual).max() <= tolerance * np.sqrt(account.scale * account.born.total.mass)
    d = sim.diagnostics()
    assert start.count + account.born.total.count - account.died.total.count == d.count
    assert start.mass + account.born.total.mass - account.died.total.mass == pytest.approx(d.mass, rel=1e-12)
    assert abs(account.residual - account.died.total.energy) > 1e-2 * account.scale  # the mutant: deaths not booked


def test_a_simulation_without_it_says_how_to_keep_it():
    sim = ga.Simulation({"s": system("leapfrog", [F.Gravity()])}, dt=0.01)
    with pytest.raises(ga.UsageError, match="ledger=True"):
        sim.ledger()


def test_momentum_closes_where_a_particle_gets_stuck():
    """Between two walls it meets more often in a step than is followed, and stays for the rest of the step."""
    walls = [ga.colliders.Plane(point=(x, 0, 0), normal=(1 - 2 * x * 1e4, 0, 0), restitution=1.0) for x in (0.0, 1e-4)]
    one = ga.ParticleSystem(
        position=[(5e-5, 0, 0)], velocity=[(1, 0, 0)], mass=2.0, radius=0.0, forces=[F.Gravity()], colliders=walls
    )
    sim = ga.Simulation({"s": one}, dt=0.01, precision="f64", ledger=True, advice="none")
    sim.step(20)
    assert sim["s"].velocity[0, 1] > -0.9 * 9.81 * sim.time  # it did get stuck
    assert np.abs(sim.ledger().momentum_residual).max() < 1e-12 * 2.0 * 9.81 * sim.time


def test_a_death_in_the_step_of_its_birth_counts_once():
    """Sparks of a burst that strike the floor at once."""
    data = {
        "version": 1, "clock": {"duration": 1, "step": "1/60"}, "forces": {"gravity": [0, -9.81, 0]},
        "systems": {
            "shells": {
                "particle": {"mass": 1, "lifetime": 0.503},
                "emitters": {"one": {"count": 5, "shape": {"box": {"min": [-1, 1.3, 0], "max": [1, 1.3, 0]}}}},
            },
            "sparks": {
                "particle": {"mass": 0.1, "radius": 0}, "colliders": {"plane": {"action": "kill"}},
                "emitters": {
                    "burst": {"from": {"event": "shells.death"}, "count": 40, "velocity": {"sphere": "0..50"}},
                    "many": {"count": 3000, "shape": {"point": [0, 99, 0]}},  # few dead are not cleared away at once
                },
            },
        },
    }  # fmt: skip
    sim = ga.Simulation(ga.load_preset(data), precision="f64", ledger=True, advice="none")
    sim.step(31)
    assert 3000 < sim["sparks"].count < 3200
    sim.step(20)
    born, died = sim.ledger().born, sim.ledger().died
    assert born["sparks.burst"].count == 200
    assert died["sparks.burst"].count == 3200 - sim["sparks"].count
