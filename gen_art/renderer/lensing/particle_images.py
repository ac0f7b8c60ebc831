"""Where particles seem to be: positions at which, without the wormhole, they would look as they do through it.

A particle is moved along the ray under which it is seen to the distance at which it looks as large as it does through the
wormhole, D = sqrt(D_along D_across), of the widths at the particle of one radian of the picture in the plane of its ray and
across it.
So its sprite has the area of its image, and light as radiance is kept. Its velocity becomes what its image moves, over the time
that the shutter is open, so that a streak ends where its old end is seen.

An image of order 0 takes the shorter way round the throat, of order 1 the longer way, at the other side of it.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.carlson import angle_of
from gen_art.particles.rows import PX, PY, PZ, RADIUS, VX, VY, VZ
from gen_art.renderer.lensing.image_solver import find_image
from gen_art.renderer.lensing.throat import Lens

__all__ = ["LENS_NUMBERS", "image_direction", "lens_numbers", "particle_images", "place_of"]

BLOCK = 512  # particles per iteration of the parallel loop
NOWHERE = 1e30  # a coordinate at which nothing is drawn
FAINT = 1000.0  # an image of order 1 is left out where it would have less than this part of the light
SMALLEST = 1e-3  # rad, as seen from the middle: particles count as this large where the image of a point is a ring
# numbers of the lens (float64)
CENTER, AXES, RADIUS_OF, U, W, CAMERA_FAR, NORMAL, OUTWARD, TANGENTS, CAMERA, ANY = (
    0,
    3,
    12,
    13,
    14,
    15,
    16,
    19,
    22,
    31,
    34,
)
LENS_NUMBERS = 37
SIDES = {"near": 0, "far": 1, "through": 2}

F64, D1 = ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.f64, 1)
STATE = ti.types.ndarray(ndim=2)


def lens_numbers(lens: Lens) -> np.ndarray:
    """The numbers of a lens, as kernels read them."""
    q = np.zeros(LENS_NUMBERS)
    q[CENTER : CENTER + 3], q[AXES : AXES + 9], q[RADIUS_OF] = lens.center, lens.axes.ravel(), lens.radius
    q[U], q[W] = lens.uw
    q[CAMERA_FAR], q[NORMAL : NORMAL + 3], q[OUTWARD : OUTWARD + 3] = lens.far, lens.place.normal, lens.outward
    q[TANGENTS : TANGENTS + 9], q[CAMERA : CAMERA + 3] = lens.tangents.ravel(), lens.position
    q[ANY : ANY + 3] = lens.place.sphere[1]
    return q


@ti.func
def _vector(Q: ti.template(), first: ti.template()):
    return ti.Vector([Q[first], Q[first + 1], Q[first + 2]])


@ti.func
def place_of(Q: ti.template(), p, far):
    """(direction from the middle in the axes of the throat, u, w) of a world position on one of the sides."""
    d = (p - _vector(Q, CENTER)) / Q[RADIUS_OF]
    x, y, z = d.dot(_vector(Q, AXES)), d.dot(_vector(Q, AXES + 3)), d.dot(_vector(Q, AXES + 6))
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
def image_direction(Q: ti.template(), n, other, order, v, x, size, towards, fixed):
    """(world direction, D / r, the order, the direction at the camera across the radial one) of the image of a thing.

    n, v, x : the thing's place; v = 1, x = 0 is infinitely far
    other : 1 for a thing on the other side than the camera, 0 otherwise
    size : angle that it fills, as seen from the middle
    towards : where `fixed` is 1, the direction across the radial one in which the image's ray must set out; its order follows
    """
    m = _vector(Q, NORMAL)
    c, cross = ti.min(ti.max(n.dot(m), -1.0), 1.0), m.cross(n)
    s = ti.min(cross.norm(), 1.0)
    angle = angle_of(s, c)
    t = _vector(Q, ANY)
    if s > 1e-12:
        t = (n - m * c) / s
        t = t - m * t.dot(m)
        t = t / t.norm()
    k = order
    if (fixed == 1) & (c < 0.0):
        k = ti.select(t.dot(towards) < 0.0, 1, 0)
    if k == 1:
        t, angle = -t, 6.283185307179586 - angle
    outward, along, across = find_image(angle, other, Q[U], Q[W], v, x)
    if (c < 0.0) | (k == 1):
        across *= ti.sqrt(s * s + size * size) / ti.max(s, 1e-300)
    sine = ti.sqrt(ti.max(1.0 - outward * outward, 0.0))
    q = ti.Vector([_vector(Q, TANGENTS + 3 * i).dot(t) for i in ti.static(range(3))])
    return _vector(Q, OUTWARD) * outward + q * sine, along, across, k, t


@ti.func
def _seen(Q: ti.template(), p, side, order, radius, towards, fixed):
    """(position at which a particle at p seems to be, the image's order, the direction in which its ray sets out)."""
    z = (p - _vector(Q, CENTER)).dot(_vector(Q, AXES + 6))
    far = 0
    if (side == 1) | ((side == 2) & (z < 0.0)):
        far = 1
    n, v, x = place_of(Q, p, far)
    other = ti.abs(far - ti.cast(Q[CAMERA_FAR], ti.i32))
    size = ti.max(radius / Q[RADIUS_OF] * x, SMALLEST)
    d, along, across, k, t = image_direction(Q, n, other, order, v, x, size, towards, fixed)
    distance = ti.sqrt(ti.max(along * across, 1e-24)) / x
    at = _vector(Q, CAMERA) + d * (distance * Q[RADIUS_OF])
    if (order == 1) & (distance * distance > FAINT * (1.0 / (x * x) + 1.0 / (Q[W] * Q[W]))):
        at = ti.Vector([NOWHERE, NOWHERE, NOWHERE])
    return at, k, t


@ti.kernel
def _images(
    S: STATE, birth: F64, n: ti.i32, side: ti.i32, order: ti.i32, time: ti.f64, shutter: ti.f64, moving: ti.i32, Q: D1,
    V: STATE,
):  # fmt: skip
    """V : (6, capacity) apparent positions and velocities, written."""
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, n)):
            p = ti.Vector([ti.cast(S[PX, i], ti.f64), ti.cast(S[PY, i], ti.f64), ti.cast(S[PZ, i], ti.f64)])
            radius = ti.cast(S[RADIUS, i], ti.f64)
            shown = ti.abs(p[0]) + ti.abs(p[1]) + ti.abs(p[2]) < NOWHERE
            seen, u = ti.Vector([NOWHERE, NOWHERE, NOWHERE]), ti.Vector([0.0, 0.0, 0.0])
            if shown & (birth[i] <= time):
                head, k, t = _seen(Q, p, side, order, radius, u, 0)
                seen = head
                lapse = ti.min(shutter, time - birth[i])
                if (moving == 1) & (lapse > 0.0) & (head.norm() < NOWHERE):
                    v = ti.Vector([ti.cast(S[VX, i], ti.f64), ti.cast(S[VY, i], ti.f64), ti.cast(S[VZ, i], ti.f64)])
                    tail, _order, _towards = _seen(Q, p - v * lapse, side, k, radius, t, 1)
                    if tail.norm() < NOWHERE:
                        u = (head - tail) / lapse
            for c in ti.static(range(3)):
                V[PX + c, i], V[VX + c, i] = seen[c], u[c]


_images_kernel = kernel(_images, "f64")


def particle_images(system, lens: Lens, side: str, order: int, time: float, shutter: float, moving: bool) -> np.ndarray:
    """(6, capacity) apparent positions and velocities of a system's particles at simulated time `time`.

    side : `near`, `far`, or `through` for particles that are on the other side where they are behind the disc
    order : of the images, 0 or 1
    shutter : simulated seconds that a streak covers
    moving : whether the velocities are needed; they are 0 otherwise
    """
    seen = np.zeros((6, system.floats.shape[1]), system.floats.dtype)
    n = int(system.count)
    if n:
        numbers = lens_numbers(lens)
        _images_kernel(system.floats, system.birth, n, SIDES[side], order, time, shutter, int(moving), numbers, seen)
    return seen
