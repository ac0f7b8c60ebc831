"""Columns of a record: arrays whose rows are written one after another, in memory or in a file."""

from pathlib import Path
from typing import Protocol

import numpy as np

from gen_art.errors import OutputError
from gen_art.files import create

__all__ = ["Column", "DiskColumn", "MemoryColumn"]


class Column(Protocol):
    """An array whose rows are written one after another."""

    def write(self, number: int, row: np.ndarray) -> None:
        """Write row `number`; the rows before it are there already."""
        ...

    def array(self, count: int) -> np.ndarray:
        """(count, *shape of a row), the first rows, read-only."""
        ...


class MemoryColumn:
    """A column in memory. The array is twice as long whenever it is full."""

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype):
        self._rows = np.zeros((16, *shape), dtype)

    def write(self, number: int, row: np.ndarray) -> None:
        if number == len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
        self._rows[number] = row

    def array(self, count: int) -> np.ndarray:
        rows = self._rows[:count]
        rows.flags.writeable = False
        return rows


class DiskColumn:
    """A column in a file of nothing but its numbers. Raises OutputError where the file cannot be written."""

    def __init__(self, path: Path, shape: tuple[int, ...], dtype: np.dtype):
        self._path, self._shape, self._dtype = path, shape, np.dtype(dtype)
        self._file = create(path)

    def write(self, number: int, row: np.ndarray) -> None:
        data = memoryview(np.asarray(row, self._dtype).tobytes())
        try:
            self._file.seek(number * len(data))
            while data:
                data = data[self._file.write(data) :]
        except OSError as error:
            raise OutputError(f"cannot write {self._path}: {error.strerror or error}") from error

    def array(self, count: int) -> np.ndarray:
        return np.memmap(self._path, self._dtype, "r", shape=(count, *self._shape))

    def close(self) -> None:
        self._file.close()
