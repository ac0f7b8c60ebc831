"""Files of records: .npz by NumPy alone; .parquet, .zarr and tables by the packages of the extra `histories`."""

import importlib
import math
import secrets
import shutil
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art.errors import OutputError, UsageError
from gen_art.files import beside
from gen_art.simulation.record_quantities import Quantity
from gen_art.simulation.snapshot import write_array

if TYPE_CHECKING:
    import pandas

__all__ = ["check_file", "data_frame", "save"]

Arrays = Mapping[str, np.ndarray]
Quantities = Sequence[Quantity]

_PACKAGES = {".npz": "", ".parquet": "pyarrow", ".zarr": "zarr"}  # by ending
_WIDEST = 10_000  # columns of a table
_BLOCK = 2**24  # bytes that are written at a time, so that a record that is larger than the memory can be


def check_file(path: Path, quantities: Quantities) -> None:
    """Raise UsageError for a file that cannot hold a record, or if its package is missing, and OutputError without its folder."""
    if path.suffix not in _PACKAGES:
        raise UsageError(f"{path}: a record is saved as {', '.join(_PACKAGES)}, by the ending of the file's name")
    if _PACKAGES[path.suffix]:
        _package(_PACKAGES[path.suffix], path.suffix)
    if path.suffix == ".parquet":
        _check_width(quantities)
    if not path.parent.is_dir():
        raise OutputError(f"cannot write {path}: there is no folder {path.parent}")
    if path.is_dir() and not (path.suffix == ".zarr" and (path / "zarr.json").is_file()):
        raise OutputError(f"cannot write {path}: a folder has this name")


def save(record: Arrays, quantities: Quantities, path: Path) -> None:
    """Write a record. Raises OutputError when the file cannot be written, UsageError as `check_file` does."""
    check_file(path, quantities)
    if path.suffix == ".npz":
        with beside(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
            for name, array in _with_ids(record, quantities):
                write_array(archive, f"{name}.npy", array)
    elif path.suffix == ".parquet":
        with beside(path) as temporary:
            _write_parquet(_table(record, quantities), temporary)
    else:
        _write_zarr(_with_ids(record, quantities), path)


def data_frame(record: Arrays, quantities: Quantities) -> "pandas.DataFrame":
    """A row for each moment, by time, and a column for each number."""
    pandas = _package("pandas", "to_pandas()")
    columns = _table(record, quantities)
    time = columns.pop("time")
    return pandas.DataFrame(columns, index=pandas.Index(time, name="time"))


def _with_ids(record: Arrays, quantities: Quantities) -> list[tuple[str, np.ndarray]]:
    """The arrays by name, and the ids of the particles that they stand for."""
    ids = {f"{one.system}.ids": one.ids for one in quantities if one.ids is not None}
    return [*record.items(), *ids.items()]


def _package(name: str, what: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise UsageError(
            f"{what} needs the package {name}, which is not installed: pip install 'gen-art[histories]'"
        ) from None


def _table(record: Arrays, quantities: Quantities) -> dict[str, np.ndarray]:
    """By name, the numbers, (moments,), of each column of a table."""
    _check_width(quantities)
    columns: dict[str, np.ndarray] = {}
    for one in quantities:
        labels = [one.name]
        if one.ids is not None:
            labels = [f"{one.name}.{number}" for number in one.ids]
        if len(one.shape) > (one.ids is not None):
            labels = [f"{label}.{axis}" for label in labels for axis in "xyz"]
        columns |= zip(labels, record[one.name].reshape(-1, len(labels)).T)
    return columns


def _check_width(quantities: Quantities) -> None:
    width = sum(math.prod(one.shape) for one in quantities)
    if width > _WIDEST:
        raise UsageError(
            f"a table of this record has {width:,} columns, one for each number of each particle, and {_WIDEST:,} are the most: "
            "save it as .npz or .zarr"
        )


def _rows_at_a_time(rows: int, bytes_of_a_row: int) -> Iterator[slice]:
    step = max(1, _BLOCK // max(1, bytes_of_a_row))
    return (slice(first, min(first + step, rows)) for first in range(0, rows, step))


def _write_parquet(columns: dict[str, np.ndarray], path: Path) -> None:
    arrow, parquet = _package("pyarrow", ".parquet"), _package("pyarrow.parquet", ".parquet")
    schema = arrow.schema([(name, arrow.from_numpy_dtype(column.dtype)) for name, column in columns.items()])
    rows = len(columns["time"])
    with parquet.ParquetWriter(path, schema) as file:
        for some in _rows_at_a_time(rows, 8 * len(columns)):
            arrays = [arrow.array(np.ascontiguousarray(column[some])) for column in columns.values()]
            file.write_table(arrow.Table.from_arrays(arrays, schema=schema))


def _write_zarr(arrays: list[tuple[str, np.ndarray]], path: Path) -> None:
    """Write a folder beside `path`, and put it in the place of a zarr that is there."""
    zarr = _package("zarr", ".zarr")
    temporary, old = (path.with_name(f".gen-art-{secrets.token_hex(8)}.part.zarr") for _ in range(2))
    try:
        group = zarr.open_group(str(temporary), mode="w")
        for name, array in arrays:
            some = max(1, _BLOCK // max(1, array[:1].nbytes))
            chunks = (min(len(array), some), *array.shape[1:])
            out = group.create_array(name, shape=array.shape, dtype=array.dtype, chunks=chunks)
            for rows in _rows_at_a_time(len(array), array[:1].nbytes):
                out[rows] = array[rows]
        if path.exists():
            path.rename(old)
        temporary.rename(path)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        for folder in (temporary, old):
            shutil.rmtree(folder, ignore_errors=True)
