"""Changes from outside: set, add and remove between steps, what the ledger books of them, and that the run goes on from them."""

import warnings

import numpy as np
import pytest

import gen_art as ga
from gen_art.simulation.coupled_systems import CoupledSystems
from gen_art.simulation.ledger import LedgerKeeper
from gen_art.simulation.watch import Watch
from tests.physics.test_births import BURST, preset

F, I = ga.forces, ga.interactions
N = 24


def arrays(seed=0):
    r = np.random.default_rng(seed)
    return dict(position=r.normal(size=(N, 3)), velocity=r.normal(size=(N, 3)), mass=r.uniform(1, 2, N))


def simulation(given, dt=0.005, precision="f64", ledger=False, **parts):
    return ga.Simulation({"s": ga.ParticleSystem(**given, **parts)}, dt=dt, precision=precision, ledger=ledger)


def states(sim):
    return sim["s"].position.tobytes() + sim["s"].velocity.tobytes()


def test_set_changes_what_is_given_and_nothing_else():
    sim = simulation(arrays(), attributes={"heat": 1.0}, forces=[F.Gravity()])
    s = sim["s"]
    before = {k: getattr(s, k) for k in ("position", "velocity", "mass", "charge", "radius")}
    s.set(velocity=[[1, 2, 3], [4, 5, 6]], charge=0.5, where=[7, 2])  # in the order of `where`
    assert s.velocity[7].tolist() == [1, 2, 3] and s.velocity[2].tolist() == [4, 5, 6]
    others = np.delete(np.arange(N), [2, 7])
    assert np.array_equal(s.velocity[others], before["velocity"][others]) and s.charge.tolist().count(0.5) == 2
    assert all(np.array_equal(getattr(s, k), before[k]) for k in ("position", "mass", "radius"))
    s.set(position=(0, 1, 0), where=s.position[:, 0] > 0)  # by bools, one place for all
    assert np.array_equal((s.position == [0, 1, 0]).all(1), before["position"][:, 0] > 0)
    s.set(mass=3.0, radius=np.arange(N), attributes={"heat": np.arange(N)})
    assert (s.mass == 3).all() and np.array_equal(s.radius, np.arange(N)) and s.attribute("heat")[5] == 5
    s.set(mass=7.0, where=[])
    assert (s.mass == 3).all()


def test_added_particles_are_as_those_of_the_start_and_ids_are_never_used_again():
    sim = simulation(arrays(), attributes={"heat": 1.0})
    s = sim["s"]
    sim.step(3)
    ids = s.add(position=[[1, 2, 3], [4, 5, 6]], velocity=(0, 0, 1), charge=[1, 2])
    assert ids.tolist() == [N, N + 1] == s.ids[-2:].tolist() and s.emitter[-2:].tolist() == ["added"] * 2
    assert s.mass[-2:].tolist() == [1, 1] and s.radius[-1] == 0.01 and s.charge[-2:].tolist() == [1, 2]
    assert s.attribute("heat")[-1] == 0 and s.age[-1] == 0 and s.age[0] == pytest.approx(3 * sim.dt)
    s.remove([*ids, 0])
    assert s.ids.tolist() == list(range(1, N)) and s.count == N - 1
    assert s.add((0, 0, 0)).tolist() == [N + 2]
    assert len(set(s.keys)) == s.count  # random streams of their own
    s.remove(s.ids)
    assert s.count == 0
    sim.step(2)
    s.add((0, 0, 0), velocity=(1, 0, 0))
    sim.step(1)
    assert s.position[0, 0] == pytest.approx(sim.dt)


def test_added_particles_live_as_long_as_is_said():
    sim = simulation(arrays(), dt=0.01, ledger=True)
    sim["s"].add([[0, 0, 0], [1, 0, 0]], lifetime=[0.045, 1.0])
    sim.step(4)
    assert sim["s"].count == N + 2
    sim.step(1)
    assert sim["s"].count == N + 1
    assert sim.ledger().died["s.added"].count == 1 and sim.ledger().outside["s"].count == 2


# --- the run goes on from the new state -------------------------------------------------------------------------

