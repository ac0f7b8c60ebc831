"""Rings about a heavy body: of a planet, or the test particles of an encounter."""

import numpy as np

from gen_art.emitters.base import emitter
from gen_art.emitters.placed import PlacedEmitter
from gen_art.errors import UsageError
from gen_art.maths.array_functions import cos, exp, log, sin
from gen_art.registry import param

__all__ = ["KeplerRings"]

_EVEN = (0.7548776662466927, 0.5698402909980532)  # 1 / p and 1 / p^2 for the root p of p^3 = p + 1


@emitter("kepler_rings")
class KeplerRings(PlacedEmitter):
    """Bodies on circles about a central mass, with +y as their axis, anticlockwise seen from +y.

    v = sqrt(G central_mass R^2 / (R^2 + softening^2)^(3/2)), and normal velocities of `spread` v in each direction
    even : in a band, places follow Roberts's sequence, frac(n 0.7549) and frac(n 0.5698), in place of two random numbers; on
        circles they are evenly spaced, and stay so
    rings = 0 : a band from `inner` to `outer` whose surface density falls as R^-falloff; else that many circles, evenly spaced
    The mass of each particle is mass / n; their own gravity is left out of their velocity.
    Source: Toomre & Toomre (1972), ApJ 178, 623, for encounters; Roberts (2018), The unreasonable effectiveness of
    quasirandom sequences.
    """

    G: float = param(
        6.67430e-11, unit="m^3/(kg s^2)", min=0, doc="constant of gravitation; units.G of the preset when left out"
    )
    central_mass: float = param(1.0, unit="kg", min=0, doc="mass of the body at the centre")
    mass: float = param(0.0, unit="kg", min=0, doc="mass of all particles of the rings")
    inner: float = param(1.0, unit="m", min=1e-30, doc="radius of the innermost circle")
    outer: float = param(2.0, unit="m", min=1e-30, doc="radius of the outermost circle")
    falloff: float = param(
        0.0, min=0, max=1.9, doc="power by which the surface density falls outwards; 0 is an even band"
    )
    rings: int = param(0, min=0, max=10_000, doc="number of circles; 0 is a band")
    even: bool = param(False, doc="spread evenly in place of at random, which leaves out the noise of numbers")
    thickness: float = param(0.0, unit="m", min=0, doc="standard deviation of the height")
    spread: float = param(0.0, min=0, max=1, doc="standard deviation of each velocity component, of the speed")
    softening: float = param(0.0, unit="m", min=0, doc="that of the attraction of the central body")

    @property
    def total_mass(self) -> float:
        return self.values["central_mass"] + self.values["mass"]

    def prepare(self):
        super().prepare()
        if self.values["outer"] < self.values["inner"]:
            raise UsageError("kepler_rings: outer must be at least inner")

    def sample(self, r, n):
        v = self.values
        inner, outer = v["inner"], v["outer"]
        across, around = r.uniform(1), r.uniform(2)
        if v["even"]:
            number, rings = np.arange(n), v["rings"]
            across, around = (0.5 + number * _EVEN[0]) % 1.0, (0.5 + number * _EVEN[1]) % 1.0
            if rings:
                across = (number % rings + 0.5) / rings
                around = (number // rings * (rings / n) + number % rings * _EVEN[1]) % 1.0
        if v["rings"]:
            place = np.minimum(np.floor(v["rings"] * across), v["rings"] - 1) / max(v["rings"] - 1, 1)
            R = inner + (outer - inner) * place
        else:
            power = 2 - v["falloff"]  # of the mass within R
            low, high = exp(power * log(inner)), exp(power * log(outer))
            R = exp(log(low + (high - low) * across) / power)
        phi, s2 = 2 * np.pi * around, R * R + v["softening"] ** 2
        speed = np.sqrt(v["G"] * v["central_mass"] * R * R / (s2 * np.sqrt(s2)))
        c, s = cos(phi), sin(phi)
        swarm = v["spread"] * speed * np.stack([r.normal(4), r.normal(5), r.normal(6)])
        return self.placed(
            {
                "position": np.stack([R * c, v["thickness"] * r.normal(3), -R * s]),
                "velocity": np.stack([-speed * s, 0 * s, -speed * c]) + swarm,
                "mass": np.full(n, v["mass"] / n),
            }
        )
