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

from gen_art.backend.runtime import is_f64, ti
from gen_art.maths.carlson import elliptic_rf

__all__ = ["angle_to", "ray_end"]


@ti.func
def angle_to(b, u, w):
    """The angle that a ray sweeps from the throat (b < 1) or from where it turns (b > 1) to the place u >= 0, w."""
    tiny = ti.static(
        1e-24 if is_f64() else 1e-12
    )  # b = 1 winds round the throat without end: so near to it, 15 or 28 rad
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
