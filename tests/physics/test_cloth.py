"""Nets by XPBD: one step of a thread against a dense solution, threads and colours, cloth that hangs, tethers, tearing."""

import subprocess
import sys

import numpy as np
import pytest

import gen_art as ga
from gen_art.backend import runtime
from gen_art.interactions.strands import LANES, Strands
from gen_art.interactions.xpbd import sweep

Springs = ga.interactions.Springs


def stepped(x, v, mass, rest, k, c, h, sign=1.0):
    """Velocities after one step of a single thread through x in order: the dense system of its impulses, solved by NumPy."""
    m = len(rest)
    y = x + h * v
    d = np.diff(y, axis=0)
    length = np.linalg.norm(d, axis=1)
    n = d / length[:, None]
    jacobian = np.zeros((m, len(x), 3))  # u = jacobian v
    for e in range(m):
        jacobian[e, e], jacobian[e, e + 1] = -n[e], n[e]
    response = np.einsum("aic,i,bic->ab", jacobian, 1 / mass, jacobian)
    response = np.where(np.eye(m, dtype=bool), response, sign * response)
    K = h * h * k + h * c
    u = np.einsum("eic,ic->e", jacobian, v)
    J = np.linalg.solve(response + np.diag(1 / K), h * (k * (length - rest) + c * u) / K)
    return v - np.einsum("e,eic->ic", J, jacobian) / mass[:, None]


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-11), ("f32", 2e-5)])
@pytest.mark.parametrize("stiffness", [1.0, 1e7])
def test_one_thread_is_solved_exactly(precision, tolerance, stiffness):
    r = np.random.default_rng(4)
    n = 40
    x = np.cumsum(r.normal(size=(n, 3)) * 0.2 + [0.5, 0, 0], axis=0)
    v, mass = r.normal(size=(n, 3)), r.uniform(0.5, 2, n)
    pairs = np.stack([np.arange(n - 1), np.arange(1, n)], 1)
    rest = np.linalg.norm(np.diff(x, axis=0), axis=1) * r.uniform(0.9, 1.05, n - 1)
    k, c, h = stiffness * r.uniform(1, 2, n - 1), r.uniform(0, 0.5, n - 1), 0.01
    floats = np.zeros((10, n + 64), {"f64": np.float64, "f32": np.float32}[precision])
    floats[:3, :n], floats[3:6, :n], floats[6, :n], floats[9] = x.T, v.T, mass, np.inf
    threads = Strands(pairs, np.stack([k, rest, c], 1), n, floats.dtype)
    assert len(threads.colours) == 1
    runtime.init()
    sweep(floats, n, threads, h, precision)
    want = stepped(x, v, mass, rest, k, c, h)
    found = floats[3:6, :n].T.astype(float)
    scale = np.abs(want - v).max() + np.abs(v).max()
    assert np.abs(found - want).max() <= tolerance * scale * (1 if precision == "f64" else 10)
    for wrong in (stepped(x, v, mass, rest, k, c, h, -1.0), stepped(x, v, mass, rest * 1.01, k, c, h)):
        assert np.abs(found - wrong).max() > 1e-3 * scale if stiffness > 1 else True


def test_threads_of_a_colour_share_no_particle():
    """Also where a hub has more springs than there are colours, and where rings and loose springs mix with threads."""
    net = ga.cloth((0, 0, 0), (1, 0, 0), (0, -1, 0), 9, 7)
    n = 63 + 90
    ring = np.stack([np.arange(10), (np.arange(10) + 1) % 10], 1) + 63
    hub = np.stack([np.full(75, 63), np.arange(75) + 75], 1)
    pairs = np.concatenate([net.pairs, ring, hub])
    numbers = np.random.default_rng(0).uniform(1, 2, (len(pairs), 3))
    threads = Strands(pairs, numbers, n, np.float64)
    assert np.array_equal(threads.numbers.reshape(-1)[threads.places], numbers)
    seen = []
    for begin, end in threads.colours:
        used = np.zeros(n, int)
        for t in range(begin, end):
            mine = set()
            for g in range(threads.tasks[t], threads.tasks[t + 1]):
                nodes = threads.nodes.reshape(-1, LANES)[threads.first[g] : threads.first[g + 1]]
                k = threads.numbers[3 * threads.first[g] : 3 * threads.first[g + 1]].reshape(-1, 3, LANES)[:, 0]
                in_group = []
                for lane in range(LANES):
                    for step in range(1, len(nodes)):
                        if k[step, lane] > 0:
                            seen.append((nodes[step - 1, lane], nodes[step, lane]))
                    in_group += sorted(i for i in set(nodes[:, lane]) if i < n)
                assert len(set(in_group)) == len(in_group)
                mine |= set(in_group)
            used[sorted(mine)] += 1
        assert used.max() == 1  # no two tasks of a colour meet
    assert sorted(seen) == sorted(map(tuple, pairs.tolist()))


