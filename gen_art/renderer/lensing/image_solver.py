"""Which way to look to see a thing through a wormhole, and how large it looks there.

A camera at radius r_c sees a thing at radius r_p under the ray that sweeps the given angle in between. With R the smaller of
r_c and r_p, and 1 where the thing is on the other side, the rays are numbered by tau, b = R sin(tau): the swept angle grows with
tau from 0 to infinity. At tau = pi/2 the ray is tangential at the nearer of the two, and beyond it the ray passes a turning
point. The root is found by regula falsi on 1 / (1 + angle), which is 0 where rays wind round the throat without end.

How many units a thing is wide that is seen under one radian follows from neighbouring rays: in the plane of the ray
r_p cos(beta) d(angle)/d(alpha), where alpha and beta are the ray's angles to the radial direction at the camera and there; and
across it r_p sin(angle) / sin(alpha).
"""

from gen_art.backend.runtime import ti
from gen_art.maths.carlson import angle_of
from gen_art.maths.elementary import cos, sin
from gen_art.renderer.lensing.geodesics import angle_to

__all__ = ["find_image"]

_MOST_STEPS = 60
_NEAR = 1e-9  # rad: a picture of 16384 pixels has 1e-5 rad a pixel
_STEP = 1e-4  # of tau, for its derivative
_HALF_PI = 1.5707963267948966


@ti.func
def _swept(tau, other, u, w, v, x, nearer):
    """The angle that ray `tau` sweeps from the camera (u, w) to the thing (v, x)."""
    b = sin(tau) / nearer
    of_camera, of_thing = angle_to(b, u, w), angle_to(b, v, x)
    return ti.select((other == 1) | (tau > _HALF_PI), of_camera + of_thing, ti.abs(of_thing - of_camera))


@ti.func
def find_image(angle, other, u, w, v, x):
    """(outward, along, across) of the image of a thing at an angle > 0 from the camera, seen from the middle.

    other : 1 for a thing on the other side of the throat, 0 otherwise
    u, w, v, x : places of the camera and of the thing, as gen_art/renderer/lensing/geodesics.py has them, u and v >= 0
    Returns the cosine of the ray's angle to the direction away from the throat, and the widths at the thing of one radian of the
    picture in the plane of the ray and across it, both divided by the thing's r.
    """
    nearer = ti.select(other == 1, 1.0, ti.max(w, x))
    end = ti.select(
        other == 1, _HALF_PI, 2.0 * _HALF_PI - angle_of(nearer, ti.sqrt(ti.max(1.0 - nearer * nearer, 0.0)))
    )
    aim = 1.0 / (1.0 + angle)
    low, high, at_low, at_high = 0.0 * angle, end, 1.0 - aim, -aim
    tau, error_of_angle, steps, side = 0.5 * end, 1.0, 0, 0
    while (error_of_angle > _NEAR) & (steps < _MOST_STEPS):
        tau = (low * at_high - high * at_low) / (at_high - at_low)
        swept = _swept(tau, other, u, w, v, x, nearer)
        error_of_angle = ti.abs(swept - angle)
        error = 1.0 / (1.0 + swept) - aim
        # the Illinois rule: an end that stays twice counts half
        if error > 0.0:
            low, at_low = tau, error
            if side > 0:
                at_high *= 0.5
            side = 1
        else:
            high, at_high = tau, error
            if side < 0:
                at_low *= 0.5
            side = -1
        steps += 1
    b = sin(tau) / nearer
    place = ti.max(tau, 1e-3 * end)
    step = _STEP * ti.min(place, end - place)
    rate = _swept(place + step, other, u, w, v, x, nearer) - _swept(place - step, other, u, w, v, x, nearer)
    rate = ti.abs(rate) / ti.max(2.0 * step, 1e-300)
    inwards = ti.sqrt(
        ti.max(1.0 - b * b * w * w, 0.0)
    )  # cosine of the ray's angle to the radial direction at the camera
    at_thing = ti.sqrt(ti.max(1.0 - b * b * x * x, 0.0))
    outward, along = -inwards, rate * inwards * ti.max(x, 1e-300) / ti.max(w, 1e-300)
    if other == 1:
        along = rate * at_thing * inwards / (w * ti.max(cos(tau), 1e-12))
    elif x <= w:
        outward, along = cos(tau), rate * at_thing
    across = sin(angle) / ti.max(b * w, 1e-300)
    return outward, along, ti.select(b * w < 1e-9, along, ti.abs(across))
