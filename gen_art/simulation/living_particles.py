"""What a script reads of the particles of a system, once it is part of a simulation."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.interactions import Interaction
from gen_art.interactions.ledger_labels import LedgerRow, check_entry
from gen_art.particles.entries import LedgerEntry
from gen_art.particles.rows import MASS, POSITION, VELOCITY
from gen_art.particles.storage import Particles
from gen_art.quantities import plain
from gen_art.registry import suggest

if TYPE_CHECKING:
    from gen_art.simulation.orbit import OrbitalElements
    from gen_art.simulation.simulation import Simulation

__all__ = ["LivingParticles"]


class LivingParticles(ABC):
    """The living particles of a system: read-only copies in the order of their ids."""

    def __init__(self) -> None:
        self.name = ""
        self.interactions: Sequence[Interaction] = ()
        self._state: Particles | None = None
        self._simulation: Simulation | None = None

    @property
    @abstractmethod
    def ledger_rows(self) -> list[LedgerRow]:
        """The rows of its ledger, in the order of the ledger kernel."""

    @property
    def state(self) -> Particles:
        """The storage. Raises UsageError until the system is part of a simulation."""
        if self._state is None:
            raise UsageError("this ParticleSystem is not part of a simulation yet")
        return self._state

    @property
    def time(self) -> float:
        """Simulated seconds of the simulation that the system is part of; 0 before that."""
        return 0.0 if self._simulation is None else self._simulation.time

    def slots(self) -> np.ndarray:
        """Slots of the living particles, in the order of their ids."""
        return np.flatnonzero(self.state.alive(self.time))

    def slots_of(self, name: str, which: Any) -> np.ndarray:
        """Slots of living particles, by ids in any order, or by one bool for each living particle.

        name : of the argument, for the UsageError about ids of no living particle, twice the same, or no ids at all
        """
        living = self.slots()
        what = f"ids of particles, or {len(living)} booleans, one for each living particle"
        which = plain(which, "", name)
        try:
            chosen = np.atleast_1d(np.asarray(which))
        except (TypeError, ValueError, OverflowError):
            raise UsageError(f"{name} must be {what}, not {arguments.shown(which)}") from None
        if chosen.dtype == bool and chosen.shape == living.shape:
            return living[chosen]
        if chosen.ndim != 1 or (chosen.size and chosen.dtype.kind not in "iu"):
            raise UsageError(f"{name} must be {what}, not {arguments.shown(which)}")
        if not chosen.size:
            return living[:0]
        ids = self.state.id[living]
        at = np.minimum(np.searchsorted(ids, chosen), max(len(ids) - 1, 0))
        known = ids[at] == chosen if len(ids) else np.zeros(len(chosen), bool)
        if not known.all():
            raise UsageError(f"system '{self.name}' has no living particle {chosen[~known][0]}")
        again, times = np.unique(chosen, return_counts=True)
        if (times > 1).any():
            raise UsageError(f"{name} has particle {again[times > 1][0]} twice")
        return living[at]

    def _copy(self, array) -> np.ndarray:
        out = np.array(array)
        out.flags.writeable = False
        return out

    @property
    def count(self) -> int:
        """The number of living particles."""
        return len(self.slots())

    @property
    def ids(self) -> np.ndarray:
        """(n,) int64, increasing; never reused."""
        return self._copy(self.state.id[self.slots()])

    @property
    def keys(self) -> np.ndarray:
        """(n,) uint64, the keys of the particles' random streams."""
        words = self.state.key[:, self.slots()].astype(np.uint64)
        return self._copy((words[0] << np.uint64(32)) | words[1])

    @property
    def emitter(self) -> np.ndarray:
        """(n,) names of the emitters of the particles ("initial" for particles given as arrays)."""
        names = np.array([s.name for s in self.state.sources] or [""])
        return self._copy(names[self.state.source[self.slots()]])

    @property
    def position(self) -> np.ndarray:
        """(n, 3) m."""
        return self._copy(self.state.floats[POSITION, self.slots()].T)

    @property
    def velocity(self) -> np.ndarray:
        """(n, 3) m/s, at the same time as the positions."""
        return self._copy(self.state.floats[VELOCITY, self.slots()].T)

    @property
    def acceleration(self) -> np.ndarray:
        """(n, 3) m/s^2, by all forces together, at the same time as the positions; computed at each reading.

        Impacts and thermal noise, which come in jumps, are left out. Raises UsageError where an interaction is solved over a
        whole step (rigid bodies, stiff springs), and before the system is part of a simulation.
        """
        from gen_art.simulation.accelerations import accelerations

        if self._simulation is None:
            raise UsageError("this ParticleSystem is not part of a simulation yet")
        return self._copy(accelerations(self._simulation, self.name)[:, self.slots()].T)

    def attribute(self, name: str) -> np.ndarray:
        """(n,) the particles' mass, charge, radius, lifetime or a declared attribute."""
        if arguments.text("the name of an attribute", name) not in self.state.channels:
            raise UsageError(f"system '{self.name}' has no attribute '{name}'{suggest(name, self.state.channels)}")
        return self._copy(self.state.floats[self.state.channels[name], self.slots()])

    def view(self, name: str) -> np.ndarray:
        """(n, 3) position or velocity, or (n,) mass, charge, radius or a declared attribute, read-only and without a copy.

        It shows the particles in the order of their ids, and is valid until the simulation is stepped or changed: take it anew
        after that, because the storage may have moved. Raises UsageError where particles die, because the dead lie among the
        living for a while: read `position`, a copy of the living.
        """
        state = self.state
        row = {"position": POSITION, "velocity": VELOCITY}.get(arguments.text("the name of what to view", name))
        known = ("position", "velocity", *state.channels)
        if row is None and name not in state.channels:
            raise UsageError(f"system '{self.name}' has no '{name}' to view{suggest(name, known)}")
        if state.may_die:
            raise UsageError(
                f"particles of '{self.name}' may die, and the dead lie among the living for a while: read its `position` and the "
                "like, which are copies of the living, instead of a view"
            )
        view = state.floats[state.channels[name] if row is None else row, : state.count].T
        view.flags.writeable = False
        return view

    def booked(self, kind: str, name: str = "") -> np.ndarray:
        """(n,) J: each living particle's share of an entry of the ledger since its birth.

        kind : "work" or "dissipated"
        name : the force as the ledger names it, without the system's name; left out for all that is dissipated
        Raises UsageError unless the particles keep it: their look goes by it, or `booked` of the system names it.
        """
        return self._copy(self.state.booked[self._entry_index(kind, name), self.slots()])

    def booked_total(self, kind: str, name: str = "") -> float:
        """The sum of `booked` over all particles that ever were, the dead too, J: to round-off the entry of `sim.ledger()`."""
        return self.state.booked_total(self._entry_index(kind, name))

    def _entry_index(self, kind: str, name: str) -> int:
        entry = LedgerEntry.of({kind: name} if name else kind)
        if entry not in self.state.entries:
            check_entry(entry, self.ledger_rows, self.interactions)
            raise UsageError(
                f"the particles of '{self.name}' keep no share of {entry}: give the system booked=[{entry.plain!r}], or a look "
                "that goes by it"
            )
        return self.state.entries.index(entry)

    def orbital_elements(
        self,
        of: ArrayLike,
        about: int,
        *,
        G: float | None = None,
        axis: ArrayLike = (0.0, 0.0, 1.0),
        reference: ArrayLike = (1.0, 0.0, 0.0),
    ) -> "OrbitalElements":
        """The elements of the orbits of particles about another one: see ga.orbital_elements.

        of : the particle's id, or ids
        about : the other's id
        G : m^3/(kg s^2), that of the system's self_gravity when left out
        Each orbit is that of two bodies alone, with the masses of both. Raises UsageError for unknown ids, and without G.
        """
        from gen_art.simulation.orbit import orbital_elements

        if G is None:
            laws = [one.values["G"] for one in self.interactions if "G" in one.values and one.source_system is None]
            if len(laws) != 1:
                raise UsageError(f"give G: system '{self.name}' has no self_gravity of its own to take it from")
            G = laws[0]
        G = arguments.number("G", G, "m^3/(kg s^2)", above=0.0)
        other, slots = self.slots_of("about", arguments.whole("about", about)), self.slots_of("of", of)
        bodies, center = (self.state.floats[: MASS + 1, one].astype(np.float64) for one in (slots, other))
        x, v = bodies[POSITION] - center[POSITION], bodies[VELOCITY] - center[VELOCITY]
        if self.state.box is not None:
            x = self.state.box.nearest(x)
        GM = G * (bodies[MASS] + center[MASS])
        which = 0 if np.ndim(of) == 0 else slice(None)
        return orbital_elements(x.T[which], v.T[which], GM[which], axis=axis, reference=reference)

    @property
    def mass(self) -> np.ndarray:
        """(n,) kg."""
        return self.attribute("mass")

    @property
    def charge(self) -> np.ndarray:
        """(n,) C."""
        return self.attribute("charge")

    @property
    def radius(self) -> np.ndarray:
        """(n,) m."""
        return self.attribute("radius")

    @property
    def age(self) -> np.ndarray:
        """(n,) s since birth."""
        return self._copy(self.time - self.state.birth[self.slots()])
