"""The depths of a liquid's surface alone, where its light is not wanted: trails are hidden by them.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS
from gen_art.renderer.surfaces.scene_numbers import PARALLEL
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["put_depths"]

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))


@ti.kernel
def _put_depths(N: F1, U: F2, cover: F2, depths: F3, bounds: F3):
    """Put the liquid with the smoothed depths U into `depths` and their `bounds`, as drawing does (liquid_shading.py)."""
    ti.loop_config(block_dim=1)
    for tile in range(bounds.shape[0] * bounds.shape[1]):
        oy, ox = tile // bounds.shape[1] * TILE, tile % bounds.shape[1] * TILE
        nearest, farthest = NEVER, -NEVER
        for p in range(TILE * TILE):
            row, column = oy + p // TILE, ox + p % TILE
            if row < U.shape[0] and column < U.shape[1]:
                u = U[row, column]
                for s in range(SUBPIXELS):
                    if u < NEVER and (ti.cast(s, ti.f32) + 0.5) / SUBPIXELS < cover[row, column]:
                        z = ti.select(N[PARALLEL] > 0.5, u, 1.0 / u)
                        depths[row, column, s] = ti.min(depths[row, column, s], z)
                    nearest = ti.min(nearest, depths[row, column, s])
                    farthest = ti.max(farthest, depths[row, column, s])
        bounds[oy // TILE, ox // TILE, 0], bounds[oy // TILE, ox // TILE, 1] = nearest, farthest


put_depths = kernel(_put_depths)
