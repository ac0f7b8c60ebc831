"""Many small lights in an octree, so that a place is lit by a few nodes instead of a million sprites.

A light of power P (its intensity I: radiance times area) and cross section A = pi a^2 gives a place with the unit normal n,
at the offset r from the place to the light, the irradiance

    E = P max(n.r, 0) / |r| * min(1 / (|r|^2 + s^2), w),        w = 1 / (a^2 + s^2)

which is that of a ball of even radiance, and inside the ball that at its surface; s is the softening. A node stands for its
lights by their sum, their first moment in each colour, their second moments, and w's mean and standard deviation.

Nodes lie in preorder: a node's descendants follow it up to its `next` node. A few nodes at the top, the `lamps`, cut the tree
into parts whose shadows are found one by one. A part that looks small from all that may shadow it is not cut further.
"""

from dataclasses import dataclass

import numpy as np

__all__ = ["LAMPS", "LEAF", "LIGHT_FLOATS", "NODE_FLOATS", "LightTree", "lamp_radii"]

LEAF = 8  # most lights of a leaf, where there are more lights than LAMPS
LAMPS = 8  # most parts of the tree with shadows of their own
_SMALL = 0.25  # tangent of half the angle from which on a lamp is cut: its shadows then differ from place to place
# shifts and masks that move the bits of a number three places apart
_SPREAD = (
    (32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249),
)  # fmt: skip
_BITS = 20  # levels below the root; lights in one cell of the last are one light
# a node is used from a distance of its radius divided by this; the lights of a leaf cost no more than the leaf itself
_OPENING, _OPENING_LEAF = 0.4, 0.14
# a node's row: the middle of its power, two values of w, the distance from which it is used, the radius around the middle, power
# of three colours, their first moments (3 x 3), second moments of the power relative to it (xx, yy, zz, xy, xz, yz), and the
# corners of the box around its lights (6)
MIDDLE, W, USED_FROM, RADIUS, POWER, FIRST, SECOND, LOW, HIGH = 0, 3, 5, 6, 7, 10, 19, 25, 28
NODE_FLOATS = 31
LIGHT_POWER, LIGHT_W, LIGHT_FLOATS = 3, 6, 7  # columns of a light's row, after the position


@dataclass(frozen=True)
class LightTree:
    """The tree, in the coordinates of its lights less `origin`.

    nodes : (n, NODE_FLOATS) float32
    links : (n, 3) int32, first light, number of lights or 0, and the next node
    lights : (m, LIGHT_FLOATS) float32
    lamps : (k, 2) int32, first node of each part and the node after its last
    """

    nodes: np.ndarray
    links: np.ndarray
    lights: np.ndarray
    lamps: np.ndarray

    @classmethod
    def of(
        cls, positions, power, cross_sections, softness: float = 0.0, origin=(0.0, 0.0, 0.0), casters=None
    ) -> "LightTree | None":
        """The tree of lights; None if none of them has any light.

        positions : (n, 3)
        power : (n, 3) radiance times area
        cross_sections : (n,) areas
        softness : s
        origin : what is taken off the positions
        casters : (centres less origin, radii) of balls around all that may cast shadows; None where they are not known
        """
        power = np.asarray(power, np.float64)
        lit = np.flatnonzero(power.sum(axis=1) > 0.0)
        if not len(lit):
            return None
        power, x = power[lit], np.asarray(positions, np.float64)[lit] - np.asarray(origin, np.float64)
        w = 1.0 / np.maximum(np.asarray(cross_sections, np.float64)[lit] / np.pi + softness * softness, 1e-30)
        x, power, w, keys = _merged(x, power, w, _keys(x))
        levels = _levels(keys)
        return cls(*_rows(levels, x, power, w, casters))


def _keys(x: np.ndarray) -> np.ndarray:
    """(n,) int64: the bits of the three coordinates of each light's cell of the last level, interleaved."""
    low = x.min(axis=0)
    extent = max(float((x.max(axis=0) - low).max()), 1e-6 * (1.0 + float(np.abs(x).max())))
    cell = np.minimum((x - low) * ((2.0**_BITS - 0.5) / extent), 2.0**_BITS - 1).astype(np.int64)
    for shift, mask in _SPREAD:
        cell = (cell | (cell << shift)) & mask
    return cell[:, 0] | (cell[:, 1] << 1) | (cell[:, 2] << 2)


