"""Cloth in the tile kernel: which triangles its rays meet, and what cloth is like where they do.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from gen_art.backend.runtime import ti
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.surfaces.pixel_rays import FACETS, SUBPIXELS, ray_limits, subpixel
from gen_art.renderer.surfaces.scene_numbers import (
    FORWARD,
    PARALLEL,
    ROWS,
    SCALE,
    TO_LAMP,
    WIDTH,
    camera_ray,
    vector_at,
)
from gen_art.renderer.surfaces.sheet_rows import (
    ALBEDO,
    BACK,
    EMITTED,
    HAS_BACK,
    NORMAL,
    ON_SHEET,
    PLACE,
    SHEET_MATERIAL,
    TRANSLUCENCY,
    VIEW,
)
from gen_art.renderer.surfaces.surface_axes import pixel_steps
from gen_art.renderer.surfaces.surface_detail import IMAGE
from gen_art.renderer.surfaces.surface_images import has_image, image_over
from gen_art.renderer.surfaces.triangles import corner, depth_of, edge_functions, edges_at, triangle_crossed

__all__ = ["middle_distance", "sheet_material", "sheet_velocity", "trace_face"]


@ti.func
def trace_face(scene: ti.template(), j, who, box, ox, oy, distance: ti.template(), owner: ti.template()):
    """Put a triangle into the rays of the tile at (ox, oy) where it is nearer.

    box : (4,) first and last column, first and last row of the tile that it may cover
    """
    N, V, faces = ti.static(scene.N, scene.V, scene.faces)
    # relative to the ray through the tile's middle, where float32 is exact enough
    half = 0.5 * TILE
    u, v = (
        (ti.cast(ox, ti.f32) + half - 0.5 * N[WIDTH]) / N[SCALE],
        (0.5 * N[ROWS] - ti.cast(oy, ti.f32) - half) / N[SCALE],
    )
    p, q, r = corner(V, faces[j, 0], VIEW), corner(V, faces[j, 1], VIEW), corner(V, faces[j, 2], VIEW)
    c = ti.Vector([1.0, 1.0, 1.0])
    if N[PARALLEL] < 0.5:
        c = ti.Vector([p[2], q[2], r[2]])
    p[0], p[1] = p[0] - u * c[0], p[1] - v * c[0]
    q[0], q[1] = q[0] - u * c[1], q[1] - v * c[1]
    r[0], r[1] = r[0] - u * c[2], r[1] - v * c[2]
    E = edge_functions(p, q, r, c)
    for row in range(box[2], box[3] + 1):
        for column in range(box[0], box[1] + 1):
            for s in range(SUBPIXELS):
                place = subpixel(s)
                across, down = ti.cast(column, ti.f32) + place[0], ti.cast(row, ti.f32) + place[1]
                e = edges_at(E, (across - half) / N[SCALE], (half - down) / N[SCALE])
                if triangle_crossed(e):
                    t, ray = depth_of(e, p, q, r), (row * TILE + column) * SUBPIXELS + s
                    o, d = camera_ray(N, ti.cast(ox, ti.f32) + across, ti.cast(oy, ti.f32) + down)
                    if N[PARALLEL] < 0.5:
                        t /= d.dot(vector_at(N, FORWARD))
                    low, high = ray_limits(N, o, d)
                    if t >= low and t <= high and t < distance[ray]:
                        distance[ray], owner[ray] = t, who * FACETS


@ti.func
def middle_distance(N: ti.template(), distance: ti.template(), first):
    """The distance to a plane along the ray through a pixel's middle, from those of its SUBPIXELS rays."""
    total = 0.0
    for s in range(SUBPIXELS):
        total += ti.select(N[PARALLEL] > 0.5, distance[first + s], 1.0 / distance[first + s])
    total /= ti.cast(SUBPIXELS, ti.f32)
    return ti.select(N[PARALLEL] > 0.5, total, 1.0 / total)


@ti.func
def _weights(p, q, r, g, x):
    """(3,) weights, of sum 1, of the corners of a triangle with the normal g at the point x of its plane."""
    square = ti.max(g.dot(g), 1e-30)
    result = ti.Vector([(q - x).cross(r - x).dot(g), (r - x).cross(p - x).dot(g), (p - x).cross(q - x).dot(g)]) / square
    result = ti.max(result, 0.0)
    return result / ti.max(result.sum(), 1e-30)


