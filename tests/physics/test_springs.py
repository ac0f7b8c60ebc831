"""Springs between pairs: forces against NumPy, modes of a chain, the catenary, momentum and energy, stability, and nets."""

import warnings

import numpy as np
import pytest

import gen_art as ga

Springs = ga.interactions.Springs


def web(n=60, m=200, seed=0):
    r = np.random.default_rng(seed)
    pairs = np.unique(np.sort(r.integers(0, n, (m, 2)), 1), axis=0)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    return r.normal(size=(n, 3)), r.normal(size=(n, 3)), r.uniform(0.5, 2, n), pairs, r.uniform(0.2, 1.5, len(pairs))


def pulls(x, v, m, pairs, rest, k, c):
    """Accelerations and the energy, spring by spring."""
    force, energy = np.zeros_like(x), 0.0
    for (i, j), length in zip(pairs, rest):
        d = x[j] - x[i]
        now = np.linalg.norm(d)
        n = d / now
        f = (k * (now - length) + c * (v[j] - v[i]).dot(n)) * n
        force[i] += f
        force[j] -= f
        energy += 0.5 * k * (now - length) ** 2
    return force / m[:, None], energy


@pytest.mark.parametrize("method", ["explicit", "implicit", "xpbd"])
@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-6), ("f32", 2e-4)])
def test_forces_energy_and_reaction(precision, tolerance, method):
    x, v, m, pairs, rest = web()
    a, energy = pulls(x, v, m, pairs, rest, 3.0, 0.4)
    h = 1e-8 if precision == "f64" else 1e-3
    springs = Springs(pairs, 3.0, rest, 0.4, method)
    system = ga.ParticleSystem(
        position=x, velocity=v, mass=m, interactions=[springs], integrator="semi_implicit_euler"
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=h, precision=precision)
    assert sim.diagnostics().potential_energy == pytest.approx(energy, rel=tolerance)
    sim.step(1)
    found = (sim["s"].velocity.astype(float) - v.astype(sim.dtype)) / h
    bound = tolerance if method == "explicit" else 0.02
    assert np.abs(found - a).max() <= bound * np.abs(a).max()
    for k, c in ((-3.0, 0.4), (3.0, -0.4), (3.3, 0.4)):
        assert np.abs(found - pulls(x, v, m, pairs, rest, k, c)[0]).max() > 2 * bound * np.abs(a).max()
    eps = np.finfo(sim.dtype).eps
    scale = np.abs(m[:, None] * sim["s"].velocity).sum()
    assert np.abs((m[:, None] * (sim["s"].velocity - v)).sum(0)).max() <= 8 * eps * scale


@pytest.mark.parametrize("mode", [1, 2, 5, 8])
def test_chain_has_its_modes(mode):
    """N = 8 masses on 9 springs: w_j = 2 sqrt(k/m) sin(j pi / (2 (N + 1))), along the chain."""
    N, k, m = 8, 40.0, 0.5
    net = ga.chain((0, 0, 0), (N + 1.0, 0, 0), N + 2)
    x = net.position.copy()
    x[:, 0] += 1e-3 * np.sin(mode * np.pi * np.arange(N + 2) / (N + 1))
    w = 2 * np.sqrt(k / m) * np.sin(mode * np.pi / (2 * (N + 1)))
    period = 2 * np.pi / w
    system = ga.ParticleSystem(
        position=x, mass=m, interactions=[net.springs(k)], fixed=net.pinned("ends"), integrator="yoshida4"
    )
    sim = ga.Simulation({"s": system}, dt=period / 128, precision="f64")
    at = 3 if mode != 5 else 1
    sim.step(32)
    before = sim["s"].position[at, 0] - at
    speed = sim["s"].velocity[at, 0]
    # a quarter of a period on, the displacement crosses zero: what is left over the speed is the error in time
    assert abs(before / speed) / (period / 4) < 1e-4
    assert abs(speed) == pytest.approx(abs(x[at, 0] - at) * w, rel=1e-4)


STRING = """
version: 1
clock: {duration: 8, fps: 30, step: 1/480}
forces: {gravity: [0, -9.81, 0]}
systems:
  row:
    particle: {mass: 0.5}
    interactions: {springs: {stiffness: 40, rest_length: 0}}
    integrator: leapfrog
    emitters: {row: {chain: {start: [0, 0, 0], end: [9, 0, 0], count: 10}}}
"""


