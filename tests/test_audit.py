"""The audit measures the expected orders, and reports a wrong scheme and a wrong ledger."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest

import gen_art as ga
from gen_art.audit import Trend, audit, measure
from gen_art.audit.advice import advice
from gen_art.integrators.schemes import INTEGRATORS
from gen_art.interactions.springs import Springs
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.preset.shipped import preset_names
from gen_art.preset.thinning import thinned
from gen_art.simulation.ledger import LedgerKeeper


def piece(forces, integrator="leapfrog", medium=None, **particle):
    system = {
        "particle": {"mass": "0.5..2", **particle},
        "integrator": integrator,
        "forces": forces,
        "emitters": {"all": {"count": 40, "shape": {"sphere": 1.0}, "velocity": {"sphere": "0.5..1.5"}}},
    }
    return ga.load_preset(
        {"version": 1, "seed": 3, "name": "small", "clock": {"duration": 1, "fps": 10, "step": "1/50"},
         "medium": medium or {}, "systems": {"s": system}}
    )  # fmt: skip


SPRING = {"spring": {"stiffness": 3}}


@pytest.mark.parametrize(
    "integrator,order",
    [("euler", 1), ("semi_implicit_euler", 1), ("leapfrog", 2), ("position_verlet", 2), ("rk2", 2), ("rk4", 4)],
)
def test_an_oscillator_converges_at_the_order_of_the_scheme(integrator, order):
    found = audit(piece(SPRING, integrator), time=0.5)
    positions, count = found.positions["s"]
    assert count == 40
    assert positions.order == pytest.approx(order, abs=0.2)
    assert found.energy["s"].order > order - 0.3
    assert found.momentum["s"].at_round_off
    assert found.invariants["s", "energy"].good and found.problems == []
    assert 0 < found.float32["s"] < 1e-5
    assert found.warnings == [] or integrator == "euler"


def test_drag_closes_to_round_off_and_says_that_an_order_means_nothing():
    found = audit(piece({"damping": 2.0}, "position_verlet", {"wind": [1, 0, 0]}), time=0.5)
    assert found.energy["s"].at_round_off and found.energy["s"].order is None
    assert "round-off: an order has no meaning" in found.text()
    assert found.booked["s", "energy"] == "worked on by damping"
    assert found.ledger.work["s.damping"] != 0 and found.problems == []


def test_a_magnetic_field_keeps_the_energy():
    found = audit(piece({"magnetic_field": [0, 0, 2]}, "boris", charge=1), time=0.5)
    assert found.invariants["s", "energy"].at_round_off
    assert found.invariants["s", "charge"].at_round_off and found.problems == []


def test_a_scheme_with_a_wrong_weight_is_found(monkeypatch):
    wrong = dataclasses.replace(INTEGRATORS["leapfrog"], stages=((0.5, 0.0, 1.0), (0.49, 1.0, 0.0)))
    monkeypatch.setitem(INTEGRATORS, "leapfrog", wrong)
    found = audit(piece(SPRING), time=0.5, precision="f64")
    assert any("positions do not converge as leapfrog should" in sentence for sentence in found.problems)
    assert any("energy should be conserved and is not" in sentence for sentence in found.problems)
    assert "NOT CLOSED" in found.text() and "Everything closes" not in found.text()


def test_wrong_books_are_found(monkeypatch):
    right = LedgerKeeper.record_step

    def wrong(self, name, *rest):
        right(self, name, *rest)
        self._rows_of[name][:, 0] *= 1.001  # work

    monkeypatch.setattr(LedgerKeeper, "record_step", wrong)
    found = audit(piece({"damping": 2.0}, "position_verlet", {"wind": [1, 0, 0]}), time=0.5, precision="f64")
    assert [s.split(":")[1].strip() for s in found.problems] == ["the ledger of energy does not close"]


def test_deaths_that_are_not_booked_are_found(monkeypatch):
    monkeypatch.setattr(LedgerKeeper, "record_deaths", lambda *_: None)
    found = audit(piece({"gravity": [0, -9.81, 0]}, lifetime="0.1..0.4"), time=0.5, precision="f64")
    assert any("births and deaths do not account for the mass" in sentence for sentence in found.problems)
    assert any("ledger of momentum does not close" in sentence for sentence in found.problems)


@pytest.mark.parametrize("forces,integrator,better", [
    ({"magnetic_field": [0, 0, 2]}, "leapfrog", "boris"), ({"magnetic_field": [0, 0, 2]}, "rk4", "boris"),
    (SPRING, "euler", "leapfrog"), (SPRING, "leapfrog", None), ({"magnetic_field": [0, 0, 2]}, "boris", None),
])  # fmt: skip
def test_an_integrator_that_does_not_suit_is_a_warning_with_the_better_choice(forces, integrator, better):
    sentences = advice(piece(forces, integrator, charge=1))
    assert (better is None) == (not sentences) and all(better in sentence for sentence in sentences)


def test_thinning_scales_rates_counts_and_what_events_feed():
    full = ga.load_preset("fireworks")
    few, changes = thinned(full, 9.0, 200)
    from gen_art.preset.estimate import estimate

    peak = estimate(few, "f64", 9.0).peak
    assert max(n for name, n in peak.items() if name != "jetty") < 300  # the points of rigid bodies stay
    path = "systems.stars.emitters.peony.count"
    assert changes[path][0] == 340 and changes[path][1] % 2 == 0  # balanced pairs stay pairs
    assert few.seed == full.seed and few.name == full.name
    assert thinned(few, 9.0, 300)[1] == {}


def test_fewer_bodies_of_their_own_gravity_attract_as_much_in_all():
    """Mutants: no mass is changed; masses are changed where other forces act on them too."""

    def total(forces):
        cloud = {
            "particle": {"mass": 0.001},
            "forces": forces,
            "interactions": {"self_gravity": {"softening": 0.05}},
            "emitters": {"all": {"count": 5000, "shape": {"ball": 1}}},
        }
        clock = {"duration": 1, "fps": 10, "step": "1/50"}
        few, changes = thinned(
            ga.load_preset({"version": 1, "name": "cloud", "clock": clock, "systems": {"s": cloud}}), 0.5, 50
        )
        sim = ga.Simulation(few, precision="f64")
        sim.step()
        assert sim["s"].count == 200 and ("systems.s.particle.mass" in changes) == (not forces)
        return sim["s"].mass.sum()

    assert total({}) == pytest.approx(5, rel=1e-5)
    assert total({"damping": 1}) == pytest.approx(0.2)


@pytest.mark.parametrize("time", [-1, float("nan"), 99, 0.0133, 0])
def test_a_bad_time_is_a_sentence(time):
    with pytest.raises(ga.UsageError, match="film time"):
        audit(piece(SPRING), time=time)


def kinked(integrator, seed, count=1):
    plain = piece({"drag": {"linear": 0.5, "quadratic": 0.4}}, integrator).resolved()
    plain["medium"] = {"wind": [1, 0, 0], "curl_noise": {"strength": 1.0, "scale": 0.5, "speed": 1.5, "octaves": 2}}
    plain["seed"], plain["systems"]["s"]["emitters"]["all"]["count"] = seed, count
    return ga.load_preset(plain)


@pytest.mark.parametrize("integrator,seed", [("rk4", 3), ("yoshida4", 4)])
def test_the_luck_of_a_few_particles_with_kinks_is_no_fault(integrator, seed):
    """One particle in noise whose second derivatives have kinks: its error at dt may be small by chance, and grow at dt/2."""
    found = audit(kinked(integrator, seed), time=0.5, precision="f64")
    trend, _ = found.positions["s"]
    assert trend.order < 1 and trend.is_scatter and found.problems == []
    assert "by chance: kinks of the field" in found.text()
    assert trend.scatter < 1e-5  # of the extent


@pytest.mark.parametrize("count", [1, 40])
def test_a_wrong_scheme_is_found_among_kinks(monkeypatch, count):
    """The mutant: rk4 with a weight off by 0.01 is of order 1, and no scatter hides it."""
    right = INTEGRATORS["rk4"]
    (first, *more), *rest = right.stages
    monkeypatch.setitem(INTEGRATORS, "rk4", dataclasses.replace(right, stages=((first + 0.01, *more), *rest)))
    found = audit(kinked("rk4", 3, count), time=0.5, precision="f64")
    assert any("positions do not converge as rk4 should" in sentence for sentence in found.problems)


@pytest.mark.parametrize("method", ["implicit", "xpbd"])
def test_what_backward_euler_takes_of_stiff_springs_is_booked(monkeypatch, method):
    """Springs with w dt = 7 lose energy to the scheme; the ledger has it, and what remains falls at order 1."""
    rope = ga.load_preset({
        "version": 1, "name": "rope", "clock": {"duration": 1, "fps": 10, "step": "1/400"},
        "forces": {"gravity": [0, -9.81, 0]},
        "systems": {"s": {
            "integrator": "semi_implicit_euler", "particle": {"mass": 0.01},
            "interactions": {"springs": {"stiffness": 20000, "method": method}},
            "emitters": {"a": {"chain": {"start": [0, 0, 0], "end": [1, 0.2, 0], "count": 30, "pinned": "start"}}},
        }},
    })  # fmt: skip
    found = audit(rope, 0.5, precision="f64")
    assert found.problems == []
    assert found.energy["s"].order == pytest.approx(1, abs=0.1)
    taken = found.ledger.dissipated["s.springs"]
    assert taken > 5 * found.energy["s"].values[0] * found.ledger.scale
    right = Springs.dissipated
    # the mutant: 0.03 W are booked that nothing takes, a hundredth of the energy that moves
    monkeypatch.setattr(
        Springs, "dissipated", lambda self, state, before, dt: right(self, state, before, dt) + 0.03 * dt
    )
    assert any("ledger of energy does not close" in sentence for sentence in audit(rope, 0.5, precision="f64").problems)


def test_an_order_needs_something_above_round_off():
    assert Trend((1e-3, 2.5e-4, 6.2e-5), 2).good and not Trend((1e-3, 5e-4, 2.5e-4), 2).good
    assert Trend((1e-16, 3e-13, 1e-12), 2).order is None and not Trend((1e-16, 1e-9, 1e-6), 2).good
    assert not Trend((float("nan"), 1e-3, 1e-4), 2).good


@pytest.mark.proof
@pytest.mark.parametrize("name", preset_names())
def test_every_shipped_preset_closes(name):
    found = audit(name)
    assert found.problems == [] and found.warnings == []


@pytest.mark.parametrize("name", preset_names())
def test_every_shipped_preset_closes_over_a_short_time(name):
    short = ga.load_preset(name, overrides={"clock.preroll": 0})
    step = max(8, short.clock.steps_per_frame) * short.clock.step / short.clock.speed
    found = audit(short, time=step, precision="f64", particles=100)
    assert [sentence for sentence in found.problems if "ledger" in sentence or "account" in sentence] == []
    json.dumps(found.as_dict(), allow_nan=False)


def test_fast_charges_close_too():
    fast = piece({"magnetic_field": [0, 0, 2], "electric_field": [0.3, 0.1, 0.2]}, "higuera_cary", charge=1)
    plain = fast.resolved()
    plain["systems"]["s"]["speed_of_light"] = 1.6
    found = audit(ga.load_preset(plain), time=0.5, precision="f64")
    assert found.problems == found.warnings == []
    assert found.invariants["s", "energy"].order == pytest.approx(2, abs=0.3)
    assert found.momentum["s"].at_round_off


def test_a_cloth_is_never_thinned():
    piece = ga.load_preset("course/flag")
    assert thinned(piece, 1.0, 10) == (piece, {})


def boxed(forces, axes="xyz", **keys):
    """Forty particles of a periodic box, without births after the start."""
    system = {
        "particle": {"mass": 1, "radius": 0.05},
        "forces": forces,
        "emitters": {"all": {"count": 40, "shape": {"sphere": 0.9}, "velocity": {"sphere": "0.5..1.5"}}},
    }
    return ga.load_preset(
        {"version": 1, "seed": 3, "clock": {"duration": 1, "fps": 10, "step": "1/100"},
         "domain": {"periodic": {"min": [-1, -1, -1], "max": [1, 1, 1], "axes": axes}}, "systems": {"s": {**system, **keys}}}
    )  # fmt: skip


def test_a_periodic_box_keeps_what_it_can(monkeypatch):
    """Energy and momentum of a free gas; not angular momentum. Paths of two steps are compared by nearest images."""
    found = audit(boxed({}), time=1)
    assert found.booked == {("s", "angular momentum"): "turned by the periodic boundary"}
    assert found.invariants["s", "energy"].at_round_off and found.invariants["s", "momentum"].at_round_off
    assert found.problems == [] and found.positions["s"][0].at_round_off
    lost = max(run.drifts["s", "angular momentum"] for run in found.runs)
    assert lost > 0.01  # expecting it would be wrong
    paths = found.runs[0].history.paths["s"]
    assert np.isnan(paths).any() and np.nanmax(np.abs(np.diff(paths, axis=1))) < 1


@pytest.mark.parametrize(
    "forces,axes,energy",
    [
        ({"gravity": [0, -2, 0]}, "xz", None),
        ({"gravity": [0, -2, 0]}, "xyz", "worked on by the periodic boundary"),
        ({"spring": {"stiffness": 1, "center": [0.5, 0, 0]}}, "x", "worked on by the periodic boundary"),
    ],
)
def test_potentials_that_jump_at_the_sides_are_booked(forces, axes, energy):
    found = audit(boxed(forces, axes), time=1)
    assert found.booked.get(("s", "energy")) == energy
    assert found.problems == []
    assert abs(found.ledger.work["s.periodic_boundary"]) > 0.5 or axes == "xz"


def test_a_jump_that_is_not_booked_is_found(monkeypatch):
    from gen_art.simulation import ledger

    report = LedgerKeeper.report

    def forgetful(self):
        found = report(self)
        forgotten = found.work.pop(f"s.{ledger.BOUNDARY}")
        return dataclasses.replace(found, residual=found.residual + forgotten)

    monkeypatch.setattr(LedgerKeeper, "report", forgetful)
    assert any("energy does not close" in problem for problem in audit(boxed({"gravity": [0, -2, 0]}), time=1).problems)


def test_places_at_two_sides_of_a_periodic_box_are_near():
    box = PeriodicBox((-1, -1, -1), (1, 1, 1), "x")
    left, right = np.array([[-0.999, 0, 0], [-0.998, 0.5, 0]]), np.array([[0.999, 0, 0], [0.999, 0.5, 0]])
    runs = [SimpleNamespace(places={"s": (np.arange(2), x)}, box=box) for x in (left, right)]
    trend, count = measure.positions(runs, "s", 2)
    assert count == 2 and trend.values[0] == pytest.approx(0.0025 / 0.999, rel=1e-9)
    for run in runs:
        run.box = None
    assert measure.positions(runs, "s", 2)[0].values[0] > 1.9  # in open space they are far apart
