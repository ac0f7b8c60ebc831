"""The kernel that draws the surface of a liquid: its light, and what is seen through it.

The surface reflects as all surfaces do (surfaces/surface_shading.py). Of the light that enters, the part exp(-L/s) goes on
along the refracted ray to where the ray leaves the liquid, and shows what the picture holds there, times exp(-a L) for each
colour; L is the length of the way, s the mean length to a scattering, a the absorption. The rest is scattered back by the
look's albedo, as by a matt surface.

The length L follows from the length T along the straight ray: in a layer whose two sides are parallel, it is T cos(i) / cos(r)
with the angles of incidence and refraction.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend.kernel_views import particle as arrays
from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp
from gen_art.renderer.liquid.smoothing import STEP_DEPTH, STEP_SLOPE
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.sky_table import sky_radiance
from gen_art.renderer.surfaces.collider_rays import ColliderTerms
from gen_art.renderer.surfaces.collider_sets import every_caster
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS
from gen_art.renderer.surfaces.scene_numbers import (
    FORWARD,
    PARALLEL,
    RIGHT,
    ROWS,
    SCALE,
    SKY_CELL,
    SKY_LIFT,
    UP,
    WIDTH,
    camera_ray,
    vector_at,
)
from gen_art.renderer.surfaces.solids import NEVER
from gen_art.renderer.surfaces.surface_detail import IOR, ROUGHNESS
from gen_art.renderer.surfaces.surface_layers import LAYER_FLOATS, layers_of_place
from gen_art.renderer.surfaces.surface_shading import air_between, layer_shares, surface_light

__all__ = ["LIQUID_NUMBERS", "draw_liquid_kernel"]

# L: absorption and scattering per length, whether it is clear, the particles' radius, material, whether a sky lies behind
ABSORPTION, SCATTERING, CLEAR, SPHERE, MATERIAL, SKY_BEHIND, LIQUID_NUMBERS = 0, 3, 4, 5, 6, 7, 8

F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1, I2 = (ti.types.ndarray(ti.i32, n) for n in (1, 2))


@ti.func
def _slope(U: ti.template(), row, column, down, limit):
    """Change of the smoothed depth from a pixel to the next, along rows or columns: of both sides that belong to one sheet."""
    here, total, sides = U[row, column], 0.0, 0.0
    for k in ti.static(range(2)):
        sign = ti.static(1 - 2 * k)
        i, j = row + sign * down, column + sign * (1 - down)
        if i >= 0 and j >= 0 and i < U.shape[0] and j < U.shape[1]:
            change = U[i, j] - here
            if U[i, j] < NEVER and abs(change) <= limit:
                total += sign * change
                sides += 1.0
    return total / ti.max(sides, 1.0)


@ti.func
def _normal(N: ti.template(), L: ti.template(), U: ti.template(), row, column):
    """Unit normal of the smoothed surface, towards the camera.

    With perspective, a plane n.x = 1 has 1/depth = n.d along the direction d whose part along the line of sight is 1.
    """
    u = U[row, column]
    pixels, change = N[SCALE], 1.0
    if N[PARALLEL] < 0.5:
        pixels, change = N[SCALE] * u, u * u
    limit = (STEP_DEPTH * L[SPHERE] + STEP_SLOPE / pixels) * change
    a, b = N[SCALE] * _slope(U, row, column, 0, limit), -N[SCALE] * _slope(U, row, column, 1, limit)
    local = ti.Vector([a, b, -1.0])
    if N[PARALLEL] < 0.5:
        x = (ti.cast(column, ti.f32) + 0.5 - 0.5 * N[WIDTH]) / N[SCALE]
        y = (0.5 * N[ROWS] - ti.cast(row, ti.f32) - 0.5) / N[SCALE]
        local = -ti.Vector([a, b, u - a * x - b * y])
    n = vector_at(N, RIGHT) * local[0] + vector_at(N, UP) * local[1] + vector_at(N, FORWARD) * local[2]
    return n.normalized()


@ti.func
def _length_at(thickness: ti.template(), row, column):
    """The length of liquid along the ray of a pixel, between the four nearest blocks."""
    v, u = 0.5 * ti.cast(row, ti.f32) - 0.25, 0.5 * ti.cast(column, ti.f32) - 0.25
    v = ti.min(ti.max(v, 0.0), ti.cast(thickness.shape[0] - 1, ti.f32))
    u = ti.min(ti.max(u, 0.0), ti.cast(thickness.shape[1] - 1, ti.f32))
    i, j = ti.cast(v, ti.i32), ti.cast(u, ti.i32)
    k, m = ti.min(i + 1, thickness.shape[0] - 1), ti.min(j + 1, thickness.shape[1] - 1)
    fv, fu = v - ti.cast(i, ti.f32), u - ti.cast(j, ti.f32)
    upper = thickness[i, j] + (thickness[i, m] - thickness[i, j]) * fu
    lower = thickness[k, j] + (thickness[k, m] - thickness[k, j]) * fu
    return upper + (lower - upper) * fv


@ti.func
def _picture_at(film: ti.template(), N: ti.template(), x, y):
    """(4,) light and coverage of the picture at a place in pixels, between the four nearest pixels."""
    u = ti.min(ti.max(x - 0.5, 0.0), N[WIDTH] - 1.0)
    v = ti.min(ti.max(y - 0.5, 0.0), N[ROWS] - 1.0)
    i, j = ti.cast(v, ti.i32), ti.cast(u, ti.i32)
    k, m = ti.min(i + 1, ti.cast(N[ROWS], ti.i32) - 1), ti.min(j + 1, ti.cast(N[WIDTH], ti.i32) - 1)
    fv, fu = v - ti.cast(i, ti.f32), u - ti.cast(j, ti.f32)
    result = ti.Vector([0.0, 0.0, 0.0, 0.0])
    for c in ti.static(range(4)):
        upper = film[i, j, c] + (film[i, m, c] - film[i, j, c]) * fu
        lower = film[k, j, c] + (film[k, m, c] - film[k, j, c]) * fu
        result[c] = upper + (lower - upper) * fv
    return result


@ti.func
def _seen_through(
    scene: ti.template(), film: ti.template(), far: ti.template(), x, towards, length, depth, row, column
):
    """(4,) light and coverage of what the refracted ray meets where it leaves the liquid.

    x : relative to the camera, where it enters; towards : its direction; depth : of x along the line of sight
    film, far : the picture without the liquid, and its depths
    """
    N = ti.static(scene.N)
    end = x + towards * length
    scale, ahead = N[SCALE], end.dot(vector_at(N, FORWARD))
    if N[PARALLEL] < 0.5:
        scale /= ti.max(ahead, 1e-6)
    u = 0.5 * N[WIDTH] + scale * end.dot(vector_at(N, RIGHT))
    v = 0.5 * N[ROWS] - scale * end.dot(vector_at(N, UP))
    i, j = (
        ti.cast(ti.floor(ti.min(ti.max(v, -1.0), N[ROWS])), ti.i32),
        ti.cast(ti.floor(ti.min(ti.max(u, -1.0), N[WIDTH])), ti.i32),
    )
    before = 1
    if i >= 0 and j >= 0 and i < film.shape[0] and j < film.shape[1]:
        before = ti.select(far[i, j] >= depth, 0, 1)
    if before == 1:  # off the picture, or of something before the liquid: what lies straight behind
        u, v = ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5
    return _picture_at(film, N, u, v)


@cache
def draw_liquid_kernel(terms: ColliderTerms, coloured: bool, layered: bool):
    """The kernel that draws a liquid among these colliders, with a colour of its own in each pixel or one for all.

    layered : whether the layers of surfaces/surface_layers.py are filled, too
    """
    kinds = terms.kinds

    @ti.kernel
    def draw(
        N: F1, Q: F1, M: F2, E: F3, B: F2, shadow_starts: I1, shadow_solids: I1, D: F2, sky: F2, open_sky: F1, smoke: F1,
        T: F2, levels: I2, G: F2, dome: F3, liquid_first: F2, liquid_depths: F3, L: F1, U: F2, cover: F2, thickness: F2,
        colours: F3, film: F3, far: F2, framebuffer: F1, stride: ti.i32, depths: F3, bounds: F3,
        layers: F3, P: F1, flow: F3,
    ):  # fmt: skip
        """Draw the liquid over the framebuffer, and its depths into `depths` and `bounds`.

        L : LIQUID_NUMBERS; U : of smoothing.smooth; cover, thickness, colours : of PixelLayers
        film, far : the framebuffer and the depths of its pixels, without the liquid
        layers, P : of SurfaceLayers; flow : whose first three numbers are the velocity of the surface in each pixel
        """
        ti.loop_config(block_dim=1)
        for tile in range(bounds.shape[0] * bounds.shape[1]):
            scene = arrays(
                N=N, Q=Q, M=M, E=E, B=B, shadow_starts=shadow_starts, shadow_solids=shadow_solids, D=D, sky=sky,
                open_sky=open_sky, smoke=smoke, T=T, levels=levels, G=G, dome=dome,
                liquid_first=liquid_first, liquid_depths=liquid_depths, with_sheets=False,
                gathers=False, glowing=False, occluded=False, mapped=False,
            )  # fmt: skip
            oy, ox = tile // bounds.shape[1] * TILE, tile % bounds.shape[1] * TILE
            nearest, farthest = NEVER, -NEVER
            for p in range(TILE * TILE):
                row, column = oy + p // TILE, ox + p % TILE
                if row < U.shape[0] and column < U.shape[1]:
                    u = U[row, column]
                    if u < NEVER and cover[row, column] > 0.0:
                        z = ti.select(N[PARALLEL] > 0.5, u, 1.0 / u)
                        visible, behind, beyond = 0.0, 0.0, 0.0
                        for s in range(SUBPIXELS):
                            if depths[row, column, s] > z:
                                visible += 1.0 / SUBPIXELS
                                if depths[row, column, s] < NEVER:
                                    behind += 1.0
                                    beyond += depths[row, column, s]
                        if visible > 0.0:
                            o, d = camera_ray(N, ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5)
                            per_depth = 1.0
                            if N[PARALLEL] < 0.5:
                                per_depth = 1.0 / d.dot(vector_at(N, FORWARD))
                            t, m = z * per_depth, ti.cast(L[MATERIAL], ti.i32)
                            x, n = o + d * t, _normal(N, L, U, row, column)
                            place = ti.Vector([0, 0])
                            if ti.static(coloured):
                                place = ti.Vector([row, column])
                            albedo, emission = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
                            for c in ti.static(range(3)):
                                albedo[c] = colours[place[0], place[1], c]
                                emission[c] = colours[place[0], place[1], 3 + c]
                            through, light, opacity = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0]), 1.0
                            if L[CLEAR] > 0.5:
                                nv = ti.min(ti.max(-n.dot(d), 1e-4), 1.0)
                                bend = 1.0 / M[m, IOR]
                                inner = ti.sqrt(ti.max(1.0 - bend * bend * (1.0 - nv * nv), 1e-8))
                                length = _length_at(thickness, row, column)
                                if behind > 0.0:
                                    length = ti.min(length, (beyond / behind - z) * per_depth)
                                length *= nv / inner
                                towards = d * bend + n * (bend * nv - inner)
                                seen = _seen_through(scene, film, far, x, towards, length, z, row, column)
                                if L[SKY_BEHIND] > 0.5 and seen[3] < 1.0:
                                    sky_there = sky_radiance(dome, towards[0], towards[1], towards[2])
                                    for c in ti.static(range(3)):
                                        seen[c] += (1.0 - seen[3]) * sky_there[c]
                                    seen[3] = 1.0
                                straight = exp(-length * L[SCATTERING])
                                albedo *= 1.0 - straight
                                straight *= 1.0 - layer_shares(M, E, m, nv)[2]
                                for c in ti.static(range(3)):
                                    through[c] = straight * exp(-length * L[ABSORPTION + c])
                                    light[c] = through[c] * seen[c]
                                opacity -= through.sum() * (1.0 / 3.0) * (1.0 - seen[3])
                            pixel = ti.select(N[PARALLEL] > 0.5, 1.0, t) / N[SCALE]
                            clear = N[SKY_CELL] + N[SKY_LIFT]
                            detail = ti.Vector([0.0, M[m, ROUGHNESS], 0.0])
                            own, of_lamp, mirrored, around, _ = surface_light(
                                kinds, 0, scene, m, x, n, -d, albedo, albedo * 0.0, emission, clear, pixel, detail,
                                -1, every_caster(),
                            )  # fmt: skip
                            air = air_between(scene, d, z)
                            light += (own + of_lamp + mirrored * around) * air[3] + ti.Vector([air[0], air[1], air[2]])
                            if ti.static(layered):
                                moves = ti.Vector([flow[row, column, 0], flow[row, column, 1], flow[row, column, 2]])
                                values = layers_of_place(kinds, scene, P, x, n, albedo, moves, z, pixel)
                                part = cover[row, column] * visible
                                for c in ti.static(range(3)):  # what is seen through it has its own albedo
                                    values[c] += through[c] * layers[row, column, c]
                                for c in ti.static(range(LAYER_FLOATS)):
                                    under = layers[row, column, c]
                                    layers[row, column, c] = under + (values[c] - under) * part
                            share, at = cover[row, column] * visible, row * stride + column * 4
                            for c in ti.static(range(3)):
                                framebuffer[at + c] = framebuffer[at + c] * (1.0 - share) + light[c] * share
                            framebuffer[at + 3] = framebuffer[at + 3] * (1.0 - share) + opacity * share
                            for s in range(SUBPIXELS):
                                if (ti.cast(s, ti.f32) + 0.5) / SUBPIXELS < cover[row, column]:
                                    depths[row, column, s] = ti.min(depths[row, column, s], z)
                    for s in range(SUBPIXELS):
                        nearest = ti.min(nearest, depths[row, column, s])
                        farthest = ti.max(farthest, depths[row, column, s])
            bounds[oy // TILE, ox // TILE, 0], bounds[oy // TILE, ox // TILE, 1] = nearest, farthest

    return kernel(draw)
