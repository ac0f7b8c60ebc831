"""A periodic force."""

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.maths.elementary import cos
from gen_art.registry import param


@force("driver")
class Driver(Force):
    """A periodic force, the same everywhere.

    F = amplitude cos(2 pi frequency t + phase) n,  n = direction / abs(direction)

    amplitude : N
    frequency : Hz, >= 0
    phase : rad (degrees in YAML)
    direction : (3,)
    Does work; time-dependent, no potential.
    """

    amplitude: float = param(1.0, unit="N")
    frequency: float = param(1.0, unit="Hz", min=0)
    phase: float = param(0.0, unit="rad", doc="of the cosine at time 0")
    direction: tuple = param((0.0, 1.0, 0.0))

    def prepare(self):
        if not any(self.values["direction"]):
            raise UsageError("Driver: direction must not be the null vector")

    @ti.func
    def force(self, p, t, q):
        cycles = q.frequency * t
        wave = cos(6.283185307179586 * (cycles - ti.floor(cycles)) + q.phase)
        return q.direction * (q.amplitude * wave / q.direction.norm())
