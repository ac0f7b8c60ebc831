"""The random part of a kick, for forces that provide `noise`.

The normal numbers come from Philox (gen_art.maths.random), with the particle's key, the number of the step and the time of the
kick in it as its counter and key: they depend on nothing else.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import real, ti
from gen_art.integrators.lanes import WIDTH, step_of
from gen_art.maths.elementary import cos, log, phi, sin
from gen_art.maths.random import philox

__all__ = ["add_noise"]

_CHANNEL = 0x6C616E67  # separates these numbers from all others of a particle


@ti.func
def _unit(bits):
    """Uniform in (0, 1), of 24 bits: the same number in float32 and float64."""
    return (ti.cast(ti.cast(bits >> ti.u32(8), ti.i32), real()) + 0.5) * (2.0**-24)


@ti.func
def _normals(low, high, step, draw):
    """Two independent standard normal numbers (Box and Muller)."""
    a, b = philox(low ^ ti.u32(_CHANNEL), step, high ^ (draw * ti.u32(0x9E3779B9)))
    radius, angle = ti.sqrt(-2.0 * log(_unit(a))), 6.283185307179586 * _unit(b)
    return radius * cos(angle), radius * sin(angle)


@ti.func
def add_noise(
    terms: ti.template(), L: ti.template(), X: ti.template(), K: ti.template(), i, fraction, step, tau
):  # fmt: skip
    """Add the thermal noise of a kick to the velocities X, and write it to L.n0 to L.n2.

    step, tau : number of the step, and the time of the kick in it, in steps, a multiple of 1/2
    With linear rates of damping k and the sum B of the noises, m^2/s^3, the variance is B (1 - e^(-2 k h)) / (2 k).
    """
    for j in range(WIDTH):
        h = fraction * step_of(L, j)
        rate = h * 0.0
        for d in ti.static(range(len(terms.dampings))):
            rate += L.at("k", d)[j]
        deviation = ti.sqrt(L.s[j] * h * phi(2.0 * rate * h))
        low, high = K[0, i + j], K[1, i + j]
        draw = ti.cast(ti.cast(4.0 * tau, ti.i32), ti.u32)
        x, y = _normals(low, high, step, draw)
        z, _ = _normals(low, high, step, draw + ti.u32(1))
        L.n0[j], L.n1[j], L.n2[j] = deviation * x, deviation * y, deviation * z
        X.v0[j] += L.n0[j]
        X.v1[j] += L.n1[j]
        X.v2[j] += L.n2[j]
