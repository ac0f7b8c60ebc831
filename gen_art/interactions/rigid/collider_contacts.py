"""Colliders as bodies meet them: solid spheres, blocks and capsules as shapes of their own, all others by their distance.

The distance of a collider, whatever it is, is asked for at points of each shape: the middle of a ball, the ends and the
middle of a capsule, the corners, edges and faces of a box.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.colliders.surface import count
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.tile import TileTerms
from gen_art.interactions.rigid.shapes import BALL, BOX, CAPSULE, Part

__all__ = ["Walls", "probes"]

_FLAT = ("plane", "box", "sphere")  # corners and ends are the first to meet them


def probes(part: Part, flat: bool) -> np.ndarray:
    """Points (n, 3) of the part's core, in the body's frame; `flat`: corners and ends alone."""
    if part.kind == BALL:
        x = np.zeros((1, 3))
    elif part.kind == CAPSULE:
        x = np.outer((-1.0, 1.0) if flat else (-1.0, -0.5, 0.0, 0.5, 1.0), part.half)
    else:
        steps = (-1.0, 1.0) if flat else (-1.0, 0.0, 1.0)
        x = np.array([(a, b, c) for a in steps for b in steps for c in steps if a or b or c]) * part.half
    return x @ part.axes.T + part.center


class Walls:
    """The colliders of a system. `solids`: those that are shapes, with their index; `others`: those asked by distance."""

    def __init__(self, colliders):
        self.colliders = list(colliders)
        self.solids: list[tuple[int, Part]] = []
        self.others: list[int] = []
        for k, one in enumerate(self.colliders):
            part = _solid(one)
            if part is None:
                self.others.append(k)
            else:
                self.solids.append((k, part))
        self.flat = all(self.colliders[k].name in _FLAT for k in self.others)
        self._composition = KernelTerms((), None, [self.colliders[k] for k in self.others])
        self._numbers = self._composition.numbers(np.float64)
        sides = [self.colliders[k].sides for k in self.others]
        self.owner = np.repeat(np.array(self.others, int), sides)  # of each surface
        self.names = [t.name for t in KernelTerms((), None, self.colliders).colliders]
        self.velocity = np.array([c.values["velocity"] for c in self.colliders], float).reshape(-1, 3)
        self.restitution = np.array([c.values["restitution"] for c in self.colliders], float)
        self.friction = np.array([tuple(c.values["friction"]) for c in self.colliders], float).reshape(-1, 2)

    def distances(self, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """(n, surfaces) m and (n, surfaces, 3): distances of points from each surface, and its normals there."""
        n, many = len(points), len(self.owner)
        D, N = np.zeros((n, many)), np.zeros((n, 3 * many))
        if n and many:
            _kernel(self._composition)(np.ascontiguousarray(points), time, self._numbers, D, N)
        return D, N.reshape(n, many, 3)


def _solid(one) -> Part | None:
    """The collider as a fixed shape, if it is one that stands in the way."""
    v, eye = one.values, np.eye(3)
    if one.name == "sphere" and not v["inside"]:
        return Part(BALL, np.zeros(3), v["radius"], np.array(v["center"], float), eye)
    if one.name == "block":
        low, high = np.array(v["min"], float), np.array(v["max"], float)
        return Part(BOX, (high - low) / 2, 0.0, (high + low) / 2, eye)
    if one.name == "capsule":
        a, b = np.array(v["a"], float), np.array(v["b"], float)
        length = float(np.linalg.norm(b - a))
        along = (b - a) / length if length > 0 else np.array([0.0, 1.0, 0.0])
        side = np.cross(along, np.eye(3)[np.abs(along).argmin()])
        side /= np.linalg.norm(side)
        axes = np.stack([side, along, np.cross(side, along)], 1)
        return Part(CAPSULE, np.array([0, length / 2, 0]), v["radius"], (a + b) / 2, axes)
    return None


@cache
def _kernel(composition: KernelTerms):
    terms = TileTerms(composition, (), 0, real=ti.f64)
    matrix = ti.types.ndarray(ti.f64, 2)

    @ti.kernel
    def measure(X: matrix, time: ti.f64, Q: ti.types.ndarray(ti.f64, 1), D: matrix, N: matrix):
        n = X.shape[0]
        ti.loop_config(block_dim=1)
        for block in range((n + 255) // 256):
            for i in range(block * 256, ti.min((block + 1) * 256, n)):
                for s in range(count(terms.walls)):
                    on = terms.surface(Q, s, ti.Vector([X[i, 0], X[i, 1], X[i, 2]]), time, 1)
                    D[i, s] = on[3]
                    for c in ti.static(range(3)):
                        N[i, 3 * s + c] = on[c]

    return runtime.kernel(measure, "f64")