def sagging(t, stiffness=40.0, N=8, m=0.5):
    """Heights of N masses let go from a straight line, by their modes: a uniform push stirs those of odd j."""
    k, y = np.arange(N + 2), np.zeros(N + 2)
    for j in range(1, N + 1, 2):
        w = 2 * np.sqrt(stiffness / m) * np.sin(j * np.pi / (2 * (N + 1)))
        share = 2 / (N + 1) / np.tan(j * np.pi / (2 * (N + 1)))
        y -= 9.81 * share / w**2 * np.sin(j * np.pi * k / (N + 1)) * (1 - np.cos(w * t))
    return y


def test_a_chain_without_rest_length_has_the_same_modes_across(tmp_path):
    (tmp_path / "a.yaml").write_text(STRING)
    sim = ga.Simulation(ga.load_preset(tmp_path / "a.yaml"), precision="f64")
    sim.step(1000)
    y = sim["row"].position[:, 1]
    assert np.abs(y - sagging(1000 / 480)).max() < 1e-3 * np.abs(y).max()
    assert np.abs(y - sagging(1000 / 480, 40.4)).max() > 3e-3 * np.abs(y).max()  # the mutant: springs 1% off


def test_energy_momentum_and_the_ledger():
    x, v, m, pairs, rest = web()

    def account(dt, damping):
        system = ga.ParticleSystem(
            position=x, velocity=v, mass=m, interactions=[Springs(pairs, 3.0, rest, damping)],
            integrator="leapfrog",
        )  # fmt: skip
        sim = ga.Simulation({"s": system}, dt=dt, precision="f64", ledger=True)
        before = sim.diagnostics()
        sim.step(round(0.4 / dt))
        return before, sim.diagnostics(), sim.ledger()

    residuals = []
    for dt in (0.004, 0.002):
        before, after, ledger = account(dt, 0.0)
        assert np.abs(after.momentum - before.momentum).max() < 1e-12
        assert np.abs(after.angular_momentum - before.angular_momentum).max() < 1e-11
        assert not ledger.dissipated
        residuals.append(abs(ledger.residual))
    assert np.log2(residuals[0] / residuals[1]) == pytest.approx(2, abs=0.35)
    before, after, ledger = account(0.002, 0.5)
    lost = before.energy - after.energy
    assert ledger.dissipated["s.springs"] == pytest.approx(lost, rel=1e-3) and lost > 1


def hung(length=1.3, count=33, stiffness=2e6, dt=1 / 60, seconds=6.0, precision="f64", method="implicit"):
    net = ga.rope((0, 0, 0), (1, 0, 0), count, length)
    system = ga.ParticleSystem(
        position=net.position, mass=0.01, interactions=[net.springs(stiffness, method=method)],
        forces=[ga.forces.Gravity(), ga.forces.Damping(1.0)], fixed=net.pinned("ends"), integrator="semi_implicit_euler",
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=dt, precision=precision)
    sim.step(round(seconds / dt))
    return sim, net


@pytest.mark.parametrize(
    "method,dt,stiffness,precision",
    [
        pytest.param("implicit", 1 / 60, 2e6, "f64", marks=pytest.mark.proof),
        pytest.param("implicit", 1 / 240, 2e6, "f64", marks=pytest.mark.proof),
        ("xpbd", 1 / 120, 2e6, "f64"),
        ("xpbd", 1 / 120, 2e12, "f64"),
        ("xpbd", 1 / 240, 2e5, "f64"),
        ("xpbd", 1 / 120, 2e12, "f32"),
    ],
)
def test_rope_hangs_as_a_catenary(method, dt, stiffness, precision):
    """y = a cosh((x - 1/2) / a) + c with 2 a sinh(1 / (2 a)) = length; its own length is kept within 0.1 %, at any step.

    In float32 alike: what hangs is at rest, so nothing adds up, and eps of a place is 6e-8 m.
    """
    length = 1.3
    sim, net = hung(length, dt=dt, method=method, stiffness=stiffness, precision=precision)
    x = sim["s"].position.astype(float)
    assert np.linalg.norm(np.diff(x, axis=0), axis=1).sum() == pytest.approx(length, rel=1e-3)
    a = 1.0
    for _ in range(200):  # 2 a sinh(1 / (2 a)) falls with a
        a += 0.05 * (2 * a * np.sinh(0.5 / a) - length)
    y = a * (np.cosh((x[:, 0] - 0.5) / a) - np.cosh(0.5 / a))
    assert np.abs(sim["s"].velocity).max() < 3e-3
    assert np.abs(x[:, 1] - y).max() < 2e-3
    assert np.array_equal(x[[0, -1]], net.position[[0, -1]])


