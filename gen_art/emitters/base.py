"""The contracts of what happens at a birth: where (a shape), how fast (a velocity), or both (an emitter)."""

from collections.abc import Callable
from typing import ClassVar

from gen_art.registry import Parametric, Registry

__all__ = ["EMITTERS", "SHAPES", "VELOCITIES", "Emitter", "Shape", "Velocity", "emitter", "shape", "velocity"]

SHAPES = Registry("shape")
VELOCITIES = Registry("velocity")
EMITTERS = Registry("emitter")
shape, velocity, emitter = SHAPES, VELOCITIES, EMITTERS


class _Birth(Parametric):
    @property
    def fixed(self) -> tuple:
        """What is generated into the birth kernel: the class and its choices. Numbers are never in it."""
        values = tuple((k, self.values[k]) for k, p in self.parameters.items() if p.kind in ("bool", "choice", "text"))
        return (type(self), values)


class Shape(_Birth):
    """Where particles are born, relative to the emitter's origin: `place(self, r, t, q)`, a @ti.func giving (3,) m."""


class Velocity(_Birth):
    """The velocity at birth, relative to the emitter's: `velocity(self, r, t, q, x)`, a @ti.func giving (3,) m/s.

    x is the place of birth relative to the origin; r.ordinal counts the particles of a burst and r.burst is its stream.
    """


class Emitter(_Birth):
    """A whole birth in one place.

    Either `birth(self, r, t, q)`, a @ti.func returning (position, velocity) or a dict that also sets mass, charge,
    radius, lifetime or declared attributes; or, for initial conditions, `sample(self, r, n)` in NumPy, returning a dict of
    arrays, where r.uniform(channel), r.normal(channel) and r.sphere(channel) give one value for each of the n particles;
    NaN leaves what the preset says.
    `declares` : attributes that its particles have without the preset's naming them.
    """

    sample: ClassVar[Callable | None] = None
    declares: ClassVar[tuple[str, ...]] = ()
