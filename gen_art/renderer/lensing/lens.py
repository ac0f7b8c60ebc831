"""What bends the light of one picture: where its camera stands, and how its directions become those of the lens."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gen_art.backend.runtime import ti

__all__ = [
    "AXES", "CAMERA", "CAMERA_FAR", "CENTER", "NORMAL", "OUTWARD", "RADIUS_OF", "TANGENTS", "U", "W", "Bending", "Lens",
    "lens_numbers", "vector", "way_to",
]  # fmt: skip

# numbers of the lens (float64)
CENTER, AXES, RADIUS_OF, U, W, CAMERA_FAR = 0, 3, 12, 13, 14, 15
NORMAL, OUTWARD, TANGENTS, CAMERA, ASIDE = 16, 19, 22, 31, 34
LENS_NUMBERS = 37


@dataclass(frozen=True, eq=False)
class Bending:
    """How a metric bends light, as functions for kernels.

    place_of : (Q, p, far) -> (direction from the middle in the axes of the lens, u, w) of a world position
    find_image : (angle, other, u, w, v, x) -> (outward, along, across), as `image_finder` makes it
    row_of, at_row : (other, v, x) -> the row of a place in the table of images, 0 to 1; and back
    apart : (c, other, u, w, v, x) -> how far outwards from the camera a thing at an angle of cosine c is, by the thing's r, in a
        flat space that is the true one near the camera
    ray_end : (b, inward, u, w) -> (angle swept to infinity, where: 0 on this side, 1 on the other one, 2 nowhere)
    sine : (w) -> the sine of a ray's angle to the radial direction at w, by its b
    edge : b of the rays that wind round without end
    horizon : whether what is within the radius cannot be seen
    """

    place_of: Any
    find_image: Any
    row_of: Any
    at_row: Any
    apart: Any
    ray_end: Any
    sine: Any
    edge: float
    horizon: bool


@dataclass(frozen=True, eq=False)
class Lens:
    """The lens of one picture. A place is given by its angles, u and w = 1 / r, in units of the radius.

    bending : of its metric
    radius : of the throat or the horizon, world units
    position : (3,) of the camera
    center : (3,) of the lens
    axes : (3, 3), rows: two directions and the axis of the lens
    uw : u and w of the camera
    far : whether the camera is on the other side
    normal : (3,) direction from the middle to the camera, in the axes of the lens
    outward : (3,) world direction at the camera away from the middle
    tangents : (3, 3) by which a direction across the radial one, in the axes of the lens, is multiplied to be one of the world
    aside : (3,) a direction across the radial one, in the axes of the lens
    table : where the camera sees things, as `image_table` makes it
    """

    bending: Bending
    radius: float
    position: np.ndarray
    center: np.ndarray
    axes: np.ndarray
    uw: tuple[float, float]
    far: bool
    normal: np.ndarray
    outward: np.ndarray
    tangents: np.ndarray
    aside: np.ndarray
    table: np.ndarray


def lens_numbers(lens: Lens) -> np.ndarray:
    """The numbers of a lens, as kernels read them."""
    q = np.zeros(LENS_NUMBERS)
    q[CENTER : CENTER + 3], q[AXES : AXES + 9], q[RADIUS_OF] = lens.center, lens.axes.ravel(), lens.radius
    q[U], q[W] = lens.uw
    q[CAMERA_FAR], q[NORMAL : NORMAL + 3], q[OUTWARD : OUTWARD + 3] = lens.far, lens.normal, lens.outward
    q[TANGENTS : TANGENTS + 9], q[CAMERA : CAMERA + 3] = lens.tangents.ravel(), lens.position
    q[ASIDE : ASIDE + 3] = lens.aside
    return q


@ti.func
def vector(Q: ti.template(), first: ti.template()):
    return ti.Vector([Q[first], Q[first + 1], Q[first + 2]])


@ti.func
def way_to(Q: ti.template(), n, order, towards, fixed):
    """(cosine and sine of the angle from the camera to a thing, seen from the middle, direction of its ray, order of the image).

    n : direction of the thing from the middle
    towards : where `fixed` is 1, the direction across the radial one in which the image's ray must set out; its order follows
    """
    m = vector(Q, NORMAL)
    c, cross = ti.min(ti.max(n.dot(m), -1.0), 1.0), m.cross(n)
    s = ti.min(cross.norm(), 1.0)
    t = vector(Q, ASIDE)
    if s > 1e-12:
        t = (n - m * c) / s
        t = t - m * t.dot(m)
        t = t / t.norm()
    k = order
    if (fixed == 1) & (c < 0.0):
        k = ti.select(t.dot(towards) < 0.0, 1, 0)
    if k == 1:
        t = -t
    return c, s, t, k
