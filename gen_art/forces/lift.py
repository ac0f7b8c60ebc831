"""Lift on a wing, perpendicular to the flow."""

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("lift")
class Lift(Force):
    """Lift on a wing: perpendicular to the flow and to the span.

    F = 1/2 density abs(w)^2 area coefficient n x w / abs(n x w),  w = v - u(x, t),  n along span_axis; 0 where w is along n

    coefficient : lift coefficient, with its sign
    area : m^2, of the wing, >= 0
    span_axis : (3,), towards the wing tip on the right of a pilot: in flight along x with the axis along z, lift is up, along y
    density : kg/m^3; the medium's when left out
    medium : a ga.Medium; the system's when left out
    Does no work in still air. A plain kick integrates it at order 1: use `rk2` or `rk4`.
    Source: Anderson, Fundamentals of Aerodynamics, section 1.5.
    """

    coefficient: float = param(1.0)
    area: float = param(1.0, unit="m^2", min=0)
    span_axis: tuple = param((0.0, 0.0, 1.0))
    density: float = param(None, unit="kg/m^3", min=0, doc="of the fluid; the medium's when left out")
    medium: object = param(None)
    depends_on_velocity = True
    reads_medium = True

    def prepare(self):
        if not any(self.values["span_axis"]):
            raise UsageError("Lift: span_axis must not be the null vector")

    @ti.func
    def force(self, p, t, q):
        w = p.velocity - p.flow
        normal = q.span_axis.cross(w)
        return normal * (0.5 * q.density * w.dot(w) * q.area * q.coefficient / ti.max(normal.norm(), 1e-30))
