"""Charges in electric and magnetic fields."""

import numpy as np
import pytest

import gen_art as ga

F = ga.forces


def run(position, velocity, forces, dt, steps, charge=1.0, precision="f64", integrator="boris", every=1):
    ion = ga.ParticleSystem(
        position=[position], velocity=[velocity], charge=charge, forces=forces, integrator=integrator
    )
    sim = ga.Simulation({"ion": ion}, dt=dt, precision=precision)
    path = [sim["ion"].position[0]]
    for _ in range(steps // every):
        sim.step(every)
        path.append(sim["ion"].position[0])
    return np.array(path), sim


def radius_of(path):
    center = (path.max(0) + path.min(0)) / 2
    return np.linalg.norm((path - center)[:, :2], axis=1).mean()


@pytest.mark.parametrize("charge", [1.0, -2.0])
def test_gyration(charge):
    """r = m v / (q B); positive charges turn left-handed about B."""
    w = abs(charge) * 2.0
    dt = 0.1 / w
    path, sim = run((0, 0, 0), (1, 0, 0), [F.MagneticField((0, 0, 2.0))], dt, round(2 * np.pi / 0.1), charge)
    assert radius_of(path) == pytest.approx(1 / w, rel=1e-3)
    assert np.linalg.norm(sim["ion"].velocity[0]) == pytest.approx(1.0, abs=1e-14)
    assert np.sign(path[10, 1]) == -np.sign(charge)


def test_wrong_field_is_caught():
    path, _ = run((0, 0, 0), (1, 0, 0), [F.MagneticField((0, 0, 2.0 * 1.01))], 0.05, 63)
    assert radius_of(path) != pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-12), ("f32", 1e-5)])
def test_crossed_fields_drift(precision, tolerance):
    """Started at v = E x B / B^2 a charge stays at it."""
    E, B = np.array([0.3, 0.0, 0.0]), np.array([0.0, 0.0, 2.0])
    drift = np.cross(E, B) / (B @ B)
    path, _ = run((0, 0, 0), drift, [F.ElectricField(E), F.MagneticField(B)], 0.05, 100, precision=precision)
    assert np.abs(path[-1] - drift * 5.0).max() <= tolerance
    wrong = np.cross(B, E) / (B @ B)
    assert np.abs(path[-1] - wrong * 5.0).max() > 0.1


def test_mirror_bounces_at_its_frequency_and_keeps_the_magnetic_moment():
    """B = B0 (1 + z^2 / L^2): the bounce frequency is v_perp / L where r_L / L is small."""
    B0, L, vperp, vpar = 100.0, 1.0, 1.0, 0.4
    gyro = vperp / B0
    forces = [F.MagneticMirror(B0, L, (0, 0, 0), (0, 0, 1.0))]
    dt = 0.1 / B0
    period = 2 * np.pi * L / vperp
    path, sim = run((gyro, 0, 0), (0, -vperp, vpar), forces, dt, round(1.1 * period / dt))
    z = path[:, 2]
    crossing = np.flatnonzero((z[1:] > 0) & (z[:-1] <= 0))
    at = [i + z[i] / (z[i] - z[i + 1]) for i in crossing]
    assert (at[-1] - at[0]) * dt == pytest.approx(period, rel=2e-3)
    turning = np.abs(z).max()
    assert turning == pytest.approx(vpar / vperp * L, rel=5e-3)  # where mu B = E
    x, v = sim["ion"].position[0], sim["ion"].velocity[0]
    rho2 = x[0] ** 2 + x[1] ** 2
    B = B0 * np.array([-x[0] * x[2], -x[1] * x[2], 1 + x[2] ** 2 - rho2 / 2])
    along = v @ B / np.linalg.norm(B)
    moment = (v @ v - along**2) / np.linalg.norm(B)
    assert moment == pytest.approx(vperp**2 / B0, rel=2e-2)  # the gyrophase average; one phase varies by r_L / L


def test_boris_keeps_its_order_where_a_plain_kick_loses_one():
    def error(integrator, n):
        path, _ = run(
            (0, 0, 0),
            (1, 0, 0),
            [F.MagneticField((0, 0, 2.0)), F.ElectricField((0.3, 0.2, 0))],
            1.0 / n,
            n,
            integrator=integrator,
        )
        return path[-1]

    def order(integrator):
        a, b, c = (error(integrator, n) for n in (50, 100, 200))
        return np.log2(np.linalg.norm(a - b) / np.linalg.norm(b - c))

    assert order("boris") == pytest.approx(2, abs=0.1)
    assert order("leapfrog") == pytest.approx(1, abs=0.1)
