"""Any shape, by its signed distance: a function, or a grid of distances."""

from pathlib import Path

import numpy as np

from gen_art import arguments
from gen_art.backend.runtime import real, ti
from gen_art.colliders.base import Collider, collider
from gen_art.errors import UsageError
from gen_art.forces.grid_file import read_array
from gen_art.registry import param


@collider("sdf")
class SDF(Collider):
    """A shape given by its signed distance: a @ti.func of the position x, or a grid of distances between min and max.

    distance = function(x), or the grid, trilinear between its points;  normal = its central differences over 2 step

    function : returns m, positive outside, never steeper than 1; or an array (nx, ny, nz), at least 2 points per axis, or the
        name of a .npy file that contains it
    min, max : m, the corners of the grid; beyond them the values of its border apply
    step : m, above 0; smaller than the details of the shape
    """

    function: object = param(
        kind="file", doc="a .npy file (nx, ny, nz) of distances in m, an array, or a @ti.func of x"
    )
    min: tuple = param((-1.0, -1.0, -1.0), unit="m", doc="where the grid begins")
    max: tuple = param((1.0, 1.0, 1.0), unit="m", doc="where the grid ends")
    step: float = param(1e-3, unit="m", min=1e-30, doc="of the differences that give the normal")

    def prepare(self):
        super().prepare()
        self.grid = None
        function = self.values["function"]
        if not callable(function):
            grid = read_array(function) if isinstance(function, (str, Path)) else function
            grid = arguments.array("function", grid, "a @ti.func, a .npy file or an array of distances")
            if grid.ndim != 3 or min(grid.shape) < 2:
                raise UsageError(
                    f"a grid of distances must have the shape (nx, ny, nz), each at least 2, not {grid.shape}"
                )
            for axis, low, high in zip("xyz", self.values["min"], self.values["max"]):
                if low >= high:
                    raise UsageError(f"min must be below max on every axis: {axis} runs from {low:g} to {high:g}")
            self.grid = grid

    @property
    def steepness(self) -> float:
        """The largest slope of the grid at the middle of a cell, m/m; 0 for a function."""
        if self.grid is None:
            return 0.0
        squares = np.zeros([n - 1 for n in self.grid.shape])
        for axis, (low, high) in enumerate(zip(self.values["min"], self.values["max"])):
            rise = np.diff(self.grid, axis=axis) * (self.grid.shape[axis] - 1) / (high - low)
            for other in {0, 1, 2} - {axis}:
                near, far = [slice(None)] * 3, [slice(None)] * 3
                near[other], far[other] = slice(None, -1), slice(1, None)
                rise = 0.5 * (rise[tuple(near)] + rise[tuple(far)])
            squares += rise**2
        return float(np.sqrt(squares.max()))

    @property
    def tabled(self) -> bool:  # type: ignore[override]  # only an instance knows whether it has a grid
        return self.grid is not None

    def table(self) -> np.ndarray:
        assert self.grid is not None
        return np.concatenate([np.array(self.grid.shape, float), self.grid.ravel()])

    @property
    def fixed(self) -> tuple:
        return (*super().fixed, None if self.tabled else self.values["function"])

    @ti.func
    def interpolated(self, x, q):
        """The grid's distance at x, trilinear."""
        cell = ti.Vector([0, 0, 0])
        fraction = x * 0.0
        size = ti.Vector([ti.cast(q.table(0), ti.i32), ti.cast(q.table(1), ti.i32), ti.cast(q.table(2), ti.i32)])
        for axis in ti.static(range(3)):
            most = size[axis] - 1
            at = (x[axis] - q.min[axis]) / (q.max[axis] - q.min[axis]) * most
            at = ti.min(ti.max(at, 0.0), ti.cast(most, real()))
            cell[axis] = ti.min(ti.cast(at, ti.i32), most - 1)
            fraction[axis] = at - cell[axis]
        d = fraction[0] * 0.0
        for corner in range(8):
            weight = fraction[0] * 0.0 + 1.0
            index = 0
            for axis in ti.static(range(3)):
                far = (corner >> axis) & 1
                weight *= ti.select(far == 1, fraction[axis], 1.0 - fraction[axis])
                index = index * size[axis] + cell[axis] + far
            d += weight * q.table(3 + index)
        return d

    @ti.func
    def distance(self, x, q, side):
        d = x[0]
        if ti.static(self.tabled):
            d = self.interpolated(x, q)
        else:
            d = self.values["function"](x)
        return d

    @ti.func
    def gradient(self, x, q, side):
        n = x * 0.0
        for axis in ti.static(range(3)):
            offset = x * 0.0
            offset[axis] = q.step
            n[axis] = self.distance(x + offset, q, side) - self.distance(x - offset, q, side)
        length = n.norm()
        up = ti.Vector([0.0, 1.0, 0.0])
        return ti.select(length > 0.0, n / ti.select(length > 0.0, length, 1.0), up)
