"""The accelerations of particles at one time, by all forces together."""

from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import UsageError
from gen_art.integrators.schemes import AHEAD, STAGE, TIME, WEIGHT
from gen_art.integrators.step_kernels import make_step
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME, VELOCITY
from gen_art.particles.storage import PADDING

if TYPE_CHECKING:
    from gen_art.simulation.simulation import Simulation

__all__ = ["accelerations"]

_VELOCITY_CHANGE = slice(9, 12)  # rows of R: what a Runge-Kutta stage adds to the velocities


def accelerations(sim: "Simulation", name: str) -> np.ndarray:
    """(3, count) m/s^2 of the particles in a system's slots now, in the simulation's precision.

    Forces, media, magnetic fields and forces between particles add up; what comes in jumps does not: impacts and thermal noise.
    Raises UsageError where an interaction is solved over a whole step, and so has no force at one time.
    """
    system = sim[name]
    for interaction in system.interactions:
        if interaction.implicit:
            raise UsageError(
                f"'{name}' has no acceleration at one time, because {interaction.name} is solved over a whole step: "
                "compare the velocities before and after a step, of sim.copy() if this one is not to go on"
            )
    if any(interaction.saved_arrays for interaction in system.interactions):
        sim = sim.copy()  # to compute these forces is to change them
        system = sim[name]
    stepper, state = sim.stepper(name), system.state
    dtype, size, n = state.floats.dtype, state.capacity + PADDING, state.count
    pair = np.zeros((max(1, 3 * stepper.part_offsets[-1]), size), dtype)
    if system.interactions and n:
        sim.sum_pair_forces(name, pair)
    # the first of two stages of a Runge-Kutta step of 1 s changes no particle and leaves the slope in R
    numbers = np.zeros(2 * STAGE + 2, dtype)
    numbers[[WEIGHT, TIME, AHEAD]] = 1.0, 0.0, 0.0
    R = np.zeros((12, size), dtype)
    kernel = make_step(
        system.composition, "runge_kutta", ("", False, False), stepper.part_offsets[-1], True, state.attributes,
        sim.precision, False,
    )  # fmt: skip
    if n:
        kernel(
            state.floats, state.birth, state.key, pair, R, stepper.numbers, numbers, 0, n, sim.time, 1, 1.0, 0.0, 0, 1,
            state.floats.ctypes.data, state.birth.ctypes.data, R.ctypes.data,
        )  # fmt: skip
    out = R[_VELOCITY_CHANGE, :n]
    out[:, fixed_lifetimes(state.floats[LIFETIME, :n])] = 0.0
    return _relativistic(out, state.floats[VELOCITY, :n], system.scheme.light) if system.scheme.light else out


def _relativistic(slope: np.ndarray, velocity: np.ndarray, light: float) -> np.ndarray:
    """The change of the velocity, from that of the momentum over the mass: (f - v (v f) / c^2) / gamma."""
    v, f = velocity.astype(np.float64) / light, slope.astype(np.float64)
    rate = f - v * (v * f).sum(axis=0)
    return (rate * np.sqrt(1.0 - (v * v).sum(axis=0))).astype(slope.dtype)