@pytest.mark.parametrize("method", ["implicit", "xpbd"])
def test_stiffness_at_rest_depends_on_no_step(method):
    """A weight on a stiff spring: it hangs m g / k below its rest, also where w dt is 60."""
    drops = []
    for dt in (1 / 30, 1 / 480):
        net = ga.chain((0, 0, 0), (0, -1, 0), 2)
        system = ga.ParticleSystem(
            position=net.position, mass=0.3, interactions=[net.springs(1e6, 30.0, method)],
            forces=[ga.forces.Gravity((0, -9.81, 0))], fixed=[0], integrator="semi_implicit_euler",
        )  # fmt: skip
        sim = ga.Simulation({"s": system}, dt=dt, precision="f64")
        sim.step(600)
        drops.append(-1 - sim["s"].position[1, 1])
    assert drops == pytest.approx([0.3 * 9.81 / 1e6] * 2, rel=1e-6)


@pytest.mark.parametrize("method", ["implicit", "xpbd"])
def test_implicit_momentum_and_ledger(method):
    """Free springs far beyond the explicit limit: momentum to round-off, and the energy that the scheme takes is booked."""
    x, v, m, pairs, rest = web()
    system = ga.ParticleSystem(
        position=x, velocity=v, mass=m, interactions=[Springs(pairs, 1e5, rest, 5.0, method)], integrator="semi_implicit_euler"
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=0.05, precision="f64", ledger=True)
    start = sim.diagnostics()
    sim.step(50)
    end, account = sim.diagnostics(), sim.ledger()
    assert np.abs(end.momentum - start.momentum).max() < 1e-10
    assert np.abs(account.momentum_residual).max() < 1e-10
    assert end.energy < start.energy
    assert account.dissipated["s.springs"] > 0.9 * (start.energy - end.energy)  # backward Euler's own, booked
    held, _ = hung(seconds=0.1)
    assert np.isfinite(held["s"].position).all()


@pytest.mark.parametrize("method", ["implicit", "xpbd"])
def test_implicit_ledger_closes_at_order_one(method, monkeypatch):
    """Where the step resolves the swings, what the linearised booking misses falls as dt; booked wrongly it does not fall."""

    def residuals():
        found = []
        for steps in (100, 200, 400):
            x, v, m, pairs, rest = web()
            system = ga.ParticleSystem(
                position=x, velocity=v, mass=m, interactions=[Springs(pairs, 10.0, rest, 5.0, method)],
                integrator="semi_implicit_euler",
            )  # fmt: skip
            sim = ga.Simulation({"s": system}, dt=2.5 / steps, precision="f64", ledger=True)
            sim.step(steps)
            found.append(abs(sim.ledger().residual) / sim.ledger().scale)
        return found

    right = residuals()
    orders = np.log2(np.array(right[:-1]) / right[1:])
    assert orders == pytest.approx([1, 1], abs=0.15)
    honest = Springs.dissipated
    monkeypatch.setattr(Springs, "dissipated", lambda self, *args: 0.95 * honest(self, *args))
    wrong = residuals()
    assert abs(np.log2(wrong[-2] / wrong[-1])) < 0.75


