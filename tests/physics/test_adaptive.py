"""Adaptive steps against Kepler's equation, SciPy's same pair, closed forms and small fixed steps."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import gen_art as ga
from gen_art.integrators import dormand_prince
from gen_art.simulation import adaptive as adaptive_steps
from tests.physics.test_integrators import on_orbit

F, I = ga.forces, ga.interactions


def kepler(rtol, precision="f64", steps=1, e=0.9):
    """The distance from the truth after one period of an orbit with GM = a = 1, and what it took."""
    star = ga.ParticleSystem(
        position=[[1 - e, 0, 0]], velocity=[[0, np.sqrt((1 + e) / (1 - e)), 0]], forces=[F.PointGravity(GM=1.0)]
    )
    sim = ga.Simulation({"star": star}, dt=2 * np.pi / steps, precision=precision)
    effort = ga.adaptive(sim, 2 * np.pi, rtol=rtol, atol=1e-3 * rtol)
    return np.linalg.norm(sim["star"].position[0] - on_orbit(2 * np.pi, e)), effort


def test_an_eccentric_orbit_to_tolerance():
    """e = 0.9: the error of the period follows rtol (the orbit magnifies it some 400 times), the effort rtol^(-1/5)."""
    (rough, few), (fine, many) = kepler(1e-6), kepler(1e-10)
    assert rough <= 1e-3 and fine <= 1e-7 and fine > 1e-10
    assert np.log10(rough / fine) == pytest.approx(4, abs=0.8)
    assert many.evaluations / few.evaluations == pytest.approx(10 ** (4 / 5), rel=0.4)
    assert many.evaluations == 6 * (many.accepted + many.rejected) + 2
    assert many.shortest < 0.01 * many.longest  # quick at pericentre, slow away from it
    assert many.evaluations < 2300  # SciPy's RK45 takes 2210 for 3.5e-8


def test_the_clock_takes_nothing_from_accuracy():
    assert kepler(1e-7, steps=16)[0] == pytest.approx(kepler(1e-7)[0], rel=1)


def test_float32_has_its_own_floor():
    """The state between steps of the clock is float64, what the forces see float32: some 1e4 eps after a period."""
    assert kepler(2e-6, "f32")[0] <= 1e4 * np.finfo(np.float32).eps


BODIES = {
    "position": [[1.0, 0, 0], [-0.6, 0.5, 0.2], [0.1, -1.1, 0.4]],
    "velocity": [[0, 0.8, 0.1], [-0.4, 0, 0.5], [0.3, 0.2, 0]], "mass": [1.0, 2.0, 1.5], "charge": [1.0, -0.5, 2.0],
}  # fmt: skip
FORCES = [
    F.Driver(3.0, 1.3, 0.4, (1.0, 2.0, 2.0)), F.MagneticField((0.3, -1.0, 2.0)), F.Drag(0.1, 0.2), F.Spring(stiffness=6.0)
]  # fmt: skip


def three(adaptive, forces, interactions, precision="f64", rtol=1e-8):
    """(3, 6): positions and velocities of three bodies after 2 s."""
    system = ga.ParticleSystem(**BODIES, forces=forces, interactions=list(interactions), integrator="rk4")
    sim = ga.Simulation({"s": system}, dt=1.0 if adaptive else 4e-3, precision=precision)
    if adaptive:
        ga.adaptive(sim, 2.0, rtol=rtol, atol=rtol * 1e-2)
    else:
        sim.advance(2.0)
    return np.concatenate([sim["s"].position, sim["s"].velocity], axis=1)


PAIRS = [I.SelfGravity(G=1.0, softening=0.1), I.Springs(pairs=[[0, 1], [1, 2]], stiffness=3.0, damping=0.5)]


@cache
def fixed(what):
    return three(False, *((FORCES, []) if what == "forces" else ([], PAIRS)))


@pytest.mark.parametrize("what", ["forces", "interaction"])
def test_agrees_with_small_fixed_steps(what):
    """Time, velocity and drag within one body's forces; gravity and damped springs between bodies."""
    laws = (FORCES, []) if what == "forces" else ([], PAIRS)
    assert np.abs(three(True, *laws) - fixed(what)).max() <= 1e-6  # of rk4
    assert np.abs(three(True, *laws, "f32", 1e-5) - fixed(what)).max() <= 1e-4


def test_agrees_with_scipy():
    """solve_ivp's RK45 is the same pair; DOP853 at 1e-12 is the truth."""
    integrate = pytest.importorskip("scipy.integrate")
    m = np.array(BODIES["mass"])

    def slope(t, y):
        x, v = y.reshape(2, 3, 3)
        d = x[None] - x[:, None]
        a = (m[None, :, None] * d / ((d**2).sum(2) + 0.01)[..., None] ** 1.5).sum(1) - 6.0 * x / m[:, None]
        return np.concatenate([v.ravel(), a.ravel()])

    start = np.concatenate([np.ravel(BODIES["position"]), np.ravel(BODIES["velocity"])])
    solve = lambda method, rtol: integrate.solve_ivp(slope, (0, 2), start, method, rtol=rtol, atol=rtol * 1e-2)  # noqa: E731
    truth = solve("DOP853", 1e-12).y[:, -1].reshape(2, 3, 3)
    theirs = np.abs(solve("RK45", 1e-8).y[:, -1].reshape(2, 3, 3) - truth).max()
    ours = three(True, [F.Spring(stiffness=6.0)], [I.SelfGravity(G=1.0, softening=0.1)], rtol=1e-8)
    assert np.abs(np.stack([ours[:, :3], ours[:, 3:]]) - truth).max() <= 3 * theirs


