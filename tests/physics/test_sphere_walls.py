"""Contacts between spheres and colliders at rest: restitution, friction, spin, the ledger, and a gas between walls."""

import warnings

import numpy as np
import pytest

import gen_art as ga

Contacts = ga.interactions.Contacts


def simulated(x, v, dt, colliders, *, mass=1.0, radius=0.1, integrator="leapfrog", forces=(), ledger=False, **rules):
    spin = {f"spin_{c}": np.zeros(len(x)) for c in "xyz"} if rules.get("spin") else {}
    system = ga.ParticleSystem(
        position=x, velocity=v, mass=mass, radius=radius, interactions=[Contacts(**rules)], integrator=integrator,
        forces=list(forces), colliders=colliders, attributes=spin,
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=dt, precision="f64", ledger=ledger)


@pytest.mark.parametrize("e", [1.0, 0.5])
@pytest.mark.parametrize("mass", [1.0, 40.0])
def test_a_sphere_leaves_a_wall_at_its_restitution(e, mass):
    """After half an oscillation, T, with overlap up to v T / pi for e = 1.

    To (pi / steps)^2, the scheme's error; with damping, which sets in and ends with a jump, to 1 / steps.
    """
    T, steps = 0.02, 100
    wall = ga.colliders.Plane(point=(0, 0, 0), normal=(0, 1, 0), restitution=e, friction=0)
    sim = simulated([[0, 0.1, 0]], [[0, -2.0, 0]], T / steps, [wall], mass=mass, duration=T, ledger=True)
    start, depth = sim.diagnostics(), 0.0
    for _ in range(steps - 2):
        sim.step(1)
        depth = max(depth, 0.1 - sim["s"].position[0, 1])
    assert sim["s"].position[0, 1] < 0.1  # the contact lasts T
    sim.step(4)
    error = (np.pi / steps) ** 2 if e == 1 else 1 / steps
    assert sim["s"].position[0, 1] > 0.1
    assert sim["s"].velocity[0, 1] == pytest.approx(2 * e, rel=2 * error)
    if e == 1:
        assert depth == pytest.approx(2 * T / np.pi, rel=2 * error)
    end, account = sim.diagnostics(), sim.ledger()
    lost = start.kinetic_energy * (1 - e * e)
    assert end.momentum[1] - start.momentum[1] == pytest.approx(account.impulse["s.plane"][1], rel=1e-12)
    assert account.dissipated.total == pytest.approx(lost, abs=4 * error * start.kinetic_energy)
    assert abs(account.residual) < error * start.kinetic_energy
    assert account.impulse["s.contacts"] == pytest.approx(0)


def test_energy_inside_a_contact():
    """U = m (pi^2 + L^2) d^2 / (2 T^2), with L = -ln restitution of the wall."""
    wall = ga.colliders.Plane(restitution=0.4, friction=0)
    sim = simulated([[0, 0.07, 0]], [[0, 0, 0]], 1e-4, [wall], mass=3.0, duration=0.01)
    expected = 3.0 * (np.pi**2 + np.log(0.4) ** 2) * 0.03**2 / (2 * 0.01**2)
    assert sim.diagnostics().potential_energy == pytest.approx(expected, rel=1e-12)


def test_a_sliding_sphere_stops_by_the_friction_of_the_wall():
    """After v^2 / (2 mu g), to a step's path; it lies sunk in by g T^2 / pi^2."""
    wall = ga.colliders.Plane(restitution=1, friction=0.3)
    T, g, dt = 0.01, 9.81, 5e-4
    sunk = g * T * T / np.pi**2
    sim = simulated([[0, 0.1 - sunk, 0]], [[1.5, 0, 0]], dt, [wall], duration=T, forces=[ga.forces.Gravity((0, -g, 0))])
    sim.step(round(0.8 / dt))
    assert sim["s"].position[0, 0] == pytest.approx(1.5**2 / (2 * 0.3 * g), abs=1.5 * dt)
    assert 0.1 - sim["s"].position[0, 1] == pytest.approx(sunk, rel=1e-9)
    assert np.abs(sim["s"].velocity).max() < 1e-9


def test_a_sphere_that_spins_comes_to_roll():
    """v = 5/7 v0, whatever the friction."""
    wall = ga.colliders.Plane(restitution=1, friction=0.3)
    T, g, dt = 0.01, 9.81, 5e-4
    sim = simulated(
        [[0, 0.1 - g * T * T / np.pi**2, 0]], [[1.4, 0, 0]], dt, [wall], duration=T, spin=True,
        integrator="position_verlet", forces=[ga.forces.Gravity((0, -g, 0))],
    )  # fmt: skip
    sim.step(round(0.6 / dt))
    assert sim["s"].velocity[0, 0] == pytest.approx(1.0, rel=g * T * T / np.pi**2 / 0.1)  # the arm is shorter by that
    assert sim["s"].attribute("spin_z")[0] * 0.1 == pytest.approx(-1.0, rel=2 * g * T * T / np.pi**2 / 0.1)


