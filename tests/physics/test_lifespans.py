"""Steps without births and deaths have kernels of their own, with the bits of the others; and the dead are removed in order."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.backend.runtime import ti
from gen_art.emitters.schedule import Rate
from gen_art.particles.compaction import compact, slots_of_living
from gen_art.particles.rows import FIRST_ATTRIBUTE, LIFETIME
from gen_art.particles.storage import Particles

F = ga.forces


@ga.force("test_ageing")
class Ageing(ga.Force):
    """Its acceleration depends on the age, the time and the place."""

    strength: float = ga.param(1.0)

    @ti.func
    def acceleration(self, p, t, q):
        return ti.Vector([q.strength * p.age, t, p.age * p.position[0]])


DAMPED = [F.Gravity(), F.Damping(0.3), F.Damping(0.2)]
SYSTEMS = {
    "damping": {"forces": DAMPED},
    "damping in a flow": {"forces": DAMPED, "medium": ga.Medium(field=F.Vortex(circulation=3.0))},
    "drag": {"forces": [F.Gravity(), F.Damping(0.3), F.Drag(0.1, 0.2)]},
    "age": {"forces": [Ageing(2.0), F.CurlNoise(strength=1.0, speed=0.5, octaves=2)]},
    "noise": {"forces": [F.Langevin(temperature=1e22, friction=2.0), F.Damping(0.3)]},
    "engine": {"forces": [F.Thrust(direction=(0, 1, 0), exhaust_speed=2.0, mass_rate=0.3, duration=0.2)]},
    "magnet": {"forces": [F.MagneticField((0, 0, 2.0)), F.Damping(0.3)], "charge": 1.0},
    "ball": {"forces": DAMPED, "colliders": [ga.colliders.Sphere(radius=0.6, restitution=0.5)]},
}


def digest(name, integrator, fixed, steps=24, batch=8) -> str:
    r = np.random.default_rng(0)
    start = {"position": r.normal(size=(70, 3)) + [2, 0, 0], "velocity": r.normal(size=(70, 3)) - [2, 0, 0]}
    sim = ga.Simulation({"s": ga.ParticleSystem(**start, **SYSTEMS[name], integrator=integrator)}, dt=0.01)
    sim["s"]._state.has_fixed = fixed
    for _ in range(steps // batch):
        sim.step(batch)
    return sim.digest()


@pytest.mark.parametrize(
    "name, integrator",
    [(name, one) for name in SYSTEMS for one in ("leapfrog", "boris", "rk4") if (name, one) != ("noise", "rk4")],
)
def test_a_step_of_particles_that_all_live_has_the_same_bits(name, integrator):
    """Mutants: an age that is half of it; the gain of half a step."""
    assert digest(name, integrator, fixed=False) == digest(name, integrator, fixed=True)


def test_a_fixed_particle_stays_and_one_that_is_born_late_catches_up():
    """Lanes of one tile with steps of different lengths, beside lanes with whole ones. Mutant: whole steps for all."""
    x, v = np.arange(20.0)[:, None] * [1, 0, 0], np.ones((20, 3))
    v[3] = 0
    pair = ga.ParticleSystem(position=x, velocity=v, forces=[F.Damping(0.7)], fixed=[3])
    alone = ga.ParticleSystem(position=x, velocity=v, forces=[F.Damping(0.7)])
    sim = ga.Simulation({"pair": pair, "alone": alone}, dt=0.1)
    sim.step(3)
    assert (sim["pair"].position[3] == x[3]).all()
    others = np.arange(20) != 3
    assert (sim["pair"].position[others] == sim["alone"].position[others]).all()
    state = sim["alone"]._state
    state.birth[5], state.has_fixed = 0.35, True  # born within the next step
    before = state.floats[:6, :20].copy()
    sim.step(1)
    moved = state.floats[0, :20] - before[0]
    assert moved[5] == pytest.approx(before[3, 5] * (1 - np.exp(-0.7 * 0.05)) / 0.7, rel=1e-3)
    assert moved[6] == pytest.approx(before[3, 6] * (1 - np.exp(-0.7 * 0.1)) / 0.7, rel=1e-3)


def test_who_takes_no_step_keeps_the_velocity_beside_those_with_whole_steps():
    """A fixed particle and an unborn one under gravity and damping. Mutant: the gain of a whole step for all lanes of their tile."""
    x, v = np.arange(20.0)[:, None] * [1, 0, 0], np.ones((20, 3))
    v[3] = 0
    system = ga.ParticleSystem(position=x, velocity=v, forces=[F.Gravity(), F.Damping(0.7)], fixed=[3])
    sim = ga.Simulation({"s": system}, dt=0.1)
    state = sim["s"]._state
    state.birth[5] = 10.0
    before = state.floats[:6, :20].copy()
    sim.step(2)
    after = state.floats[:6, :20]
    assert (after[:, [3, 5]] == before[:, [3, 5]]).all()
    assert (after[4, [0, 1, 2, 4, 6]] < before[4, 0] - 1).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("entries", [0, 2])
def test_the_dead_leave_and_the_others_keep_their_order(dtype, entries):
    """Mutant: a column left out, or moved from the back."""
    r = np.random.default_rng(0)
    state = Particles(dtype, ("heat",), capacity=5000, entries=(None,) * entries)
    n = 4321
    columns = state._arrays()
    for column in columns:
        column[..., :n] = r.integers(0, 1000, column[..., :n].shape)
    for keep in (np.flatnonzero(r.random(n) < 0.7), np.arange(7, n), np.arange(n - 7), np.array([], np.int64)):
        expected = [column[..., keep].copy() for column in columns]
        compact(keep.astype(np.int32), *columns)
        assert all((column[..., : len(keep)] == wanted).all() for column, wanted in zip(columns, expected))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", [1, 4095, 4096, 4097, 20_000])
def test_the_slots_of_the_living(n, dtype):
    """Mutants: a chunk's slots written from the start of the next, `>=` for who dies at that time, no limit."""
    rng = np.random.default_rng(n)
    birth, floats = rng.integers(0, 4, n).astype(float), np.zeros((FIRST_ATTRIBUTE, n), dtype)
    floats[LIFETIME] = rng.choice([0.5, 1.0, 2.0, np.inf], n)
    lives = birth + floats[LIFETIME] > 3.0
    living, slots = slots_of_living(floats, birth, n, 3.0, n)
    assert living == lives.sum() and np.array_equal(slots, np.flatnonzero(lives))
    assert slots_of_living(floats, birth, n, 3.0, living - 1) == (living, None)
    assert [len(part) for part in slots_of_living(floats, birth, n, np.inf, n)[1:]] == [0]


