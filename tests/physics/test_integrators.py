"""The order of every integrator, reversibility, and what a wrong one would do."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gen_art as ga
from gen_art.integrators import INTEGRATORS

SYMPLECTIC = ["semi_implicit_euler", "position_verlet", "velocity_verlet", "leapfrog", "yoshida4"]


def on_orbit(t, e):
    """The position at time t of an orbit with GM = a = 1 from pericentre, by Kepler's equation."""
    E = t
    for _ in range(60):
        E -= (E - e * np.sin(E) - t) / (1 - e * np.cos(E))
    return np.array([np.cos(E) - e, np.sqrt(1 - e * e) * np.sin(E), 0.0])


def kepler(integrator, dt, periods=0.4, eccentricity=0.5, forces=(), scheme=None, precision="f64"):
    """The position error after some periods of an orbit with GM = a = 1, and the simulation."""
    x, v = 1 - eccentricity, np.sqrt((1 + eccentricity) / (1 - eccentricity))
    star = ga.ParticleSystem(
        position=[[x, 0, 0]],
        velocity=[[0, v, 0]],
        forces=[ga.forces.PointGravity(GM=1.0), *forces],
        integrator=integrator,
    )
    if scheme is not None:
        star.scheme = scheme
    sim = ga.Simulation({"star": star}, dt=dt, precision=precision)
    sim.step(round(periods * 2 * np.pi / dt))
    return np.linalg.norm(sim["star"].position[0] - on_orbit(sim.time, eccentricity)), sim


def orders(error, steps):
    errors = np.array([error(2 * np.pi / n) for n in steps])
    return np.log2(errors[:-1] / errors[1:])


def measured_order(integrator, scheme=None):
    coarse = {1: 20000, 2: 2000, 4: 500}[INTEGRATORS[integrator].order]
    return orders(lambda dt: kepler(integrator, dt, scheme=scheme)[0], [coarse, 2 * coarse, 4 * coarse])[-1]


@pytest.mark.parametrize("name", INTEGRATORS)
def test_order_on_an_eccentric_orbit(name):
    assert measured_order(name) == pytest.approx(INTEGRATORS[name].order, abs=0.1)


def apsides(sim):
    """Semi-major axis and the angle by which the ellipse has turned, of an orbit with GM = 1 that began at its apocentre on +x."""
    (x, y, _), (u, v, _) = sim["star"].position[0], sim["star"].velocity[0]
    r, L = np.hypot(x, y), x * v - y * u
    return 1 / (2 / r - u * u - v * v), np.arctan2(u * L + y / r, x / r - v * L)


def test_at_forty_steps_a_turn_each_integrator_errs_in_its_own_way():
    """e = 0.6, six turns: Euler leaves, rk2 gains and rk4 loses energy; the symplectic ones keep it, and the ellipse turns alike."""
    found = {n: apsides(kepler(n, 2 * np.pi / 40, 6, -0.6)[1]) for n in ("euler", "rk2", "rk4", *SYMPLECTIC)}
    a = {n: size for n, (size, _) in found.items()}
    assert a["euler"] > 3 or a["euler"] < 0  # hardly bound, or not at all
    assert a["rk2"] > 1.2 and 0.8 < a["rk4"] < 0.95
    second = [n for n in SYMPLECTIC if n != "yoshida4"]
    assert all(a[n] == pytest.approx(1, abs=0.02) for n in SYMPLECTIC)
    turned = [found[n][1] for n in second]
    assert np.ptp(turned) < 0.02 * np.abs(turned).max() and np.abs(turned).min() > 0.5


def test_the_apsides_turn_by_an_angle_of_second_order():
    """By the modified Hamiltonian the pericentre of a symplectic orbit drifts as dt^2: a quarter with half the step."""

    def ratios(scheme=None):
        runs = (kepler("leapfrog", 2 * np.pi / n, 6, -0.6, scheme=scheme)[1] for n in (160, 320, 640))
        turned = np.array([apsides(sim)[1] for sim in runs])
        return turned[:-1] / turned[1:]

    assert ratios() == pytest.approx([4, 4], abs=0.1)
    right = INTEGRATORS["leapfrog"]
    first, *rest = right.stages
    wrong = replace(right, stages=((first[0] * 0.9, *first[1:]), *rest))  # a little of a kick missing: no order at all
    assert ratios(wrong) != pytest.approx([4, 4], abs=0.5)


@pytest.mark.parametrize("name", ["semi_implicit_euler", "position_verlet", "leapfrog", "rk2"])
def test_order_in_float32(name):
    """Of orders 1 and 2, at steps so long that rounding, sqrt(400) eps = 1e-6, is a hundredth of the scheme's error; what
    order 4 errs by where its order shows is not."""
    found = orders(lambda dt: kepler(name, dt, precision="f32")[0], [500, 1000])[0]
    assert found == pytest.approx(INTEGRATORS[name].order, abs=0.1)


