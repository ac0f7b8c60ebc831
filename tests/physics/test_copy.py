"""A copy of a simulation, and a snapshot with a ledger: both go on to the same bytes, and neither touches the original."""

import warnings

import pytest

import gen_art as ga
from tests.physics.test_births import BURST, preset
from tests.physics.test_changes import RUNS, arrays, parts, simulation, states
from tests.small import SMALL

F, I = ga.forces, ga.interactions


class Unregistered(ga.Force):
    """A constant push along x, of a class that no snapshot can name."""

    strength: float = ga.param(1.0, unit="m/s^2")

    @ga.ti.func
    def acceleration(self, p, t, q):
        return ga.ti.Vector([q.strength, 0.0, 0.0])


def cases():
    for name in RUNS:
        more = {"radius": RUNS[name]["radius"]} if "radius" in RUNS[name] else {}
        yield name, lambda name=name, more=more: simulation(arrays() | more, ledger=True, **parts(name))
    yield "unregistered", lambda: simulation(arrays(), ledger=True, forces=[Unregistered(2.0)])
    yield "shares", lambda: simulation(arrays(), forces=[F.Damping(1.0)], booked=[{"dissipated": "damping"}])
    yield "bursts", lambda: ga.Simulation(preset(BURST, 0.01), ledger=True)
    yield (
        "tearing",
        lambda: simulation(arrays(), interactions=[I.Springs(pairs=[(0, 1), (2, 3), (4, 5)], stiffness=9.0, tear=0.3)]),
    )
    box = {"periodic": {"min": (0, 0, 0), "max": (9, 9, 9), "axes": "xz"}}
    floor = [ga.colliders.Plane()]

    def boxed():
        systems = {"s": ga.ParticleSystem(**arrays(), forces=[F.Gravity()])}
        return ga.Simulation(systems, dt=0.01, domain=box, ledger=True)

    def body():
        bodies = ga.bodies([ga.body({"box": (1, 1, 1)}, points=20, position=(0, 0.6, 0), spin=(1, 2, 0))])
        return ga.Simulation({"b": bodies.system(forces=[F.Gravity()], colliders=floor)}, dt=0.01, ledger=True)

    yield from (("box", boxed), ("bodies", body))


CASES = dict(cases())


@pytest.mark.filterwarnings("ignore::gen_art.AdviceWarning")
@pytest.mark.parametrize("case", CASES)
def test_a_copy_goes_on_to_the_same_bytes_and_is_independent(case):
    sim = CASES[case]()
    sim.step(18)
    now = sim.digest()
    twin = sim.copy()
    assert twin.digest() == now and twin.steps_done == 18 and twin.keeps_ledger == sim.keeps_ledger
    twin.step(12)
    assert sim.digest() == now  # the copy's steps are its own
    sim.step(12)
    assert twin.digest() == sim.digest() != now
    if sim.keeps_ledger:
        assert twin.ledger().as_dict() == sim.ledger().as_dict() and twin.joules() == sim.joules()


@pytest.mark.parametrize("name", ["fire", "course/tower", "course/cloth_over_ball"])
def test_a_copy_of_a_preset(name):
    sim = ga.Simulation(ga.load_preset(name, overrides=SMALL.get(name, {})), advice="none", ledger=name == "fire")
    sim.step(20)
    twin = sim.copy()
    for one in (twin, sim):
        one.step(10)
    assert twin.digest() == sim.digest()
    if sim.keeps_ledger:
        assert twin.ledger().as_dict() == sim.ledger().as_dict()


def test_a_changed_copy_leaves_the_original_alone_and_the_other_way_round():
    sim = simulation(arrays(), ledger=True, interactions=[I.SelfGravity(G=0.3, softening=0.2)])
    sim.step(5)
    twin, untouched = sim.copy(), sim.copy()
    twin["s"].set(velocity=(0, 0, 0))
    twin["s"].remove([3])
    assert sim.digest() == untouched.digest() != twin.digest() and not sim.ledger().outside
    changed = states(twin)
    sim["s"].set(position=(1, 1, 1), where=[0])
    assert states(twin) == changed
    assert [one["s"].add((9, 9, 9)).tolist() for one in (sim, untouched)] == [[24], [24]]
    assert sim["s"].keys[-1] == untouched["s"].keys[-1]  # the same stream of random numbers


