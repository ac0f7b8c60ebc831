"""How much of a distant lamp's disc cloth hides from a point.

Triangles are listed in cells of a grid across the lamp's direction. A point looks into all cells that the cone from it to the
lamp's disc passes, up to the triangle nearest to the lamp, so a half-shadow is as wide as it is, however small the triangles are.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.lamp_shadows import LAMP_POINTS
from gen_art.renderer.surfaces.sheet_rows import GRID_CELL, GRID_CORNER, GRID_SHAPE, GRID_TOP, LAMP
from gen_art.renderer.surfaces.triangles import corner, edge_functions, edges_at, triangle_crossed

__all__ = ["sheet_shadow"]

_ALL = -1  # all bits of a set


@ti.func
def _length(x, y):
    return ti.sqrt(x * x + y * y)


@ti.func
def _face_shadow(hidden, V: ti.template(), faces: ti.template(), j, at, tangent, half_pixel, D: ti.template()):
    """The set `hidden` with the lamp's points that a triangle hides.

    at : (3,) the point in the lamp's frame
    """
    result = hidden
    p, q = corner(V, faces[j, 0], LAMP) - at, corner(V, faces[j, 1], LAMP) - at
    r = corner(V, faces[j, 2], LAMP) - at
    z = ti.Vector([p[2], q[2], r[2]])
    if z.max() > 0.0:
        c = half_pixel + tangent * z  # how far the lamp's rays are apart at each corner
        near = 1
        for k in ti.static(range(2)):
            side = ti.Vector([p[k], q[k], r[k]])
            if (side - abs(c)).min() > 0.0 or (side + abs(c)).max() < 0.0:
                near = 0
        if near == 1:
            E = edge_functions(p, q, r, c)
            # over all D: the least and the largest of each E, of their sum, and of their sum times the depth of the crossing
            least, most, total, times_depth = z, z, z * 0.0, z * 0.0
            for k in ti.static(range(3)):
                change = _length(E[k, 1], E[k, 2])
                least[k], most[k] = E[k, 0] - change, E[k, 0] + change
                for i in ti.static(range(3)):
                    total[i] += E[k, i]
                    times_depth[i] += E[k, i] * z[k]
            turns, rises = _length(total[1], total[2]), _length(times_depth[1], times_depth[2])
            before, behind = (
                0,
                0,
            )  # whether all of the triangle lies before the point where the rays cross it, or none of it
            if abs(total[0]) > turns:
                depth = times_depth[0] * ti.select(total[0] > 0.0, 1.0, -1.0)
                before, behind = ti.cast(depth > rises, ti.i32), ti.cast(depth < -rises, ti.i32)
            if behind == 0:
                if before == 1 and (least.min() > 0.0 or most.max() < 0.0):
                    result = ti.i64(_ALL)
                elif most.min() >= 0.0 or least.max() <= 0.0:
                    for k in range(LAMP_POINTS):
                        e = edges_at(E, D[k, 0], D[k, 1])
                        if triangle_crossed(e) and e.dot(z) * (e[0] + e[1] + e[2]) > 0.0:  # before the point
                            result |= ti.i64(1) << ti.cast(k, ti.i64)
    return result


@ti.func
def sheet_shadow(hidden, scene: ti.template(), x, to_lamp, side, up, tangent, half_pixel):
    """The set `hidden` with the lamp's points that cloth hides from x (relative to the camera)."""
    G = ti.static(scene.sheet_grid)
    result, at = hidden, ti.Vector([x.dot(side), x.dot(up), x.dot(to_lamp)])
    above = G[GRID_TOP] - at[2]
    if above > 0.0:
        cone, cells = half_pixel + tangent * above, ti.Vector([0, 0, 0, 0])
        for k in ti.static(range(2)):
            middle, last = (at[k] - G[GRID_CORNER + k]) / G[GRID_CELL], G[GRID_SHAPE + k] - 1.0
            low, high = ti.floor(middle - cone / G[GRID_CELL]), ti.floor(middle + cone / G[GRID_CELL])
            cells[2 * k] = ti.cast(ti.min(ti.max(low, 0.0), last + 1.0), ti.i32)
            cells[2 * k + 1] = ti.cast(ti.max(ti.min(high, last), -1.0), ti.i32)
        columns = ti.cast(G[GRID_SHAPE + 1], ti.i32)
        for i in range(cells[0], cells[1] + 1):
            for j in range(cells[2], cells[3] + 1):
                cell = i * columns + j
                k, end = scene.sheet_starts[cell], scene.sheet_starts[cell + 1]
                while k < end and result != ti.i64(_ALL):
                    face = scene.sheet_faces[k]
                    result = _face_shadow(result, scene.V, scene.faces, face, at, tangent, half_pixel, scene.D)
                    k += 1
    return result
