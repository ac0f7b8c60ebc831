"""A table of where the rays of a picture end, made for each picture; it depends on the camera's distance from the middle alone.

With alpha the angle at which a ray sets out, 0 straight inwards and pi outwards, c and s its cosine and sine, a ray of the
camera is given by

    q = tan(alpha / 2) = s / (1 + c) up to alpha = pi/2,    q = 2 - s / (1 - c) beyond it

from 0 to 2. Rays wind round the middle without end at one q, the edge, and near it the angle that they sweep grows as the
logarithm of x = |q - edge|. So the entries lie as floating-point numbers do, PER_OCTAVE evenly in each power of two, and the
first bits of x are the number of its entry. Between two entries runs a straight line, off by at most (x / PER_OCTAVE)^2 / 8 times
the second derivative: where the angle is g log(x), by g / (8 PER_OCTAVE^2), 3e-5 rad for g = 1.

Rays with q below the edge go through a throat, or end at a horizon; the others come out on the camera's side. Those that end at a
horizon are black wherever they end: they have the entries of the others at the same distance from the edge, which say how many
samples a pixel takes.
"""

from functools import cache

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.lensing.lens import Bending

__all__ = ["ray_at", "ray_number", "ray_table"]

_BITS = 17  # of the mantissa that do not number an entry
PER_OCTAVE = 1 << (23 - _BITS)
_NEAREST = -24  # power of two of the first entry's x
_ENTRIES = (1 - _NEAREST) * PER_OCTAVE + 2  # up to x = 2
_FIRST = (127 + _NEAREST) << (23 - _BITS)

_ENDS, _EDGE = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.f32, 1)


@cache
def _fill_kernel(bending: Bending):
    ray_end, sine, edge_b, horizon = bending.ray_end, bending.sine, bending.edge, bending.horizon

    @ti.kernel
    def fill(u: ti.f64, w: ti.f64, ends: _ENDS, edge: _EDGE):
        """ends : (below the edge or above it, entries) angles swept to infinity, written; edge : (1,) its q, written"""
        s = ti.min(edge_b * sine(w), 1.0)
        edge[0] = ti.cast(s / (1.0 + ti.sqrt(1.0 - s * s)), ti.f32)
        ti.loop_config(block_dim=1)
        for entry in range(ends.shape[1]):
            for above in range(2):
                x = ti.cast(ti.bit_cast((entry + _FIRST) << _BITS, ti.f32), ti.f64)
                q = ti.cast(edge[0], ti.f64) + ti.select((above == 1) | horizon, x, -x)
                inward = ti.select(q < 1.0, 1, 0)
                half = ti.select(
                    inward == 1, q, 2.0 - q
                )  # below 0 beyond the rays straight in and out: the next ray, mirrored
                b = ti.abs(2.0 * half / (1.0 + half * half)) / sine(w)
                angle, _where = ray_end(b, inward, u, w)
                ends[above, entry] = ti.cast(ti.select(half < 0.0, -angle, angle), ti.f32)

    return kernel(fill, "f64")


def ray_table(bending: Bending, u: float, w: float) -> tuple[np.ndarray, float]:
    """The table of a camera at the place u, w: (2, entries) float32 rad, and q of the edge."""
    ends, edge = np.zeros((2, _ENTRIES), np.float32), np.zeros(1, np.float32)
    _fill_kernel(bending)(u, w, ends, edge)
    return ends, float(edge[0])


@ti.func
def ray_number(c, s):
    """(q, its derivative with respect to alpha) of a ray, by the cosine and the sine of alpha."""
    half = s / (1.0 + ti.abs(c))
    return ti.select(c < 0.0, 2.0 - half, half), 0.5 * (1.0 + half * half)


@ti.func
def ray_at(ends: ti.template(), x):
    """(angle swept to infinity, its derivative with respect to abs(x)) of the ray with q - edge = x."""
    above = ti.select(x < 0.0, 0, 1)
    bits = ti.bit_cast(ti.abs(x), ti.i32)
    entry = ti.min(ti.max((bits >> _BITS) - _FIRST, 0), ends.shape[1] - 2)
    first, last = ti.bit_cast((entry + _FIRST) << _BITS, ti.f32), ti.bit_cast((entry + _FIRST + 1) << _BITS, ti.f32)
    start = ends[above, entry]
    change = (ends[above, entry + 1] - start) / (last - first)
    return start + change * ti.max(ti.abs(x) - first, 0.0), change
