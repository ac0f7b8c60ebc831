"""`expect:` and `check`: what holds, what does not, and what could not fail."""

import math

import numpy as np
import pytest

import gen_art as ga
from gen_art.audit.expectations import check
from gen_art.audit.observables import period, value_of
from gen_art.output.recipe import version
from gen_art.preset.shipped import course_names, preset_names
from gen_art.preset.verdicts import verdict_of

K = math.pi**2  # of a mass of 1 kg: a period of 2 s


def bob(expect, **changes):
    """A mass on a spring, 1 m from rest."""
    return {
        "version": 1, "clock": {"duration": 10, "fps": 30, "step": "1/120"}, "forces": {"spring": {"stiffness": K}},
        "systems": {
            "bob": {
                "integrator": "leapfrog", "look": {"draw": "point"},
                "emitters": {"one": {"count": 1, "mass": 1, "shape": {"point": [1, 0, 0]}}},
            }
        },
        "expect": expect, **changes,
    }  # fmt: skip


STIFFER = {"forces.spring.stiffness": 1.1 * K}


def found(expect, **changes):
    result = check(bob(expect, **changes))
    assert len(result.findings) == 1
    return result.findings[0]


def test_a_period_and_its_order():
    """Leapfrog's is shorter by (w dt)^2 / 24 of it, a fourth of that at dt/2; a passage between samples errs by (w dt)^3."""
    one = found({"time": 9, "period": {"of": "bob.x", "is": 2.0, "within": 0.01}, "mutant": STIFFER})
    assert one.verdict == "holds"
    for division, measured in zip((1, 2, 4), one.measured):
        angle = math.pi / 120 / division
        assert measured == pytest.approx(2.0 * (1 - angle**2 / 24), abs=2 * angle**3)
    assert one.mutant_error == pytest.approx(1 - 1 / math.sqrt(1.1), rel=0.01)


def test_what_cannot_be_measured_is_said():
    short = check(bob({"time": 2, "period": {"of": "bob.x", "is": 2.0}, "mutant": STIFFER}))
    assert short.findings[0].verdict == "does not hold" and "give a longer expect.time" in short.text()


def test_a_claim_that_is_wrong_does_not_hold():
    wrong = {"time": 9, "period": {"of": "bob.x", "is": 2.1, "within": 0.01}, "mutant": STIFFER}
    assert found(wrong).verdict == "does not hold"
    assert not check(bob(wrong)).good


@pytest.mark.parametrize(
    "expect",
    [
        {"time": 9, "period": {"of": "bob.x", "is": 2.0, "within": 0.2}, "mutant": STIFFER},  # too loose
        {
            "time": 9,
            "period": {"of": "bob.x", "is": 2.0},
            "mutant": {"systems.bob.emitters.one.shape.point": [2, 0, 0]},
        },
        {"energy": 0.5},
        {"ledger": {"energy": 0.5}},
    ],
)
def test_a_claim_that_its_mutant_keeps_cannot_fail(expect):
    assert found(expect).verdict == "cannot fail"


def test_energy_drifts_by_what_leapfrog_lets_it():
    """The error of the energy swings by (w dt)^2 / 4 of it, and the mutant's by twice the share of the velocity or less."""
    one = found({"time": 9, "energy": 1e-3})
    angle = math.pi / 120
    assert one.verdict == "holds" and one.measured[0] <= angle**2 / 4 * 1.01
    assert one.measured[2] == pytest.approx(one.measured[0] / 16, rel=0.05)
    assert found({"time": 9, "energy": 1e-6}).verdict == "does not hold"


def test_momentum_of_two_is_kept_to_round_off_and_of_one_is_not():
    pair = {
        "version": 1, "units": {"G": 1}, "clock": {"duration": 2, "step": "1/120"},
        "systems": {
            "stars": {
                "integrator": "leapfrog", "interactions": {"self_gravity": {"softening": 0.1}},
                "emitters": {
                    "a": {"count": 1, "mass": 2, "shape": {"point": [1, 0, 0]}, "velocity": [0, 0.3, 0]},
                    "b": {"count": 1, "mass": 1, "shape": {"point": [-1, 0, 0]}, "velocity": [0, -0.6, 0]},
                },
            }
        },
        "expect": {"momentum": 0, "angular_momentum": {"drift": 0, "of": "stars"}, "mass": 0, "energy": 1e-3},
    }  # fmt: skip
    result = check(pair)
    assert result.good and [one.verdict for one in result.findings] == ["holds"] * 4
    assert check({**pair, "forces": {"gravity": [0, -1, 0]}}).findings[1].verdict == "does not hold"


def test_the_ledger_of_a_fall_with_drag_closes():
    fall = bob({"ledger": {"energy": 1e-3, "momentum": 1e-9}}, forces={"gravity": [0, -9.81, 0], "damping": 0.5})
    energy, momentum = check(fall).findings
    assert energy.verdict == momentum.verdict == "holds"
    assert check({**fall, "expect": {"energy": 1e-3}}).findings[0].verdict == "does not hold"


def test_values_and_bounds():
    at = {"of": "bob.x", "is": math.cos(math.pi * 1.25), "within": 1e-3, "at": 1.25}
    assert found({"value": at, "mutant": STIFFER}).verdict == "holds"
    assert found({"value": {**at, "at": 1.2}, "mutant": STIFFER}).verdict == "does not hold"
    assert found({"value": {"of": "bob.vy", "is": 0, "within": 1e-9, "mutant": {"forces.gravity": [0, -1, 0]}}}).good
    softer = {"forces.spring.stiffness": K / 2}
    speeds = {"of": "bob.speed", "over": "largest", "to": math.pi * 1.001}
    assert found({"range": speeds, "mutant": {"forces.spring.stiffness": 1.2 * K}}).good
    late = {"of": "bob.x", "from": 0.99, "after": 1.97}  # after nearly a whole swing
    assert found({"range": late, "mutant": softer}).verdict == "holds"
    assert found({"range": {**late, "after": 1.5}, "mutant": softer}).verdict == "does not hold"
    energy = {"of": "bob.energy", "from": 0.4999 * K, "to": 0.5001 * K, "mutant": STIFFER}
    assert found({"range": energy}).verdict == "holds"


