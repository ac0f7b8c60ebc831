"""Numbers that follow from a simulation at a moment, by the names that `expect:` uses."""

from collections.abc import Callable

import numpy as np

from gen_art.preset.expect import OF_A_SYSTEM
from gen_art.simulation.diagnostics import (
    ANGULAR_MOMENTUM,
    ENERGY,
    KINETIC_ENERGY,
    MOMENTUM,
    POTENTIALS,
    energy_of_pairs,
    sums,
)

__all__ = ["period", "value_of"]

_STATISTICS: dict[str, Callable] = {
    "mean": np.mean, "least": np.min, "largest": np.max, "rms": lambda values: np.sqrt(np.mean(values * values)),
}  # fmt: skip


def value_of(sim, of: str, over: str) -> float:
    """A quantity now; NaN without living particles.

    of : SYSTEM.QUANTITY or SYSTEM.EMITTER.QUANTITY
    over : what is taken over the particles, a name of _STATISTICS
    """
    name, *emitter, quantity = of.split(".")
    if quantity in OF_A_SYSTEM and not emitter:
        return _of_system(sim, name, quantity)
    system = sim[name]
    chosen = np.ones(system.count, bool)
    if emitter:  # the kinds of `choose` are named EMITTER.CHOICE
        chosen = np.array([source.split(".")[0] == emitter[0] for source in system.emitter], bool)
    values = _of_particles(system, quantity).astype(np.float64)[chosen]
    return float(_STATISTICS[over](values)) if len(values) else np.nan


def _of_particles(system, quantity: str) -> np.ndarray:
    if quantity in ("x", "y", "z"):
        return system.position[:, "xyz".index(quantity)]
    if quantity in ("vx", "vy", "vz"):
        return system.velocity[:, "xyz".index(quantity[1])]
    if quantity == "speed":
        return np.linalg.norm(system.velocity, axis=1)
    if quantity == "distance":
        return np.linalg.norm(system.position, axis=1)
    return system.age if quantity == "age" else system.attribute(quantity)


def _of_system(sim, name: str, quantity: str) -> float:
    slots = sim.living(name)
    total = sums(sim, name, slots)
    if quantity == "count":
        return float(len(slots))
    if quantity.startswith("momentum_"):
        return float(total[MOMENTUM]["xyz".index(quantity[-1])])
    if quantity.startswith("angular_momentum_"):
        return float(total[ANGULAR_MOMENTUM]["xyz".index(quantity[-1])])
    if quantity == "kinetic_energy":
        return float(total[KINETIC_ENERGY])
    columns = total[POTENTIALS] if quantity == "potential_energy" else total[ENERGY]
    return float(columns.sum()) + energy_of_pairs(sim, name, slots)


def period(times: np.ndarray, values: np.ndarray) -> float:
    """The mean time between passages upwards through the middle between the least and the largest value; NaN without two.

    times : (n,) s, ascending
    values : (n,); between two moments a passage is interpolated linearly
    """
    middle = (values.min() + values.max()) / 2
    k = np.flatnonzero((values[:-1] < middle) & (values[1:] >= middle))
    if len(k) < 2:
        return float("nan")
    passages = times[k] + (middle - values[k]) / (values[k + 1] - values[k]) * (times[k + 1] - times[k])
    return float((passages[-1] - passages[0]) / (len(k) - 1))
