"""Periodic boxes: positions modulo the box, contacts across its sides, what is conserved, what is refused."""

import math
import subprocess
import sys

import numpy as np
import pytest

import gen_art as ga
from gen_art.interactions.base import ForceRequest
from gen_art.particles.periodic_box import PeriodicBox

Contacts = ga.interactions.Contacts
LOW, HIGH = np.array([-0.3, 0.1, 2.0]), np.array([0.9, 0.8, 3.3])
LENGTHS = HIGH - LOW
INTEGRATORS = ("euler", "semi_implicit_euler", "rk2", "rk4", "leapfrog", "position_verlet", "yoshida4", "boris")


def domain(axes="xyz", low=LOW, high=HIGH):
    return {"periodic": {"min": list(low), "max": list(high), "axes": axes}}


def simulated(x, v, dt, precision="f64", axes="xyz", box=(LOW, HIGH), ledger=False, **parts):
    system = ga.ParticleSystem(position=x, velocity=v, **parts)
    space = None if box is None else domain(axes, *box)
    return ga.Simulation({"s": system}, dt=dt, precision=precision, domain=space, ledger=ledger)


def apart(a, b, axes="xyz", lengths=LENGTHS):
    """Differences (n, 3) of places, by nearest images along the periodic axes."""
    d = np.asarray(a, float) - b
    for c, axis in enumerate("xyz"):
        if axis in axes:
            d[:, c] -= lengths[c] * np.round(d[:, c] / lengths[c])
    return d


def inside(x, axes="xyz"):
    """Whether min <= x < max holds exactly, compared in float64."""
    x = np.asarray(x, np.float64)
    return all(((x[:, c] >= LOW[c]) & (x[:, c] < HIGH[c])).all() for c in range(3) if "xyz"[c] in axes)


# positions


@pytest.mark.parametrize("axes", ["xyz", "x", "y", "z", "xy", "zx"])
@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_uniform_motion_is_modulo_the_box(precision, axes):
    """x(t) = min + (x0 + v t - min) mod L: in batches, at once, slowly, and by several lengths of the box a step.

    A step rounds the position, its way and the wrap by eps / 2 of the longest of them each: 3 eps of it a step at the most;
    and the length of the box is rounded once, for each of the lengths that are passed.
    """
    r = np.random.default_rng(1)
    x, v = r.uniform(LOW, HIGH, (200, 3)), r.normal(size=(200, 3)) * np.repeat([0.1, 1.0, 60.0, 400.0], 50)[:, None]
    dt, steps = 1 / 64, 150
    x, v = np.float32(x).astype(float), np.float32(v).astype(float)  # what float32 starts with
    sim = simulated(x, v, dt, precision, axes)
    sim.step(7)
    sim.step(steps - 7)
    eps = np.finfo(sim.dtype).eps
    longest = np.abs(v).max(axis=1, keepdims=True) * dt + np.abs([LOW, HIGH]).max()
    if axes != "xyz":
        longest = longest * steps  # along open axes they fly on
    passed = np.abs(v) * dt * steps
    assert (np.abs(v) * dt > 3 * LENGTHS).any() and (passed < LENGTHS).any()
    assert (
        np.abs(apart(sim["s"].position, x + v * dt * steps, axes)) <= 3 * eps * steps * longest + eps * passed
    ).all()
    assert inside(sim["s"].position, axes)
    assert (sim["s"].velocity == v).all()


def test_without_wrapping_that_test_fails():
    """The mutant: the same motion in open space leaves the box."""
    r = np.random.default_rng(1)
    sim = simulated(r.uniform(LOW, HIGH, (50, 3)), r.normal(size=(50, 3)), 1 / 64, box=None)
    sim.step(150)
    assert not inside(sim["s"].position)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("forces", [(), (ga.forces.CurlNoise(strength=3.0, scale=0.3, speed=1.0),)])
