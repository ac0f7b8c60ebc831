"""Colliders as rigid bodies touch them: solid spheres, blocks and capsules as shapes, all others by their signed distance.

The distance is evaluated at probe points of each body: the centre of a ball, points along the axis of a capsule, and the
corners, the middles of the edges and the centres of the faces of a box.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.colliders.surface import count
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.particle_tile import TileTerms
from gen_art.interactions.rigid.shapes import BALL, BOX, CAPSULE, Part
from gen_art.interactions.rigid.small_matrices import apply, cross, norm

__all__ = ["RigidColliders", "probe_points"]

_FLAT = ("plane", "box", "sphere")  # plane or concave: corners and ends touch first


def probe_points(part: Part, flat: bool) -> np.ndarray:
    """Points (n, 3) of the part's core, in the body's frame; `flat`: only corners and ends."""
    if part.kind == BALL:
        x = np.zeros((1, 3))
    elif part.kind == CAPSULE:
        x = np.outer((-1.0, 1.0) if flat else (-1.0, -0.5, 0.0, 0.5, 1.0), part.half)
    else:
        steps = (-1.0, 1.0) if flat else (-1.0, 0.0, 1.0)
        x = np.array([(a, b, c) for a in steps for b in steps for c in steps if a or b or c]) * part.half
    return apply(part.axes, x) + part.center


class RigidColliders:
    """The colliders of a system of rigid bodies.

    members: all of them
    solids: (index, shape) of those that are shapes
    flat: whether probes at corners and ends are enough for all others
    owner: the index of the collider that each surface belongs to, without those of the solids
    names, velocity, restitution, friction: of each collider
    """

    def __init__(self, colliders):
        self.members = list(colliders)
        shapes = [_solid(collider) for collider in self.members]
        self.solids: list[tuple[int, Part]] = [(k, part) for k, part in enumerate(shapes) if part is not None]
        by_distance = [k for k, part in enumerate(shapes) if part is None]
        self.flat = all(self.members[k].name in _FLAT for k in by_distance)
        self._composition = KernelTerms((), None, [self.members[k] for k in by_distance])
        self._numbers = self._composition.numbers(np.float64)
        self.owner = np.repeat(np.array(by_distance, int), [self.members[k].sides for k in by_distance])
        self.names = [t.name for t in KernelTerms((), None, self.members).colliders]
        self.velocity = np.array([c.values["velocity"] for c in self.members], float).reshape(-1, 3)
        self.restitution = np.array([c.values["restitution"] for c in self.members], float)
        self.friction = np.array([tuple(c.values["friction"]) for c in self.members], float).reshape(-1, 2)

    def distances(self, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Distances, m, of points (n, 3) from each surface, (n, surfaces), and its normals there, (n, surfaces, 3)."""
        n, surfaces = len(points), len(self.owner)
        D, N = np.zeros((n, surfaces)), np.zeros((n, 3 * surfaces))
        if n and surfaces:
            _distance_kernel(self._composition)(np.ascontiguousarray(points), time, self._numbers, D, N)
        return D, N.reshape(n, surfaces, 3)


def _solid(collider) -> Part | None:
    """The collider as a fixed shape; None unless it is a solid sphere, block or capsule."""
    v, eye = collider.values, np.eye(3)
    if collider.name == "sphere" and not v["inside"]:
        return Part(BALL, np.zeros(3), v["radius"], np.array(v["center"], float), eye)
    if collider.name == "block":
        low, high = np.array(v["min"], float), np.array(v["max"], float)
        return Part(BOX, (high - low) / 2, 0.0, (high + low) / 2, eye)
    if collider.name == "capsule":
        a, b = np.array(v["a"], float), np.array(v["b"], float)
        length = float(norm(b - a))
        along = (b - a) / length if length > 0 else np.array([0.0, 1.0, 0.0])
        side = cross(along, np.eye(3)[np.abs(along).argmin()])
        side /= norm(side)
        axes = np.stack([side, along, cross(side, along)], 1)
        return Part(CAPSULE, np.array([0, length / 2, 0]), v["radius"], (a + b) / 2, axes)
    return None


@cache
def _distance_kernel(composition: KernelTerms):
    terms = TileTerms(composition, (), 0, ti.f64)
    matrix = ti.types.ndarray(ti.f64, 2)

    @ti.kernel
    def measure(X: matrix, time: ti.f64, Q: ti.types.ndarray(ti.f64, 1), D: matrix, N: matrix):
        n = X.shape[0]
        ti.loop_config(block_dim=1)
        for block in range((n + 255) // 256):
            for i in range(block * 256, ti.min((block + 1) * 256, n)):
                for s in range(count(terms.kinds)):
                    hit = terms.surface(Q, s, ti.Vector([X[i, 0], X[i, 1], X[i, 2]]), time, 1)
                    D[i, s] = hit[3]
                    for c in ti.static(range(3)):
                        N[i, 3 * s + c] = hit[c]

    return runtime.kernel(measure, "f64")
