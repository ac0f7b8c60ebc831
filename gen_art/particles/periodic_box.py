"""A periodic box: particles that leave it on one side come in at the other.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import asdict, dataclass

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError

__all__ = ["BOX_NUMBERS", "PeriodicBox", "wrapped"]

BOX_NUMBERS = 9  # of a box in kernels: the lower corner, the upper corner, the lengths
_AXES = "xyz"
_CELLS = 3  # a neighbour's image is the only one in reach where the box is this many times the reach
_FEWEST_PLACES = 1024  # different coordinates in the box


@dataclass(frozen=True)
class PeriodicBox:
    """min <= x < max along each periodic axis, and x + k (max - min) is the same place for every whole number k.

    min, max : (3,) m, opposite corners
    axes : the periodic axes, some of "xyz"; space is open along the others, whose min and max are not used
    Raises UsageError for axes that are none of xyz, and for a box without a length along a periodic axis.
    """

    min: tuple[float, float, float]
    max: tuple[float, float, float]
    axes: str = _AXES

    def __post_init__(self) -> None:
        axes = self.axes if isinstance(self.axes, str) else ""
        if not axes or set(axes) - set(_AXES) or len(set(axes)) < len(axes):
            raise UsageError(f"axes must be some of xyz, each once, such as xy, not {self.axes!r}")
        for axis, low, high, length in zip(_AXES, self.min, self.max, self.lengths):
            if axis in axes and not 0.0 < length < np.inf:
                raise UsageError(f"max must be above min along {axis}, not {high:g} with a min of {low:g}")

    @property
    def lengths(self) -> np.ndarray:
        """(3,) m, 0 along axes that are not periodic."""
        periodic = [axis in self.axes for axis in _AXES]
        with np.errstate(all="ignore"):
            return np.where(periodic, np.subtract(self.max, self.min, dtype=np.float64), 0.0)

    def numbers(self, dtype) -> np.ndarray:
        """(BOX_NUMBERS,) of the kernels. The corners are rounded upwards, so that min <= x < max holds exactly."""
        dtype = np.dtype(dtype).type
        corners = np.where(np.tile(self.lengths > 0, 2), np.concatenate([self.min, self.max]), 0.0)
        rounded = corners.astype(dtype)
        rounded = np.where(rounded.astype(np.float64) < corners, np.nextafter(rounded, dtype(np.inf)), rounded)
        return np.concatenate([rounded, self.lengths.astype(dtype)])

    def check_precision(self, dtype) -> None:
        """Raise UsageError where numbers of this type have too few coordinates in the box."""
        dtype = np.dtype(dtype).type
        for axis, low, high, length in zip(_AXES, self.min, self.max, self.lengths):
            spacing = float(np.spacing(dtype(max(abs(low), abs(high)))))
            if 0 < length < _FEWEST_PLACES * spacing:
                better = "use precision f64, or move the box" if dtype == np.float32 else "move the box"
                raise UsageError(
                    f"domain: near {high:g} m the coordinates of {np.dtype(dtype).name} are {spacing:.2g} m apart, too far for "
                    f"a box of {length:g} m along {axis}: {better} nearer to 0"
                )

    def problem_of_reach(self, name: str, reach: float) -> str | None:
        """Why particles that `reach` so far, in m, might reach two images of another; None if they cannot."""
        for axis, length in zip(_AXES, self.lengths):
            if 0 < length < _CELLS * reach:
                return (
                    f"{name} reach {reach:g} m, and a periodic box must be at least {_CELLS} times as long, "
                    f"{_CELLS * reach:g} m: along {axis} it is {length:g} m; make the box longer or the particles smaller"
                )
        return None

    def wrap(self, positions: np.ndarray) -> None:
        """Move positions (3, n), m, into the box, in place; as `wrapped` does in kernels."""
        dtype = positions.dtype.type
        low, high, length = self.numbers(dtype).reshape(3, 3)
        with np.errstate(all="ignore"):
            for c in np.flatnonzero(length > 0):
                x = positions[c]
                outside = np.flatnonzero((x < low[c]) | (x >= high[c]))
                y = x[outside]
                y = y - length[c] * np.floor((y - low[c]) / length[c])
                x[outside] = np.where((y < low[c]) | (y >= high[c]), low[c], y)

    def nearest(self, differences: np.ndarray) -> np.ndarray:
        """Differences of positions, (3, n) m, to the nearest images: each at most half a length."""
        length = self.lengths[:, None]
        turns = np.floor(np.divide(differences, length, out=np.zeros(differences.shape), where=length > 0) + 0.5)
        return differences - (length * turns).astype(differences.dtype)

    def jumps(self, differences: np.ndarray) -> np.ndarray:
        """(n,) bools: which differences of positions, (3, n) m, are above half a length, as after passing a side."""
        return ((self.lengths[:, None] > 0) & (2 * np.abs(differences) > self.lengths[:, None])).any(axis=0)

    def as_dict(self) -> dict:
        """Plain data."""
        plain = asdict(self)
        return {key: list(value) if isinstance(value, tuple) else value for key, value in plain.items()}

    def __str__(self) -> str:
        sides = [
            f"{axis} from {low:g} to {high:g}"
            for axis, low, high in zip(_AXES, self.min, self.max)
            if axis in self.axes
        ]
        return f"periodic, {', '.join(sides)}"


@ti.func
def wrapped(x, low, high, length):
    """One coordinate in the box; unchanged where it is inside, where the length is 0, and where it is not finite.

    A coordinate that the subtraction rounds to the upper side is at the lower side, which is the same place.
    """
    y = x - length * ti.floor((x - low) / ti.max(length, 1e-30))
    y = ti.select((y < low) | (y >= high), low, y)
    return ti.select((length > 0.0) & ((x < low) | (x >= high)), y, x)
