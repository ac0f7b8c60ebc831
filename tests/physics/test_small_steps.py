"""A few particles are moved by the calling thread alone: by the same bits as more of them, which all threads share."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.integrators.step_kernels import BLOCK
from gen_art.interactions.pair_sums import TASK


def positions(n: int, more: int, integrator: str) -> np.ndarray:
    """Of n bodies under their gravity after ten steps, beside `more` without mass, which move nobody."""
    rng = np.random.default_rng(3)
    place, speed = rng.normal(0, 1, (n + 1, 3)), rng.normal(0, 0.2, (n + 1, 3))
    mass = np.r_[rng.uniform(0.5, 1.5, n) / n, 0.0]
    some = slice(0, n + more)
    bodies = ga.ParticleSystem(
        position=place[some], velocity=speed[some], mass=mass[some], integrator=integrator,
        interactions=[ga.interactions.SelfGravity(G=1.0, softening=0.1)],
    )  # fmt: skip
    sim = ga.Simulation({"bodies": bodies}, dt=0.01)
    sim.step(10)
    return bodies.position[:n]


@pytest.mark.parametrize("integrator", ["leapfrog", "rk4"])
@pytest.mark.parametrize("n", [TASK, BLOCK])
def test_one_task_moves_particles_by_the_same_bits(n, integrator):
    alone, shared = positions(n, 0, integrator), positions(n, 1, integrator)
    assert np.isfinite(alone).all() and np.array_equal(alone, shared)
    assert np.abs(alone - positions(n, 0, "semi_implicit_euler")).max() > 1e-4  # they do move


def test_an_added_particle_changes_the_kernel_and_not_the_motion():
    place = np.random.default_rng(4).normal(0, 1, (BLOCK, 3))
    one, other = (
        ga.ParticleSystem(position=place, mass=1.0 / BLOCK, interactions=[ga.interactions.SelfGravity(softening=0.1)])
        for _ in range(2)
    )
    short, long = (ga.Simulation({"s": system}, dt=0.01) for system in (one, other))
    short.step(5)
    long.step(5)
    other.add(position=[[50.0, 0.0, 0.0]], mass=0.0)
    short.step(5)
    long.step(5)
    assert np.array_equal(one.position, other.position[:BLOCK])
