"""Divergence-free noise: the curl of a vector potential of lattice noise, with derivatives in closed form.

The potential A has independent values in [-1, 1] for each of its three components at each lattice corner, faded from one
random set to the next as time passes, and blended by the quintic 6f^5 - 15f^4 + 10f^3, so the velocity curl A has
continuous derivatives. The result is scaled so that the root mean square of its length is 1.
Source: Bridson, Hourihan, Nordenstam, Curl-noise for procedural fluid flow (SIGGRAPH 2007).
"""

from gen_art.runtime import real, ti

__all__ = ["curl_noise", "lattice_hash"]

# 1 / rms of abs(curl A): <u^2> of the corner weights w and slopes w' over a cell, times the variance of the corner values
_NORM = 0.7206


@ti.func
def lattice_hash(h):
    """A 32-bit finaliser (two rounds of xor-shift and multiply) of a u32."""
    h = (h ^ (h >> ti.u32(16))) * ti.u32(0x7FEB352D)
    h = (h ^ (h >> ti.u32(15))) * ti.u32(0x846CA68B)
    return h ^ (h >> ti.u32(16))


@ti.func
def _values(h):
    """Three numbers in [-1, 1] from 30 bits of a hash."""
    return (
        ti.Vector(
            [
                ti.cast(ti.cast(h & ti.u32(1023), ti.i32), real()),
                ti.cast(ti.cast((h >> ti.u32(10)) & ti.u32(1023), ti.i32), real()),
                ti.cast(ti.cast((h >> ti.u32(20)) & ti.u32(1023), ti.i32), real()),
            ]
        )
        * (2.0 / 1023.0)
        - 1.0
    )


@ti.func
def curl_noise(p, time, seed):
    """Unit-strength divergence-free velocity at lattice position p (3,), at noise time `time`; seed is a u32.

    The field changes wholly over one unit of `time`. Dimensionless; features are about one lattice cell across.
    """
    base = ti.floor(p)
    f = p - base
    w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
    dw = 30.0 * f * f * (f * (f - 2.0) + 1.0)
    i, j, k = ti.cast(base[0], ti.i32), ti.cast(base[1], ti.i32), ti.cast(base[2], ti.i32)
    tick = ti.floor(time)
    g = time - tick
    g = g * g * (3.0 - 2.0 * g)
    scale = _NORM / ti.sqrt(g * g + (1.0 - g) * (1.0 - g))
    old, new = (1.0 - g) * scale, g * scale
    epoch = seed + ti.cast(ti.cast(tick, ti.i32), ti.u32) * ti.u32(0x27D4EB2F)
    c = ti.Vector([0.0, 0.0, 0.0])
    for n in ti.static(range(8)):
        x, y, z = ti.static(n & 1, (n >> 1) & 1, n >> 2)
        cell = (
            ti.cast(i + x, ti.u32) * ti.u32(0x9E3779B1)
            ^ ti.cast(j + y, ti.u32) * ti.u32(0x85EBCA77)
            ^ ti.cast(k + z, ti.u32) * ti.u32(0xC2B2AE3D)
        )
        a = _values(lattice_hash(cell + epoch)) * old + _values(lattice_hash(cell + epoch + ti.u32(0x27D4EB2F))) * new
        wx, sx = (w[0], dw[0]) if ti.static(x == 1) else (1.0 - w[0], -dw[0])
        wy, sy = (w[1], dw[1]) if ti.static(y == 1) else (1.0 - w[1], -dw[1])
        wz, sz = (w[2], dw[2]) if ti.static(z == 1) else (1.0 - w[2], -dw[2])
        gx, gy, gz = sx * wy * wz, wx * sy * wz, wx * wy * sz
        c += ti.Vector([gy * a[2] - gz * a[1], gz * a[0] - gx * a[2], gx * a[1] - gy * a[0]])
    return c
