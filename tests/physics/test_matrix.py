"""The matrix: every force in a step, every integrator with two forces and with a pair force, and what makes no sense together."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import gen_art as ga
from gen_art.forces import FORCES
from gen_art.integrators import INTEGRATORS
from tests.physics.probe import FLOW, probe, states
from tests.physics.references import CASES

F, I = ga.forces, ga.interactions
BUILT_IN = sorted(n for n in FORCES if FORCES[n].__module__.startswith("gen_art."))
H, FIRST = 0.1, 7  # thrust is lit from 0.5 to 1.0 s


DRAGS = ["damping", "drag"]
NOISY = ["langevin"]  # whose noise test_langevin.py measures


@pytest.fixture(scope="module", params=["position_verlet", "euler"])
def together(request):
    """One step under every force at once but drag, or under drag: the change of velocity over dt, and each part by NumPy."""
    p = states()
    names = DRAGS if request.param == "euler" else [n for n in BUILT_IN if n not in (*DRAGS, *NOISY)]
    system = ga.ParticleSystem(
        position=p.position.T, velocity=p.velocity.T, mass=p.mass, charge=p.charge, radius=p.radius,
        attributes={name: getattr(p, name) for name in ("area", "normal_x", "normal_y", "normal_z")},
        forces=[CASES[name][0] for name in names], medium=ga.Medium(wind=FLOW), integrator=request.param,
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=H, precision="f64")
    sim.steps_done = FIRST
    keys = sim["s"].keys
    p.key = np.stack([keys >> np.uint64(32), keys & np.uint64(0xFFFFFFFF)]).astype(np.uint32)
    p.time, p.age = FIRST * H, np.full(p.mass.size, FIRST * H)
    if request.param == "position_verlet":  # the kick is in the middle, where half of the step's propellant is gone
        p.time, p.age, p.position = p.time + H / 2, p.age + H / 2, p.position + p.velocity * H / 2
        p.mass = p.mass - CASES["thrust"][0].values["mass_rate"] * H / 2
    sim.step(1)
    return (sim["s"].velocity.T - p.velocity) / H, {name: part(name, p) for name in names}


def part(name, p):
    """The acceleration (3, n) that a force gives by its NumPy formula."""
    force, what, formula = CASES[name]
    if what == "noise":  # its own pattern, which test_noise.py proves
        return probe(force, p)[0]
    found = formula(p)
    if what == "magnetic":
        return np.cross(p.velocity.T, found.T).T * p.charge / p.mass
    if what == "damping":
        w = p.velocity - p.flow
        return -(found[0] + found[1] * np.linalg.norm(w, axis=0)) * w
    return found


def test_every_force_acts_in_a_step_as_its_formula_says(together):
    found, parts = together
    total = sum(parts.values())
    close = 1e-7 * np.abs(found).max()  # aperture's formula is a difference quotient
    assert np.abs(found - total).max() <= close
    for name, own in parts.items():  # the mutants: left out, a wrong sign, a wrong factor
        for wrong in (0.0, -1.0, 1.001):
            assert np.abs(found - total - (wrong - 1) * own).max() > close, (name, wrong)


def test_no_force_is_left_out():
    assert sorted(CASES) == BUILT_IN and set(DRAGS + NOISY) == {n for n in BUILT_IN if FORCES[n].provides("damping")}


def end(integrator, n, forces, interactions=(), scheme=None):
    """Positions (3, 3) of three bodies after a second in n steps."""
    bodies = ga.ParticleSystem(
        position=[[1.0, 0, 0], [-0.6, 0.5, 0.2], [0.1, -1.1, 0.4]], velocity=[[0, 0.8, 0.1], [-0.4, 0, 0.5], [0.3, 0.2, 0]],
        mass=[1.0, 2.0, 1.5], charge=[1.0, -0.5, 2.0], forces=forces, interactions=list(interactions),
        integrator=integrator,
    )  # fmt: skip
    bodies.scheme = scheme or bodies.scheme
    sim = ga.Simulation({"s": bodies}, dt=1.0 / n, precision="f64")
    sim.step(n)
    return sim["s"].position


def order_of(integrator, forces, interactions=()):
    """The order at which positions converge at dt, dt/2 and dt/4."""
    a, b, c = (end(integrator, n, forces, interactions) for n in (40, 80, 160))
    return float(np.log2(np.abs(a - b).max() / np.abs(b - c).max()))


TWO = [F.Spring(stiffness=6.0, rest_length=0.3), F.PointGravity((0.2, -0.3, 2.0), 1.5, 0.1)]
CHARGED = [F.Spring(stiffness=6.0), F.MagneticField((0.3, -1.0, 2.0)), F.ElectricField((0.5, 0.2, -0.4))]


@pytest.mark.parametrize("name", INTEGRATORS)
def test_every_integrator_keeps_its_order_with_two_forces(name):
    forces = CHARGED if INTEGRATORS[name].pusher else TWO
    assert order_of(name, forces) == pytest.approx(INTEGRATORS[name].order, abs=0.15)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_every_integrator_keeps_its_order_with_an_interaction(name):
    found = order_of(name, TWO[:1], [I.SelfGravity(G=0.7, softening=0.5)])
    assert found == pytest.approx(INTEGRATORS[name].order, abs=0.15)


DRIVEN = [*TWO, F.Driver(3.0, 1.3, 0.4, (1.0, 2.0, 2.0))]


@cache
def truth():
    return end("rk4", 2000, DRIVEN)


def order_against_the_truth(scheme):
    errors = [np.abs(end(scheme.name, n, DRIVEN, scheme=scheme) - truth()).max() for n in (40, 80)]
    return float(np.log2(errors[0] / errors[1]))


def mutants(scheme):
    """The scheme with one of its numbers off by a tenth, and with the kick and the drift of its first stage swapped."""
    kick, time, drift = scheme.stages[0]
    yield "kick and drift swapped", replace(scheme, stages=((drift, time, kick), *scheme.stages[1:]))
    if scheme.first_drift:
        yield "first drift", replace(scheme, first_drift=1.1 * scheme.first_drift)
    for g, stage in enumerate(scheme.stages):
        for at, what in enumerate(
            ("kick", "time", "drift") if scheme.kind == "splitting" else ("weight", "time", "next")
        ):
            if stage[at] or (what == "time" and stage[0]):
                wrong = (*stage[:at], stage[at] + 0.1, *stage[at + 1 :])
                yield f"{what} {g}", replace(scheme, stages=(*scheme.stages[:g], wrong, *scheme.stages[g + 1 :]))


@pytest.mark.parametrize("name", ["leapfrog", "position_verlet", "yoshida4", "rk2", "rk4"])
def test_a_mutant_of_a_scheme_loses_its_order(name):
    right = INTEGRATORS[name]
    assert order_against_the_truth(right) == pytest.approx(right.order, abs=0.15)
    for what, wrong in mutants(right):
        assert order_against_the_truth(wrong) < right.order - 0.4, what


PAIR = np.array([[0.0, 0, 0], [1.0, 0, 0]])


def system(**more):
    return ga.ParticleSystem(**{"position": PAIR, "integrator": "leapfrog", **more})


def simulated(dt=0.01, ledger=False, **systems):
    return ga.Simulation(systems, dt=dt, ledger=ledger)


IMPLICIT = {"pairs": [[0, 1]], "stiffness": 5.0, "method": "implicit"}
LIGHT = {"integrator": "vay", "speed_of_light": 3.0}
REFUSED = {
    "implicit springs off their integrator": (
        lambda: simulated(s=system(interactions=[I.Springs(**IMPLICIT)])), "beside the kick of semi_implicit_euler"
    ),
    "speed of light without a pusher": (lambda: system(speed_of_light=3.0), "needs an integrator for charges .* not leapfrog"),
    "exact gyration without a pusher": (lambda: system(exact_gyration=True), "exact_gyration needs an integrator for charges"),
    "no speed of light": (lambda: system(integrator="boris", speed_of_light=0.0), "above 0"),
    "faster than light": (lambda: system(**LIGHT, velocity=PAIR * 3.0), "below the speed of light"),
    "light and drag": (lambda: system(**LIGHT, forces=[F.Drag(0.1)]), "drag is not relativistic"),
    "light and damping": (lambda: system(**LIGHT, forces=[F.Damping(0.1)]), "damping is not relativistic"),
    "light and thrust": (lambda: system(**LIGHT, forces=[F.Thrust()]), "thrust takes mass"),
    "light and colliders": (lambda: system(**LIGHT, colliders=[ga.colliders.Plane()]), "colliders bounce slow particles"),
    "light and contacts": (lambda: system(**LIGHT, interactions=[I.Contacts()]), "losses of contacts are not relativistic"),
    "light and damped springs": (
        lambda: system(**LIGHT, interactions=[I.Springs(pairs=[[0, 1]], damping=1.0)]), "losses of springs are not"
    ),
    "two integrators joined by a force": (
        lambda: simulated(a=system(interactions=[I.SelfGravity(sources="b")]), b=system(integrator="rk4")), "same integrator"
    ),
    "gravity of an unknown system": (
        lambda: simulated(a=system(interactions=[I.SelfGravity(sources="bb")]), b=system()), "did you mean 'b'"
    ),
    "an unknown integrator": (lambda: system(integrator="leapfrg"), "did you mean 'leapfrog'"),
    "springs between particles without mass": (
        lambda: simulated(s=system(mass=[1.0, 0.0], interactions=[I.Springs(pairs=[[0, 1]])])), "has no mass"
    ),
    "thrust of a particle too light": (lambda: system(mass=1e-9, forces=[F.Thrust(dry_mass=1.0)]), "mass"),
    "drag by cd without a density": (lambda: system(forces=[F.Drag(cd=0.5)]), "density"),
    "a medium that is no field": (lambda: ga.Medium(field=F.Drag(0.1)), "not a vector field"),
    "an interaction among the forces": (lambda: system(forces=[I.SelfGravity()]), "forces must be"),
    "a force among the interactions": (lambda: system(interactions=[F.Gravity()]), "interactions must be"),
    "a force among the colliders": (lambda: system(colliders=[F.Gravity()]), "colliders must be"),
    "a system in two simulations": (lambda: [simulated(s=one) for one in [system()] * 2], "already"),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_what_makes_no_sense_together_is_refused_with_a_sentence(what):
    make, words = REFUSED[what]
    with pytest.raises(ga.UsageError, match=words) as told:
        make()
    assert len(str(told.value).split()) > 3


@pytest.mark.parametrize("walls", [False, pytest.param(True, marks=pytest.mark.proof)])
def test_implicit_springs_burn_and_bounce_as_explicit_ones(walls):
    """An implicit step is one step, whatever stands in it: propellant burns once, and a path meets a wall once."""
    ends = []
    for method in ("implicit", "explicit"):
        one = ga.ParticleSystem(
            position=PAIR + [0, 0.05, 0], mass=2.0, radius=0.01, integrator="semi_implicit_euler",
            forces=[F.Gravity(), F.Thrust((0, 1, 0), 0.3, 0.2)], colliders=[ga.colliders.Plane(restitution=0.8)] * walls,
            interactions=[I.Springs(pairs=[[0, 1]], stiffness=1.0, method=method)],
        )  # fmt: skip
        sim = ga.Simulation({"s": one}, dt=0.01, precision="f64", ledger=walls)
        sim.step(30)
        assert sim["s"].mass == pytest.approx([2 - 0.2 * 0.3] * 2, rel=1e-12)
        books = (sim.ledger().residual, *sim.ledger().momentum_residual) if walls else ()
        ends.append((*sim["s"].position.ravel(), *books))
    assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-12)
