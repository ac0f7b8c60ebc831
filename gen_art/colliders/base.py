"""The contract of a collider: a signed distance, its gradient, and what an impact does."""

import math
from typing import ClassVar

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.kernel_methods import check_kernel_methods
from gen_art.registry import Parameter, Parametric, Registry, param

__all__ = ["ACTIONS", "COLLIDERS", "Collider", "collider"]

COLLIDERS = Registry("collider")
collider = COLLIDERS  # as a decorator: @collider("egg")

ACTIONS = ("bounce", "stick", "kill", "emit")


class Collider(Parametric):
    """A surface that particles cannot pass. A subclass defines @ti.func methods, each for all of its smooth `sides`:

    distance(self, x, q, side)  m, from x to the surface, positive where particles may be, never steeper than 1
    gradient(self, x, q, side)  (3,), the unit gradient of the distance
    nearest(self, x, q)         m, the smallest distance of all sides; needed if there is more than one
    facet(self, x, q)           0 to 3, the face on which a place of the surface lies; needed if it is `faceted`
    ray_span(self, o, d, q, radius, tangent)    (2,) m, from where to where a cone about a ray may meet it; speeds up drawing
    clear_way(self, q)          m, how far a ray that leaves it surely goes before it meets it again, if it `has_clear_way`

    `convex` says that no side's solid has a dent: a ray then finds it in a few steps.
    q holds the run-time parameters, and q.table(k) the numbers of a `table()`. A particle touches the surface where its distance
    equals its radius. The parameters below come after the subclass's own.
    """

    sides: ClassVar[int] = 1
    convex: ClassVar[bool] = (
        False  # whether each side is the surface of a convex solid, which a ray meets by Newton's method
    )
    flat: ClassVar[bool] = False  # whether a side has flat faces only
    faceted: ClassVar[bool] = False  # whether a side has edges between its faces, which are drawn smoothly
    # whether `clear_way` is known: shadows then do not look for the surface again where a ray has just left it
    has_clear_way: ClassVar[bool] = False
    repeat: ClassVar[None] = None

    restitution: float = param(
        0.5, min=0, max=1, doc="speed after over speed before, along the normal; 1 is elastic, 0 slides"
    )
    friction: tuple = param(
        (0.0, 0.0), kind="range", min=0, doc="coefficient of Coulomb friction; kinetic..static, if they differ"
    )
    action: str = param(
        "bounce", choices=ACTIONS, doc="what an impact does; emit: a bounce that `from: SYSTEM.impact` listens to"
    )
    velocity: tuple = param((0.0, 0.0, 0.0), unit="m/s", doc="of the surface")
    angular_velocity: tuple = param((0.0, 0.0, 0.0), unit="rad/s", doc="of the surface about the pivot, right-handed")
    pivot: tuple = param((0.0, 0.0, 0.0), unit="m", doc="a point of the axis of rotation at time 0")
    look: object = param(
        None, kind="look", doc="how its surface is drawn, see `look: of a collider`; unseen when left out"
    )

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        common = [key for key in Collider.parameters if key in cls.parameters]
        specific: dict[str, Parameter] = {key: p for key, p in cls.parameters.items() if key not in common}
        cls.parameters = specific | {key: cls.parameters[key] for key in common}
        check_kernel_methods(cls, ("distance", "gradient", "nearest", "facet", "ray_span", "clear_way"))

    def prepare(self):
        pair = tuple(float(c) for c in self.values["friction"])
        self.values["friction"] = (min(pair), max(pair))

    @property
    def takes_energy(self) -> bool:
        """Whether an impact changes the energy of a particle."""
        elastic = self.values["restitution"] == 1.0 and self.values["friction"][1] == 0.0
        return not (elastic and self.values["action"] == "bounce" and not self.moves)

    @property
    def moves(self) -> bool:
        """Whether the surface moves: with a velocity, or as it rotates."""
        return any(self.values["velocity"]) or self.rotates

    @property
    def rotates(self) -> bool:
        """Whether the surface rotates."""
        return any(self.values["angular_velocity"])

    @property
    def fixed(self) -> tuple:
        """What the generated kernel depends on: the class and its choices and flags, but no numbers."""
        values = tuple((k, self.values[k]) for k, p in self.parameters.items() if p.kind in ("bool", "choice", "text"))
        return (type(self), values, self.rotates)

    @ti.func
    def nearest(self, x, q):
        """The distance, m, from x to the nearest side."""
        return self.distance(x, q, 0)

    @ti.func
    def facet(self, x, q):
        return 0

    @ti.func
    def ray_span(self, o, d, q, radius, tangent):
        """From where to where, m, a cone about the ray from o along the unit vector d may meet the surface: anywhere.

        It need not be exact. A solid with dents is marched through only there. The cone is `radius` wide, m, at o, and grows by
        `tangent` per length. o, d : in the frame at time 0
        """
        return ti.Vector([-1e30, 1e30])

    @ti.func
    def clear_way(self, q):
        """How far, m, a ray that leaves the surface at a slope of 0.1 or more surely goes before it meets it again."""
        return 0.0

    def ball(self) -> tuple[np.ndarray, float] | None:
        """(centre, radius), m, of a ball around it at time 0; None where its extent is not known."""
        return None

    def surface_area(self) -> float:
        """m^2, of a convex solid, four times its mean shadow over all directions; 0 for any other."""
        return 0.0

    def bound_numbers(self, medium) -> list[float]:
        return self.numbers()

    def unit(self, key: str) -> None:
        """Normalise the vector `key`. Raises UsageError if it is zero."""
        vector = self.values[key]
        length = math.sqrt(sum(c * c for c in vector))
        if length == 0.0:
            raise UsageError(f"{type(self).__name__}: {key} must not be the zero vector: it says which way is out")
        self.values[key] = tuple(c / length for c in vector)
