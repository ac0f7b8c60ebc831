"""Vectors sampled on a grid."""

import numpy as np

from gen_art.arguments import shown
from gen_art.backend.runtime import real, ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.forces.grid_file import read_grid
from gen_art.registry import param

__all__ = ["Sampled", "VectorField"]

LOW, SCALE, SIZE, VECTORS = 0, 3, 6, 9  # parts of the table: lower corner, vectors per metre, sizes, the vectors


class Sampled(Force):
    """The base of forces sampled on a grid: the data, their bounds, and trilinear interpolation."""

    steady = True
    field: object = param(kind="file", doc="a .npy file (nx, ny, nz, 3), a picture, or an array")
    bounds: object = param(
        ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), unit="m", doc="the corners at which the first and the last vector stand"
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
                f"bounds must be two corners [[x, y, z], [x, y, z]], the lower one first, not {shown(self.values['bounds'])}"
            )
        self.values["bounds"] = (tuple(low.tolist()), tuple(high.tolist()))
        size = np.array(grid.shape[:3])
        self._table = np.concatenate([low, (size - 1) / (high - low), size, grid.reshape(-1)])

    def table(self) -> np.ndarray:
        return self._table

    @ti.func
    def sampled(self, p, q):
        """strength times the trilinear interpolation of the eight vectors around the particle."""
        base, fraction = ti.Vector([0, 0, 0]), ti.Vector([0.0, 0.0, 0.0])
        size = ti.Vector([0, 0, 0])
        weight = q.strength
        for c in ti.static(range(3)):
            last = q.table(SIZE + c) - 1.0
            grid_position = (p.position[c] - q.table(LOW + c)) * q.table(SCALE + c)
            size[c] = ti.cast(last, ti.i32) + 1
            inside = ti.min(ti.max(grid_position, 0.0), last)
            base[c] = ti.max(ti.min(ti.cast(inside, ti.i32), size[c] - 2), 0)
            fraction[c] = inside - ti.cast(base[c], real())
            if ti.static(self.values["outside"] == "zero"):
                weight = ti.select(grid_position < 0.0, 0.0, ti.select(grid_position > last, 0.0, weight))
        result = ti.Vector([0.0, 0.0, 0.0])
        for corner in ti.static(range(8)):
            w, index = weight, 0
            for c in ti.static(range(3)):
                upper = ti.static((corner >> c) & 1)
                w *= fraction[c] if ti.static(upper) else 1.0 - fraction[c]
                index = index * size[c] + ti.min(base[c] + upper, size[c] - 1)
            for c in ti.static(range(3)):
                result[c] += w * q.table(VECTORS + 3 * index + c)
        return result


@force("vector_field")
class VectorField(Sampled):
    """Vectors from a file: as a term of a medium a velocity (m/s), as a force an acceleration (m/s^2).

    a = strength V(x), V the trilinear interpolation of the grid's vectors

    field : a .npy file or array of the shape (nx, ny, nz, 3), in which a size may be 1 (the same all along that axis), or a
        picture: red is x, green is y, 0 to 255 for -1 to 1 with 128 for 0; its bottom row has the lowest y
    bounds : m, the corners at which the first and the last vector stand
    strength : factor
    outside : zero, or the vectors of the edge
    Does work (no potential): even a field without curl, interpolated, is not exactly a gradient.
    Source: Press and others, Numerical Recipes, section 3.6.
    """

    @ti.func
    def acceleration(self, p, t, q):
        return self.sampled(p, q)