@pytest.mark.parametrize("name", ["leapfrog", "position_verlet", "rk2", "rk4", "yoshida4"])
def test_a_wrong_weight_shows_in_the_order(name):
    right = INTEGRATORS[name]
    first, *rest = right.stages
    wrong = replace(right, stages=((first[0] * 0.9, *first[1:]), *rest) if first[0] else ((0.1, *first[1:]), *rest))
    assert measured_order(name, wrong) < right.order - 0.5


def test_swapped_kick_and_drift_lose_the_second_order():
    swapped = replace(INTEGRATORS["leapfrog"], stages=((1.0, 0.0, 0.5),), first_drift=0.0)
    assert measured_order("leapfrog", swapped) < 1.5


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-10), ("f32", 3e-5)])
@pytest.mark.parametrize("name", ["position_verlet", "velocity_verlet", "leapfrog", "yoshida4"])
def test_forward_then_back_returns(name, precision, tolerance):
    """In float32 800 steps of up to three kicks round speeds of up to 10 m/s: sqrt(2400) eps 10."""
    r = np.random.default_rng(0)
    x, v = r.normal(size=(20, 3)), r.normal(size=(20, 3))

    def run(x, v):
        system = ga.ParticleSystem(
            position=x, velocity=v, forces=[ga.forces.Spring(stiffness=3.0), ga.forces.Gravity()], integrator=name
        )
        sim = ga.Simulation({"s": system}, dt=0.01, precision=precision)
        sim.step(400)
        return sim["s"].position, sim["s"].velocity

    there, speed = run(x, v)
    back, reversed_speed = run(there, -speed)
    assert np.abs(back - x).max() <= tolerance
    assert np.abs(reversed_speed + v).max() <= tolerance
    assert np.abs(there - x).max() > 0.1


def test_velocities_stand_at_the_time_of_positions():
    """In free fall both are exact at every step, for every scheme of second order."""
    for name in ("leapfrog", "velocity_verlet", "position_verlet", "rk2", "rk4", "yoshida4", "boris"):
        ball = ga.ParticleSystem(
            position=[[0, 0, 0]], velocity=[[1, 2, 3]], forces=[ga.forces.Gravity((0, -9, 0))], integrator=name
        )
        sim = ga.Simulation({"b": ball}, dt=0.1, precision="f64")
        sim.step(7)
        assert np.allclose(sim["b"].velocity[0], (1, 2 - 6.3, 3), atol=1e-13)
        assert np.allclose(sim["b"].position[0], (0.7, 1.4 - 4.5 * 0.49, 2.1), atol=1e-13)


@pytest.mark.parametrize("name", ["leapfrog", "position_verlet", "rk4", "yoshida4", "euler", "boris"])
def test_order_with_drag_and_a_varying_wind(name):
    """Drag must not lower the order of the composition: symmetric ones keep 2, RK4 keeps 4.

    The closed form of quadratic drag takes its rate at a predicted middle, which is not reversible: yoshida4 falls to 3.
    """
    medium = ga.Medium(field=ga.forces.Vortex(circulation=3.0, core_radius=0.7))
    forces = [ga.forces.Damping(1.5, medium), ga.forces.Drag(linear=0.2, quadratic=0.3), ga.forces.Gravity()]

    def end(dt):
        one = ga.ParticleSystem(position=[[1.0, 0.2, 0]], velocity=[[0, 1, 2]], forces=forces, integrator=name)
        sim = ga.Simulation({"s": one}, dt=dt, precision="f64")
        sim.step(round(1.0 / dt))
        return sim["s"].position[0]

    ends = [end(1 / n) for n in (40, 80, 160, 320)]
    differences = [np.linalg.norm(a - b) for a, b in zip(ends, ends[1:])]
    order = np.log2(differences[-2] / differences[-1])
    expected = 3 if name == "yoshida4" else INTEGRATORS[name].order
    assert order == pytest.approx(expected, abs=0.15)


def test_symplectic_energy_error_stays_bounded_and_eulers_grows():
    def energies(name, periods):
        _, sim = kepler(name, 2 * np.pi / 2000, periods)
        return abs(sim.diagnostics().energy + 0.5)

    for name in SYMPLECTIC:
        assert energies(name, 100.25) < 3 * max(energies(name, 3.25), 1e-12)
    assert energies("euler", 20.25) > 2 * energies("euler", 3.25)


def test_unknown_integrator_names_the_nearest():
    with pytest.raises(ga.UsageError, match="did you mean 'leapfrog'"):
        ga.ParticleSystem(position=np.zeros((1, 3)), integrator="leapfrg")


