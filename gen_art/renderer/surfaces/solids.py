"""Balls, capsules and boxes: boxes with rounded edges, each a row of SOLID_FLOATS, and where rays meet them.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (`and` would follow each ray, whether it is needed or not)
from gen_art.backend.runtime import ti

__all__ = [
    "NEVER",
    "SOLID_FLOATS",
    "along_axes",
    "row_vector",
    "solid_facet",
    "solid_hit",
    "solid_normal",
    "solid_reaches_cone",
]

# a solid's row: centre relative to the camera, radius of the rounding, half extents inside it, its axes in the world (rows),
# albedo, emission, row of its material, radius of the ball around it, where on its image the middles of its sides lie (in images)
CENTER, RADIUS, HALF, AXES, ALBEDO, EMITTED, MATERIAL, BOUND, IMAGE_PLACE = 0, 3, 4, 7, 16, 19, 22, 23, 24
SOLID_FLOATS = 26
NEVER = 1e30  # distance along a ray that meets nothing
_NEWTON_STEPS = 24


@ti.func
def row_vector(B: ti.template(), i, k):
    """The three numbers of row i from column k on."""
    return ti.Vector([B[i, k], B[i, k + 1], B[i, k + 2]])


@ti.func
def along_axes(B: ti.template(), i, v):
    """A direction along the solid's axes."""
    return ti.Vector(
        [row_vector(B, i, AXES).dot(v), row_vector(B, i, AXES + 3).dot(v), row_vector(B, i, AXES + 6).dot(v)]
    )


@ti.func
def _rounded_entry(p, v, half, radius, low, high):
    """Where along a ray it enters a rounded box, or NEVER, by Newton's method, which does not pass the convex root.

    p, v : a point of the ray and its unit direction along the axes; low, high : where it enters and leaves the box around it
    """
    result, t, steps = NEVER, low, 0
    while steps < _NEWTON_STEPS:
        steps += 1
        x = p + v * t
        q = ti.max(abs(x) - half, 0.0)
        distance = q.norm() - radius
        if distance < 1e-5 * radius:
            result, steps = t, _NEWTON_STEPS
        else:
            slope = 0.0
            for k in ti.static(range(3)):
                slope += ti.select(x[k] < 0.0, -q[k], q[k]) * v[k]
            slope /= q.norm()
            t -= distance / ti.min(slope, -1e-6)
            if slope > -1e-6 or t > high:
                steps = _NEWTON_STEPS
    return result


@ti.func
def box_meets(p, v, half, radius, first, last):
    """1 if a ray meets a rounded box between two of its points, else 0.

    p, v : a point of the ray and its unit direction along the box's axes; first, last : lengths from p
    """
    low, high, met = first, last, 0
    for k in ti.static(range(3)):
        inverse = 1.0 / ti.select(abs(v[k]) > 1e-12, v[k], 1e-12)
        a, b = (-half[k] - radius - p[k]) * inverse, (half[k] + radius - p[k]) * inverse
        low, high = ti.max(low, ti.min(a, b)), ti.min(high, ti.max(a, b))
    if low <= high:
        if ti.max(abs(p + v * (0.5 * (low + high))) - half, 0.0).norm() <= radius:
            met = 1
        elif radius > 0.0:
            if _rounded_entry(p, v, half, radius, low, high) < NEVER:
                met = 1
    return met


@ti.func
def solid_hit(B: ti.template(), i, o, d, from_inside: ti.template()):
    """The distance along a ray (relative to the camera) at which it enters a solid, or NEVER.

    from_inside : whether a ray that starts inside meets it, at 0
    """
    c, radius = row_vector(B, i, CENTER) - o, B[i, RADIUS]
    along = c.dot(d)
    aside = c - d * along
    inside = B[i, BOUND] * B[i, BOUND] - aside.dot(aside)
    result = NEVER
    if inside > 0.0:
        reach = ti.sqrt(inside)
        half = row_vector(B, i, HALF)
        if half.max() == 0.0:
            if along > reach:
                result = along - reach
            elif from_inside and along > -reach:
                result = 0.0
        elif along + reach > 0.0:
            # from the point of the ray that is nearest to the centre, where float32 is exact enough
            p, v = -along_axes(B, i, aside), along_axes(B, i, d)
            low, high, outer = -reach, reach, half + radius
            for k in ti.static(range(3)):
                inverse = 1.0 / ti.select(abs(v[k]) > 1e-12, v[k], 1e-12)
                a, b = (-outer[k] - p[k]) * inverse, (outer[k] - p[k]) * inverse
                low, high = ti.max(low, ti.min(a, b)), ti.min(high, ti.max(a, b))
            if low <= high:
                if radius == 0.0:
                    if along + low > 0.0:
                        result = along + low
                    elif from_inside and along + high > 0.0:
                        result = 0.0
                else:
                    t = _rounded_entry(p, v, half, radius, low, high)
                    if t < NEVER:
                        if along + t > 0.0:
                            result = along + t
                        elif from_inside and (ti.max(abs(p - v * along) - half, 0.0)).norm() < radius:
                            result = 0.0
    return result


