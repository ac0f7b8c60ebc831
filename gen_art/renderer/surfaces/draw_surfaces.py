"""The kernel that draws surfaces: which is nearest in each pixel, and the light it sends to the camera.

A pixel is seen through SUBPIXELS rays. Those that meet the same surface are shaded once, so edges are smooth and what lies
between them costs one shading. The picture is drawn in tiles of 8 x 8 pixels, each by one thread in local arrays.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from functools import cache

from gen_art.backend.kernel_views import particle as arrays
from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.surfaces.collider_rays import ColliderTerms, first_hit, surface_normal
from gen_art.renderer.surfaces.scene_numbers import CAMERA, FAR, FORWARD, NEAR, PARALLEL, ROWS, SCALE, TIME, WIDTH, camera_ray, vector_at
from gen_art.renderer.surfaces.surface_shading import EMISSION, albedo_at, row_vector, surface_radiance

__all__ = ["BALL_FLOATS", "NEVER", "SUBPIXELS", "draw_kernel"]

BIN, TILE = 32, 8  # pixels along the sides of a bin of the framebuffer and of a tile
TILES = BIN // TILE
SUBPIXELS = 4
_PLACES = ((0.375, 0.125), (0.875, 0.375), (0.125, 0.625), (0.625, 0.875))  # a rotated grid: no two in a row or a column
_RAYS, _WITH_BORDER = TILE * TILE * SUBPIXELS, (TILE + 2) * (TILE + 2)
NEVER = 1e30  # distance along a ray that meets nothing
# a ball's row: centre relative to the camera, radius, albedo, emission, row of its material
RADIUS, BALL_ALBEDO, BALL_EMISSION, BALL_MATERIAL, BALL_FLOATS = 3, 4, 7, 10, 12

F1, F2, F3, I1, I2 = (
    ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.f32, 3), (ti.i32, 1), (ti.i32, 2))
)


@ti.func
def _ball_hit(B: ti.template(), i, o, d):
    """The distance along a ray to a ball, or NEVER."""
    c = row_vector(B, i, 0) - o
    along = c.dot(d)
    aside = c - d * along
    inside = B[i, RADIUS] * B[i, RADIUS] - aside.dot(aside)
    result = NEVER
    if inside > 0.0:
        result = along - ti.sqrt(inside)
    return result


@ti.func
def _place(s, axis: ti.template()):
    """Where ray s of a pixel lies in it, along one axis."""
    value = 0.0
    for k in ti.static(range(SUBPIXELS)):
        if s == k:
            value = ti.static(_PLACES[k][axis])
    return value


@ti.func
def _limits(N: ti.template(), d):
    """(low, high) distances along a ray between the camera's near and far planes."""
    stretch = 1.0
    if N[PARALLEL] < 0.5:
        stretch = 1.0 / ti.max(d.dot(vector_at(N, FORWARD)), 1e-6)
    return N[NEAR] * stretch, ti.min(N[FAR] * stretch, NEVER)


