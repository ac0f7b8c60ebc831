"""Divergence-free noise: the curl of a vector potential of lattice noise, with derivatives in closed form.

The potential A has independent values in [-1, 1] for each of its three components at each lattice corner, faded from one
random set to the next as time passes, and blended by the quintic 6f^5 - 15f^4 + 10f^3, so the velocity curl A has
continuous derivatives. The result is scaled so that the root mean square of its length is 1.
Source: Bridson, Hourihan, Nordenstam, Curl-noise for procedural fluid flow (SIGGRAPH 2007).
"""

from gen_art.backend.runtime import real, ti

__all__ = ["curl_noise", "lattice_hash"]

# 1 / rms of abs(curl A) for values uniform in [-1, 1]: the mean square is 6 (1/3) D W^2 with W = 2 (181/462), the mean of
# w^2 + (1 - w)^2 over a cell, and D = 2 (10/7), that of the two slopes squared
_NORM = (2.0 * (20.0 / 7.0) * (181.0 / 231.0) ** 2) ** -0.5


@ti.func
def lattice_hash(h):
    """A short 32-bit mixer (two xor-shifts, one multiply) of a lattice cell's already multiplied coordinates."""
    h = (h ^ (h >> ti.u32(15))) * ti.u32(0x2C1B3C6D)
    return h ^ (h >> ti.u32(12))


@ti.func
def _value(h, shift: ti.template()):
    """Ten bits of a hash, 0 to 1023. An offset does not change the curl, and the scale is applied once at the end."""
    return ti.cast(ti.cast((h >> ti.u32(shift)) & ti.u32(1023), ti.i32), real())


@ti.func
def _mix(a, b, w):
    return a + (b - a) * w


@ti.func
def _slopes(a: ti.template(), c: ti.template(), n: ti.template(), u, v, w):
    """d/dv and d/dw of the trilinear interpolation of a[c, n[u + 2 v + 4 w]], without the derivatives of the weights."""
    e00, e10 = _mix(a[c, n[0]], a[c, n[1]], u), _mix(a[c, n[2]], a[c, n[3]], u)
    e01, e11 = _mix(a[c, n[4]], a[c, n[5]], u), _mix(a[c, n[6]], a[c, n[7]], u)
    return _mix(e10 - e00, e11 - e01, w), _mix(e01 - e00, e11 - e10, v)


@ti.func
def curl_noise(p, time, seed):
    """Unit-strength divergence-free velocity at lattice position p (3,), at noise time `time`; seed is a u32.

    The field is a new one after one unit of `time`. Dimensionless; features are about one lattice cell across.
    """
    base = ti.floor(p)
    f = p - base
    w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
    dw = 30.0 * f * f * (f * (f - 2.0) + 1.0)
    tick = ti.floor(time)
    g = time - tick
    g = g * g * (3.0 - 2.0 * g)
    fade = _NORM * (2.0 / 1023.0) / ti.sqrt(g * g + (1.0 - g) * (1.0 - g))
    epoch = seed + ti.cast(ti.cast(tick, ti.i32), ti.u32) * ti.u32(0x27D4EB2F)
    x0 = ti.cast(ti.cast(base[0], ti.i32), ti.u32) * ti.u32(0x9E3779B1)
    y0 = ti.cast(ti.cast(base[1], ti.i32), ti.u32) * ti.u32(0x85EBCA77)
    z0 = ti.cast(ti.cast(base[2], ti.i32), ti.u32) * ti.u32(0xC2B2AE3D)
    a = ti.Matrix([[0.0] * 8, [0.0] * 8, [0.0] * 8])
    for n in ti.static(range(8)):
        i = x0 + ti.u32(0x9E3779B1 * (n & 1))
        j = y0 + ti.u32(0x85EBCA77 * ((n >> 1) & 1))
        k = z0 + ti.u32(0xC2B2AE3D * (n >> 2))
        cell = (i ^ j ^ k) + epoch
        old, new = lattice_hash(cell), lattice_hash(cell + ti.u32(0x27D4EB2F))
        for c in ti.static(range(3)):
            a[c, n] = _mix(_value(old, 10 * c), _value(new, 10 * c), g)
    # of each component of A two of the three slopes are needed: interpolate along the third axis first
    dy0, dz0 = _slopes(a, 0, (0, 1, 2, 3, 4, 5, 6, 7), w[0], w[1], w[2])
    dz1, dx1 = _slopes(a, 1, (0, 2, 4, 6, 1, 3, 5, 7), w[1], w[2], w[0])
    dx2, dy2 = _slopes(a, 2, (0, 4, 1, 5, 2, 6, 3, 7), w[2], w[0], w[1])
    return ti.Vector([dy2 * dw[1] - dz1 * dw[2], dz0 * dw[2] - dx2 * dw[0], dx1 * dw[0] - dy0 * dw[1]]) * fade
