"""What the rays of a tile of the picture meet: colliders, then solids that are nearer.

A ray of a pixel is number `pixel * SUBPIXELS + s` of its tile; `distance` and `owner` hold what each ray meets.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from gen_art.backend.runtime import ti
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.surfaces.collider_rays import first_hit
from gen_art.renderer.surfaces.pixel_rays import FACETS, SUBPIXELS, ray_limits, subpixel
from gen_art.renderer.surfaces.ray_tree import shows_edges
from gen_art.renderer.surfaces.scene_numbers import CAMERA, FORWARD, PARALLEL, SCALE, TIME, camera_ray, vector_at
from gen_art.renderer.surfaces.solids import NEVER, solid_facet, solid_hit
from gen_art.renderer.surfaces.tile_lists import colliders_in_tile, covered_by, solid_in_tile

__all__ = [
    "box_in_tile",
    "depth_along",
    "middle_ray",
    "not_empty",
    "solid_distance",
    "subpixel_ray",
    "trace_colliders",
    "trace_solids",
]

_RAYS, _SIDE = TILE * TILE * SUBPIXELS, TILE + 2  # of a tile; pixels along a tile with a border of one pixel around it
_WITH_BORDER, _CORNERS = _SIDE * _SIDE, 4


@ti.func
def subpixel_ray(N: ti.template(), column, row, s):
    """Origin and direction of ray s of a pixel."""
    place = subpixel(s)
    return camera_ray(N, ti.cast(column, ti.f32) + place[0], ti.cast(row, ti.f32) + place[1])


@ti.func
def middle_ray(N: ti.template(), column, row):
    """(origin, direction) of the ray through the middle of a pixel."""
    return camera_ray(N, ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5)


@ti.func
def depth_along(N: ti.template(), d, t):
    """The distance along the line of sight of a place at distance t along a ray."""
    result = t
    if N[PARALLEL] < 0.5:
        result = t * d.dot(vector_at(N, FORWARD))
    return result


@ti.func
def _collider_hit(kinds: ti.template(), scene: ti.template(), among, o, d):
    """(distance along a ray, owner) of the nearest of some colliders, or (NEVER, -1); exact to 1/250 of a pixel."""
    N = ti.static(scene.N)
    per_length, tolerance = 0.0, 0.004 / N[SCALE]
    if N[PARALLEL] < 0.5:
        per_length, tolerance = tolerance, 1e-7
    low, high = ray_limits(N, o, d)
    t, surface, facet = first_hit(
        kinds, scene.Q, o + vector_at(N, CAMERA), d, N[TIME], low, high, tolerance, per_length, among
    )
    owner = surface * FACETS + facet
    if surface < 0:
        t, owner = NEVER, -1
    return t, owner


@ti.func
def _fill_with_face(
    N: ti.template(), ox, oy, covering, middle_t: ti.template(), distance: ti.template(), owner: ti.template()
):
    """Fill a tile's rays with a flat face that covers it.

    middle_t : distances through the middles of the pixels of the tile and around it, of which the four in the corners are known
    The reciprocal of the distance along the line of sight is linear in the picture; without perspective that distance is.
    """
    at_corners, last = ti.Vector([0.0] * 4), _SIDE - 1
    for corner in ti.static(range(4)):
        column, row = last * (corner & 1), last * (corner >> 1)
        _, d = middle_ray(N, ox + column - 1, oy + row - 1)
        depth = depth_along(N, d, middle_t[row * _SIDE + column])
        at_corners[corner] = ti.select(N[PARALLEL] > 0.5, depth, 1.0 / depth)
    for p in range(TILE * TILE):
        across, down = (p % TILE + 1.0) / last, (p // TILE + 1.0) / last
        at = at_corners[0] + (at_corners[1] - at_corners[0]) * across + (at_corners[2] - at_corners[0]) * down
        at += (at_corners[3] - at_corners[1] - at_corners[2] + at_corners[0]) * across * down
        t = at
        if N[PARALLEL] < 0.5:
            _, d = middle_ray(N, ox + p % TILE, oy + p // TILE)
            t = 1.0 / (at * d.dot(vector_at(N, FORWARD)))
        for s in range(SUBPIXELS):
            distance[p * SUBPIXELS + s], owner[p * SUBPIXELS + s] = t, covering


@ti.func
def trace_colliders(
    kinds: ti.template(), surfaces: ti.template(), follows: ti.template(), scene: ti.template(), ox, oy,
    distance: ti.template(), owner: ti.template(),
):  # fmt: skip
    """Fill a tile's rays, which meet nothing so far, with the nearest colliders.

    One ray a pixel first, with a border of a pixel around the tile; all rays only where these meet different surfaces, or one
    that shows others sharply.
    Returns the owner that all rays meet, or -1 where that is not known.
    """
    among, covering = colliders_in_tile(kinds, scene, ox, oy), -1
    if among != 0:
        covering = _trace_among(kinds, surfaces, follows, scene, among, ox, oy, distance, owner)
    return covering


@ti.func
def _trace_among(
    kinds: ti.template(), surfaces: ti.template(), follows: ti.template(), scene: ti.template(), among, ox, oy,
    distance: ti.template(), owner: ti.template(),
):  # fmt: skip
    """Trace a tile's rays to the colliders of the set `among`, as trace_colliders does to all."""
    N = ti.static(scene.N)
    middle_t, middle_owner, differ = ti.Vector([NEVER] * _WITH_BORDER), ti.Vector([-1] * _WITH_BORDER), 0
    k, end, covering = -_CORNERS, _WITH_BORDER + _RAYS, -1
    while k < end:  # one loop, so that a collider is compiled once
        r = k - _WITH_BORDER
        p = r // SUBPIXELS
        here, again = (p // TILE + 1) * _SIDE + p % TILE + 1, 1
        o, d = vector_at(N, CAMERA), vector_at(N, CAMERA)
        if r < 0:
            here = k
            if k < 0:
                here = (k & 1) * (_SIDE - 1) + ((k >> 1) & 1) * (_WITH_BORDER - _SIDE)
            elif covering >= 0:
                here = (k // TILE + 1) * _SIDE + k % TILE + 1
            o, d = middle_ray(N, ox + here % _SIDE - 1, oy + here // _SIDE - 1)
        else:
            if r % SUBPIXELS == 0:
                again = 0
                if differ == 1:
                    for beside in range(9):
                        if middle_owner[here + (beside // 3 - 1) * _SIDE + beside % 3 - 1] != middle_owner[here]:
                            again = 1
                if ti.static(follows):
                    again |= shows_edges(surfaces, scene, middle_owner[here] // FACETS)
            if again == 1:
                o, d = subpixel_ray(N, ox + p % TILE, oy + p // TILE, r % SUBPIXELS)
        if again == 1:
            t, who = _collider_hit(kinds, scene, among, o, d)
            if r >= 0:
                distance[r], owner[r] = t, who
            elif covering >= 0:
                for s in range(SUBPIXELS):
                    distance[k * SUBPIXELS + s], owner[k * SUBPIXELS + s] = t, who
            else:
                middle_t[here], middle_owner[here] = t, who
                if who != middle_owner[0]:
                    differ = 1
            k += 1
            if k == 0:
                differ = 0
                covering, flat = covered_by(kinds, among, middle_owner)
                if ti.static(follows):
                    if shows_edges(surfaces, scene, covering // FACETS) == 1:
                        covering = -1
                if covering >= 0:
                    end = TILE * TILE
                    if flat == 1:
                        _fill_with_face(N, ox, oy, covering, middle_t, distance, owner)
                        k = end
        else:
            for s in range(SUBPIXELS):
                distance[r + s], owner[r + s] = middle_t[here], middle_owner[here]
            k += SUBPIXELS
    return covering


@ti.func
def solid_distance(scene: ti.template(), i, o, d):
    """The distance along a ray to a solid, or NEVER; an orthographic camera also sees what is behind it."""
    N = ti.static(scene.N)
    low, high = ray_limits(N, o, d)
    start = ti.select(N[PARALLEL] > 0.5, low, 0.0)
    t = solid_hit(scene.B, i, o + d * start, d, False)
    if t < NEVER:
        t += start
    if t < low or t > high:
        t = NEVER
    return t


@ti.func
def _fill_with_solid(
    surfaces: ti.template(), scene: ti.template(), i, ox, oy, distance: ti.template(), owner: ti.template()
):
    """Fill a tile's rays with a solid that covers it, by one ray a pixel, through its middle.

    A convex solid that all corners of the tile meet, on the same face, covers it.
    Returns its owner, or -1 where it does not cover the tile.
    """
    N = ti.static(scene.N)
    covers = 1 - shows_edges(surfaces, scene, surfaces + i)
    farthest, facet = 0.0, 0
    for corner in range(4):
        o, d = camera_ray(N, ti.cast(ox + TILE * (corner & 1), ti.f32), ti.cast(oy + TILE * (corner >> 1), ti.f32))
        t = NEVER
        if covers == 1:
            t = solid_distance(scene, i, o, d)
        if t < NEVER:
            here = solid_facet(scene.B, i, o + d * t)
            covers = ti.select(corner == 0 or here == facet, covers, 0)
            farthest, facet = ti.max(farthest, t), here
        else:
            covers = 0
    for r in range(_RAYS):
        covers = ti.select(distance[r] > farthest, covers, 0)
    if covers == 1:
        for p in range(TILE * TILE):
            o, d = middle_ray(N, ox + p % TILE, oy + p // TILE)
            t = solid_distance(scene, i, o, d)
            for s in range(SUBPIXELS):
                distance[p * SUBPIXELS + s], owner[p * SUBPIXELS + s] = t, (surfaces + i) * FACETS + facet
    return ti.select(covers == 1, (surfaces + i) * FACETS + facet, -1)


@ti.func
def box_in_tile(rectangles: ti.template(), i, ox, oy, width, rows):
    """(4,) first and last column, first and last row of rectangle i in the tile at (ox, oy)."""
    left, right = ti.max(rectangles[i, 0] - ox, 0), ti.min(rectangles[i, 1] - ox, width - 1)
    return ti.Vector([left, right, ti.max(rectangles[i, 2] - oy, 0), ti.min(rectangles[i, 3] - oy, rows - 1)])


@ti.func
def not_empty(box):
    """Whether a box_in_tile holds a pixel."""
    return box[0] <= box[1] and box[2] <= box[3]


@ti.func
def _trace_solid(scene: ti.template(), i, who, box, ox, oy, distance: ti.template(), owner: ti.template()):
    """Put a solid into a tile's rays where it is nearer.

    box : (4,) first and last column, first and last row of the tile that it may cover
    """
    N = ti.static(scene.N)
    for row in range(box[2], box[3] + 1):
        for column in range(box[0], box[1] + 1):
            for s in range(SUBPIXELS):
                r = (row * TILE + column) * SUBPIXELS + s
                o, d = subpixel_ray(N, ox + column, oy + row, s)
                t = solid_distance(scene, i, o, d)
                if t < distance[r]:
                    distance[r], owner[r] = t, who * FACETS + solid_facet(scene.B, i, o + d * t)


@ti.func
def trace_solids(
    surfaces: ti.template(), scene: ti.template(), rectangles: ti.template(), bin_solids: ti.template(), first, end, ox, oy,
    width, rows, covering, distance: ti.template(), owner: ti.template(),
):  # fmt: skip
    """Put the solids bin_solids[first:end] into a tile's rays where they are nearer.

    width, rows : of the part of the tile that lies in the picture; covering : of trace_colliders
    Returns the owner that all rays meet, or -1 where that is not known.
    """
    alone, count, covers = -1, 0, covering
    for k in range(first, end):
        box = box_in_tile(rectangles, bin_solids[k], ox, oy, width, rows)
        if not_empty(box) and solid_in_tile(scene, bin_solids[k], ox, oy):
            alone, count = bin_solids[k], count + 1
    if count > 0:
        covers = -1
    if count == 1:
        covers = _fill_with_solid(surfaces, scene, alone, ox, oy, distance, owner)
    if count > 0 and covers < 0:
        for k in range(first, end):
            i = bin_solids[k]
            box = box_in_tile(rectangles, i, ox, oy, width, rows)
            if not_empty(box) and solid_in_tile(scene, i, ox, oy):
                _trace_solid(scene, i, surfaces + i, box, ox, oy, distance, owner)
    return covers
