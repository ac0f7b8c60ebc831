"""The contract of a collider: a signed distance, its gradient, and what becomes of a particle at the surface."""

from typing import ClassVar

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.registry import Parameter, Parametric, Registry, param

__all__ = ["ACTIONS", "COLLIDERS", "Collider", "collider"]

COLLIDERS = Registry("collider")
collider = COLLIDERS  # as a decorator: @collider("torus")

ACTIONS = ("bounce", "stick", "kill", "emit")


class Collider(Parametric):
    """A surface that particles do not pass. A subclass gives two @ti.func methods, for each of its smooth `sides`:

    distance(self, x, q, side)  m, from x to the surface, positive where particles may be, never steeper than 1
    gradient(self, x, q, side)  (3,) the unit gradient of the distance
    nearest(self, x, q)         m, the least distance of all sides; needed where there are several

    q holds the run-time parameters, and q.table(k) the numbers of a `table()`. A particle touches where its distance is its
    radius. The parameters below come after the subclass's own.
    """

    sides: ClassVar[int] = 1
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
    velocity: tuple = param((0.0, 0.0, 0.0), unit="m/s", doc="the surface moves with it")
    angular_velocity: tuple = param((0.0, 0.0, 0.0), unit="rad/s", doc="it turns about the pivot, right-handed")
    pivot: tuple = param((0.0, 0.0, 0.0), unit="m", doc="where its axis goes through at time 0")

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        common = [key for key in Collider.parameters if key in cls.parameters]
        own: dict[str, Parameter] = {key: p for key, p in cls.parameters.items() if key not in common}
        cls.parameters = own | {key: cls.parameters[key] for key in common}

    def prepare(self):
        pair = tuple(float(c) for c in self.values["friction"])
        self.values["friction"] = (min(pair), max(pair))

    @property
    def takes_energy(self) -> bool:
        """Whether an impact changes the energy of a particle."""
        elastic = self.values["restitution"] == 1.0 and self.values["friction"][1] == 0.0
        moves = any(self.values["velocity"]) or self.turns
        return not (elastic and self.values["action"] == "bounce" and not moves)

    @property
    def turns(self) -> bool:
        return any(self.values["angular_velocity"])

    @property
    def fixed(self) -> tuple:
        """What is generated into the kernel: the class and its choices and flags. Numbers are never in it."""
        values = tuple((k, self.values[k]) for k, p in self.parameters.items() if p.kind in ("bool", "choice", "text"))
        return (type(self), values, self.turns)

    @ti.func
    def nearest(self, x, q):
        """m, from x to the nearest of the sides."""
        return self.distance(x, q, 0)

    def bound_numbers(self, medium) -> list[float]:
        return self.numbers()

    def unit(self, key: str) -> None:
        """Give the vector `key` the length 1; UsageError if it is zero."""
        vector = self.values[key]
        length = sum(c * c for c in vector) ** 0.5
        if length == 0.0:
            raise UsageError(f"{type(self).__name__}: {key} must not be the zero vector: it says which way is out")
        self.values[key] = tuple(c / length for c in vector)
