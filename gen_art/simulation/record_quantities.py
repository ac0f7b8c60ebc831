"""The quantities that a record may keep, by name."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.registry import suggest
from gen_art.simulation.diagnostics import Diagnostics, diagnose

if TYPE_CHECKING:
    from gen_art.simulation.simulation import Simulation
    from gen_art.simulation.system import ParticleSystem

__all__ = ["Moment", "Quantity", "quantity_of"]

_VECTORS = ("momentum", "angular_momentum", "center_of_mass")
_SUMS = (*(one.name for one in fields(Diagnostics) if one.name != "time"), "energy")
_OF_PARTICLES = ("position", "velocity", "age")  # and every attribute


class Moment:
    """One moment of a simulation; the sums that several quantities are taken from are computed once."""

    def __init__(self, sim: "Simulation"):
        self.sim = sim
        self._sums: dict[str, Diagnostics] = {}

    def sums(self, system: str) -> Diagnostics:
        """The sums over one system, or over all of them for ""."""
        if system not in self._sums:
            self._sums[system] = diagnose(self.sim, [system] if system else None)
        return self._sums[system]


@dataclass(frozen=True)
class Quantity:
    """A quantity that is recorded.

    shape, dtype : of its value at a moment
    measure : gives the value
    ids : of the particles that its first axis stands for; None where it is a sum
    """

    name: str
    shape: tuple[int, ...]
    dtype: np.dtype
    measure: Callable[[Moment], np.ndarray]
    ids: np.ndarray | None = None

    @property
    def system(self) -> str:
        """The name of its system; "" for the sums over all of them."""
        return self.name.rpartition(".")[0]


def quantity_of(sim: "Simulation", name: str) -> Quantity:
    """The quantity of this name: a sum, SYSTEM.SUM, or SYSTEM.QUANTITY of each particle that lives now.

    Raises UsageError for an unknown name, and for particles of a system that has none now.
    """
    arguments.text("a quantity to record", name)
    system_name, dot, key = name.rpartition(".")
    if not dot:
        if name not in _SUMS:
            known = [*_SUMS, *(f"{one}.position" for one in sim.members)]
            hint = suggest(name, known) or f"; there are {', '.join(_SUMS)}, and of a system such as {known[-1]}"
            raise UsageError(f"nothing can be recorded by the name '{name}'{hint}")
        return _sum(name, "", name)
    system = sim[system_name]
    if key in system.state.channels or key in _OF_PARTICLES:
        return _of_particles(name, system, key)
    if key not in _SUMS:
        known = [*_OF_PARTICLES, *system.state.channels, *_SUMS]
        hint = suggest(key, known) or f"; there are {', '.join(dict.fromkeys(known))}"
        raise UsageError(f"system '{system_name}' has no '{key}' to record{hint}")
    return _sum(name, system_name, key)


def _sum(name: str, system: str, key: str) -> Quantity:
    shape = (3,) if key in _VECTORS else ()
    dtype = np.dtype(np.int64 if key == "count" else np.float64)
    return Quantity(name, shape, dtype, lambda moment: np.asarray(getattr(moment.sums(system), key)))


def _of_particles(name: str, system: "ParticleSystem", key: str) -> Quantity:
    ids = system.ids
    if not len(ids):
        raise UsageError(
            f"system '{system.name}' has no particles yet whose {key} could be recorded: begin the record later, or record "
            f"{system.name}.count"
        )
    first = _value(system, key)
    return Quantity(name, first.shape, first.dtype, partial(_values, system, key, ids, first.shape), ids)


def _value(system: "ParticleSystem", key: str) -> np.ndarray:
    return getattr(system, key) if key in _OF_PARTICLES else system.attribute(key)


def _values(system: "ParticleSystem", key: str, ids: np.ndarray, shape: tuple[int, ...], moment: Moment) -> np.ndarray:
    """The values of the particles with these ids, NaN where one does not live any more."""
    living, values = system.ids, _value(system, key)
    if len(living) == len(ids) and np.array_equal(living, ids):
        return values
    out = np.full(shape, np.nan, values.dtype)
    if len(living):
        at = np.minimum(np.searchsorted(living, ids), len(living) - 1)
        known = living[at] == ids
        out[known] = values[at[known]]
    return out
