"""Contacts: against NumPy, collisions of two, the cradle, gases, stacks, neighbours however far apart, momentum."""

import numpy as np
import pytest

import gen_art as ga

Contacts = ga.interactions.Contacts


def simulated(
    x, v, dt, precision="f64", ledger=False, integrator="leapfrog", forces=(), fixed=None, mass=1.0, radius=0.1, **rules
):
    system = ga.ParticleSystem(
        position=x, velocity=v, mass=mass, radius=radius, interactions=[Contacts(**rules)], integrator=integrator,
        forces=list(forces), fixed=fixed,
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=dt, precision=precision, ledger=ledger)


def crowd(n=400, seed=0, spread=1.0):
    r = np.random.default_rng(seed)
    return r.uniform(-spread, spread, (n, 3)), r.normal(size=(n, 3)), r.uniform(0.5, 2, n), r.uniform(0.03, 0.15, n)


def pushes(x, v, m, r, e, mu, T, dt):
    """Accelerations of every overlapping pair, and their energy, as the docstring has them (kick of dt, exact decay)."""
    L = -np.log(e)
    force, energy = np.zeros_like(x), 0.0
    for i in range(len(x)):
        d = x[i] - x
        distance = np.linalg.norm(d, axis=1)
        near = np.flatnonzero((distance < r[i] + r) & (np.arange(len(x)) != i))
        for j in near:
            n, M = d[j] / distance[j], 1 / (1 / m[i] + 1 / m[j])
            k = M * (np.pi**2 + L**2) / T**2
            overlap = r[i] + r[j] - distance[j]
            u = v[i] - v[j]
            push = k * overlap - M * (1 - np.exp(-2 * L / T * dt)) / dt * u.dot(n)
            slide = u - u.dot(n) * n
            drag = min(mu * max(push, 0), 0.5 * M / dt * np.linalg.norm(slide))
            force[i] += push * n - drag * slide / np.linalg.norm(slide)
            energy += 0.25 * k * overlap**2
    return force / m[:, None], energy


@pytest.mark.parametrize("spread", [0.6, 30.0])
@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-7), ("f32", 1e-2)])
def test_forces_energy_and_reaction(precision, tolerance, spread):
    """Also where a few spheres lie far from the others, round which the grid wraps."""
    x, v, m, r = crowd()
    x[:40] *= spread
    x[40:80] += [0, 0, 3 * spread]
    dt = 1e-4
    a, energy = pushes(x, v, m, r, 0.6, 0.4, 0.05, dt)
    sim = simulated(
        x,
        v,
        dt,
        precision,
        integrator="semi_implicit_euler",
        mass=m,
        radius=r,
        restitution=0.6,
        friction=0.4,
        duration=0.05,
    )
    assert sim.diagnostics().potential_energy == pytest.approx(energy, rel=max(tolerance, 1e-9) / 10)
    sim.step(1)
    found = (sim["s"].velocity.astype(float) - v.astype(sim.dtype)) / dt
    assert np.abs(found - a).max() <= tolerance * np.abs(a).max()
    for wrong in (dict(e=0.5, mu=0.4), dict(e=0.6, mu=0.2)):
        assert np.abs(found - pushes(x, v, m, r, T=0.05, dt=dt, **wrong)[0]).max() > 2 * tolerance * np.abs(a).max()
    eps = np.finfo(sim.dtype).eps
    change = (m[:, None] * (sim["s"].velocity.astype(float) - v.astype(sim.dtype))).sum(0)
    assert np.abs(change).max() <= 4 * eps * np.abs(m[:, None] * v).sum()


