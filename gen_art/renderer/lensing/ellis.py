"""Rays of light through an Ellis wormhole, in closed form.

    ds^2 = -dt^2 + dl^2 + (l^2 + a^2) dOmega^2,    r = sqrt(l^2 + a^2)

l > 0 is one side, l < 0 the other, l = 0 the throat, a sphere of radius a. All lengths here are in units of a. A ray lies in a
plane through the middle and keeps its impact parameter b = r sin(angle to the radial direction), so

    d(angle) / dl = b / (r sqrt(r^2 - b^2))

A ray with b < 1 goes through the throat, one with b > 1 turns round at r = b. A place is given by u = l / r and w = 1 / r, with
u^2 + w^2 = 1, so that infinity is u = 1, w = 0. With Carlson's R_F the angle from the throat or the turning point to there is

    b < 1    b u R_F((1 - b^2) w^2, 1 - b^2, 1 - b^2 w^2)
    b > 1    sqrt(1 - b^2 w^2) R_F((b^2 - 1) w^2, 1 - 1 / b^2, u^2)

From infinity to infinity, a ray with b > 1 is deflected by 2 K(1 / b) - pi, far out by pi / (4 b^2).
Sources: Ellis, Ether flow through a drainhole, J. Math. Phys. 14 (1973); Chetouani, Clement, Geometrical optics in the Ellis
geometry, Gen. Relativ. Gravit. 16 (1984); Mueller, Visual appearance of a Morris-Thorne wormhole, Am. J. Phys. 72 (2004).
"""

from gen_art.backend.runtime import ti
from gen_art.maths.carlson import elliptic_rf
from gen_art.renderer.lensing.image_solver import CAMERA_NEARER, NO_TURNING, THING_NEARER, image_finder
from gen_art.renderer.lensing.lens import AXES, CENTER, RADIUS_OF, Bending, vector

__all__ = ["ELLIS", "angle_to", "ray_end"]


@ti.func
def angle_to(b, u, w):
    """The angle that a ray sweeps from the throat (b < 1) or from where it turns (b > 1) to the place u >= 0, w."""
    tiny = 1e-24  # b = 1 winds round the throat without end: so near to it, 28 rad
    cosine2 = ti.max(1.0 - b * b * w * w, 0.0)
    beyond = (b - 1.0) * (b + 1.0)
    angle = 0.0 * b
    if b < 1.0:
        left = ti.max(-beyond, tiny)
        angle = b * u * elliptic_rf(left * w * w, left, ti.max(cosine2, tiny))
    else:
        left = ti.max(beyond, tiny)
        angle = ti.sqrt(cosine2) * elliptic_rf(left * w * w, left / (b * b), ti.max(u * u, tiny))
    return angle


@ti.func
def ray_end(b, inward, u, w):
    """(angle swept to infinity, 1 if on the other side) of a ray from the place u >= 0, w.

    inward : 1 for a ray that sets out towards the throat, 0 otherwise
    """
    start, end = angle_to(b, u, w), angle_to(b, 1.0 + 0.0 * u, 0.0 * w)
    return ti.select(inward == 1, end + start, end - start), ti.select((inward == 1) & (b < 1.0), 1, 0)


@ti.func
def _sine(w):
    return w


@ti.func
def _nearest(other, w, x):
    """1 / b of the ray that is tangential at the nearer of two places, or at the throat for a thing beyond it."""
    least = ti.select(other == 1, 1.0, ti.max(w, x))
    return least, ti.select(other == 1, NO_TURNING, ti.select(x <= w, CAMERA_NEARER, THING_NEARER))


@ti.func
def _swept(b, turned, case, u, w, v, x):
    of_camera, of_thing = angle_to(b, u, w), angle_to(b, v, x)
    return ti.select((case == NO_TURNING) | (turned == 1), of_camera + of_thing, ti.abs(of_thing - of_camera))


_find_image = image_finder(_nearest, _swept, _sine, 1.0)


@ti.func
def _place_of(Q: ti.template(), p, far):
    d = (p - vector(Q, CENTER)) / Q[RADIUS_OF]
    x, y, z = d.dot(vector(Q, AXES)), d.dot(vector(Q, AXES + 3)), d.dot(vector(Q, AXES + 6))
    across2 = x * x + y * y
    excess = across2 + z * z - 1.0
    root = ti.sqrt(excess * excess + 4.0 * z * z)
    larger = 0.5 * (root + ti.abs(excess))
    smaller = z * z / ti.max(larger, 1e-300)
    l2, cosine2 = ti.select(excess > 0.0, larger, smaller), ti.select(excess > 0.0, smaller, larger)
    cosine2 = ti.min(cosine2, 1.0)
    cosine = ti.sqrt(cosine2)
    if ((far == 1) & (z > 0.0)) | ((far == 0) & (z < 0.0)):
        cosine = -cosine
    level = ti.sqrt(ti.max(1.0 - cosine2, 0.0)) / ti.sqrt(ti.max(across2, 1e-300))
    w = 1.0 / ti.sqrt(1.0 + l2)
    return ti.Vector([x * level, y * level, cosine]), ti.sqrt(l2) * w, w


@ti.func
def _row_of(other, v, x):
    """Even in 1 / r far out and in l at the throat: (1 + l / (1 + r)) / 2."""
    half = 0.5 * v / (1.0 + x)
    return ti.select(other == 1, 0.5 - half, 0.5 + half)


@ti.func
def _at_row(p):
    half = 2.0 * p - 1.0  # the tangent of half the angle whose tangent is l
    other = ti.select(half < 0.0, 1, 0)
    return other, ti.abs(2.0 * half / (1.0 + half * half)), (1.0 - half * half) / (1.0 + half * half)


@ti.func
def _apart(c, other, u, w, v, x):
    return c - 1.0 + ti.select(other == 1, -v, v) - u / ti.max(w, 1e-300) * x


ELLIS = Bending(_place_of, _find_image, _row_of, _at_row, _apart, ray_end, _sine, edge=1.0, horizon=False)
