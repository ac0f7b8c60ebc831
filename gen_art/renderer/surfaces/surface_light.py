"""The light that arrives at a place of a surface: from the sky, and from the lamp past colliders, solids and smoke.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from gen_art.backend.runtime import ti
from gen_art.maths.elementary import exp
from gen_art.renderer.surfaces.lamp_shadows import (
    LAMP_POINTS,
    collider_shadow,
    in_shadow_cells,
    set_bits,
    shadow_cell,
    solid_shadow,
)
from gen_art.renderer.surfaces.scene_numbers import (
    BIN_SHAPE,
    CAMERA,
    LAMP_SIDE,
    LAMP_TANGENT,
    LAMP_UP,
    SHADOW_REACH,
    SHADOWS,
    SKY_CELL,
    SKY_ORIGIN,
    SKY_SHAPE,
    SMOKE_CELL,
    SMOKE_CORNER,
    SMOKE_SHAPE,
    TIME,
    TO_LAMP,
    vector_at,
)
from gen_art.renderer.surfaces.sheet_shadows import sheet_shadow
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["lamp_share", "sky_at"]


@ti.func
def sky_at(N: ti.template(), sky: ti.template(), open_sky: ti.template(), place):
    """(12,) coefficients of the sky's light at a world position: linear between the nodes, fading to the open sky outside."""
    result = ti.Vector([open_sky[k] for k in range(12)])
    if N[SKY_SHAPE] > 1.5:
        inside = 1.0
        cell, fraction = ti.Vector([0, 0, 0]), ti.Vector([0.0, 0.0, 0.0])
        for c in ti.static(range(3)):
            last = N[SKY_SHAPE + c] - 1.0
            at = (place[c] - N[SKY_ORIGIN + c]) / N[SKY_CELL]
            beyond = ti.max(ti.max(-at, at - last), 0.0)
            inside *= ti.max(1.0 - 2.0 * beyond / last, 0.0)
            at = ti.min(ti.max(at, 0.0), last - 1e-3)
            cell[c] = ti.cast(at, ti.i32)
            fraction[c] = at - ti.cast(cell[c], ti.f32)
        if inside > 0.0:
            rows, columns = ti.cast(N[SKY_SHAPE + 1], ti.i32), ti.cast(N[SKY_SHAPE + 2], ti.i32)
            here = result * 0.0
            for corner in range(8):
                i, j, k = corner >> 2, (corner >> 1) & 1, corner & 1
                weight = ti.select(i == 1, fraction[0], 1.0 - fraction[0])
                weight *= ti.select(j == 1, fraction[1], 1.0 - fraction[1])
                weight *= ti.select(k == 1, fraction[2], 1.0 - fraction[2])
                node = ((cell[0] + i) * rows + cell[1] + j) * columns + cell[2] + k
                for c in ti.static(range(12)):
                    here[c] += weight * sky[node, c]
            result += (here - result) * inside
    return result


@ti.func
def smoke_depth(N: ti.template(), depth: ti.template(), place):
    """Optical depth of smoke between the lamp and a world position; the grid's third axis is the direction of its light."""
    result = 0.0
    if N[SMOKE_SHAPE] > 1.5:
        to_lamp = vector_at(N, TO_LAMP)
        at = ti.Vector([place.dot(vector_at(N, LAMP_SIDE)), place.dot(vector_at(N, LAMP_UP)), -place.dot(to_lamp)])
        cell, fraction, inside = ti.Vector([0, 0, 0]), ti.Vector([0.0, 0.0, 0.0]), 1
        for c in ti.static(range(3)):
            last = N[SMOKE_SHAPE + c] - 1.0
            node = at[c] / N[SMOKE_CELL] - N[SMOKE_CORNER + c]
            if node < 0.0 or (c < 2 and node > last):
                inside = 0
            node = ti.min(ti.max(node, 0.0), last - 1e-3)
            cell[c] = ti.cast(node, ti.i32)
            fraction[c] = node - ti.cast(cell[c], ti.f32)
        if inside == 1:
            rows, columns = ti.cast(N[SMOKE_SHAPE + 1], ti.i32), ti.cast(N[SMOKE_SHAPE + 2], ti.i32)
            for corner in range(8):
                i, j, k = corner >> 2, (corner >> 1) & 1, corner & 1
                weight = ti.select(i == 1, fraction[0], 1.0 - fraction[0])
                weight *= ti.select(j == 1, fraction[1], 1.0 - fraction[1])
                weight *= ti.select(k == 1, fraction[2], 1.0 - fraction[2])
                result += weight * depth[((cell[0] + i) * rows + cell[1] + j) * columns + cell[2] + k]
    return result


def _given(nearby) -> bool:
    """Whether a list of solids was passed; `is` cannot be written in a kernel."""
    return nearby is not None


@ti.func
def lamp_share(kinds: ti.template(), scene: ti.template(), x, pixel, casters, own=-1, nearby: ti.template() = None):
    """The share of the lamp's light that reaches x (relative to the camera) past colliders, solids and smoke.

    scene : view of the kernel's arrays; its `with_sheets` says whether there is any cloth
    pixel : side of a pixel at x, in world units
    casters : (3,) i64, of tile_casters: the set of the colliders that may hide the lamp; the number of solids in `nearby`
    own : a solid that does not hide it, or -1
    nearby : the solids that may hide it, where that number is not negative; or None
    """
    share = 1.0
    N = ti.static(scene.N)
    if N[SHADOWS] > 0.5:
        place, half_pixel, tangent = x + vector_at(N, CAMERA), 0.5 * pixel, N[LAMP_TANGENT]
        to_lamp, side, up = vector_at(N, TO_LAMP), vector_at(N, LAMP_SIDE), vector_at(N, LAMP_UP)
        hidden = collider_shadow(
            kinds,
            scene.Q,
            place,
            to_lamp,
            side,
            up,
            tangent,
            half_pixel,
            N[TIME],
            N[SHADOW_REACH],
            scene.D,
            LAMP_POINTS,
            casters[0],
        )
        k, end, listed = 0, 0, 0
        if ti.static(_given(nearby)):
            listed, end = ti.cast(casters[2] >= 0, ti.i32), ti.cast(ti.max(casters[2], 0), ti.i32)
        if listed == 0:
            at = shadow_cell(N, place, 0.0)
            if in_shadow_cells(N, at[0], at[1]):
                cell = at[0] * ti.cast(N[BIN_SHAPE + 1], ti.i32) + at[1]
                k, end = scene.shadow_starts[cell], scene.shadow_starts[cell + 1]
        while k < end:
            solid = -1
            if ti.static(_given(nearby)):
                if listed == 1:
                    solid = nearby[k]
            if listed == 0:
                solid = scene.shadow_solids[k]
            if solid != own:
                hidden = solid_shadow(
                    hidden, scene.B, solid, x, to_lamp, side, up, tangent, half_pixel, NEVER, scene.D, LAMP_POINTS
                )
            k = ti.select(hidden == ti.i64(-1), end, k + 1)
        if ti.static(scene.with_sheets):
            hidden = sheet_shadow(hidden, scene, x, to_lamp, side, up, tangent, half_pixel)
        share = 1.0 - ti.cast(set_bits(hidden), ti.f32) * (1.0 / LAMP_POINTS)
        if share > 0.0:
            share *= exp(-smoke_depth(N, scene.smoke, place))
    return share
