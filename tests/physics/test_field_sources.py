"""Fields of sources: exact on their axes, free of divergence; charges in them drift and swing as theory says."""

import numpy as np
import pytest

import gen_art as ga
from gen_art import ti
from tests.physics.probe import probe, states
from tests.physics.test_charged import run

F = ga.forces
MAGNETS = {
    "dipole": F.MagneticDipole((4e6, -1e7, 7e6), (0.1, 0, 0), 0.3),
    "wire": F.MagneticWire(3e6, (0.1, 0, 0), (1, 2, 2), 0.2),
    "loop": F.MagneticLoop(4e6, 0.9, (0.1, 0, 0), (0, 3, 4)),
    "thick loop": F.MagneticLoop(4e6, 0.9, (0.1, 0, 0), (0, 3, 4), 0.3),
    "mirror": F.MagneticMirror(0.5, 1.3, (0, 0.1, 0), (0, 3, 0)),
}


def slopes(force, h=1e-4):
    """dB_i/dx_j at the states, (3, 3, n)."""
    out = []
    for c in range(3):
        plus, minus = states(), states()
        plus.position[c] += h
        minus.position[c] -= h
        out.append((probe(force, plus)[1] - probe(force, minus)[1]) / (2 * h))
    return np.array(out).transpose(1, 0, 2)


@pytest.mark.parametrize("name", MAGNETS)
def test_magnetic_fields_have_no_divergence(name):
    d = slopes(MAGNETS[name])
    size = np.sqrt((d**2).sum((0, 1)))
    assert (np.abs(np.trace(d)) / size).max() <= 1e-5
    d[0] *= 1.01  # the mutant: one component a per cent off
    assert (np.abs(np.trace(d)) / size).max() > 1e-3


def on_axis(force, z):
    p = states(len(z))
    p.position[:] = 0.0
    p.position[1] = z
    return probe(force, p)[1]


def test_values_on_the_axis():
    z = np.array([0.0, 0.4, -1.5, 30.0])
    loop = on_axis(F.MagneticLoop(5.0, 0.7), z)
    assert np.allclose(loop[1], 2e-7 * np.pi * 5.0 * 0.49 / (0.49 + z**2) ** 1.5, rtol=1e-13)
    assert np.abs(loop[[0, 2]]).max() == 0.0
    dipole = on_axis(F.MagneticDipole((0, 3.0, 0)), z[1:])
    assert np.allclose(dipole[1], 2e-7 * 3.0 / np.abs(z[1:]) ** 3, rtol=1e-13)


def test_a_loop_from_afar_is_a_dipole():
    p = states()
    p.position *= 100.0 / np.linalg.norm(p.position, axis=0)
    loop, dipole = probe(F.MagneticLoop(5.0, 0.7), p)[1], probe(F.MagneticDipole((0, 5.0 * np.pi * 0.49, 0)), p)[1]
    assert np.abs(loop - dipole).max() <= 2e-4 * np.abs(dipole).max()


def test_close_to_its_wire_a_loop_is_a_wire():
    p = states(16)
    angle = np.linspace(0, 2 * np.pi, 16)
    p.position[:] = (1.0 + 1e-4 * np.cos(angle), 1e-4 * np.sin(angle), 0 * angle)
    B = probe(F.MagneticLoop(1.0, 1.0), p)[1]
    assert np.allclose(np.linalg.norm(B, axis=0), 2e-7 / 1e-4, rtol=1e-3)