def test_every_scheme_stays_in_the_box(integrator, forces):
    r = np.random.default_rng(2)
    system = ga.ParticleSystem(
        position=r.uniform(-5, 5, (300, 3)),
        velocity=r.normal(size=(300, 3)),
        integrator=integrator,
        forces=list(forces),
    )
    sim = ga.Simulation({"s": system}, dt=0.02, domain=domain(), advice="none")
    assert inside(sim["s"].position)  # from the start: those that were given outside are wrapped
    for _ in range(5):
        sim.step(13)
        assert inside(sim["s"].position)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_upper_side_is_never_reached(dtype):
    """Numbers next to the sides, and tiny negative ones, which a subtraction rounds up to max."""
    for low, high in ((0.0, 1.0), (0.0, 0.1), (-0.7, 0.3), (0.7, 1.0), (1e-3, 1e3), (-1.0, 0.0)):
        box = PeriodicBox((low,) * 3, (high,) * 3)
        near = [
            dtype(low),
            dtype(high),
            dtype(0),
            dtype(-1e-30),
            dtype(low - (high - low)),
            dtype(high + 2 * (high - low)),
        ]
        x = np.array([np.nextafter(n, dtype(side)) for n in near for side in (-np.inf, np.inf)] + near, dtype)
        x[np.abs(x) < np.finfo(dtype).tiny] = 0  # kernels take these for 0
        start = x.astype(float)
        system = ga.ParticleSystem(position=np.repeat(start[:, None], 3, 1))
        precision = "f32" if dtype == np.float32 else "f64"
        sim = ga.Simulation({"s": system}, dt=1.0, precision=precision, domain=domain("xyz", (low,) * 3, (high,) * 3))
        state = sim.systems["s"]
        for wrapped_by in ("NumPy", "kernel"):
            at = sim["s"].position.astype(float)
            assert ((at >= low) & (at < high)).all(), wrapped_by
            off = (at[:, 0] - start) / (high - low)
            assert np.abs(off - np.round(off)).max() <= 8 * np.finfo(dtype).eps * max(
                1, np.abs(start).max() / (high - low)
            )
            before = at
            sim.step()
            assert (sim["s"].position == before).all()  # at rest: a place in the box stays as it is
            state.floats[:3, : len(x)] = x
            sim.step()
        y = x.copy()[None].repeat(3, 0)
        box.wrap(y)
        assert (y[0] == sim["s"].position[:, 0]).all()  # NumPy and the kernel give the same bits


def test_numbers_that_are_not_finite_are_still_noticed():
    sim = simulated([[0, 0.5, 2.5]], [[1.0, 0, 0]], 0.1)
    sim.systems["s"].floats[0, 0] = np.inf
    with pytest.raises(ga.DivergedError):
        sim.step(128)


@pytest.mark.parametrize("integrator", ["position_verlet", "boris", "rk2"])
@pytest.mark.parametrize("ledger", [False, True])
def test_forces_act_at_the_place_in_the_box(integrator, ledger):
    """The middle of this step lies beyond the side, at 1.05: the spring to 0.3 pulls as it does at 0.05."""
    k, h = 2.0, 0.2
    sim = simulated(
        [[0.95, 0.5, 0.5]], [[1.0, 0, 0]], h, box=(np.zeros(3), np.ones(3)), integrator=integrator, ledger=ledger,
        forces=[ga.forces.Spring(stiffness=k, center=(0.3, 0.5, 0.5))],
    )  # fmt: skip
    sim.step()
    assert sim["s"].velocity[0, 0] == pytest.approx(1.0 - h * k * (0.05 - 0.3), rel=1e-12)  # and not 1.05 - 0.3
    if ledger:
        account = sim.ledger()
        assert account.work["s.periodic_boundary"] == pytest.approx(
            0.5 * k * ((sim["s"].position[0, 0] - 0.3) ** 2 - (sim["s"].position[0, 0] + 0.7) ** 2), rel=1e-12
        )


def test_births_outside_are_wrapped():
    preset = ga.load_preset({
        "version": 1, "clock": {"duration": 1, "step": 0.01, "fps": 25},
        "domain": {"periodic": {"min": [0, 0, 0], "max": [1, 1, 1], "axes": "xz"}},
        "forces": {"gravity": [-1, 0, 0]},
        "systems": {
            "a": {"emitters": {"far": {"rate": 500, "shape": {"sphere": 3}, "velocity": [0.3, 0.2, 0]}}},
            "b": {"emitters": {"once": {"count": 50, "shape": [5.25, 7, -3.25]}}, "inherit_forces": False},
            "c": {
                "particle": {"lifetime": 0.1},
                "emitters": {"sparks": {"from": "a.birth", "count": 2, "shape": {"sphere": 2}}},
            },
        },
    })  # fmt: skip
    sim = ga.Simulation(preset, precision="f64", ledger=True)
    assert np.allclose(sim["b"].position, [0.25, 7, 0.75], atol=1e-6)  # at birth, before any step
    sim.advance(0.5)
    for name in "abc":
        x = sim[name].position
        assert len(x) > 40 and ((x[:, [0, 2]] >= 0) & (x[:, [0, 2]] < 1)).all()
    account = sim.ledger()  # a potential is booked as born where the particle is wrapped to
    assert abs(account.residual) < 1e-12 * account.scale
    assert np.abs(sim["a"].position[:, 1]).max() > 1