def test_births_and_deaths_inside_a_step_of_the_clock():
    """Particles are moved from their birth to their death, whatever the clock's step."""
    fountain = {"jet": {"rate": 7, "velocity": {"constant": [0.3, 4, 0]}, "lifetime": 0.9}}
    law = {"central_force": {"strength": 2.0, "exponent": 1}}
    ends = []
    for dt in (1.0, 0.125):
        clock = {"duration": 4, "fps": 1, "step": dt}
        one = {"version": 1, "clock": clock, "forces": law, "systems": {"s": {"emitters": fountain}}}
        sim = ga.Simulation(ga.load_preset(one), precision="f64")
        ga.adaptive(sim, 2.0, rtol=1e-11)
        ends.append(np.concatenate([sim["s"].position, sim["s"].velocity], axis=1))
    assert len(ends[0]) == len(ends[1]) > 4
    assert np.abs(ends[0] - ends[1]).max() <= 1e-9
    w, age = np.sqrt(2.0), sim["s"].age
    assert ends[1][:, 1] == pytest.approx(4 / w * np.sin(w * age), abs=1e-9)


def test_propellant_burns_once():
    rocket = ga.ParticleSystem(position=[[0, 0, 0]], mass=2.0, forces=[F.Thrust((0, 1, 0), 30.0, 0.5, duration=3.0)])
    sim = ga.Simulation({"r": rocket}, dt=1.0, precision="f64")
    ga.adaptive(sim, 3.0)
    assert sim["r"].mass[0] == pytest.approx(0.5, rel=1e-12)
    assert sim["r"].velocity[0, 1] == pytest.approx(30 * np.log(4.0), rel=1e-8)


def test_the_same_bits_again():
    assert np.array_equal(three(True, FORCES, []), three(True, FORCES, []))


@pytest.mark.parametrize("where", ["STAGES", "ERROR", "TIMES"])
def test_a_wrong_number_of_the_pair_is_noticed(where, monkeypatch):
    """The mutants: one weight of the step, of the error or of the times a per cent off."""
    right, right_one = getattr(dormand_prince, where), kepler(1e-4)[1].evaluations
    if where == "STAGES":
        wrong = (*right[:6], (1.01 * right[6][0], *right[6][1:]))
    else:
        wrong = (*right[:4], 1.01 * right[4], *right[5:])
    monkeypatch.setattr(adaptive_steps, where, wrong)
    if where == "ERROR":  # its sum is no longer 0: the estimate sees an error where there is none, and steps are short
        assert kepler(1e-4)[1].evaluations > 2 * right_one
    else:
        assert np.abs(three(True, FORCES, [], rtol=1e-6) - fixed("forces")).max() > 1e-5


def test_what_it_cannot_take_is_a_sentence():
    pair = {"position": np.array([[0.0, 0, 0], [1.0, 0, 0]])}
    springs = I.Springs(pairs=[[0, 1]], method="implicit")
    for more, words in (
        ({"colliders": [ga.colliders.Plane()]}, "colliders"),
        ({"integrator": "vay", "speed_of_light": 3.0}, "speed_of_light"),
        ({"integrator": "semi_implicit_euler", "interactions": [springs]}, "implicit springs"),
    ):
        sim = ga.Simulation({"s": ga.ParticleSystem(**pair, **more)}, dt=0.1)
        with pytest.raises(ga.UsageError, match=f"cannot take system 's': it has .*{words}"):
            ga.adaptive(sim, 0.1)
    sim = ga.Simulation({"s": ga.ParticleSystem(**pair)}, dt=0.1, ledger=True)
    with pytest.raises(ga.UsageError, match="no ledger"):
        ga.adaptive(sim, 0.1)
    sim = ga.Simulation({"s": ga.ParticleSystem(**pair)}, dt=0.1)
    for bad, words in (
        ({"seconds": 0.15}, "nearest"), ({"seconds": 0.1, "rtol": 1e-9}, "rtol must be at least 1.2e-06"),
        ({"seconds": 0.1, "rtol": 1e-4, "atol": -1.0}, "atol"),
    ):  # fmt: skip
        with pytest.raises(ga.UsageError, match=words):
            ga.adaptive(sim, **bad)
    with pytest.raises(ga.UsageError, match="emitters fed by events"):
        ga.adaptive(ga.Simulation(ga.load_preset("fireworks")), 0.1)


def test_a_fall_into_a_singularity_names_the_particle():
    fall = ga.ParticleSystem(position=[[9.0, 0, 0], [1.0, 0, 0]], forces=[F.PointGravity(GM=1.0)])
    sim = ga.Simulation({"s": fall}, dt=4.0, precision="f64")
    before = sim.digest()
    with pytest.raises(ga.UsageError, match=r"below round-off at 1\.11\d* s for particle 1 of 's'.*softening"):
        ga.adaptive(sim, 4.0, rtol=1e-4)
    assert sim.digest() == before


def test_the_code_of_the_page_takes_what_it_says():
    page = (Path(__file__).resolve().parents[2] / "docs" / "integrators.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", page, re.S).group(1)
    names: dict = {}
    exec(code, names)
    said = int(re.search(r"# (\d+) evaluations", code).group(1))
    assert names["effort"].evaluations == pytest.approx(said, rel=0.02)  # another libm may reject another step
    assert np.linalg.norm(names["sim"]["comet"].position[0] - on_orbit(2 * np.pi, 0.9)) < 5e-8
