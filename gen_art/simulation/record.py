"""A record: values of a simulation that are kept every so many steps while it runs."""

import atexit
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art import arguments
from gen_art.errors import OutputError, UsageError
from gen_art.registry import suggest
from gen_art.simulation.record_columns import Column, DiskColumn, MemoryColumn
from gen_art.simulation.record_files import check_file, data_frame, save
from gen_art.simulation.record_quantities import Moment, Quantity, quantity_of

if TYPE_CHECKING:
    import pandas

    from gen_art.simulation.simulation import Simulation

__all__ = ["Record"]


class Record(dict[str, np.ndarray]):
    """Arrays by name, with the moments on the first axis; they are as long as the record was when they were taken from it.

    "time" : (moments,) s, also `record.time`
    a sum of ga.Diagnostics, such as "energy", of all systems, or of one as "stars.energy" : (moments,) or (moments, 3)
    a quantity of each particle, such as "stars.position" : (moments, n, 3) or (moments, n), of the particles that lived when the
        record began, in the order of `record.ids["stars"]`; NaN after a particle's death
    It goes on until `close()`, or the end of its `with` block. A record that goes to a file holds no arrays after that.
    """

    def __init__(self, sim: "Simulation", every: int, what: Iterable[str], to: Any):
        super().__init__()
        self._every = arguments.whole("every", every, 1)
        self._quantities = [Quantity("time", (), np.dtype(np.float64), _time), *_checked(sim, what)]
        self.ids = {one.system: one.ids for one in self._quantities if one.ids is not None}
        self._path = None if to is None else arguments.path("to", to)
        self._folder: Path | None = None
        if self._path is not None:
            check_file(self._path, self._quantities)
            self._folder = _temporary_folder(self._path)
            atexit.register(self.close)  # a script that ends without `close` still gets its file
        self._columns: dict[str, Column] = {}
        for k, one in enumerate(self._quantities):
            self._columns[one.name] = (
                MemoryColumn(one.shape, one.dtype)
                if self._folder is None
                else DiskColumn(self._folder / str(k), one.shape, one.dtype)
            )
        self._sim: Simulation | None = sim
        self._moments, self._next = 0, sim.steps_done
        self.look(sim)

    @property
    def time(self) -> np.ndarray:
        """(moments,) s, simulated times."""
        return self["time"]

    def steps_left(self, done: int) -> int:
        """The number of steps from step `done` to the next moment."""
        return max(1, self._next - done)

    def look(self, sim: "Simulation") -> None:
        """Keep the present values if they are due."""
        if sim.steps_done < self._next:
            return
        moment = Moment(sim)
        for one in self._quantities:
            self._columns[one.name].write(self._moments, one.measure(moment))
        self._moments, self._next = self._moments + 1, sim.steps_done + self._every
        self.update({name: column.array(self._moments) for name, column in self._columns.items()})

    def close(self) -> None:
        """End the record; one that goes to a file is written there. A second call does nothing.

        Raises OutputError when the file cannot be written; then the values are still here, and `save` can write them elsewhere.
        """
        if self._sim is not None:
            self._sim.stop_observing(self)
            self._sim = None
        if self._path is None or self._folder is None:
            return
        atexit.unregister(self.close)
        save(self, self._quantities, self._path)
        self.clear()
        for column in self._columns.values():
            if isinstance(column, DiskColumn):
                column.close()
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder = None

    def save(self, path: Any) -> None:
        """Write what was recorded so far to a file: .npz, .parquet (a table as of `to_pandas`) or .zarr.

        Beside the arrays an .npz or .zarr has "SYSTEM.ids" of the particles. Raises OutputError when the file cannot be written,
        UsageError for another ending or a package that is missing.
        """
        save(self._open(), self._quantities, arguments.path("path", path))

    def to_pandas(self) -> "pandas.DataFrame":
        """A DataFrame with a row for each moment, by time, and a column for each number: "momentum.x", "stars.position.7.x".

        7 is the id of a particle. Raises UsageError without the package pandas, and for more than 10,000 columns.
        """
        return data_frame(self._open(), self._quantities)

    def _open(self) -> "Record":
        if not self:
            raise UsageError(f"this record is closed, and its values are in {self._path}: read them from there")
        return self

    def __missing__(self, name: Any) -> np.ndarray:
        self._open()
        hint = suggest(name, self) or f"; it has {', '.join(self)}"
        raise UsageError(f"the record has no {arguments.shown(name)}{hint}")

    def __enter__(self) -> "Record":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        if not self:
            return f"<Record in {self._path}>"
        return f"<Record of {', '.join(self)}; {len(self.time):,} moments>"


def _time(moment: Moment) -> np.ndarray:
    return np.asarray(moment.sim.time)


def _checked(sim: "Simulation", what: Any) -> list[Quantity]:
    """The quantities of these names. Raises UsageError for no names, one name twice, or an unknown one."""
    if isinstance(what, (str, bytes, Mapping)) or not isinstance(what, Iterable):
        raise UsageError(
            f'what must be a list of quantities, such as ["energy", "stars.position"], not {arguments.shown(what)}'
        )
    quantities = [quantity_of(sim, name) for name in what]
    names = [one.name for one in quantities]
    if not names:
        raise UsageError('what must name at least one quantity, such as ["energy"]')
    again = {name for name in names if names.count(name) > 1}
    if again:
        raise UsageError(f"what has {sorted(again)[0]} twice")
    return quantities


def _temporary_folder(path: Path) -> Path:
    try:
        return Path(tempfile.mkdtemp(prefix=".gen-art-", suffix=".part", dir=path.parent))
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
