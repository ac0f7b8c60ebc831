"""Where bodies touch: pairs whose boxes along the axes overlap, then the contacts of each pair of shapes.

Every shape is a core rounded by a radius, so that all but two boxes come down to the nearest points of two cores.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.interactions.rigid.box_contacts import between_boxes
from gen_art.interactions.rigid.shapes import BALL, BOX

__all__ = ["ContactPoints", "Shapes", "near_pairs", "detect_contacts"]

_THIRDS = 48  # steps of the search along a segment: each keeps two thirds, so 4e-9 of it is left


@dataclass
class Shapes:
    """The shapes of all bodies in the world: kind (s,), body (s,), half (s, 3), radius (s,), center (s, 3), axes (s, 3, 3)."""

    kind: np.ndarray
    body: np.ndarray
    half: np.ndarray
    radius: np.ndarray
    center: np.ndarray
    axes: np.ndarray


@dataclass
class ContactPoints:
    """k contacts: shapes first and second (k,), point (k, 3), normal (k, 3) from second to first, gap (k,), key (k,) int64."""

    first: np.ndarray
    second: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    key: np.ndarray


def near_pairs(shapes: Shapes, reach: np.ndarray, movable: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of shapes of different bodies, one of them movable (s,), whose boxes, widened by reach (s,), overlap."""
    extent = np.einsum("sij,sj->si", np.abs(shapes.axes), shapes.half) + (shapes.radius + reach)[:, None]
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
    swap = (shapes.kind[i] > shapes.kind[j]) | ((shapes.kind[i] == shapes.kind[j]) & (i > j))
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    order = np.lexsort((j, i))
    return i[order], j[order]


def detect_contacts(shapes: Shapes, reach: np.ndarray, movable: np.ndarray) -> ContactPoints:
    """Every contact whose gap is below the sum of the two shapes' reach, m; in the order of the shapes."""
    i, j = near_pairs(shapes, reach, movable)
    s, most = shapes, reach[i] + reach[j]
    found = []
    both = s.kind[j] == BOX
    for group, boxes in ((np.flatnonzero(~both), 0), (np.flatnonzero(both & (s.kind[i] != BOX)), 1)):
        if len(group):
            found.append(_rounded(s, i[group], j[group], most[group], group, boxes == 1))
    group = np.flatnonzero(both & (s.kind[i] == BOX))
    if len(group):
        a, b = i[group], j[group]
        k, *rest = between_boxes(
            s.center[a], s.axes[a], s.half[a], s.center[b], s.axes[b], s.half[b], most[group]
        )  # fmt: skip
        found.append((group[k], *rest))
    if not found:
        none = np.zeros(0, np.int64)
        return ContactPoints(none, none, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), none)
    pair, point, normal, gap, feature = (np.concatenate(part) for part in zip(*found))
    order = np.lexsort((feature, pair))
    pair, point, normal, gap, feature = (part[order] for part in (pair, point, normal, gap, feature))
    first, second = i[pair].astype(np.int64), j[pair].astype(np.int64)
    return ContactPoints(first, second, point, normal, gap, (first * len(s.kind) + second) * 512 + feature)


def _rounded(s: Shapes, i, j, most, pair, box: bool):
    """Contacts of points and segments i with those, or with boxes, j: the nearest points, and each end of a segment."""
    arm = s.half[i, 1][:, None] * s.axes[i][:, :, 1]
    c = s.center[i]
    if box:
        near = _nearest_to_box(s, j, c, arm)
        tries = [c + near[:, None] * arm, c - arm, c + arm]
        sides = [(p, _on_box(s, j, p)) for p in tries]
    else:
        other = s.half[j, 1][:, None] * s.axes[j][:, :, 1]
        d = s.center[j]
        a, b = _between_segments(c, arm, d, other)
        sides = [(c + a[:, None] * arm, d + b[:, None] * other)]
        sides += [(p, d + _along(p - d, other)[:, None] * other) for p in (c - arm, c + arm)]
        sides += [(c + _along(p - c, arm)[:, None] * arm, p) for p in (d - other, d + other)]
        sides = [(p, (q, *_apart(p - q))) for p, q in sides]
    found = []
    longer = (s.kind[i] != BALL) | (s.kind[j] != BALL) if not box else s.kind[i] != BALL
    for feature, (p, (_, normal, distance)) in enumerate(sides):
        gap = distance - s.radius[i] - s.radius[j]
        take = (gap < most) & (longer | (feature == 0))
        point = p - (s.radius[i] + 0.5 * gap)[:, None] * normal
        found.append((pair[take], point[take], normal[take], gap[take], np.full(int(take.sum()), feature)))
    return tuple(np.concatenate(part) for part in zip(*found))


def _apart(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Direction and length; straight up where there is none."""
    length = np.sqrt((d * d).sum(1))
    flat = length > 1e-12
    return np.where(flat[:, None], d / np.where(flat, length, 1.0)[:, None], np.array([0.0, 1.0, 0.0])), length


def _along(d: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Where on the segment -arm to arm, -1 to 1, is nearest to d."""
    square = (arm * arm).sum(1)
    return np.clip((d * arm).sum(1) / np.where(square > 0, square, 1.0), -1, 1)


def _between_segments(c, u, d, v):
    """The shares a, b, -1 to 1, at which c + a u and d + b v are nearest."""
    w = c - d
    uu, vv, uv = (u * u).sum(1), (v * v).sum(1), (u * v).sum(1)
    det = uu * vv - uv * uv
    flat = det > 1e-12 * uu * vv
    a = np.where(flat, (uv * (w * v).sum(1) - vv * (w * u).sum(1)) / np.where(flat, det, 1.0), 0.0)
    b = _along(w + np.clip(a, -1, 1)[:, None] * u, v)
    a = _along(d + b[:, None] * v - c, u)
    return a, _along(c + a[:, None] * u - d, v)


def _on_box(s: Shapes, j, p):
    """(nearest point, normal out of the box, distance) of points p."""
    x = np.einsum("mji,mj->mi", s.axes[j], p - s.center[j])
    q = np.abs(x) - s.half[j]
    out = np.maximum(q, 0)
    length = np.sqrt((out * out).sum(1))
    inside = length <= 1e-12
    face = np.zeros_like(x)
    face[np.arange(len(x)), q.argmax(1)] = 1.0
    n = np.where(inside[:, None], face, out / np.where(inside, 1.0, length)[:, None]) * np.where(x < 0, -1.0, 1.0)
    distance = np.where(inside, q.max(1), length)
    n = np.einsum("mij,mj->mi", s.axes[j], n)
    return p - distance[:, None] * n, n, distance


def _nearest_to_box(s: Shapes, j, c, arm):
    """Where on the segment c - arm to c + arm, -1 to 1, is nearest to the box, or deepest inside: its distance is convex."""
    low, high = np.full(len(c), -1.0), np.full(len(c), 1.0)
    x, u = (np.einsum("mji,mj->mi", s.axes[j], w) for w in (c - s.center[j], arm))

    def distance(t):
        q = np.abs(x + t[:, None] * u) - s.half[j]
        out = np.maximum(q, 0)
        return np.sqrt((out * out).sum(1)) + np.minimum(q.max(1), 0)

    if not u.any():
        return 0.5 * (low + high)
    for _ in range(_THIRDS):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        left = distance(a) <= distance(b)
        low, high = np.where(left, low, a), np.where(left, b, high)
    return 0.5 * (low + high)
