"""The battery that every force goes through."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.forces import FORCES
from gen_art.forces.base import is_steady
from tests.physics.probe import probe, states
from tests.physics.references import CASES

UNSEEN = {
    "langevin": {"temperature", "boltzmann"},  # of its noise: test_langevin.py
    "aircraft": {"stall"},  # beyond it alone: test_controls.py
    # a longer axis, a place along a symmetry, a radius of 0, a limit not reached
    "aperture": {"axis[2]"}, "height_gravity": {"point[0]"}, "magnetic_loop": {"core"}, "magnetic_mirror": {"axis[1]"},
    # columns of its table take their place
    "attractor": {"pull", "x", "y"}, "hand": {"x", "y"}, "thruster": {"x"},
    "thrust": {"dry_mass"}, "vortex": {"axis[1]", "center[1]"},
}  # fmt: skip
BUILT_IN = sorted(n for n in FORCES if FORCES[n].__module__.startswith("gen_art."))


def test_every_force_has_a_canonical_instance():
    assert sorted(CASES) == BUILT_IN


@pytest.mark.parametrize("name", [n for n in BUILT_IN if CASES[n][1] != "noise"])  # the noise: test_noise.py
def test_formula(name):
    force, what, formula = CASES[name]
    p = states()
    push, magnetic, damping, _ = probe(force, p)
    found = {"push": push, "magnetic": magnetic, "damping": damping}[what]
    expected = formula(p)
    scale = np.abs(expected).max()
    tolerance = 1e-7 if name == "aperture" else 1e-13  # the aperture's reference is a difference quotient
    assert np.abs(found - expected).max() <= tolerance * scale
    # the mutants: a wrong sign and a wrong factor are caught
    assert np.abs(-found - expected).max() > 1e3 * tolerance * scale
    assert np.abs(1.0001 * found - expected).max() > tolerance * scale


def mutants(force):
    """A force's values with one number a per cent off, for every number it has."""
    for key, parameter in type(force).parameters.items():
        value = force.values[key]
        if value is None or parameter.kind not in ("float", "int", "vector", "range"):
            continue
        for at in range(np.size(value)):
            if parameter.kind in ("float", "int"):
                yield key, {**force.values, key: value + 1 if parameter.kind == "int" else 1.01 * value}
            else:  # a component: a direction or a place that leans, a vector that grows
                yield (
                    f"{key}[{at}]",
                    {
                        **force.values,
                        key: tuple(c + 0.05 * (max(map(abs, value)) or 1) * (k == at) for k, c in enumerate(value)),
                    },
                )


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_wrong_number_fails_the_formula(name):
    """The mutants: every number of every force is in the vectors that test_formula compares."""
    force, what, _ = CASES[name]
    p, unseen = states(), set()
    index = {"push": 0, "noise": 0, "magnetic": 1, "damping": 2}[what]
    right = probe(force, p)[index]
    for key, values in mutants(force):
        if np.abs(probe(type(force)(**values), p)[index] - right).max() <= 1e-6 * np.abs(right).max():
            unseen.add(key)
    assert unseen == UNSEEN.get(name, set())


@pytest.mark.parametrize("name", BUILT_IN)
def test_float32_agrees_with_float64(name):
    p = states()
    exact, rough = probe(CASES[name][0], p), probe(CASES[name][0], p, "f32")
    for a, b in zip(exact, rough):
        scale = max(np.abs(a).max(), 1e-30)
        assert np.abs(a - b).max() <= 3e-5 * scale
        assert b.dtype == np.float32


@pytest.mark.parametrize("name", [n for n in BUILT_IN if FORCES[n].conservative])
def test_conservative_force_is_minus_the_gradient(name):
    force = CASES[name][0]
    p = states()
    push = probe(force, p)[0] * p.mass
    h = 1e-5
    gradient = np.zeros_like(push)
    for c in range(3):
        plus, minus = states(), states()
        plus.position[c] += h
        minus.position[c] -= h
        gradient[c] = (probe(force, plus)[3] - probe(force, minus)[3]) / (2 * h)
    scale = np.abs(push).max()
    assert np.abs(push + gradient).max() <= 1e-6 * scale
    assert np.abs(push - gradient).max() > 0.1 * scale  # the mutant: a potential of the wrong sign


@pytest.mark.parametrize("name", BUILT_IN)
def test_docstring_has_a_formula_and_parameters_have_ranges(name):
    cls = FORCES[name]
    assert " = " in cls.__doc__
    for key, parameter in cls.parameters.items():
        if parameter.kind in ("float", "int") and parameter.default is not None:
            assert parameter.check(parameter.default) == parameter.default, key


@pytest.mark.parametrize("name", BUILT_IN)
def test_wrong_arguments_are_sentences(name):
    cls = FORCES[name]
    with pytest.raises(ga.UsageError, match="no parameter"):
        cls(nonsense=1.0)
    for key, parameter in cls.parameters.items():
        if parameter.kind == "float":
            with pytest.raises(ga.UsageError, match="finite"):
                cls(**{**CASES[name][0].values, key: float("nan")})
        if parameter.kind == "vector":
            with pytest.raises(ga.UsageError, match="three finite numbers"):
                cls(**{**CASES[name][0].values, key: (1.0, 2.0)})


def test_exponent_minus_one_has_a_logarithmic_potential():
    p = states()
    _, _, _, U = probe(ga.forces.CentralForce((0.0, 0.0, 0.0), 2.0, -1.0, 0.1), p)
    s = np.sqrt((p.position**2).sum(0) + 0.01)
    assert np.allclose(U, p.mass * 2.0 * np.log(s), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_particle_without_mass_is_refused_or_has_an_acceleration(name):
    force, p = CASES[name][0], states()
    try:
        force.check_mass(0.0)
    except ga.UsageError as error:
        assert "mass" in str(error)
        return
    p.mass = 0.0 * p.mass
    with np.errstate(all="ignore"):
        assert all(np.isfinite(part).all() for part in probe(force, p)[:3])


def test_reading_a_parameter_in_a_kernel_says_what_to_write():
    with pytest.raises(AttributeError, match=r"write q\.field"):
        _ = ga.forces.Gravity().field


def test_drag_by_cd_needs_a_density():
    with pytest.raises(ga.UsageError, match="density"):
        ga.ParticleSystem(position=np.zeros((1, 3)), forces=[ga.forces.Drag(cd=0.5)])


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_steady_force_knows_neither_time_nor_age_nor_velocity(name):
    force = CASES[name][0]
    p, later = states(), states()
    later.time, later.age, later.velocity = 1.9, later.age + 0.4, 2 * later.velocity
    same = all(np.array_equal(a, b) for a, b in zip(probe(force, p), probe(force, later)))
    assert is_steady(force) == (same and not force.provides("magnetic"))
