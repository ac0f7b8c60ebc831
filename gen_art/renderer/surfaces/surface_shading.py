"""The light that a place of a surface sends to the camera: scattered, reflected and emitted.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from gen_art.backend.runtime import ti
from gen_art.maths.elementary import exp
from gen_art.renderer.sky_table import sky_radiance
from gen_art.renderer.surfaces.collider_rays import without_itself
from gen_art.renderer.surfaces.glow_light import DULL, glow_at
from gen_art.renderer.surfaces.liquid_shadow import liquid_light
from gen_art.renderer.surfaces.mirror_film import LEVELS, blurred_light, mirrored_light
from gen_art.renderer.surfaces.photon_cells import photon_light
from gen_art.renderer.surfaces.reflection import ANGLES, SMOOTH, fresnel_of, microfacets
from gen_art.renderer.surfaces.scene_numbers import (
    CAMERA,
    FOG_COLOUR,
    FOG_IS_SKY,
    FOG_RATE,
    FOG_START,
    HAS_DOME,
    LAMP_COLOUR,
    LAMP_TANGENT,
    LIQUID_BIAS,
    MIRROR,
    RIGHT,
    ROWS,
    SCALE,
    TO_LAMP,
    UP,
    WIDTH,
    vector_at,
)
from gen_art.renderer.surfaces.sky_occlusion import open_sky_share
from gen_art.renderer.surfaces.surface_detail import IOR, METAL, ROUGHNESS, TRANSMISSION, WAVES
from gen_art.renderer.surfaces.surface_light import lamp_share, sky_at
from gen_art.renderer.surfaces.water_waves import mean_reflected

__all__ = [
    "air_between", "background", "layer_shares", "mirror_film_at", "surface_light",
]  # fmt: skip

WATER_IOR = 1.33
_FOUR_PI = 12.566370614359172


@ti.func
def layer_shares(M: ti.template(), E: ti.template(), m, nv):
    """A, B and C of reflection.py (3,): what the layer of a material reflects of light from all sides.

    nv : cosine of the normal with the view
    """
    at = nv * (ANGLES - 1.0)
    e = ti.min(ti.cast(at, ti.i32), ANGLES - 2)
    result = row_vector_3(E, m, e) + (row_vector_3(E, m, e + 1) - row_vector_3(E, m, e)) * (at - ti.cast(e, ti.f32))
    if M[m, ROUGHNESS] <= SMOOTH:
        result[2] = fresnel_of(nv, M[m, IOR])
    return result


@ti.func
def surface_light(
    kinds: ti.template(), surfaces: ti.template(), scene: ti.template(), m, x, n, view, albedo, through, emission, clear,
    pixel, detail, who, casters, nearby: ti.template() = None,
):  # fmt: skip
    """The light from x towards the viewer, in parts: (own, of_lamp, mirrored, around, entering).

    own : (3,) radiance of what is scattered and emitted, without the lamp's light
    of_lamp : (3,) radiance of the lamp's light that is scattered, and of its highlight
    mirrored : (3,) the share that is reflected of the light from the mirrored direction
    around : (3,) radiance from there, if nothing but the sky lies there
    entering : the share of the light that goes into a transparent body

    m : row of the material
    x : position relative to the camera; n : unit normal; view : unit vector to the viewer
    albedo, through : (3,) the part of the light that is scattered on this side, and of the light on the other side that comes
        through
    clear : how far from x the sky's light is taken, so that what lies at x does not hide it
    pixel : side of a pixel at x, in world units
    detail : of surface_detail
    who : a collider's surface, and from `surfaces` on a solid
    casters : (3,) i64, of tile_casters
    nearby : of lamp_share
    """
    N, M, E = ti.static(scene.N, scene.M, scene.E)
    to_lamp = vector_at(N, TO_LAMP)
    nl, nv = n.dot(to_lamp), ti.min(ti.max(n.dot(view), 1e-4), 1.0)
    share, lit, passed = 0.0, nl > 0.0, ti.Vector([1.0, 1.0, 1.0])
    if ti.static(scene.with_sheets):
        lit = nl > 0.0 or through.max() > 0.0
    if lit and N[LAMP_COLOUR] + N[LAMP_COLOUR + 1] + N[LAMP_COLOUR + 2] > 0.0:
        hiding, own_solid = casters, -1
        if nl > N[LAMP_TANGENT]:  # a convex solid does not hide what shines on its outside
            hiding[0], own_solid = without_itself(kinds, hiding[0], who), who - surfaces
        beside = x + n * ti.select(nl > 0.0, 0.6 * pixel, -0.6 * pixel)
        share = lamp_share(kinds, scene, beside, pixel, hiding, own_solid, nearby)
        if share > 0.0:
            place = x + vector_at(N, CAMERA) + n * N[LIQUID_BIAS]
            passed = liquid_light(N, scene.liquid_first, scene.liquid_depths, scene.D, place, pixel)
    sky = sky_at(N, scene.sky, scene.open_sky, x + vector_at(N, CAMERA) + n * clear)
    if ti.static(scene.occluded):
        sky *= open_sky_share(kinds, scene, x, n, without_itself(kinds, casters[1], who))
    shining, lamp_through = through * 0.0, through * 0.0  # what comes through from the other side
    if ti.static(scene.with_sheets):
        if through.max() > 0.0:
            behind = sky_at(N, scene.sky, scene.open_sky, x + vector_at(N, CAMERA) - n * clear)
            for k in ti.static(range(3)):
                slope = ti.Vector([behind[3 + 3 * k], behind[4 + 3 * k], behind[5 + 3 * k]])
                of_sky = ti.max(behind[k] - (2.0 / 3.0) * slope.dot(n), 0.0)
                shining[k] = through[k] * of_sky
                lamp_through[k] = through[k] * 4.0 * N[LAMP_COLOUR + k] * share * passed[k] * ti.max(-nl, 0.0)
    metal, rough, ior = M[m, METAL], detail[1], M[m, IOR]
    share_of = layer_shares(M, E, m, nv)
    a, b, c = share_of[0], share_of[1], share_of[2]
    if ti.static(scene.mapped):
        ior += (WATER_IOR - ior) * detail[0]
        c += (fresnel_of(nv, WATER_IOR) - c) * detail[0]
        if detail[2] > 0.0:
            c = mean_reflected(c, nv, ior, 0.5 * detail[2])
    h = (to_lamp + view).normalized()
    vh, lobe = ti.max(h.dot(view), 0.0), 0.0
    if nl > 0.0 and share > 0.0:  # the lamp's disc widens the highlight
        alpha = ti.max(rough * rough, 0.5 * N[LAMP_TANGENT] + 1e-3)
        lobe = microfacets(nl, nv, ti.max(n.dot(h), 0.0), alpha) * nl * _FOUR_PI
    towards = n * (2.0 * n.dot(view)) - view
    if ti.static(scene.mapped):
        if M[m, WAVES + 1] > 0.0:
            towards[1] = ti.abs(towards[1])  # a ray that goes down meets another wave
    schlick, dielectric = (1.0 - vh) ** 5, fresnel_of(vh, ior) * lobe
    blur = 1.0 - rough * (1.0 / 3.0)
    # the sky as a smooth surface reflects it, dimmed as the sky's mean is here; a rough one reflects its even part
    dome, even = ti.Vector([0.0, 0.0, 0.0]), 1.0
    if N[HAS_DOME] > 0.5:
        even = ti.min(1.5 * rough, 1.0)
        if even < 1.0:
            dome = sky_radiance(scene.dome, towards[0], towards[1], towards[2])
    gathered, glow = emission * 0.0, ti.Vector([0.0] * 12)
    if ti.static(scene.gathers):
        gathered = photon_light(scene, x)
    if ti.static(scene.glowing):
        dull = ti.select(N[MIRROR] == ti.cast(m, ti.f32), 1.0, rough)  # a mirror shows the particles themselves
        if dull < DULL or metal > 0.0 or albedo.max() > 0.0:  # what is black and shows no highlights shows no light
            glow = glow_at(scene, x, n, view, dull, ior, pixel, who - surfaces)
    own, of_lamp, mirrored, around = emission, emission * 0.0, emission * 0.0, emission * 0.0
    scattered = 1.0 - M[m, TRANSMISSION]
    for k in ti.static(range(3)):
        lamp = N[LAMP_COLOUR + k] * share * passed[k]
        slope = ti.Vector([sky[3 + 3 * k], sky[4 + 3 * k], sky[5 + 3 * k]])
        arriving = ti.max(sky[k] + (2.0 / 3.0) * slope.dot(n), 0.0) + gathered[k]
        open_share = ti.min(sky[k] / ti.max(scene.open_sky[k], 1e-20), 1.0)
        around[k] = even * ti.max(sky[k] + blur * slope.dot(towards), 0.0) + (1.0 - even) * dome[k] * open_share
        if ti.static(scene.glowing):
            arriving += glow[k]
        colour = (1.0 - c) * scattered * albedo[k]
        painted, lit_paint = colour * arriving, (colour * 4.0 * ti.max(nl, 0.0) + dielectric) * lamp
        if ti.static(scene.with_sheets):
            painted, lit_paint = painted + (1.0 - c) * shining[k], lit_paint + (1.0 - c) * lamp_through[k]
        again = 1.0 + albedo[k] * (1.0 / ti.max(a + b, 1e-3) - 1.0)  # what a rough metal reflects twice
        bare, lit_metal = 0.0, (albedo[k] + (1.0 - albedo[k]) * schlick) * lobe * lamp
        if ti.static(scene.glowing):
            painted += glow[6 + k]
            bare += albedo[k] * glow[3 + k] + (1.0 - albedo[k]) * glow[9 + k]
            if rough >= DULL:
                bare += (albedo[k] * a + b) * glow[k]
        own[k] += (1.0 - metal) * painted + metal * bare * again
        of_lamp[k] = (1.0 - metal) * lit_paint + metal * lit_metal * again
        mirrored[k] = (1.0 - metal) * c + metal * (albedo[k] * a + b) * again
    return own, of_lamp, mirrored, around, (1.0 - metal) * (1.0 - c) * M[m, TRANSMISSION]


@ti.func
def air_between(scene: ti.template(), direction, depth):
    """(4,) radiance of the fog up to a distance `depth` in a direction, and the share of the light behind that passes."""
    N = ti.static(scene.N)
    result = ti.Vector([0.0, 0.0, 0.0, 1.0])
    if N[FOG_RATE] > 0.0:
        seen = exp(-ti.max(depth - N[FOG_START], 0.0) * N[FOG_RATE])
        air = vector_at(N, FOG_COLOUR)
        if N[FOG_IS_SKY] > 0.5:
            level = ti.max(direction[1], 0.02 * ti.sqrt(direction[0] * direction[0] + direction[2] * direction[2]))
            air = sky_radiance(scene.dome, direction[0], level, direction[2])
        for k in ti.static(range(3)):
            result[k] = air[k] * (1.0 - seen)
        result[3] = seen
    return result


@ti.func
def background(scene: ti.template(), direction):
    """The radiance (3,) of the sky in a direction, without the lamp."""
    N = ti.static(scene.N)
    result = ti.Vector([0.0, 0.0, 0.0])
    if N[HAS_DOME] > 0.5:
        result = sky_radiance(scene.dome, direction[0], direction[1], direction[2])
    else:
        for k in ti.static(range(3)):
            slope = ti.Vector([scene.open_sky[3 + 3 * k], scene.open_sky[4 + 3 * k], scene.open_sky[5 + 3 * k]])
            result[k] = ti.max(scene.open_sky[k] + slope.dot(direction), 0.0)
    return result


@ti.func
def _way_beyond(scene: ti.template(), x, y, depth):
    """The part of the way to what the mirror shows at a place of the film that lies behind the mirror: 1 for the sky."""
    side = scene.levels[0, 3]
    i = ti.min(ti.max(ti.cast(y, ti.i32) // side, 0), scene.film_depths.shape[0] - 1)
    j = ti.min(ti.max(ti.cast(x, ti.i32) // side, 0), scene.film_depths.shape[1] - 1)
    return ti.min(ti.max(1.0 - depth / ti.max(scene.film_depths[i, j], 1e-30), 0.0), 1.0)


@ti.func
def mirror_film_at(scene: ti.template(), rough, flat, n, view, column, row, depth):
    """(4,) light and coverage that the mirror shows in a pixel.

    flat : the mirror's unit normal; n : that of its waves; depth : of the mirror along the line of sight
    """
    N = ti.static(scene.N)
    x, y, result = ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5, ti.Vector([0.0, 0.0, 0.0, 0.0])
    if scene.levels[LEVELS, 2] > 0:
        result = blurred_light(scene.T, scene.levels, x, y)
    else:
        nv = ti.min(ti.max(flat.dot(view), 1e-4), 1.0)
        # the slopes of facets have the standard deviation alpha / sqrt(2); a reflected ray turns by twice the angle
        spread = 1.4142135 * rough * rough * N[SCALE]
        up = ti.Vector([flat.dot(vector_at(N, RIGHT)), -flat.dot(vector_at(N, UP))])
        length = up.norm()
        cosine, sine = 0.0, 1.0
        if length > 1e-6:
            cosine, sine = up[0] / length, up[1] / length
        inside = 1.0
        if ti.static(scene.mapped):
            # a slope towards the viewer turns the ray in the plane of the view, one across it out of that plane by nv
            towards = view - flat * flat.dot(view)
            towards /= ti.max(towards.norm(), 1e-6)
            leaning = (n - flat * n.dot(flat)) / ti.max(n.dot(flat), 1e-3)
            height = ti.abs(
                nv + 2.0 * leaning.dot(towards)
            )  # of the mirrored ray; one that goes down meets another wave
            along, aside = N[SCALE] * (nv - height), 2.0 * N[SCALE] * nv * leaning.dot(flat.cross(towards))
            move = ti.Vector([along * cosine - aside * sine, along * sine + aside * cosine])
            # the ray turns at the mirror: what stands close behind it moves less
            beyond = _way_beyond(scene, x, y, depth)
            beyond = _way_beyond(scene, x + beyond * move[0], y + beyond * move[1], depth)
            x, y, spread = x + beyond * move[0], y + beyond * move[1], spread * beyond
            # past the film's border the sky alone is mirrored
            beside = ti.min(ti.min(x, N[WIDTH] - x), ti.min(y, N[ROWS] - y))
            inside = ti.min(ti.max(1.0 + beside / (0.05 * N[ROWS]), 0.0), 1.0)
        result = inside * mirrored_light(scene.T, scene.levels, scene.G, x, y, spread, spread * nv, cosine, sine)
    return result


@ti.func
def row_vector_3(E: ti.template(), m, k):
    return ti.Vector([E[m, k, 0], E[m, k, 1], E[m, k, 2]])
