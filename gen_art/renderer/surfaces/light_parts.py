"""The light of surfaces in each pixel, in parts: its own, the lamp's, which smoke may dim, and what a mirror adds.

While the surfaces, the camera and the lights rest, the parts stay as they are: smoke that drifts before a house and particles
above a mirror then cost no rays. They are put together anew for each picture.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend.kernel_views import particle as arrays
from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS
from gen_art.renderer.surfaces.scene_numbers import CAMERA, ROWS, SMOKE_SHAPE, WIDTH, vector_at
from gen_art.renderer.surfaces.solids import NEVER
from gen_art.renderer.surfaces.surface_light import smoke_depth
from gen_art.renderer.surfaces.surface_shading import mirror_film_at
from gen_art.renderer.surfaces.tile_rays import depth_along, middle_ray

__all__ = ["MIRROR_PARTS", "OWN_PARTS", "LightParts"]

OWN_PARTS = 7  # of a pixel: own radiance, the lamp's, and coverage
MIRROR_PARTS = 14  # of a pixel: six factors of light_along, roughness, two normals of mirror_film_at, and depth

F1, F2, F3, I2 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.f32, 3), (ti.i32, 2)))


class LightParts:
    """The parts of the last picture of one size, and what they were drawn from.

    own : (rows, columns, OWN_PARTS)
    mirrored : (rows, columns, MIRROR_PARTS); of one pixel only where there is no mirror
    """

    def __init__(self, size: tuple[int, int], with_mirror: bool):
        self.with_mirror = with_mirror
        self.own = np.zeros((size[1], size[0], OWN_PARTS), np.float32)
        self.mirrored = np.zeros((*(self.own.shape[:2] if with_mirror else (1, 1)), MIRROR_PARTS), np.float32)
        self._drawn_from: tuple = ()

    def rest(self, terms, *given: np.ndarray) -> bool:
        """Whether these colliders and arrays are those of the last call, so that the parts are still right."""
        before, self._drawn_from = self._drawn_from, (terms, *given)
        if not before or before[0] != terms:
            return False
        return all(a is b or np.array_equal(a, b) for a, b in zip(before[1:], given))

    def forget(self) -> None:
        self._drawn_from = ()

    def put_together(self, numbers, smoke, film, blur, waves: bool, depths, bounds, framebuffer) -> None:
        """Write the light of the surfaces into a clear framebuffer.

        numbers : N, with the smoke's grid; smoke : its optical depths from the lamp; film, blur : what the mirror shows
        waves : whether images or waves lie on the surfaces; depths, bounds : of SurfacePass
        """
        _put_together(self.with_mirror, waves)(
            numbers, self.own, self.mirrored, smoke, film.texels, film.levels, blur, film.depths, depths, bounds,
            framebuffer.buffer, framebuffer.stride,
        )  # fmt: skip


@cache
def _put_together(with_mirror: bool, mapped: bool):
    @ti.kernel
    def put_together(
        N: F1, own: F3, mirrored: F3, smoke: F1, T: F2, levels: I2, G: F2, film_depths: F2, depths: F3, bounds: F3,
        framebuffer: F1, stride: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for tile in range(bounds.shape[0] * bounds.shape[1]):
            scene = arrays(N=N, smoke=smoke, T=T, levels=levels, G=G, film_depths=film_depths, mapped=mapped)
            oy, ox = tile // bounds.shape[1] * TILE, tile % bounds.shape[1] * TILE
            width, rows = ti.min(ti.cast(N[WIDTH], ti.i32) - ox, TILE), ti.min(ti.cast(N[ROWS], ti.i32) - oy, TILE)
            if bounds[oy // TILE, ox // TILE, 0] < NEVER:
                for row, column in ti.ndrange((oy, oy + rows), (ox, ox + width)):
                    lamp = ti.Vector([own[row, column, 3 + k] for k in range(3)])
                    if N[SMOKE_SHAPE] > 1.5 and lamp.max() > 0.0:
                        lamp *= _past_smoke(scene, depths, row, column)
                    for k in ti.static(range(3)):
                        framebuffer[row * stride + column * 4 + k] = own[row, column, k] + lamp[k]
                    framebuffer[row * stride + column * 4 + 3] = own[row, column, 6]
                    if ti.static(with_mirror):
                        _add_mirrored(scene, mirrored, row, column, framebuffer, row * stride + column * 4)

    return kernel(put_together)


@ti.func
def _past_smoke(scene: ti.template(), depths: ti.template(), row, column):
    """The share of the lamp's light that smoke lets through to what a pixel shows: the mean over its rays."""
    N = ti.static(scene.N)
    o, d = middle_ray(N, column, row)
    total, met, share, last = 0.0, 0.0, 0.0, NEVER
    for s in range(SUBPIXELS):
        depth = depths[row, column, s]
        if depth < NEVER:
            if depth != last:  # one surface in all rays has one depth
                place = o + d * (depth / depth_along(N, d, 1.0)) + vector_at(N, CAMERA)
                share, last = exp(-smoke_depth(N, scene.smoke, place)), depth
            total, met = total + share, met + 1.0
    return total / ti.max(met, 1.0)


@ti.func
def _add_mirrored(scene: ti.template(), mirrored: ti.template(), row, column, framebuffer: ti.template(), place):
    """Add to the framebuffer at `place` what the mirror shows in a pixel."""
    factors = ti.Vector([mirrored[row, column, k] for k in range(6)])
    if factors[0] + factors[1] + factors[2] > 0.0:
        rough, depth = mirrored[row, column, 6], mirrored[row, column, 13]
        normal = ti.Vector([mirrored[row, column, 7 + k] for k in range(3)])
        level = ti.Vector([mirrored[row, column, 10 + k] for k in range(3)])
        _, d = middle_ray(scene.N, column, row)
        film = mirror_film_at(scene, rough, level, normal, -d, column, row, depth)
        for k in ti.static(range(3)):
            framebuffer[place + k] += factors[k] * film[k] - factors[3 + k] * film[3]
