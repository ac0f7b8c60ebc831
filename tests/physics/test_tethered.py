"""Cords, hands, canopies and what floats: the bungee, drag by hand, the parachute, the floating ball, a load on a rope."""

import math

import numpy as np
import pytest

import gen_art as ga
from tests.physics.probe import probe, states

F = ga.forces
G = 9.81


def stepped(sim, system, steps, every=1):
    """Positions (steps // every, 3) of the last particle of a system, as it goes."""
    found = []
    for _ in range(steps // every):
        sim.step(every)
        found.append(sim[system].position[-1].copy())
    return np.array(found)


def jumper(slack=True, **given):
    """60 kg on a cord of 20 m and 90 N/m, let go where the cord is tied."""
    cord = F.Spring((0.0, 0.0, 0.0), 90.0, 20.0, slack)
    system = ga.ParticleSystem(position=[[0, -1e-9, 0]], mass=60.0, forces=[F.Gravity((0.0, -G, 0.0)), cord])
    return ga.Simulation({"j": system}, dt=0.01, precision="f64", **given)


def deepest(mass, length, stiffness):
    """The greatest stretch x of a cord: m g (L + x) = k x^2 / 2."""
    weight = mass * G
    return (weight + math.sqrt(weight**2 + 2 * stiffness * weight * length)) / stiffness


def test_a_bungee_stretches_as_far_as_its_energy_says():
    sim = jumper(ledger=True)
    fall = stepped(sim, "j", 100)
    assert fall[-1, 1] == pytest.approx(-0.5 * G, rel=1e-9)  # while the cord is slack it falls freely
    depth = -stepped(sim, "j", 600)[:, 1].min()
    assert depth - 20 == pytest.approx(deepest(60.0, 20.0, 90.0), rel=1e-4)
    assert abs(sim.ledger().residual) <= 1e-4 * 60 * G * depth
    rod = jumper(slack=False)  # the mutant: a spring that pushes too
    assert abs(-stepped(rod, "j", 100)[-1, 1] - 0.5 * G) > 1.0


def test_a_slack_cord_s_force_is_minus_its_gradient():
    p, cord = states(), F.Spring((0.1, 0.2, -0.3), 2.5, 1.5, True)
    push, _, _, energy = probe(cord, p)
    r = p.position - np.array([[0.1], [0.2], [-0.3]])
    d = np.linalg.norm(r, axis=0)
    stretch = np.maximum(d - 1.5, 0)
    assert 10 < (stretch > 0).sum() < 54
    assert np.allclose(push, -2.5 * stretch * r / d / p.mass, rtol=1e-13, atol=1e-15)
    assert np.allclose(energy, 1.25 * stretch**2, rtol=1e-13)


def dragged(drag=3.0, stiffness=4.0, speed=2.0, rest=0.5):
    path = {"time": [0.0, 1.0, 30.0], "x": [0.0, 0.0, 29 * speed]}
    system = ga.ParticleSystem(
        position=[[0, 0, 0]], mass=1.5,
        forces=[F.Hand(controls=path, stiffness=stiffness, rest_length=rest), F.Drag(linear=drag)],
    )  # fmt: skip
    return ga.Simulation({"h": system}, dt=0.025, precision="f64", ledger=True)


def test_what_a_hand_drags_lags_by_drag_times_speed_over_stiffness():
    sim = dragged()
    sim.step(40)
    assert sim["h"].position[0, 0] == 0.0  # the hand rests
    sim.step(560)
    x, v = sim["h"].position[0], sim["h"].velocity[0]
    lag = 2.0 * 14.0 - x[0]
    assert lag == pytest.approx(3.0 * 2.0 / 4.0 + 0.5, rel=1e-5)
    assert v == pytest.approx([2.0, 0, 0], abs=1e-5)
    account = sim.ledger()
    power = account.work["h.hand"]
    sim.step(40)
    assert sim.ledger().work["h.hand"] - power == pytest.approx(
        3.0 * 2.0**2, rel=1e-5
    )  # W = c v^2, all of it lost to drag
    wrong = dragged(drag=3.03)  # the mutant: drag that is 1% off
    wrong.step(600)
    assert 28.0 - wrong["h"].position[0, 0] == pytest.approx(2.015, rel=1e-5)


def test_a_sphere_at_the_surface_is_lifted_by_the_part_of_it_under_water():
    """The share of the sphere under water by integrating its slices; the potential by differences of it."""
    sea = F.Buoyancy(1.3, (0.0, -3.0, -4.0), 0.2)
    p = states(400)
    p.radius = p.radius * 2
    up = np.array([0.0, 0.6, 0.8])
    c = (0.2 - up @ p.position) / p.radius
    z = (np.arange(4000) + 0.5) / 2000 - 1  # slices of the unit sphere, from its lowest point
    share = np.array([(0.75 * (1 - z**2) * (z < k)).sum() / 2000 for k in c])
    assert ((share > 0) & (share < 1)).sum() > 50
    push = probe(sea, p)[0]
    expected = 1.3 * 4 / 3 * np.pi * p.radius**3 * share / p.mass * 5.0 * up[:, None]
    assert np.allclose(push, expected, atol=1e-3 * np.abs(expected).max())
    h = 1e-6
    for way in np.eye(3):
        there, back = states(400), states(400)
        there.radius = back.radius = p.radius
        there.position = p.position + h * way[:, None]
        back.position = p.position - h * way[:, None]
        slope = (probe(sea, there)[3] - probe(sea, back)[3]) / (2 * h)
        assert np.allclose(-slope, (push * p.mass).T @ way, atol=1e-7)
    assert np.abs(probe(F.Buoyancy(1.3, (0.0, -3.0, -4.0)), p)[0] - push).max() > 0.1  # the mutant: no surface


def floating(density, start, steps, dt=0.005, forces=()):
    """Heights of a ball of 0.2 m and that density, let go at `start`, in water of 1000 kg/m^3 up to 0."""
    system = ga.ParticleSystem(
        position=[[0, start, 0]], radius=0.2, mass=density * 4 / 3 * math.pi * 0.2**3,
        forces=[F.Gravity((0.0, -G, 0.0)), F.Buoyancy(1000.0, (0.0, -G, 0.0), 0.0), *forces],
    )  # fmt: skip
    sim = ga.Simulation({"b": system}, dt=dt, precision="f64")
    return stepped(sim, "b", steps)[:, 1], sim


def draught(density):
    """Depth of the middle, in radii, of a sphere that floats: (2 + 3c - c^3) / 4 = density / 1000."""
    roots = np.roots([-1.0, 0.0, 3.0, 2.0 - 4 * density / 1000.0])
    return next(float(r.real) for r in roots if abs(r.imag) < 1e-12 and -1 <= r.real <= 1)


@pytest.mark.parametrize("density", [250.0, 600.0])
def test_a_ball_floats_at_its_draught_and_bobs_in_its_time(density):
    c = draught(density)
    heights, _ = floating(density, -0.2 * c + 0.001, 1600)
    y = heights + 0.2 * c
    assert np.abs(y).max() < 1.01e-3
    falls = np.flatnonzero((y[:-1] > 0) & (y[1:] <= 0))
    times = falls + y[falls] / (y[falls] - y[falls + 1])
    period = np.diff(times).mean() * 0.005
    w = math.sqrt(3 * G * 1000.0 * (1 - c**2) / (4 * 0.2 * density))
    assert period == pytest.approx(2 * math.pi / w, rel=1e-3)
    assert abs(period * w / math.sqrt(1 - c**2) - 2 * math.pi) > 1e-2 or abs(c) < 0.1  # the mutant: a box's waterline


def test_what_is_denser_than_water_sinks_at_its_terminal_speed():
    _, sim = floating(1600.0, 0.5, 1600, forces=[F.Drag(cd=0.5, density=1000.0)])
    sinking = math.sqrt(8 * 0.2 * G * (1600.0 / 1000.0 - 1) / (3 * 0.5))
    assert sim["b"].velocity[0, 1] == pytest.approx(-sinking, rel=1e-6)


PIECE = """
version: 1
clock: {duration: 8, fps: 30, step: 1/120}
forces: {gravity: [0, -9.81, 0], damping: 6}
systems:
  cord:
    particle: {mass: 0.1}
    interactions: {springs: {stiffness: 1000}}
    emitters: {rope: {rope: {end: [0, -2, 0], count: 11, pinned: start, load: 1.5}}}
"""


def test_a_load_hangs_on_a_rope_and_stretches_it_by_the_weight_below(tmp_path):
    """Ten springs in a row, each stretched by the weight below it: g (10 load + 45 mass) / k in all."""
    (tmp_path / "a.yaml").write_text(PIECE)
    sim = ga.Simulation(ga.load_preset(tmp_path / "a.yaml"), precision="f64")
    cord = sim["cord"]
    assert cord.mass[-1] == 1.5 and (cord.mass[:-1] == 0.1).all()
    assert np.allclose(cord.attribute("along"), np.linspace(0, 1, 11))
    sim.step(600)
    stretch = -2 - cord.position[-1, 1]
    assert stretch == pytest.approx(G * (10 * 1.5 + 45 * 0.1) / 1000, rel=1e-5)
    assert stretch != pytest.approx(G * 55 * 0.1 / 1000, rel=0.5)  # the mutant: no load


JUMP = """
version: 1
clock: {duration: 8, fps: 30, step: 1/120}
medium: {density: 1.2}
forces: {gravity: [0, -9.81, 0]}
systems:
  jumpers:
    particle: {mass: 90, lifetime: 3.003}
    forces: {drag: {quadratic: 0.25}}
    emitters: {door: {count: 1}}
  canopies:
    particle: {mass: 90}
    forces: {drag: {quadratic: 22}}
    emitters: {core: {from: {event: jumpers.death, inherit: velocity}, count: 1}}
"""


def braked(start, terminal, t):
    """Speed of a fall under quadratic drag, t s after `start` m/s."""
    share = math.tanh(G * t / terminal)
    return terminal * (start + terminal * share) / (terminal + start * share)


def test_a_parachute_that_opens_brakes_a_fall_to_its_own_terminal_speed(tmp_path):
    (tmp_path / "a.yaml").write_text(JUMP)
    sim = ga.Simulation(ga.load_preset(tmp_path / "a.yaml"), precision="f64")
    free, under = (math.sqrt(90 * G / k) for k in (0.25, 22.0))
    sim.step(360)
    assert -sim["jumpers"].velocity[0, 1] == pytest.approx(braked(0.0, free, 3.0), rel=1e-5)
    opened = braked(0.0, free, 3.003)
    sim.step(30)
    assert sim["jumpers"].count == 0
    found = -sim["canopies"].velocity[0, 1]
    assert found == pytest.approx(braked(opened, under, 0.247), rel=1e-4)
    assert found != pytest.approx(braked(opened, free, 0.247), rel=0.1)  # the mutant: a canopy that stays shut
    sim.step(360)
    assert -sim["canopies"].velocity[0, 1] == pytest.approx(under, rel=1e-4)


def test_a_balloon_rises_at_its_terminal_speed_past_the_wind():
    """cd rho pi r^2 v^2 / 2 = (rho V - m) g, and it drifts with the wind."""
    r, mass = 0.2, 0.025
    balloon = ga.ParticleSystem(
        position=[[0, 0, 0]], radius=r, mass=mass, medium=ga.Medium(1.2, (1.5, 0.0, -0.5)),
        forces=[F.Gravity((0.0, -G, 0.0)), F.Buoyancy(1.2, (0.0, -G, 0.0)), F.Drag(cd=0.5)],
    )  # fmt: skip
    sim = ga.Simulation({"b": balloon}, dt=0.02, precision="f64")
    sim.step(400)
    push = (1.2 * 4 / 3 * math.pi * r**3 - mass) * G
    rise = math.sqrt(2 * push / (1.2 * 0.5 * math.pi * r**2))
    assert sim["b"].velocity[0] == pytest.approx([1.5, rise, -0.5], rel=1e-6)
    assert sim["b"].velocity[0, 1] != pytest.approx(math.sqrt(2 * (push + mass * G) / (0.6 * math.pi * r**2)), rel=0.1)
