"""Snapshots: the whole state of a simulation, bit for bit; in a file, with the forces that it needs to continue."""

import json
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gen_art.colliders import COLLIDERS
from gen_art.errors import OutputError, UsageError
from gen_art.files import beside
from gen_art.forces.base import FORCES
from gen_art.forces.medium import Medium
from gen_art.interactions import INTERACTIONS
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME
from gen_art.simulation.system import ParticleSystem

__all__ = ["Snapshot", "capture", "read", "write", "write_array"]

_FORMAT = 1
_UNPROCESSED, _SAVED = "behind", "memory"  # the names of these keys in format 1
_COLUMNS = ("floats", "birth", "key", "id", "source")


@dataclass(frozen=True)
class Snapshot:
    """The state of a simulation.

    head : the clock, and in a file the definition from which the simulation is built
    columns : by (system, column), the particles' arrays
    saved_arrays : by system, the arrays of each interaction
    booked : by system, each particle's shares of entries of the ledger
    """

    head: dict
    columns: dict[tuple[str, str], np.ndarray]
    saved_arrays: dict[str, list[dict[str, np.ndarray]]]
    booked: dict[str, np.ndarray]

    @property
    def dt(self) -> float:
        return self.head["dt"]

    @property
    def seed(self) -> int:
        return self.head["seed"]

    @property
    def precision(self) -> str:
        return self.head["precision"]

    @property
    def steps_done(self) -> int:
        return self.head["steps"]

    @property
    def ledger(self) -> dict | None:
        """What the ledger had recorded; None where none was kept."""
        return self.head.get("ledger")

    @property
    def unprocessed_ids(self) -> dict[str, tuple[int, int]]:
        """By system, the ids from..to of the particles whose births no emitter has handled yet."""
        return {name: tuple(entry[_UNPROCESSED]) for name, entry in self.head["systems"].items()}

    @property
    def definition(self):
        """The Preset, or the ParticleSystems by name, from which the simulation is built."""
        if self.head["preset"] is None:
            return {name: _build(entry["definition"]) for name, entry in self.head["systems"].items()}
        from gen_art.preset import load_preset

        return load_preset(self.head["preset"])

    @property
    def domain(self) -> dict | None:
        """The space of systems that are not a preset's; None where it is open, or the preset has it."""
        return self.head.get("domain")

    def check_members(self, members) -> None:
        """Raise UsageError unless these systems can take the saved particles: the same names and rows, emitter for emitter."""
        if list(members) != list(self.head["systems"]):
            raise UsageError("the snapshot has other systems")
        for name, entry in self.head["systems"].items():
            system, state = members[name], members[name].state
            same_parts = len(system.emitters) == len(entry["done"])
            same_parts &= len(system.interactions) == len(self.saved_arrays[name])
            if not same_parts or list(state.attributes) != list(entry["attributes"]):
                raise UsageError(f"system '{name}' of the snapshot has other emitters, interactions or attributes")
            if bool(state.entries) != (name in self.booked):
                raise UsageError(f"system '{name}' of the snapshot has other shares of the ledger")

    def restore_systems(self, members, time: float) -> None:
        """Put the saved particles into systems that were built from `definition`.

        time : simulated time at which they were saved, s
        """
        for name, entry in self.head["systems"].items():
            system, state = members[name], members[name].state
            state.count = 0
            state.reserve(entry["count"])
            for column in _COLUMNS:
                getattr(state, column)[..., : entry["count"]] = self.columns[name, column]
            state.count, state.next_id, state.may_die = entry["count"], entry["next_id"], entry["may_die"]
            state.last_birth = float(np.max(state.birth[: state.count], initial=-np.inf))
            state.has_fixed = bool(fixed_lifetimes(state.floats[LIFETIME, : state.count]).any())
            # the dead are then removed when they would have been, which decides the order of the ledger's sums
            state.launches, state.count_at = entry.get("launches", 0), entry.get("count_at", 0)
            if name in self.booked:
                state.booked[:, : entry["count"]] = self.booked[name]
                state.removed = [float(sum_) for sum_ in entry["removed"]]
            for emitter, done in zip(system.emitters, entry["done"]):
                emitter.done = done
        for name, saved in self.saved_arrays.items():
            for interaction, arrays in zip(members[name].interactions, saved):
                if arrays:
                    interaction.restore_arrays(arrays, time)


def capture(sim, unprocessed_ids: dict[str, tuple[int, int]], ledger: dict | None) -> Snapshot:
    """The present state of `sim`, in its own arrays: nothing is copied.

    ledger : what its ledger has recorded, as plain data; None where it keeps none
    """
    systems = {
        name: {
            "count": system.state.count, "next_id": system.state.next_id, "may_die": system.state.may_die,
            "attributes": system.state.attributes, "done": [e.done for e in system.emitters],
            _UNPROCESSED: unprocessed_ids[name],
            _SAVED: [list(interaction.saved_arrays) for interaction in system.interactions],
            "removed": system.state.removed if system.state.entries else None,
            "launches": system.state.launches, "count_at": system.state.count_at,
        }
        for name, system in sim.members.items()
    }  # fmt: skip
    head = {
        "format": _FORMAT, "precision": sim.precision, "dt": sim.dt, "seed": sim.seed, "steps": sim.steps_done,
        "systems": systems, "ledger": ledger,
    }  # fmt: skip
    columns = {
        (name, column): getattr(system.state, column)[..., : system.state.count]
        for name, system in sim.members.items()
        for column in _COLUMNS
    }
    saved = {
        name: [dict(interaction.saved_arrays) for interaction in system.interactions]
        for name, system in sim.members.items()
    }
    booked = {
        name: system.state.booked[:, : system.state.count]
        for name, system in sim.members.items()
        if system.state.entries
    }
    return Snapshot(head, columns, saved, booked)