# contacts


def pair(shift, precision, axis=0):
    """Two spheres that meet off centre along an axis, their velocities and places after it."""
    x, v = np.full((2, 3), 0.5), np.zeros((2, 3))
    x[0, axis], x[1, axis], v[0, axis], v[1, axis] = 0.4, 0.6, 1.0, -1.0
    x[1, (axis + 1) % 3] += 0.03
    sim = simulated(
        x + shift, v, 0.0005, precision, box=(np.zeros(3), np.ones(3)), radius=0.05, mass=[1.0, 2.0],
        interactions=[Contacts(restitution=0.7, friction=0.3, duration=0.02)],
    )  # fmt: skip
    start = sim.diagnostics()
    sim.step(300)
    return sim["s"].velocity.astype(float), sim["s"].position.astype(float), sim.diagnostics(), start


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_collision_across_a_side_is_that_in_the_middle(precision, axis):
    """Positions are rounded by eps / 2 in each of 300 steps: their relative position by 300 eps at the worst.

    The contact, half an oscillation with w T = pi (1.006 with its damping), makes of an error d of the overlap one of the
    velocity of w d = 160/s d, and friction, 0.3 of the force, adds to it: within 200/s d.
    """
    shift = np.zeros(3)
    shift[axis], shift[(axis + 1) % 3], shift[(axis + 2) % 3] = 0.5, 0.49, 0.37
    v, x, end, start = pair(np.zeros(3), precision, axis)
    moved_v, moved_x, moved_end, _ = pair(shift, precision, axis)
    error = 300 * float(np.finfo(precision.replace("f", "float")).eps)
    assert v[0, axis] < -0.5  # they did collide
    assert np.abs(moved_v - v).max() <= 200 * error
    assert np.abs(apart(moved_x, x + shift, lengths=np.ones(3))).max() <= (1 + 200 * 0.15) * error
    assert moved_end.kinetic_energy == pytest.approx(end.kinetic_energy, abs=2 * 3 * 200 * error)
    assert np.abs(moved_end.momentum - start.momentum).max() <= 3 * error


def test_in_open_space_that_pair_never_meets():
    """The mutant: no wrap, no nearest image."""
    x = np.array([[0.9, 0.5, 0.5], [0.1, 0.53, 0.5]])  # where the box puts the pair
    sim = simulated(
        x, [[1.0, 0, 0], [-1.0, 0, 0]], 0.0005, box=None, radius=0.05, mass=[1.0, 2.0],
        interactions=[Contacts(restitution=0.7, friction=0.3, duration=0.02)],
    )  # fmt: skip
    sim.step(300)
    assert (sim["s"].velocity[:, 0] == [1, -1]).all()


def crowd(n=300, seed=3):
    r = np.random.default_rng(seed)
    return r.uniform(LOW, HIGH, (n, 3)), r.uniform(0.03, 0.1, n), r.uniform(1, 2, n)


