"""Which way to look to see a thing through bent light, and how large it looks there.

A camera at radius r_c sees a thing at radius r_p under the ray that sweeps the given angle in between. The rays are numbered by
tau, b = b_max sin(tau), where b_max belongs to the ray that is tangential at the nearer of the two, or to the ray that winds
round without end, where that one comes first: the swept angle grows with tau from 0 to infinity. At tau = pi/2 the ray is
tangential at the nearer of the two, and beyond it the ray passes a turning point. The root is found by regula falsi on
1 / (1 + angle), which is 0 where rays wind round without end.

How many units a thing is wide that is seen under one radian follows from neighbouring rays: in the plane of the ray
r_p cos(beta) d(angle)/d(alpha), where alpha and beta are the ray's angles to the radial direction at the camera and there; and
across it r_p sin(angle) / sin(alpha).
"""

from gen_art.backend.runtime import ti
from gen_art.maths.carlson import angle_of
from gen_art.maths.elementary import cos, sin

__all__ = ["CAMERA_NEARER", "NO_TURNING", "THING_NEARER", "image_finder"]

CAMERA_NEARER, THING_NEARER, NO_TURNING = 0, 1, 2
_MOST_STEPS = 60
_NEAR = 1e-9  # rad: a picture of 16384 pixels has 1e-5 rad a pixel
_STEP = 1e-4  # of tau, for its derivative
_HALF_PI = 1.5707963267948966


def image_finder(nearest, swept, sine, edge: float):
    """The function of kernels that finds an image.

    nearest : (other, w, x) -> (1 / b_max, CAMERA_NEARER, THING_NEARER or NO_TURNING)
    swept : (b, turned, case, u, w, v, x) -> the angle that a ray sweeps from the camera (u, w) to the thing (v, x); turned is 1
        for a ray that passes its turning point on the way
    sine : (w) -> the sine of a ray's angle to the radial direction at w, by its b
    edge : b of the rays that wind round without end
    """

    @ti.func
    def angle_at(tau, least, case, u, w, v, x):
        return swept(sin(tau) / least, ti.select(tau > _HALF_PI, 1, 0), case, u, w, v, x)

    @ti.func
    def find_image(angle, other, u, w, v, x):
        """(outward, along, across) of the image of a thing at an angle > 0 from the camera, seen from the middle.

        other : 1 for a thing on the other side of a throat, 0 otherwise
        u, w, v, x : places of the camera and of the thing, as the metric's rays have them
        Returns the cosine of the ray's angle to the direction away from the middle, and the widths at the thing of one radian of
        the picture in the plane of the ray and across it, both divided by the thing's r.
        """
        least, case = nearest(other, w, x)
        last = edge * least
        end = ti.select(
            case == NO_TURNING, _HALF_PI, 2.0 * _HALF_PI - angle_of(last, ti.sqrt(ti.max(1.0 - last * last, 0.0)))
        )
        aim = 1.0 / (1.0 + angle)
        low, high, at_low, at_high = 0.0 * angle, end, 1.0 - aim, -aim
        tau, error_of_angle, steps, side = 0.5 * end, 1.0, 0, 0
        while (error_of_angle > _NEAR) & (steps < _MOST_STEPS):
            tau = (low * at_high - high * at_low) / (at_high - at_low)
            angle_there = angle_at(tau, least, case, u, w, v, x)
            error_of_angle = ti.abs(angle_there - angle)
            error = 1.0 / (1.0 + angle_there) - aim
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
        b = sin(tau) / least
        place = ti.max(tau, 1e-3 * end)
        step = _STEP * ti.min(place, end - place)
        rate = angle_at(place + step, least, case, u, w, v, x) - angle_at(place - step, least, case, u, w, v, x)
        rate = ti.abs(rate) / ti.max(2.0 * step, 1e-300)
        of_camera, of_thing = sine(w), sine(x)
        # cosines of the ray's angles to the radial direction at the camera and at the thing
        inwards = ti.sqrt(ti.max(1.0 - b * b * of_camera * of_camera, 0.0))
        at_thing = ti.sqrt(ti.max(1.0 - b * b * of_thing * of_thing, 0.0))
        outward, along = -inwards, rate * inwards * ti.max(of_thing, 1e-300) / ti.max(of_camera, 1e-300)
        if case == NO_TURNING:
            along = rate * at_thing * inwards * least / (of_camera * ti.max(cos(tau), 1e-12))
        elif case == CAMERA_NEARER:
            outward, along = cos(tau), rate * at_thing
        across = sin(angle) / ti.max(b * of_camera, 1e-300)
        return outward, along, ti.select(b * of_camera < 1e-9, along, ti.abs(across))

    return find_image
