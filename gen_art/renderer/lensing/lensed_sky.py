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
from gen_art.renderer.lensing.lens import Bending, Lens, lens_numbers, vector
from gen_art.renderer.lensing.particle_images import BLOCK, FAINT
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
# numbers of the picture's lens (float32): u, w, far, then vectors
U, W, FAR, OUTWARD, NORMAL, TANGENTS, WORLD = 0, 1, 2, 3, 6, 9, 18


@cache
def _sky_kernel(bending: Bending):
    ray_end, sine, edge, winding = bending.ray_end, bending.sine, bending.edge, bending.winding

    @ti.func
    def impact(N: ti.template(), d):
        """(b, whether the ray goes inwards, direction across the radial one in the axes of the lens) of the unit direction d."""
        across = ti.Vector([vector(N, TANGENTS + 3 * i).dot(d) for i in ti.static(range(3))])
        norm = across.norm()
        return norm / sine(N[W]), ti.select(d.dot(vector(N, OUTWARD)) < 0.0, 1, 0), across / ti.max(norm, 1e-30)

    @ti.func
    def light_along(N: ti.template(), near: ti.template(), far: ti.template(), d):
        """Light of the sky that a ray along the unit direction d reaches."""
        b, inward, across = impact(N, d)
        angle, where = ray_end(b, inward, N[U], N[W])
        n = vector(N, NORMAL) * cos(angle) + across * sin(angle)
        beyond = ti.abs(where - ti.cast(N[FAR], ti.i32))
        if beyond == 1:
            n[2] = -n[2]
        e = ti.Vector([vector(N, WORLD + 3 * i).dot(n) for i in ti.static(range(3))])
        light = ti.Vector([0.0, 0.0, 0.0])
        if beyond == 1:
            light = sky_radiance(far, e[0], e[1], e[2])
        elif beyond == 0:
            light = sky_radiance(near, e[0], e[1], e[2])
        return light

    @ti.kernel
    def draw(
        axes: F2, slope: ti.f32, width: ti.i32, height: ti.i32, stride: ti.i32, N: F1, near: F3, far: F3, framebuffer: PIXELS
    ):  # fmt: skip
        """axes : right, up, forward; slope : of a pixel; near, far : tables of the two skies"""
        ti.loop_config(block_dim=1)
        for row in range(height):
            y = (0.5 * ti.cast(height, ti.f32) - ti.cast(row, ti.f32) - 0.5) * slope
            for column in range(width):
                o = row * stride + column
                pixel = framebuffer[o]
                shown = ti.max(1.0 - pixel[3], 0.0)
                if shown > 0.0:
                    x = (ti.cast(column, ti.f32) + 0.5 - 0.5 * ti.cast(width, ti.f32)) * slope
                    right = ti.Vector([axes[0, c] for c in ti.static(range(3))])
                    up = ti.Vector([axes[1, c] for c in ti.static(range(3))])
                    ahead = ti.Vector([axes[2, c] for c in ti.static(range(3))])
                    d = (ahead + right * x + up * y).normalized()
                    b, _inward, _across = impact(N, d)
                    # the angle to a ray's end grows by about winding * d(alpha) * r / abs(b - edge) near the edge
                    blur = winding * slope / sine(N[W])
                    samples = ti.cast(
                        ti.ceil(ti.min(blur / ti.max(ti.abs(b - edge), blur) / _EVEN, 1.0 * _MOST)), ti.i32
                    )
                    middle = -vector(N, OUTWARD)
                    aside = middle - d * middle.dot(d)
                    gx, gy = aside.dot(right), aside.dot(up)
                    size = 1.0 / ti.max(ti.sqrt(gx * gx + gy * gy), 1e-20) * slope
                    light = ti.Vector([0.0, 0.0, 0.0])
                    for k in range(ti.max(samples, 1)):
                        s = ((ti.cast(k, ti.f32) + 0.5) / ti.cast(ti.max(samples, 1), ti.f32) - 0.5) * size
                        light += light_along(
                            N, near, far, (ahead + right * (x + gx * s) + up * (y + gy * s)).normalized()
                        )
                    light *= shown / ti.cast(ti.max(samples, 1), ti.f32)
                    pixel += PIXEL(light[0], light[1], light[2], 0.0)
                pixel[3] = 1.0
                framebuffer[o] = pixel

    return kernel(draw)


@cache
def _stars_kernel(bending: Bending):
    image_direction = image_director(bending)

    @ti.kernel
    def stars(directions: D2, other: ti.i32, order: ti.i32, Q: D1, T: TABLE, found: D2):
        """Images of stars: found[i] is the direction in the world, and the factor on the light."""
        ti.loop_config(block_dim=1)
        for block in range((directions.shape[0] + BLOCK - 1) // BLOCK):
            for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, directions.shape[0])):
                n = ti.Vector([directions[i, 0], directions[i, 1], directions[i, 2]])
                d, along, across, _k, _t = image_direction(Q, T, n, other, order, 1.0, 0.0, _STAR, n, 0)
                for c in ti.static(range(3)):
                    found[i, c] = d[c]
                found[i, 3] = 1.0 / ti.max(along * across, 1e-30)

    return kernel(stars, "f64")


def lensed_stars(stars: StarField, lens: Lens, far: bool, order: int) -> StarField:
    """The images of stars of one side: order 0 the shorter way round the middle, order 1 the longer. Faint ones are left out."""
    local = np.stack([np.sum(stars.directions * axis, axis=1) for axis in lens.axes], axis=1)
    if far:
        local[:, 2] *= -1.0
    found = np.zeros((len(local), 4))
    _stars_kernel(lens.bending)(
        np.ascontiguousarray(local), int(far != lens.far), order, lens_numbers(lens), lens.table, found
    )
    bright = found[:, 3] * FAINT > 1.0
    return StarField(found[bright, :3], stars.light[bright] * found[bright, 3:])


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
    numbers = np.zeros(WORLD + 9, np.float32)
    numbers[U], numbers[W] = lens.uw
    numbers[FAR], numbers[OUTWARD : OUTWARD + 3], numbers[NORMAL : NORMAL + 3] = (
        lens.far,
        lens.outward,
        lens.normal,
    )
    numbers[TANGENTS : TANGENTS + 9], numbers[WORLD : WORLD + 9] = lens.tangents.T.ravel(), lens.axes.T.ravel()
    tables = [NO_SKY if dome is None else dome.table for dome in (near, far)]
    axes = np.ascontiguousarray(view.axes, np.float32)
    size = framebuffer.width, framebuffer.height, framebuffer.stride // 4
    _sky_kernel(lens.bending)(axes, 1.0 / scale, *size, numbers, *tables, framebuffer.buffer.reshape(-1, 4))
