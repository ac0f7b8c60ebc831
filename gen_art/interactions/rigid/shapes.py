"""The shapes of bodies: balls, capsules and boxes, each a core (a point, a segment, a box) rounded by a radius.

Volume, area, second moments of the solid and of the shell, and points on the surface or along the edges.
"""

import math
from dataclasses import dataclass

import numpy as np

from gen_art.arguments import shown
from gen_art.errors import UsageError
from gen_art.interactions.rigid.quaternions import matrices, rotation
from gen_art.interactions.rigid.small_matrices import apply, apply_transposed, compose, norm
from gen_art.maths.array_functions import cos, sin
from gen_art.quantities import plain
from gen_art.registry import suggest

__all__ = ["BALL", "BOX", "CAPSULE", "Part", "parts_of", "plain_shape"]

BALL, CAPSULE, BOX = 0, 1, 2
_KINDS = {"sphere": BALL, "capsule": CAPSULE, "box": BOX}
_UNITS = {"sphere": "m", "capsule": "m", "box": "m", "at": "m", "turn": "degrees"}
MOST_SLENDER = 1e5  # largest over smallest size: the moments go by the squares, of which float64 holds 15 digits
_GOLDEN = math.pi * (3 - math.sqrt(5))


@dataclass(frozen=True)
class Part:
    """One shape of a body.

    kind : BALL, CAPSULE or BOX
    half : (3,) m, half extents of the core
    radius : m, of the rounding
    center : (3,) m
    axes : (3, 3), columns are the shape's axes
    share : its density relative to the body's other parts
    """

    kind: int
    half: np.ndarray
    radius: float
    center: np.ndarray
    axes: np.ndarray
    share: float = 1.0

    @property
    def volume(self) -> float:
        r, (a, b, c) = self.radius, self.half
        return 8 * a * b * c if self.kind == BOX else 2 * math.pi * r * r * b + 4 / 3 * math.pi * r**3

    @property
    def area(self) -> float:
        r, (a, b, c) = self.radius, self.half
        return 8 * (a * b + b * c + c * a) if self.kind == BOX else 4 * math.pi * r * (b + r)

    def moments(self, hollow: bool) -> np.ndarray:
        """The mean of x x^T, (3, 3) m^2, over the solid, or over its surface, about the part's centre."""
        r, (a, b, c) = self.radius, self.half
        if self.kind == BOX:
            squares = np.array([a * a, b * b, c * c]) / 3
            if hollow:
                faces = np.array([b * c, c * a, a * b])
                squares *= 1 + 2 * faces / faces.sum()
        else:  # a cylinder of half length b between two hemispheres
            rod, ball = 2 * math.pi * r * r * b, 4 / 3 * math.pi * r**3
            if hollow:
                rod, ball = 4 * math.pi * r * b, 4 * math.pi * r * r
            along = rod * b * b / 3 + ball * (b * b + b * r * (1 if hollow else 0.75) + r * r / (3 if hollow else 5))
            across = rod * r * r / (2 if hollow else 4) + ball * r * r / (3 if hollow else 5)
            squares = np.array([across, along, across]) / (rod + ball)
        return compose(self.axes * squares, self.axes.T)

    @property
    def reach(self) -> float:
        """A distance, m, from its centre that no point of the part is beyond."""
        return float(norm(self.half)) + self.radius

    def distance(self, x: np.ndarray) -> np.ndarray:
        """Distances (n,), m, of points (n, 3) in the body's frame from the surface; negative inside."""
        q = np.abs(apply_transposed(self.axes, x - self.center)) - self.half
        return norm(np.maximum(q, 0)) + np.minimum(q.max(-1), 0) - self.radius

    def points(self, draw: str, spacing: float) -> int:
        """The number of points of `surface` ("cloud") or about that of `wires` ("wire"), before any is made."""
        r, b = self.radius, float(self.half[1])
        if draw == "wire":
            return round(self.wire_length() / spacing) + 100
        if self.kind == BOX:
            x, y, z = _cells(self.half, spacing)
            return 2 * (x * y + y * z + z * x)
        count, rings, around = _round_counts(b, r, spacing)
        return count + rings * around

    def surface(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points about `spacing` m apart, outward normals (n, 3), and the area, m^2, that each represents."""
        if self.kind == BOX:
            x, n, area = _faces(self.half, spacing)
        else:
            x, n, area = _rounded(float(self.half[1]), self.radius, spacing)
        return apply(self.axes, x) + self.center, apply(self.axes, n), area

    def wires(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same along edges and great circles; their area is 0."""
        x = _edges(self.half, spacing) if self.kind == BOX else _rings(float(self.half[1]), self.radius, spacing)
        n = x - np.clip(x, -self.half, self.half)
        if self.kind == BOX:
            n = np.sign(x) * (np.abs(x) > self.half * (1 - 1e-9))
        n /= np.maximum(norm(n)[:, None], 1e-300)
        return apply(self.axes, x) + self.center, apply(self.axes, n), np.zeros(len(x))

    def wire_length(self) -> float:
        """The length, m, of the edges and great circles."""
        r, b = self.radius, float(self.half[1])
        if self.kind == BOX:
            return 8 * float(self.half.sum())
        return 6 * math.pi * r + (2 * math.pi * r + 8 * b if b else 0)


def parts_of(shape) -> list[Part]:
    """The parts of {"sphere": radius}, {"capsule": [length, radius]}, {"box": [x, y, z]}, or of a list of them.

    Each may have `at` (3,) m, `turn` (3,) degrees as a rotation vector, and `density` relative to the others.
    Raises UsageError.
    """
    entries = shape if isinstance(shape, (list, tuple)) else [shape]
    if not entries:
        raise UsageError("a body needs a shape: sphere, capsule or box")
    parts = [_part(entry) for entry in entries]
    sizes = np.concatenate([size for part in parts for size in (part.half[part.half > 0], [part.radius or np.inf])])
    sizes = sizes[np.isfinite(sizes)]
    if sizes.max() > MOST_SLENDER * sizes.min():
        raise UsageError(
            f"the sizes of a body must differ by a factor of {MOST_SLENDER:,.0f} at most, so that its moments of inertia can be "
            f"told apart, not {sizes.max() / sizes.min():.3g}"
        )
    return parts


def plain_shape(shape):
    """The same shape with the quantities of astropy or pint as plain numbers in m and degrees. Raises UsageError."""
    if isinstance(shape, (list, tuple)):
        return [plain_shape(entry) for entry in shape]
    if not isinstance(shape, dict):
        return shape
    return {key: plain(value, _UNITS.get(key, ""), f"{key} of a shape") for key, value in shape.items()}


def _part(entry) -> Part:
    if not isinstance(entry, dict):
        raise UsageError(
            f"a shape must be such as {{sphere: 0.5}}, {{capsule: [1, 0.2]}} or {{box: [1, 1, 1]}}, not {shown(entry)}"
        )
    kinds = [key for key in entry if key in _KINDS]
    extra = [key for key in entry if key not in (*_KINDS, "at", "turn", "density")]
    if extra or len(kinds) != 1:
        what = f"{len(kinds)} of them"
        if extra:
            what = f"'{extra[0]}'{suggest(extra[0], [*_KINDS, 'at', 'turn', 'density'])}"
        raise UsageError(f"a shape is one of sphere, capsule, box, with at, turn and density beside it; not {what}")
    kind = kinds[0]
    size = _numbers(kind, entry[kind], {"sphere": 1, "capsule": 2, "box": 3}[kind])
    if (size <= 0).any():
        raise UsageError(f"{kind}: sizes must be above 0, not {entry[kind]}")
    half, radius = np.zeros(3), float(size[-1])
    if kind == "box":
        half, radius = size / 2, 0.0
    elif kind == "capsule":
        half[1] = size[0] / 2
    rotation_vector = np.radians(_numbers("turn", entry.get("turn", (0, 0, 0)), 3))
    share = float(_numbers("density", entry.get("density", 1.0), 1)[0])
    if share <= 0:
        raise UsageError(f"density must be above 0, not {share:g}")
    at = _numbers("at", entry.get("at", (0, 0, 0)), 3)
    return Part(_KINDS[kind], half, radius, at, matrices(rotation(rotation_vector)), share)


def _numbers(what: str, value, count: int) -> np.ndarray:
    try:
        array = np.atleast_1d(np.asarray(value, float))
    except (TypeError, ValueError, OverflowError):
        array = np.zeros(0)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise UsageError(f"{what} must be {count} finite number{'s' * (count > 1)}, not {shown(value)}")
    return array


def _sphere(count: int) -> np.ndarray:
    """Directions in a Fibonacci spiral about y."""
    k = np.arange(count)
    y = 1 - (2 * k + 1) / count
    s = np.sqrt(1 - y * y)
    return np.stack([s * cos(_GOLDEN * k), y, s * sin(_GOLDEN * k)], 1)


def _round_counts(b: float, r: float, spacing: float) -> tuple[int, int, int]:
    """Points of the two hemispheres together, an even number: as many on either half; rings of the side, points of a ring."""
    count = max(6, round(4 * math.pi * r * r / spacing**2))
    if b <= 0:
        return count + count % 2, 0, 0
    return count + count % 2, max(1, round(2 * b / spacing)), max(6, round(2 * math.pi * r / spacing))


def _rounded(b: float, r: float, spacing: float):
    count, rings, around = _round_counts(b, r, spacing)
    n = _sphere(count)
    x = r * n + np.sign(n[:, 1:2]) * np.array([0, b, 0])
    area = np.full(len(n), 4 * math.pi * r * r / len(n))
    if b > 0:
        k = np.arange(rings * around)
        angle = 2 * np.pi * (k % around + 0.5 * (k // around % 2)) / around
        side = np.stack([cos(angle), np.zeros(len(k)), sin(angle)], 1)
        y = b * ((2 * (k // around) + 1) / rings - 1)
        x = np.concatenate([x, r * side + np.outer(y, [0, 1, 0])])
        n = np.concatenate([n, side])
        area = np.concatenate([area, np.full(len(k), 4 * math.pi * r * b / len(k))])
    return x, n, area


def _cells(half: np.ndarray, spacing: float) -> list[int]:
    """How many points a box has along each axis of its faces."""
    return [max(1, round(2 * h / spacing)) for h in half]


def _faces(half: np.ndarray, spacing: float):
    points, normals, areas = [], [], []
    along = _cells(half, spacing)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        i, j = np.meshgrid(*((2 * np.arange(along[w]) + 1) / along[w] - 1 for w in (u, v)), indexing="ij")
        for side in (-1.0, 1.0):
            x, n = np.zeros((i.size, 3)), np.zeros((i.size, 3))
            x[:, axis], x[:, u], x[:, v], n[:, axis] = side * half[axis], half[u] * i.ravel(), half[v] * j.ravel(), side
            points.append(x)
            normals.append(n)
            areas.append(np.full(i.size, 4 * half[u] * half[v] / i.size))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(areas)


def _edges(half: np.ndarray, spacing: float) -> np.ndarray:
    signs = np.array([(a, b, c) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)])
    points = [signs * half]
    for axis in range(3):
        count = max(1, round(2 * half[axis] / spacing) - 1)
        along = 2 * np.arange(1, count + 1) / (count + 1) - 1
        for a in (-1.0, 1.0):
            for b in (-1.0, 1.0):
                x = np.zeros((count, 3))
                x[:, axis] = along * half[axis]
                x[:, (axis + 1) % 3], x[:, (axis + 2) % 3] = a * half[(axis + 1) % 3], b * half[(axis + 2) % 3]
                points.append(x)
    return np.concatenate(points)


def _rings(b: float, r: float, spacing: float) -> np.ndarray:
    count = 4 * max(2, round(math.pi * r / 2 / spacing))
    angle = 2 * np.pi * (np.arange(count) + 0.5) / count
    c, s, o = r * cos(angle), r * sin(angle), np.zeros(count)
    shift = np.sign(s) * b
    points = [np.stack([c, s + shift, o], 1), np.stack([o, s + shift, c], 1)]
    for y in (-b, b) if b else (0.0,):
        points.append(np.stack([c, np.full(count, y), s], 1))
    rungs = round(2 * b / spacing)
    along = b * ((2 * np.arange(rungs) + 1) / max(rungs, 1) - 1)
    for x, z in ((r, 0.0), (-r, 0.0), (0.0, r), (0.0, -r)):
        points.append(np.stack([np.full(rungs, x), along, np.full(rungs, z)], 1))
    return np.concatenate(points)
