"""Draws bent skies under what a framebuffer holds: light += (1 - alpha) * sky, alpha = 1.

Each pixel is the light from where its ray ends, as radiance is kept along a ray; one that ends at a horizon is black. Near the
rim, where rays wind round the middle without end, a pixel is the mean of samples along the line to the middle, which is the
direction in which the image of the sky is compressed. Stars are points: each has two images, whose light is its own times what
the lens magnifies.

The one-letter names in kernels are in docs/glossary.md.
"""

import math
from functools import cache

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import cos, sin
from gen_art.renderer.lensing.image_table import TABLE, image_director
from gen_art.renderer.lensing.lens import AXES, CAMERA_FAR, Bending, Lens, lens_numbers, vector
from gen_art.renderer.lensing.particle_images import BLOCK, FAINT
from gen_art.renderer.lensing.ray_table import ray_at, ray_number, ray_table
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.sky_table import ROWS, sky_radiance
from gen_art.renderer.stars import StarField, add_stars

__all__ = ["draw_lensed_sky", "lensed_stars"]

PIXEL = ti.types.vector(4, ti.f32)
PIXELS = ti.types.ndarray(PIXEL, 1)
F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
D1, D2 = ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.f64, 2)

_EVEN = 0.02  # rad of sky that one sample stands for
_MOST = 48  # samples of a pixel
_STAR = 1e-3  # rad: how large a star counts where its image would be a ring
NO_SKY = np.zeros((ROWS, 2, 3), np.float32)
# numbers of the picture's lens (float32): q of the edge, far, then vectors
EDGE, FAR, OUTWARD, START, AXIS, ASIDE, NUMBERS = 0, 1, 2, 5, 8, 11, 20


@cache
def _sky_kernel(horizon: bool):
    @ti.kernel
    def draw(
        axes: F2, slope: ti.f32, width: ti.i32, height: ti.i32, stride: ti.i32, N: F1, ends: F2, near: F3, far: F3,
        framebuffer: PIXELS,
    ):  # fmt: skip
        """axes : right, up, forward; slope : of a pixel; ends : of rays, a `ray_table`; near, far : tables of the two skies"""
        ti.loop_config(block_dim=1)
        for row in range(height):
            y = (0.5 * ti.cast(height, ti.f32) - ti.cast(row, ti.f32) - 0.5) * slope
            right = ti.Vector([axes[0, c] for c in ti.static(range(3))])
            level = ti.Vector([axes[1, c] * y + axes[2, c] for c in ti.static(range(3))])
            edge, here = N[EDGE], ti.cast(N[FAR], ti.i32)
            outward, start, axis = vector(N, OUTWARD), vector(N, START), vector(N, AXIS)
            aside = ti.Matrix([[N[ASIDE + 3 * i + j] for j in ti.static(range(3))] for i in ti.static(range(3))])
            for column in range(width):
                o = row * stride + column
                pixel = framebuffer[o]
                shown = ti.max(1.0 - pixel[3], 0.0)
                if shown > 0.0:
                    d = level + right * ((ti.cast(column, ti.f32) + 0.5 - 0.5 * ti.cast(width, ti.f32)) * slope)
                    per_length = 1.0 / d.norm()
                    across = aside @ d
                    sine = across.norm()
                    across /= ti.max(sine, 1e-30)
                    q, by_alpha = ray_number(-d.dot(outward) * per_length, sine * per_length)
                    size = by_alpha * per_length * slope  # of a pixel
                    _angle, change = ray_at(ends, q - edge)
                    samples = ti.max(ti.cast(ti.ceil(ti.min(ti.abs(change) * size / _EVEN, 1.0 * _MOST)), ti.i32), 1)
                    light = ti.Vector([0.0, 0.0, 0.0])
                    for k in range(samples):
                        x = q + ((ti.cast(k, ti.f32) + 0.5) / ti.cast(samples, ti.f32) - 0.5) * size - edge
                        angle, _change = ray_at(ends, x)
                        e = start * cos(angle) + across * sin(angle)
                        if ti.static(horizon):
                            if x >= 0.0:
                                light += sky_radiance(near, e[0], e[1], e[2])
                        else:
                            if ti.select(x < 0.0, 1 - here, here) == 1:
                                e -= axis * (2.0 * e.dot(axis))
                                light += sky_radiance(far, e[0], e[1], e[2])
                            else:
                                light += sky_radiance(near, e[0], e[1], e[2])
                    light *= shown / ti.cast(samples, ti.f32)
                    pixel += PIXEL(light[0], light[1], light[2], 0.0)
                pixel[3] = 1.0
                framebuffer[o] = pixel

    return kernel(draw)