@pytest.mark.parametrize("axes", ["xyz", "x", "y", "z", "xz"])
def test_forces_are_those_of_nearest_images(axes):
    """Against all pairs in NumPy, with positions up to three boxes away, as they may be within a step."""
    x, radius, m = crowd()
    n, T = len(x), 1.0
    contacts = Contacts(restitution=1.0, duration=T)
    system = ga.ParticleSystem(position=x, radius=radius, mass=m, interactions=[contacts])
    sim = ga.Simulation({"s": system}, dt=0.01, precision="f64", domain=domain(axes), advice="none")
    state, out = sim.systems["s"], np.zeros((3, sim.systems["s"].floats.shape[1]))
    rows, away = state.floats.copy(), np.random.default_rng(4).integers(-3, 4, (n, 3))
    rows[:3, :n] += (away * LENGTHS * [axis in axes for axis in "xyz"]).T
    contacts.accelerate(ForceRequest(rows, state, n, rows, state, n, 0.01, 0.01, "f64", 0.0), out)

    def expected(axes):
        d = apart((x[:, None] - x[None]).reshape(-1, 3), 0, axes).reshape(n, n, 3)
        distance = np.linalg.norm(d, axis=2)
        overlap = np.maximum(radius[:, None] + radius - distance, 0)
        np.fill_diagonal(overlap, 0)
        k = (math.pi / T) ** 2 / (1 / m[:, None] + 1 / m)
        pull = (k * overlap / np.maximum(distance, 1e-300))[..., None] * d
        return pull.sum(axis=1) / m[:, None], 0.25 * (k * overlap**2).sum()

    a, energy = expected(axes)
    eps = np.finfo(float).eps
    # places three boxes away are rounded there, by 4 of their coordinates' eps; k / m is at most 10/s^2, of at most 60 pairs
    assert np.abs(out[:, :n].T - a).max() <= 60 * 10 * 4 * eps * 8
    assert contacts.energy(state, np.arange(n), "f64") == pytest.approx(energy, rel=1e-12)
    assert np.abs(expected("")[0] - a).max() > 0.1  # the mutant: without images the forces are others
    depth, _ = contacts.overlaps(state, "f64")
    d = apart((x[:, None] - x[None]).reshape(-1, 3), 0, axes).reshape(n, n, 3)
    deepest = radius[:, None] + radius - np.linalg.norm(d, axis=2) - 10 * np.eye(n)
    assert np.allclose(depth, np.maximum(deepest.max(axis=1), 0), atol=1e-12)


def gas(precision="f64", seed=5, per_side=6, ledger=False, shift=0.0, integrator="leapfrog"):
    """216 elastic spheres of one speed in a periodic cube; the mean free path, 1 / (sqrt(2) pi d^2 n), is 0.16 of its side."""
    r = np.random.default_rng(seed)
    at = (np.arange(per_side) + 0.5) / per_side
    x = np.stack(np.meshgrid(at, at, at), -1).reshape(-1, 3)
    v = r.normal(size=x.shape)
    v /= np.linalg.norm(v, axis=1)[:, None]
    return simulated(
        x + shift, v, 2.5e-4, precision, box=(np.zeros(3), np.ones(3)), ledger=ledger, radius=0.04, integrator=integrator,
        interactions=[Contacts(restitution=1.0, duration=5e-3)],
    )  # fmt: skip


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_gas_keeps_momentum_and_energy(precision):
    """Momentum to round-off: 216 velocities of about 1 m/s are rounded by eps / 2 in 1200 kicks, sqrt(2.6e5) eps / 2 in all;
    five times that is allowed. Of a contact of 20 steps, w dt = pi / 20, leapfrog's energy oscillates by (w dt)^2 / 4 of it."""
    sim = gas(precision, ledger=True)
    start = sim.diagnostics()
    sim.step(600)
    end, account = sim.diagnostics(), sim.ledger()
    eps, allowed = float(np.finfo(sim.dtype).eps), (math.pi / 20) ** 2 / 4
    assert np.abs(end.momentum - start.momentum).max() < 5 * math.sqrt(216 * 1200) * eps / 2
    assert end.energy == pytest.approx(start.energy, rel=allowed)
    assert abs(account.residual) <= allowed * account.scale
    assert (np.abs(sim["s"].velocity - np.asarray(gas(precision)["s"].velocity)).max(axis=1) > 0.1).mean() > 0.2