def test_quantities_are_what_they_say():
    particles = ga.ParticleSystem(
        position=[[3, 4, 0], [0, 0, 1]],
        velocity=[[1, 2, 2], [0, 0, -1]],
        mass=[2, 1],
        charge=[1, -3],
        radius=[0.1, 0.3],
    )
    sim = ga.Simulation({"s": particles}, dt=0.1, precision="f64", advice="none")

    def of(quantity, over="mean"):
        return value_of(sim, f"s.{quantity}", over)

    assert (of("x"), of("vy"), of("distance"), of("speed")) == pytest.approx((1.5, 1.0, 3.0, 2.0))
    assert (of("distance", "least"), of("distance", "largest"), of("x", "rms")) == pytest.approx(
        (1, 5, 3 / math.sqrt(2))
    )
    assert (of("mass"), of("charge"), of("radius"), of("count")) == pytest.approx((1.5, -1, 0.2, 2))
    assert (of("momentum_x"), of("momentum_z"), of("kinetic_energy")) == pytest.approx((2, 3, 9.5))
    assert of("angular_momentum_z") == pytest.approx(2 * (3 * 2 - 4 * 1)) and of("energy") == pytest.approx(9.5)


def test_period_of_a_sine():
    """A passage is interpolated linearly between moments: an error of the third order in the angle between them."""
    t = np.linspace(0, 10, 400)
    angle = 2 * math.pi / 0.7 * t[1]
    assert period(t, np.sin(2 * math.pi * t / 0.7 + 1)) == pytest.approx(0.7, rel=angle**3)
    assert math.isnan(period(t, np.sin(2 * math.pi * t / 12)))
    assert math.isnan(period(t, np.ones(400)))


def test_a_rigid_body_is_disturbed_too():
    """Its velocity is its own, not its particles'."""
    body = {
        "version": 1, "clock": {"duration": 1, "step": "1/60"},
        "systems": {
            "top": {
                "integrator": "leapfrog", "interactions": {"rigid": {}},
                "emitters": {"b": {"body": {"shape": {"box": [0.2, 0.5, 1]}, "spin": [0, 5, 0.1]}}},
            }
        },
        "expect": {"angular_momentum": 1e-9, "ledger": {"energy": 1e-9}},
    }  # fmt: skip
    assert check(body).good


@pytest.mark.parametrize(
    "expect, says",
    [
        ({}, "expects nothing"),
        ({"energi": 1}, "did you mean 'energy'"),
        ({"energy": -1}, "at least 0"),
        ({"energy": {"drift": 1e-3, "of": "bop"}}, "no system 'bop'; did you mean 'bob'"),
        ({"ledger": {"of": "bob"}}, "needs energy, momentum or both"),
        ({"period": {"of": "bob.x", "is": 2}}, "needs a mutant"),
        ({"period": {"of": "bob", "is": 2}, "mutant": STIFFER}, "SYSTEM.QUANTITY"),
        ({"period": {"of": "bob.sped", "is": 2}, "mutant": STIFFER}, "no quantity 'sped'; did you mean 'speed'"),
        ({"period": {"of": "bob.two.x", "is": 2}, "mutant": STIFFER}, "no emitter 'two'"),
        ({"period": {"of": "bob.x", "is": 0}, "mutant": STIFFER}, "more than 0"),
        ({"value": {"of": "bob.x", "is": "soon"}, "mutant": STIFFER}, "must be a number"),
        ({"value": {"of": "bob.x", "is": 1, "over": "median"}, "mutant": STIFFER}, "mean, least, largest, rms"),
        ({"range": {"of": "bob.x"}, "mutant": STIFFER}, "needs from, to or both"),
        ({"range": {"of": "bob.x", "from": 2, "to": 1}, "mutant": STIFFER}, "at least 2"),
        ({"energy": 1, "mutant": 7}, "changes of the preset by their path"),
    ],
)
def test_what_is_wrong_is_said_where_it_stands(expect, says):
    with pytest.raises(ga.PresetError, match=says):
        ga.load_preset(bob(expect))


def test_what_only_a_run_can_tell():
    with pytest.raises(ga.UsageError, match="expects nothing"):
        check({key: value for key, value in bob(None).items() if key != "expect"})
    with pytest.raises(ga.UsageError, match="lies beyond the preset"):
        check(bob({"time": 30, "energy": 1}))
    with pytest.raises(ga.UsageError, match=r"about film time 5 s, but the check ends at 2 s: give a longer"):
        check(bob({"value": {"of": "bob.x", "is": 1, "at": 5}, "mutant": STIFFER}))
    with pytest.raises(ga.UsageError, match="the mutant of preset is no preset"):
        check(bob({"time": 9, "period": {"of": "bob.x", "is": 2.0}, "mutant": {"forces.sprnig.stiffness": 1}}))


@pytest.mark.parametrize("name", [*preset_names(), *course_names()])
def test_every_shipped_preset_is_checked(name):
    """By `make verdicts`, since its physics or the version changed; continuous integration runs the checks themselves."""
    verdict = verdict_of(ga.load_preset(name), version())
    assert verdict and verdict["verdict"] == "good", f"{name}: run make verdicts"