@ti.func
def solid_reaches_cone(B: ti.template(), i, offset, d, tangent, radius_at_start, far):
    """Whether a solid reaches into a cone of rays about a ray: 0 no, 1 perhaps in part, 2 it meets all of them.

    offset : of the solid's centre from where the ray starts; d : unit vector along it
    radius_at_start, tangent : the cone's radius where the ray starts, and by which it grows per length
    far : length of the ray
    """
    along, half, radius = offset.dot(d), row_vector(B, i, HALF), B[i, RADIUS]
    p, v = along_axes(B, i, d * along - offset), along_axes(B, i, d)
    # lengths along the ray from the point nearest to the centre; the cone's width at the far end of the solid
    low, high = -ti.min(along, B[i, BOUND]), ti.min(far - along, B[i, BOUND])
    first, last = low, high
    wide = radius_at_start + ti.max(along + B[i, BOUND], 0.0) * tangent
    for k in ti.static(range(3)):
        inverse = 1.0 / ti.select(abs(v[k]) > 1e-12, v[k], 1e-12)
        outer = half[k] + radius
        a, b = (-outer - p[k]) * inverse, (outer - p[k]) * inverse
        low, high = ti.max(low, ti.min(a, b)), ti.min(high, ti.max(a, b))
        a, b = (-outer - wide - p[k]) * inverse, (outer + wide - p[k]) * inverse
        first, last = ti.max(first, ti.min(a, b)), ti.min(last, ti.max(a, b))
    state = ti.select(first <= last, 1, 0)
    if low < high:  # as deep inside as the cone is wide, no ray of the cone gets past
        t = 0.5 * (low + high)
        beyond = abs(p + v * t) - half
        depth = radius - ti.max(beyond, 0.0).norm() - ti.min(beyond.max(), 0.0)
        if depth >= radius_at_start + (along + t) * tangent:
            state = 2
    return state


@ti.func
def solid_facet(B: ti.template(), i, x):
    """Of a box without rounding, the axis of its own that the face at x lies across; 0 for other solids."""
    result, half = 0, row_vector(B, i, HALF)
    if half.max() > 0.0 and B[i, RADIUS] == 0.0:
        beyond = abs(along_axes(B, i, x - row_vector(B, i, CENTER))) - half
        for k in ti.static(range(1, 3)):
            if beyond[k] > ti.max(beyond[0], beyond[3 - k]):
                result = k
    return result


@ti.func
def solid_normal(B: ti.template(), i, x):
    """The unit normal at a point of the surface, relative to the camera.

    A point that lies deeper than a rounded box's radius, by round-off where the radius is small, has the nearest face's normal.
    """
    r = x - row_vector(B, i, CENTER)
    n, half = r, row_vector(B, i, HALF)
    if half.max() > 0.0:
        local = along_axes(B, i, r)
        q, m = abs(local) - half, local * 0.0
        if B[i, RADIUS] > 0.0 and q.max() > 0.0:
            for k in ti.static(range(3)):
                m[k] = ti.select(local[k] < 0.0, -1.0, 1.0) * ti.max(q[k], 0.0)
        else:
            found = 0
            for k in ti.static(range(3)):
                if found == 0 and q[k] == q.max():
                    m[k] = ti.select(local[k] < 0.0, -1.0, 1.0)
                    found = 1
        n = row_vector(B, i, AXES) * m[0] + row_vector(B, i, AXES + 3) * m[1] + row_vector(B, i, AXES + 6) * m[2]
    return n.normalized()
