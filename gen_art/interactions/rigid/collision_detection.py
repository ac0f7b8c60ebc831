"""Collision detection: pairs whose axis-aligned bounding boxes overlap, then the contacts of each pair of shapes.

Every shape is a core (point, segment or box) rounded by a radius. The contacts of all pairs but two boxes are therefore the
nearest points of two cores.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.interactions.rigid.box_contacts import contacts_between_boxes
from gen_art.interactions.rigid.shapes import BALL, BOX
from gen_art.interactions.rigid.small_matrices import apply, apply_transposed, dot, norm

__all__ = ["MAX_FEATURES", "ContactPoints", "Shapes", "detect_contacts", "near_pairs", "pair_key"]

MAX_FEATURES = 512  # a contact's key is its pair of shapes times this, plus the number of its feature
_TERNARY_STEPS = 48  # of the search along a segment: each keeps two thirds, so 4e-9 of the segment is left


@dataclass
class Shapes:
    """The shapes of all bodies, placed in the world.

    kind, body : (s,)
    half : (s, 3) m, half extents of the core
    radius : (s,) m
    center : (s, 3) m
    axes : (s, 3, 3), columns are the shape's axes
    """

    kind: np.ndarray
    body: np.ndarray
    half: np.ndarray
    radius: np.ndarray
    center: np.ndarray
    axes: np.ndarray


@dataclass
class ContactPoints:
    """k contacts.

    first, second : (k,) shapes
    point : (k, 3) m
    normal : (k, 3), from second to first
    gap : (k,) m, negative where they overlap
    key : (k,) int64, the same for the same contact in the next step
    """

    first: np.ndarray
    second: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    key: np.ndarray


def pair_key(one, other):
    """A number for a pair of bodies, whatever their order."""
    return np.minimum(one, other) * 2**31 + np.maximum(one, other)


def near_pairs(
    shapes: Shapes, margin: np.ndarray, movable: np.ndarray, joined: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of shapes of different bodies whose bounding boxes, widened by margin (s,), m, overlap; at least one is movable.

    joined : pairs of bodies that are left out, as of pair_key
    """
    extent = apply(np.abs(shapes.axes), shapes.half) + (shapes.radius + margin)[:, None]
    low, high = shapes.center - extent, shapes.center + extent
    order = np.argsort(low[:, 0], kind="stable")
    many = np.searchsorted(low[order, 0], high[order, 0], "right") - np.arange(len(order)) - 1
    i = np.repeat(np.arange(len(order)), many)
    j = i + 1 + np.arange(len(i)) - np.repeat(np.cumsum(many) - many, many)
    i, j = order[i], order[j]
    keep = (shapes.body[i] != shapes.body[j]) & (movable[i] | movable[j])
    for axis in (1, 2):
        keep &= (low[i, axis] <= high[j, axis]) & (low[j, axis] <= high[i, axis])
    i, j = i[keep], j[keep]
    if len(joined):
        apart = ~np.isin(pair_key(shapes.body[i], shapes.body[j]), joined)
        i, j = i[apart], j[apart]
    swap = (shapes.kind[i] > shapes.kind[j]) | ((shapes.kind[i] == shapes.kind[j]) & (i > j))
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    order = np.lexsort((j, i))
    return i[order], j[order]


_NONE = np.zeros(0, np.int64)


def detect_contacts(
    shapes: Shapes, margin: np.ndarray, movable: np.ndarray, joined: np.ndarray = _NONE
) -> ContactPoints:
    """Every contact whose gap is below the sum of the two shapes' margins (s,), m, in the order of the shapes."""
    i, j = near_pairs(shapes, margin, movable, joined)
    s, most = shapes, margin[i] + margin[j]
    found = []
    box_i, box_j = s.kind[i] == BOX, s.kind[j] == BOX  # in a pair the box comes last
    for group, with_box in ((np.flatnonzero(~box_j), False), (np.flatnonzero(box_j & ~box_i), True)):
        if len(group):
            found.append(_rounded_contacts(s, i[group], j[group], most[group], group, with_box))
    group = np.flatnonzero(box_j & box_i)
    if len(group):
        a, b = i[group], j[group]
        box_a, box_b = (s.center[a], s.axes[a], s.half[a]), (s.center[b], s.axes[b], s.half[b])
        k, *rest = contacts_between_boxes(*box_a, *box_b, most[group])
        found.append((group[k], *rest))
    if not found:
        none = np.zeros(0, np.int64)
        return ContactPoints(none, none, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), none)
    pair, point, normal, gap, feature = (np.concatenate(column) for column in zip(*found))
    order = np.lexsort((feature, pair))
    pair, point, normal, gap, feature = (column[order] for column in (pair, point, normal, gap, feature))
    first, second = i[pair].astype(np.int64), j[pair].astype(np.int64)
    return ContactPoints(first, second, point, normal, gap, (first * len(s.kind) + second) * MAX_FEATURES + feature)


