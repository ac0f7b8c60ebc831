"""Forces from sources given to ElectricField and MagneticField: an object, a function or a grid."""

from functools import cache
from pathlib import Path

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force

__all__ = ["field_of"]


@cache
def _magnetic_of(function) -> Force:
    class MagneticFunction(Force):
        """A magnetic field from a user's function, B = f(p, t, q)."""

        does_work = False
        depends_on_velocity = True

        @ti.func
        def magnetic(self, p, t, q):
            return function(p, t, q)

    return MagneticFunction()


@cache
def _electric_of(function) -> Force:
    class ElectricFunction(Force):
        """An electric field from a user's function, E = f(p, t, q)."""

        @ti.func
        def electric(self, p, t, q):
            return function(p, t, q)

    return ElectricFunction()


def _is_grid(source) -> bool:
    """Whether it has the form of a grid: lists of lists, or an array of several dimensions."""
    if isinstance(source, np.ndarray):
        return source.ndim > 1
    return isinstance(source, (list, tuple)) and bool(source) and isinstance(source[0], (list, tuple, np.ndarray))


def field_of(quantity: str, source, options: dict) -> Force | None:
    """The force of a source of an electric or magnetic field; None if `source` is three numbers or left out.

    quantity : "electric" or "magnetic"
    source : a Force that provides the quantity is returned as it is; a @ti.func of (p, t, q) is called; a path or an array
        (nx, ny, nz, 3) is a grid
    options : of a grid, as of vector_field
    Raises UsageError for a force that provides no such field.
    """
    from gen_art.forces.electric_sources import ElectricGrid
    from gen_art.forces.magnetic_sources import MagneticGrid

    if isinstance(source, Force):
        if not source.provides(quantity):
            raise UsageError(f"{source!r} gives no {quantity} field")
        return source
    if getattr(source, "_is_taichi_function", False):
        return (_magnetic_of if quantity == "magnetic" else _electric_of)(source)
    if isinstance(source, (str, Path)) or _is_grid(source):
        return (MagneticGrid if quantity == "magnetic" else ElectricGrid)(source, **options)
    return None