@pytest.mark.proof
def test_a_gas_comes_to_maxwells_distribution_and_pressure():
    """Maxwell's speeds, and by the virial the pressure of hard spheres, after Carnahan & Starling.

    Z - 1 = sum r.F / (3 N k T). Spheres overlap by v T / pi, 3 % of their diameter, which takes up to 5 % of it; a thousand
    samples of some three contacts have a standard deviation of 2 %.
    """
    from tests.physics.test_gases import kolmogorov_smirnov

    sim, n = gas(), 216
    start, speeds, virials, energies = np.linalg.norm(sim["s"].velocity, axis=1), [], [], []
    for k in range(1200):
        sim.step(20)
        if k < 200:
            continue
        x = sim["s"].position
        d = apart((x[:, None] - x[None]).reshape(-1, 3), 0, lengths=np.ones(3)).reshape(n, n, 3)
        distance = np.linalg.norm(d, axis=2) + np.eye(n)
        virials.append(0.5 * (np.maximum(0.08 - distance, 0) * distance).sum() * 0.5 * (math.pi / 5e-3) ** 2)
        if k % 100 == 0:  # every half a second, three collisions
            speeds.append(np.linalg.norm(sim["s"].velocity, axis=1))
            energies.append(0.5 * (speeds[-1] ** 2).sum())
    width = math.sqrt(2 * np.mean(energies) / 3 / n)

    def maxwell(u):
        w = u / width
        return math.erf(w / math.sqrt(2)) - math.sqrt(2 / math.pi) * w * math.exp(-w * w / 2)

    assert kolmogorov_smirnov(np.concatenate(speeds), maxwell) > 0.01
    assert kolmogorov_smirnov(start, maxwell) < 1e-6  # the same test refuses the speeds of the start
    eta = n * math.pi / 6 * 0.08**3
    excess = (1 + eta + eta**2 - eta**3) / (1 - eta) ** 3 - 1
    assert np.mean(virials) / (2 * np.mean(energies)) == pytest.approx(excess, rel=0.05 + 3 * 0.02)


def test_moving_the_gas_changes_nothing():
    """The same physics wherever the box is cut, as far as round-off grows: a collision turns an error d of the place into an
    angle of 2 d / 0.08 m, and over a free path of 0.16 m into 4 d; 20-fold for grazing ones, of which three are in a row at most.
    """
    here, there = gas(), gas(shift=np.array([0.31, 0.77, -0.42]))
    here.step(600)
    there.step(600)
    error = 600 * np.finfo(float).eps * 20**3
    assert np.abs(there["s"].velocity - here["s"].velocity).max() < 100 * error
    moved = apart(there["s"].position, here["s"].position + [0.31, 0.77, -0.42], lengths=np.ones(3))
    assert np.abs(moved).max() < error


# the ledger


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_wrapping_does_no_work_but_the_jump_of_a_potential(integrator):
    """A fall along a periodic axis: U jumps by m g L each time; the entry holds it, and the ledger closes to round-off."""
    g, length, dt, steps = 3.0, LENGTHS[1], 1 / 64, 200
    sim = simulated(
        [[0.0, 0.5, 2.5], [0.2, 0.3, 2.2]], [[0.5, 0, 0], [0, 1.0, -0.7]], dt, ledger=True, mass=[1.0, 2.0],
        forces=[ga.forces.Gravity((0, -g, 0))], integrator=integrator,
    )  # fmt: skip
    before = sim.diagnostics()
    fallen = np.array([0.5, 0.3]) - sim["s"].position[:, 1]
    sim.step(steps)
    account, after = sim.ledger(), sim.diagnostics()
    order_one = integrator in ("euler", "semi_implicit_euler")  # these fall by g dt t / 2 more or less
    t = steps * dt
    way = 0.5 * g * t * t * np.array([1, 1]) - [0, t] + fallen
    shift = {"euler": -0.5, "semi_implicit_euler": 0.5}.get(integrator, 0) * g * t * dt
    turns = np.round((way + shift - (np.array([0.5, 0.3]) - sim["s"].position[:, 1])) / length)
    assert turns.min() > 10
    booked = account.work["s.periodic_boundary"]
    assert booked == pytest.approx(float(g * length * (turns * [1, 2]).sum()), rel=1e-12)
    assert "s.periodic_boundary" not in account.impulse
    # euler's kinetic energy is not that of its way: it gains m g^2 dt^2 / 2 a step, as in open space
    gained = {"euler": 0.5, "semi_implicit_euler": -0.5}.get(integrator, 0) * 3 * g * g * dt * dt * steps
    assert account.residual == pytest.approx(gained, abs=1e-11 * account.scale)
    assert after.energy - before.energy == pytest.approx(booked + gained, rel=1e-11)
    assert order_one or abs(account.residual) <= 1e-11 * account.scale
    assert (
        abs(account.residual - gained - booked) > 0.5 * account.scale
    )  # the mutant: without the entry it does not close


