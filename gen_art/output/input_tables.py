"""The control inputs of a preset as tables: which there are, and how a table grows while somebody steers."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gen_art.errors import UsageError
from gen_art.forces.controls import Controlled
from gen_art.forces.steering import Device, Hands, Pointer

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["InputTable", "controls_paths", "input_tables", "with_tables"]

WINDOW = 4  # rows that a force has of a growing table


@dataclass
class InputTable:
    """The inputs that some forces read of one table, and its rows as they are recorded.

    file : of the table that the preset names, as written there; None where it names none
    kind : the class of the forces
    rest : by input, at the start, in the units of a table
    devices : by input, what sets it
    rows : (time, inputs in the order of `rest`) as they are written
    """

    file: str | None
    kind: type[Controlled]
    rest: dict[str, float]
    devices: dict[str, Device]
    forces: list[Controlled] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    live: list[Controlled] = field(default_factory=list)

    def begin(self, time: float, distance: float) -> None:
        """Start with a row of the inputs at rest.

        time : s, of that row
        distance : s, from row to row
        """
        self._distance = distance
        self.rows = [_as_written((time, *self.rest.values()))]
        self.live = [force.with_controls(self.window()) for force in self.forces]

    def extend(self, hands: Hands, seconds: float) -> None:
        """Add the next row, moved from the last one by somebody's hands.

        seconds : of the film from row to row
        """
        before = dict(zip(self.rest, self.rows[-1][1:]))
        inputs = (device.moved(before[name], self.rest[name], hands, seconds) for name, device in self.devices.items())
        first = self.rows[0][0]
        self.rows.append(_as_written((first + len(self.rows) * self._distance, *inputs)))
        for force in self.live:
            force.set_table(self.window())

    def window(self) -> dict[str, list[float]]:
        """The last rows as controls of a force. Where there are fewer than WINDOW, rows like the last one follow."""
        rows = self.rows[-WINDOW:]
        while len(rows) < WINDOW:
            rows = [*rows, (rows[-1][0] + self._distance, *rows[-1][1:])]
        return dict(zip(("time", *self.rest), map(list, zip(*rows))))

    def text(self) -> str:
        """The whole table as a .csv file."""
        lines = [("time", *self.rest), *([f"{number!r}" for number in row] for row in self.rows)]
        return "".join(",".join(line) + "\n" for line in lines)

    @property
    def points(self) -> bool:
        """Whether the pointer sets any of it."""
        return any(isinstance(device, Pointer) for device in self.devices.values())


def _as_written(row: Sequence[float]) -> tuple[float, ...]:
    """The numbers that are read again from a file, with nine digits of the time and six of an input."""
    return (float(f"{row[0]:.9g}"), *(float(f"{number:.6g}") for number in row[1:]))


def _forces_of(preset: "Preset") -> Iterator[Controlled]:
    for force in (*preset.forces, *(force for system in preset.systems.values() for force in system.forces)):
        if isinstance(force, Controlled):
            yield force


def input_tables(preset: "Preset") -> list[InputTable]:
    """The tables that can be steered, one for each file, and for each kind of force that has no file.

    Of a file, the columns are steered; without one, all inputs are. Empty if there is nothing to steer.
    """
    found: dict[tuple, InputTable] = {}
    for force in _forces_of(preset):
        given = force.values["controls"]
        file = None if given is None else str(given)
        key = (file, type(force))
        if key not in found:
            rest = {name: value for name, value in force.at_start().items() if name in force.steering}
            devices = {name: force.steering[name] for name in rest}
            found[key] = InputTable(file, type(force), rest, devices)
        found[key].forces.append(force)
    return [table for table in found.values() if table.rest]


def with_tables(preset: "Preset", tables: Sequence[InputTable]) -> "Preset":
    """The preset with forces that read the rows recorded so far."""
    live = {id(old): new for table in tables for old, new in zip(table.forces, table.live)}

    def replaced(forces):
        return tuple(live.get(id(force), force) for force in forces)

    systems = {
        name: system.model_copy(update={"forces": replaced(system.forces)}) for name, system in preset.systems.items()
    }
    return preset.model_copy(update={"forces": replaced(preset.forces), "systems": systems})


def controls_paths(data: Mapping[str, Any], table: InputTable) -> list[str]:
    """The dotted paths of `controls` in the plain data of a preset, of the forces that read a table.

    Raises UsageError for a force that is written in its short form, which has no room for the key.
    """
    kind, found = table.kind.name, []
    holders = {"": data} | {f"systems.{name}.": system for name, system in data.get("systems", {}).items()}
    for prefix, holder in holders.items():
        forces = holder.get("forces") or {}
        if kind not in forces:
            continue
        path, given = f"{prefix}forces.{kind}", forces[kind]
        parts = {f"{path}[{k}]": part for k, part in enumerate(given)} if isinstance(given, list) else {path: given}
        for place, part in parts.items():
            if not isinstance(part, Mapping):
                raise UsageError(
                    f"{place}: write its parameters as a mapping, so that `controls` can stand beside them"
                )
            if part.get("controls") == table.file:
                found.append(f"{place}.controls")
    return found
