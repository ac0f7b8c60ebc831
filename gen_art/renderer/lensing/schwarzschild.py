"""Rays of light past a black hole that does not turn, in closed form.

    ds^2 = -(1 - 1 / r) dt^2 + dr^2 / (1 - 1 / r) + r^2 dOmega^2

All lengths here are in units of the horizon's radius. A ray lies in a plane through the middle and keeps its impact parameter
b = r sin(angle to the radial direction, as one at rest there sees it) / sqrt(1 - 1 / r). With w = 1 / r,

    d(angle) / dw = 1 / sqrt(1 / b^2 - w^2 + w^3)

A ray that comes from afar with b < sqrt(27) / 2 ends at the horizon; one with more turns round at r > 3/2, and near that b it
winds round r = 3/2 without end. The cubic has a root w1 < 0 for every b; with it the others are those of

    w^2 - (1 - w1) w - w1 (1 - w1) = 0

two between 0 and 1 where the ray has a turning point, the smaller one there, and two conjugate ones where it has none. Between
two places y < x of one leg of the ray the angle is, by Carlson's R_F,

    2 (x - y) R_F(V12^2, V13^2, V23^2),    V12 = X1 X2 Y3 + Y1 Y2 X3 and so on,    Xi = sqrt(abs(x - wi)),  Yi = sqrt(abs(y - wi))

where V12^2 and V13^2 are conjugate for conjugate roots. Far out the deflection is 2 / b + 15 pi / (16 b^2).
Sources: Darwin, The gravity field of a particle, Proc. R. Soc. Lond. A 249 (1959); Luminet, Image of a spherical black hole with
thin accretion disk, Astron. Astrophys. 75 (1979); Carlson, A table of elliptic integrals: cubic cases, Math. Comp. 53 (1989).
"""

import math

from gen_art.backend.runtime import ti
from gen_art.maths.carlson import elliptic_rf, elliptic_rf_of_pair
from gen_art.renderer.lensing.image_solver import CAMERA_NEARER, NO_TURNING, THING_NEARER, image_finder
from gen_art.renderer.lensing.lens import CENTER, RADIUS_OF, Bending, vector

__all__ = ["EDGE", "SCHWARZSCHILD", "angle_between", "first_root", "ray_end", "turning_point"]

EDGE = math.sqrt(27.0) / 2.0
_CIRCLE = 2.0 / 3.0  # w at which light runs in a circle
_MOST_STEPS = 60


@ti.func
def _sine(w):
    """The sine of a ray's angle to the radial direction at w, by its b."""
    return w * ti.sqrt(ti.max(1.0 - w, 0.0))


@ti.func
def first_root(b):
    """The root below 0 of w^3 - w^2 + 1 / b^2, by Newton's method from -1 / b, which lies beyond it: every step comes nearer."""
    at = ti.max(b, 1e-12)  # a ray so near to the radial direction sweeps less than that
    root, last, steps = -1.0 / at, 1.0 + 0.0 * b, 0
    q = root * root
    while (last > 1e-9) & (steps < _MOST_STEPS):  # squared at every step
        step = (root * root * (root - 1.0) + q) / (root * (3.0 * root - 2.0))
        root -= step
        last = ti.abs(step / root)
        steps += 1
    return root


@ti.func
def _larger_root(root):
    return 0.5 * (1.0 - root + ti.sqrt(ti.max((1.0 - root) * (1.0 + 3.0 * root), 0.0)))


@ti.func
def turning_point(root):
    """w at which a ray with b > EDGE turns, by its `first_root`."""
    return -root * (1.0 - root) / _larger_root(root)


@ti.func
def angle_between(root, y, x):
    """The angle that a ray, given by its `first_root`, sweeps on one leg from w = y to w = x >= y."""
    tiny = 1e-290
    x1, y1 = ti.sqrt(x - root), ti.sqrt(y - root)
    factor = 0.0 * x
    if 1.0 + 3.0 * root >= 0.0:
        third = _larger_root(root)
        second = -root * (1.0 - root) / third
        x2, x3 = ti.sqrt(ti.max(second - x, 0.0)), ti.sqrt(ti.max(third - x, 0.0))
        y2, y3 = ti.sqrt(ti.max(second - y, 0.0)), ti.sqrt(ti.max(third - y, 0.0))
        v12, v13, v23 = x1 * x2 * y3 + y1 * y2 * x3, x1 * x3 * y2 + y1 * y3 * x2, x2 * x3 * y1 + y2 * y3 * x1
        factor = elliptic_rf(ti.max(v12 * v12, tiny), ti.max(v13 * v13, tiny), ti.max(v23 * v23, tiny))
    else:
        of_x = ti.sqrt(ti.max(x * x - (1.0 - root) * (x + root), 0.0))
        of_y = ti.sqrt(ti.max(y * y - (1.0 - root) * (y + root), 0.0))
        v23 = of_x * y1 + of_y * x1
        d2 = (x - y) * (x - y)
        square = ti.max(v23 * v23, tiny)
        imaginary = 0.5 * d2 * ti.sqrt(ti.max(-(1.0 - root) * (1.0 + 3.0 * root), 0.0))
        factor = elliptic_rf_of_pair(square - 0.5 * d2 * (1.0 - 3.0 * root), imaginary, square)
    return 2.0 * (x - y) * factor


@ti.func
def ray_end(b, inward, u, w):
    """(angle swept to infinity, 0, or 2 if the ray ends at the horizon) of a ray from w < 2/3. u is not needed.

    inward : 1 for a ray that sets out towards the black hole, 0 otherwise
    """
    angle, where = 0.0 * b, 0
    root = first_root(b)
    if inward == 0:
        angle = angle_between(root, 0.0 * w, w)
    elif 1.0 + 3.0 * root <= 0.0:
        where = 2
    else:
        turn = ti.max(turning_point(root), w)
        angle = angle_between(root, 0.0 * w, turn) + angle_between(root, w, turn)
    return angle, where


@ti.func
def _nearest(other, w, x):
    """1 / b of the ray that is tangential at the nearer of two places, or winds without end where the thing is within 3/2."""
    inner = ti.max(w, x)
    least, case = _sine(inner), ti.select(x <= w, CAMERA_NEARER, THING_NEARER)
    if inner >= _CIRCLE:
        least, case = 1.0 / EDGE + 0.0 * w, NO_TURNING
    return least, case


@ti.func
def _swept(b, turned, case, u, w, v, x):
    root, inner, outer = first_root(b), ti.max(w, x), ti.min(w, x)
    angle = 0.0 * w
    if turned == 1:
        turn = ti.max(turning_point(root), inner)
        angle = angle_between(root, inner, turn) + angle_between(root, outer, turn)
    else:
        angle = angle_between(root, outer, inner)
    return angle


_find_image = image_finder(_nearest, _swept, _sine, EDGE)


@ti.func
def _place_of(Q: ti.template(), p, far):
    d = (p - vector(Q, CENTER)) / Q[RADIUS_OF]
    r = ti.max(d.norm(), 1e-30)
    return d / r, 0.0, 1.0 / r


@ti.func
def _row_of(other, v, x):
    return ti.sqrt(x)


@ti.func
def _at_row(p):
    return 0, 0.0, p * p


@ti.func
def _apart(c, other, u, w, v, x):
    return c - 1.0 + (1.0 - x / w) / ti.sqrt(1.0 - w)


SCHWARZSCHILD = Bending(_place_of, _find_image, _row_of, _at_row, _apart, ray_end, _sine, edge=EDGE, horizon=True)