def test_colliders_and_a_periodic_floor():
    """Balls that bounce on a floor in a box that is periodic along it: as in open space, with x modulo L."""
    r = np.random.default_rng(6)
    x, v = r.uniform(LOW, HIGH, (40, 3)), r.normal(size=(40, 3)) * [2, 0.5, 2]
    x[:, 1] += 0.2
    results = []
    for box in ((LOW, HIGH), None):
        sim = simulated(
            x, v, 1 / 128, axes="xz", box=box, ledger=True, forces=[ga.forces.Gravity((0, -9.81, 0))],
            colliders=[ga.colliders.Plane(point=(0, 0.1, 0), normal=(0, 1, 0), restitution=0.8)],
        )  # fmt: skip
        sim.step(160)
        account = sim.ledger()
        assert abs(account.residual) < 1e-9 * account.scale
        results.append((sim["s"].position, sim["s"].velocity))
    (wrapped, v1), (free, v0) = results
    assert inside(wrapped, "xz") and not inside(free, "xz")
    assert np.abs(apart(wrapped, free, "xz")).max() < 1e-12 and np.abs(v1 - v0).max() < 1e-11


def test_the_path_to_a_wall_goes_on_beyond_the_side():
    """A particle that passes a wall near the side and the side in one step is stopped by the wall."""
    wall = ga.colliders.Plane(point=(0.99, 0, 0), normal=(-1, 0, 0), restitution=1.0)
    sim = simulated([[0.9, 0.5, 0.5]], [[2.0, 0, 0]], 0.1, box=(np.zeros(3), np.ones(3)), radius=0.0, colliders=[wall])
    sim.step()
    assert sim["s"].position[0, 0] == pytest.approx(0.88) and sim["s"].velocity[0, 0] == -2


# the rest of the program


def test_children_of_a_path_follow_it_through_the_side():
    """A parent of several lengths of the box a step leaves children on its line, also where that passes the sides."""
    preset = ga.load_preset({
        "version": 1, "clock": {"duration": 1, "step": 0.05, "fps": 20},
        "domain": {"periodic": {"min": [0, 0, 0], "max": [1, 1, 1]}},
        "systems": {
            "a": {"emitters": {"one": {"count": 1, "shape": [0.2, 0.5, 0.5], "velocity": [13.7, 0, 0]}}},
            "b": {"emitters": {"dots": {"from": "a.path", "rate": 400}}},
        },
    })  # fmt: skip
    sim = ga.Simulation(preset, precision="f64")
    sim.advance(0.5)
    when = (np.arange(sim["b"].count) + 0.5) / 400
    assert len(when) == 200
    line = np.stack([0.2 + 13.7 * when, np.full(200, 0.5), np.full(200, 0.5)], 1)
    assert np.abs(apart(sim["b"].position, line, lengths=np.ones(3))).max() < 1e-12


def test_snapshots_and_digests_carry_the_box(tmp_path):
    sim = gas("f32")
    sim.step(10)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    assert again.box == sim.box and again.digest() == sim.digest()
    sim.step(50)
    again.step(50)
    assert again.digest() == sim.digest()
    x, v = [[0.1, 0.2, 2.5]], [[0.0, 0, 0]]
    digests = {simulated(x, v, 0.1, axes=axes).digest() for axes in ("xyz", "x")} | {
        simulated(x, v, 0.1, box=None).digest()
    }
    assert len(digests) == 3


def test_batches_are_single_steps():
    """64 steps in one launch are 64 launches, to the bit: wrapping happens within the kernel at every step."""
    r = np.random.default_rng(7)
    x, v = r.uniform(LOW, HIGH, (100, 3)), 30 * r.normal(size=(100, 3))
    forces = [ga.forces.CurlNoise(strength=20.0, scale=0.4)]
    once, often = (simulated(x, v, 0.01, "f32", forces=forces, integrator="rk4") for _ in range(2))
    once.step(64)
    for _ in range(64):
        often.step()
    assert once.digest() == often.digest()