@cache
def draw_kernel(terms: ColliderTerms):
    """The kernel that draws surfaces of these colliders, and balls."""
    entries, surfaces = terms.entries, len(terms.owners)

    @ti.kernel
    def draw(
        N: F1, Q: F1, owners: I1, M: F2, E: F3, B: F2, rectangles: I2, bin_starts: I1, bin_balls: I1, shadow_starts: I1,
        shadow_balls: I1, D: F2, sky: F2, open_sky: F1, smoke: F1, across: ti.i32, down: ti.i32, framebuffer: F1,
        stride: ti.i32, depths: F3, bounds: F3,
    ):  # fmt: skip
        """Draw surfaces into a clear framebuffer, and their distances along the line of sight into `depths`.

        owners : collider of each surface
        M : (materials, 13); E : (materials, ANGLES, 3) of reflected_share
        B : (balls, 12) rows; rectangles : (balls, 4) first and last column and row of the pixels that each may cover
        bin_starts, bin_balls : the balls of each bin of the framebuffer; shadow_starts, shadow_balls : of BallBins
        D : of lamp_disc; sky, open_sky : of SkyLight; smoke : optical depths from the lamp
        depths : (rows, columns, SUBPIXELS), NEVER where nothing is met
        bounds : (down, across, 2) the least and the largest of them in each tile
        """
        ti.loop_config(block_dim=1)
        for tile in range(across * down * TILES * TILES):
            scene = arrays(
                N=N, Q=Q, M=M, E=E, B=B, shadow_starts=shadow_starts, shadow_balls=shadow_balls, D=D, sky=sky,
                open_sky=open_sky, smoke=smoke,
            )  # fmt: skip
            bin, part = tile // (TILES * TILES), tile % (TILES * TILES)
            ox, oy = (bin % across) * BIN + (part % TILES) * TILE, (bin // across) * BIN + (part // TILES) * TILE
            width, rows = ti.min(ti.cast(N[WIDTH], ti.i32) - ox, TILE), ti.min(ti.cast(N[ROWS], ti.i32) - oy, TILE)
            if width > 0 and rows > 0:
                distance, owner = ti.Vector([NEVER] * _RAYS), ti.Vector([-1] * _RAYS)
                camera, forward = vector_at(N, CAMERA), vector_at(N, FORWARD)
                if ti.static(surfaces > 0):
                    per_length, tolerance = 0.02 / N[SCALE], 1e-7
                    if N[PARALLEL] > 0.5:
                        per_length, tolerance = 0.0, 0.02 / N[SCALE]
                    # one ray a pixel, with a border of one pixel around the tile; all rays only where these meet different surfaces
                    first_t, first_owner = ti.Vector([NEVER] * _WITH_BORDER), ti.Vector([-1] * _WITH_BORDER)
                    for r in range(_WITH_BORDER):
                        column, row = ox + r % (TILE + 2) - 1, oy + r // (TILE + 2) - 1
                        o, d = camera_ray(N, ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5)
                        low, high = _limits(N, d)
                        t, found = first_hit(entries, Q, o + camera, d, N[TIME], low, high, tolerance, per_length)
                        first_t[r], first_owner[r] = ti.select(found >= 0, t, NEVER), found
                    for p in range(TILE * TILE):
                        here, same = (p // TILE + 1) * (TILE + 2) + p % TILE + 1, 1
                        for k in range(9):
                            if first_owner[here + (k // 3 - 1) * (TILE + 2) + k % 3 - 1] != first_owner[here]:
                                same = 0
                        for s in range(SUBPIXELS):
                            t, found = first_t[here], first_owner[here]
                            if same == 0:
                                column, row = ti.cast(ox + p % TILE, ti.f32), ti.cast(oy + p // TILE, ti.f32)
                                o, d = camera_ray(N, column + _place(s, 0), row + _place(s, 1))
                                low, high = _limits(N, d)
                                t, found = first_hit(entries, Q, o + camera, d, N[TIME], low, high, tolerance, per_length)
                            distance[p * SUBPIXELS + s] = ti.select(found >= 0, t, NEVER)
                            owner[p * SUBPIXELS + s] = found
                for k in range(bin_starts[bin], bin_starts[bin + 1]):
                    i = bin_balls[k]
                    left, right = ti.max(rectangles[i, 0] - ox, 0), ti.min(rectangles[i, 1] - ox, width - 1)
                    top, bottom = ti.max(rectangles[i, 2] - oy, 0), ti.min(rectangles[i, 3] - oy, rows - 1)
                    for row in range(top, bottom + 1):
                        for column in range(left, right + 1):
                            for s in range(SUBPIXELS):
                                r = (row * TILE + column) * SUBPIXELS + s
                                o, d = camera_ray(N, ti.cast(ox + column, ti.f32) + _place(s, 0), ti.cast(oy + row, ti.f32) + _place(s, 1))
                                t = _ball_hit(B, i, o, d)
                                if t < distance[r]:
                                    distance[r], owner[r] = t, surfaces + i
                nearest, farthest = NEVER, -NEVER
                for p in range(TILE * TILE):
                    column, row = p % TILE, p // TILE
                    if column < width and row < rows:
                        total, covered = ti.Vector([0.0, 0.0, 0.0]), 0.0
                        a = p * SUBPIXELS
                        whole = 1
                        for s in ti.static(range(1, SUBPIXELS)):
                            if owner[a + s] != owner[a]:
                                whole = 0
                        s = 0
                        while s < SUBPIXELS:
                            who, t, first, alike = owner[a + s], distance[a + s], s, SUBPIXELS
                            x_s, y_s = ti.cast(ox + column, ti.f32) + 0.5, ti.cast(oy + row, ti.f32) + 0.5
                            if whole == 0:
                                alike = 0
                                x_s, y_s = x_s - 0.5 + _place(s, 0), y_s - 0.5 + _place(s, 1)
                                for other in range(SUBPIXELS):
                                    if owner[a + other] == who:
                                        alike += 1
                                        first = ti.min(first, other)
                            o, d = camera_ray(N, x_s, y_s)
                            if who >= surfaces and whole == 1:
                                middle = _ball_hit(B, who - surfaces, o, d)
                                t = ti.select(middle < NEVER, middle, t)
                            depth = t
                            if N[PARALLEL] < 0.5:
                                depth *= d.dot(forward)
                            nearest, farthest = ti.min(nearest, depth), ti.max(farthest, depth)
                            if who >= 0 and first == s:
                                x = o + d * t
                                n, albedo, emission, m = d, d, d, 0
                                if who >= surfaces:
                                    i = who - surfaces
                                    n = (x - row_vector(B, i, 0)).normalized()
                                    m = ti.cast(B[i, BALL_MATERIAL], ti.i32)
                                    albedo, emission = row_vector(B, i, BALL_ALBEDO), row_vector(B, i, BALL_EMISSION)
                                else:
                                    if ti.static(surfaces > 0):
                                        n = surface_normal(entries, Q, who, x + camera, N[TIME])
                                        m = owners[who]
                                        albedo, emission = albedo_at(M, N, m, x, n, t, x_s, y_s), row_vector(M, m, EMISSION)
                                light = surface_radiance(entries, scene, m, x, n, -d, albedo, emission, t, depth)
                                total += light * ti.cast(alike, ti.f32)
                                covered += ti.cast(alike, ti.f32)
                            if whole == 1:
                                for k in range(SUBPIXELS):
                                    depths[oy + row, ox + column, k] = depth
                                s = SUBPIXELS
                            else:
                                depths[oy + row, ox + column, s] = depth
                                s += 1
                        place = (oy + row) * stride + (ox + column) * 4
                        for k in ti.static(range(3)):
                            framebuffer[place + k] = total[k] * (1.0 / SUBPIXELS)
                        framebuffer[place + 3] = covered * (1.0 / SUBPIXELS)
                bounds[oy // TILE, ox // TILE, 0], bounds[oy // TILE, ox // TILE, 1] = nearest, farthest

    return kernel(draw)