def write(sim, snapshot: Snapshot, path) -> None:
    """Write the snapshot of `sim` to a temporary file and rename it to `path`.

    Raises OutputError when the file cannot be written, UsageError for what no file can describe.
    """
    head = {**snapshot.head, "preset": None, "systems": dict(snapshot.head["systems"])}
    if sim.preset is not None:
        head["preset"] = {**sim.preset.resolved(), "name": sim.preset.name}
    elif sim.box is not None:
        head["domain"] = {"periodic": sim.box.as_dict()}
    for name, system in sim.members.items():
        definition = None if sim.preset is not None else _definition(system)
        head["systems"][name] = {**head["systems"][name], "definition": definition}
    path = Path(path)
    if not path.parent.is_dir():
        raise OutputError(f"cannot write {path}: there is no folder {path.parent}")
    with beside(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        archive.writestr("head.json", json.dumps(head))
        for (name, column), array in snapshot.columns.items():
            write_array(archive, f"{name}/{column}.npy", array)
        for name, array in snapshot.booked.items():
            write_array(archive, f"{name}/booked.npy", array)
        for name, interactions in snapshot.saved_arrays.items():
            for k, arrays in enumerate(interactions):
                for key, array in arrays.items():
                    write_array(archive, f"{name}/{k}.{key}.npy", array)


def write_array(archive: zipfile.ZipFile, name: str, array: np.ndarray) -> None:
    """Add an array to an archive, as .npy."""
    with archive.open(name, "w", force_zip64=True) as out:
        np.lib.format.write_array(out, np.ascontiguousarray(array), allow_pickle=False)


def _read_array(archive, name: str) -> np.ndarray:
    return np.lib.format.read_array(archive.open(name), allow_pickle=False)


def read(path) -> Snapshot:
    """The snapshot at `path`. Raises OutputError if it cannot be read, UsageError if it is not a snapshot."""
    try:
        with zipfile.ZipFile(path) as archive:
            head = json.loads(archive.read("head.json"))
            if head["format"] != _FORMAT:
                raise UsageError(f"{path} is a snapshot of format {head['format']}; this version reads {_FORMAT}")
            systems = head["systems"]
            columns = {
                (name, column): _read_array(archive, f"{name}/{column}.npy") for name in systems for column in _COLUMNS
            }
            saved = {
                name: [
                    {key: _read_array(archive, f"{name}/{k}.{key}.npy") for key in keys}
                    for k, keys in enumerate(entry[_SAVED])
                ]
                for name, entry in systems.items()
            }
            booked = {
                name: _read_array(archive, f"{name}/booked.npy")
                for name, entry in systems.items()
                if entry.get("removed") is not None
            }
            if not isinstance(head["preset"], (dict, type(None))):
                raise UsageError(f"{path} is damaged: its preset is no mapping")
    except (UsageError, MemoryError):
        raise
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from None
    except Exception:  # of a damaged file, zipfile, json and NumPy raise errors of many kinds
        raise UsageError(f"{path} is not a snapshot of this program") from None
    return Snapshot(head, columns, saved, booked)


def _as_dict(law) -> dict:
    """A force, interaction or collider as plain data."""
    laws = {k: v for k, v in law.values.items() if law.parameters[k].kind != "look"}
    values = {k: _medium(v) if isinstance(v, Medium) else v for k, v in laws.items()}
    values = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in values.items()}
    return {"name": law.name, "values": values}


def _medium(medium: Medium) -> dict:
    return {"density": medium.density, "terms": [_as_dict(t) for t in medium.terms]}


def _is_medium(value) -> bool:
    return isinstance(value, dict) and set(value) == {"density", "terms"}


def _definition(system: ParticleSystem) -> dict:
    if system.emitters:
        raise UsageError("a system with emitters made in Python cannot be saved: describe it as a preset")
    for force in [*system.forces, *system.medium.terms]:
        if force.name not in FORCES or any(isinstance(v, np.ndarray) for v in force.values.values()):
            raise UsageError(f"{force!r} cannot be saved: register its class with @ga.force('name')")
    for collider in system.colliders:
        if any(callable(v) for v in collider.values.values()):
            raise UsageError(f"{collider!r} is given by a function, and a function cannot be saved: give it as a grid")
    return {
        "forces": [_as_dict(f) for f in system.forces],
        "interactions": [_as_dict(i) for i in system.interactions],
        "colliders": [_as_dict(c) for c in system.colliders],
        "medium": _medium(system.medium),
        "integrator": system.scheme.name,
        "speed_of_light": system.scheme.light or None,
        "exact_gyration": system.scheme.exact,
        "attributes": list(system.attribute_names),
        "booked": [entry.plain for entry in system.entries],
    }


def _build(definition: dict) -> ParticleSystem:
    def medium(entry):
        return Medium(entry["density"], field=[build(FORCES, t) for t in entry["terms"]])

    def build(registry, entry):
        values = {k: medium(v) if _is_medium(v) else v for k, v in entry["values"].items()}
        return registry[entry["name"]](**values)

    empty = np.zeros((0, 3))
    return ParticleSystem(
        position=empty,
        forces=[build(FORCES, f) for f in definition["forces"]],
        interactions=[build(INTERACTIONS, i) for i in definition["interactions"]],
        colliders=[build(COLLIDERS, c) for c in definition.get("colliders", ())],
        medium=medium(definition["medium"]),
        integrator=definition["integrator"],
        speed_of_light=definition.get("speed_of_light"),
        exact_gyration=definition.get("exact_gyration", False),
        attributes={name: np.zeros(0) for name in definition["attributes"]},
        booked=definition.get("booked", ()),
    )
