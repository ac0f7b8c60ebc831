"""The rays of a pixel.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.scene_numbers import CLIP, FAR, FORWARD, NEAR, PARALLEL, first_distance, vector_at
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["FACETS", "SUBPIXELS", "ray_limits", "subpixel"]

SUBPIXELS = 4
FACETS = 4  # an owner of a ray is a surface, solid or triangle, times this, plus the facet that the ray meets


@ti.func
def subpixel(s):
    """The place of ray s in a pixel, on a rotated grid: no two of the rays share a row or a column."""
    return ti.Vector(
        [0.375 + 0.5 * ti.cast(s & 1, ti.f32) - 0.25 * ti.cast(s >> 1, ti.f32), 0.125 + 0.25 * ti.cast(s, ti.f32)]
    )


@ti.func
def ray_limits(N: ti.template(), o, d):
    """The distances along a ray between which the scene is drawn: the near and the far plane, and the plane of a mirror."""
    stretch = 1.0
    if N[PARALLEL] < 0.5:
        stretch = 1.0 / ti.max(d.dot(vector_at(N, FORWARD)), 1e-6)
    low = N[NEAR] * stretch
    if N[CLIP] ** 2 + N[CLIP + 1] ** 2 + N[CLIP + 2] ** 2 > 0.0:
        low = ti.max(low, first_distance(N, o, d))
    return low, ti.min(N[FAR] * stretch, NEVER)