def gas(integrator, per_side, steps, dt, duration, share=0.3):
    """Spheres of masses 1 and 100 in a unit box; the largest relative change of the energy, sampled ten times.

    share : of a sphere's radius in its cell at the start
    """
    n, r = per_side**3, share / per_side
    at = np.linspace(1.2 * r, 1 - 1.2 * r, per_side)
    x = np.stack(np.meshgrid(at, at, at, indexing="ij"), -1).reshape(-1, 3)
    v = np.random.default_rng(1).normal(size=(n, 3))
    box = ga.colliders.Box(min=(0, 0, 0), max=(1, 1, 1), restitution=1, friction=0)
    sim = simulated(
        x, v, dt, [box], mass=np.where(np.arange(n) % 2, 100.0, 1.0), radius=r, integrator=integrator, restitution=1,
        duration=duration,
    )  # fmt: skip
    start, errors = sim.diagnostics().energy, []
    for _ in range(10):
        sim.step(steps // 10)
        errors.append(abs(sim.diagnostics().energy / start - 1))
    return max(errors)


@pytest.mark.parametrize("integrator, bound", [("semi_implicit_euler", 0.03), ("leapfrog", 0.015)])
def test_a_gas_between_walls_keeps_its_energy(integrator, bound):
    """Light spheres are squeezed between heavy ones and walls.

    semi_implicit_euler keeps H - dt/2 F.v: with 12 steps a contact each of some 60 contacts is off by up to 13 % of its
    energy, with random signs, so the sum by 0.8 % (one sigma). Leapfrog's error is of the next order. Walls that strike at
    an instant multiply the energy by thousands with the first, and change it by 2 to 6 % with the second.
    """
    assert gas(integrator, 5, 6000, 1e-4, 1.2e-3, share=0.42) < bound


@pytest.mark.proof
@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "position_verlet", "leapfrog", "yoshida4", "rk4"])
def test_a_gas_between_walls_keeps_its_energy_over_300_collisions(integrator):
    """The light spheres come to 12 m/s, and each collides 1000 (0.06 m)^2 pi 12 m/s = 135 times a second with spheres alone."""
    assert gas(integrator, 10, 50_000, 5e-5, 7e-4) < 0.01


def test_schemes_that_gain_energy_are_refused():
    for scheme in ("euler", "rk2"):
        with pytest.raises(
            ga.UsageError, match=rf"contacts: {scheme} gains energy in every collision; give 's' leapfrog"
        ):
            simulated([[0, 0, 0]], [[0, 0, 0]], 1e-3, [], integrator=scheme)


def test_colliders_that_move_or_do_more_than_bounce_strike_at_an_instant():
    """They are left to the step kernel; the names in the ledger count all of them."""
    still = ga.colliders.Plane(point=(0, -1, 0), restitution=1)
    moving = ga.colliders.Plane(point=(0, 1, 0), normal=(0, -1, 0), velocity=(0, -0.1, 0), restitution=1)
    kills = ga.colliders.Plane(point=(2, 0, 0), normal=(-1, 0, 0), action="kill")
    sim = simulated([[0, 0, 0]], [[0, 2.0, 0]], 1e-3, [still, moving, kills], restitution=1, ledger=True)
    assert [t.name for t in sim["s"].composition.colliders] == ["plane_2", "plane_3"]
    sim.step(600)
    account = sim.ledger()
    assert sim["s"].velocity[0, 1] == pytest.approx(-2.2, rel=1e-12)
    assert set(account.impulse) == {"s.contacts", "s.plane", "s.plane_2", "s.plane_3"}
    assert abs(account.residual) < 1e-12


def test_spheres_too_fast_for_their_contacts_are_said():
    """Closing at 8 m/s, radius 0.02, default duration of 20 steps of 1 ms: they pass through each other. With what is advised they bounce."""
    x, v = [[-0.1, 0, 0], [0.1, 0, 0]], [[4.0, 0, 0], [-4.0, 0, 0]]
    with pytest.warns(
        ga.AdviceWarning, match=r"too soft for particle \d, which has 4 m/s: .* use a duration of at most"
    ) as caught:
        sim = simulated(x, v, 1e-3, [], radius=0.02, restitution=1)
    sim.step(100)
    assert sim["s"].velocity[0, 0] > 0  # through each other
    words = str(caught[0].message)
    duration, step = (
        float(words.split("duration of at most ")[1].split()[0]),
        float(words.split("step of at most ")[1].split()[0]),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim = simulated(x, v, step, [], radius=0.02, restitution=1, duration=duration)
        sim.step(round(0.1 / step))
    assert sim["s"].velocity[0, 0] == pytest.approx(-4.0, rel=(np.pi / 8) ** 2)
