"""A random force that is a function of time and of the particle's key."""

from gen_art.backend.runtime import real, ti
from gen_art.forces.base import Force, force
from gen_art.maths.elementary import cos, log
from gen_art.registry import param

_FREQUENCY = (
    1.2533141373155003  # sqrt(pi / 2): standard deviation of the angular frequencies for a correlation time of 1
)


@ti.func
def _mix_bits(h):
    """A 32-bit bijection in which every input bit affects every output bit (the finaliser of MurmurHash3)."""
    h = (h ^ (h >> ti.u32(16))) * ti.u32(0x85EBCA6B)
    h = (h ^ (h >> ti.u32(13))) * ti.u32(0xC2B2AE35)
    return h ^ (h >> ti.u32(16))


@ti.func
def _uniform(h, channel: ti.template()):
    """Uniform in (0, 1), of 24 bits, from a hash and a channel: the same number in float32 and float64."""
    bits = _mix_bits(h + ti.u32((channel * 0x9E3779B9) & 0xFFFFFFFF)) >> ti.u32(8)
    return (ti.cast(ti.cast(bits, ti.i32), real()) + 0.5) * (2.0**-24)


@force("random_driver")
class RandomDriver(Force):
    """A stationary random force, independent for each particle: noise with a correlation time.

    F = strength sqrt(2 / (3 harmonics)) sum over k of cos(w_k t + phase_k) for each component, phases uniform,
    w_k normal with standard deviation sqrt(pi / 2) / correlation_time: mean 0, <F . F> = strength^2 and
    <F(t) . F(t + s)> = strength^2 exp(-pi / 4 (s / correlation_time)^2), whose integral over s > 0 is correlation_time

    strength : N, root mean square of the force's length
    correlation_time : s, > 0
    seed : selects another force
    harmonics : 1 to 64; with many, each component is normally distributed
    It is a smooth function of time and the particle's key alone, without state, so every integrator keeps its order. Does work.
    Over times much longer than its correlation time a free particle gains <v^2> = 2 strength^2 correlation_time t / m^2. It is
    no heat bath: with few harmonics the velocities that it and a damping bring about are not normally distributed (a
    kurtosis far above 3), because each particle keeps its own few frequencies for ever. Use `langevin`.
    Source: Rice (1944), Mathematical analysis of random noise, Bell System Tech. J. 23, 282.
    """

    strength: float = param(1.0, unit="N", min=0)
    correlation_time: float = param(1.0, unit="s", min=1e-30)
    seed: int = param(0, min=0, max=2**24, doc="another force")
    harmonics: int = param(8, min=1, max=64, doc="waves that are summed")
    repeat = "harmonics"

    @ti.func
    def force(self, p, t, q):
        wave = ti.cast(q.seed * 64 + q.index, ti.u32) * ti.u32(0x165667B1)
        h = _mix_bits(_mix_bits(p.key[0] ^ wave) ^ p.key[1])
        normal = ti.sqrt(-2.0 * log(_uniform(h, 0))) * cos(6.283185307179586 * _uniform(h, 1))
        angle = normal * (_FREQUENCY / q.correlation_time) * t
        phases = ti.Vector([_uniform(h, 2), _uniform(h, 3), _uniform(h, 4)]) * 6.283185307179586
        return cos(phases + angle) * (q.strength * ti.sqrt(2.0 / 3.0 / ti.cast(q.harmonics, real())))
