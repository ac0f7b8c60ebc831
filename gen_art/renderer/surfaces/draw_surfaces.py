"""The kernel that draws surfaces: which is nearest in each pixel, and the light it sends to the camera.

A pixel is seen through SUBPIXELS rays. Those that meet the same surface are shaded once, so edges are smooth and what lies
between them costs one shading. The picture is drawn in tiles of 8 x 8 pixels, each by one thread in local arrays.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from functools import cache

from gen_art.backend.kernel_views import particle as arrays
from gen_art.backend.runtime import kernel, ti
from gen_art.colliders.plane import Plane
from gen_art.renderer.picture_tiles import BIN, TILE, TILES
from gen_art.renderer.surfaces.collider_rays import ColliderTerms
from gen_art.renderer.surfaces.collider_sets import every_caster
from gen_art.renderer.surfaces.draw_sheets import middle_distance, trace_face
from gen_art.renderer.surfaces.even_tiles import NODES, even_light, is_even, may_be_even, node_pixel
from gen_art.renderer.surfaces.lamp_shadows import SOLIDS_OF_TILE
from gen_art.renderer.surfaces.pixel_rays import FACETS, SUBPIXELS
from gen_art.renderer.surfaces.ray_tree import LIGHT_PARTS, light_along, shows_edges
from gen_art.renderer.surfaces.scene_numbers import FORWARD, MIRROR, ROWS, WIDTH, vector_at
from gen_art.renderer.surfaces.solids import NEVER
from gen_art.renderer.surfaces.surface_layers import LAYER_FLOATS, layers_of_surface
from gen_art.renderer.surfaces.surface_shading import mirror_film_at
from gen_art.renderer.surfaces.tile_lists import ball_of_tile, tile_casters
from gen_art.renderer.surfaces.tile_rays import (
    box_in_tile,
    depth_along,
    middle_ray,
    not_empty,
    solid_distance,
    subpixel_ray,
    trace_colliders,
    trace_solids,
)

__all__ = ["draw_kernel"]

_RAYS = TILE * TILE * SUBPIXELS

F1, F2, F3, F4, I1, I2 = (
    ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.f32, 3), (ti.f32, 4), (ti.i32, 1), (ti.i32, 2))
)


@cache
def draw_kernel(
    terms: ColliderTerms, follows: bool, with_sheets: bool, glowing: bool, mapped: bool, layered: bool, shaded: bool = True,
    in_parts: bool = False,
):  # fmt: skip
    """The kernel that draws surfaces of these colliders, solids, and cloth if there is any.

    follows : whether smooth surfaces reflect each other, and light goes through transparent bodies
    glowing : whether emitting particles light them
    mapped : whether there are images, puddles or waves on them
    layered : whether the layers of surface_layers.py are filled, too
    shaded : whether their light is drawn; else their depths alone are found
    in_parts : whether the light goes into LightParts instead of the framebuffer
    """
    kinds, surfaces = terms.kinds, len(terms.owners)
    has_occluders = surfaces > 1
    near_casters = tuple(kind for kind in kinds if not isinstance(kind.collider, Plane))

    @ti.kernel
    def draw(
        N: F1, Q: F1, owners: I1, M: F2, E: F3, B: F2, rectangles: I2, bin_starts: I1, bin_solids: I1, shadow_starts: I1,
        shadow_solids: I1, D: F2, sky: F2, open_sky: F1, smoke: F1, across: ti.i32, down: ti.i32, framebuffer: F1,
        stride: ti.i32, depths: F3, bounds: F3, T: F2, levels: I2, G: F2, dome: F3, liquid_first: F2, liquid_depths: F3,
        grid_starts: I1, grid_solids: I1, photons: F2, photon_starts: I1, V: F2, faces: I2, sheet_looks: F2, sheet_grid: F1,
        sheet_starts: I1, sheet_faces: I1, face_rectangles: I2, face_starts: I1, bin_faces: I1, glow_nodes: F2,
        glow_links: I2, glow_lights: F2, glow_parts: I2, glow_lamps: F2, near_starts: I1, near_solids: I1, near_disc: F2,
        occluders: F2, images: F2, waves: F2, wave_field: F4, film_depths: F2, layers: F3, P: F1, solid_moves: F2,
        corner_moves: F2, own_light: F3, mirrored: F3,
    ):  # fmt: skip
        """Draw surfaces into a clear framebuffer, and their distances along the line of sight into `depths`.

        owners : collider of each surface
        M : (materials, 15); E : (materials, ANGLES, 3) of reflected_share
        B : (solids, SOLID_FLOATS) rows; rectangles : (solids, 4) first and last column and row of the pixels that each may cover
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
        occluders : of sky_occluders; images, waves : of SurfaceMaps; wave_field : of wave_field; film_depths : of the MirrorFilm
        layers, P, solid_moves, corner_moves : of SurfaceLayers
        own_light, mirrored : of LightParts
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
                mapped=mapped, images=images, waves=waves, wave_field=wave_field, film_depths=film_depths,
            )  # fmt: skip
            moves = arrays(P=P, solids=solid_moves, corners=corner_moves)
            bin, part = tile // (TILES * TILES), tile % (TILES * TILES)
            ox, oy = (bin % across) * BIN + (part % TILES) * TILE, (bin // across) * BIN + (part // TILES) * TILE
            width, rows = ti.min(ti.cast(N[WIDTH], ti.i32) - ox, TILE), ti.min(ti.cast(N[ROWS], ti.i32) - oy, TILE)
            if width > 0 and rows > 0:
                distance, owner, covering = ti.Vector([NEVER] * _RAYS), ti.Vector([-1] * _RAYS), -1
                if ti.static(surfaces > 0):
                    covering = trace_colliders(kinds, surfaces, follows, scene, ox, oy, distance, owner)
                covering = trace_solids(
                    surfaces, scene, rectangles, bin_solids, bin_starts[bin], bin_starts[bin + 1], ox, oy, width, rows,
                    covering, distance, owner,
                )  # fmt: skip
                first_face = surfaces + B.shape[0]
                if ti.static(with_sheets):
                    for k in range(face_starts[bin], face_starts[bin + 1]):
                        j = bin_faces[k]
                        box = box_in_tile(face_rectangles, j, ox, oy, width, rows)
                        if not_empty(box):
                            trace_face(scene, j, first_face + j, box, ox, oy, distance, owner)
                casters, nearby, even, first_pixel = every_caster(), ti.Vector([0] * SOLIDS_OF_TILE), 0, 0
                nearest, farthest = NEVER, -NEVER
                middle, radius = ball_of_tile(N, ox, oy, distance, owner)
                if radius < 0.0 and ti.static(not layered):  # the tile is empty, as the framebuffer is already
                    nearest, farthest, first_pixel = NEVER, NEVER, TILE * TILE
                    if bounds[oy // TILE, ox // TILE, 0] < NEVER:  # it was not empty in the picture before
                        for row, column, s in ti.ndrange((oy, oy + rows), (ox, ox + width), SUBPIXELS):
                            depths[row, column, s] = NEVER
                if ti.static(shaded):
                    if radius >= 0.0:
                        casters = tile_casters(kinds, scene, middle, radius, nearby)
                        if ti.static(not with_sheets and not glowing):
                            if covering >= 0 and width == TILE and rows == TILE:
                                even = may_be_even(kinds, surfaces, follows, scene, covering // FACETS, casters)
                if even == 1:
                    first_pixel = -NODES
                parts = ti.select(N[MIRROR] >= 0.0, LIGHT_PARTS, 6)
                nodes, rough = ti.Vector([0.0] * (NODES * LIGHT_PARTS)), 0.0
                normal, level = vector_at(N, FORWARD), vector_at(N, FORWARD)
                for q in range(first_pixel, TILE * TILE):
                    p = q
                    if q < 0:
                        p = node_pixel(q + NODES)
                    if q == 0 and even == 1:
                        even = is_even(nodes)
                    column, row = ox + p % TILE, oy + p // TILE
                    if column < ox + width and row < oy + rows:
                        total, covered, first, whole = ti.Vector([0.0, 0.0, 0.0]), 0.0, p * SUBPIXELS, 1
                        of_lamp, of_film, read = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0] * 6), ti.Vector([0.0] * 8)
                        layer_sums = ti.Vector([0.0] * LAYER_FLOATS)
                        apart = 0  # whether each ray is shaded by itself: what a smooth surface shows has edges
                        if ti.static(follows):
                            apart = shows_edges(surfaces, scene, owner[first] // FACETS)
                            whole = 1 - apart
                        if covering < 0:
                            for s in range(1, SUBPIXELS):
                                if owner[first + s] != owner[first]:
                                    whole = 0
                        for s in range(ti.select(whole == 1, 1, SUBPIXELS)):
                            who, t, earlier, share = owner[first + s], distance[first + s], 0, 1.0
                            o, d = middle_ray(N, column, row)
                            if whole == 1:  # one surface in all rays: its light along the ray through the middle
                                if who // FACETS >= first_face:
                                    if ti.static(with_sheets):
                                        t = middle_distance(N, distance, first)
                                elif distance[first + 1] != t:  # each ray of the pixel was traced, but not this one
                                    if who // FACETS >= surfaces:
                                        at_middle = solid_distance(scene, who // FACETS - surfaces, o, d)
                                        t = ti.select(at_middle < NEVER, at_middle, t)
                                    else:
                                        o, d = subpixel_ray(N, column, row, 0)
                            else:
                                o, d = subpixel_ray(N, column, row, s)
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
                            depth = ti.select(who >= 0, depth_along(N, d, t), NEVER)
                            nearest, farthest = ti.min(nearest, depth), ti.max(farthest, depth)
                            depths[row, column, s] = depth
                            if who >= 0 and earlier == 0:
                                if ti.static(shaded):
                                    light = ti.Vector([0.0] * LIGHT_PARTS)
                                    if q >= 0 and even == 1:
                                        light = even_light(nodes, p, parts)
                                    else:
                                        light, normal, level, rough = light_along(
                                            kinds, surfaces, follows, scene, who // FACETS, t, column, row, o, d, depth,
                                            casters, nearby,
                                        )  # fmt: skip
                                    if q < 0:
                                        for k in ti.static(range(LIGHT_PARTS)):
                                            nodes[(q + NODES) * LIGHT_PARTS + k] = light[k]
                                    elif ti.static(in_parts):
                                        for k in ti.static(range(3)):
                                            total[k] += share * light[k]
                                            of_lamp[k] += share * light[3 + k]
                                        if light[6] + light[7] + light[8] > 0.0:
                                            for k in ti.static(range(6)):
                                                of_film[k] += share * light[6 + k]
                                            read[0], read[7] = rough, depth
                                            for k in ti.static(range(3)):
                                                read[1 + k], read[4 + k] = normal[k], level[k]
                                    else:
                                        film = ti.Vector([0.0, 0.0, 0.0, 0.0])
                                        if light[6] + light[7] + light[8] > 0.0:
                                            film = mirror_film_at(scene, rough, level, normal, -d, column, row, depth)
                                        for k in ti.static(range(3)):
                                            seen = light[6 + k] * film[k] - light[9 + k] * film[3]
                                            total[k] += share * (light[k] + light[3 + k] + seen)
                                covered += share
                                if ti.static(layered):
                                    if q >= 0:
                                        layer_sums += share * layers_of_surface(
                                            kinds, surfaces, scene, moves, who // FACETS, o, d, t, depth
                                        )
                        if whole == 1:
                            for s in range(1, SUBPIXELS):
                                depths[row, column, s] = depths[row, column, 0]
                        if ti.static(in_parts):
                            for k in ti.static(range(3)):
                                own_light[row, column, k], own_light[row, column, 3 + k] = total[k], of_lamp[k]
                            own_light[row, column, 6] = covered
                            if N[MIRROR] >= 0.0:
                                for k in ti.static(range(6)):
                                    mirrored[row, column, k] = of_film[k]
                                for k in ti.static(range(8)):
                                    mirrored[row, column, 6 + k] = read[k]
                        elif ti.static(shaded):
                            place = row * stride + column * 4
                            for k in ti.static(range(3)):
                                framebuffer[place + k] = total[k]
                            framebuffer[place + 3] = covered
                        if ti.static(layered):
                            for k in ti.static(range(LAYER_FLOATS)):
                                layers[row, column, k] = layer_sums[k]
                bounds[oy // TILE, ox // TILE, 0], bounds[oy // TILE, ox // TILE, 1] = nearest, farthest

    return kernel(draw)
