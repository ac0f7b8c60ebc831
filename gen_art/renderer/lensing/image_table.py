"""A table of where a camera in bent space sees things, made once for each distance of the camera from the middle.

A thing is given by its place along the radial direction and its angle from the camera, seen from the middle. Rows are even in
what the metric makes of the place, columns in q = tan(angle / 4), which square roots alone give. For the image of order 0 the
table holds by how much the direction is turned from that in a flat space which is the true one near the camera, and the width
`along` by that in the flat space; both are smooth. For order 1, whose ray goes round the other side, it holds the direction and
the width themselves. Between rows and columns runs a polynomial of degree 3 through four of each.
"""

from functools import cache

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.carlson import angle_of
from gen_art.maths.elementary import cos, sin
from gen_art.renderer.lensing.lens import NORMAL, OUTWARD, TANGENTS, Bending, U, W, vector, way_to

__all__ = ["TABLE", "image_director", "image_table"]

ROWS, COLUMNS = 128, 128
_ALMOST_0 = 1e-7  # rad: the angle of column 0
_NEARLY = 1e-12

TABLE = ti.types.ndarray(ti.f64, 4)


@cache
def _fill_kernel(bending: Bending):
    find_image, at_row, apart_of = bending.find_image, bending.at_row, bending.apart

    @ti.kernel
    def fill(u: ti.f64, w: ti.f64, T: TABLE):
        """T : (2 orders, turned or direction and along, rows, columns), written."""
        ti.loop_config(block_dim=1)
        for row in range(T.shape[2]):
            for column in range(T.shape[3]):
                for order in range(2):
                    q = ti.cast(column, ti.f64) / ti.cast(T.shape[3] - 1, ti.f64)
                    half_c, half_s = (1.0 - q * q) / (1.0 + q * q), 2.0 * q / (1.0 + q * q)
                    c, s = half_c * half_c - half_s * half_s, ti.max(2.0 * half_s * half_c, _ALMOST_0)
                    angle = ti.max(angle_of(2.0 * half_s * half_c, c), _ALMOST_0)
                    other, v, x = at_row(ti.cast(row, ti.f64) / ti.cast(T.shape[2] - 1, ti.f64))
                    angle = ti.select(order == 1, 6.283185307179586 - angle, angle)
                    outward, along, _across = find_image(angle, other, u, w, v, x)
                    turned = angle_of(ti.sqrt(ti.max(1.0 - outward * outward, 0.0)), outward)
                    if order == 0:
                        apart = apart_of(c, other, u, w, v, x)
                        flat = ti.max(ti.sqrt(apart * apart + s * s), _NEARLY)
                        turned -= angle_of(s / flat, apart / flat)
                        along /= flat
                    T[order, 0, row, column], T[order, 1, row, column] = turned, along

    return kernel(fill, "f64")


def image_table(bending: Bending, u: float, w: float) -> np.ndarray:
    """The table of a camera at the place u, w: (2, 2, ROWS, COLUMNS) float64."""
    table = np.zeros((2, 2, ROWS, COLUMNS))
    _fill_kernel(bending)(u, w, table)
    return table


@ti.func
def _weights(f):
    """Lagrange's polynomials of the nodes 0, 1, 2, 3 at f."""
    a, b, c = f - 1.0, f - 2.0, f - 3.0
    return ti.Vector([-a * b * c / 6.0, f * b * c / 2.0, -f * a * c / 2.0, f * a * b / 6.0])


@ti.func
def _look_up(T: ti.template(), order, p, q):
    """(turned or direction, along) at the part p of the rows and the part q of the columns."""
    at, beside = p * ti.cast(T.shape[2] - 1, ti.f64), q * ti.cast(T.shape[3] - 1, ti.f64)
    row = ti.min(ti.max(ti.cast(at, ti.i32) - 1, 0), T.shape[2] - 4)
    column = ti.min(ti.max(ti.cast(beside, ti.i32) - 1, 0), T.shape[3] - 4)
    of_row, of_column = _weights(at - ti.cast(row, ti.f64)), _weights(beside - ti.cast(column, ti.f64))
    turned, along = 0.0, 0.0
    for i in ti.static(range(4)):
        for j in ti.static(range(4)):
            weight = of_row[i] * of_column[j]
            turned += weight * T[order, 0, row + i, column + j]
            along += weight * T[order, 1, row + i, column + j]
    return turned, along


@cache
def image_director(bending: Bending):
    """The function of kernels that finds the direction in which a camera sees a thing, and how large."""
    row_of, apart_of = bending.row_of, bending.apart

    @ti.func
    def image_direction(Q: ti.template(), T: ti.template(), n, other, order, v, x, size, towards, fixed):
        """(world direction, along, across, the order, the direction at the camera across the radial one) of the image of a thing.

        n, v, x : the thing's place; x = 0 is infinitely far
        other : 1 for a thing on the other side than the camera, 0 otherwise
        size : angle that it fills, as seen from the middle
        towards : where `fixed` is 1, the direction across the radial one in which the image's ray must set out; its order follows
        along and across are the widths at the thing of one radian of the picture in the plane of its ray and across it, by its r.
        """
        c, s, t, k = way_to(Q, n, order, towards, fixed)
        m = vector(Q, NORMAL)
        q = 0.5 * (n - m).norm() / (1.0 + 0.5 * (n + m).norm())
        turned, along = _look_up(T, k, row_of(other, v, x), q)
        outward, sine = cos(turned), sin(turned)
        if k == 0:
            apart = apart_of(c, other, Q[U], Q[W], v, x)
            flat = ti.max(ti.sqrt(apart * apart + s * s), _NEARLY)
            outward, sine = (apart * outward - s * sine) / flat, (s * outward + apart * sine) / flat
            along *= flat
        wide = s
        if (c < 0.0) | (k == 1):
            wide = ti.sqrt(s * s + size * size)
        along, sine = ti.max(along, _NEARLY), ti.max(sine, 0.0)
        aside = ti.Vector([vector(Q, TANGENTS + 3 * i).dot(t) for i in ti.static(range(3))])
        return vector(Q, OUTWARD) * outward + aside * sine, along, ti.select(sine < 1e-9, along, wide / sine), k, t

    return image_direction
