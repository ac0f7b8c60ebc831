"""The contract of a force: what a class may declare, and what the kernels use of it."""

import math
from typing import Any, ClassVar, Protocol

from gen_art.arguments import shown
from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.kernel_methods import check_kernel_methods
from gen_art.registry import Parametric, Registry

__all__ = [
    "FORCES",
    "Force",
    "force",
    "has_acceleration",
    "is_steady",
    "loses_mass",
    "term_acceleration",
    "term_mass_rate",
]

FORCES = Registry("force")
force = FORCES  # as a decorator: @ga.force("swirl")


class Fluid(Protocol):
    """What a force needs to know of a medium: its density, kg/m^3."""

    density: float


class Force(Parametric):
    """A force that acts on one particle, from the particle's own state, the time and parameters.

    A subclass declares parameters by `name: float = ga.param(...)` and any of the @ti.func methods below. Each is called as
    `(self, p, t, q)`:

    p : the particle (position, velocity, mass, charge, radius, age, lifetime, key, declared attributes)
    t : time, s
    q : the run-time parameters

    acceleration  (3,) m/s^2
    force         (3,) N, divided by the particle's mass
    electric      (3,) V/m
    magnetic      (3,) T
    damping       (2,) rate in 1/s and quadratic rate in 1/m, which the integrator solves exactly
    noise         m^2/s^3, the strength of a white noise: a free velocity's variance grows by it each second; beside `damping`
    potential     J, time-independent; -gradient is the force
    mass_rate     kg/s by which the particle's mass falls, constant over a step; p.since is the age at the step's start, p.step
                  its length, s (`mass_loss` is the same under another name, for classes with a parameter mass_rate)

    Flags, which the ledger and `inspect` read:
    conservative : has a time-independent potential
    reciprocal, dissipative, does_work : as their names say
    repeat : the name of an int parameter; the term is summed for q.index in 0 .. q.<repeat> - 1
    depends_on_velocity : tells the integrators that a plain kick loses an order
    steady : its vectors, and the rates of its damping, depend on neither time, age nor velocity (those of a conservative force
        never do). Leapfrog then reuses the accelerations of its last kick for the next step's first, where nothing has moved
    reads_medium : gives `p.flow` (3,) m/s, the velocity of the system's medium at the particle
    drags_on_mass : the rates of `damping` are divided by the mass
    needs : attributes that particles must have
    random : its acceleration is noise, so that velocities do not change smoothly
    damping_reads_particle : False if `damping` reads nothing of `p`. Where it is `steady` too, its exponential is computed once
    quadratic_damping : False if the second number of `damping` is always 0
    """

    repeat: ClassVar[str | None] = None
    conservative: ClassVar[bool] = False
    reciprocal: ClassVar[bool] = False
    dissipative: ClassVar[bool] = False
    does_work: ClassVar[bool] = True
    depends_on_velocity: ClassVar[bool] = False
    steady: ClassVar[bool] = False
    reads_medium: ClassVar[bool] = False
    drags_on_mass: ClassVar[bool] = False
    needs: ClassVar[tuple[str, ...]] = ()
    random: ClassVar[bool] = False
    quadratic_damping: ClassVar[bool] = True
    damping_reads_particle: ClassVar[bool] = True

    kernel_methods: ClassVar[tuple[str, ...]] = (
        "acceleration", "force", "electric", "magnetic", "damping", "noise", "potential", "mass_rate", "mass_loss",
    )  # fmt: skip

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        check_kernel_methods(cls, cls.kernel_methods)
        if cls.repeat is not None and cls.repeat not in cls.parameters:
            raise UsageError(f"{cls.__name__}.repeat names '{cls.repeat}', which is no parameter of it")
        if cls.conservative and not cls.provides("potential"):
            raise UsageError(f"{cls.__name__} is declared conservative: it needs a potential")

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        medium = self.values.get("medium")
        if medium is not None:
            from gen_art.forces.medium import Medium  # which imports this module

            if not isinstance(medium, Medium):
                raise UsageError(f"{type(self).__name__}: medium must be a ga.Medium, not {shown(medium)}")

    @classmethod
    def provides(cls, quantity: str) -> bool:
        """Whether the class defines the method `quantity` (acceleration, potential, damping ...)."""
        return callable(getattr(cls, quantity, None))

    @property
    def fixed(self) -> tuple:
        """What the kernel is compiled for: the class and its choices and flags. Numbers are never part of it."""
        values = tuple((k, self.values[k]) for k, p in self.parameters.items() if p.kind in ("bool", "choice", "text"))
        return (type(self), values)

    @property
    def feature_size(self) -> float:
        """m, the distance over which the force changes entirely; no particle may pass it in a step. inf if it has none."""
        return math.inf

    def check_mass(self, lightest: float) -> None:
        """Raises UsageError if the lightest particle of a system, in kg, is too light for this force."""
        in_newtons = self.drags_on_mass or any(self.provides(k) for k in ("force", "electric", "magnetic"))
        if lightest <= 0 and in_newtons:
            raise UsageError(
                f"{self.name or type(self).__name__} acts with a force, and a particle without mass has no acceleration: "
                "give it a mass above 0"
            )

    def bound_numbers(self, medium: "Fluid") -> list[float]:
        """The run-time numbers in a medium: a `density` that was left out is the medium's.

        Raises UsageError if this force needs a density and neither gives one.
        """
        numbers = self.numbers()
        if "density" in self.parameters and self.values["density"] is None:
            if self.needs_density and not medium.density:
                raise UsageError(f"{self.name} needs the fluid's density: {self.name}.density, or medium.density")
            numbers[next(start for name, start, _ in self.layout() if name == "density")] = medium.density
        return numbers

    @property
    def needs_density(self) -> bool:
        """Whether a force with the parameter `density` has no effect without it."""
        return True


@ti.func
def term_acceleration(term: ti.template(), p, t, q):
    """The acceleration (3,) of one term, whichever method the class defines; without the magnetic part."""
    a = ti.Vector([0.0, 0.0, 0.0])
    if ti.static(term.provides("acceleration")):
        a += term.acceleration(p, t, q)
    if ti.static(term.provides("force")):
        a += term.force(p, t, q) / p.mass
    if ti.static(term.provides("electric")):
        a += term.electric(p, t, q) * (p.charge / p.mass)
    return a


def has_acceleration(term) -> bool:
    """Whether a term has a part that acts as an acceleration."""
    return any(term.provides(n) for n in ("acceleration", "force", "electric"))


@ti.func
def term_mass_rate(term: ti.template(), p, t, q):
    """The mass rate of one term, kg/s."""
    rate = p.mass * 0.0
    if ti.static(term.provides("mass_rate")):
        rate = term.mass_rate(p, t, q)
    else:
        rate = term.mass_loss(p, t, q)
    return rate


def is_steady(term) -> bool:
    """Whether a term gives the same vectors again if a particle has not moved."""
    return (term.steady or term.conservative) and not term.depends_on_velocity


def loses_mass(term) -> bool:
    """Whether a term reduces the particle's mass."""
    return term.provides("mass_rate") or term.provides("mass_loss")
