"""Laws of pairs that a user writes: against NumPy, their own potentials, and the built-in laws."""

import numpy as np
import pytest

import gen_art as ga
from gen_art import ti
from tests.threads import digests

EPS = np.finfo(np.float64).eps


@ga.interaction("lennard_jones_of_tests")
class LennardJones(ga.PairLaw):
    """F = 24 depth (2 s^12 - s^6) r / abs(r)^2, s = size / abs(r), with the potential shifted to 0 at the cutoff."""

    depth: float = ga.param(1.0, unit="J")
    size: float = ga.param(1.0, unit="m")
    cutoff: float = ga.param(2.5, unit="m")
    conservative = True

    @ti.func
    def pair(self, r, v, a, b, t, q):
        s = q.size**2 / r.dot(r)
        s3 = s * s * s
        return 24.0 * q.depth * (2.0 * s3 * s3 - s3) / r.dot(r) * r

    @ti.func
    def potential(self, r, a, b, q):
        s, c = q.size**2 / r.dot(r), (q.size / q.cutoff) ** 6
        s3 = s * s * s
        return 4.0 * q.depth * (s3 * s3 - s3 - c * c + c)


@ga.interaction("charges_of_tests")
class Charges(ga.PairLaw):
    """F = k q_a q_b r / abs(r)^3."""

    k: float = ga.param(1.0, unit="N m^2/C^2")
    sources: str = ga.param(None)
    conservative = True

    @ti.func
    def pair(self, r, v, a, b, t, q):
        return q.k * a.charge * b.charge * r / ti.sqrt(r.dot(r)) ** 3

    @ti.func
    def potential(self, r, a, b, q):
        return q.k * a.charge * b.charge / ti.sqrt(r.dot(r))


@ga.interaction("dashpots_of_tests")
class Dashpots(ga.PairLaw):
    """F = -rate v, between particles closer than the cutoff."""

    rate: float = ga.param(0.5, unit="kg/s")
    cutoff: float = ga.param(1.5, unit="m")
    dissipative = True

    @ti.func
    def pair(self, r, v, a, b, t, q):
        return -q.rate * v


@ga.interaction("growing_of_tests")
class Growing(ga.PairLaw):
    """F = (t, age of b, 0), on the first particle of the two alone."""

    reciprocal = False

    @ti.func
    def pair(self, r, v, a, b, t, q):
        return ti.Vector([t, b.age, 0.0]) * ti.cast(a.charge > 0.0, ti.f32)


def lattice(n=6, spacing=1.2, seed=1, shake=0.05):
    g = np.arange(n) * spacing
    x = np.stack(np.meshgrid(g, g, g), -1).reshape(-1, 3)
    return x + shake * np.random.default_rng(seed).normal(size=x.shape)


def system(x, *laws, speed=0.3, **more):
    velocity = speed * np.random.default_rng(2).normal(size=x.shape)
    return ga.ParticleSystem(position=x, velocity=velocity, interactions=list(laws), integrator="leapfrog", **more)


def separations(x, lengths=None):
    r = x[:, None] - x[None]
    return r if lengths is None else r - lengths * np.floor(r / lengths + 0.5)


def lennard_jones_by_numpy(x, cutoff, lengths=None):
    """(accelerations, energy, sum of the magnitudes of the forces on each) of particles of 1 kg."""
    r = separations(x, lengths)
    r2 = (r**2).sum(-1)
    np.fill_diagonal(r2, np.inf)
    s3 = np.where(r2 < cutoff**2, 1 / r2**3, 0)
    F = (24 * (2 * s3**2 - s3) / r2)[..., None] * r
    c = cutoff**-6.0
    U = np.where(r2 < cutoff**2, 4 * (s3**2 - s3 - c * c + c), 0)
    return F.sum(1), U.sum() / 2, np.sqrt((F**2).sum(-1)).sum(1)


@pytest.mark.parametrize("cutoff, periodic", [(2.5, False), (1.3, False), (50.0, False), (2.5, True), (1.3, True)])
def test_a_kick_and_the_energy_are_those_of_numpy(cutoff, periodic):
    side = 7.6
    box = {"periodic": {"min": [-0.5] * 3, "max": [side - 0.5] * 3, "axes": "xyz"}} if periodic else None
    x, dt = lattice(), 1e-3
    sim = ga.Simulation({"s": system(x, LennardJones(cutoff=cutoff), speed=0)}, dt=dt, precision="f64", domain=box)
    wanted, energy, magnitude = lennard_jones_by_numpy(x, cutoff, side if periodic else None)
    assert abs(sim.diagnostics().energy - energy) <= 216 * 20 * EPS * np.abs(magnitude).sum()
    sim.step(1)
    moved = sim["s"].position - x
    if periodic:
        moved -= side * np.floor(moved / side + 0.5)
    # the first step of leapfrog from rest moves each by a dt^2 / 2; the positions round at their own size
    assert np.abs(moved - wanted * dt**2 / 2).max() <= 8 * EPS * (side + magnitude.max() * dt**2)


