"""Grids of vectors from a .npy file, from two channels of a picture, or from an array, with their checks."""

from pathlib import Path

import numpy as np

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.pictures import picture_size, read_picture

__all__ = ["read_array", "read_grid"]

MAX_VECTORS = 2**24  # vectors: 256^3
_SHAPE = "(nx, ny, nz, 3): a vector for each place of a grid"


def read_grid(given) -> np.ndarray:
    """(nx, ny, nz, 3) float64 from a path or an array.

    A .npy file or array has that shape. A picture gives (width, height, 1, 3): red is x, green is y, 0 to 255 for -1 to 1 with
    128 for 0; its bottom row has the lowest y. Raises UsageError if it is not such a grid.
    """
    if not isinstance(given, (str, Path)):
        return _checked(arguments.array("field", given, f"a path, or numbers of the shape {_SHAPE}"), "field")
    path = arguments.path("field", getattr(given, "place", given))
    is_array = _exists(path, given).suffix.lower() == ".npy"
    return _checked(read_array(given) if is_array else _picture(path, given), str(given))


def read_array(given) -> np.ndarray:
    """The array in a .npy file, memory-mapped. Raises UsageError if the file is not one."""
    path = _exists(arguments.path("file", getattr(given, "place", given)), given)
    try:
        return np.lib.format.open_memmap(path, mode="r")  # unlike np.load, it opens no archives and no pickles
    except MemoryError:
        raise
    except Exception as error:  # of a damaged header, NumPy raises errors of many kinds
        raise UsageError(f"{given}: is not a NumPy array of numbers (.npy)") from error


def _exists(path: Path, name) -> Path:
    if not path.is_file():
        raise UsageError(f"{name}: there is no such file")
    return path


def _picture(path: Path, name) -> np.ndarray:
    try:
        width, height = picture_size(path, name)
    except UsageError:
        raise UsageError(f"{name}: is neither a NumPy array (.npy) nor a picture") from None
    if width * height > MAX_VECTORS:
        raise UsageError(f"{name}: has more than {MAX_VECTORS:,} pixels")
    pixels = read_picture(path, name, "RGB").astype(np.float64)
    vectors = np.zeros((width, height, 1, 3))
    vectors[..., 0, :2] = np.maximum((pixels[::-1, :, :2].transpose(1, 0, 2) - 128.0) / 127.0, -1.0)
    return vectors


def _checked(array: np.ndarray, name: str) -> np.ndarray:
    if array.ndim != 4 or array.shape[3] != 3 or 0 in array.shape:
        raise UsageError(f"{name}: a grid must have the shape {_SHAPE}, not {array.shape}")
    if array.size > 3 * MAX_VECTORS:
        raise UsageError(f"{name}: a grid has at most {MAX_VECTORS:,} vectors, not {array.size // 3:,}")
    if array.dtype.kind not in "fiu":
        raise UsageError(f"{name}: a grid holds real numbers, not {array.dtype}")
    numbers = np.array(array, np.float64)
    if not np.isfinite(numbers).all():
        raise UsageError(f"{name}: the grid holds numbers that are not finite")
    return numbers
