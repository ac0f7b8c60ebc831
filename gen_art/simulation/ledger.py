"""The ledger: the running account of mass, momentum, charge and energy.

E(t) = E(0) + work + born - died - dissipated + residual, where E is the kinetic energy plus the time-independent potential
of the living; with a speed of light (gamma - 1) m c^2, and momentum gamma m v.
Conservative forces book no work: the residual is the scheme's error. Every force books its impulse.
A collider books what it takes and, where it moves, works, and what outer forces work otherwise in the rest of a step for it.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gen_art.integrators.ledger_kernel import make_ledger_kernel
from gen_art.integrators.ledger_rows import LEDGER_COLUMNS
from gen_art.particles.rows import MASS, POSITION, VELOCITY
from gen_art.simulation.diagnostics import diagnose, energy_of_pairs, sums

__all__ = ["Account", "LedgerKeeper", "Ledger", "Transfer"]


class Account(dict):
    """Amounts by name, and their `total`. Vectors are (3,) float64 arrays."""

    zero: Any = 0.0

    @property
    def total(self):
        return sum(self.values(), self.zero)


@dataclass(frozen=True)
class Transfer:
    """What births brought or deaths took: number, mass (kg), charge (C), momentum (3,), angular momentum (3,), energy (J)."""

    count: int = 0
    mass: float = 0.0
    charge: float = 0.0
    momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    energy: float = 0.0

    def __add__(self, other: "Transfer") -> "Transfer":
        return Transfer(*(getattr(self, k) + getattr(other, k) for k in self.__dataclass_fields__))


@dataclass(frozen=True)
class Ledger:
    """The account since the simulation began.

    born, died : Passage by emitter, and died by engine for what it burnt
    work, dissipated : J by force     impulse : (3,) N s by force; each with .total
    residual : J, what the energy changed by beyond the account; momentum_residual : (3,), likewise
    scale : J, the energy that moved (kinetic, work, dissipated, born, died), to judge the residual by
    """

    born: Account
    died: Account
    work: Account
    dissipated: Account
    impulse: Account
    residual: float
    momentum_residual: np.ndarray
    scale: float

    def as_dict(self) -> dict:
        """Plain numbers, lists and dicts."""

        def plain(x):
            if isinstance(x, dict):
                return {k: plain(v) for k, v in x.items()}
            if isinstance(x, Transfer):
                return {k: plain(getattr(x, k)) for k in x.__dataclass_fields__}
            return x.tolist() if isinstance(x, np.ndarray) else x

        return {k: plain(getattr(self, k)) for k in self.__dataclass_fields__}


class _Transfers(Account):
    zero = Transfer()


class _Vectors(Account):
    zero = np.zeros(3)


class LedgerKeeper:
    """Keeps the account of one simulation: called around each step and at each birth."""

    def __init__(self, sim):
        self.sim = sim
        self._rows_of = {}
        for name, system in sim.members.items():
            rows = len(system.composition.terms) + sum(len(one.parts) for one in system.interactions)
            rows += len(system.composition.colliders) + 2 * len(system.composition.mass_loss_terms)
            self._rows_of[name] = np.zeros((rows, LEDGER_COLUMNS))
        self._kept: dict[str, np.ndarray] = {}
        self._born, self._died = _Transfers(), _Transfers()
        self._solved: dict[str, np.ndarray] = {}  # of implicit and torn interactions: impulse, dissipated
        self._worked: dict[str, float] = {}  # by moving colliders that an interaction has taken
        self._start = diagnose(sim)

    def record_step(self, name: str, stepper, begin, first, dt, earliest, stage0, stage1) -> None:
        """Book what the coming launch will do; the launch itself is not touched."""
        system, state = stepper.system, stepper.system.state
        rows = len(self._rows_of[name])
        if rows == 0 or state.count <= begin:
            return
        mutual = tuple(
            one.conservative and one.source_system is None and not part
            for one in system.interactions
            for part in one.parts
        )
        kernel = make_ledger_kernel(
            system.composition, system.scheme.kind, system.scheme.rotation, mutual, stepper.coupled,
            state.attributes, self.sim.precision,
        )  # fmt: skip
        size = state.floats.shape[1] if system.composition.colliders else 1
        kept = self._kept.get(name)
        if kept is None or kept.shape[1] != size:
            kept = self._kept[name] = np.zeros((3, size), state.floats.dtype)
        blocks = -(-(state.count - begin) // 1024)
        entries = np.zeros((blocks, rows * LEDGER_COLUMNS))
        kernel(
            state.floats, state.birth, state.key, stepper.pair, stepper.scratch, stepper.numbers, stepper.scheme_numbers,
            begin, state.count, float(first), dt, earliest, stage0, stage1, entries, kept,
        )  # fmt: skip
        self._rows_of[name] += entries.sum(axis=0).reshape(rows, LEDGER_COLUMNS)

    def record_implicit(self, name: str, one, state, before: np.ndarray, turn) -> None:
        """Book an implicit interaction's change of the velocities, which were `before`."""
        mass = state.floats[MASS, : state.count].astype(np.float64)
        now = state.floats[VELOCITY, : state.count].astype(np.float64)
        change = now - before
        row = self._solved.setdefault(f"{name}.{one.name}", np.zeros(4))
        row[:3] += change @ mass
        if not one.moves_particles:
            row[3] += one.dissipated(state, before, turn.dt)
            return
        taken = 0.5 * float(((before.astype(np.float64) ** 2 - now**2) @ mass).sum())
        if turn.drift > 0:
            taken += self._lifted(name, state, change * turn.kick + one.drift_displacement())
        for label, (impulse, work) in one.collider_impulses().items():
            other = self._solved.setdefault(f"{name}.{label}", np.zeros(4))
            other[:3] += impulse
            row[:3] -= impulse
            self._worked[f"{name}.{label}"] = self._worked.get(f"{name}.{label}", 0.0) + work
            taken += work
        row[3] += taken

    def _lifted(self, name: str, state, way: np.ndarray) -> float:
        """J that conservative forces give on half the way there and half the way back, `way` (3, n), m: their kick was for
        velocities that the change has made others."""
        slots, energy = np.flatnonzero(state.alive(self.sim.time)), []
        kept = state.floats[POSITION, : state.count].copy()
        for sign in (-0.5, 0.5):
            state.floats[POSITION, : state.count] = kept + sign * way
            energy.append(float(sums(self.sim, name, slots)[13:].sum()))
        state.floats[POSITION, : state.count] = kept
        return energy[0] - energy[1]

    def record_broken_bonds(self, name: str, one, energy: float) -> None:
        """Book the energy, J, of what an interaction let go of."""
        self._solved.setdefault(f"{name}.{one.name}", np.zeros(4))[3] += energy

    def record_births(self, name: str, new: slice) -> None:
        """Book births, at their exact times and before they move."""
        self._add_transfers(self._born, name, np.arange(new.start, new.stop))

    def record_deaths(self, t0: float, t1: float, unprocessed_ids: dict[str, tuple[int, int]]) -> None:
        """Add the deaths of the step to the account; the dead stand where they died.

        unprocessed_ids : by system, ids from..to of the particles that were born at the end of the step before
        """
        for name, system in self.sim.members.items():
            state = system.state
            death, ids = state.death(), state.id[: state.count]
            begin, end = unprocessed_ids[name]
            unseen = (death > t0) | ((ids >= begin) & (ids < end))
            self._add_transfers(self._died, name, np.flatnonzero((death <= t1) & unseen))

    def _add_transfers(self, account: Account, name: str, slots: np.ndarray) -> None:
        if not len(slots):
            return
        state = self.sim.members[name].state
        for source in np.unique(state.source[slots]):
            of = slots[state.source[slots] == source]
            part = sums(self.sim, name, of)
            energy = float(part[12:].sum()) + self._mutual(name, of)
            key = f"{name}.{state.sources[source].kind or state.sources[source].name}"
            passage = Transfer(len(of), float(part[1]), float(part[2]), part[3:6].copy(), part[6:9].copy(), energy)
            account[key] = account.get(key, Transfer()) + passage

    def _mutual(self, name: str, slots: np.ndarray) -> float:
        """The potential energy these particles share with each other and with the rest of the living."""
        if not any(one.source_system is None for one in self.sim.members[name].interactions):
            return 0.0
        others = np.setdiff1d(self.sim.living(name), slots)
        everyone = np.union1d(others, slots)
        return energy_of_pairs(self.sim, name, everyone) - energy_of_pairs(self.sim, name, others)

    def report(self) -> Ledger:
        """The account so far."""
        died = _Transfers(self._died)
        work, dissipated, impulse = Account(), Account(), _Vectors()
        for name, system in self.sim.members.items():
            labels = [(t.name, "") for t in system.composition.terms]
            labels += [(one.name, part) for one in system.interactions for part in one.parts]
            works = [not t.force.conservative for t in system.composition.terms]
            works += [
                not one.conservative or one.source_system is not None for one in system.interactions for _ in one.parts
            ]
            labels += [(t.name, "") for t in system.composition.colliders]
            works += [True] * len(system.composition.colliders)
            for (label, part), does, row in zip(labels, works, self._rows_of[name]):
                key = f"{name}.{label}"
                if part:  # what a dissipative part of an interaction works, it takes
                    dissipated[key] = dissipated.get(key, 0.0) - float(row[0])
                elif does:
                    work[key] = work.get(key, 0.0) + float(row[0])
                    dissipated[key] = dissipated.get(key, 0.0) + float(row[1])
                impulse[key] = impulse.get(key, np.zeros(3)) + row[2:5]
            for k, burner in enumerate(system.composition.mass_loss_terms):
                taken, turn = self._rows_of[name][len(labels) + 2 * k :][:2]
                died[f"{name}.{burner.name}"] = Transfer(
                    0, taken[1], 0.0, taken[2:].copy(), turn[2:].copy(), float(taken[0])
                )
        for key, row in self._solved.items():
            impulse[key] = impulse.get(key, np.zeros(3)) + row[:3]
            dissipated[key] = dissipated.get(key, 0.0) + float(row[3])
        for key, amount in self._worked.items():
            work[key] = work.get(key, 0.0) + amount
        now = diagnose(self.sim)
        born, gone = self._born.total, died.total
        expected = self._start.energy + work.total + born.energy - gone.energy - dissipated.total
        momentum = self._start.momentum + impulse.total + born.momentum - gone.momentum
        scale = max(
            abs(self._start.kinetic_energy), now.kinetic_energy, abs(self._start.potential_energy), abs(work.total),
            abs(dissipated.total), abs(born.energy), abs(gone.energy), 1e-300,
        )  # fmt: skip
        return Ledger(
            _Transfers(self._born), died, work, dissipated, impulse,
            float(now.energy - expected), now.momentum - momentum, float(scale),
        )  # fmt: skip
