"""A rocket engine: its thrust, and the mass that it burns."""

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("thrust")
class Thrust(Force):
    """A rocket's thrust; the particle's mass decreases while it burns.

    F = mass_rate exhaust_speed n,  dm/dt = -mass_rate,  n = direction / abs(direction),
    while start <= age < start + duration;  free flight gains exhaust_speed ln(m0 / m1)

    exhaust_speed : m/s, >= 0
    mass_rate : kg/s, >= 0
    duration, start : s of the particle's age, >= 0
    dry_mass : kg, the mass that must remain; a lighter particle is refused
    A burn that ends inside a step is spread over that step, so that the mass is exact. The ledger records the released energy,
    mass_rate exhaust_speed^2 / 2, as work, and, as died under the thrust's name, the mass, momentum and energy of the exhaust,
    which leaves at v - exhaust_speed n.
    Source: Tsiolkovsky's equation; Goldstein, Classical Mechanics, chapter 1, derivation 13.
    """

    direction: tuple = param((0.0, 1.0, 0.0))
    exhaust_speed: float = param(1.0, unit="m/s", min=0)
    mass_rate: float = param(0.1, unit="kg/s", min=0, doc="mass burnt per second")
    duration: float = param(1.0, unit="s", min=0)
    start: float = param(0.0, unit="s", min=0, doc="age at ignition")
    dry_mass: float = param(0.0, unit="kg", min=0, doc="mass that must remain")

    def prepare(self):
        if not any(self.values["direction"]):
            raise UsageError("Thrust: direction must not be the null vector")

    def check_mass(self, lightest: float):
        super().check_mass(lightest)
        burnt, dry = self.values["mass_rate"] * self.values["duration"], self.values["dry_mass"]
        if burnt > 0.0 and not (lightest - burnt >= dry and lightest > burnt):
            left = f"leaves less than its dry mass of {dry:g} kg" if dry else "would leave nothing"
            raise UsageError(
                f"thrust burns {burnt:g} kg ({self.values['mass_rate']:g} kg/s for {self.values['duration']:g} s), which {left} "
                f"of a particle of {lightest:g} kg: make it heavier, or the burn shorter"
            )

    @ti.func
    def mass_loss(self, p, t, q):
        burning = ti.min(p.since + p.step, q.start + q.duration) - ti.max(p.since, q.start)
        return q.mass_rate * ti.max(burning, 0.0) / ti.max(p.step, 1e-30)

    @ti.func
    def force(self, p, t, q):
        return q.direction * (self.mass_loss(p, t, q) * q.exhaust_speed / q.direction.norm())
