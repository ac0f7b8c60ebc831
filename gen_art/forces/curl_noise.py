"""Turbulence: octaves of divergence-free noise."""

from gen_art.backend.runtime import real, ti
from gen_art.forces.base import Force, force
from gen_art.maths.noise import curl_noise
from gen_art.registry import param


@force("curl_noise")
class CurlNoise(Force):
    """Octaves of divergence-free noise: as a term of a medium a velocity (m/s), as a force an acceleration (m/s^2).

    u = sum over k of strength gain^k N(x / (scale / lacunarity^k), speed lacunarity^k t),  div N = 0, rms abs(N) = 1

    strength : root mean square of the first octave
    scale : m, size of its features, > 0
    speed : 1/s, how often the pattern renews itself
    octaves : 1 to 12
    drift : (3,) m/s, velocity of the whole pattern
    seed : selects another pattern
    Does work (no potential). Source: Bridson and others, SIGGRAPH 2007.
    """

    strength: float = param(1.0, unit="m/s or m/s^2")
    scale: float = param(1.0, unit="m", min=1e-30)
    speed: float = param(0.0, unit="1/s")
    octaves: int = param(1, min=1, max=12)
    gain: float = param(0.5, min=0, doc="strength of each octave divided by the one before")
    lacunarity: float = param(2.0, min=1, doc="frequency of each octave divided by the one before")
    drift: tuple = param((0.0, 0.0, 0.0), unit="m/s", doc="velocity of the whole pattern")
    seed: int = param(0, min=0, max=2**24)
    repeat = "octaves"

    @property
    def feature_size(self):
        return self.values["scale"]

    @ti.func
    def acceleration(self, p, t, q):
        frequency = 1.0 / q.scale
        amplitude = q.strength
        for k in ti.static(range(11)):  # powers by selects, because a run-time loop here would not vectorise
            frequency *= ti.select(k < q.index, q.lacunarity, 1.0)
            amplitude *= ti.select(k < q.index, q.gain, 1.0)
        rate = q.speed * q.scale * frequency
        offset = 17.31 * ti.cast(q.index, real()) + 0.5
        seed = ti.cast(q.seed * 64 + q.index, ti.u32) * ti.u32(0x165667B1)
        return amplitude * curl_noise((p.position - q.drift * t) * frequency + offset, rate * t, seed)