def frequencies(signal, dt, count):
    """The strongest angular frequencies of a real signal, by the windowed transform and a parabola about each peak."""
    power = np.log(np.abs(np.fft.rfft((signal - signal.mean()) * np.blackman(len(signal)))) + 1e-300)
    inner = np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] > power[2:])) + 1
    best = sorted(inner, key=lambda k: -power[k])[:count]
    found = []
    for k in best:
        a, b, c = power[k - 1 : k + 2]
        found.append((k + 0.5 * (a - c) / (a - 2 * b + c)) * 2 * np.pi / (dt * len(signal)))
    return sorted(found)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_penning_trap_swings_at_its_three_frequencies(precision):
    """w_z, and w+- = w_c / 2 +- sqrt(w_c^2 / 4 - w_z^2 / 2), within 1e-3; of 16,000 roundings in float32 a phase holds
    sqrt(16,000) eps = 8e-6, less than the scheme's (w dt)^2 / 12 = 2e-4."""
    wc, wz = 10.0, 3.0
    dt = 0.05 / wc
    path, _ = run(
        (0.1, 0, 0.2), (0.3, 0, 0), [F.MagneticField((0, 0, wc)), F.ElectricQuadrupole(wz**2, 1.0, (0, 0, 0), (0, 0, 1))],
        dt, 16000, precision=precision, every=4,
    )  # fmt: skip
    path, dt = path.astype(float), 4 * dt
    split = np.sqrt(wc**2 / 4 - wz**2 / 2)
    assert frequencies(path[:, 2], dt, 1) == pytest.approx([wz], rel=1e-3)
    assert frequencies(path[:, 0], dt, 2) == pytest.approx([wc / 2 - split, wc / 2 + split], rel=1e-3)
    assert wc != pytest.approx(wc / 2 + split, rel=1e-2)  # the mutant: no electric field


@pytest.mark.parametrize("charge", [1.0, -1.0])
def test_gradient_drift_around_a_wire(charge):
    """About a wire a gyrating charge drifts along it at m v_perp^2 / (2 q B rho), the gradient part of the drift."""
    B0, rho, speed = 50.0, 1.0, 0.5
    current = B0 * rho / 2e-7
    gyro = speed / B0
    start = (rho, 0.0, 0.0)  # B is along -z there, the wire along y; the motion stays in the plane z = 0
    path, _ = run(start, (0, speed, 0), [F.MagneticWire(current)], 0.05 / B0, 6283, charge)
    center = path[:, 0].mean()
    drift = speed * gyro / (2 * center)  # v_perp r_L / (2 rho)
    found = np.polyfit(np.arange(len(path)) * 0.05 / B0, path[:, 1], 1)[0]
    assert abs(found) == pytest.approx(drift, rel=0.02)
    direction = np.cross((0, 0, -1.0), (-1.0, 0, 0))[1] * charge  # q B x grad B
    assert np.sign(found) == np.sign(direction)


@ti.func
def sheared(p, t, q):
    return ti.Vector([0.0, 0.0, 2.0 + p.position[0]])


def test_a_source_may_stand_in_place_of_three_numbers(tmp_path):
    loop = F.MagneticLoop(3.0)
    assert F.MagneticField(loop) is loop
    p = states()
    assert np.allclose(probe(F.MagneticField(sheared), p)[1], [0 * p.mass, 0 * p.mass, 2.0 + p.position[0]])
    assert np.allclose(probe(F.ElectricField(sheared), p)[0][2], (2.0 + p.position[0]) * p.charge / p.mass)
    grid = np.zeros((2, 2, 2, 3)) + (0, 0, 2.0)
    np.save(tmp_path / "b.npy", grid)
    corners = ((-9, -9, -9), (9, 9, 9))
    for source in (grid, tmp_path / "b.npy"):
        field = F.MagneticField(source, bounds=corners)
        assert isinstance(field, F.MagneticGrid) and np.allclose(probe(field, p)[1][2], 2.0)
    assert isinstance(F.ElectricField(grid, bounds=corners), F.ElectricGrid)
    path, _ = run((0, 0, 0), (1, 0, 0), [F.MagneticField(grid, bounds=corners)], 0.05, 63)
    assert np.abs(path[:, :2]).max() == pytest.approx(1.0, rel=1e-2)  # the diameter 2 m v / (q B)
    assert F.MagneticField((0, 0, 1)).values["field"] == (0, 0, 1)
    with pytest.raises(ga.UsageError, match="gives no magnetic field"):
        F.MagneticField(F.Gravity())
    for make in (F.MagneticLoop, F.MagneticWire, F.ElectricWire, F.ElectricQuadrupole):
        with pytest.raises(ga.UsageError, match="null vector"):
            make(axis=(0, 0, 0))
