"""Control inputs recorded over time, as a table that a force reads."""

import csv
import math
from collections.abc import Mapping
from itertools import islice
from typing import ClassVar

import numpy as np

from gen_art import arguments
from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force
from gen_art.forces.steering import Device
from gen_art.registry import param

__all__ = ["Controlled", "read_controls"]

MAX_ROWS = 100_000  # rows: a control for each step of half an hour at 1/60 s
MAX_BYTES = 20_000_000


def read_controls(given, units: Mapping[str, str]) -> dict[str, np.ndarray]:
    """{"time": (n,), name: (n,)} float64 from a .csv file, whose first line names the columns, or from a mapping of arrays.

    units : of the columns beside time, by name; angles are in degrees
    time : s, increasing
    Only those columns that are present are returned. Raises UsageError if it is not such a table.
    """
    columns = dict(given) if isinstance(given, Mapping) else _read(given)
    label = "controls" if isinstance(given, Mapping) else str(given)
    unknown = [str(name) for name in columns if name not in ("time", *units)]
    if "time" not in columns or unknown:
        what = f"has no column {', '.join(sorted(unknown))} to give" if unknown else "needs a column `time`"
        raise UsageError(f"{label}: {what}; the columns are time, {', '.join(units)}")
    if len(columns) == 1:
        raise UsageError(f"{label}: has no input beside time; give at least one of {', '.join(units)}")
    table = {
        name: arguments.array(
            f"{label}: {name}", column, "numbers, one for each time", "s" if name == "time" else units[name]
        )
        for name, column in columns.items()
    }
    time = table["time"]
    for name, column in table.items():
        if column.ndim != 1 or len(column) != len(time) or not 1 <= len(column) <= MAX_ROWS:
            raise UsageError(f"{label}: columns must be lists of one length, from 1 to {MAX_ROWS:,}: {name} is not")
    if (np.diff(time) <= 0).any():
        row = int(np.flatnonzero(np.diff(time) <= 0)[0])
        raise UsageError(
            f"{label}: times must rise from row to row, but {time[row]:g} s is followed by {time[row + 1]:g} s"
        )
    return table


def _read(given) -> dict[str, list[float]]:
    path = arguments.path("controls", getattr(given, "place", given))
    if not path.is_file():
        raise UsageError(f"{given}: there is no such file")
    if path.stat().st_size > MAX_BYTES:
        raise UsageError(
            f"{given}: is larger than {MAX_BYTES // 10**6} MB: a table of controls has at most {MAX_ROWS:,} rows"
        )
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, skipinitialspace=True)
            kept = ((reader.line_num, row) for row in reader if row and not row[0].startswith("#"))
            rows = list(islice(kept, MAX_ROWS + 2))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{given}: cannot be read as a table of comma-separated numbers") from error
    if len(rows) > MAX_ROWS + 1:
        raise UsageError(f"{given}: has more than {MAX_ROWS:,} rows")
    if len(rows) < 2:
        raise UsageError(f"{given}: needs a line of names and at least one of numbers")
    names = [name.strip() for name in rows[0][1]]
    columns: dict[str, list[float]] = {name: [] for name in names}
    if len(columns) < len(names):
        raise UsageError(f"{given}: names a column twice")
    for number, row in rows[1:]:
        if len(row) != len(names):
            raise UsageError(f"{given}: line {number} has {len(row)} numbers for {len(names)} columns")
        for name, word in zip(names, row):
            try:
                columns[name].append(float(word))
            except ValueError:
                raise UsageError(f"{given}: line {number}: {word!r} is not a number") from None
    return columns


class Controlled(Force):
    """The base of forces with control inputs. Each name in `inputs` is a parameter, and may be a column of the table.

    Between two rows the value is linear; before the first and after the last row it is theirs.
    steering : by input, how a person sets it where the motion is steered live; see gen_art.forces.steering
    """

    controls: object = param(
        None, kind="file", doc="a .csv file of a column `time` (s) and columns of inputs, or a mapping"
    )
    inputs: ClassVar[tuple[str, ...]] = ()
    steering: ClassVar[Mapping[str, Device]] = {}
    tabled = True

    def prepare(self):
        self.set_table(self.values["controls"])

    def set_table(self, given) -> None:
        """Go on with another table; see `read_controls`. None is one row of the parameters. Raises UsageError.

        A force that already acts in a simulation takes one with as many rows as before; `KernelTerms.place_tables` then
        passes it on.
        """
        table = {"time": np.zeros(1)} if given is None else read_controls(given, self.input_units())
        self.tabled_inputs = tuple(name for name in self.inputs if name in table)
        columns = []
        for name in self.inputs:
            if name in table:
                parameter = self.parameters[name]
                angle = self._is_angle(name)
                column = np.radians(table[name]) if angle else table[name]
                low, high = parameter.minimum, parameter.maximum
                if column.min() < low or column.max() > high:
                    low, high = (math.degrees(x) if angle else x for x in (low, high))
                    wrong = next(x for x in table[name] if not low <= x <= high)
                    label = "controls" if isinstance(given, Mapping) else given
                    raise UsageError(
                        f"{label}: {name} must be from {low:g} to {high:g}{' degrees' if angle else ''}, not {wrong:g}"
                    )
            else:
                column = np.full(len(table["time"]), self.values[name])
            columns.append(column)
        self._table = np.concatenate([[len(table["time"])], table["time"], *columns])

    @classmethod
    def input_units(cls) -> dict[str, str]:
        """The units of the inputs as a table has them, by name: angles are in degrees."""
        return {name: cls.parameters[name].unit.replace("rad", "degrees") for name in cls.inputs}

    def at_start(self) -> dict[str, float]:
        """By name, the inputs of the table's first row, in its units; those of all inputs where there is no table."""
        rows, names = int(self._table[0]), self.tabled_inputs or self.inputs
        first = {name: float(self._table[1 + rows * (k + 1)]) for k, name in enumerate(self.inputs)}
        return {name: math.degrees(first[name]) if self._is_angle(name) else first[name] for name in names}

    def with_controls(self, controls: Mapping) -> "Controlled":
        """The same force with another table."""
        return type(self)(**{**{name: self.values[name] for name in self.parameters}, "controls": controls})

    @classmethod
    def _is_angle(cls, name: str) -> bool:
        return cls.parameters[name].unit == "rad"

    @property
    def steady(self) -> bool:  # type: ignore[override]  # depends on the instance: only a table changes with time
        return self.values["controls"] is None

    @property
    def fixed(self) -> tuple:
        return (*super().fixed, self.steady)

    def table(self) -> np.ndarray:
        return self._table

    @ti.func
    def recorded(self, k: ti.template(), t, q):
        """Control input number k at time t."""
        n = ti.cast(q.table(0), ti.i32)
        low, high = 0, n - 1
        while high - low > 1:
            middle = (low + high) // 2
            if q.table(1 + middle) <= t:
                low = middle
            else:
                high = middle
        start, end = q.table(1 + low), q.table(1 + high)
        fraction = ti.select(end > start, (t - start) / ti.select(end > start, end - start, 1.0), 0.0)
        fraction = ti.min(ti.max(fraction, 0.0), 1.0)
        row = 1 + n * (k + 1)
        return q.table(row + low) * (1.0 - fraction) + q.table(row + high) * fraction
