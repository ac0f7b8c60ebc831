"""A heat bath: friction and thermal noise."""

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("langevin")
class Langevin(Force):
    """A heat bath: friction against the medium, and the noise that keeps the particles at a temperature.

    dv = -friction (v - u) dt + sqrt(2 friction boltzmann temperature / m) dW, an Ornstein-Uhlenbeck process: each component of
    v - u comes to a normal distribution of variance boltzmann temperature / m, after 1/friction, and then
    <v(t) v(t + s)> = boltzmann temperature / m exp(-friction s)

    temperature : K, >= 0
    friction : 1/s, > 0
    boltzmann : J/K; 1 where a temperature is given as an energy
    medium : a ga.Medium, which gives u; the system's when left out
    Each kick solves velocities exactly, whatever the step: with other forces the distribution of positions has an error of
    order 2. A free particle spreads by <x^2> = 2 boltzmann temperature / (m friction) t, with a relative error of
    (friction dt)^2 / 12. The normal numbers are functions of the particle's key and the number of the step (Philox), so the
    result does not depend on threads; it does depend on the step. Works with semi_implicit_euler, position_verlet, leapfrog,
    velocity_verlet and boris. The ledger has the noise as work and the friction as dissipated.
    Source: Uhlenbeck & Ornstein (1930), Phys. Rev. 36, 823; Bussi & Parrinello (2007), Phys. Rev. E 75, 056707.
    """

    temperature: float = param(300.0, unit="K", min=0)
    friction: float = param(1.0, unit="1/s", min=0)
    boltzmann: float = param(1.380649e-23, unit="J/K", min=0)
    medium: object = param(None)
    dissipative = True
    random = True
    steady = True
    quadratic_damping = False

    def prepare(self):
        if self.values["friction"] == 0:
            raise UsageError("Langevin: friction must be above 0: without friction a bath exchanges no heat")

    @ti.func
    def damping(self, p, t, q):
        return ti.Vector([q.friction, 0.0])

    @ti.func
    def noise(self, p, t, q):
        return 2.0 * q.friction * q.temperature * (q.boltzmann / p.mass)