CHAIN = [(k, k + 1) for k in range(N // 2 - 1)]
GRAVITY = dict(interactions=lambda: [I.SelfGravity(G=0.3, softening=0.2)])
RUNS = {
    "leapfrog": dict(forces=lambda: [F.Spring(stiffness=2.0), F.Drag(0.1)]),
    "gravity": GRAVITY,
    "gravity velocity_verlet": {**GRAVITY, "integrator": "velocity_verlet"},
    "gravity rk4": {**GRAVITY, "integrator": "rk4"},
    "gravity yoshida4": {**GRAVITY, "integrator": "yoshida4"},
    "gravity tree": dict(interactions=lambda: [I.SelfGravity(G=0.3, softening=0.2, method="tree")]),
    "gravity levels": dict(interactions=lambda: [I.SelfGravity(G=3.0, softening=0.05, levels=3)]),
    "springs": dict(interactions=lambda: [I.Springs(pairs=CHAIN, stiffness=50.0, rest_length=0.5)]),
    "springs implicit": dict(
        interactions=lambda: [I.Springs(pairs=CHAIN, stiffness=50.0, rest_length=0.5, method="implicit")],
        integrator="semi_implicit_euler",
    ),
    "springs xpbd": dict(
        interactions=lambda: [I.Springs(pairs=CHAIN, stiffness=50.0, rest_length=0.5, method="xpbd")],
        integrator="semi_implicit_euler",
    ),
    "contacts": dict(interactions=lambda: [I.Contacts(restitution=0.8)], radius=0.15),
    "colliders": dict(
        **GRAVITY, colliders=lambda: [ga.colliders.Plane(point=(0, -1, 0), normal=(0, 1, 0))], forces=lambda: [F.Gravity()]
    ),
}  # fmt: skip


def parts(case):
    return {key: value() if callable(value) else value for key, value in RUNS[case].items() if key != "radius"}


def afresh(sim, case):
    """A simulation that begins with the present state of another."""
    s = sim["s"]
    given = {k: getattr(s, k) for k in ("position", "velocity", "mass", "radius")}
    return simulation(given, precision=sim.precision, **parts(case))


def changed(case, precision="f64"):
    given = arrays() | ({"radius": RUNS[case]["radius"]} if "radius" in RUNS[case] else {})
    sim = simulation(given, precision=precision, **parts(case))
    sim.step(5)
    sim["s"].set(position=sim["s"].position[::-1] + 0.3, velocity=(0.1, 0.2, 0.3), mass=2.5)
    return sim


@pytest.mark.filterwarnings("ignore::gen_art.AdviceWarning")
@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("case", RUNS)
def test_a_changed_run_is_that_of_the_new_state(case, precision):
    """Bit for bit: nothing that was derived from the old state is left."""
    sim = changed(case, precision)
    fresh = afresh(sim, case)
    for one in (sim, fresh):
        one.step(7)
    assert states(sim) == states(fresh)


@pytest.mark.filterwarnings("ignore::gen_art.AdviceWarning")
@pytest.mark.parametrize("case", [case for case in RUNS if "springs" not in case])
def test_a_run_with_other_particles_is_that_of_the_new_state(case):
    sim = changed(case)
    sim.step(1)
    sim["s"].add([[0.2, 3, 0.1], [1, 2, 2]], velocity=(1, 0, 0), mass=2.0, radius=0.1)
    sim["s"].remove([0, 11, 17])
    fresh = afresh(sim, case)
    for one in (sim, fresh):
        one.step(7)
    assert states(sim) == states(fresh)


@pytest.mark.filterwarnings("ignore::gen_art.AdviceWarning")
def test_springs_end_where_a_particle_is_removed():
    """The others go on as two chains; what was joined only to the removed one goes straight on."""
    pairs = np.array([(0, 1), (1, 2), (2, 3), (4, 5)])
    sim = simulation(arrays(), interactions=[I.Springs(pairs=pairs, stiffness=50.0, rest_length=0.5)], ledger=True)
    sim.step(3)
    sim["s"].remove([1])
    left = simulation(
        {k: getattr(sim["s"], k) for k in ("position", "velocity", "mass")},
        interactions=[I.Springs(pairs=[(1, 2), (3, 4)], stiffness=50.0, rest_length=0.5)],
    )
    v = sim["s"].velocity[0]
    for one in (sim, left):
        one.step(5)
    assert states(sim) == states(left) and np.array_equal(sim["s"].velocity[0], v)
    assert abs(sim.ledger().residual) < 1e-2 * sim.ledger().scale
    sim["s"].remove(sim["s"].ids)
    sim.step(2)
    assert sim.diagnostics().energy == 0


@pytest.mark.parametrize("case", ["gravity", "gravity levels"])
def test_the_mutant_that_keeps_the_old_accelerations_is_found(case, monkeypatch):
    monkeypatch.setattr(CoupledSystems, "forget", lambda self: None)
    with warnings.catch_warnings(action="ignore"):
        sim = changed(case)
        fresh = afresh(sim, case)
    for one in (sim, fresh):
        one.step(7)
    assert states(sim) != states(fresh)


# --- the ledger ---------------------------------------------------------------------------------------------------

LEDGERS = {  # schemes that close to round-off, so that only the change can be missing
    "field": dict(forces=lambda: [F.Gravity(), F.ElectricField((0.5, 0, 0))], integrator="leapfrog"),
    "drag": dict(forces=lambda: [F.ElectricField((0.5, 0, 0)), F.Damping(1.0)], integrator="position_verlet"),
}


def booked(case, change):
    sim = simulation(
        arrays(), ledger=True, charge=0.3, **{k: v() if callable(v) else v for k, v in LEDGERS[case].items()}
    )
    start = sim.diagnostics()
    sim.step(20)
    before = sim.diagnostics()
    change(sim["s"])
    after = sim.diagnostics()
    sim.step(20)
    return sim, start, before, after


CHANGES = {
    "velocity": lambda s: s.set(velocity=(3, 1, -2), where=[1, 2, 5]),
    "position": lambda s: s.set(position=s.position + [0, 2, 0]),
    "mass": lambda s: s.set(mass=5.0, where=[4]),
    "charge": lambda s: s.set(charge=[2.0, -1.0], where=[4, 9]),
    "add": lambda s: s.add([[1, 2, 3], [0, 0, 1]], velocity=(0, 3, 0), mass=2.0, charge=1.0),
    "remove": lambda s: s.remove([0, 3]),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("case", LEDGERS)
def test_the_ledger_closes_over_a_change(case, change):
    """To the round-off of 40 steps and some 30 particles; and each sum of the entry is the change of that sum."""
    sim, start, before, after = booked(case, CHANGES[change])
    ledger = sim.ledger()
    outside = ledger.outside["s"]
    assert abs(ledger.residual) <= 1e-13 * ledger.scale
    assert np.abs(ledger.momentum_residual).max() <= 1e-13 * 40 * N
    for key in ("count", "mass", "charge", "momentum", "angular_momentum", "energy"):
        a, b = getattr(before, key), getattr(after, key)
        assert np.allclose(getattr(outside, key), b - a, rtol=1e-13, atol=1e-13 * np.abs(a).max()), key
    assert ledger.work["s.outside"] == outside.energy and np.array_equal(ledger.impulse["s.outside"], outside.momentum)
    assert np.allclose(sim.diagnostics().momentum, start.momentum + ledger.impulse.total, atol=1e-13 * 40 * N)


@pytest.mark.parametrize("change", CHANGES)
def test_the_mutant_that_books_nothing_is_found(change, monkeypatch):
    monkeypatch.setattr(LedgerKeeper, "record_outside", lambda *_: None)
    sim, *_ = booked("field", CHANGES[change])
    assert abs(sim.ledger().residual) > 1e-3 * sim.ledger().scale


@pytest.mark.parametrize("order,integrator", [(2, "leapfrog"), (4, "rk4")])
def test_what_is_left_is_still_the_error_of_the_scheme(order, integrator):
    """With forces between particles, whose energy changes too: halving the step divides the residual by 2^order."""
    residuals = []
    for dt in (0.01, 0.005):
        sim = simulation(
            arrays(), dt=dt, ledger=True, interactions=[I.SelfGravity(G=0.05, softening=0.3)], integrator=integrator
        )
        sim.advance(0.2)
        sim["s"].set(position=sim["s"].position * 1.5, where=None)
        sim["s"].add((0, 0, 0), mass=5.0)
        sim["s"].remove([3])
        sim.advance(0.2)
        residuals.append(sim.ledger().residual)
    assert np.log2(abs(residuals[0] / residuals[1])) == pytest.approx(order, abs=0.4)


def test_a_ledger_leaves_the_bits_of_a_changed_run_alone():
    runs = []
    for ledger in (True, False):
        sim = simulation(arrays(), precision="f32", ledger=ledger, interactions=[I.SelfGravity(G=0.05, softening=0.3)])
        for k in range(4):
            sim.step(3)
            sim["s"].set(velocity=(k, 0, 1), where=[k])
            sim["s"].remove([5 + k])
            sim["s"].add((k, k, k))
        sim.step(3)
        runs.append(sim.digest())
    assert runs[0] == runs[1]


def test_shares_of_removed_particles_stay_in_the_total():
    sim = simulation(arrays(), forces=[F.Damping(1.0)], booked=[{"dissipated": "damping"}])
    sim.step(20)
    sim["s"].remove(np.arange(10))
    sim["s"].add((0, 0, 0), velocity=(1, 0, 0))
    sim.step(20)
    shares = sim["s"].booked("dissipated", "damping")
    total = sim["s"].booked_total("dissipated", "damping")
    assert total == pytest.approx(sim.ledger().dissipated["s.damping"], rel=1e-12) and shares.sum() < 0.9 * total
    assert 0 < shares[-1] < 0.5


def test_a_changed_run_is_saved_and_goes_on_to_the_same_bytes(tmp_path):
    sim = simulation(
        arrays(), ledger=True, forces=[F.Damping(1.0)], interactions=[I.SelfGravity(G=0.05, softening=0.3)]
    )
    sim.step(5)
    sim["s"].set(velocity=(1, 0, 0), where=[2])
    sim["s"].add([[1, 1, 1], [2, 2, 2]], lifetime=0.05)
    sim["s"].remove([0])
    sim.save(tmp_path / "s.gas")
    again = ga.Simulation.restore(tmp_path / "s.gas")
    for one in (sim, again):
        one.step(5)
        one["s"].add((0, 0, 5))  # the random stream of the next one is the same too
        one.step(15)
    assert again.digest() == sim.digest() and again.ledger().as_dict() == sim.ledger().as_dict()
    assert sim.ledger().outside["s"].count == 2 and again["s"].emitter[-1] == "added"


# --- emitters, boxes, fixed particles, bodies ---------------------------------------------------------------------


def test_emitters_take_an_added_particle_for_a_birth_and_no_removed_one_for_a_death():
    """BURST: two shells of the first 0.05 s burst into stars before 0.19 s; no other shell is born until then."""
    sim = ga.Simulation(preset(BURST, 0.01))
    plain = ga.Simulation(preset(BURST, 0.01))
    for one in (sim, plain):
        one.step(5)
    sim["shells"].remove(sim["shells"].ids)
    for one in (sim, plain):
        one.step(14)
    assert plain["stars"].count > 0 and sim["stars"].count == 0
    born = {
        "a": {"emitters": {"one": {"count": 1}}},
        "b": {"emitters": {"child": {"from": {"event": "a.birth"}, "count": 3}}},
    }
    sim = ga.Simulation(preset(born))
    sim.step(4)
    count = sim["b"].count
    sim["a"].add((0, 1, 0))
    sim.step(1)
    assert count == 3 and sim["b"].count == 6
    sim.step(2)
    assert sim["b"].count == 6


def test_places_are_wrapped_into_a_periodic_box():
    box = {"periodic": {"min": (0, 0, 0), "max": (1, 1, 1), "axes": "xy"}}
    system = ga.ParticleSystem(position=[[0.5, 0.5, 0.5]], radius=0.01, interactions=[I.Contacts()])
    ga.Simulation({"s": system}, dt=1e-3, precision="f64", domain=box)
    system.set(position=(1.25, -0.5, 7))
    system.add((2.5, 0.5, -3), radius=0.01)
    assert np.allclose(system.position, [[0.25, 0.5, 7], [0.5, 0.5, -3]])
    with pytest.raises(ga.UsageError, match="a periodic box must be at least 3 times as long"):
        system.set(radius=0.4)


def test_a_fixed_particle_may_be_carried_but_has_no_velocity():
    sim = simulation(arrays() | {"velocity": None}, fixed=[3], forces=[F.Gravity()])
    with pytest.raises(ga.UsageError, match="the velocity of particle 3 must be 0"):
        sim["s"].set(velocity=(0, 1, 0))
    sim["s"].set(position=(0, 5, 0), where=[3])
    sim.step(10)
    assert sim["s"].position[3].tolist() == [0, 5, 0]


@pytest.mark.parametrize("call,words", [
    (lambda s: s.set(), "set changes nothing"),
    (lambda s: s.set(position=[[1, 2, 3]]), r"position must be three numbers, or numbers of the shape \(24, 3\), not an array"),
    (lambda s: s.set(velocity=[[1, 2, 3]] * 3, where=[1, 2]), r"velocity must be three numbers, or numbers of the shape \(2, 3\)"),
    (lambda s: s.set(mass=[1, 2]), r"mass must be one number, or numbers of the shape \(24,\)"),
    (lambda s: s.set(velocity=(1, 2, np.nan)), "velocity holds numbers that are not finite"),
    (lambda s: s.set(position=(1e39, 0, 0)), "position holds numbers that float32 does not hold"),
    (lambda s: s.set(mass=-1.0), "mass must not be negative"),
    (lambda s: s.set(mass=0.0), "a particle without mass has no acceleration"),
    (lambda s: s.set(mass="heavy"), "mass must be one number"),
    (lambda s: s.set(charge=1, where=[99]), "system 's' has no living particle 99"),
    (lambda s: s.set(charge=1, where=[-1]), "system 's' has no living particle -1"),
    (lambda s: s.set(charge=1, where=[2, 3, 2]), "where has particle 2 twice"),
    (lambda s: s.set(charge=1, where=[0.5]), "where must be ids of particles, or 24 booleans"),
    (lambda s: s.set(charge=1, where=[True, False]), "where must be ids of particles, or 24 booleans"),
    (lambda s: s.set(charge=1, where=[[1, 2], [3, 4]]), "where must be ids of particles"),
    (lambda s: s.set(attributes={"head": 1}), "system 's' has no attribute 'head'; did you mean 'heat'"),
    (lambda s: s.set(attributes=3), "attributes must be a mapping"),
    (lambda s: s.add([[1, 2]]), r"position must have the shape \(n, 3\)"),
    (lambda s: s.add((0, 0, 0), velocity=[[1, 2, 3], [4, 5, 6]]), "velocity must be three numbers"),
    (lambda s: s.add((0, 0, 0), mass=0.0), "a particle without mass has no acceleration"),
    (lambda s: s.add((0, 0, 0), lifetime=0), "lifetime must be above 0 s"),
    (lambda s: s.add((0, 0, np.inf)), "position holds numbers that are not finite"),
    (lambda s: s.remove([3, 77]), "system 's' has no living particle 77"),
    (lambda s: s.remove([3, 3]), "ids has particle 3 twice"),
])  # fmt: skip
def test_nonsense_is_a_sentence_and_changes_nothing(call, words):
    sim = simulation(arrays(), precision="f32", ledger=True, forces=[F.Drag(0.1)], attributes={"heat": 1.0})
    sim.step(2)
    before = sim.digest()
    with pytest.raises(ga.UsageError, match=words):
        call(sim["s"])
    assert sim.digest() == before and not sim.ledger().outside


def test_what_cannot_be_changed_says_so():
    with pytest.raises(ga.UsageError, match="not part of a simulation yet"):
        ga.ParticleSystem(**arrays()).set(mass=1.0)
    with pytest.raises(ga.UsageError, match="not part of a simulation yet"):
        ga.ParticleSystem(**arrays()).add((0, 0, 0))
    bodies = ga.bodies([ga.body({"sphere": 0.5}, points=20)]).system()
    ga.Simulation({"b": bodies}, dt=0.01)
    with pytest.raises(ga.UsageError, match="those of rigid bodies"):
        bodies.set(velocity=(1, 0, 0))
    light = ga.ParticleSystem(
        **arrays(), charge=1.0, integrator="boris", speed_of_light=10.0, forces=[F.MagneticField((0, 0, 1))]
    )
    ga.Simulation({"s": light}, dt=0.01)
    with pytest.raises(ga.UsageError, match="below the speed of light, 10 m/s"):
        light.set(velocity=(6, 8, 0))
    for one in (I.Contacts(), I.Springs(pairs=[(0, 1)], stiffness=1.0)):
        sim = simulation(arrays() | {"radius": 1e-3}, interactions=[one], dt=1e-4)
        with pytest.raises(ga.UsageError, match="has no mass"):
            sim["s"].set(mass=0.0, where=[1])


def test_a_change_is_no_motion_that_the_step_cannot_carry(monkeypatch):
    def run():
        sim = simulation(arrays(), forces=[F.Gravity()])
        for k in range(6):
            sim["s"].set(velocity=-sim["s"].velocity)
            sim.step(1)

    with warnings.catch_warnings():
        warnings.simplefilter("error", ga.AdviceWarning)
        run()
        monkeypatch.setattr(Watch, "restart", lambda self: None)
        with pytest.raises(ga.AdviceWarning, match="too long for particle"):
            run()