class Stuck(ga.forces.Driver):
    """A driver that claims to be steady: x = A cos(2 pi f t)."""

    steady = True


def digests(forces, **more):
    """After 32 steps in one launch, one by one, and with the ledger, which takes them one by one too."""
    r = np.random.default_rng(0)
    start = {"position": r.normal(size=(60, 3)), "velocity": r.normal(size=(60, 3)), "forces": forces, **more}
    found = []
    for batch, ledger in ((32, False), (1, False), (32, True)):
        sim = ga.Simulation({"s": ga.ParticleSystem(**start)}, dt=0.01, ledger=ledger)
        for _ in range(32 // batch):
            sim.step(batch)
        found.append(sim.digest())
    return found


@pytest.mark.parametrize("integrator", ["leapfrog", "position_verlet", "semi_implicit_euler"])
def test_what_leapfrog_keeps_from_step_to_step_changes_no_bit(integrator):
    forces = [ga.forces.Spring(stiffness=3.0), ga.forces.PointGravity(GM=1.0, softening=0.1), ga.forces.Drag(0.1, 0.2)]
    flow = ga.Medium(field=ga.forces.Vortex(circulation=3.0))
    assert len(set(digests(forces, medium=flow, integrator=integrator))) == 1


def test_a_force_that_is_not_steady_is_not_kept():
    assert len(set(digests([ga.forces.Driver(1.0, 2.0)]))) == 1
    assert len(set(digests([Stuck(1.0, 2.0)]))) == 2  # the mutant


PAGE = (Path(__file__).resolve().parents[2] / "docs" / "integrators.md").read_text(encoding="utf-8")
TABLE = {cells[0].strip("`"): cells[1:] for cells in (
    [cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if line.startswith("| `")
)}  # fmt: skip
LIGHT = 2.0


def test_the_page_says_what_the_integrators_are():
    assert list(TABLE) == list(INTEGRATORS)
    for name, (order, measured, evaluations, _, _, stable, use) in TABLE.items():
        used = INTEGRATORS[name]
        assert int(order) == used.order and float(measured) == pytest.approx(used.order, abs=0.1)
        assert int(evaluations.split()[0]) == len(used.stages)
        assert (
            stable == ("never" if name in ("euler", "rk2") else f"{used.stability_limit:.3g}") and len(use.split()) > 2
        )
    for picture in re.findall(r"\((images/[^)]+)\)", PAGE):
        assert 10_000 < (Path(__file__).resolve().parents[2] / "docs" / picture).stat().st_size < 150_000


def step(name, x, u, steps=1, sign=1.0):
    """Steps of 0.2 in a field that varies, from momenta per mass u to those at the end; with a speed of light for pushers."""
    pusher = bool(INTEGRATORS[name].pusher)
    light = LIGHT if pusher else None
    forces = [ga.forces.CentralForce((0.1, 0.2, -0.3), 1.7, -1.5, 0.4)]
    forces += [ga.forces.MagneticMirror(1.3 * sign, 1.5)] if pusher else [ga.forces.HeightGravity(1.0, 2.0, (0, -3, 0))]
    v = u / np.sqrt(1 + (u**2).sum(1, keepdims=True) / LIGHT**2) if pusher else u
    system = ga.ParticleSystem(
        position=x, velocity=v, charge=1.0, forces=forces, integrator=name, speed_of_light=light
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=0.2, precision="f64")
    sim.step(steps)
    v = sim["s"].velocity
    return sim["s"].position, v / np.sqrt(1 - (v**2).sum(1, keepdims=True) / LIGHT**2) if pusher else v


@pytest.mark.parametrize("name", INTEGRATORS)
def test_reversible_and_symplectic_are_as_the_page_says(name):
    """Back after turning round, to round-off; M^T J M = J, or det M = 1, of the step's Jacobian M by differences."""
    symplectic, reversible = TABLE[name][3:5]
    x, u = np.array([[0.6, -0.4, 0.7]]), np.array([[0.9, 0.5, -0.8]])
    there, fast = step(name, x, u, 10)
    back, _ = step(name, there, -fast, 10, -1.0)
    assert (np.abs(back - x).max() <= 1e-12) == (reversible == "yes")
    h = 1e-4
    moved = np.concatenate([np.eye(6), -np.eye(6)]) * h
    X, U = step(name, x + moved[:, :3], u + moved[:, 3:])
    ends = np.concatenate([X, U], 1)
    M = ((ends[:6] - ends[6:]) / (2 * h)).T
    J = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])
    assert (np.abs(M.T @ J @ M - J).max() <= 1e-6) == (symplectic == "yes")
    assert (abs(np.linalg.det(M) - 1) <= 1e-6) == (symplectic != "no")
