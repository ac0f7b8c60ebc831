"""The ledger of mass, momentum, charge and energy: what every force, birth and death adds to the totals or takes from them.

E(t) = E(0) + work + born - died - dissipated + residual, where E is the kinetic energy plus the time-independent potential
energy of the living particles; with a speed of light the kinetic energy is (gamma - 1) m c^2 and the momentum gamma m v.
Conservative forces have no entry of work: the residual is the scheme's error. Every force has an entry of its impulse.
The entry of a collider holds the energy that it dissipates, its work if it moves, and by how much an impact changes the
work of the other forces in the rest of the step.
The entry `outside` holds what `set`, `add` and `remove` of a ParticleSystem changed between steps.
The entry `periodic_boundary` holds by how much potentials change where particles leave a periodic box on one side and come in
at the other: wrapping changes no velocity, so it has no impulse.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gen_art.html_table import html_table, vector_text
from gen_art.integrators.ledger_kernel import make_ledger_kernel
from gen_art.integrators.ledger_rows import DISSIPATED, LEDGER_COLUMNS, WORK
from gen_art.integrators.step_kernels import BLOCK
from gen_art.interactions.ledger_labels import shares_of
from gen_art.particles.entries import LedgerEntry
from gen_art.particles.rows import MASS, POSITION, VELOCITY
from gen_art.simulation.diagnostics import (
    ANGULAR_MOMENTUM,
    ENERGY,
    MOMENTUM,
    POTENTIALS,
    TOTAL_CHARGE,
    TOTAL_MASS,
    Diagnostics,
    diagnose,
    energy_of_pairs,
    sums,
)

__all__ = ["Entries", "LedgerKeeper", "Ledger", "Transfer"]

_IMPULSE = slice(2, 5)  # columns of the ledger rows (gen_art.integrators.ledger_rows)
# an engine has two rows: energy, mass and momentum of the exhaust, then its angular momentum
_EXHAUST_ENERGY, _EXHAUST_MASS, _EXHAUST_VECTOR = 0, 1, slice(2, 5)
_NOTHING_BOOKED = np.zeros((1, 1))  # a kernel's argument where no particle keeps a share


BOUNDARY = "periodic_boundary"  # the name of the sides of a periodic box
OUTSIDE = "outside"  # the name of the changes that a script makes between steps


def _has_boundary(system) -> bool:
    """Whether the ledger has a row for the sides of a periodic box, where the potentials of the forces on a system jump."""
    return system.box is not None and bool(system.composition.potentials)


class Entries(dict):
    """Amounts by name, and their `total`. Vectors are (3,) float64 arrays."""

    zero: Any = 0.0

    @property
    def total(self):
        return sum(self.values(), self.zero)


@dataclass(frozen=True)
class Transfer:
    """What births add, deaths remove, or a script changes from outside.

    count : number of particles
    mass : kg
    charge : C
    momentum : (3,) N s
    angular_momentum : (3,) N m s
    energy : J
    """

    count: int = 0
    mass: float = 0.0
    charge: float = 0.0
    momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    energy: float = 0.0

    def __add__(self, other: "Transfer") -> "Transfer":
        return Transfer(*(getattr(self, k) + getattr(other, k) for k in self.__dataclass_fields__))

    def __sub__(self, other: "Transfer") -> "Transfer":
        return Transfer(*(getattr(self, k) - getattr(other, k) for k in self.__dataclass_fields__))


@dataclass(frozen=True)
class Ledger:
    """The entries since the simulation began. Names are SYSTEM.FORCE or SYSTEM.EMITTER.

    born : Transfer by emitter
    died : Transfer by emitter, and by engine the exhaust
    work, dissipated : energy by force, J
    impulse : (3,) by force, N s
    outside : Transfer by system, all that `set`, `add` and `remove` changed; its energy is also SYSTEM.outside of work, and its
        momentum SYSTEM.outside of impulse
    residual : change of the energy that the entries do not explain, J
    momentum_residual : (3,) the same of the momentum, N s
    scale : the largest energy that moved (kinetic, work, dissipated, born, died), J, to compare the residual with
    born, died, work, dissipated, impulse and outside have a .total.
    """

    born: Entries
    died: Entries
    work: Entries
    dissipated: Entries
    impulse: Entries
    outside: Entries
    residual: float
    momentum_residual: np.ndarray
    scale: float

    def as_dict(self) -> dict:
        """Plain numbers, lists and dicts."""

        def plain(x):
            if isinstance(x, dict):
                return {k: plain(v) for k, v in x.items()}
            if isinstance(x, Transfer):
                return _plain(x)
            return x.tolist() if isinstance(x, np.ndarray) else x

        return {k: plain(getattr(self, k)) for k in self.__dataclass_fields__}

    def _repr_html_(self) -> str:
        """What a notebook shows: the entries that are not zero, then what came and went, then the residuals."""
        names = [
            name
            for name in dict.fromkeys([*self.work, *self.dissipated, *self.impulse])
            if self.work.get(name) or self.dissipated.get(name) or np.any(self.impulse.get(name, 0.0))
        ]
        entries = [
            (name, f"{self.work.get(name, 0.0):.6g}", f"{self.dissipated.get(name, 0.0):.6g}",
             vector_text(self.impulse.get(name, np.zeros(3))))
            for name in names
        ]  # fmt: skip
        total = ("total", f"{self.work.total:.6g}", f"{self.dissipated.total:.6g}", vector_text(self.impulse.total))
        transfers = [
            (name, what, f"{one.count:,}", f"{one.mass:.6g}", vector_text(one.momentum), f"{one.energy:.6g}")
            for what, those in (("born", self.born), ("died", self.died), ("outside", self.outside))
            for name, one in those.items()
        ]
        residuals = [
            ("energy, J", f"{self.residual:.3g}", f"largest energy that moved: {self.scale:.6g} J"),
            ("momentum, N s", vector_text(self.momentum_residual), ""),
        ]
        tables = [
            html_table(
                "Ledger, in SI units unless the preset says otherwise", [*entries, total],
                ("Force", "Work, J", "Dissipated, J", "Impulse, N s"),
            )
        ]  # fmt: skip
        if transfers:
            columns = ("Emitter or system", "What", "Particles", "Mass, kg", "Momentum, N s", "Energy, J")
            tables.append(html_table("Born, died, changed from outside", transfers, columns))
        return "\n".join([*tables, html_table("Residual: what the entries do not explain", residuals)])


def _plain(record: "Transfer | Diagnostics") -> dict:
    """The fields of a record as plain data."""
    values = {field: getattr(record, field) for field in record.__dataclass_fields__}
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in values.items()}


def _with_arrays(plain: dict) -> dict:
    return {k: np.array(v) if isinstance(v, list) else v for k, v in plain.items()}


class _Transfers(Entries):
    zero = Transfer()


class _Vectors(Entries):
    zero = np.zeros(3)


class LedgerKeeper:
    """Collects the ledger entries of one simulation. It is called before each launch and at births and deaths."""

    def __init__(self, sim):
        self.sim = sim
        self._labels = {name: system.ledger_rows for name, system in sim.members.items()}
        self._shares = {name: shares_of(self._labels[name], s.state.entries) for name, s in sim.members.items()}
        self._rows_of = {}
        for name, system in sim.members.items():
            rows = len(self._labels[name]) + 2 * len(system.composition.mass_loss_terms) + _has_boundary(system)
            self._rows_of[name] = np.zeros((rows, LEDGER_COLUMNS))
            system.state.forget_booked()
        # by system, (3, capacity): what the ledger kernel of a system with colliders stores between the stages of a step
        self._impact_states: dict[str, np.ndarray] = {}
        self._born, self._died, self._outside = _Transfers(), _Transfers(), _Transfers()
        # ledger rows of implicit interactions, also of those that rest, and of broken bonds
        self._implicit_rows = {
            f"{name}.{one.name}": np.zeros(LEDGER_COLUMNS)
            for name, system in sim.members.items()
            for one in system.interactions
            if one.implicit
        }
        self._collider_work: dict[str, float] = {}  # J, of colliders that an interaction handles
        self._start = diagnose(sim)

    def record_step(self, name: str, stepper, begin, first, dt, earliest, stage0, stage1) -> None:
        """Add the entries of a launch, which is about to happen with the same arguments and is not changed by this."""
        system, state = stepper.system, stepper.system.state
        rows = len(self._rows_of[name])
        if rows == 0 or state.count <= begin:
            return
        mutual = tuple(
            interaction.conservative and interaction.source_system is None and not part.dissipates
            for interaction in system.interactions
            for part in interaction.parts
        )
        kernel = make_ledger_kernel(
            system.composition, system.scheme.kind, system.scheme.rotation, mutual, stepper.coupled,
            state.attributes, self.sim.precision, self._shares[name],
        )  # fmt: skip
        size = state.floats.shape[1] if system.composition.colliders else 1
        impact_state = self._impact_states.get(name)
        if impact_state is None or impact_state.shape[1] != size:
            impact_state = self._impact_states[name] = np.zeros((3, size), state.floats.dtype)
        blocks = -(-(state.count - begin) // BLOCK)
        entries = np.zeros((blocks, rows * LEDGER_COLUMNS))
        kernel(
            state.floats, state.birth, state.key, stepper.pair, stepper.scratch, stepper.numbers, stepper.scheme_numbers,
            begin, state.count, float(first), dt, earliest, stage0, stage1, state.floats.ctypes.data, state.birth.ctypes.data,
            stepper.scratch.ctypes.data, entries, impact_state,
            state.booked if state.entries else _NOTHING_BOOKED,
        )  # fmt: skip
        self._rows_of[name] += entries.sum(axis=0).reshape(rows, LEDGER_COLUMNS)

    def _implicit_row(self, key: str) -> np.ndarray:
        return self._implicit_rows.setdefault(key, np.zeros(LEDGER_COLUMNS))

    def record_implicit(self, name: str, interaction, state, before: np.ndarray, stage) -> None:
        """Add the entries of an implicit interaction that changed the velocities.

        before : (3, n) velocities before the change, m/s
        stage : the ImplicitStage
        """
        mass = state.floats[MASS, : state.count].astype(np.float64)
        now = state.floats[VELOCITY, : state.count].astype(np.float64)
        change = now - before
        row = self._implicit_row(f"{name}.{interaction.name}")
        row[_IMPULSE] += change @ mass
        if not interaction.moves_particles:
            row[DISSIPATED] += interaction.dissipated(state, before, stage.dt)
            return
        dissipated = 0.5 * float(((before.astype(np.float64) ** 2 - now**2) @ mass).sum())
        if stage.drift > 0:
            displacement = change * stage.kick + interaction.drift_displacement()
            dissipated += self._conservative_work(name, state, displacement)
        for label, (impulse, work) in interaction.collider_impulses().items():
            self._implicit_row(f"{name}.{label}")[_IMPULSE] += impulse
            row[_IMPULSE] -= impulse
            self._collider_work[f"{name}.{label}"] = self._collider_work.get(f"{name}.{label}", 0.0) + work
            dissipated += work
        row[DISSIPATED] += dissipated

    def record_turn(self, name: str, interaction, state, before: np.ndarray) -> None:
        """Add the impulse of pivots and axles while bodies turn about them, which does no work.

        before : (3, n) velocities before the drift, m/s
        """
        mass = state.floats[MASS, : state.count].astype(np.float64)
        change = state.floats[VELOCITY, : state.count].astype(np.float64) - before
        self._implicit_row(f"{name}.{interaction.name}")[_IMPULSE] += change @ mass

    def _conservative_work(self, name: str, state, displacement: np.ndarray) -> float:
        """The work of conservative forces over a displacement (3, n), m, with its middle at the particles' positions, J.

        It corrects the work of their kick, which was computed for the velocities before the interaction changed them.
        """
        slots, energy = np.flatnonzero(state.alive(self.sim.time)), []
        positions = state.floats[POSITION, : state.count].copy()
        for sign in (-0.5, 0.5):
            state.floats[POSITION, : state.count] = positions + sign * displacement
            energy.append(float(sums(self.sim, name, slots)[POTENTIALS].sum()))
        state.floats[POSITION, : state.count] = positions
        return energy[0] - energy[1]

    def record_broken_bonds(self, name: str, interaction, energy: float) -> None:
        """Add the energy of broken bonds, J."""
        self._implicit_row(f"{name}.{interaction.name}")[DISSIPATED] += energy

    def record_births(self, name: str, new: slice) -> None:
        """Add the entries of births, at their exact times and before the particles move."""
        self._add_transfers(self._born, name, np.arange(new.start, new.stop))

    def record_deaths(self, t0: float, t1: float) -> None:
        """Add the entries of the deaths after t0 until t1, s; dead particles are still where they died."""
        for name, system in self.sim.members.items():
            death = system.state.death()
            self._add_transfers(self._died, name, np.flatnonzero((death > t0) & (death <= t1)))

    def _add_transfers(self, entries: Entries, name: str, slots: np.ndarray) -> None:
        """Add the particles in these slots to the entries of their emitters."""
        if not len(slots):
            return
        state = self.sim.members[name].state
        for source in np.unique(state.source[slots]):
            chosen = slots[state.source[slots] == source]
            key = f"{name}.{state.sources[source].kind or state.sources[source].name}"
            transfer = self._transfer(name, chosen, self._mutual_energy(name, chosen))
            entries[key] = entries.get(key, Transfer()) + transfer

    def _transfer(self, name: str, slots: np.ndarray, mutual_energy: float) -> Transfer:
        """What the particles in these slots have, with this potential energy of the forces between them, J."""
        total = sums(self.sim, name, slots)
        return Transfer(
            len(slots), float(total[TOTAL_MASS]), float(total[TOTAL_CHARGE]), total[MOMENTUM].copy(),
            total[ANGULAR_MOMENTUM].copy(), float(total[ENERGY].sum()) + mutual_energy,
        )  # fmt: skip

    def holdings(self, name: str) -> Transfer:
        """What the living particles of one system have now."""
        slots = self.sim.living(name)
        return self._transfer(name, slots, energy_of_pairs(self.sim, name, slots))

    def record_outside(self, name: str, before: Transfer) -> None:
        """Add what was changed from outside since the particles of a system had `before`."""
        self._outside[name] = self._outside.get(name, Transfer()) + (self.holdings(name) - before)

    def _mutual_energy(self, name: str, slots: np.ndarray) -> float:
        """The potential energy of these particles with each other and with the other living particles, J."""
        interactions = self.sim.members[name].interactions
        if not any(interaction.source_system is None for interaction in interactions):
            return 0.0
        others = np.setdiff1d(self.sim.living(name), slots)
        everyone = np.union1d(others, slots)
        return energy_of_pairs(self.sim, name, everyone) - energy_of_pairs(self.sim, name, others)

    def saved(self) -> dict:
        """Everything that the ledger has recorded, as plain data for a snapshot; numbers survive JSON bit for bit."""
        born, died, outside = (
            {key: _plain(one) for key, one in entries.items()} for entries in (self._born, self._died, self._outside)
        )
        return {
            "rows": {name: rows.tolist() for name, rows in self._rows_of.items()},
            "implicit": {key: row.tolist() for key, row in self._implicit_rows.items()},
            "colliders": dict(self._collider_work),
            "start": _plain(self._start),
            "born": born,
            "died": died,
            "outside": outside,
        }

    def restore(self, saved: dict) -> None:
        """Continue from what `saved` gave."""
        self._rows_of = {name: np.array(saved["rows"][name]).reshape(r.shape) for name, r in self._rows_of.items()}
        self._implicit_rows |= {key: np.array(row) for key, row in saved["implicit"].items()}
        self._collider_work = dict(saved["colliders"])
        self._start = Diagnostics(**_with_arrays(saved["start"]))
        self._born, self._died, self._outside = (
            _Transfers({key: Transfer(**_with_arrays(one)) for key, one in saved.get(entries, {}).items()})
            for entries in ("born", "died", "outside")
        )

    def total(self, name: str, entry: LedgerEntry) -> float:
        """The ledger's entry of one system so far, J: of {dissipated}, the sum over all of its forces."""
        rows = zip(self._labels[name], self._rows_of[name])
        return sum(
            sign * float(amounts[part])
            for row, amounts in rows
            if entry.name in ("", row.label)
            for part, sign in row.parts(entry.kind)
        )

    def report(self) -> Ledger:
        """The ledger so far."""
        died = _Transfers(self._died)
        work, dissipated, impulse = Entries(), Entries(), _Vectors()
        for name, system in self.sim.members.items():
            rows = self._labels[name]
            for row, amounts in zip(rows, self._rows_of[name]):
                key = f"{name}.{row.label}"
                for entries, kind in ((work, "work"), (dissipated, "dissipated")):
                    for part, sign in row.parts(kind):
                        entries[key] = entries.get(key, 0.0) + sign * float(amounts[part])
                impulse[key] = impulse.get(key, np.zeros(3)) + amounts[_IMPULSE]
            for k, engine in enumerate(system.composition.mass_loss_terms):
                exhaust, angular = self._rows_of[name][len(rows) + 2 * k :][:2]
                died[f"{name}.{engine.name}"] = Transfer(
                    0, exhaust[_EXHAUST_MASS], 0.0, exhaust[_EXHAUST_VECTOR].copy(), angular[_EXHAUST_VECTOR].copy(),
                    float(exhaust[_EXHAUST_ENERGY]),
                )  # fmt: skip
            if _has_boundary(system):
                work[f"{name}.{BOUNDARY}"] = float(self._rows_of[name][-1][WORK])
        for key, row in self._implicit_rows.items():
            impulse[key] = impulse.get(key, np.zeros(3)) + row[_IMPULSE]
            dissipated[key] = dissipated.get(key, 0.0) + float(row[DISSIPATED])
        for key, amount in self._collider_work.items():
            work[key] = work.get(key, 0.0) + amount
        for name, transfer in self._outside.items():
            work[f"{name}.{OUTSIDE}"], impulse[f"{name}.{OUTSIDE}"] = transfer.energy, transfer.momentum
        now = diagnose(self.sim)
        born, lost = self._born.total, died.total
        expected = self._start.energy + work.total + born.energy - lost.energy - dissipated.total
        momentum = self._start.momentum + impulse.total + born.momentum - lost.momentum
        scale = max(
            abs(self._start.kinetic_energy), now.kinetic_energy, abs(self._start.potential_energy), abs(work.total),
            abs(dissipated.total), abs(born.energy), abs(lost.energy), 1e-300,
        )  # fmt: skip
        return Ledger(
            _Transfers(self._born), died, work, dissipated, impulse, _Transfers(self._outside),
            float(now.energy - expected), now.momentum - momentum, float(scale),
        )  # fmt: skip
