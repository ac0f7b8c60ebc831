"""Where particles seem to be: positions at which, without the lens, they would look as they do through it.

A particle is moved along the ray under which it is seen to the distance at which it looks as large as it does through the
lens, D = sqrt(D_along D_across), of the widths at the particle of one radian of the picture in the plane of its ray and
across it.
So its sprite has the area of its image, and light as radiance is kept. Its velocity becomes what its image moves, over the time
that the shutter is open, so that a streak ends where its old end is seen.

An image of order 0 takes the shorter way round the middle, of order 1 the longer way, at the other side of it.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.particles.rows import PX, PY, PZ, RADIUS, VX, VY, VZ
from gen_art.renderer.lensing.image_table import TABLE, image_director
from gen_art.renderer.lensing.lens import (
    AXES,
    CAMERA,
    CAMERA_FAR,
    CENTER,
    RADIUS_OF,
    Bending,
    Lens,
    W,
    lens_numbers,
    vector,
)

__all__ = ["BLOCK", "FAINT", "particle_images"]

BLOCK = 512  # particles per iteration of the parallel loop
NOWHERE = 1e30  # a coordinate at which nothing is drawn
FAINT = 1000.0  # an image is left out where it would have less than this part of the light
SMALLEST = 1e-3  # rad, as seen from the middle: particles count as this large where the image of a point is a ring
SIDES = {"near": 0, "far": 1, "through": 2}

F64, D1 = ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.f64, 1)
STATE = ti.types.ndarray(ndim=2)


@cache
def _images_kernel(bending: Bending):
    place_of, image_direction = bending.place_of, image_director(bending)

    @ti.func
    def seen_at(Q: ti.template(), T: ti.template(), p, side, order, radius, towards, fixed):
        """(position at which a particle at p seems to be, the image's order, the direction in which its ray sets out)."""
        z = (p - vector(Q, CENTER)).dot(vector(Q, AXES + 6))
        far = 0
        if (side == 1) | ((side == 2) & (z < 0.0)):
            far = 1
        n, v, x = place_of(Q, p, far)
        other = ti.abs(far - ti.cast(Q[CAMERA_FAR], ti.i32))
        size = ti.max(radius / Q[RADIUS_OF] * x, SMALLEST)
        at, k, t = ti.Vector([NOWHERE, NOWHERE, NOWHERE]), order, ti.Vector([0.0, 0.0, 0.0])
        if (not ti.static(bending.horizon)) | (x < 1.0):
            d, along, across, k_seen, t_seen = image_direction(Q, T, n, other, order, v, x, size, towards, fixed)
            k, t = k_seen, t_seen
            distance = ti.sqrt(ti.max(along * across, 1e-24)) / x
            if (order == 0) | (distance * distance <= FAINT * (1.0 / (x * x) + 1.0 / (Q[W] * Q[W]))):
                at = vector(Q, CAMERA) + d * (distance * Q[RADIUS_OF])
        return at, k, t

    @ti.kernel
    def images(
        S: STATE, birth: F64, n: ti.i32, side: ti.i32, order: ti.i32, time: ti.f64, shutter: ti.f64, moving: ti.i32, Q: D1,
        T: TABLE, V: STATE,
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
                    head, k, t = seen_at(Q, T, p, side, order, radius, u, 0)
                    seen = head
                    lapse = ti.min(shutter, time - birth[i])
                    if (moving == 1) & (lapse > 0.0) & (head.norm() < NOWHERE):
                        v = ti.Vector([ti.cast(S[VX, i], ti.f64), ti.cast(S[VY, i], ti.f64), ti.cast(S[VZ, i], ti.f64)])
                        tail, _order, _towards = seen_at(Q, T, p - v * lapse, side, k, radius, t, 1)
                        if tail.norm() < NOWHERE:
                            u = (head - tail) / lapse
                for c in ti.static(range(3)):
                    V[PX + c, i], V[VX + c, i] = seen[c], u[c]

    return kernel(images, "f64")


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
        _images_kernel(lens.bending)(
            system.floats, system.birth, n, SIDES[side], order, time, shutter, int(moving), numbers, lens.table, seen
        )
    return seen
