"""The light that a place of a surface sends to the camera: scattered, reflected and emitted.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.maths.elementary import exp
from gen_art.renderer.sky_table import sky_radiance
from gen_art.renderer.surfaces.glow_light import DULL, glow_at
from gen_art.renderer.surfaces.mirror_film import mirrored_light
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
    MIRROR,
    PARALLEL,
    RIGHT,
    SCALE,
    SKY_CELL,
    TO_LAMP,
    UP,
    camera_ray,
    vector_at,
)
from gen_art.renderer.surfaces.surface_light import lamp_share, sky_at

__all__ = ["MATERIAL_FLOATS", "albedo_at", "row_vector", "surface_radiance"]

# a material's row: albedo, second albedo, side of the checker's squares or 0, roughness, refractive index, metal, emission
SECOND_ALBEDO, CHECKER, ROUGHNESS, IOR, METAL, EMISSION, MATERIAL_FLOATS = 3, 6, 7, 8, 9, 10, 13
_FOUR_PI = 12.566370614359172


@ti.func
def row_vector(A: ti.template(), i, k):
    """The three numbers of row i from column k on."""
    return ti.Vector([A[i, k], A[i, k + 1], A[i, k + 2]])


@ti.func
def _checker(position, change_x, change_y, size):
    """The share of a checker's second colour in a pixel: the mean over the box that the pixel's edges span.

    position : (2,) in the world; change_x, change_y : (2,) from one pixel to the next
    Source: Quilez, Filtering the checkerboard pattern.
    """
    value = 1.0
    for c in ti.static(range(2)):
        x = position[c] / size
        w = ti.max((abs(change_x[c]) + abs(change_y[c])) / size, 1e-4)
        low, high = 0.5 * (x - 0.5 * w), 0.5 * (x + 0.5 * w)
        value *= 2.0 * (abs(low - ti.floor(low) - 0.5) - abs(high - ti.floor(high) - 0.5)) / w
    return 0.5 - 0.5 * value


@ti.func
def albedo_at(M: ti.template(), N: ti.template(), m, x, n, t, column, row):
    """A collider's albedo at the position x (relative to the camera), averaged over the pixel."""
    albedo = row_vector(M, m, 0)
    if M[m, CHECKER] > 0.0:
        # the pixel's neighbours on the plane through x that touches the surface
        moves = ti.Matrix([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
        for k in range(2):
            o_k, d_k = camera_ray(N, column + ti.cast(1 - k, ti.f32), row + ti.cast(k, ti.f32))
            slope = d_k.dot(n)
            slope = ti.select(abs(slope) < 1e-6, -1e-6, slope)
            t_k = ti.min(ti.max((x - o_k).dot(n) / slope, 0.0), 100.0 * t)
            for c in ti.static(range(3)):
                moves[k, c] = o_k[c] + d_k[c] * t_k - x[c]
        world = x + vector_at(N, CAMERA)
        a, b = 0, 2  # the two axes of the world along which the surface extends most
        if abs(n[0]) > abs(n[1]) and abs(n[0]) >= abs(n[2]):
            a, b = 1, 2
        elif abs(n[2]) > abs(n[1]) and abs(n[2]) > abs(n[0]):
            a, b = 0, 1
        place, east, south = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
        for c in ti.static(range(3)):
            if c == a:
                place[0], east[0], south[0] = world[c], moves[0, c], moves[1, c]
            if c == b:
                place[1], east[1], south[1] = world[c], moves[0, c], moves[1, c]
        share = _checker(place, east, south, M[m, CHECKER])
        albedo += (row_vector(M, m, SECOND_ALBEDO) - albedo) * share
    return albedo


@ti.func
def surface_radiance(
    entries: ti.template(), scene: ti.template(), m, x, n, view, albedo, emission, t, depth, column, row
):  # fmt: skip
    """The radiance (3,) from x towards the camera.

    m : row of the material
    x : position relative to the camera; n : unit normal; view : unit vector to the camera
    t, depth : distance along the ray, and along the line of sight
    column, row : the pixel
    """
    N, M, E = ti.static(scene.N, scene.M, scene.E)
    pixel = ti.select(N[PARALLEL] > 0.5, 1.0, t) / N[SCALE]
    to_lamp = vector_at(N, TO_LAMP)
    nl, nv = n.dot(to_lamp), ti.min(ti.max(n.dot(view), 1e-4), 1.0)
    share = 0.0
    if nl > 0.0:
        share = lamp_share(entries, scene, x + n * (0.6 * pixel), pixel)
    sky = sky_at(N, scene.sky, scene.open_sky, x + vector_at(N, CAMERA) + n * N[SKY_CELL])
    metal, rough = M[m, METAL], M[m, ROUGHNESS]
    at = nv * (ANGLES - 1.0)
    e = ti.min(ti.cast(at, ti.i32), ANGLES - 2)
    share_of = row_vector_3(E, m, e) + (row_vector_3(E, m, e + 1) - row_vector_3(E, m, e)) * (at - ti.cast(e, ti.f32))
    a, b, c = share_of[0], share_of[1], share_of[2]
    if rough <= SMOOTH:
        c = fresnel_of(nv, M[m, IOR])
    h = (to_lamp + view).normalized()
    vh, lobe = ti.max(h.dot(view), 0.0), 0.0
    if nl > 0.0:  # the lamp's disc widens the highlight
        alpha = ti.max(rough * rough, 0.5 * N[LAMP_TANGENT] + 1e-3)
        lobe = microfacets(nl, nv, ti.max(n.dot(h), 0.0), alpha) * nl * _FOUR_PI
    mirrored = n * (2.0 * n.dot(view)) - view
    schlick, dielectric = (1.0 - vh) ** 5, fresnel_of(vh, M[m, IOR]) * lobe
    blur = 1.0 - rough * (1.0 / 3.0)
    film = ti.Vector([0.0, 0.0, 0.0, 0.0])
    if N[MIRROR] == ti.cast(m, ti.f32):
        film = _mirrored(scene, n, nv, rough, column, row)
    # the sky as a smooth surface reflects it, dimmed as the sky's mean is here; a rough one reflects its even part
    around, even = ti.Vector([0.0, 0.0, 0.0]), 1.0
    if N[HAS_DOME] > 0.5:
        even = ti.min(1.5 * rough, 1.0)
        if even < 1.0:
            around = sky_radiance(scene.dome, mirrored[0], mirrored[1], mirrored[2])
    result = emission
    glow = ti.Vector([0.0] * 12)
    if ti.static(scene.glowing):
        dull = ti.select(N[MIRROR] == ti.cast(m, ti.f32), 1.0, rough)  # a mirror shows the particles themselves
        glow = glow_at(scene, x, n, view, dull, M[m, IOR], pixel)
    for k in ti.static(range(3)):
        lamp, slope = N[LAMP_COLOUR + k] * share, ti.Vector([sky[3 + 3 * k], sky[4 + 3 * k], sky[5 + 3 * k]])
        arriving = 4.0 * lamp * ti.max(nl, 0.0) + ti.max(sky[k] + (2.0 / 3.0) * slope.dot(n), 0.0)
        open_share = ti.min(sky[k] / ti.max(scene.open_sky[k], 1e-20), 1.0)
        reflected = even * ti.max(sky[k] + blur * slope.dot(mirrored), 0.0) + (1.0 - even) * around[k] * open_share
        reflected = film[k] + (1.0 - film[3]) * reflected
        if ti.static(scene.glowing):
            arriving += glow[k]
        painted = (1.0 - c) * arriving * albedo[k] + c * reflected + dielectric * lamp
        again = 1.0 + albedo[k] * (1.0 / ti.max(a + b, 1e-3) - 1.0)  # what a rough metal reflects twice
        bare = (albedo[k] * a + b) * reflected + (albedo[k] + (1.0 - albedo[k]) * schlick) * lobe * lamp
        if ti.static(scene.glowing):
            painted += glow[6 + k]
            bare += albedo[k] * glow[3 + k] + (1.0 - albedo[k]) * glow[9 + k]
            if rough >= DULL:
                bare += (albedo[k] * a + b) * glow[k]
        result[k] += (1.0 - metal) * painted + metal * bare * again
    if N[FOG_RATE] > 0.0:
        seen = exp(-ti.max(depth - N[FOG_START], 0.0) * N[FOG_RATE])
        air = vector_at(N, FOG_COLOUR)
        if N[FOG_IS_SKY] > 0.5:
            level = ti.max(-view[1], 0.02 * ti.sqrt(view[0] * view[0] + view[2] * view[2]))
            air = sky_radiance(scene.dome, -view[0], level, -view[2])
        result = result * seen + air * (1.0 - seen)
    return result


@ti.func
def _mirrored(scene: ti.template(), n, nv, rough, column, row):
    """(4,) light and coverage that the mirror shows in a pixel."""
    N = ti.static(scene.N)
    # the slopes of facets have the standard deviation alpha / sqrt(2); a reflected ray turns by twice the angle
    spread = 1.4142135 * rough * rough * N[SCALE]
    up = ti.Vector([n.dot(vector_at(N, RIGHT)), -n.dot(vector_at(N, UP))])
    length = up.norm()
    cosine, sine = 0.0, 1.0
    if length > 1e-6:
        cosine, sine = up[0] / length, up[1] / length
    x, y = ti.cast(column, ti.f32) + 0.5, ti.cast(row, ti.f32) + 0.5
    return mirrored_light(scene.T, scene.levels, scene.G, x, y, spread, spread * nv, cosine, sine)


@ti.func
def row_vector_3(E: ti.template(), m, k):
    return ti.Vector([E[m, k, 0], E[m, k, 1], E[m, k, 2]])