THREADS = """
import sys
import numpy as np
import gen_art as ga
r = np.random.default_rng(8)
box = {"periodic": {"min": [0, 0, 0], "max": [1, 1, 1], "axes": "xz"}}
grains = ga.ParticleSystem(
    position=r.uniform(0, 1, (5000, 3)), velocity=r.normal(size=(5000, 3)), radius=r.uniform(0.01, 0.03, 5000),
    interactions=[ga.interactions.Contacts(friction=0.3, spin=True, duration=0.02)], integrator="position_verlet",
    forces=[ga.forces.CurlNoise(scale=0.3)],
)
sim = ga.Simulation({"s": grains}, dt=1e-3, domain=box, threads=int(sys.argv[1]), advice="none", ledger=True)
sim.step(40)
print(sim.digest(), sim.ledger().residual.hex())
"""


def test_any_number_of_threads_gives_the_same_bytes():
    out = [subprocess.run([sys.executable, "-c", THREADS, n], capture_output=True, text=True).stdout for n in "14"]
    assert out[0] == out[1] and len(out[0]) > 64


def test_adaptive_steps_are_wrapped():
    sim = simulated([[0.0, 0.5, 2.5]], [[3.0, -2.0, 1.0]], 0.25)
    ga.adaptive(sim, 2.5)
    assert inside(sim["s"].position)
    assert np.abs(apart(sim["s"].position, [[7.5, -4.5, 5.0]])).max() < 1e-8


def test_curl_noise_says_that_it_jumps():
    system = ga.ParticleSystem(position=[[0, 0.5, 2.5]], forces=[ga.forces.CurlNoise(scale=0.5)])
    with pytest.warns(ga.AdviceWarning, match="curl_noise does not repeat with the periodic box"):
        ga.Simulation({"s": system}, dt=0.01, domain=domain())


# errors


@pytest.mark.parametrize(
    "given,sentence",
    [
        (
            {"min": [0, 0, 0], "max": [1, 0, 1]},
            r"domain.periodic.max: max must be above min along y, not 0 with a min of 0",
        ),
        ({"min": [0, 0, 0], "max": [1, -2, 1]}, r"max must be above min along y, not -2"),
        ({"min": [0, 0, 0], "max": [1, 1, 1], "axes": "xw"}, r"domain.periodic.axes: axes must be some of xyz.*'xw'"),
        ({"min": [0, 0, 0], "max": [1, 1, 1], "axes": "xx"}, r"axes must be some of xyz, each once"),
        ({"min": [0, 0, 0], "max": [1, 1, 1], "axes": ""}, r"axes must be some of xyz"),
        (
            {"min": [0, 0, 0], "max": [1, 1, 1], "axes": 3},
            r"domain.periodic.axes: must be some of xyz, such as xy, not 3",
        ),
        ({"min": [0, 0, math.nan], "max": [1, 1, 1]}, r"domain.periodic.min"),
        ({"min": [0, 0, 0], "max": [1, 1, math.inf]}, r"domain.periodic.max"),
        ({"min": [0, 0, 0]}, r"domain.periodic.max: is missing"),
        ({"min": [0, 0], "max": [1, 1, 1]}, r"domain.periodic.min"),
        ({"min": [0, 0, 0], "max": [1, 1, 1], "axis": "x"}, r"unknown key.*axes"),
        ([1, 2], r"must be a mapping of keys"),
    ],
)
def test_what_is_no_box_is_refused(given, sentence):
    with pytest.raises(ga.UsageError, match=sentence):
        ga.Simulation({"s": ga.ParticleSystem(position=[[0, 0, 0]])}, dt=0.1, domain={"periodic": given})


@pytest.mark.parametrize(
    "given,sentence", [({}, "periodic"), (3, "must be a mapping"), ({"period": {}}, "unknown key")]
)
def test_what_is_no_domain_is_refused(given, sentence):
    with pytest.raises(ga.UsageError, match=sentence):
        ga.Simulation({"s": ga.ParticleSystem(position=[[0, 0, 0]])}, dt=0.1, domain=given)


def test_open_axes_need_no_length():
    sim = simulated([[5.0, 3, 7]], [[0.0, 0, 0]], 0.1, axes="x", box=([0, 0, 0], [1, 0, 0]))
    assert (sim["s"].position == [[0, 3, 7]]).all()


