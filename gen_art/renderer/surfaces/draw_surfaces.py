"""The kernel that draws surfaces: which is nearest in each pixel, and the light it sends to the camera.

A pixel is seen through SUBPIXELS rays. Those that meet the same surface are shaded once, so edges are smooth and what lies
between them costs one shading. The picture is drawn in tiles of 8 x 8 pixels, each by one thread in local arrays.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend.kernel_views import particle as arrays
from gen_art.backend.runtime import kernel, ti
from gen_art.colliders.plane import Plane
from gen_art.renderer.surfaces.collider_rays import ColliderTerms, first_hit
from gen_art.renderer.surfaces.collider_sets import every_collider
from gen_art.renderer.surfaces.draw_sheets import middle_distance, trace_face
from gen_art.renderer.surfaces.ray_tree import light_along, shows_edges
from gen_art.renderer.surfaces.scene_numbers import (
    CAMERA,
    FORWARD,
    PARALLEL,
    ROWS,
    SCALE,
    TIME,
    WIDTH,
    camera_ray,
    vector_at,
)
from gen_art.renderer.surfaces.solids import NEVER, solid_facet, solid_hit
from gen_art.renderer.surfaces.surface_layers import LAYER_FLOATS, layers_of_surface
from gen_art.renderer.surfaces.tile_colliders import colliders_in_tile, tile_casters
from gen_art.renderer.surfaces.tiles import BIN, FACETS, SUBPIXELS, TILE, TILES, ray_limits, subpixel

__all__ = ["draw_kernel"]

_RAYS, _WITH_BORDER = TILE * TILE * SUBPIXELS, (TILE + 2) * (TILE + 2)

F1, F2, F3, I1, I2 = (
    ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.f32, 3), (ti.i32, 1), (ti.i32, 2))
)


@ti.func
def _subpixel_ray(N: ti.template(), column, row, s):
    """Origin and direction of ray s of a pixel."""
    place = subpixel(s)
    return camera_ray(N, ti.cast(column, ti.f32) + place[0], ti.cast(row, ti.f32) + place[1])


@ti.func
def _middle_ray(N: ti.template(), column, row):
    return camera_ray(N, ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5)


@ti.func
def _collider_hit(entries: ti.template(), scene: ti.template(), among, o, d):
    """(distance along a ray, owner) of the nearest of some colliders, or (NEVER, -1); exact to 1/250 of a pixel."""
    N = ti.static(scene.N)
    per_length, tolerance = 0.0, 0.004 / N[SCALE]
    if N[PARALLEL] < 0.5:
        per_length, tolerance = tolerance, 1e-7
    low, high = ray_limits(N, o, d)
    t, surface, facet = first_hit(
        entries, scene.Q, o + vector_at(N, CAMERA), d, N[TIME], low, high, tolerance, per_length, among
    )
    owner = surface * FACETS + facet
    if surface < 0:
        t, owner = NEVER, -1
    return t, owner


@ti.func
def _trace_colliders(
    entries: ti.template(), surfaces: ti.template(), follows: ti.template(), scene: ti.template(), ox, oy,
    distance: ti.template(), owner: ti.template(),
):  # fmt: skip
    """Fill a tile's rays, which meet nothing so far, with the nearest colliders.

    One ray a pixel first, with a border of a pixel around the tile; all rays only where these meet different surfaces, or one
    that shows others sharply.
    """
    N = ti.static(scene.N)
    middle_t, middle_owner, differ = ti.Vector([NEVER] * _WITH_BORDER), ti.Vector([-1] * _WITH_BORDER), 0
    among, k = colliders_in_tile(entries, scene, ox, oy), 0
    if among == 0:
        k = _WITH_BORDER + _RAYS
    while k < _WITH_BORDER + _RAYS:  # one loop, so that a collider is compiled once
        r = k - _WITH_BORDER
        p = r // SUBPIXELS
        here = (p // TILE + 1) * (TILE + 2) + p % TILE + 1
        o, d, again = vector_at(N, CAMERA), vector_at(N, CAMERA), 1
        if r < 0:
            o, d = _middle_ray(N, ox + k % (TILE + 2) - 1, oy + k // (TILE + 2) - 1)
        else:
            if r % SUBPIXELS == 0:
                again = 0
                if differ == 1:
                    for beside in range(9):
                        if middle_owner[here + (beside // 3 - 1) * (TILE + 2) + beside % 3 - 1] != middle_owner[here]:
                            again = 1
                if ti.static(follows):
                    again |= shows_edges(surfaces, scene, middle_owner[here] // FACETS)
            if again == 1:
                o, d = _subpixel_ray(N, ox + p % TILE, oy + p // TILE, r % SUBPIXELS)
        if again == 1:
            t, who = _collider_hit(entries, scene, among, o, d)
            if r < 0:
                middle_t[k], middle_owner[k] = t, who
                if who != middle_owner[0]:
                    differ = 1
            else:
                distance[r], owner[r] = t, who
            k += 1
        else:
            for s in range(SUBPIXELS):
                distance[r + s], owner[r + s] = middle_t[here], middle_owner[here]
            k += SUBPIXELS


@ti.func
def _solid_distance(scene: ti.template(), i, o, d):
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
def _trace_solid(scene: ti.template(), i, who, box, ox, oy, distance: ti.template(), owner: ti.template()):
    """Put a solid into a tile's rays where it is nearer.

    box : (4,) first and last column, first and last row of the tile that it may cover
    """
    N = ti.static(scene.N)
    for row in range(box[2], box[3] + 1):
        for column in range(box[0], box[1] + 1):
            for s in range(SUBPIXELS):
                r = (row * TILE + column) * SUBPIXELS + s
                o, d = _subpixel_ray(N, ox + column, oy + row, s)
                t = _solid_distance(scene, i, o, d)
                if t < distance[r]:
                    distance[r], owner[r] = t, who * FACETS + solid_facet(scene.B, i, o + d * t)


@ti.func
def _box_in_tile(rectangles: ti.template(), i, ox, oy, width, rows):
    """(4,) first and last column, first and last row of rectangle i in the tile at (ox, oy)."""
    left, right = ti.max(rectangles[i, 0] - ox, 0), ti.min(rectangles[i, 1] - ox, width - 1)
    return ti.Vector([left, right, ti.max(rectangles[i, 2] - oy, 0), ti.min(rectangles[i, 3] - oy, rows - 1)])


@ti.func
def _depth(N: ti.template(), d, t):
    """The distance along the line of sight of a place at distance t along a ray."""
    result = t
    if N[PARALLEL] < 0.5:
        result = t * d.dot(vector_at(N, FORWARD))
    return result


@cache
def draw_kernel(
    terms: ColliderTerms, follows: bool, with_sheets: bool, glowing: bool, mapped: bool, layered: bool, shaded: bool = True
):  # fmt: skip
    """The kernel that draws surfaces of these colliders, solids, and cloth if there is any.

    follows : whether smooth surfaces reflect each other, and light goes through transparent bodies
    glowing : whether emitting particles light them
    mapped : whether there are images, puddles or waves on them
    layered : whether the layers of surface_layers.py are filled, too
    shaded : whether their light is drawn; else their depths alone are found
    """
    entries, surfaces = terms.entries, len(terms.owners)
    has_occluders = surfaces > 1
    near_casters = tuple(entry for entry in entries if not isinstance(entry.collider, Plane))

    @ti.kernel
    def draw(
        N: F1, Q: F1, owners: I1, M: F2, E: F3, B: F2, rectangles: I2, bin_starts: I1, bin_solids: I1, shadow_starts: I1,
        shadow_solids: I1, D: F2, sky: F2, open_sky: F1, smoke: F1, across: ti.i32, down: ti.i32, framebuffer: F1,
        stride: ti.i32, depths: F3, bounds: F3, T: F2, levels: I2, G: F2, dome: F3, liquid_first: F2, liquid_depths: F3,
        grid_starts: I1, grid_solids: I1, photons: F2, photon_starts: I1, V: F2, faces: I2, sheet_looks: F2, sheet_grid: F1,
        sheet_starts: I1, sheet_faces: I1, face_rectangles: I2, face_starts: I1, bin_faces: I1, glow_nodes: F2,
        glow_links: I2, glow_lights: F2, glow_parts: I2, glow_lamps: F2, near_starts: I1, near_solids: I1, near_disc: F2,
        occluders: F2, images: F2, waves: F2, film_depths: F2, layers: F3, P: F1, solid_moves: F2, corner_moves: F2,
    ):  # fmt: skip
        """Draw surfaces into a clear framebuffer, and their distances along the line of sight into `depths`.

        owners : collider of each surface
        M : (materials, 15); E : (materials, ANGLES, 3) of reflected_share
        B : (solids, 24) rows; rectangles : (solids, 4) first and last column and row of the pixels that each may cover
        bin_starts, bin_solids : the solids of each bin of the framebuffer; shadow_starts, shadow_solids : of ShadowBins
        D : of lamp_disc; sky, open_sky : of SkyLight; smoke : optical depths from the lamp
        depths : (rows, columns, SUBPIXELS), NEVER where nothing is met
        bounds : (down, across, 2) the least and the largest of them in each tile
        T, levels : of the MirrorFilm; G : of blur_points; dome : table of the SkyDome
        liquid_first, liquid_depths : of the LiquidShadow
        grid_starts, grid_solids : of the SolidGrid; photons, photon_starts : of Photons
        V, faces, sheet_looks, sheet_grid, sheet_starts, sheet_faces : of Sheets
        face_rectangles, face_starts, bin_faces : of its faces, as for solids
        glow_... : of a LightTree; near_starts, near_solids : of NearBins; near_disc : of lamp_disc
        occluders : of sky_occluders; images, waves : of SurfaceMaps; film_depths : of the MirrorFilm
        layers, P, solid_moves, corner_moves : of SurfaceLayers
        """
        ti.loop_config(block_dim=1)
        for tile in range(across * down * TILES * TILES):
            scene = arrays(
                N=N, Q=Q, owners=owners, M=M, E=E, B=B, shadow_starts=shadow_starts, shadow_solids=shadow_solids, D=D,
                sky=sky, open_sky=open_sky, smoke=smoke, T=T, levels=levels, G=G, dome=dome,
                liquid_first=liquid_first, liquid_depths=liquid_depths, grid_starts=grid_starts, grid_solids=grid_solids,
                gathers=True, photons=photons, photon_starts=photon_starts, with_sheets=with_sheets, V=V, faces=faces,
                sheet_looks=sheet_looks, sheet_grid=sheet_grid, sheet_starts=sheet_starts, sheet_faces=sheet_faces,
                glowing=glowing, near_casters=near_casters, glow_nodes=glow_nodes, glow_links=glow_links,
                glow_lights=glow_lights, glow_parts=glow_parts, glow_lamps=glow_lamps, near_starts=near_starts,
                near_solids=near_solids, near_disc=near_disc, occluded=has_occluders, occluders=occluders,
                mapped=mapped, images=images, waves=waves, film_depths=film_depths,
            )  # fmt: skip
            moves = arrays(P=P, solids=solid_moves, corners=corner_moves)
            bin, part = tile // (TILES * TILES), tile % (TILES * TILES)
            ox, oy = (bin % across) * BIN + (part % TILES) * TILE, (bin // across) * BIN + (part // TILES) * TILE
            width, rows = ti.min(ti.cast(N[WIDTH], ti.i32) - ox, TILE), ti.min(ti.cast(N[ROWS], ti.i32) - oy, TILE)
            if width > 0 and rows > 0:
                distance, owner = ti.Vector([NEVER] * _RAYS), ti.Vector([-1] * _RAYS)
                if ti.static(surfaces > 0):
                    _trace_colliders(entries, surfaces, follows, scene, ox, oy, distance, owner)
                for k in range(bin_starts[bin], bin_starts[bin + 1]):
                    i = bin_solids[k]
                    box = _box_in_tile(rectangles, i, ox, oy, width, rows)
                    _trace_solid(scene, i, surfaces + i, box, ox, oy, distance, owner)
                first_face = surfaces + B.shape[0]
                if ti.static(with_sheets):
                    for k in range(face_starts[bin], face_starts[bin + 1]):
                        j = bin_faces[k]
                        box = _box_in_tile(face_rectangles, j, ox, oy, width, rows)
                        if box[0] <= box[1] and box[2] <= box[3]:
                            trace_face(scene, j, first_face + j, box, ox, oy, distance, owner)
                casters = every_collider()
                if ti.static(surfaces > 0 and shaded):
                    casters = tile_casters(entries, scene, ox, oy, distance, owner)
                nearest, farthest = NEVER, -NEVER
                for p in range(TILE * TILE):
                    column, row = ox + p % TILE, oy + p // TILE
                    if column < ox + width and row < oy + rows:
                        total, covered, first, whole = ti.Vector([0.0, 0.0, 0.0]), 0.0, p * SUBPIXELS, 1
                        layer_sums = ti.Vector([0.0] * LAYER_FLOATS)
                        apart = 0  # whether each ray is shaded by itself: what a smooth surface shows has edges
                        if ti.static(follows):
                            apart = shows_edges(surfaces, scene, owner[first] // FACETS)
                            whole = 1 - apart
                        for s in range(1, SUBPIXELS):
                            if owner[first + s] != owner[first]:
                                whole = 0
                        for s in range(ti.select(whole == 1, 1, SUBPIXELS)):
                            who, t, earlier, share = owner[first + s], distance[first + s], 0, 1.0
                            o, d = _middle_ray(N, column, row)
                            if whole == 1:  # one surface in all rays: its light along the ray through the middle
                                if who // FACETS >= first_face:
                                    if ti.static(with_sheets):
                                        t = middle_distance(N, distance, first)
                                elif who // FACETS >= surfaces:
                                    middle = _solid_distance(scene, who // FACETS - surfaces, o, d)
                                    t = ti.select(middle < NEVER, middle, t)
                                elif distance[first + 1] != t:  # each ray of the pixel was traced, but not this one
                                    o, d = _subpixel_ray(N, column, row, 0)
                            else:
                                o, d = _subpixel_ray(N, column, row, s)
                                share = 0.0
                                if ti.static(follows):
                                    apart = shows_edges(surfaces, scene, who // FACETS)
                                for other in range(SUBPIXELS):
                                    if apart == 1:
                                        share = 1.0 / SUBPIXELS
                                    elif owner[first + other] == who:
                                        share += 1.0 / SUBPIXELS
                                        if other < s:
                                            earlier = 1
                            depth = _depth(N, d, t)
                            nearest, farthest = ti.min(nearest, depth), ti.max(farthest, depth)
                            depths[row, column, s] = depth
                            if who >= 0 and earlier == 0:
                                if ti.static(shaded):
                                    total += share * light_along(
                                        entries,
                                        surfaces,
                                        follows,
                                        scene,
                                        who // FACETS,
                                        t,
                                        column,
                                        row,
                                        o,
                                        d,
                                        depth,
                                        casters,
                                    )
                                covered += share
                                if ti.static(layered):
                                    layer_sums += share * layers_of_surface(
                                        entries, surfaces, scene, moves, who // FACETS, o, d, t, depth
                                    )
                        if whole == 1:
                            for s in range(1, SUBPIXELS):
                                depths[row, column, s] = depths[row, column, 0]
                        if ti.static(shaded):
                            place = row * stride + column * 4
                            for k in ti.static(range(3)):
                                framebuffer[place + k] = total[k]
                            framebuffer[place + 3] = covered
                        if ti.static(layered):
                            for k in ti.static(range(LAYER_FLOATS)):
                                layers[row, column, k] = layer_sums[k]
                bounds[oy // TILE, ox // TILE, 0], bounds[oy // TILE, ox // TILE, 1] = nearest, farthest

    return kernel(draw)