def sheet(
    columns=32,
    rows=32,
    dt=1 / 300,
    stiffness=1000.0,
    pinned="top",
    precision="f32",
    forces=(),
    fixed=None,
    ledger=False,
    **more,
):
    net = ga.cloth((-0.5, 0.5, 0), (1, 0, 0), (0, -1, 0), columns, rows, 0.2, 0.05)
    system = ga.ParticleSystem(
        position=net.position, mass=0.2 / len(net.position), forces=[ga.forces.Gravity(), *forces],
        fixed=net.pinned(pinned), interactions=[net.springs(stiffness, 0.0, "xpbd", **more)], integrator="semi_implicit_euler",
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=dt, precision=precision, ledger=ledger), net


@pytest.mark.parametrize("dt", [1 / 60, 1 / 300])
def test_a_cloth_hangs_by_its_threads_without_stretching(dt):
    """The top springs carry all: their strain is load / stiffness, at any step; 0.6 % here."""
    sim, _ = sheet(24, 24, dt, 800.0)
    sim.step(round(2 / dt))
    x = sim["s"].position.reshape(24, 24, 3)
    strain = np.linalg.norm(x[1] - x[0], axis=1) * 23 - 1
    load = 0.2 * 9.81 * 23 / 24 / 24
    assert 0.5 < strain.mean() / (load / 800 * 23) < 1  # diagonals carry the rest
    assert strain.max() < 0.01


def test_tethers_hold_what_sweeps_cannot():
    """A cloth of 96 x 96 by its corners, ten steps a frame: no particle beyond 1 % of its way from a corner; without, far beyond."""
    from gen_art.interactions.adjacency import Adjacency
    from gen_art.interactions.tethers import find_tethers

    found = []
    for tether in (0.01, None):
        sim, net = sheet(96, 96, pinned="corners", tether=tether)
        sim.step(90)
        held = np.zeros(len(net.position), bool)
        held[net.pinned("corners")] = True
        springs = Adjacency(net.pairs, np.stack([net.share, net.rest_length, net.share], 1), len(held), np.float64)
        x = sim["s"].position.astype(float)
        worst = 0.0
        for anchor, way in find_tethers(springs, held, np.float64):
            free = anchor != np.arange(len(held))
            worst = max(worst, (np.linalg.norm(x - x[anchor], axis=1)[free] / way[free]).max())
        found.append(worst)
    assert found[0] < 1.0101 and found[1] > 1.1
    sizes = sorted(way.max() for _, way in find_tethers(springs, held, np.float64))
    assert sizes == pytest.approx([np.sqrt(2)] * 2, rel=1e-6)  # along the diagonal


def test_free_cloth_keeps_its_momentum():
    sim, _ = sheet(20, 20, 1 / 100, 1e5, "none", "f64", ledger=True)
    sim.step(100)
    p = sim.diagnostics().momentum
    assert p == pytest.approx([0, -0.2 * 9.81, 0], abs=1e-13)
    assert abs(sim.ledger().momentum_residual).max() < 1e-13


def chain(tear=0.2, method="explicit", precision="f64", ledger=False, dt=1e-3):
    """Twelve masses hang down; each weighs the same, so the spring at the top has the most to carry and is near breaking."""
    net = ga.chain((0, 0, 0), (0, -1.1, 0), 12)
    system = ga.ParticleSystem(
        position=net.position, velocity=np.linspace(0, 1, 12)[:, None] * [0, -2.0, 0], mass=0.1, fixed=[0],
        forces=[ga.forces.Gravity()], interactions=[net.springs(400.0, 0.3, method, tear=tear)], integrator="semi_implicit_euler",
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=dt, precision=precision, ledger=ledger)


