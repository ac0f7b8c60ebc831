"""Draws a sky under what a framebuffer holds: light += (1 - alpha) * sky, alpha = 1.

Stars and the sun's disc are added first, where nothing hides them, then the light of the sky's table, which lies before them.
An orthographic camera has one direction for all pixels, so it sees the sky as a perspective camera with its `fov` would.

    light of the disc at a share u of its radius    (1 + a / 2) (1 - u^2)^(a / 2) of its mean,  a = 0.292 / wavelength - 0.023
                                                    (wavelength in um), which is limb darkening
Source: Hestroffer, Magnan, Wavelength dependency of the solar limb darkening (1998).

The one-letter names in kernels are in docs/glossary.md.
"""

import math

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import power
from gen_art.renderer.daylight import DISC_ROWS
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.sky_table import sky_radiance
from gen_art.renderer.stars import add_stars

__all__ = ["draw_sky"]

PIXEL = ti.types.vector(4, ti.f32)
PIXELS = ti.types.ndarray(PIXEL, 1)
F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))

_LIMB = tuple(0.292 / wavelength - 0.023 for wavelength in (0.611, 0.549, 0.465))  # the middles of red, green and blue
_TO_RADIUS, _FEWEST, _MOST = 24.0, 4, 64  # samples to the radius of the disc, and across a pixel
NEAR_HORIZON = 0.02  # slope from the horizon, within which the table is read for each pixel
_EVEN, _LARGEST_GROUP = 0.005, 16  # rad over which light off the horizon is even enough to be interpolated; pixels


@ti.func
def _direction(axes: ti.template(), x, y):
    """The direction of the place (x, y) of the picture, right and up from its middle in units of slope."""
    return ti.Vector([axes[2, c] + x * axes[0, c] + y * axes[1, c] for c in ti.static(range(3))])


@ti.func
def _pixel_light(table: ti.template(), d, reach):
    """Light of a pixel with the direction d; where the horizon runs through it, the mean of the light above and below."""
    light = sky_radiance(table, d[0], d[1], d[2])
    above = d[1] / reach + 0.5
    if (above > 0.0) & (above < 1.0):
        upper = sky_radiance(table, d[0], ti.max(d[1], 0.0), d[2])
        lower = sky_radiance(table, d[0], ti.min(d[1], -1e-20), d[2])
        light = lower + (upper - lower) * above
    return light