@pytest.mark.parametrize(
    "interaction",
    [
        ga.interactions.SelfGravity(softening=0.1), ga.interactions.Coulomb(softening=0.1),
        ga.interactions.PairForce(strength=1.0, exponent=-2, softening=0.1), ga.interactions.Springs(pairs=[[0, 1]]),
    ],
)  # fmt: skip
def test_other_interactions_are_refused(interaction):
    system = ga.ParticleSystem(position=[[0, 0.5, 2.5], [0.1, 0.5, 2.5]], interactions=[interaction])
    with pytest.raises(
        ga.UsageError,
        match=rf"^{interaction.name} does not act across the sides of a periodic box \(these do: contacts\b.*\): leave out",
    ):
        ga.Simulation({"s": system}, dt=0.01, domain=domain())


def test_a_box_that_is_too_short_is_refused():
    system = ga.ParticleSystem(position=[[0, 0.5, 2.5]], radius=0.12, interactions=[Contacts()])
    with pytest.raises(ga.UsageError, match=r"reach 0.24 m.*at least 3 times as long, 0.72 m: along y it is 0.7 m"):
        ga.Simulation({"s": system}, dt=0.01, domain=domain())
    system = ga.ParticleSystem(position=[[0, 0.5, 2.5]], radius=0.12, interactions=[Contacts()])
    ga.Simulation({"s": system}, dt=0.01, domain=domain("xz"))


def test_a_box_that_float32_cannot_hold_is_refused():
    box = ([1e9, 0, 0], [1e9 + 1, 1, 1])
    with pytest.raises(ga.UsageError, match=r"float32 are 64 m apart.*use precision f64"):
        simulated([[0.0, 0, 0]], [[0.0, 0, 0]], 0.1, "f32", box=box)
    simulated([[0.0, 0, 0]], [[0.0, 0, 0]], 0.1, "f64", box=box)


PRESET = """\
version: 1
clock: {duration: 1, step: 0.01, fps: 25}
domain:
  periodic: {min: [0, 0, 0], max: [1, 1, 1]%s}
systems:
  s:
    particle: {radius: %s}
    emitters: {one: {count: 9, shape: {sphere: 3}}}
    interactions: {%s: {}}
"""


@pytest.mark.parametrize(
    "more,radius,interaction,line,sentence",
    [
        ("", 0.1, "self_gravity", 9, "self_gravity does not act across"),
        ("", 0.2, "contacts", 9, "at least 3 times as long, 1.2 m: along x it is 1 m"),
        (", axes: xq", 0.1, "contacts", 4, "axes must be some of xyz"),
    ],
)
def test_a_preset_says_where(more, radius, interaction, line, sentence):
    from gen_art.preset.load import validate
    from gen_art.preset.reader import read_text

    text = read_text(PRESET % (more, radius, interaction), "box.yaml")
    with pytest.raises(ga.PresetError, match=sentence) as error:
        validate(text.plain(), "box", text, [])
    assert f"box.yaml:{line}:" in str(error.value)


def test_a_preset_has_its_own_domain():
    from gen_art.preset.reader import read_text

    preset = ga.load_preset(read_text(PRESET % (", axes: yx", 0.1, "contacts"), "box.yaml").plain())
    sim = ga.Simulation(preset, advice="none")
    assert sim.box == PeriodicBox((0, 0, 0), (1, 1, 1), "yx")
    assert preset.resolved()["domain"]["periodic"]["axes"] == "yx"  # so recipes and snapshots have it
    with pytest.raises(ga.UsageError, match="a preset has its space in itself"):
        ga.Simulation(preset, domain=domain())


def test_a_system_keeps_the_space_of_its_simulation():
    """A system that a simulation has is not moved into a box by another one, and a box is not left behind in an interaction."""
    contacts = Contacts(duration=0.02)
    first = ga.Simulation(
        {"s": ga.ParticleSystem(position=[[0, 0.5, 2.5]], radius=0.05, interactions=[contacts])},
        dt=1e-3,
        domain=domain(),
    )
    with pytest.raises(ga.UsageError, match="already part of a simulation"):
        ga.Simulation({"s": first["s"]}, dt=1e-3, domain=domain("x"))
    assert first["s"].box == first.box and first.box.axes == "xyz"
    x = [[-0.29, 0.5, 2.5], [0.89, 0.5, 2.5]]  # apart in open space, in touch across the side of the box
    again = ga.ParticleSystem(position=x, radius=0.05, interactions=[contacts])
    sim = ga.Simulation({"s": again}, dt=1e-3)
    sim.step(5)
    assert not sim["s"].velocity.any()