@cache
def _stars_kernel(bending: Bending):
    image_direction = image_director(bending)

    @ti.kernel
    def stars(
        directions: D2, light: D2, far: ti.i32, order: ti.i32, Q: D1, T: TABLE, seen: D2, shown: D2
    ):  # fmt: skip
        """seen, shown : (n, 3) directions and light of the images, written"""
        ti.loop_config(block_dim=1)
        for block in range((directions.shape[0] + BLOCK - 1) // BLOCK):
            for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, directions.shape[0])):
                e = ti.Vector([directions[i, 0], directions[i, 1], directions[i, 2]])
                n = ti.Vector([vector(Q, AXES + 3 * c).dot(e) for c in ti.static(range(3))])
                if far == 1:
                    n[2] = -n[2]
                other = ti.abs(far - ti.cast(Q[CAMERA_FAR], ti.i32))
                d, along, across, _k, _t = image_direction(Q, T, n, other, order, 1.0, 0.0, _STAR, n, 0)
                magnified = 1.0 / ti.max(along * across, 1e-30)
                for c in ti.static(range(3)):
                    seen[i, c] = d[c]
                    shown[i, c] = light[i, c] * ti.select(magnified * FAINT > 1.0, magnified, 0.0)

    return kernel(stars, "f64")


def lensed_stars(stars: StarField, lens: Lens, far: bool, order: int) -> StarField:
    """The images of stars of one side: order 0 the shorter way round the middle, order 1 the longer. Faint ones are black."""
    seen, shown = np.zeros_like(stars.directions), np.zeros_like(stars.directions)
    _stars_kernel(lens.bending)(
        stars.directions, stars.light, int(far), order, lens_numbers(lens), lens.table, seen, shown
    )
    return StarField(seen, shown)


def draw_lensed_sky(near: SkyDome | None, far: SkyDome | None, lens: Lens, view, framebuffer) -> None:
    """Draw the skies of both sides under what the framebuffer holds, whose alpha is 1 afterwards.

    near, far : the skies of this side and the other; None is black
    view : a CameraView
    """
    scale = 0.5 * framebuffer.height / math.tan(math.radians(view.fov) / 2)  # pixels per unit of slope
    for dome, beyond in ((near, False), (far, True)):
        if dome is not None and dome.stars is not None:
            for order in (0, 1):
                add_stars(lensed_stars(dome.stars, lens, beyond, order), view.axes, scale, framebuffer.pixels)
    numbers = np.zeros(NUMBERS, np.float32)
    ends, numbers[EDGE] = ray_table(lens.bending, *lens.uw)
    numbers[FAR], numbers[OUTWARD : OUTWARD + 3], numbers[AXIS : AXIS + 3] = lens.far, lens.outward, lens.axes[2]
    numbers[START : START + 3] = lens.axes.T @ lens.normal
    numbers[ASIDE:] = (lens.axes.T @ lens.tangents.T).ravel()
    tables = [NO_SKY if dome is None else dome.table for dome in (near, far)]
    axes = np.ascontiguousarray(view.axes, np.float32)
    size = framebuffer.width, framebuffer.height, framebuffer.stride // 4
    _sky_kernel(lens.bending.horizon)(
        axes, 1.0 / scale, *size, numbers, ends, *tables, framebuffer.buffer.reshape(-1, 4)
    )
