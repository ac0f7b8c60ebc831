"""Drag against its closed forms."""

import numpy as np
import pytest

import gen_art as ga

SPLITTING = ["semi_implicit_euler", "leapfrog", "velocity_verlet", "position_verlet", "boris"]


def run(forces, dt, steps, velocity=(1.0, 2.0, -1.0), precision="f64", integrator="leapfrog", medium=None, mass=1.3):
    system = ga.ParticleSystem(
        position=[[0, 0, 0]], velocity=[velocity], mass=mass, forces=forces, medium=medium, integrator=integrator
    )
    sim = ga.Simulation({"s": system}, dt=dt, precision=precision)
    sim.step(steps)
    return sim["s"].velocity[0]


@pytest.mark.parametrize("integrator", SPLITTING)
@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (0.0, -9.81, 0.0)])
@pytest.mark.parametrize("kdt", [0.1, 2.0])
def test_linear_drag_is_exact(kdt, gravity, integrator):
    """v = u + a/k + (v0 - u - a/k) exp(-k t), at 1e-12: a stray float32 literal anywhere would show at 1e-8."""
    k, u, a, v0 = 1.7, np.array([0.5, 0.0, 0.3]), np.array(gravity), np.array([1.0, 2.0, -1.0])
    dt, steps = kdt / k, 5
    exact = u + a / k + (v0 - u - a / k) * np.exp(-k * dt * steps)
    found = run(
        [ga.forces.Damping(k), ga.forces.Gravity(gravity)], dt, steps, integrator=integrator, medium=ga.Medium(wind=u)
    )
    assert np.abs(found - exact).max() <= 1e-12
    single = run(
        [ga.forces.Damping(k), ga.forces.Gravity(gravity)],
        dt,
        steps,
        precision="f32",
        integrator=integrator,
        medium=ga.Medium(wind=u),
    )
    assert np.abs(single - exact).max() <= 8 * np.finfo(np.float32).eps * steps * max(1, np.abs(exact).max())
    assert np.abs(single - exact).max() > 1e-12  # float32 is not float64


def fall(dt, integrator="leapfrog", factor=1.0):
    m, k, g, t = 1.3, 0.2, 9.81, 2.0
    v = run(
        [ga.forces.Drag(quadratic=k * factor), ga.forces.Gravity((0, -g, 0))],
        dt,
        round(t / dt),
        (0, 0, 0),
        integrator=integrator,
        mass=m,
    )
    return abs(v[1] + np.sqrt(m * g / k) * np.tanh(t * np.sqrt(g * k / m)))


@pytest.mark.parametrize("integrator,order", [("leapfrog", 2), ("position_verlet", 2), ("rk4", 4)])
def test_quadratic_drag_fall(integrator, order):
    assert fall(0.01, integrator) <= 1e-4
    assert np.log2(fall(0.1, integrator) / fall(0.05, integrator)) == pytest.approx(order, abs=0.35)
    assert fall(0.01, integrator, factor=1.01) > 1e-3  # the mutant: one per cent more drag


@pytest.mark.parametrize("kdt", [0.1, 0.83, 5.0])
def test_terminal_speed_is_exact_whatever_the_step(kdt):
    m, k, g = 1.3, 0.2, 9.81
    terminal = np.sqrt(m * g / k)
    dt = kdt / (k * terminal / m)
    v = run([ga.forces.Drag(quadratic=k), ga.forces.Gravity((0, -g, 0))], dt, 200, (0, 0, 0), mass=m)
    assert v[1] == pytest.approx(-terminal, rel=1e-12)


def test_two_media_pull_towards_their_weighted_mean():
    """dv/dt = k1 (u1 - v) + k2 (u2 - v)."""
    k1, k2, u1, u2, t = 0.7, 1.9, np.array([2.0, 0, 0]), np.array([0, -1.0, 0]), 1.0
    forces = [ga.forces.Damping(k1, ga.Medium(wind=u1)), ga.forces.Damping(k2, ga.Medium(wind=u2))]
    mean = (k1 * u1 + k2 * u2) / (k1 + k2)
    exact = mean + (np.array([1.0, 2.0, -1.0]) - mean) * np.exp(-(k1 + k2) * t)
    assert np.abs(run(forces, 0.25, 4) - exact).max() <= 1e-12


def test_sphere_of_a_coefficient_has_its_terminal_speed():
    """14 mm stars of 1700 kg/m^3 in air: sqrt(2 m g / (density cd area))."""
    radius, density = 0.007, 1700.0
    mass = density * 4 / 3 * np.pi * radius**3
    system = ga.ParticleSystem(
        position=[[0, 0, 0]], mass=mass, radius=radius, medium=ga.Medium(density=1.2),
        forces=[ga.forces.Gravity(), ga.forces.Drag(cd=0.5)],
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=0.1, precision="f64")
    sim.step(600)
    assert sim["s"].velocity[0, 1] == pytest.approx(
        -np.sqrt(2 * mass * 9.81 / (1.2 * 0.5 * np.pi * radius**2)), rel=1e-9
    )
