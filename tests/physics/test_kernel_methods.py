"""A user's force that cannot be right is refused by a sentence, before it is compiled."""

import linecache

import numpy as np
import pytest

import gen_art as ga
from gen_art import ti


@ti.func
def jitter(x):
    return x * ti.random()


def system(force, n=20, **more):
    return ga.ParticleSystem(position=np.random.default_rng(1).normal(size=(n, 3)), forces=[force], **more)


def test_random_numbers_of_taichi_are_refused_by_name():
    with pytest.raises(
        ga.UsageError, match=r"Shaken\.acceleration calls random, whose numbers differ .*p\.key.*langevin"
    ):

        class Shaken(ga.Force):
            @ti.func
            def acceleration(self, p, t, q):
                return p.position * ti.random()


def test_and_those_of_a_function_that_the_force_calls():
    with pytest.raises(ga.UsageError, match=r"Trembling\.force calls random"):

        class Trembling(ga.Force):
            @ti.func
            def force(self, p, t, q):
                return jitter(p.position)


def test_an_attribute_or_a_function_of_another_name_is_no_random_number():
    class Calm(ga.Force):
        strength: float = ga.param(1.0)

        @ti.func
        def acceleration(self, p, t, q):
            return ga.sin(p.position) * q.strength

    ga.Simulation({"s": system(Calm())}, dt=0.1).step(1)


def test_a_method_without_ti_func():
    with pytest.raises(ga.UsageError, match=r"Plain\.acceleration runs in a kernel: write @ti\.func above it"):

        class Plain(ga.Force):
            def acceleration(self, p, t, q):
                return p.position


def test_a_shape_and_a_collider_without_ti_func():
    with pytest.raises(ga.UsageError, match=r"Dot\.place runs in a kernel"):

        class Dot(ga.Shape):
            def place(self, r, t, q):
                return 0


def test_a_parameter_that_is_not_there():
    with pytest.raises(
        ga.UsageError,
        match=r"Pull\.acceleration reads q\.strenth, but Pull has the parameters strength; did you mean 'strength'",
    ):

        class Pull(ga.Force):
            strength: float = ga.param(1.0)

            @ti.func
            def acceleration(self, p, t, q):
                return -q.strenth * p.position


def test_an_attribute_that_particles_do_not_have():
    class Hot(ga.Force):
        @ti.func
        def acceleration(self, p, t, q):
            return p.position * p.heat + p.velocty

    with pytest.raises(ga.UsageError, match=r"Hot\.acceleration reads p\.velocty, .* did you mean 'velocity'"):
        system(Hot(), attributes={"heat": 1.0})

    class Warm(ga.Force):
        @ti.func
        def acceleration(self, p, t, q):
            return p.position * p.heat

    with pytest.raises(ga.UsageError, match=r"Warm\.acceleration reads p\.heat, .* declare it as an attribute"):
        system(Warm())
    ga.Simulation({"s": system(Warm(), attributes={"heat": 1.0})}, dt=0.01).step(1)


class Well(ga.Force):
    """F = -factor m x, and a potential with another factor."""

    factor: float = ga.param(1.0)
    other: float = ga.param(1.0)
    conservative = True

    @ti.func
    def acceleration(self, p, t, q):
        return -q.factor * p.position

    @ti.func
    def potential(self, p, t, q):
        return 0.5 * q.other * p.mass * p.position.dot(p.position)


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("other", [2.0, -1.0, 1.01])
def test_a_potential_that_is_not_the_forces(precision, other):
    with pytest.raises(
        ga.UsageError, match=r"Well: its potential is not that of its force: at \(.*'s' the force is .* is a sign"
    ):
        ga.Simulation({"s": system(Well(other=other), mass=3.0)}, dt=0.01, precision=precision)


@pytest.mark.parametrize("place", [1e-6, 1.0, 1e6])
def test_a_potential_that_is_the_forces(place):
    right = system(Well(factor=5.0, other=5.0), mass=0.3)
    ga.Simulation({"s": right}, dt=0.01)
    far = ga.ParticleSystem(position=[[place, 0, 0], [0, -place, 2 * place]], forces=[Well()])
    ga.Simulation({"s": far}, dt=0.01)


def test_what_only_the_compiler_sees_is_a_sentence_too():
    class Flat(ga.Force):
        @ti.func
        def acceleration(self, p, t, q):
            return p.position + ti.Vector([1.0, 2.0])

    sim = ga.Simulation({"s": system(Flat())}, dt=0.1)
    with pytest.raises(
        ga.UsageError,
        match=r"^acceleration cannot be compiled: unsupported operand .*test_kernel_methods.*line \d+: return",
    ) as caught:
        sim.step(1)
    assert "\n" not in str(caught.value)


CELL = '''
import numpy as np

import gen_art as ga
from gen_art import ti


@ga.force("nudge")
class Nudge(ga.Force):
    """A push. Source: none."""

    strength: float = ga.param(1.0, unit="m/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        return ti.Vector([AXES])


system = ga.ParticleSystem(position=np.zeros((1, 3)), forces=[Nudge(3.0)])
ga.Simulation({"s": system}, dt=0.125, precision="f64").step(8)
'''


def test_a_class_may_stand_in_a_cell_of_a_notebook_and_is_replaced_when_the_cell_runs_again():
    """As IPython runs a cell: its text is in `linecache` alone, and the cells share one namespace."""
    space: dict = {"__name__": "__main__"}
    for number, (axes, expected) in enumerate(
        {"q.strength, 0.0, 0.0": [3, 0, 0], "0.0, q.strength, 0.0": [0, 3, 0]}.items()
    ):
        text, name = CELL.replace("AXES", axes), f"<ipython-input-{number}-cell>"
        linecache.cache[name] = (len(text), None, text.splitlines(True), name)
        exec(compile(text, name, "exec"), space)
        assert np.allclose(space["system"].velocity, [expected])