def test_a_constant_rate_gives_the_times_of_the_general_formula():
    """Bit for bit: the same rate as two points takes the formula for rates that change. Mutant: births at k / rate."""
    for rate in (3.0, 1 / 3, 16_666.666, 1e9):
        plain, general = Rate(rate, start=0.25), Rate(((0.25, rate), (1e9, rate)), start=0.25)
        assert (plain.times(5, 4000) == general.times(5, 4000)).all()


@pytest.mark.parametrize("emitter", [{"count": 40, "at": [0, 0.0317]}, {"rate": 300, "start": 0.021, "stop": 0.043}])
def test_births_take_the_kernel_with_lifespans_and_nothing_after_them_does(emitter):
    """Bit for bit as when every step has lifespans. Mutant: the other kernel for steps in which somebody is born."""
    piece = {
        "version": 1, "clock": {"duration": 1, "fps": 10, "step": 0.01}, "forces": {"gravity": [0, -9.81, 0], "damping": 0.5},
        "systems": {"s": {"emitters": {"e": {**emitter, "shape": {"sphere": 1}, "velocity": {"sphere": 2}}}}},
    }  # fmt: skip

    def run(fixed, batches):
        sim = ga.Simulation(ga.load_preset(piece))
        sim["s"]._state.has_fixed = fixed
        for steps in batches:
            sim.step(steps)
        return sim.digest(), sim._steppers["s"]._kernels.keys()

    plain, kernels = run(False, [20, 20])
    assert plain == run(True, [20, 20])[0] == run(False, [1] * 40)[0]
    assert set(kernels) == {False, True}
