"""Draws the skies of both sides of a wormhole under what a framebuffer holds: light += (1 - alpha) * sky, alpha = 1.

Each pixel is the light from where its ray ends, as radiance is kept along a ray. Near the rim, where rays with b = 1 wind
round the throat without end, a pixel is the mean of samples along the line to the wormhole's middle, which is the direction in
which the image of the sky is compressed. Stars are points: each has two images, whose light is its own times what the wormhole
magnifies.

The one-letter names in kernels are in docs/glossary.md.
"""

import math

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import cos, sin
from gen_art.renderer.lensing.geodesics import ray_end
from gen_art.renderer.lensing.particle_images import BLOCK, image_direction, lens_numbers
from gen_art.renderer.lensing.throat import Lens
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


@ti.func
def _vector(N: ti.template(), first: ti.template()):
    return ti.Vector([N[first], N[first + 1], N[first + 2]])


@ti.func
def _impact(N: ti.template(), d):
    """(b, whether the ray goes inwards, direction across the radial one in the axes of the throat) of the unit direction d."""
    across = ti.Vector([_vector(N, TANGENTS + 3 * i).dot(d) for i in ti.static(range(3))])
    sine = across.norm()
    return sine / N[W], ti.select(d.dot(_vector(N, OUTWARD)) < 0.0, 1, 0), across / ti.max(sine, 1e-30)


@ti.func
def _light(N: ti.template(), near: ti.template(), far: ti.template(), d):
    """Light of the sky that a ray along the unit direction d reaches."""
    b, inward, across = _impact(N, d)
    angle, other = ray_end(b, inward, N[U], N[W])
    n = _vector(N, NORMAL) * cos(angle) + across * sin(angle)
    beyond = ti.abs(other - ti.cast(N[FAR], ti.i32))
    if beyond == 1:
        n[2] = -n[2]
    e = ti.Vector([_vector(N, WORLD + 3 * i).dot(n) for i in ti.static(range(3))])
    light = ti.Vector([0.0, 0.0, 0.0])
    if beyond == 1:
        light = sky_radiance(far, e[0], e[1], e[2])
    else:
        light = sky_radiance(near, e[0], e[1], e[2])
    return light


@ti.kernel
def _sky(
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
                b, _inward, _across = _impact(N, d)
                # the angle to a ray's end grows by about d(alpha) / 2 * r / abs(b - 1) near b = 1
                blur = slope / N[W]
                samples = ti.cast(
                    ti.ceil(ti.min(0.5 * blur / ti.max(ti.abs(b - 1.0), 0.5 * blur) / _EVEN, 1.0 * _MOST)), ti.i32
                )
                middle = -_vector(N, OUTWARD)
                aside = middle - d * middle.dot(d)
                gx, gy = aside.dot(right), aside.dot(up)
                size = 1.0 / ti.max(ti.sqrt(gx * gx + gy * gy), 1e-20) * slope
                light = ti.Vector([0.0, 0.0, 0.0])
                for k in range(ti.max(samples, 1)):
                    s = ((ti.cast(k, ti.f32) + 0.5) / ti.cast(ti.max(samples, 1), ti.f32) - 0.5) * size
                    light += _light(N, near, far, (ahead + right * (x + gx * s) + up * (y + gy * s)).normalized())
                light *= shown / ti.cast(ti.max(samples, 1), ti.f32)
                pixel += PIXEL(light[0], light[1], light[2], 0.0)
            pixel[3] = 1.0
            framebuffer[o] = pixel


@ti.kernel
def _stars(directions: D2, other: ti.i32, order: ti.i32, Q: D1, found: D2):
    """Images of stars: found[i] is the direction in the world, and the factor on the light."""
    ti.loop_config(block_dim=1)
    for block in range((directions.shape[0] + BLOCK - 1) // BLOCK):
        for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, directions.shape[0])):
            n = ti.Vector([directions[i, 0], directions[i, 1], directions[i, 2]])
            d, along, across, _k, _t = image_direction(Q, n, other, order, 1.0, 0.0, _STAR, n, 0)
            for c in ti.static(range(3)):
                found[i, c] = d[c]
            found[i, 3] = 1.0 / ti.max(along * across, 1e-30)


_sky_kernel, _stars_kernel = kernel(_sky), kernel(_stars, "f64")


def lensed_stars(stars: StarField, lens: Lens, far: bool, order: int) -> StarField:
    """The images of stars of one side: order 0 the shorter way round the throat, order 1 the longer."""
    local = np.stack([np.sum(stars.directions * axis, axis=1) for axis in lens.axes], axis=1)
    if far:
        local[:, 2] *= -1.0
    found = np.zeros((len(local), 4))
    _stars_kernel(np.ascontiguousarray(local), int(far != lens.far), order, lens_numbers(lens), found)
    return StarField(found[:, :3], stars.light * found[:, 3:])


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
        lens.place.normal,
    )
    numbers[TANGENTS : TANGENTS + 9], numbers[WORLD : WORLD + 9] = lens.tangents.T.ravel(), lens.axes.T.ravel()
    tables = [NO_SKY if dome is None else dome.table for dome in (near, far)]
    axes = np.ascontiguousarray(view.axes, np.float32)
    size = framebuffer.width, framebuffer.height, framebuffer.stride // 4
    _sky_kernel(axes, 1.0 / scale, *size, numbers, *tables, framebuffer.buffer.reshape(-1, 4))