@pytest.mark.parametrize("masses", [(1.0, 1.0), (1.0, 4.0), (3.0, 0.01)])
@pytest.mark.parametrize("e", [1.0, 0.9, 0.5, 0.1])
@pytest.mark.parametrize("integrator", ["leapfrog", "position_verlet", "rk4"])
def test_two_spheres_part_at_the_restitution(e, masses, integrator):
    """In a line: u1 = v1 + (1 + e) m2 / (m1 + m2) (v2 - v1). Met to 2 % of the approach at 20 steps a collision (4 % with position_verlet)."""
    m = np.array(masses)
    sim = simulated(
        [[-0.12, 0, 0], [0.12, 0, 0]], [[1.0, 0, 0], [-0.5, 0, 0]], 1e-3, mass=m, restitution=e, integrator=integrator
    )
    sim.step(100)
    v = sim["s"].velocity[:, 0]
    assert (v[1] - v[0]) == pytest.approx(1.5 * e, abs=(0.04 if integrator == "position_verlet" else 0.02) * 1.5)
    assert m @ v == pytest.approx(m @ [1.0, -0.5], abs=1e-14)


def test_restitution_is_met_better_with_more_steps():
    errors = []
    for steps in (20, 200):
        sim = simulated(
            [[-0.101, 0, 0], [0.101, 0, 0]], [[1.0, 0, 0], [-1.0, 0, 0]], 0.02 / steps, restitution=0.5, duration=0.02
        )
        sim.step(2 * steps)
        errors.append(abs(np.diff(sim["s"].velocity[:, 0])[0] / 2 - 0.5))
    assert errors[1] < errors[0] / 5 or errors[1] < 1e-4


def test_oblique_elastic_collision_turns_by_a_right_angle():
    """Equal masses, one at rest: their paths part at 90 degrees and the energy stays."""
    b = 0.09
    sim = simulated([[-0.2, b, 0], [0, 0, 0]], [[1.0, 0, 0], [0, 0, 0]], 2e-4, restitution=1.0, duration=0.004)
    sim.step(2000)
    v = sim["s"].velocity
    assert (v**2).sum() == pytest.approx(1, rel=1e-3)
    assert abs(v[0] @ v[1]) / np.prod(np.linalg.norm(v, axis=1)) < 0.03
    assert np.abs(v.sum(0) - [1, 0, 0]).max() < 1e-13


@pytest.mark.parametrize("precision,steps,tolerance", [("f64", 300, 1e-6), ("f32", 75, 3e-4)])
def test_newtons_cradle(precision, steps, tolerance):
    """One in, one out: the last leaves at the speed of the first, the others stay. They hang apart, so that one collision
    comes after another; to 1e-6 at 300 steps a collision. In float32 an overlap of up to v T / pi = 6e-4 m is a difference of
    places of up to 0.8 m: four collisions at eps 0.8 / 6e-4."""
    x, v = np.zeros((5, 3)), np.zeros((5, 3))
    x[:, 0] = np.arange(5) * 0.201
    v[0, 0] = 1.0
    errors = []
    for restitution, n in ((1.0, steps), (1 - 3 * tolerance, 75)):
        sim = simulated(x, v, 2e-3 / n, precision, restitution=restitution, duration=2e-3)
        sim.step(7 * n)
        errors.append(np.abs(sim["s"].velocity[:, 0].astype(float) - [0, 0, 0, 0, 1]).max())
    assert errors[0] < tolerance < errors[1]


def test_elastic_gas_keeps_its_energy_and_momentum():
    r = np.random.default_rng(1)
    cells = np.stack(np.meshgrid(*[np.arange(6)] * 3), -1).reshape(-1, 3) * 0.3
    v = r.normal(size=cells.shape)
    sim = simulated(cells, v, 2e-4, radius=0.1, restitution=1.0, duration=0.01, ledger=True)
    before = sim.diagnostics()
    sim.step(1000)
    after, account = sim.diagnostics(), sim.ledger()
    assert np.abs(sim["s"].velocity - v).max() > 0.5  # many collided
    assert after.energy == pytest.approx(before.energy, rel=2e-3)
    assert np.abs(after.momentum - before.momentum).max() < 1e-12
    assert np.abs(after.angular_momentum - before.angular_momentum).max() < 1e-11
    assert not account.dissipated


