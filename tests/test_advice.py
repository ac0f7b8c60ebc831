"""What inspect and audit say before and after: what should hold, by every combination of flags, and the better choice."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import gen_art as ga
from gen_art.audit import audit
from gen_art.audit.advice import advice, step_advice
from gen_art.audit.invariants import expected_order, invariants
from gen_art.integrators import INTEGRATORS
from tests.small import SMALL

MIRROR = {"magnetic_mirror": {"strength": 2}}
FIELD = {"magnetic_field": [0, 0, 2]}
SPRING = {"spring": {"stiffness": 50}}
WALL = {"plane": {"restitution": 0.5}}


def piece(forces=None, integrator="leapfrog", step="1/50", particle=None, emitter=None, **system):
    emitters = {"all": {"count": 12, "shape": {"sphere": 1.0}, "velocity": {"sphere": 1}, **(emitter or {})}}
    system = {
        "particle": particle or {},
        "integrator": integrator,
        "forces": forces or {},
        "emitters": emitters,
        **system,
    }
    clock = {"duration": 1, "fps": 10, "step": step}
    return ga.load_preset({"version": 1, "seed": 3, "name": "small", "clock": clock, "systems": {"s": system}})


# what: (arguments of the piece, what it says; None: nothing)
SAID = {
    "magnetic field, leapfrog": (dict(forces=FIELD), "leapfrog takes magnetic_field, which depends .* order 1.*; boris"),
    "magnetic field, position_verlet": (dict(forces=FIELD, integrator="position_verlet"), "boris turns"),
    "magnetic field, rk4": (dict(forces=FIELD, integrator="rk4"), "rk4 does not keep the speed.*; boris turns"),
    "magnetic field, boris": (dict(forces=FIELD, integrator="boris"), None),
    "lift, leapfrog": (dict(forces={"lift": {"density": 1}}), "leapfrog takes lift.* rk2 has order 2, rk4 order 4"),
    "lift, rk2": (dict(forces={"lift": {"density": 1}}, integrator="rk2"), None),
    "quadratic drag, leapfrog": (dict(forces={"drag": {"quadratic": 0.1}}), None),  # in closed form
    "quadratic drag, yoshida4": (dict(forces={"drag": {"quadratic": 0.1}}, integrator="yoshida4"), "order 3 .*; rk4 keeps"),
    "damping, yoshida4": (dict(forces={"damping": 1}, integrator="yoshida4"), None),
    "walls, rk4": (dict(colliders=WALL, integrator="rk4"), "impacts inside a step are of order 2.*; leapfrog costs less"),
    "walls, leapfrog": (dict(colliders=WALL), None),
    "vay, slow": (dict(forces=FIELD, integrator="vay"), "vay without speed_of_light takes the same steps as boris"),
    "higuera_cary, slow": (dict(integrator="higuera_cary"), "higuera_cary without speed_of_light takes the same"),
    "vay, fast": (dict(forces=FIELD, integrator="vay", speed_of_light=9), None),
    "euler, spring": (dict(forces=SPRING, integrator="euler"), "grow by 55.3% a period; leapfrog keeps it"),
    "euler, driver": (
        dict(forces={"driver": {"frequency": 0.5}, **SPRING}, integrator="euler"), "explicit euler gains energy under spring"
    ),
    "euler, nothing": (dict(integrator="euler"), "explicit euler gains energy at every step; leapfrog"),
    "a driver too quick": (dict(forces={"driver": {"frequency": 20}}), "2.51 rad a step.* at most 0.00239 s"),
    "a driver": (dict(forces={"driver": {"frequency": 2}}), None),
    "a spring too stiff": (dict(forces=SPRING, particle={"mass": "0.001..1"}), "w dt = 4.47 .* at most 0.00894 s"),
    "a spring too stiff, rk4": (dict(forces=SPRING, particle={"mass": 0.005}, integrator="rk4"), None),
    "a spring far too stiff, rk4": (dict(forces=SPRING, particle={"mass": 0.002}, integrator="rk4"), "at most 0.0179 s"),
    "a linear centre": (dict(forces={"central_force": {"strength": 2e4, "exponent": 1}}), "at most 0.0141 s"),
    "quick gyration": (
        dict(forces=FIELD, integrator="boris", particle={"charge": "-20..5", "mass": "2..3"}),
        "w dt = 0.4 rad a step, and lag by 1.3.%.* at most 0.005 s, or exact_gyration",
    ),
    "quick gyration, exactly": (
        dict(forces=FIELD, integrator="boris", particle={"charge": 20}, exact_gyration=True), None
    ),
    "quick gyration in a mirror": (dict(forces=MIRROR, integrator="boris", particle={"charge": 9}), r"at most 0\.00556 s, or"),
    "far too quick gyration": (dict(forces=FIELD, integrator="boris", particle={"charge": 900}), r"at most 5.56e-05 s$"),
    "a collider that turns too fast": (
        dict(colliders={"block": {"min": [0, 0, 0], "max": [1, 1, 1], "angular_velocity": [0, 63, 0], "restitution": 1}}),
        r"block turns by 1\.26 rad a step, so .* wrong place; .* at most 0\.0159 s",
    ),
    "a collider that turns": (dict(colliders={"plane": {"angular_velocity": [0, 40, 0]}}), None),
    "theta, direct": (
        dict(interactions={"self_gravity": {"G": 1, "method": "direct", "theta": 0.5}}), "self_gravity: theta has no effect with method: direct"
    ),
    "theta, tree": (dict(interactions={"self_gravity": {"G": 1, "method": "tree", "theta": 0.5}}), None),
    "direct": (dict(interactions={"coulomb": {"k": 1, "method": "direct"}}), None),
    "slow gyration": (dict(forces=FIELD, integrator="boris", particle={"charge": 2}), None),
}  # fmt: skip


@pytest.mark.parametrize("what", SAID)
def test_what_does_not_suit_is_said_with_the_better_choice(what):
    given, words = SAID[what]
    sentences = advice(piece(**given))
    if words is None:
        assert sentences == []
    else:
        assert any(re.search(words, sentence) for sentence in sentences), sentences
        assert all(sentence.startswith("system 's': ") for sentence in sentences)


@pytest.mark.parametrize("factor,said", [(1.0, False), (1.2, True)])
def test_a_grid_that_is_no_distance_is_said(tmp_path, monkeypatch, factor, said):
    """A ball on a grid of 12 points an axis, true or 1.2 times too steep; one whose corners are wrong is too steep as well."""
    at = np.linspace(-1, 1, 12)
    x, y, z = np.meshgrid(at, at, at, indexing="ij")
    monkeypatch.chdir(tmp_path)
    np.save("ball.npy", factor * (np.sqrt(x * x + y * y + z * z) - 0.5))
    for corner in (1, 0.5):
        wall = {"sdf": {"function": "ball.npy", "min": [-corner] * 3, "max": [corner] * 3, "restitution": 0}}
        sentences = advice(piece(colliders=wall))
        words = f"system 's': sdf: the grid grows by up to {factor / corner:.2g}.* m a metre, .* divide it by {factor / corner:.2g}"
        assert [re.match(words, one) is not None for one in sentences] == [True] * (said or corner < 1), sentences


def rope(**more):
    system = {
        "integrator": "leapfrog", "interactions": {"springs": {"stiffness": 5000}},
        "emitters": {"line": {"rope": {"start": [0, 0, 0], "end": [1, 0, 0], "count": 12}}}, **more,
    }  # fmt: skip
    clock = {"duration": 1, "fps": 10, "step": "1/50"}
    return ga.load_preset({"version": 1, "seed": 3, "name": "small", "clock": clock, "systems": {"s": system}})


def test_springs_and_contacts_say_the_largest_step():
    assert any("longest that is surely stable is" in sentence for sentence in step_advice(rope()))
    touching = piece(interactions={"contacts": {"duration": 0.05}}, particle={"radius": 0.1})
    assert sum("a step of at most 0.00625 s" in sentence for sentence in step_advice(touching)) == 1
    large = piece(interactions={"contacts": {"duration": 0.2}}, particle={"radius": 0.3})
    assert not any("step of at most" in sentence for sentence in step_advice(large))
    assert step_advice(piece(SPRING)) == []


def test_audit_says_it_too():
    found = audit(
        piece(interactions={"contacts": {"duration": 0.05}}, particle={"radius": 0.01}), time=0.1, precision="f64"
    )
    assert any("leapfrog needs 8: use a step of at most 0.00625 s" in sentence for sentence in found.warnings)
    assert "warning: " in found.text()


def test_audit_says_how_far_charges_turn_where_they_are():
    wire = {"magnetic_wire": {"current": 5e7, "center": [3, 0, 0]}}
    given = dict(forces=wire, integrator="boris", particle={"charge": 2})
    assert advice(piece(**given)) == []
    found = audit(piece(**given), time=0.1, precision="f64").warnings
    assert len(found) == 1 and re.search(
        r"^system 's': charges turn by w dt = 0\.\d+ rad a step.* exact_gyration", found[0]
    )
    assert 0.1 < float(found[0].split("w dt = ")[1].split()[0]) < 5e7 * 2e-7 / 1.5 * 2 / 50
    weak = {**given, "particle": {"charge": 0.1}}
    assert audit(piece(**weak), time=0.1, precision="f64").warnings == []


def test_inspect_says_it_and_lists_walls_and_pair_forces(tmp_path):
    from gen_art.commands.inspect import command

    one = piece({"driver": {"frequency": 20}}, colliders=WALL, interactions={"contacts": {"duration": 0.05}})
    path = tmp_path / "p.yaml"
    path.write_text(json.dumps(one.resolved()), encoding="utf-8")
    text = CliRunner().invoke(command, [str(path)]).output
    for words in (
        "colliders     Plane(",
        "interactions  Contacts(",
        "warning: system 's': driver turns",
        "warning: system 's': contacts of",
    ):
        assert words in text
    facts = json.loads(CliRunner().invoke(command, [str(path), "--json"]).stdout)
    assert len(facts["advice"]) >= 2 and facts["systems"]["s"]["colliders"]


@pytest.mark.parametrize("name", INTEGRATORS)
def test_the_stable_step_of_an_oscillator(name):
    """Energy stays bounded over 400 steps just below the reach, and grows a hundredfold just above; at half for rk2, slowly."""

    def growth(turn):
        ball = ga.ParticleSystem(position=[[1.0, 0, 0]], forces=[ga.forces.Spring(stiffness=1.0)], integrator=name)
        sim = ga.Simulation({"b": ball}, dt=turn, precision="f64")
        largest = 0.0
        for _ in range(8):
            sim.step(50)
            largest = max(largest, sim.diagnostics().energy / 0.5)
        return largest

    limit = INTEGRATORS[name].stability_limit
    if name == "euler":
        assert limit == 0 and growth(0.1) > 50
    elif name == "rk2":
        assert growth(0.1) < 1.02 and growth(1.0) > 1e10
    else:
        assert growth(0.995 * limit) < 1000
        assert growth(1.01 * limit) > 1e3 or growth(1.03 * limit) > 1e6


HOLD = {"energy", "momentum", "angular momentum", "mass", "charge"}
# what: (arguments of the piece, what should not hold and is left to the ledger)
FLAGS = {
    "nothing": (dict(), set()),
    "conservative, of no system": (dict(forces=SPRING), {"momentum", "angular momentum"}),
    "does work without a potential": (dict(forces={"wind": [1, 0, 0]}), {"energy", "momentum", "angular momentum"}),
    "does no work, without a potential": (dict(forces=FIELD, integrator="boris"), {"momentum", "angular momentum"}),
    "dissipative": (dict(forces={"damping": 1.0}), {"energy", "momentum", "angular momentum"}),
    "takes mass": (dict(forces={"thrust": {"mass_rate": 0.01}}), {"energy", "momentum", "angular momentum", "mass"}),
    "conservative and reciprocal pairs": (dict(interactions={"self_gravity": {"softening": 0.3}}), set()),
    "pairs that lose": (dict(interactions={"contacts": {}}), {"energy"}),
    "pairs that lose nothing": (dict(interactions={"contacts": {"restitution": 1}}), set()),
    "elastic walls": (dict(colliders={"plane": {"point": [0, -1.2, 0], "restitution": 1}}), {"momentum", "angular momentum"}),
    "walls that take": (dict(colliders=WALL), {"energy", "momentum", "angular momentum"}),
    "walls that move": (
        dict(colliders={"plane": {"restitution": 1, "velocity": [0, 1, 0]}}), {"energy", "momentum", "angular momentum"}
    ),
    "deaths": (dict(particle={"lifetime": 0.3}), HOLD),
    "births": (dict(emitter={"count": None, "rate": 5}), HOLD),
}  # fmt: skip


@pytest.mark.parametrize("what", FLAGS)
def test_what_should_hold_follows_from_the_flags(what):
    given, left = FLAGS[what]
    one = piece(**given)
    holds, booked = invariants(one, one.systems["s"])
    assert set(booked) == left and set(holds) == HOLD - left


def test_a_field_of_another_system_is_booked():
    clock = {"duration": 1, "fps": 10, "step": "1/50"}
    of = {"emitters": {"all": {"count": 3}}}
    pulled = {**of, "interactions": {"self_gravity": {"sources": "b"}}}
    one = ga.load_preset({"version": 1, "clock": clock, "systems": {"a": pulled, "b": of}})
    assert set(invariants(one, one.systems["a"])[1]) == {"energy", "momentum", "angular momentum"}
    assert invariants(one, one.systems["b"])[1] == {}


MEASURED = [
    "nothing", "conservative, of no system", "does work without a potential", "does no work, without a potential",
    "dissipative", "takes mass", "conservative and reciprocal pairs", "elastic walls", "walls that take", "deaths",
]  # fmt: skip


@pytest.mark.proof
@pytest.mark.parametrize("what", MEASURED)
def test_what_should_hold_did(what):
    given, left = FLAGS[what]
    found = audit(piece(**given), time=0.4, precision="f64")
    assert found.problems == []
    assert {quantity for _, quantity in found.invariants} == HOLD - left
    assert all(trend is None or trend.good for trend in found.invariants.values())


@pytest.mark.parametrize("given,order", [
    (dict(integrator="rk4"), 4), (dict(integrator="yoshida4", forces={"drag": {"quadratic": 0.1}}), 3),
    (dict(integrator="rk4", forces={"drag": {"quadratic": 0.1}}), 4), (dict(integrator="rk4", colliders=WALL), 2),
    (dict(integrator="rk4", interactions={"contacts": {}}), 2), (dict(forces=FIELD), 1), (dict(forces=FIELD, integrator="boris"), 2),
    (dict(integrator="rk4", forces={"curl_noise": {"strength": 1}}), 3), (dict(integrator="euler"), 1),
])  # fmt: skip
def test_the_order_to_expect(given, order):
    assert expected_order(piece(**given), "s") == order


@pytest.mark.parametrize("name", SMALL)
def test_the_large_presets_give_no_cause_for_advice(name):
    """Those of the course are drawn with AdviceWarning as an error in tests/test_course.py."""
    sim = ga.Simulation(ga.load_preset(name, overrides=SMALL[name]), advice="error")
    sim.advance_to_frame(15)
