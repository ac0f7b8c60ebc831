"""The light along a ray that surfaces reflect and transparent bodies refract, followed from one surface to the next.

At a smooth surface a ray goes on in the mirrored direction, and into a transparent body as the law of refraction says; each
part carries its share of the light. Rays wait in a short list until all are followed or MOST_RAYS are.
Source: Whitted, An improved illumination model for shaded display, CACM 23 (1980).

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from gen_art.backend.runtime import ti
from gen_art.maths.elementary import exp, log
from gen_art.preset.surface import TRACED_ROUGHNESS
from gen_art.renderer.surfaces.collider_rays import first_hit, surface_exit, surface_normal
from gen_art.renderer.surfaces.collider_sets import ALL_COLLIDERS, every_caster
from gen_art.renderer.surfaces.draw_sheets import sheet_material
from gen_art.renderer.surfaces.reflection import fresnel_of
from gen_art.renderer.surfaces.scene_numbers import CAMERA, MIRROR, PARALLEL, SCALE, SKY_CELL, TIME, vector_at
from gen_art.renderer.surfaces.solid_grid import far_side, nearest_solid
from gen_art.renderer.surfaces.solids import ALBEDO, EMITTED, MATERIAL, NEVER, row_vector, solid_normal
from gen_art.renderer.surfaces.surface_detail import (
    EMISSION,
    IMAGE,
    IOR,
    METAL,
    PER_LENGTH,
    PUDDLES,
    ROUGHNESS,
    TRANSMISSION,
    surface_detail,
)
from gen_art.renderer.surfaces.surface_images import has_image, image_on_solid
from gen_art.renderer.surfaces.surface_shading import air_between, background, surface_light

__all__ = [
    "LIGHT_PARTS",
    "leaving_distance",
    "light_along",
    "nearest_hit",
    "refracted",
    "shows_edges",
    "surface_point",
]

_SHARP = 0.05  # roughness up to which one ray shows a reflection; a rougher surface sends FACETS of them
_FACETS = 4
LIGHT_PARTS = 12  # that light_along returns
_AWAY = 0.05  # pixels from a surface at which the next ray starts
MOST_RAYS = 16
_WAITING = 12  # rays that may wait
_STRONG = 0.15  # share of the light from which on a rough surface's reflection is worth several rays
_LEAST = 0.01  # share of the light below which a reflection is not followed
_NUMBERS = 11  # of a waiting ray: origin, direction, share of the light, length so far, what it is inside or -1


@ti.func
def surface_point(
    kinds: ti.template(), surfaces: ti.template(), scene: ti.template(), who, x, d, pixel, column=-1, row=-1
):  # fmt: skip
    """(unit normal, place, material, albedo, through, emission, clear, flat, detail) of what a ray along d meets at x.

    who : a surface, from `surfaces` on a solid, and after them a face of cloth, which is smooth: its place is not quite x
    through, clear : see surface_light
    column, row : see surface_detail
    flat : the normal without waves and relief; detail : of surface_detail
    """
    N, B = ti.static(scene.N, scene.B)
    n, place, m, albedo, through, emission, clear = d, x, 0, d, d * 0.0, d, N[SKY_CELL]
    if who >= surfaces + B.shape[0]:
        if ti.static(scene.with_sheets):
            clear *= 2.0  # a sheet lies in two layers of the grid's nodes, blurred by one more
            n, place, m, albedo, through, emission = sheet_material(scene, who - surfaces - B.shape[0], x, -d, pixel)
    elif who >= surfaces:
        i = who - surfaces
        n, m = solid_normal(B, i, x), ti.cast(B[i, MATERIAL], ti.i32)
        albedo, emission = row_vector(B, i, ALBEDO), row_vector(B, i, EMITTED)
        if ti.static(scene.mapped):
            if has_image(scene.M, m, IMAGE):
                albedo = image_on_solid(scene, i, m, IMAGE, PUDDLES, albedo, x, n, d, pixel)
    else:
        if ti.static(surfaces > 0):
            n = surface_normal(kinds, scene.Q, who, x + vector_at(N, CAMERA), N[TIME])
            m = scene.owners[who]
            emission = row_vector(scene.M, m, EMISSION)
    flat, detail = n, ti.Vector([0.0, scene.M[m, ROUGHNESS], 0.0])
    if who < surfaces:
        if ti.static(surfaces > 0):
            albedo, n, emission, detail = surface_detail(kinds, scene, who, m, x, flat, d, pixel, column, row)
    return n, place, m, albedo, through, emission, clear, flat, detail


@ti.func
def shows_edges(surfaces: ti.template(), scene: ti.template(), who):
    """1 for a surface that shows others sharply, by reflection or through it, else 0."""
    m = -1
    if who >= surfaces + scene.B.shape[0]:
        m = -1
    elif who >= surfaces:
        m = ti.cast(scene.B[who - surfaces, MATERIAL], ti.i32)
    elif who >= 0:
        m = scene.owners[who]
    result = 0
    if m >= 0 and scene.N[MIRROR] != ti.cast(m, ti.f32):
        clear = scene.M[m, TRANSMISSION] > 0.0 or scene.M[m, METAL] > 0.0
        result = ti.cast(clear and scene.M[m, ROUGHNESS] <= _SHARP, ti.i32)
    return result


@ti.func
def nearest_hit(kinds: ti.template(), surfaces: ti.template(), scene: ti.template(), o, d, pixel):
    """(distance, index of the surface or solid) of what a ray meets first, or (NEVER, -1)."""
    N = ti.static(scene.N)
    t, who = NEVER, -1
    if ti.static(surfaces > 0):
        t, who, _ = first_hit(
            kinds,
            scene.Q,
            o + vector_at(N, CAMERA),
            d,
            N[TIME],
            0.0,
            NEVER,
            0.01 * pixel,
            0.004 / N[SCALE],
            ti.i64(ALL_COLLIDERS),
        )
    near, i = nearest_solid(scene, o, d, t)
    if i >= 0:
        t, who = near, surfaces + i
    return t, who


@ti.func
def leaving_distance(kinds: ti.template(), surfaces: ti.template(), scene: ti.template(), who, o, d, pixel):
    """The distance at which a ray inside a transparent body leaves it."""
    N = ti.static(scene.N)
    t = 0.0
    if who >= surfaces:
        t = far_side(scene.B, who - surfaces, o, d)
    else:
        if ti.static(surfaces > 0):
            t = surface_exit(kinds, scene.Q, who, o + vector_at(N, CAMERA), d, N[TIME], 0.01 * pixel)
    return t


@ti.func
def refracted(d, n, ratio):
    """The unit direction in which a ray along d goes on behind a surface, or zeros where all is reflected.

    n : unit normal towards the side from which the ray comes; ratio : its side's refractive index over that of the other
    """
    cosine = -d.dot(n)
    square = 1.0 - ratio * ratio * (1.0 - cosine * cosine)
    result = d * 0.0
    if square > 0.0:
        result = (d * ratio + n * (ratio * cosine - ti.sqrt(square))).normalized()
    return result


@ti.func
def _facet(scene: ti.template(), n, roughness, nth, column, row):
    """Normal `nth` of _FACETS facets of a rough surface, drawn from the Trowbridge-Reitz distribution."""
    # which of the evenly spread points a pixel takes follows a pattern of 4 x 4 pixels
    which = ((column & 3) * 5 + (row & 3) * 7 + 3 * ((column >> 2) ^ (row >> 2))) & 15
    k = nth * 16 + which
    u, v = scene.D[k, 0], scene.D[k, 1]
    slope = roughness * roughness / ti.sqrt(ti.max(1.0 - u * u - v * v, 1e-3))
    side = ti.Vector([1.0, 0.0, 0.0])
    if abs(n[0]) > 0.7:
        side = ti.Vector([0.0, 1.0, 0.0])
    side = (side - n * n.dot(side)).normalized()
    return (n + (side * u + n.cross(side) * v) * slope).normalized()


@ti.func
def _put(waiting: ti.template(), count, o, d, share, length, inside):
    """Add a ray to those that wait; returns their new number."""
    base = count * _NUMBERS
    for k in ti.static(range(3)):
        waiting[base + k], waiting[base + 3 + k], waiting[base + 6 + k] = o[k], d[k], share[k]
    waiting[base + 9], waiting[base + 10] = length, ti.cast(inside, ti.f32)
    return count + 1


@ti.func
def light_along(
    kinds: ti.template(), surfaces: ti.template(), follows: ti.template(), scene: ti.template(), owner, distance, column,
    row, origin, direction, depth, casters, nearby: ti.template(),
):  # fmt: skip
    """The light along a camera's ray that meets `owner` at `distance`, with the part that the mirror's film adds left open.

    Returns parts (LIGHT_PARTS,), and how the film is read: the unit normals (n, flat) of mirror_film_at, and its roughness.
    The radiance is parts[0:3] + parts[3:6] + parts[6:9] film - parts[9:12] coverage, of the film's light and coverage. parts[3:6]
    is the lamp's light from what the ray meets first; the last six are 0 where no mirror is met.

    follows : whether rays go on to what a surface reflects and refracts; else it reflects the sky and its mirror alone
    depth : distance along the line of sight
    casters, nearby : of tile_casters, for where the ray ends
    """
    N, M = ti.static(scene.N, scene.M)
    per_length, same_everywhere = 1.0 / N[SCALE], N[PARALLEL]  # of a pixel's side
    air = air_between(scene, direction, depth)
    result = ti.Vector([air[0], air[1], air[2]])
    lamp_first, of_film = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0] * 6)
    normal, level, film_roughness = direction, direction, 0.0
    waiting, count, followed = ti.Vector([0.0] * (_WAITING * _NUMBERS if follows else _NUMBERS)), 0, 0
    count = _put(waiting, count, origin, direction, ti.Vector([air[3], air[3], air[3]]), 0.0, -1)
    while count > 0:
        count -= 1
        followed += 1
        base = count * _NUMBERS
        o = ti.Vector([waiting[base], waiting[base + 1], waiting[base + 2]])
        d = ti.Vector([waiting[base + 3], waiting[base + 4], waiting[base + 5]])
        share = ti.Vector([waiting[base + 6], waiting[base + 7], waiting[base + 8]])
        length, inside, t, who = waiting[base + 9], ti.cast(waiting[base + 10], ti.i32), distance, owner
        pixel = ti.select(same_everywhere > 0.5, 1.0, length) * per_length
        if ti.static(follows):
            if inside >= 0:
                t, who = leaving_distance(kinds, surfaces, scene, inside, o, d, pixel), inside
            elif followed > 1:
                t, who = nearest_hit(kinds, surfaces, scene, o, d, pixel)
        if who < 0:
            result += share * background(scene, d)
        else:
            length += t
            pixel = ti.select(same_everywhere > 0.5, 1.0, length) * per_length
            room = followed < MOST_RAYS and count < _WAITING - _FACETS
            n, x, m, albedo, through, emission, clear, flat, detail = surface_point(
                kinds, surfaces, scene, who, o + d * t, d, pixel, ti.select(followed == 1, column, -1), row
            )
            if inside >= 0:
                if ti.static(follows):
                    for k in ti.static(range(3)):
                        share[k] *= exp(log(ti.max(albedo[k], 1e-6)) * t * M[m, PER_LENGTH])
                    out, back = refracted(d, -n, M[m, IOR]), 1.0
                    if out.dot(out) > 0.0:
                        back = fresnel_of(ti.max(out.dot(n), 1e-4), M[m, IOR])
                    if room and (share * back).max() > _LEAST:
                        turned = d - n * (2.0 * n.dot(d))
                        count = _put(waiting, count, x - n * (_AWAY * pixel), turned, share * back, length, inside)
                    elif back < 1.0:
                        back = 0.0
                    if back < 1.0:
                        count = _put(waiting, count, x + n * (_AWAY * pixel), out, share * (1.0 - back), length, -1)
            else:
                if followed > 1:
                    gas = air_between(scene, d, t)
                    result += share * ti.Vector([gas[0], gas[1], gas[2]])
                    share *= gas[3]
                hiding = every_caster()
                if followed == 1 and who < surfaces + scene.B.shape[0]:
                    hiding = casters
                own, of_lamp, mirrored, around, entering = surface_light(
                    kinds,
                    surfaces,
                    scene,
                    m,
                    x,
                    n,
                    -d,
                    albedo,
                    through,
                    emission,
                    clear,
                    pixel,
                    detail,
                    who,
                    hiding,
                    nearby,
                )
                result += share * own
                if followed == 1:
                    lamp_first = share * of_lamp
                else:
                    result += share * of_lamp
                mirrored *= share
                reflects = room and detail[1] <= TRACED_ROUGHNESS and mirrored.max() > _LEAST
                if N[MIRROR] == ti.cast(m, ti.f32):
                    reflects = False
                    if followed == 1:
                        normal, level, film_roughness = n, flat, detail[1]
                        for k in ti.static(range(3)):
                            # the film's light has come through the air already, so what the air adds is in it too
                            of_film[k] = mirrored[k] / ti.max(air[3], 1e-30)
                            of_film[3 + k] = of_film[k] * air[k] + mirrored[k] * around[k]
                if ti.static(follows):
                    if reflects:
                        facets = 1
                        if followed == 1 and detail[1] > _SHARP and mirrored.max() > _STRONG:
                            facets = _FACETS
                        for k in range(facets):
                            h = n
                            if followed == 1 and detail[1] > _SHARP:
                                h = _facet(scene, n, detail[1], k, column, row)
                            turned = d - h * (2.0 * h.dot(d))
                            if turned.dot(n) <= 0.0:
                                turned = d - n * (2.0 * n.dot(d))
                            part = mirrored / ti.cast(facets, ti.f32)
                            count = _put(waiting, count, x + n * (_AWAY * pixel), turned, part, length, -1)
                    else:
                        result += mirrored * around
                    if entering > 0.0 and not room:
                        result += share * entering * around
                    elif entering > 0.0:
                        into = refracted(d, n, 1.0 / M[m, IOR])
                        count = _put(waiting, count, x - n * (_AWAY * pixel), into, share * entering, length, who)
                else:
                    result += mirrored * around
    parts = ti.Vector([0.0] * LIGHT_PARTS)
    for k in ti.static(range(3)):
        parts[k], parts[3 + k], parts[6 + k], parts[9 + k] = result[k], lamp_first[k], of_film[k], of_film[3 + k]
    return parts, normal, level, film_roughness