def test_what_inelastic_contacts_take_is_booked():
    x, v, m, r = crowd(300)
    sim = simulated(
        x, v, 2e-4, mass=m, radius=r, restitution=0.5, friction=0.3, duration=0.01, ledger=True, integrator="leapfrog"
    )
    before = sim.diagnostics()
    sim.step(300)
    account = sim.ledger()
    lost = before.energy - sim.diagnostics().energy
    assert lost > 0.2 * before.energy
    assert account.dissipated["s.contacts"] == pytest.approx(lost, rel=0.02)
    assert np.abs(account.momentum_residual).max() < 1e-11


def test_a_stack_stays():
    """Four spheres on a fixed one, under gravity: at rest, in a column, sunk by no more than its weight asks for."""
    n, T, g = 5, 0.02, 9.81
    x = np.zeros((n, 3))
    x[:, 1] = np.arange(n) * 0.2
    sim = simulated(
        x, np.zeros((n, 3)), 1e-3, fixed=[0], restitution=0.3, friction=0.5, duration=T,
        forces=[ga.forces.Gravity((0, -g, 0))],
    )  # fmt: skip
    sim.step(2500)
    y = sim["s"].position
    assert np.abs(sim["s"].velocity).max() < 1e-5
    assert np.abs(y[:, [0, 2]]).max() < 1e-9
    k = 0.5 * (np.pi**2 + np.log(0.3) ** 2) / T**2
    load = g * (n - 1 - np.arange(n - 1))  # carried by contact j
    soft = np.r_[2.0, np.ones(n - 2)]  # the fixed one doubles the reduced mass of the first
    assert np.diff(y[:, 1]) == pytest.approx(0.2 - load / (k * soft), abs=1e-7)


def test_friction_slows_sliding():
    """A sphere pressed on a fixed, larger one slides off later with friction than without; mu N a bound of the pull."""
    speeds = []
    for mu in (0.0, 0.5):
        sim = simulated(
            [[0, 0, 0], [0, 0.1999, 0]], [[0, 0, 0], [0.3, 0, 0]], 1e-4, fixed=[0], restitution=0.5, friction=mu, duration=0.01,
            forces=[ga.forces.Gravity((0, -9.81, 0))],
        )  # fmt: skip
        sim.step(200)
        speeds.append(sim["s"].velocity[1, 0])
    assert 0 <= speeds[1] < speeds[0]
    assert speeds[0] - speeds[1] == pytest.approx(0.5 * 9.81 * 0.02, rel=0.25)


def test_the_same_bits_again_and_a_yaml_key():
    from gen_art.preset import load_preset

    preset = {
        "version": 1, "clock": {"duration": 1, "fps": 25, "step": 0.001},
        "systems": {"s": {
            "particle": {"radius": 0.08}, "interactions": {"contacts": {"restitution": 0.7, "friction": 0.2}},
            "emitters": {"crowd": {"count": 300, "shape": {"ball": 0.5}, "velocity": {"thermal": 0.5}}},
        }},
    }  # fmt: skip
    ends = set()
    for _ in range(2):
        sim = ga.Simulation(load_preset(preset))
        sim.step(40)
        ends.add(sim.digest())
    assert len(ends) == 1


def test_contacts_that_cannot_be():
    with pytest.warns(UserWarning, match="last 5 steps; leapfrog needs 8: use a step of at most 0.000625 s"):
        simulated(np.eye(3), np.zeros((3, 3)), 1e-3, duration=5e-3)
    with pytest.raises(ga.UsageError, match="contacts: a particle has no mass"):
        simulated(np.eye(3), np.zeros((3, 3)), 1e-3, mass=0.0).step(1)
    with pytest.raises(ga.UsageError, match="restitution must be from 0 to 1"):
        Contacts(restitution=1.2)


@pytest.mark.parametrize("far", [1e30, np.inf, np.nan])
def test_a_sphere_that_is_far_too_far_is_said(far):
    spheres = ga.ParticleSystem(position=[(0, 0, 0), (1, 0, 0)], radius=0.1, interactions=[ga.interactions.Contacts()])
    sim = ga.Simulation({"s": spheres}, dt=1e-4, advice="none")
    sim.step(1)
    sim.systems["s"].floats[0, 1] = far
    with pytest.raises(ga.DivergedError, match="most likely because"):
        sim.step(64)
