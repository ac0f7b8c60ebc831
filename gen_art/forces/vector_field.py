"""Vectors sampled on a grid."""

import numpy as np

from gen_art.backend.runtime import real, ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.forces.grid_file import read_grid
from gen_art.registry import param

__all__ = ["Sampled", "VectorField"]


class Sampled(Force):
    """What forces of a grid have in common: the data, where they lie, and the trilinear blend."""

    steady = True
    field: object = param(kind="file", doc="a .npy file (nx, ny, nz, 3), a picture, or an array")
    bounds: object = param(
        ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), unit="m", doc="the corners where the first and last vectors are"
    )
    strength: float = param(1.0, doc="factor of the grid's vectors")
    outside: str = param("zero", choices=("zero", "clamp"), doc="nothing, or the vectors of the edge")
    tabled = True

    def prepare(self):
        grid = read_grid(self.values["field"])
        try:
            low, high = (np.array([float(c) for c in corner]) for corner in self.values["bounds"])
        except (TypeError, ValueError):
            low = high = np.zeros(0)
        if low.shape != (3,) or high.shape != (3,) or not np.isfinite([low, high]).all() or not (low < high).all():
            raise UsageError(
                f"bounds must be two corners [[x, y, z], [x, y, z]], the lower one first, not {self.values['bounds']!r}"
            )
        self.values["bounds"] = (tuple(low.tolist()), tuple(high.tolist()))
        size = np.array(grid.shape[:3])
        self._table = np.concatenate([low, (size - 1) / (high - low), size, grid.reshape(-1)])

    def table(self) -> np.ndarray:
        return self._table

    @ti.func
    def sampled(self, p, q):
        """strength times the trilinear blend of the eight vectors about the particle."""
        base, part = ti.Vector([0, 0, 0]), ti.Vector([0.0, 0.0, 0.0])
        size = ti.Vector([0, 0, 0])
        weight = q.strength
        for c in ti.static(range(3)):
            last = q.table(6 + c) - 1.0
            g = (p.position[c] - q.table(c)) * q.table(3 + c)
            size[c] = ti.cast(last, ti.i32) + 1
            inner = ti.min(ti.max(g, 0.0), last)
            base[c] = ti.max(ti.min(ti.cast(inner, ti.i32), size[c] - 2), 0)
            part[c] = inner - ti.cast(base[c], real())
            if ti.static(self.values["outside"] == "zero"):
                weight = ti.select(g < 0.0, 0.0, ti.select(g > last, 0.0, weight))
        result = ti.Vector([0.0, 0.0, 0.0])
        for corner in ti.static(range(8)):
            w, at = weight, 0
            for c in ti.static(range(3)):
                upper = ti.static((corner >> c) & 1)
                w *= part[c] if ti.static(upper) else 1.0 - part[c]
                at = at * size[c] + ti.min(base[c] + upper, size[c] - 1)
            for c in ti.static(range(3)):
                result[c] += w * q.table(9 + 3 * at + c)
        return result


@force("vector_field")
class VectorField(Sampled):
    """Vectors from a file: a velocity (m/s) in a medium, as a force an acceleration (m/s^2).

    a = strength V(x), V the trilinear blend of the grid's vectors, the first at one corner of `bounds`, the last at the other

    field : a .npy file or array of the shape (nx, ny, nz, 3), where one of the sizes may be 1 (the same all along that axis), or
    a picture: red is x, green is y, 0 to 255 for -1 to 1 with 128 for 0, its bottom row the lowest y     bounds : m
    strength : factor     outside : zero, or the vectors of the edge.  Does work (no potential): even a field without curl is
    no exact gradient between its places. Source: Press and others, Numerical Recipes, section 3.6.
    """

    @ti.func
    def acceleration(self, p, t, q):
        return self.sampled(p, q)