def test_an_error_of_one_part_in_a_thousand_in_the_force_would_be_seen():
    x, dt = lattice(), 1e-3
    wanted, _, magnitude = lennard_jones_by_numpy(x, 2.5)
    sim = ga.Simulation({"s": system(x, LennardJones(size=1.001), speed=0)}, dt=dt, precision="f64")
    sim.step(1)
    assert np.abs(sim["s"].position - x - wanted * dt**2 / 2).max() > 100 * 8 * EPS * (8 + magnitude.max() * dt**2)


def test_energy_and_momentum_are_kept_and_the_ledger_closes():
    def error(dt):
        sim = ga.Simulation(
            {"s": system(lattice(), Charges(), charge=np.ones(216))}, dt=dt, precision="f64", ledger=True
        )
        start = sim.diagnostics()
        sim.advance(0.4)
        end = sim.diagnostics()
        assert np.abs(np.subtract(end.momentum, start.momentum)).max() < 1e-11
        assert sim.ledger().work.total == 0.0
        return abs(end.energy - start.energy)

    coarse, fine = error(0.02), error(0.01)
    assert 3 < coarse / fine < 5.5  # of second order


def test_a_law_of_charges_is_the_built_in_one():
    charge = np.where(np.arange(216) % 2, 1.0, -1.0)
    ends = []
    for law in (Charges(k=2.0), ga.interactions.Coulomb(k=2.0, method="direct")):
        sim = ga.Simulation({"s": system(lattice(), law, charge=charge)}, dt=2e-3, precision="f64")
        sim.step(20)
        ends.append(sim["s"].position.copy())
    assert np.abs(ends[0] - ends[1]).max() < 1e-12


def test_sources_of_another_system_act_without_reaction():
    far = ga.ParticleSystem(position=[[0.0, 0, 0], [0, 1, 0]], charge=[1.0, 2.0], integrator="leapfrog")
    near = ga.ParticleSystem(
        position=[[2.0, 0, 0]], charge=[3.0], mass=[2.0], interactions=[Charges(sources="far")], integrator="leapfrog"
    )
    sim = ga.Simulation({"far": far, "near": near}, dt=1e-3, precision="f64")
    sim.step(1)
    wanted = 3 * (np.array([2.0, 0, 0]) / 8 + 2 * np.array([2.0, -1, 0]) / 5**1.5) / 2
    assert np.abs((sim["near"].position[0] - [2, 0, 0]) - wanted * 0.5e-6).max() < 1e-15
    assert (sim["far"].position == [[0, 0, 0], [0, 1, 0]]).all()


def test_dissipated_energy_is_that_which_is_lost():
    sim = ga.Simulation({"s": system(lattice(4), Dashpots())}, dt=1e-3, precision="f64", ledger=True)
    start = sim.diagnostics()
    sim.advance(0.2)
    ledger, end = sim.ledger(), sim.diagnostics()
    lost = start.energy - end.energy
    assert lost > 0.1 * start.energy
    assert ledger.dissipated.total == pytest.approx(lost, rel=1e-10)
    assert ledger.work.total == 0.0
    assert np.abs(np.subtract(end.momentum, start.momentum)).max() < 1e-12


def test_two_particles_come_to_rest_at_the_rate_of_their_reduced_mass():
    two = ga.ParticleSystem(
        position=[[0.0, 0, 0], [1, 0, 0]], velocity=[[1.0, 0, 0], [0, 0, 0]], mass=[1.0, 3.0],
        interactions=[Dashpots(rate=0.5, cutoff=10)], integrator="rk4",
    )  # fmt: skip
    sim = ga.Simulation({"s": two}, dt=0.05, precision="f64")
    sim.advance(1.0)
    v = sim["s"].velocity[:, 0]
    # the local error of rk4 is (k dt)^5 / 120, twenty times
    assert abs(v[0] - v[1] - np.exp(-0.5 * 4 / 3)) < 20 * (0.5 * 4 / 3 * 0.05) ** 5 / 120


def test_a_law_sees_the_time_and_the_age():
    two = ga.ParticleSystem(
        position=[[0.0, 0, 0], [5, 0, 0]], charge=[1.0, 0.0], interactions=[Growing()], integrator="rk4"
    )
    sim = ga.Simulation({"s": two}, dt=0.1, precision="f64")
    sim.advance(1.0)
    assert np.abs(sim["s"].position[0] - [1 / 6, 1 / 6, 0]).max() < 1e-14  # rk4 is exact for a cubic
    assert (sim["s"].position[1] == [5, 0, 0]).all()


