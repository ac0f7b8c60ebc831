"""Full blocks of particles move by the same bits as beside one more particle, whichever threads move them."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.integrators.step_kernels import BLOCK


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
@pytest.mark.parametrize("n", [BLOCK, 5 * BLOCK])
def test_a_full_block_moves_by_the_same_bits_as_beside_another(n, integrator):
    alone, shared = positions(n, 0, integrator), positions(n, 1, integrator)
    assert np.isfinite(alone).all() and np.array_equal(alone, shared)
    assert np.abs(alone - positions(n, 0, "semi_implicit_euler")).max() > 1e-4  # they do move
