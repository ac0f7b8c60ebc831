"""The light that emitting particles send to a place of a surface, past solids and colliders.

The tree of light_tree.py is walked for each pixel. A node that is far enough stands for its lights by the expansion of its
irradiance to second order; of a leaf near by, each light counts by itself. Each part of the tree, a lamp, is shadowed as a
disc of the size of its cluster. Planes cast no shadows of it.

A place of a smooth surface also reflects each node and each light, as a highlight that is as wide as it.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.collider_sets import ALL_COLLIDERS
from gen_art.renderer.surfaces.lamp_shadows import collider_shadow, set_bits, solid_shadow
from gen_art.renderer.surfaces.light_tree import (
    FIRST,
    HIGH,
    LIGHT_POWER,
    LIGHT_W,
    LOW,
    POWER,
    RADIUS,
    SECOND,
    USED_FROM,
    W,
)
from gen_art.renderer.surfaces.near_bins import COLUMNS, ROWS, near_cell
from gen_art.renderer.surfaces.reflection import fresnel_of, microfacets
from gen_art.renderer.surfaces.scene_numbers import CAMERA, SHADOWS, TIME, vector_at

__all__ = ["DULL", "GLOW_POINTS", "LAMP_FLOATS", "LAMP_RADIUS", "SOFTENING2", "glow_at"]

# a lamp's row: centre relative to the camera, radius of its disc, square of the softening
LAMP_RADIUS, SOFTENING2, LAMP_FLOATS = 3, 4, 5
_FINER = 2.0  # factor on the distance from which a node is used where it makes a highlight: without it, edges show
GLOW_POINTS = 16  # of a lamp's disc; the lamps together have up to eight times as many
_STRADDLES = 0.04  # a node through which the surface's plane goes is used where its radius is this part of its distance
_INVERSE_PI = 0.3183098861837907
DULL = 0.8  # roughness from which no highlights are computed; a rough metal scatters this light evenly


@ti.func
def _row3(A: ti.template(), i, k):
    return ti.Vector([A[i, k], A[i, k + 1], A[i, k + 2]])


@ti.func
def _falloff(q, softening2, low, high):
    """Mean of min(1 / (q + s^2), w) over the two values of w, and its first two derivatives by q."""
    outside = 1.0 / ti.max(q + softening2, 1e-30)
    h, h1, h2 = 0.0, 0.0, 0.0
    for k in ti.static(range(2)):
        w = low if ti.static(k == 0) else high
        if w < outside:
            h += 0.5 * w
        else:
            h += 0.5 * outside
            h1 -= 0.5 * outside * outside
            h2 += outside * outside * outside
    return h, h1, h2


@ti.func
def _highlight(total: ti.template(), n, to_light, view, power, width, alpha, ior):
    """Add what facets reflect of the irradiance `power` across the direction to a light to total[3..11]: all of it, its part
    by Fresnel's formula, and its part by Schlick's (1 - vh)^5.

    width : tangent of half the light's angle
    """
    nl, nv = n.dot(to_light), ti.max(n.dot(view), 1e-4)
    if nl > 0.0:
        half = (to_light + view).normalized()
        vh = ti.max(half.dot(view), 0.0)
        lobe = microfacets(nl, nv, ti.max(n.dot(half), 0.0), ti.max(alpha, 0.5 * width + 1e-3)) * nl
        fresnel, schlick = fresnel_of(vh, ior), (1.0 - vh) ** 5
        for k in ti.static(range(3)):
            total[3 + k] += lobe * power[k]
            total[6 + k] += lobe * power[k] * fresnel
            total[9 + k] += lobe * power[k] * schlick


@ti.func
def _light_of_part(scene: ti.template(), first, end, softening2, x, n, view, alpha, ior):
    """(12,) irradiance over pi from a part of the tree, then the highlights; without shadows."""
    T, I, L = ti.static(scene.glow_nodes, scene.glow_links, scene.glow_lights)
    total = ti.Vector([0.0] * 12)
    node = first
    while node < end:
        r = _row3(T, node, 0) - x
        q, height = r.dot(r), n.dot(r)
        bottom, top = height, height
        for c in ti.static(range(3)):
            bottom += ti.min(n[c] * T[node, LOW + c], n[c] * T[node, HIGH + c])
            top += ti.max(n[c] * T[node, LOW + c], n[c] * T[node, HIGH + c])
        following = I[node, 2]
        if top > 0.0:
            reach = T[node, USED_FROM]
            if bottom < 0.0:
                reach = T[node, RADIUS] * (1.0 / _STRADDLES)
            elif alpha >= 0.0:
                reach *= _FINER
            if q > reach * reach:
                inverse = 1.0 / ti.sqrt(q)
                qi = inverse * inverse
                h, h1, h2 = _falloff(q, softening2, T[node, W], T[node, W + 1])
                g, power = inverse * h, _row3(T, node, POWER)
                if bottom < 0.0:
                    for k in ti.static(range(3)):
                        total[k] += power[k] * ti.max(height, 0.0) * g
                else:
                    g1, g2 = inverse * (h1 - 0.5 * qi * h), inverse * (h2 - qi * h1 + 0.75 * qi * qi * h)
                    a, b = _row3(T, node, SECOND), _row3(T, node, SECOND + 3)
                    u = ti.Vector(
                        [
                            a[0] * r[0] + b[0] * r[1] + b[1] * r[2],
                            b[0] * r[0] + a[1] * r[1] + b[2] * r[2],
                            b[1] * r[0] + b[2] * r[1] + a[2] * r[2],
                        ]
                    )
                    mean = height * g + g1 * (2.0 * n.dot(u) + height * (a[0] + a[1] + a[2]))
                    mean += 2.0 * g2 * height * r.dot(u)
                    for k in ti.static(range(3)):
                        d = _row3(T, node, FIRST + 3 * k)
                        total[k] += ti.max(power[k] * mean + g * n.dot(d) + 2.0 * g1 * height * r.dot(d), 0.0)
                if alpha >= 0.0:
                    spread = ti.sqrt(ti.max(T[node, SECOND] + T[node, SECOND + 1] + T[node, SECOND + 2], 0.0))
                    _highlight(total, n, r * inverse, view, power * h, 1.4 * spread * inverse, alpha, ior)
            elif I[node, 1] == 0:
                following = node + 1
            else:
                for i in range(I[node, 0], I[node, 0] + I[node, 1]):
                    o = _row3(L, i, 0) - x
                    q_i, height_i = o.dot(o), n.dot(o)
                    if height_i > 0.0:
                        inverse = 1.0 / ti.sqrt(q_i)
                        h = ti.min(1.0 / ti.max(q_i + softening2, 1e-30), L[i, LIGHT_W])
                        power = _row3(L, i, LIGHT_POWER)
                        for k in ti.static(range(3)):
                            total[k] += power[k] * height_i * inverse * h
                        if alpha >= 0.0:
                            size = ti.sqrt(1.0 / ti.max(L[i, LIGHT_W], 1e-30))
                            _highlight(total, n, o * inverse, view, power * h, size * inverse, alpha, ior)
        node = following
    for k in ti.static(range(3)):
        total[k] *= _INVERSE_PI
    return total


@ti.func
def _share_of_lamp(scene: ti.template(), lamp, x, n, pixel, own):
    """The share of a lamp's disc that a place sees; n, own : of glow_at."""
    N, H = ti.static(scene.N, scene.glow_lamps)
    offset = _row3(H, lamp, 0) - x
    distance = ti.max(offset.norm(), 1e-20)
    to_lamp = offset / distance
    side = ti.Vector([to_lamp[2], 0.0, -to_lamp[0]])
    if abs(to_lamp[1]) > 0.9:
        side = ti.Vector([0.0, -to_lamp[2], to_lamp[1]])
    side = side.normalized()
    up = to_lamp.cross(side)
    tangent, half_pixel = ti.min(H[lamp, LAMP_RADIUS] / distance, 1.0), 0.5 * pixel
    place = x + vector_at(N, CAMERA)
    hidden = collider_shadow(
        scene.near_casters,
        scene.Q,
        place,
        to_lamp,
        side,
        up,
        tangent,
        half_pixel,
        N[TIME],
        distance,
        scene.near_disc,
        GLOW_POINTS,
        ti.i64(ALL_COLLIDERS),
    )
    cell = lamp * ROWS * COLUMNS + near_cell(-to_lamp)
    spared = ti.select(n.dot(to_lamp) > tangent, own, -1)  # a convex solid does not hide what shines on its outside
    k, end = scene.near_starts[cell], scene.near_starts[cell + 1]
    while k < end:
        solid = scene.near_solids[k]
        if solid != spared:
            hidden = solid_shadow(
                hidden,
                scene.B,
                solid,
                x,
                to_lamp,
                side,
                up,
                tangent,
                half_pixel,
                distance,
                scene.near_disc,
                GLOW_POINTS,
            )
        k = ti.select(hidden == ti.i64(-1), end, k + 1)
    return ti.max(1.0 - ti.cast(set_bits(hidden), ti.f32) * (1.0 / GLOW_POINTS), 0.0)


@ti.func
def glow_at(scene: ti.template(), x, n, view, rough, ior, pixel, own=-1):
    """(12,) what reaches x (relative to the camera) from emitting particles, in three colours each: the irradiance over pi, then
    the irradiance times the facets' lobe, the same times Fresnel's reflectance, and times (1 - vh)^5.

    scene : view of the kernel's arrays
    n, view : unit normal, and unit vector to the camera
    pixel : side of a pixel at x, in world units
    own : the solid on which x lies, or -1
    """
    N, H = ti.static(scene.N, scene.glow_lamps)
    total = ti.Vector([0.0] * 12)
    alpha = ti.select(rough < DULL, rough * rough, -1.0)
    for lamp in range(scene.glow_parts.shape[0]):
        part = _light_of_part(
            scene, scene.glow_parts[lamp, 0], scene.glow_parts[lamp, 1], H[lamp, SOFTENING2], x, n, view, alpha, ior
        )
        if part.max() > 0.0 and N[SHADOWS] > 0.5:
            part *= _share_of_lamp(scene, lamp, x + n * (0.6 * pixel), n, pixel, own)
        total += part
    return total