def test_a_second_law_sees_the_same_time():
    two = ga.ParticleSystem(
        position=[[0.0, 0, 0], [5, 0, 0]], charge=[1.0, 0.0], interactions=[Growing(), Growing()], integrator="rk4"
    )
    ga.Simulation({"s": two}, dt=0.1, precision="f64").advance(1.0)
    assert np.abs(two.position[0] - [2 / 6, 2 / 6, 0]).max() < 1e-14


def test_numbers_are_run_time_parameters_and_nothing_is_compiled_for_them():
    from gen_art.backend import runtime

    ga.Simulation({"s": system(lattice(), LennardJones(depth=1.0))}, dt=1e-3).step(2)
    before = runtime.compilations()
    ga.Simulation({"s": system(lattice(), LennardJones(depth=2.0, cutoff=2.0))}, dt=1e-3).step(2)
    assert runtime.compilations() == before


def test_the_bits_depend_on_no_thread_count():
    script = """
import sys
import numpy as np
import gen_art as ga
from tests.physics.test_pair_laws import Charges, Dashpots, LennardJones, lattice, system
laws = (LennardJones(), Dashpots(), Charges())
sim = ga.Simulation({"s": system(lattice(8), *laws, charge=np.ones(512))}, dt=1e-3, threads=int(sys.argv[1]))
sim.step(20)
print(sim.digest(), repr(sim.diagnostics().energy))
"""
    assert len(set(digests(script))) == 1


def run(law, **more):
    return ga.Simulation({"s": system(lattice(3), law, **more)}, dt=1e-3)


def test_a_force_without_its_reaction_is_refused():
    class Chase(ga.PairLaw):
        @ti.func
        def pair(self, r, v, a, b, t, q):
            return a.mass * r

    with pytest.raises(
        ga.UsageError, match=r"Chase: action is not reaction between particles 0 and .*reciprocal = False"
    ):
        run(Chase(), mass=np.arange(1.0, 28.0))

    class Declared(ga.PairLaw):
        reciprocal = False

        @ti.func
        def pair(self, r, v, a, b, t, q):
            return a.mass * r

    run(Declared(), mass=np.arange(1.0, 28.0))


@pytest.mark.parametrize("factor", [-1.0, 0.5, 1.01])
def test_a_potential_that_is_not_the_forces_is_refused(factor):
    class Wrong(ga.PairLaw):
        factor: float = ga.param(1.0)
        conservative = True

        @ti.func
        def pair(self, r, v, a, b, t, q):
            return -r

        @ti.func
        def potential(self, r, a, b, q):
            return q.factor * 0.5 * r.dot(r)

    run(Wrong(factor=1.0))
    with pytest.raises(
        ga.UsageError, match=r"Wrong: its potential is not that of its force.*is a sign or a factor missing"
    ):
        run(Wrong(factor=factor))


def test_what_cannot_be_right_is_a_sentence():
    with pytest.raises(ga.UsageError, match=r"Empty needs the method pair"):

        class Empty(ga.PairLaw):
            pass

    with pytest.raises(ga.UsageError, match=r"Bare is declared conservative: it needs a potential"):

        class Bare(ga.PairLaw):
            conservative = True

            @ti.func
            def pair(self, r, v, a, b, t, q):
                return -r

    with pytest.raises(ga.UsageError, match=r"Plain\.pair runs in a kernel: write @ti\.func"):

        class Plain(ga.PairLaw):
            def pair(self, r, v, a, b, t, q):
                return -r

    class Fluffy(ga.PairLaw):
        @ti.func
        def pair(self, r, v, a, b, t, q):
            return -a.fluf * b.fluf * r

    with pytest.raises(ga.UsageError, match=r"Fluffy\.pair reads fluf, .*did you mean 'fluff'"):
        run(Fluffy(), attributes={"fluff": np.ones(27)})
    with pytest.raises(ga.UsageError, match=r"cutoff must be above 0 m"):
        LennardJones(cutoff=0.0)
    with pytest.raises(ga.UsageError, match=r"lennard_jones_of_tests acts with a force.*give it a mass"):
        run(LennardJones(), mass=np.zeros(27))


def test_a_law_is_written_in_a_preset_like_any_other():
    preset = ga.load_preset({
        "version": 1, "clock": {"duration": 0.1, "fps": 10, "step": 0.01},
        "systems": {"s": {
            "emitters": {"start": {"count": 20, "shape": {"sphere": {"radius": 3}}}},
            "interactions": {"lennard_jones_of_tests": {"depth": 2}},
        }},
    })  # fmt: skip
    (law,) = preset.systems["s"].interactions
    assert isinstance(law, LennardJones) and law.values["depth"] == 2