def _merged(x, power, w, keys):
    """Lights in the order of their keys; those of one key are one light."""
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    first = np.concatenate([[True], keys[1:] != keys[:-1]])
    if first.all():
        return x[order], power[order], w[order], keys
    which, weight = np.cumsum(first) - 1, power[order].sum(axis=1)
    total = np.bincount(which, weight)
    means = [np.bincount(which, weight * values) / total for values in (*x[order].T, w[order])]
    sums = [np.bincount(which, power[order, c]) for c in range(3)]
    return np.stack(means[:3], axis=1), np.stack(sums, axis=1), means[3], keys[first]


def _most_in_leaf(lights: int) -> int:
    """The most lights of a leaf: a few lamps each have a leaf of their own, so that each casts shadows of its own."""
    return 1 if lights <= LAMPS else LEAF


def _levels(keys: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """For each level from the root on: first light and end of each node, and its parent in the level above."""
    levels = [(np.zeros(1, np.int64), np.array([len(keys)]), np.full(1, -1))]
    most = _most_in_leaf(len(keys))
    for level in range(1, _BITS + 1):
        start, end, _ = levels[-1]
        if not (end - start > most).any():
            break
        cell = keys >> (3 * (_BITS - level))
        first = np.flatnonzero(np.concatenate([[True], cell[1:] != cell[:-1]]))
        last = np.append(first[1:], len(keys))
        parent = np.searchsorted(start, first, side="right") - 1
        inside = (parent >= 0) & (first < end[parent]) & ((end - start)[parent] > most)
        levels.append((first[inside], last[inside], parent[inside]))
    return levels


def _rows(levels, x, power, w, casters) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, links, lights and lamps of a LightTree."""
    weight = power.sum(axis=1)
    middle = (weight[:, None] * x).sum(axis=0) / weight.sum()
    y = x - middle
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    of_lights = np.column_stack(
        [power, *(power[:, k] * y[:, c] for k in range(3) for c in range(3)), *(weight * y[:, a] * y[:, b] for a, b in pairs),
         weight * w, weight * w * w]
    )  # fmt: skip
    most = _most_in_leaf(len(x))
    sums: list[np.ndarray] = []
    lows: list[np.ndarray] = []
    highs: list[np.ndarray] = []
    sizes: list[np.ndarray] = []
    z = np.column_stack([y, w])
    for level in range(len(levels) - 1, -1, -1):
        start, end, _ = levels[level]
        total, low, high = (
            np.zeros((len(start), of_lights.shape[1])),
            np.zeros((len(start), 4)),
            np.zeros((len(start), 3)),
        )
        size = np.ones(len(start), np.int64)
        leaf = np.flatnonzero(end - start <= most) if level < len(levels) - 1 else np.arange(len(start))
        for k in range(int((end - start)[leaf].max(initial=0))):
            here = leaf[(end - start)[leaf] > k]
            one = start[here] + k
            total[here] += of_lights[one]
            low[here] = z[one] if k == 0 else np.minimum(low[here], z[one])
            high[here] = y[one] if k == 0 else np.maximum(high[here], y[one])
        if sums:
            parent = levels[level + 1][2]
            of_parent = np.flatnonzero(np.concatenate([[True], parent[1:] != parent[:-1]]))
            owner = parent[of_parent]
            for c in range(of_lights.shape[1]):
                total[:, c] += np.bincount(parent, sums[0][:, c], len(start))
            low[owner], high[owner] = np.minimum.reduceat(lows[0], of_parent), np.maximum.reduceat(highs[0], of_parent)
            size += np.bincount(parent, sizes[0], len(start)).astype(np.int64)
        sums, lows, highs, sizes = [total, *sums], [low, *lows], [high, *highs], [size, *sizes]
    places = [np.zeros(1, np.int64)]
    for level in range(1, len(levels)):
        parent = levels[level][2]
        before = np.cumsum(sizes[level]) - sizes[level]
        of_parent = np.flatnonzero(np.concatenate([[True], parent[1:] != parent[:-1]]))
        counts = np.diff(np.append(of_parent, len(parent)))
        places.append(places[-1][parent] + 1 + before - np.repeat(before[of_parent], counts))
    order = np.argsort(np.concatenate(places))
    total, low, high = (np.concatenate(parts)[order] for parts in (sums, lows, highs))
    size = np.concatenate(sizes)[order]
    links = np.zeros((len(order), 3), np.int64)
    links[:, 0] = np.concatenate([start for start, _, _ in levels])[order]
    links[:, 1] = np.where(size == 1, np.concatenate([end for _, end, _ in levels])[order] - links[:, 0], 0)
    links[:, 2] = np.arange(len(order)) + size
    nodes = _node_rows(total, low[:, :3], high, low[:, 3], size == 1, middle)
    lights = np.column_stack([x, power, w])
    lamps = _lamps(nodes, links, casters)
    return nodes.astype(np.float32), links.astype(np.int32), lights.astype(np.float32), lamps


def _node_rows(total, low, high, widest, leaf, origin) -> np.ndarray:
    """(n, NODE_FLOATS) from sums about `origin`."""
    power, first, second = total[:, :3], total[:, 3:12].reshape(-1, 3, 3), total[:, 12:18]
    weight = power.sum(axis=1)
    middle = first.sum(axis=1) / weight[:, None]
    rows = np.zeros((len(total), NODE_FLOATS))
    rows[:, MIDDLE : MIDDLE + 3], rows[:, POWER : POWER + 3] = middle + origin, power
    rows[:, FIRST : FIRST + 9] = (first - power[:, :, None] * middle[:, None, :]).reshape(-1, 9)
    for c, (a, b) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]):
        rows[:, SECOND + c] = second[:, c] / weight - middle[:, a] * middle[:, b]
    rows[:, LOW : LOW + 3], rows[:, HIGH : HIGH + 3] = low - middle, high - middle
    mean = total[:, 18] / weight
    spread = np.sqrt(np.maximum(total[:, 19] / weight - mean * mean, 0.0))
    rows[:, W] = np.maximum(mean - spread, widest)  # no less than that of the widest light: from afar all count fully
    rows[:, W + 1] = 2.0 * mean - rows[:, W]
    rows[:, RADIUS] = np.sqrt((np.maximum(np.abs(low - middle), np.abs(high - middle)) ** 2).sum(axis=1))
    rows[:, USED_FROM] = rows[:, RADIUS] / np.where(leaf, _OPENING_LEAF, _OPENING)
    return rows


def lamp_radii(nodes: np.ndarray) -> np.ndarray:
    """(n,) of the discs of even radiance that are as wide as nodes' lights: b^2 / 4 is a disc's variance along each axis."""
    variance = nodes[:, SECOND : SECOND + 3].sum(axis=1) / 3.0
    return np.sqrt(4.0 * np.maximum(variance, 0.0) + 1.0 / np.maximum(nodes[:, W + 1], 1e-30))


def _distances(nodes, casters) -> np.ndarray:
    """(n,) from the boxes of nodes' lights to the nearest of some balls; 0 where they touch."""
    if casters is None:
        return np.zeros(len(nodes))
    nearest = np.full(len(nodes), np.inf)
    for k, node in enumerate(nodes):
        offset = casters[0] - node[MIDDLE : MIDDLE + 3]
        outside = offset - np.clip(offset, node[LOW : LOW + 3], node[HIGH : HIGH + 3])
        nearest[k] = max((np.sqrt((outside**2).sum(axis=1)) - casters[1]).min(initial=np.inf), 0.0)
    return nearest


def _lamps(nodes, links, casters) -> np.ndarray:
    """(k, 2) int32: the tree cut into at most LAMPS parts, the widest and brightest cut first."""
    parts = [0]
    while True:
        looks_wide = lamp_radii(nodes[parts]) > _SMALL * _distances(nodes[parts], casters)
        worth = (
            nodes[parts, POWER : POWER + 3].sum(axis=1)
            * nodes[parts, RADIUS] ** 2
            * (links[parts, 1] == 0)
            * looks_wide
        )
        widest = int(np.argmax(worth))
        children, child = [], parts[widest] + 1
        while child < links[parts[widest], 2]:
            children.append(child)
            child = int(links[child, 2])
        if worth[widest] <= 0.0 or len(parts) - 1 + len(children) > LAMPS:
            return np.array([(part, links[part, 2]) for part in parts], np.int32)
        parts[widest : widest + 1] = children
