"""Block time steps of self-gravity beside shared ones: the same motion, less work where only a few need short steps."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.simulation import block_steps
from tests.threads import digests

I = ga.interactions


def cluster(levels, dt, n=200, softening=0.05, forces=(), precision="f64", ledger=False):
    """A tight pair inside a wide, cold cloud."""
    r = np.random.default_rng(3)
    x, v = 4 * r.normal(size=(n, 3)), 0.1 * r.normal(size=(n, 3))
    x[0], x[1] = (0.06, 0, 0), (-0.06, 0, 0)
    v[0], v[1] = (0, 3.0, 0), (0, -3.0, 0)
    m = np.full(n, 0.05)
    m[:2] = 3.0
    stars = ga.ParticleSystem(
        position=x, velocity=v, mass=m, forces=list(forces), integrator="leapfrog",
        interactions=[I.SelfGravity(G=1.0, softening=softening, method="direct", levels=levels)],
    )  # fmt: skip
    return ga.Simulation({"s": stars}, dt=dt, precision=precision, ledger=ledger, advice="none")


def places(sim, time):
    sim.step(round(time / sim.dt))
    return sim["s"].position


def energy_error(levels, dt):
    """The largest error of the energy of a pair on an ellipse of eccentricity 0.9 over three turns, relative."""
    e = 0.9
    speed = np.sqrt((1 - e) / (1 + e))
    pair = ga.ParticleSystem(
        position=[[0, 0, 0], [1 + e, 0, 0]], velocity=[[0, 0, 0], [0, 0, speed]], mass=[1.0, 1e-12], integrator="leapfrog",
        interactions=[I.SelfGravity(G=1.0, softening=0.01, method="direct", levels=levels)],
    )  # fmt: skip
    sim, worst, start = ga.Simulation({"s": pair}, dt=dt, precision="f64", advice="none"), 0.0, 0.0
    for k in range(round(3 * 2 * np.pi / dt)):
        (x0, x1), v = sim["s"].position, sim["s"].velocity[1]
        energy = 0.5 * v @ v - 1 / np.sqrt((x1 - x0) @ (x1 - x0) + 0.01**2)
        start = energy if k == 0 else start
        worst = max(worst, abs(energy / start - 1))
        sim.step(1)
    return worst


def test_a_close_passage_keeps_its_energy_with_long_steps():
    """Steps of 0.02 lose the orbit; with steps of 0.02 / 16 where they are needed it is as good as with those for all."""
    assert energy_error(0, 0.02) > 0.1
    assert energy_error(4, 0.02) < 1.5 * energy_error(0, 0.02 / 16)


def test_where_none_needs_shorter_steps_they_are_those_of_one_step_for_all():
    """Drifts in parts differ by rounding alone; a mutant that kicks in each part has eight times the force."""
    shared, blocks = (places(cluster(levels, 1e-3, softening=5.0), 0.2) for levels in (0, 3))
    assert np.abs(shared - blocks).max() <= 200 * 8 * np.finfo(float).eps * np.abs(shared).max()


def test_where_all_need_the_shortest_steps_they_are_shared_steps_of_that_length():
    shared, blocks = (places(cluster(*of, softening=1e-7), 0.2) for of in ((0, 1e-3), (3, 8e-3)))
    assert (
        np.abs(shared - blocks).max() <= 1e-9 * np.abs(shared).max()
    )  # a pair turns 1.6 times, and magnifies rounding


def test_a_tight_pair_in_a_wide_cloud_moves_as_with_short_steps_for_all(monkeypatch):
    right = places(cluster(0, 0.04 / 256), 0.4)
    shared, blocks = places(cluster(0, 0.04), 0.4), None
    asked = []
    find = block_steps.BlockSteps._find

    def counted(self, name, k, some, h, time):
        asked.append(200 if some is None else len(some))
        find(self, name, k, some, h, time)

    monkeypatch.setattr(block_steps.BlockSteps, "_find", counted)
    blocks = places(cluster(5, 0.04), 0.4)
    of_pair, of_cloud = (np.abs(blocks - right)[some].max() for some in (slice(2), slice(2, None)))
    assert of_pair < 0.02 < np.abs(shared - right)[:2].max()
    assert of_cloud < 2e-3
    assert sum(asked) < 0.5 * 200 * 320  # of what shared steps of the same length would sum


def test_the_ledger_closes_with_blocks_and_forces_of_all_kinds():
    forces = [ga.forces.Gravity((0, -1.0, 0.5)), ga.forces.Damping(0.3)]
    sim = cluster(4, 0.02, forces=forces, ledger=True)
    start = sim.diagnostics()
    sim.step(20)
    end, account = sim.diagnostics(), sim.ledger()
    scale = (sim["s"].mass * np.linalg.norm(sim["s"].velocity, axis=1)).sum()
    change = end.momentum - start.momentum
    assert np.abs(change - sum(account.impulse.values())).max() <= 1e-11 * scale
    assert np.linalg.norm(change) > 0.1 * scale


SCRIPT = """
import sys
import numpy as np
import gen_art as ga
r = np.random.default_rng(0)
pull = ga.interactions.SelfGravity(G=1e-3, softening=0.02, method="tree", levels=3)
s = ga.ParticleSystem(position=r.normal(size=(3000, 3)), mass=1.0, interactions=[pull], integrator="leapfrog")
sim = ga.Simulation({"s": s}, dt=0.02, threads=int(sys.argv[1]), advice="none")
sim.step(3)
print(sim.digest())
"""


def test_thread_counts_give_the_same_bits():
    runs = digests(SCRIPT)
    assert runs[0] and len(set(runs)) == 1


def test_a_start_in_the_middle_goes_on_as_if_it_had_not_stopped(tmp_path):
    """Levels follow from the accelerations at the start of a step, which a snapshot does not hold."""
    whole = places(cluster(4, 0.02), 0.4)
    sim = cluster(4, 0.02)
    sim.step(10)
    sim.save(tmp_path / "half.npz")
    np.testing.assert_array_equal(places(ga.Simulation.restore(tmp_path / "half.npz"), 0.2), whole)


def test_what_cannot_be_divided_is_a_sentence():
    def sim(**more):
        system = ga.ParticleSystem(position=np.eye(3), **more)
        return ga.Simulation({"s": system}, dt=0.01)

    pull = I.SelfGravity(G=1.0, softening=0.1, levels=2)
    with pytest.raises(ga.UsageError, match="levels need a softening"):
        I.SelfGravity(G=1.0, levels=2)
    with pytest.raises(ga.UsageError, match="needs the integrator leapfrog or velocity_verlet for that, not rk4"):
        sim(interactions=[pull], integrator="rk4")
    with pytest.raises(ga.UsageError, match="which contacts does not allow"):
        sim(interactions=[pull, I.Contacts()], integrator="leapfrog")
