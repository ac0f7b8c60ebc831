"""What varies over a surface, as means over a pixel: its albedo, its light, its roughness, and the normal of waves and relief.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.collider_rays import in_start_frame
from gen_art.renderer.surfaces.scene_numbers import CAMERA, TIME, vector_at
from gen_art.renderer.surfaces.solids import row_vector
from gen_art.renderer.surfaces.surface_axes import on_axes, pixel_steps
from gen_art.renderer.surfaces.surface_maps import MAP_FLOATS, map_at
from gen_art.renderer.surfaces.water_waves import one_number, wave_slope

__all__ = ["LIGHT_FACTOR", "MATERIAL_FLOATS", "surface_detail"]

# a material's row: albedo, second albedo, side of the checker's squares or 0, roughness, refractive index, metal, emission,
# transmission, 1 / attenuation_distance, the numbers of the maps of its image, puddles, light and relief, first row and number
# of its waves and the number of rows that make them uneven, how damp it is between puddles, the factor on its light map, and
# which of the arrays of wave_field is its own, or -1
SECOND_ALBEDO, CHECKER, ROUGHNESS, IOR, METAL, EMISSION, TRANSMISSION, PER_LENGTH = 3, 6, 7, 8, 9, 10, 13, 14
IMAGE, PUDDLES, LIGHT, RELIEF, WAVES = (15 + k * MAP_FLOATS for k in range(5))
DAMP, LIGHT_FACTOR, WAVE_FIELD = WAVES + 3, WAVES + 4, WAVES + 5
MATERIAL_FLOATS = WAVE_FIELD + 1
_FADES, _GONE = 0.6, 1.1  # squares of a checker in a pixel
_MAPS = 4  # of a material, in the order of their columns
_WET_ROUGHNESS = 0.02  # of a puddle


@ti.func
def _checker(position, change_x, change_y, size):
    """The share of a checker's second colour in a pixel: the mean over the box that the pixel's edges span.

    Where more than _FADES squares fall into a pixel they fade into the mean of both colours, and at _GONE nothing is left of
    them: a pixel shows no pattern whose squares are narrower than it, only a coarser one, a moire, of a tenth of its contrast.

    position : (2,) in the world; change_x, change_y : (2,) from one pixel to the next
    Source: Quilez, Filtering the checkerboard pattern.
    """
    value = 1.0
    for c in ti.static(range(2)):
        x = position[c] / size
        w = ti.max((abs(change_x[c]) + abs(change_y[c])) / size, 1e-4)
        low, high = 0.5 * (x - 0.5 * w), 0.5 * (x + 0.5 * w)
        value *= 2.0 * (abs(low - ti.floor(low) - 0.5) - abs(high - ti.floor(high) - 0.5)) / w
        value *= ti.min(ti.max((_GONE - w) / (_GONE - _FADES), 0.0), 1.0)
    return 0.5 - 0.5 * value


@ti.func
def _tangent(east, south, a, b):
    """The vector (3,) in the plane of two vectors, east and south, whose products with them are a and b."""
    ee, es, ss = east.dot(east), east.dot(south), south.dot(south)
    determinant = ti.max(ee * ss - es * es, 1e-7 * ee * ss + 1e-30)
    return (east * (ss * a - es * b) + south * (ee * b - es * a)) / determinant


@ti.func
def surface_detail(kinds: ti.template(), scene: ti.template(), who, m, x, n, d, pixel, column, row):
    """What varies over a collider, as means over a pixel: (albedo, normal, emission, detail).

    who : the surface; x : position relative to the camera; n : unit normal
    d : direction of the ray that meets x; pixel : side of a pixel at x, in world units
    column, row : of the picture's pixel that sees x, or -1 where x is seen otherwise
    normal : unit normal of the waves and of the relief
    detail : (3,) the wet part, the roughness, and the mean square slope of waves that are shorter than a pixel
    """
    N, M = ti.static(scene.N, scene.M)
    albedo, normal, detail = row_vector(M, m, 0), n, ti.Vector([0.0, M[m, ROUGHNESS], 0.0])
    emission = row_vector(M, m, EMISSION)
    patterned = M[m, CHECKER] > 0.0
    if ti.static(scene.mapped):
        for k in range(_MAPS):
            patterned = patterned or M[m, IMAGE + k * MAP_FLOATS + 1] > 0.0
        patterned = patterned or M[m, WAVES + 1] > 0.0
    if patterned:
        to_east, to_south = pixel_steps(N, n, d, pixel)
        place, facing, east, south = in_start_frame(
            kinds, scene.Q, who, x + vector_at(N, CAMERA), n, to_east, to_south, N[TIME]
        )
        at, right, down = on_axes(facing, place), on_axes(facing, east), on_axes(facing, south)
        if M[m, CHECKER] > 0.0:
            share = _checker(at, right, down, M[m, CHECKER])
            albedo += (row_vector(M, m, SECOND_ALBEDO) - albedo) * share
        if ti.static(scene.mapped):
            image, wet, relief = ti.Vector([0.0, 0.0, 0.0, 0.0]), 0.0, ti.Vector([0.0, 0.0, 0.0, 0.0])
            for k in range(_MAPS):  # one loop, so that a map is compiled once
                found = map_at(scene.images, M, m, IMAGE + k * MAP_FLOATS, at, right, down)
                if k == 0:
                    image = found
                elif k == 1:
                    wet = found[3]
                elif k == 2:
                    light = ti.Vector([found[0], found[1], found[2]]) * M[m, LIGHT_FACTOR]
                    emission = emission * (1.0 - found[3]) + light
                else:
                    relief = found
            albedo = albedo * (1.0 - image[3]) + ti.Vector([image[0], image[1], image[2]])
            if M[m, PUDDLES + 1] > 0.0:
                damp = M[m, DAMP] * (1.0 - wet) + wet
                albedo *= 1.0 - 0.5 * damp  # water in its pores darkens what is rough (Lekner and Dorf, 1988)
                detail[0] = wet
                detail[1] = detail[1] * (1.0 - 0.5 * M[m, DAMP]) * (1.0 - wet) + _WET_ROUGHNESS * wet
            if M[m, RELIEF + 1] > 0.0:
                dry = 1.0 - detail[0]  # water is level, whatever lies below it
                a, b = dry * relief[0], dry * relief[1]
                uphill = _tangent(to_east, to_south, a * right[0] + b * right[1], a * down[0] + b * down[1])
                normal = (n - uphill).normalized()
                # the slopes that the pixel does not show one by one make it rougher (Olano and Baker, LEAN mapping, 2010)
                hidden = ti.max(dry * dry * relief[2] - a * a - b * b, 0.0)
                detail[1] = ti.min(ti.sqrt(ti.sqrt(detail[1] ** 4 + hidden)), 1.0)
            if M[m, WAVES + 1] > 0.0:
                waves = ti.Vector([0.0, 0.0, 0.0])
                field = ti.cast(M[m, WAVE_FIELD], ti.i32)
                if field >= 0 and column >= 0:
                    for k in ti.static(range(3)):
                        waves[k] = scene.wave_field[field, row, k, column]
                else:
                    first, number, uneven = [ti.cast(M[m, WAVES + k], ti.i32) for k in ti.static(range(3))]
                    to_right, to_down, shorter = wave_slope(
                        scene.waves, first, number, uneven, one_number, at, right, down
                    )
                    waves = ti.Vector([to_right, to_down, shorter])
                # `right` is x and `down` is z on a level surface; waves are for those
                normal = (normal - ti.Vector([waves[0], 0.0, waves[1]])).normalized()
                detail[1] = ti.sqrt(ti.sqrt(detail[1] ** 4 + waves[2]))
                detail[2] = waves[2]
    return albedo, normal, emission, detail
