"""Carlson's symmetric elliptic integral of the first kind, of which all others of the first kind are made.

    R_F(x, y, z) = 1/2 * integral from 0 to infinity of dt / sqrt((t + x) (t + y) (t + z))
    F(phi, k) = sin(phi) R_F(cos(phi)^2, 1 - k^2 sin(phi)^2, 1),  K(k) = R_F(0, 1 - k^2, 1),  atan2(s, c) = s R_F(c^2, 1, 1)

It takes square roots and arithmetic alone, so it has the same bits with every C library.
Source: Carlson, Numerical computation of real or complex elliptic integrals, Numerical Algorithms 10 (1995).
"""

from gen_art.backend.runtime import ti

__all__ = ["angle_of", "elliptic_rf", "elliptic_rf_of_pair"]

_MOST_STEPS = 60
# Distance of the arguments from their mean, relative to it, at which the series of degree 5 ends: its error is about the sixth
# power, 1e-12
_NEAR = 8e-3


@ti.func
def elliptic_rf(x, y, z):
    """R_F(x, y, z) of numbers >= 0, of which one at most is 0."""
    mean = (x + y + z) / 3.0
    steps = 0
    while (ti.max(ti.abs(x - mean), ti.max(ti.abs(y - mean), ti.abs(z - mean))) > _NEAR * mean) & (steps < _MOST_STEPS):
        a, b, c = ti.sqrt(x), ti.sqrt(y), ti.sqrt(z)
        shift = a * b + a * c + b * c
        x, y, z = 0.25 * (x + shift), 0.25 * (y + shift), 0.25 * (z + shift)
        mean = (x + y + z) / 3.0
        steps += 1
    p, q = 1.0 - x / mean, 1.0 - y / mean
    r = -p - q
    e2, e3 = p * q - r * r, p * q * r
    return (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - e2 * e3 * ti.static(3.0 / 44.0)) / ti.sqrt(mean)


@ti.func
def angle_of(s, c):
    """The angle in 0..pi with the sine s >= 0 and the cosine c, whose squares add up to 1."""
    angle = s * elliptic_rf(c * c, 1.0 + 0.0 * c, 1.0 + 0.0 * c)
    return ti.select(c < 0.0, ti.static(3.141592653589793) - angle, angle)


@ti.func
def elliptic_rf_of_pair(re, im, w):
    """R_F(z, conjugate of z, w) of the complex number z = re + i im, not 0 or below with im = 0, and w > 0."""
    mean = (2.0 * re + w) / 3.0
    steps = 0
    while (ti.max(ti.abs(re - mean), ti.max(ti.abs(im), ti.abs(w - mean))) > _NEAR * ti.abs(mean)) & (
        steps < _MOST_STEPS
    ):
        size = ti.sqrt(re * re + im * im)
        # the square roots of z and of its conjugate add up to 2 sqrt((size + re) / 2), and their product is size
        shift = size + ti.sqrt(2.0 * ti.max(size + re, 0.0) * w)
        re, im, w = 0.25 * (re + shift), 0.25 * im, 0.25 * (w + shift)
        mean = (2.0 * re + w) / 3.0
        steps += 1
    p, q = 1.0 - re / mean, im / mean
    e2, e3 = q * q - 3.0 * p * p, -2.0 * p * (p * p + q * q)
    return (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - e2 * e3 * ti.static(3.0 / 44.0)) / ti.sqrt(mean)
