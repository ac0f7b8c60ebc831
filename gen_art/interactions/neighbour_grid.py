"""Neighbour search by a uniform grid: the particles sorted by cell, by a counting sort of fixed order.

A cell is as wide as the largest distance of an interacting pair, so that neighbours lie in 3 x 3 x 3 cells. Along x, cells
beyond the ends of the grid count as the last ones; along y and z the grid is periodic. Memory is therefore proportional to the
particles however far they fly, and each pair is still found once, because distances decide.

In a periodic box a whole number of cells, at least three, fits into each periodic axis. The cells beyond one side are then
those at the other, and a pair's separation is that of nearest images.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.errors import DivergedError
from gen_art.particles.fixed import is_fixed
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.rows import LIFETIME, MASS, RADIUS

__all__ = [
    "INVERSE_MASS_AT", "POSITION_AT", "RADIUS_AT", "RECORD", "VELOCITY_AT", "Grid", "cell_of", "frame_vector",
    "nearest_image", "place_in_grid", "run_beyond", "run_of", "sort_into_grid",
]  # fmt: skip

# a particle's record in the sorted copy: position, velocity, radius, 1 / mass (0 where fixed)
POSITION_AT, VELOCITY_AT, RADIUS_AT, INVERSE_MASS_AT, RECORD = 0, 3, 6, 7, 8
# a grid's frame in a periodic box: its origin, the widths of its cells, the box's lengths (0 along open axes) and their inverses
_ORIGIN, _WIDTHS, _LENGTHS, _INVERSES = 0, 3, 6, 9
_FARTHEST = 1e9  # cells from the origin: beyond, a cell's number is no int32
_CHUNKS = (
    4  # of the particles, counted and placed in parallel; fixed, so that the sort is the same on any number of threads
)


@dataclass
class Grid:
    """Particles sorted by cell.

    first : (cells + 1,), the place in `sorted` where each cell begins
    sorted : (n RECORD,), the particles' records
    slots : (n,), the slot of the particle at each place
    rank : (n,), the place of each particle
    size : m, width of a cell
    low, shape : (3,), the first cell along each axis, and the number of cells
    frame : (12,) in a periodic box, else empty: origin, widths of cells, lengths of the box (0 along open axes), 1 / lengths
    """

    first: np.ndarray
    sorted: np.ndarray
    slots: np.ndarray
    rank: np.ndarray
    size: float
    low: np.ndarray
    shape: np.ndarray
    frame: np.ndarray


def sort_into_grid(
    rows: np.ndarray, floats: np.ndarray, n: int, size: float, precision: str, box: PeriodicBox | None = None
) -> Grid:
    """A grid with cells of `size`, m, of the first n particles: positions and velocities in `rows`, the rest in `floats`.

    box : the periodic box that the positions are in; along its axes cells may be wider
    """
    low = np.array([np.floor(rows[c, :n].min() / size) for c in range(3)])
    high = np.array([np.floor(rows[c, :n].max() / size) for c in range(3)])
    if not max(np.abs(low).max(), np.abs(high).max()) <= _FARTHEST:
        raise DivergedError(
            f"a particle with contacts is {np.abs(rows[:3, :n]).max():.3g} m from the origin, more than {_FARTHEST:.0e} times "
            "the size of the largest sphere: most likely because a step is too long for the forces"
        )
    shape = np.clip(high - low + 1, 3, 2**20)
    lengths = np.zeros(3) if box is None else box.lengths
    low, shape = np.where(lengths > 0, 0, low), np.where(lengths > 0, np.clip(lengths // size, 3, 2**20), shape)
    while shape.prod() > 2 * n + 4096 and shape.max() > 3:
        shape[np.argmax(shape)] = max(3, np.ceil(shape.max() / 2))
    low, shape = low.astype(np.int32), shape.astype(np.int32)
    cells = int(shape.prod())
    count, place = _kernels(precision, box is not None)
    frame = np.zeros(0) if box is None else _frame(box, size, shape)
    cell, counts = np.empty(n, np.int32), np.zeros((cells, _CHUNKS), np.int32)
    width = np.array([size, *frame], rows.dtype)
    count(rows, n, width, low, shape, cell, counts)
    before = np.zeros(cells * _CHUNKS + 1, np.int32)
    np.cumsum(counts.ravel(), out=before[1:])
    first = np.ascontiguousarray(before[::_CHUNKS])
    ordered, slots, rank = np.empty(n * RECORD, rows.dtype), np.empty(n, np.int32), np.empty(n, np.int32)
    place(rows, floats, n, cell, before[:-1].reshape(cells, _CHUNKS), ordered, slots, rank)
    return Grid(first, ordered, slots, rank, size, low, shape, frame)


def _frame(box: PeriodicBox, size: float, shape: np.ndarray) -> np.ndarray:
    """(12,), the frame of a grid of `shape`, with cells of `size`, m, along open axes."""
    lengths = box.lengths
    periodic = lengths > 0
    inverse = np.divide(1.0, lengths, out=np.zeros(3), where=periodic)
    origin, widths = np.where(periodic, box.min, 0.0), np.where(periodic, lengths / shape, size)
    return np.concatenate([origin, widths, lengths, inverse])


@cache
def _kernels(precision: str, periodic: bool):
    real = runtime.DTYPES[precision]
    matrix, ints = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1)
    table, vector = ti.types.ndarray(ti.i32, 2), ti.types.ndarray(real, 1)

    @ti.kernel
    def count(X: matrix, n: ti.i32, size: vector, low: ints, shape: ints, cell: ints, counts: table):
        share = (n + _CHUNKS - 1) // _CHUNKS
        ti.loop_config(block_dim=1)
        for c in range(_CHUNKS):
            for i in range(c * share, ti.min((c + 1) * share, n)):
                x = cell_of(X[0, i], size[0]) - low[0]
                y = (cell_of(X[1, i], size[0]) - low[1]) % shape[1]
                z = (cell_of(X[2, i], size[0]) - low[2]) % shape[2]
                if ti.static(periodic):
                    at = place_in_grid(ti.Vector([X[0, i], X[1, i], X[2, i]]), size, 1)
                    here = periodic_cell(at, low, shape, size, 1)
                    x, y, z = here[0], here[1], here[2]
                k = ti.min(ti.max(x, 0), shape[0] - 1) + shape[0] * (y + shape[1] * z)
                cell[i] = k
                counts[k, c] = counts[k, c] + 1

    @ti.kernel
    def place(X: matrix, S: matrix, n: ti.i32, cell: ints, next_place: table, out: vector, slots: ints, rank: ints):
        share = (n + _CHUNKS - 1) // _CHUNKS
        ti.loop_config(block_dim=1)
        for c in range(_CHUNKS):
            for i in range(c * share, ti.min((c + 1) * share, n)):
                k = next_place[cell[i], c]
                next_place[cell[i], c] = k + 1
                slots[k] = i
                rank[i] = k
                for r in ti.static(range(6)):
                    out[k * RECORD + r] = X[r, i]
                out[k * RECORD + RADIUS_AT] = S[RADIUS, i]
                out[k * RECORD + INVERSE_MASS_AT] = ti.select(
                    is_fixed(S[LIFETIME, i]), 0.0, 1.0 / ti.max(S[MASS, i], 1e-30)
                )

    return runtime.kernel(count, precision), runtime.kernel(place, precision)


@ti.func
def cell_of(x, size):
    """The index of the cell that contains x along one axis."""
    return ti.cast(ti.floor(ti.min(ti.max(x / size, -1.0e9), 1.0e9)), ti.i32)


@ti.func
def frame_vector(q: ti.template(), at):
    return ti.Vector([q[at], q[at + 1], q[at + 2]])


@ti.func
def place_in_grid(x, q: ti.template(), frame: ti.template()):
    """A position in cells, from the origin of a grid whose frame begins at q[frame]."""
    return (x - frame_vector(q, frame + _ORIGIN)) / frame_vector(q, frame + _WIDTHS)


@ti.func
def periodic_cell(at, low: ti.template(), shape: ti.template(), q: ti.template(), frame: ti.template()):
    """The cell of a place in cells; y and z, and x where it is periodic, are those of the grid."""
    c = ti.Vector([cell_of(at[0], 1.0) - low[0], cell_of(at[1], 1.0) - low[1], cell_of(at[2], 1.0) - low[2]])
    return ti.Vector([
        ti.select(q[frame + _LENGTHS] > 0.0, c[0] % shape[0], c[0]), c[1] % shape[1], c[2] % shape[2]
    ])  # fmt: skip


@ti.func
def nearest_image(d, q: ti.template(), frame: ti.template()):
    """A difference of positions to the nearest image; the images of -d and d are opposite to the last bit."""
    turns = ti.floor(d * frame_vector(q, frame + _INVERSES) + 0.5)
    return d - frame_vector(q, frame + _LENGTHS) * turns


@ti.func
def run_beyond(first: ti.template(), shape, x, y, z, left, right, q: ti.template(), frame: ti.template()):
    """As run_of, the cell beyond a side of the periodic axis x, which is at its other end; none where x is open."""
    y = ti.select(y < 0, shape[1] - 1, ti.select(y == shape[1], 0, y))
    z = ti.select(z < 0, shape[2] - 1, ti.select(z == shape[2], 0, z))
    row, last = shape[0] * (y + shape[1] * z), shape[0] - 1
    begin, end = 0, 0
    if q[frame + _LENGTHS] > 0.0:
        if x - left < 0:
            begin, end = first[row + last], first[row + last + 1]
        elif x + right > last:
            begin, end = first[row], first[row + 1]
    return begin, end


@ti.func
def run_of(first: ti.template(), shape, x, y, z, left, right):
    """The places where the cells x - left to x + right of the row (y, z) begin and end; y, z may be one cell outside the grid."""
    y = ti.select(y < 0, shape[1] - 1, ti.select(y == shape[1], 0, y))
    z = ti.select(z < 0, shape[2] - 1, ti.select(z == shape[2], 0, z))
    row, last = shape[0] * (y + shape[1] * z), shape[0] - 1
    return first[row + ti.min(ti.max(x - left, 0), last)], first[row + ti.min(ti.max(x + right, 0), last) + 1]
