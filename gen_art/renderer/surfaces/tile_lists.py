"""What matters in a tile of the picture: what its rays may meet, and what may hide light from its places.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.colliders.kinds import numbers_of
from gen_art.colliders.surface import to_start_frame
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.surfaces.collider_rays import cast_by, cone_contact, ray_in_start_frame
from gen_art.renderer.surfaces.collider_sets import with_collider
from gen_art.renderer.surfaces.lamp_shadows import SOLIDS_OF_TILE, shadow_cell
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS, ray_limits
from gen_art.renderer.surfaces.scene_numbers import (
    BIN_SHAPE,
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
from gen_art.renderer.surfaces.solids import BOUND, CENTER, NEVER, row_vector, solid_reaches_cone

__all__ = ["ball_of_tile", "colliders_in_tile", "covered_by", "solid_in_tile", "tile_casters"]

_CONE = 0.7072 * (TILE + 2)  # pixels: radius of the cone about a tile and the pixels around it
_RAYS = TILE * TILE * SUBPIXELS


@ti.func
def colliders_in_tile(kinds: ti.template(), scene: ti.template(), ox, oy):
    """The set of the colliders that rays through the tile at (ox, oy) and the pixels around it may meet."""
    N = ti.static(scene.N)
    o, d = _middle_of_tile(N, ox, oy)
    radius, tangent, low, high = 0.0, _CONE / N[SCALE], 0.0, NEVER
    if N[PARALLEL] > 0.5:
        radius, tangent = tangent, 0.0
        low, high = ray_limits(N, o, d)
    return _in_cone(kinds, scene, o + d * low, d, radius, tangent, high - low, ti.static(False))


@ti.func
def covered_by(kinds: ti.template(), among, owners: ti.template()):
    """(owner of all rays of a tile, or -1 where that is not known; 1 if it is flat).

    among : of colliders_in_tile; owners : of the middles of the tile's pixels and of those around them, of which the four in
        the corners are known: a convex solid, alone, that they meet on one face covers the tile
    """
    last = (TILE + 2) * (TILE + 2) - 1
    owner, alone, flat = owners[0], 0, 0
    for kind in ti.static(kinds):
        if ti.static(kind.collider.convex and kind.collider.sides == 1):
            for j in range(kind.count):
                if among == with_collider(ti.i64(0), kind.first + j):
                    alone, flat = 1, ti.static(int(kind.collider.flat))
    same = owner == owners[TILE + 1] and owner == owners[last - TILE - 1] and owner == owners[last]
    return ti.select(alone == 1 and same, owner, -1), flat


@ti.func
def solid_in_tile(scene: ti.template(), i, ox, oy):
    """Whether rays through the tile at (ox, oy) may meet a solid."""
    N = ti.static(scene.N)
    o, d = _middle_of_tile(N, ox, oy)
    radius, tangent, start = 0.0, _CONE / N[SCALE], 0.0
    if N[PARALLEL] > 0.5:
        radius, tangent, start = tangent, 0.0, -NEVER
    offset = row_vector(scene.B, i, CENTER) - o
    start = ti.max(start, offset.dot(d) - scene.B[i, BOUND])
    return solid_reaches_cone(scene.B, i, offset - d * start, d, tangent, radius + start * tangent, NEVER) > 0


@ti.func
def ball_of_tile(N: ti.template(), ox, oy, distance: ti.template(), owner: ti.template()):
    """(middle relative to the camera, radius) of a ball that holds all places that a tile's rays meet; -1 if they meet nothing.

    distance, owner : (64 SUBPIXELS,) of the rays
    """
    nearest, farthest = NEVER, -NEVER
    for r in range(_RAYS):
        if owner[r] >= 0:
            nearest, farthest = ti.min(nearest, distance[r]), ti.max(farthest, distance[r])
    o, d = _middle_of_tile(N, ox, oy)
    middle, radius = o, -1.0
    if farthest > -NEVER:
        across = _CONE / N[SCALE]
        if N[PARALLEL] < 0.5:
            across *= ti.max(farthest, 0.0)
        # a tenth and a tile more: rays through pixels' middles end elsewhere
        middle, radius = o + d * (0.5 * (nearest + farthest)), 0.6 * (farthest - nearest) + 2.0 * across
    return middle, radius


@ti.func
def tile_casters(kinds: ti.template(), scene: ti.template(), middle, radius, nearby: ti.template()):
    """What may hide light from places in the ball of a tile.

    (3,) i64: the sets of colliders that may hide the lamp, and the sky, and the number of solids in `nearby` (_tile_solids)
    """
    N = ti.static(scene.N)
    wide, to_lamp, sky = radius * (1.0 + N[LAMP_TANGENT]), vector_at(N, TO_LAMP), ti.i64(0)
    lamp = _in_cone(kinds, scene, middle, to_lamp, wide, N[LAMP_TANGENT], N[SHADOW_REACH], ti.static(True))
    if ti.static(scene.occluded):
        for kind in ti.static(kinds):
            if ti.static(cast_by(kind.collider)):
                for j in range(kind.count):
                    q, k = numbers_of(scene.Q, kind, j), kind.first + j
                    y, _, _ = to_start_frame(kind.collider, q, middle + vector_at(N, CAMERA), N[TIME])
                    if kind.collider.distance(y, q, 0) - radius < FARTHEST_OCCLUDER * scene.occluders[k, 0]:
                        sky = with_collider(sky, k)
    return ti.Vector([lamp, sky, ti.cast(_tile_solids(scene, middle, radius, nearby), ti.i64)])


@ti.func
def _tile_solids(scene: ti.template(), middle, radius, nearby: ti.template()):
    """List the solids that may hide the lamp from places in the ball of a tile.

    nearby : (SOLIDS_OF_TILE,) takes them
    Returns their number: -1 where they are more, or in more than four cells of ShadowBins.
    """
    N, B = ti.static(scene.N, scene.B)
    place, to_lamp, spread = middle + vector_at(N, CAMERA), vector_at(N, TO_LAMP), N[LAMP_TANGENT]
    first, last, wide = shadow_cell(N, place, -radius), shadow_cell(N, place, radius), radius * (1.0 + spread)
    count, cell, columns = 0, 0, ti.cast(N[BIN_SHAPE + 1], ti.i32)
    for c in ti.static(range(2)):
        first[c], last[c] = ti.max(first[c], 0), ti.min(last[c], ti.cast(N[BIN_SHAPE + c], ti.i32) - 1)
    if (last[0] - first[0]) > 1 or (last[1] - first[1]) > 1:
        count, cell = -1, 4
    while cell < 4:
        row, column = first[0] + (cell >> 1), first[1] + (cell & 1)
        cell += 1
        if row <= last[0] and column <= last[1]:
            k, end = scene.shadow_starts[row * columns + column], scene.shadow_starts[row * columns + column + 1]
            while k < end:
                i = scene.shadow_solids[k]
                k += 1
                offset = row_vector(B, i, CENTER) - middle
                along, reach = offset.dot(to_lamp), B[i, BOUND] + wide
                width = reach + ti.max(along, 0.0) * spread
                if along > -reach and offset.dot(offset) - along * along < width * width:
                    wanted = solid_reaches_cone(B, i, offset + to_lamp * wide, to_lamp, spread, wide, NEVER)
                    for other in range(count):
                        if nearby[other] == i:
                            wanted = 0
                    if wanted > 0:
                        if count < SOLIDS_OF_TILE:
                            nearby[count] = i
                            count += 1
                        else:
                            count, k, cell = -1, end, 4
    return count


@ti.func
def _middle_of_tile(N: ti.template(), ox, oy):
    return camera_ray(N, ti.cast(ox, ti.f32) + 0.5 * TILE, ti.cast(oy, ti.f32) + 0.5 * TILE)


@ti.func
def _in_cone(
    kinds: ti.template(), scene: ti.template(), origin, direction, radius, tangent, far, casters: ti.template()
):  # fmt: skip
    """The set of the colliders that a ray may enter, or pass through, that stays in a cone about this one.

    origin : relative to the camera; radius : of the cone there; tangent : by which it grows per length
    casters : whether only colliders count that cast shadows
    """
    N = ti.static(scene.N)
    result = ti.i64(0)
    for kind in ti.static(kinds):
        for j in range(kind.count):
            if ti.static(kind.collider.sides > 1):
                if ti.static(not casters):
                    result = with_collider(result, kind.first + j)
            elif ti.static(cast_by(kind.collider) or not casters):
                q = numbers_of(scene.Q, kind, j)
                o, d = ray_in_start_frame(kind.collider, q, origin + vector_at(N, CAMERA), direction, N[TIME])
                meets = cone_contact(kind.collider, q, o, d, radius, tangent, 0.0, far) < far
                if ti.static(kind.collider.convex and not casters):
                    # a ray that starts in a convex solid leaves it and does not come back
                    meets = meets and kind.collider.distance(o, q, 0) > -radius
                if meets:
                    result = with_collider(result, kind.first + j)
    return result