@pytest.mark.parametrize("method", ["explicit", "implicit", "xpbd"])
def test_a_spring_that_is_stretched_too_far_breaks_for_good(method):
    whole, torn = chain(None, method), chain(0.2, method)
    for sim in (whole, torn):
        sim.step(400)
    springs = torn["s"].interactions[0]
    broken = springs.saved_arrays["torn"]
    assert 0 < broken.sum() < 6 and not whole["s"].interactions[0].saved_arrays
    gap = np.linalg.norm(np.diff(torn["s"].position, axis=0), axis=1)
    assert gap[broken].min() > 0.12 and gap[~broken].max() < 0.12  # none that holds is beyond the strain
    y = torn["s"].position[:, 1]
    below = np.flatnonzero(broken)[-1] + 1
    assert y[below] < whole["s"].position[below, 1] - 0.2  # what came off falls
    before, torn_before = torn["s"].velocity[below:].mean(0), broken.sum()
    torn.step(50)
    assert springs.saved_arrays["torn"].sum() == torn_before
    assert torn["s"].velocity[below:].mean(0) == pytest.approx(before + [0, -9.81 * 0.05, 0], abs=1e-9)


def test_the_energy_of_torn_springs_is_booked():
    """It must not stay in the account's residual, which is the scheme's own and falls with the step."""
    residuals, booked = [], []
    for dt in (4e-4, 1e-4):
        sim = chain(0.2, "explicit", ledger=True, dt=dt)
        start = sim.diagnostics().energy
        sim.step(round(0.3 / dt))
        account = sim.ledger()
        assert sim["s"].interactions[0].saved_arrays["torn"].any()
        residuals.append(abs(account.residual))
        booked.append(account.dissipated["s.springs"])
        assert start - sim.diagnostics().energy == pytest.approx(booked[-1], rel=0.05)
    held = 0.5 * 400 * (0.2 * 0.1) ** 2  # of one spring that breaks
    assert residuals[1] < residuals[0] / 3 and residuals[1] < 0.1 * held
    assert min(booked) > held


@pytest.mark.parametrize("method", ["explicit", "xpbd"])
def test_snapshots_and_digests_know_what_is_torn(tmp_path, method):
    sim = chain(0.2, method, "f32")
    sim.step(200)
    torn = sim["s"].interactions[0].saved_arrays["torn"].copy()
    assert torn.any()
    sim.save(tmp_path / "torn.gas")
    again = ga.Simulation.restore(tmp_path / "torn.gas")
    assert again.digest() == sim.digest()
    sim.step(100)
    again.step(100)
    assert again.digest() == sim.digest()
    other = ga.Simulation.restore(tmp_path / "torn.gas")
    other["s"].interactions[0].restore_arrays({"torn": np.zeros_like(torn)}, 0.0)
    assert other.digest() != ga.Simulation.restore(tmp_path / "torn.gas").digest()
    other.step(100)
    assert not np.array_equal(other["s"].position, sim["s"].position)


_RUN = """
import gen_art as ga
net = ga.cloth((0, 0, 0), (1, 0, 0), (0, -1, 0), 70, 60)
system = ga.ParticleSystem(position=net.position, mass=1e-4, forces=[ga.forces.Gravity()], fixed=net.pinned("corners"),
                           interactions=[net.springs(300.0, 0.001, "xpbd", tether=0.02)], integrator="semi_implicit_euler")
sim = ga.Simulation({"s": system}, dt=1 / 200, threads=THREADS)
sim.step(40)
print(sim.digest())
"""


def test_the_same_bits_on_any_number_of_threads():
    digests = set()
    for threads in ("1", "3"):
        done = subprocess.run(
            [sys.executable, "-c", _RUN.replace("THREADS", threads)], capture_output=True, text=True, check=True
        )
        digests.add(done.stdout)
    assert len(digests) == 1


@pytest.mark.parametrize(
    "wanted,sentence",
    [
        (dict(tether=0.1), "tether goes with method 'xpbd'"),
        (dict(tether=0.1, tear=0.2, method="xpbd"), "give tear or tether, not both"),
        (dict(tear=-0.1), "tear must be at least 0"),
    ],
)
def test_tethers_and_tears_that_cannot_be(wanted, sentence):
    with pytest.raises(ga.UsageError, match=sentence):
        Springs([[0, 1]], **wanted)