@ti.func
def sheet_velocity(scene: ti.template(), velocities: ti.template(), j, x):
    """The velocity of triangle j at x (relative to the camera), between those of the corners."""
    V, faces = ti.static(scene.V, scene.faces)
    i = ti.Vector([faces[j, 0], faces[j, 1], faces[j, 2]])
    p, q, r = corner(V, i[0], PLACE), corner(V, i[1], PLACE), corner(V, i[2], PLACE)
    w = _weights(p, q, r, (q - p).cross(r - p), x)
    return corner(velocities, i[0], 0) * w[0] + corner(velocities, i[1], 0) * w[1] + corner(velocities, i[2], 0) * w[2]


@ti.func
def _image_on_sheet(scene: ti.template(), i, m, albedo, w, g, sides, view, pixel):
    """The albedo (3,) of a sheet under its material's image.

    i : corners of the triangle; w : their weights; g : normal of the triangle, twice as long as its area is large
    sides : (3, 3), rows: the side opposite to each corner
    """
    V = ti.static(scene.V)
    east, south = pixel_steps(scene.N, g.normalized(), -view, pixel)
    at, right, down = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
    for c in ti.static(range(3)):
        place = ti.Vector([V[i[c], ON_SHEET], V[i[c], ON_SHEET + 1]])
        side = ti.Vector([sides[c, 0], sides[c, 1], sides[c, 2]])
        at += place * w[c]
        right += place * (east.cross(side).dot(g) / g.dot(g))
        down += place * (south.cross(side).dot(g) / g.dot(g))
    return image_over(scene, m, IMAGE, albedo, at, right, down)


@ti.func
def sheet_material(scene: ti.template(), j, x, view, pixel):
    """What cloth is like where a ray meets triangle j at x (relative to the camera).

    view : unit vector to the camera; pixel : side of a pixel at x, in world units
    Returns (unit normal towards the camera, x moved onto the smooth sheet, row of the material, the part of the light that is
    scattered on this side, the part that comes through, emission). Of the albedo A with the translucency T, (1 - T) A is
    scattered and T A goes to the other side; with two colours, T times the lesser of the two does.
    The triangles of a bent sheet lie inside of it, so that its points would be shadowed by triangles beside them. x is moved out,
    to the mean of its feet on the tangent planes of the corners. Source: Hanika, Hacking the Shadow Terminator (2021).
    """
    N, V, faces, L = ti.static(scene.N, scene.V, scene.faces, scene.sheet_looks)
    i = ti.Vector([faces[j, 0], faces[j, 1], faces[j, 2]])
    k = faces[j, 3]
    p, q, r = corner(V, i[0], PLACE), corner(V, i[1], PLACE), corner(V, i[2], PLACE)
    g = (q - p).cross(r - p)
    w = _weights(p, q, r, g, x)
    front = g.dot(view) >= 0.0
    n, albedo, emission = x * 0.0, x * 0.0, x * 0.0
    for c in ti.static(range(3)):
        n += w[c] * corner(V, i[c], NORMAL)
        albedo += w[c] * corner(V, i[c], ALBEDO)
        emission += w[c] * corner(V, i[c], EMITTED)
    if n.dot(g) <= 1e-6 * ti.sqrt(g.dot(g)):  # folded at a point
        n = g
    n = n.normalized() * ti.select(front, 1.0, -1.0)
    # of a coarse sheet, the smooth normal may turn away where the triangle does not
    turned = n.dot(view)
    if turned < 1e-3:
        n = (n + view * (1e-3 - turned)).normalized()
    moved = x
    outwards = ti.select((n.dot(vector_at(N, TO_LAMP)) >= 0.0) == front, 1.0, -1.0)  # the side of the lamp
    for c in ti.static(range(3)):
        out = corner(V, i[c], NORMAL) * outwards
        moved += out * (w[c] * ti.max((corner(V, i[c], PLACE) - x).dot(out), 0.0))
    m = ti.cast(L[k, SHEET_MATERIAL], ti.i32)
    if ti.static(scene.mapped):
        if has_image(scene.M, m, IMAGE) and g.dot(g) > 0.0:
            albedo = _image_on_sheet(scene, i, m, albedo, w, g, ti.Matrix.rows([q - r, r - p, p - q]), view, pixel)
    here, other = albedo, albedo
    if L[k, HAS_BACK] > 0.5:
        back = corner(L, k, BACK)
        here, other = ti.select(front, albedo, back), ti.select(front, back, albedo)
    through = L[k, TRANSLUCENCY] * ti.min(here, other)
    scattered = here * (1.0 - L[k, TRANSLUCENCY])
    return n, moved, m, scattered, through, emission
