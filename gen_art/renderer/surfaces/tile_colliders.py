"""Which colliders matter in a tile of the picture: those that its rays may meet, and those that may hide light from its places.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.colliders.surface import to_start_frame
from gen_art.renderer.surfaces.collider_rays import cast_by, cone_contact, ray_in_start_frame
from gen_art.renderer.surfaces.collider_sets import with_collider
from gen_art.renderer.surfaces.scene_numbers import (
    CAMERA,
    LAMP_TANGENT,
    PARALLEL,
    SCALE,
    SHADOW_REACH,
    TIME,
    TO_LAMP,
    camera_ray,
    vector_at,
)
from gen_art.renderer.surfaces.sky_occlusion import FARTHEST_OCCLUDER
from gen_art.renderer.surfaces.solids import NEVER
from gen_art.renderer.surfaces.tiles import SUBPIXELS, TILE, ray_limits

__all__ = ["colliders_in_tile", "tile_casters"]

_CONE = 0.7072 * (TILE + 2)  # pixels: radius of the cone about a tile and the pixels around it
_RAYS = TILE * TILE * SUBPIXELS


@ti.func
def colliders_in_tile(entries: ti.template(), scene: ti.template(), ox, oy):
    """The set of the colliders that rays through the tile at (ox, oy) and the pixels around it may meet."""
    N = ti.static(scene.N)
    o, d = _middle_of_tile(N, ox, oy)
    radius, tangent, low, high = 0.0, _CONE / N[SCALE], 0.0, NEVER
    if N[PARALLEL] > 0.5:
        radius, tangent = tangent, 0.0
        low, high = ray_limits(N, o, d)
    return _in_cone(entries, scene, o + d * low, d, radius, tangent, high - low, ti.static(False))


@ti.func
def tile_casters(entries: ti.template(), scene: ti.template(), ox, oy, distance: ti.template(), owner: ti.template()):
    """(2,) the sets of colliders that may hide the lamp, and the sky, from what the rays of a tile meet.

    distance, owner : (64 SUBPIXELS,) of the rays. A ball holds all places that they meet
    """
    N = ti.static(scene.N)
    nearest, farthest = NEVER, -NEVER
    for r in range(_RAYS):
        if owner[r] >= 0:
            nearest, farthest = ti.min(nearest, distance[r]), ti.max(farthest, distance[r])
    lamp, sky = ti.i64(0), ti.i64(0)
    if farthest > -NEVER:
        o, d = _middle_of_tile(N, ox, oy)
        across = _CONE / N[SCALE]
        if N[PARALLEL] < 0.5:
            across *= ti.max(farthest, 0.0)
        radius = (
            0.6 * (farthest - nearest) + 2.0 * across
        )  # a tenth and a tile more: rays through pixels' middles end elsewhere
        middle = o + d * (0.5 * (nearest + farthest))
        wide = radius * (1.0 + N[LAMP_TANGENT])
        to_lamp = vector_at(N, TO_LAMP)
        lamp = _in_cone(entries, scene, middle, to_lamp, wide, N[LAMP_TANGENT], N[SHADOW_REACH], ti.static(True))
        if ti.static(scene.occluded):
            for k, entry in ti.static(enumerate(entries)):
                if ti.static(cast_by(entry)):
                    q = parameters(scene.Q, entry.collider, entry.offset)
                    y, _, _ = to_start_frame(entry.collider, q, middle + vector_at(N, CAMERA), N[TIME])
                    if entry.collider.distance(y, q, 0) - radius < FARTHEST_OCCLUDER * scene.occluders[k, 0]:
                        sky = with_collider(sky, k)
    return ti.Vector([lamp, sky])


@ti.func
def _middle_of_tile(N: ti.template(), ox, oy):
    return camera_ray(N, ti.cast(ox, ti.f32) + 0.5 * TILE, ti.cast(oy, ti.f32) + 0.5 * TILE)


@ti.func
def _in_cone(
    entries: ti.template(), scene: ti.template(), origin, direction, radius, tangent, far, casters: ti.template()
):  # fmt: skip
    """The set of the colliders that a ray may enter, or pass through, that stays in a cone about this one.

    origin : relative to the camera; radius : of the cone there; tangent : by which it grows per length
    casters : whether only colliders count that cast shadows
    """
    N = ti.static(scene.N)
    result = ti.i64(0)
    for k, entry in ti.static(enumerate(entries)):
        if ti.static(entry.collider.sides > 1):
            if ti.static(not casters):
                result = with_collider(result, k)
        elif ti.static(cast_by(entry) or not casters):
            q = parameters(scene.Q, entry.collider, entry.offset)
            o, d = ray_in_start_frame(entry, q, origin + vector_at(N, CAMERA), direction, N[TIME])
            at_start, t = cone_contact(entry, q, o, d, radius, tangent, far)
            meets = t < far
            if ti.static(entry.collider.convex and not casters):
                # a ray that starts in a convex solid leaves it and does not come back
                meets = meets and at_start > -radius
            if meets:
                result = with_collider(result, k)
    return result