@ti.kernel
def _sky(
    axes: F2, slope: ti.f32, width: ti.i32, height: ti.i32, stride: ti.i32, group: ti.i32, table: F3, framebuffer: PIXELS
):  # fmt: skip
    """The light of the table under all pixels.

    axes : right, up, forward
    slope : of a pixel's side
    group : pixels between which the light is interpolated, off the horizon
    """
    ti.loop_config(block_dim=4)
    for row in range(height):
        y = (0.5 * ti.cast(height, ti.f32) - ti.cast(row, ti.f32) - 0.5) * slope
        start = (0.5 - 0.5 * ti.cast(width, ti.f32)) * slope
        # how far a pixel's sides reach in height
        reach = slope * ti.max(ti.abs(axes[0, 1]), ti.abs(axes[1, 1])) + 1e-20
        d = _direction(axes, start, y)
        before = sky_radiance(table, d[0], d[1], d[2])
        for part in range((width + group - 1) // group):
            first = part * group
            e = _direction(axes, start + ti.cast(first + group, ti.f32) * slope, y)
            after = sky_radiance(table, e[0], e[1], e[2])
            even = (d[1] * e[1] > 0.0) & (ti.min(ti.abs(d[1]), ti.abs(e[1])) > NEAR_HORIZON)
            change = (after - before) / ti.cast(group, ti.f32)
            for column in range(first, ti.min(first + group, width)):
                pixel = framebuffer[row * stride + column]
                shown = ti.max(1.0 - pixel[3], 0.0)
                light = before + change * ti.cast(column - first, ti.f32)
                if (not even) & (shown > 0.0):
                    light = _pixel_light(table, _direction(axes, start + ti.cast(column, ti.f32) * slope, y), reach)
                pixel += PIXEL(light[0], light[1], light[2], 0.0) * shown
                pixel[3] = 1.0
                framebuffer[row * stride + column] = pixel
            d, before = e, after


@ti.kernel
def _disc(
    axes: F2, slope: ti.f32, width: ti.i32, height: ti.i32, stride: ti.i32, first: ti.i32, last: ti.i32, left: ti.i32,
    right: ti.i32, samples: ti.i32, sun: F1, light_at: F2, framebuffer: PIXELS,
):  # fmt: skip
    """The sun's disc, as means over samples x samples places of a pixel; the rim is soft over the distance of two of them.

    first, last, left, right : the rows and columns that the disc can reach
    sun : its direction and its radius
    light_at : light of the disc at each height
    """
    ti.loop_config(block_dim=1)
    for row in range(first, last):
        step = slope / ti.cast(samples, ti.f32)
        steep = ti.max(ti.sqrt(ti.max(1.0 - sun[1] * sun[1], 0.0)), 0.1)
        for column in range(left, right):
            total = ti.Vector([0.0, 0.0, 0.0])
            top = (0.5 * ti.cast(height, ti.f32) - ti.cast(row, ti.f32)) * slope
            side = (ti.cast(column, ti.f32) - 0.5 * ti.cast(width, ti.f32)) * slope
            for k in range(samples):
                y = top - (ti.cast(k, ti.f32) + 0.5) * step
                for m in range(samples):
                    x = side + (ti.cast(m, ti.f32) + 0.5) * step
                    d = _direction(axes, x, y)
                    d = d / ti.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
                    e = ti.Vector([d[c] - sun[c] for c in ti.static(range(3))])
                    distance = ti.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
                    inside = ti.min(ti.max((sun[3] - distance) / step + 0.5, 0.0), 1.0)
                    if inside > 0.0:
                        # the middle of that part of the sample's width which lies on the disc
                        u = 0.5 * (distance - 0.5 * step + ti.min(distance + 0.5 * step, sun[3])) / sun[3]
                        rim = ti.max(1.0 - u * u, 1e-6)
                        band = (e[1] / (steep * sun[3]) + 1.0) * ti.static(0.5 * (DISC_ROWS - 1))
                        band = ti.min(ti.max(band, 0.0), ti.static(DISC_ROWS - 1.001))
                        b = ti.cast(band, ti.i32)
                        part = band - ti.cast(b, ti.f32)
                        for c in ti.static(range(3)):
                            dark = ti.static(1.0 + 0.5 * _LIMB[c]) * power(rim, ti.static(0.5 * _LIMB[c]))
                            total[c] += inside * dark * (light_at[b, c] + (light_at[b + 1, c] - light_at[b, c]) * part)
            o = row * stride + column
            pixel = framebuffer[o]
            share = ti.max(1.0 - pixel[3], 0.0) / ti.cast(samples * samples, ti.f32)
            pixel += PIXEL(total[0], total[1], total[2], 0.0) * share
            framebuffer[o] = pixel


_sky_kernel, _disc_kernel = kernel(_sky), kernel(_disc)


def draw_sky(dome: SkyDome, view, framebuffer) -> None:
    """Draw a sky under what the framebuffer holds, whose alpha is 1 afterwards.

    view : a CameraView
    """
    scale = 0.5 * framebuffer.height / math.tan(math.radians(view.fov) / 2)  # pixels per unit of slope
    axes = np.ascontiguousarray(view.axes, np.float32)
    size = framebuffer.width, framebuffer.height, framebuffer.stride // 4
    pixels = framebuffer.buffer.reshape(-1, 4)
    if dome.stars is not None:
        add_stars(dome.stars, view.axes, scale, framebuffer.pixels)
    if dome.disc.any():
        _draw_disc(dome, view, scale, axes, size, pixels)
    group = min(max(int(_EVEN * scale), 1), _LARGEST_GROUP)
    _sky_kernel(axes, 1.0 / scale, *size, group, dome.table, pixels)


def _draw_disc(dome: SkyDome, view, scale: float, axes: np.ndarray, size, pixels: np.ndarray) -> None:
    width, height, _ = size
    assert dome.sun_direction is not None
    right, up, forward = (float(sum((dome.sun_direction * axis).tolist())) for axis in view.axes)
    if forward < 0.02:
        return
    reach = (
        1.1 * scale * dome.sun_radius / forward**2 + 1.0
    )  # the disc's radius in pixels, longest away from the middle
    column, row = 0.5 * width + scale * right / forward, 0.5 * height - scale * up / forward
    left, end = max(math.floor(column - reach), 0), min(math.ceil(column + reach), width)
    first, last = max(math.floor(row - reach), 0), min(math.ceil(row + reach), height)
    if left >= end or first >= last:
        return
    samples = min(max(math.ceil(_TO_RADIUS / (scale * dome.sun_radius)), _FEWEST), _MOST)
    sun = np.append(dome.sun_direction, dome.sun_radius).astype(np.float32)
    _disc_kernel(axes, 1.0 / scale, *size, first, last, left, end, samples, sun, dome.disc, pixels)