def test_a_copy_does_not_say_again_what_was_said():
    with pytest.warns(ga.AdviceWarning, match="too long for particle"):
        sim = simulation(arrays(), dt=1.0, forces=[F.Spring(stiffness=9.0)])
        sim.step(3)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ga.AdviceWarning)
        sim.copy().step(5)


def test_simulations_of_one_preset_do_not_share_their_bodies():
    """The state of rigid bodies is their interaction's own."""
    loaded = ga.load_preset("course/tower")
    one = ga.Simulation(loaded, advice="none")
    one.step(3)
    alone = one.digest()
    two = ga.Simulation(loaded, advice="none")
    two.step(9)
    assert one.digest() == alone


@pytest.mark.filterwarnings("ignore::gen_art.AdviceWarning")
@pytest.mark.parametrize("case", [name for name in CASES if name != "unregistered"])
def test_a_snapshot_with_a_ledger_goes_on_to_the_same_bytes(case, tmp_path):
    sim = CASES[case]()
    sim.step(18)
    sim.save(tmp_path / "s.gas")
    again = ga.Simulation.restore(tmp_path / "s.gas")
    for one in (sim, again):
        one.step(12)
    assert again.digest() == sim.digest() and again.keeps_ledger == sim.keeps_ledger
    if sim.keeps_ledger:
        assert again.ledger().as_dict() == sim.ledger().as_dict() and again.joules() == sim.joules()


def test_the_mutant_that_begins_a_new_ledger_is_found():
    sim = simulation(arrays(), ledger=True, forces=[F.Damping(1.0)])
    sim.step(5)
    twin = sim.copy()
    twin.keep_ledger()  # begins anew
    for one in (sim, twin):
        one.step(5)
    assert twin.ledger().as_dict() != sim.ledger().as_dict()


def test_particles_go_on_under_another_preset_of_the_same_parts():
    """Without a ledger any force may change; with one its rows, and always the step, must be the same."""
    data = {
        "version": 1, "clock": {"duration": 1, "fps": 20, "step": 0.01}, "forces": {"gravity": [0, -9.81, 0], "drag": {"linear": 0.1}},
        "systems": {"s": {"emitters": {"e": {"rate": 500, "velocity": {"sphere": 1}}}}},
    }  # fmt: skip
    other = {**data, "forces": {"damping": 0.5, "drag": {"linear": 0.1}}}
    sim = ga.Simulation(ga.load_preset(data))
    sim.step(20)
    before = sim.digest()
    twin = sim.continued(ga.load_preset(other))
    assert twin.digest() == before and twin.steps_done == 20
    twin.step(10)
    assert twin["s"].count == 150 and sim.digest() == before
    with_ledger = {**data, "systems": {"s": {**data["systems"]["s"], "look": _by_drag()}}}
    sim = ga.Simulation(ga.load_preset(with_ledger))
    sim.step(20)
    assert sim.continued(ga.load_preset(with_ledger)).digest() == sim.digest()
    with pytest.raises(ga.UsageError, match="other emitters, forces between particles or ledger entries"):
        sim.continued(ga.load_preset({**with_ledger, "forces": other["forces"]}))
    with pytest.raises(ga.UsageError, match="another step"):
        sim.continued(ga.load_preset(with_ledger, overrides={"clock.step": 0.005}))


def _by_drag() -> dict:
    """A look that goes by joules, which makes a simulation keep its ledger."""
    by = {"by": {"dissipated": "drag"}, "range": "0..1", "gradient": ["white", "blue"]}
    return {"draw": "disc", "emission": {"color": by}}
