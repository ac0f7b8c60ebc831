"""Nets of springs: chains, ropes and cloths as positions, pairs and rest lengths."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from gen_art import arguments
from gen_art.errors import UsageError

__all__ = ["Net", "chain", "cloth", "rope"]


MOST_POINTS = 1_000_000  # of a net


@dataclass(frozen=True)
class Net:
    """Points and the springs between them.

    position : (n, 3) m
    pairs : (m, 2), indices of points
    rest_length : (m,) m
    share : (m,), each spring's part of the stiffness and of the damping
    edges : named groups of points, for pinning
    faces : (k, 3), indices of the points of each triangle of a sheet; none for chains and ropes
    place : (n, 2) m, to the right and down on a sheet at rest; none for chains and ropes
    """

    position: np.ndarray
    pairs: np.ndarray
    rest_length: np.ndarray
    share: np.ndarray
    edges: dict[str, np.ndarray]
    faces: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.int64))
    place: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))

    def springs(self, stiffness: float, damping: float = 0.0, method: str = "explicit", **more):
        """The interaction for a ParticleSystem whose first particles are these points, in this order; `more` as of Springs."""
        from gen_art.interactions.springs import Springs

        more = {"faces": self.faces, **more} if len(self.faces) else more
        return Springs(self.pairs, stiffness, self.rest_length, damping, method, self.share, **more)

    def pinned(self, name: str) -> np.ndarray:
        """The points of the edge of that name: none, start, end, ends, top, left, corners or others, depending on the net."""
        if not isinstance(name, str) or name not in self.edges:
            raise UsageError(f"this net has no edge '{name}': there are {', '.join(self.edges)}")
        return self.edges[name]


def chain(start: ArrayLike, end: ArrayLike, count: int) -> Net:
    """`count` points at equal distances from start to end (3,), m, both included; each is joined to the next."""
    return _string(start, end, count, None, 0.0)


def rope(start: ArrayLike, end: ArrayLike, count: int, length: float | None = None, bend: float = 0.0) -> Net:
    """A chain of the total rest length `length`, m, at least the distance; if longer, it starts as a V that sags down (-y).

    bend : share of the stiffness of springs between every other point, which resist folding
    """
    return _string(start, end, count, length, bend)


def _string(start, end, count, length, bend) -> Net:
    count = arguments.whole("count, the points of a chain,", count, 2, MOST_POINTS)
    a, b = (np.array(arguments.vector(name, given, "m")) for name, given in (("start", start), ("end", end)))
    bend = arguments.number("bend", bend, low=0.0)
    distance = math.sqrt(sum(c * c for c in b - a))
    total = distance if length is None else arguments.number("length", length, "m")
    if total <= 0 or total < distance * (1 - 1e-12):
        raise UsageError(f"a rope of {total:g} m does not reach over {distance:g} m")
    s = np.linspace(0, 1, count)
    x = a + np.outer(s, b - a)
    sag = math.sqrt(max(total * total - distance * distance, 0.0))
    x[:, 1] -= sag * np.minimum(s, 1 - s)
    step = total / (len(s) - 1)
    k = np.arange(len(s))
    pairs, rest, share = [np.stack([k[:-1], k[1:]], 1)], [np.full(len(s) - 1, step)], [np.ones(len(s) - 1)]
    if bend > 0:
        pairs.append(np.stack([k[:-2], k[2:]], 1))
        rest.append(np.full(len(s) - 2, 2 * step))
        share.append(np.full(len(s) - 2, float(bend)))
    edges = {"none": k[:0], "start": k[:1], "end": k[-1:], "ends": k[[0, -1]]}
    return Net(x, np.concatenate(pairs), np.concatenate(rest), np.concatenate(share), edges)


def cloth(
    corner: ArrayLike,
    across: ArrayLike,
    down: ArrayLike,
    columns: int,
    rows: int,
    shear: float = 0.5,
    bend: float = 0.1,
) -> Net:
    """A sheet of columns x rows points over the parallelogram corner + across + down ((3,) m), point k = row columns + column.

    Springs lie along both directions of the weave (share 1), along both diagonals of each cell (shear) and between every
    other point (bend). They are listed head to tail along straight lines, the stiffest last, because method "xpbd" solves
    whole lines at once, in this order.
    """
    columns = arguments.whole("columns of a cloth", columns, 2, MOST_POINTS)
    rows = arguments.whole("rows of a cloth", rows, 2, MOST_POINTS)
    if columns * rows > MOST_POINTS:
        raise UsageError(f"a cloth has at most {MOST_POINTS:,} points, not {columns:,} x {rows:,}")
    shear, bend = arguments.number("shear", shear, low=0.0), arguments.number("bend", bend, low=0.0)
    origin = np.array(arguments.vector("corner", corner, "m"))
    sides = [np.array(arguments.vector(name, side, "m")) for name, side in (("across", across), ("down", down))]
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    x = origin + u.reshape(-1, 1) * sides[0] + v.reshape(-1, 1) * sides[1]
    k = np.arange(columns * rows).reshape(rows, columns)
    lines = []
    if bend > 0:
        lines += [(line[odd::2], bend) for line in (*k, *k.T) for odd in (0, 1)]
    if shear > 0:
        offsets = range(1 - rows, columns)
        lines += [(across.diagonal(o), shear) for across in (k, k[:, ::-1]) for o in offsets]
    lines += [(line, 1.0) for line in (*k, *k.T)]
    pairs = np.concatenate([np.stack([line[:-1], line[1:]], 1) for line, _ in lines])
    share = np.concatenate([np.full(len(line) - 1, float(part)) for line, part in lines])
    rest = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
    edges = {
        "none": k[:0, 0], "top": k[0], "bottom": k[-1], "left": k[:, 0], "right": k[:, -1],
        "corners": k[0, [0, -1]], "four corners": k[[0, 0, -1, -1], [0, -1, 0, -1]],
    }  # fmt: skip
    lengths = [float(np.sqrt((side * side).sum())) for side in sides]
    place = np.stack([u.ravel() * lengths[0], v.ravel() * lengths[1]], axis=1)
    return Net(x, pairs, rest, share, edges, _triangles(k), place)


def _triangles(k: np.ndarray) -> np.ndarray:
    """(m, 3): two triangles for each cell of a sheet of points k (rows, columns), counter-clockwise as seen with column 0 on the
    left and row 0 at the top. The diagonals alternate from cell to cell, so that no direction of the weave is preferred.
    """
    a, b, c, d = (part.reshape(-1) for part in (k[:-1, :-1], k[:-1, 1:], k[1:, :-1], k[1:, 1:]))
    row, column = np.divmod(np.arange(len(a)), k.shape[1] - 1)
    falling = (row + column) % 2 == 0  # the diagonal from a to d
    one = np.where(falling[:, None], np.stack([a, c, d], 1), np.stack([a, c, b], 1))
    two = np.where(falling[:, None], np.stack([a, d, b], 1), np.stack([b, c, d], 1))
    return np.stack([one, two], 1).reshape(-1, 3)