def _rounded_contacts(s: Shapes, i, j, most, pair, with_box: bool):
    """Contacts of points and segments i with points and segments, or boxes, j: nearest points, and each end of a segment."""
    arm = s.half[i, 1][:, None] * s.axes[i][:, :, 1]
    c = s.center[i]
    if with_box:
        near = _nearest_to_box(s, j, c, arm)
        candidates = [(p, *_to_box(s, j, p)) for p in (c + near[:, None] * arm, c - arm, c + arm)]
    else:
        other = s.half[j, 1][:, None] * s.axes[j][:, :, 1]
        d = s.center[j]
        a, b = _between_segments(c, arm, d, other)
        points = [(c + a[:, None] * arm, d + b[:, None] * other)]
        points += [(p, d + _nearest_on_segment(p - d, other)[:, None] * other) for p in (c - arm, c + arm)]
        points += [(c + _nearest_on_segment(p - c, arm)[:, None] * arm, p) for p in (d - other, d + other)]
        candidates = [(p, *_direction(p - q)) for p, q in points]
    found = []
    with_ends = s.kind[i] != BALL if with_box else (s.kind[i] != BALL) | (s.kind[j] != BALL)
    for feature, (p, normal, distance) in enumerate(candidates):
        gap = distance - s.radius[i] - s.radius[j]
        keep = (gap < most) & (with_ends | (feature == 0))
        point = p - (s.radius[i] + 0.5 * gap)[:, None] * normal
        found.append((pair[keep], point[keep], normal[keep], gap[keep], np.full(int(keep.sum()), feature)))
    return tuple(np.concatenate(column) for column in zip(*found))


def _direction(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors and lengths of vectors d (m, 3); straight up where the length is 0."""
    length = norm(d)
    flat = length > 1e-12
    return np.where(flat[:, None], d / np.where(flat, length, 1.0)[:, None], np.array([0.0, 1.0, 0.0])), length


def _nearest_on_segment(d: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The parameter, -1 to 1, of the point of the segment from -arm to arm that is nearest to d."""
    square = dot(arm, arm)
    return np.clip(dot(d, arm) / np.where(square > 0, square, 1.0), -1, 1)


def _between_segments(c, u, d, v):
    """The parameters a, b, -1 to 1, at which c + a u and d + b v are nearest to each other."""
    w = c - d
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    det = uu * vv - uv * uv
    flat = det > 1e-12 * uu * vv
    a = np.where(flat, (uv * dot(w, v) - vv * dot(w, u)) / np.where(flat, det, 1.0), 0.0)
    b = _nearest_on_segment(w + np.clip(a, -1, 1)[:, None] * u, v)
    a = _nearest_on_segment(d + b[:, None] * v - c, u)
    return a, _nearest_on_segment(c + a[:, None] * u - d, v)


def _to_box(s: Shapes, j, p):
    """(normal out of the box, distance) of points p."""
    x = apply_transposed(s.axes[j], p - s.center[j])
    q = np.abs(x) - s.half[j]
    out = np.maximum(q, 0)
    length = norm(out)
    inside = length <= 1e-12
    face = np.zeros_like(x)
    face[np.arange(len(x)), q.argmax(1)] = 1.0
    n = np.where(inside[:, None], face, out / np.where(inside, 1.0, length)[:, None]) * np.where(x < 0, -1.0, 1.0)
    distance = np.where(inside, q.max(1), length)
    n = apply(s.axes[j], n)
    return n, distance


def _nearest_to_box(s: Shapes, j, c, arm):
    """The parameter, -1 to 1, of the point of c + t arm nearest to the box, or deepest inside; the distance is convex in t."""
    low, high = np.full(len(c), -1.0), np.full(len(c), 1.0)
    x, u = (apply_transposed(s.axes[j], w) for w in (c - s.center[j], arm))

    def distance(t):
        q = np.abs(x + t[:, None] * u) - s.half[j]
        out = np.maximum(q, 0)
        return norm(out) + np.minimum(q.max(1), 0)

    if not u.any():
        return 0.5 * (low + high)
    for _ in range(_TERNARY_STEPS):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        left = distance(a) <= distance(b)
        low, high = np.where(left, low, a), np.where(left, b, high)
    return 0.5 * (low + high)