def test_a_spring_that_is_too_stiff_for_the_step_is_a_warning():
    net = ga.chain((0, 0, 0), (9, 0, 0), 10)

    def run(dt, integrator="leapfrog"):
        system = ga.ParticleSystem(
            position=net.position + 1e-6 * np.random.default_rng(0).normal(size=(10, 3)) * [1, 0, 0],
            mass=0.5, interactions=[net.springs(50.0)], integrator=integrator,
        )  # fmt: skip
        sim = ga.Simulation({"s": system}, dt=dt, precision="f64")
        sim.step(400)
        return np.abs(sim["s"].position - net.position).max()  # not reached if the positions leave the finite numbers

    limit = 2 / np.sqrt(4 * 50 / 0.5)  # w_max = 2 sqrt(k / m)
    said = f"longest that is surely stable is {limit:.3g} s"
    with (
        pytest.warns(ga.AdviceWarning, match=said),
        pytest.raises(ga.DivergedError, match=f"most likely because .*{said}"),
    ):
        run(limit * 1.2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run(limit * 0.95) < 1e-4


@pytest.mark.parametrize("integrator", ["euler", "rk2", "rk4", "yoshida4", "leapfrog"])
def test_springs_and_forces_know_one_limit_of_stability(integrator):
    """The warning of a pair of masses on a spring names the step at which w dt is the scheme's limit; w = sqrt(2 k / m)."""
    from gen_art.integrators import INTEGRATORS

    w, limit = np.sqrt(2 * 50.0 / 0.5), INTEGRATORS[integrator].stability_limit

    def made(dt):
        net = ga.chain((0, 0, 0), (1, 0, 0), 2)
        system = ga.ParticleSystem(
            position=net.position, mass=0.5, interactions=[net.springs(50.0)], integrator=integrator
        )
        return ga.Simulation({"s": system}, dt=dt, precision="f64")

    with pytest.warns(UserWarning, match=f"longest that is surely stable is {limit / w:.3g} s"):
        made(max(1.01 * limit / w, 1e-6))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if limit:
            made(0.99 * limit / w)


def test_a_spring_goes_with_the_first_end_that_dies():
    from gen_art.preset import load_preset

    preset = {
        "version": 1, "clock": {"duration": 1, "fps": 25, "step": 0.01},
        "systems": {"s": {
            "integrator": "leapfrog", "interactions": {"springs": {"stiffness": 10, "pairs": [[0, 1]], "rest_length": 0.5}},
            "emitters": {
                "a": {"count": 1, "shape": [0, 0, 0], "lifetime": 0.2}, "b": {"count": 1, "shape": [1, 0, 0]},
            },
        }},
    }  # fmt: skip
    sim = ga.Simulation(load_preset(preset), precision="f64")
    sim.step(20)
    speed = sim["s"].velocity.copy()
    assert sim["s"].count == 1 and abs(speed[0, 0]) > 0.1
    sim.step(20)
    assert np.array_equal(sim["s"].velocity, speed)


@pytest.mark.parametrize("pinned,still", [("top", 8), ("corners", 2), ("none", 0)])
def test_cloth_in_yaml(pinned, still):
    from gen_art.preset import load_preset

    preset = {
        "version": 1, "clock": {"duration": 1, "step": "1/120"}, "medium": {"wind": [0, 0, 3]},
        "forces": {"gravity": [0, -9.81, 0], "drag": {"linear": 0.002}},
        "systems": {"sheet": {
            "integrator": "semi_implicit_euler", "particle": {"mass": 0.002},
            "interactions": {"springs": {"stiffness": 200, "method": "implicit"}},
            "emitters": {"c": {"cloth": {"columns": 8, "rows": 6, "pinned": pinned}}},
        }},
    }  # fmt: skip
    sim = ga.Simulation(load_preset(preset), ledger=True)
    assert sim["sheet"].count == 48
    assert sim.diagnostics().potential_energy == pytest.approx(0, abs=1e-6)
    start = sim["sheet"].position.copy()
    sim.step(60)
    moved = np.abs(sim["sheet"].position - start).max(axis=1)
    assert (moved == 0).sum() == still
    assert sim["sheet"].position[:, 2].max() > 0.1  # the wind blows it out
    assert np.abs(sim.ledger().momentum_residual).max() < 1e-5


def test_snapshots_keep_nets(tmp_path):
    net = ga.cloth((0, 0, 0), (1, 0, 0), (0, -1, 0), 5, 4)
    system = ga.ParticleSystem(
        position=net.position, mass=0.01, forces=[ga.forces.Gravity()], fixed=net.pinned("top"),
        interactions=[net.springs(50.0, 0.01, "implicit")], integrator="semi_implicit_euler",
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=0.01)
    sim.step(5)
    sim.save(tmp_path / "net.gas")
    again = ga.Simulation.restore(tmp_path / "net.gas")
    sim.step(5)
    again.step(5)
    assert sim.digest() == again.digest()


@pytest.mark.parametrize(
    "make,sentence",
    [
        (lambda: Springs(stiffness=1.0, pairs=[[0, 0]]), "joins particle 0 to itself"),
        (lambda: Springs(stiffness=1.0, pairs=[[0, 1], [1, 0]]), "contradict each other: particles 0 and 1"),
        (
            lambda: Springs(stiffness=1.0, pairs=[[0, 1]], rest_length=[1, 2]),
            "rest_length must be one number or 1 of them",
        ),
        (lambda: Springs(stiffness=1.0, pairs=[0, 1]), r"shape \(m, 2\)"),
        (lambda: Springs(stiffness=1.0, share=2.0), "goes with pairs"),
        (lambda: Springs(stiffness=1.0, rest_length=(1.0, 2.0)), "rest_length, without pairs, must be a finite number"),
        (lambda: Springs(stiffness=1.0, rest_length=-1.0), "at least 0"),
        (lambda: ga.rope((0, 0, 0), (1, 0, 0), 5, 0.9), "does not reach over 1 m"),
        (lambda: ga.chain((0, 0, 0), (1, 0, 0), 1), "whole number from 2 to"),
        (lambda: ga.cloth((0, 0, 0), (1, 0, 0), (0, 1, 0), 1, 4), "columns of a cloth must be a whole number from 2"),
        (lambda: ga.chain((0, 0, 0), (1, 0, 0), 3).pinned("top"), "no edge 'top': there are none, start, end, ends"),
    ],
)
def test_bad_nets(make, sentence):
    with pytest.raises(ga.UsageError, match=sentence):
        make()


@pytest.mark.parametrize(
    "wanted,sentence",
    [
        (
            dict(interactions=[Springs(stiffness=1.0, pairs=[[0, 7]])]),
            r"names particle 7, but 's' begins with 3 \(0 to 2\)",
        ),
        (dict(interactions=[Springs()]), "'s' has none; give pairs"),
        (dict(interactions=[Springs(stiffness=1.0, pairs=[[0, 1]])], mass=0.0), "particle 0 of 's' has no mass"),
        (dict(interactions=[Springs([[0, 1]], method="implicit")], integrator="rk4"), "give 's' that integrator"),
        (dict(fixed=[5]), "fixed must be indices from 0 to 2"),
        (dict(fixed=[1], velocity=np.ones((3, 3))), "fixed particles do not move"),
    ],
)
def test_springs_that_cannot_be(wanted, sentence):
    with pytest.raises(ga.UsageError, match=sentence):
        ga.Simulation({"s": ga.ParticleSystem(position=np.eye(3), **wanted)}, dt=0.1)


def test_pairs_of_uneven_length_are_a_sentence():
    with pytest.raises(ga.UsageError, match=r"whole numbers of the shape \(m, 2\); some pair is no pair"):
        Springs(pairs=[[0, 1], [0]])


@pytest.mark.parametrize("name, length", [("chain", 2.0), ("rope", 3.0)])
def test_rows_of_particles_in_yaml_lie_as_the_builders_lay_them(name, length):
    row = {"start": [0, 0, 0], "end": [2, 0, 0], "count": 9, "pinned": "start"}
    piece = ga.load_preset({
        "name": "row", "version": 1, "clock": {"duration": 1, "fps": 10, "step": 0.01},
        "systems": {"row": {
            "interactions": {"springs": {"stiffness": 50}}, "particle": {"mass": 0.1},
            "emitters": {"e": {name: {**row, "length": length} if name == "rope" else row}},
        }},
    })  # fmt: skip
    sim = ga.Simulation(piece, precision="f64")
    net = ga.chain((0, 0, 0), (2, 0, 0), 9) if name == "chain" else ga.rope((0, 0, 0), (2, 0, 0), 9, length)
    assert np.allclose(sim["row"].position, net.position, atol=1e-15)
    assert np.sum(net.rest_length[:8]) == pytest.approx(length)
    moved = np.linalg.norm(np.diff(sim["row"].position, axis=0), axis=1)
    assert moved == pytest.approx(np.full(8, length / 8))
    sim.step(20)
    assert np.array_equal(sim["row"].position[0], net.position[0]), "pinned"
