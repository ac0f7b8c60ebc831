"""Which solids may hide the light of emitting particles from the places of a tile of the picture.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.glow_light import DULL, LAMP_RADIUS
from gen_art.renderer.surfaces.lamp_shadows import SOLIDS_OF_TILE
from gen_art.renderer.surfaces.near_bins import COLUMNS, ROWS, near_cell
from gen_art.renderer.surfaces.scene_numbers import MIRROR
from gen_art.renderer.surfaces.solids import BOUND, CENTER, row_vector, solid_reaches_cone
from gen_art.renderer.surfaces.surface_detail import CHECKER, IMAGE, METAL, PUDDLES, ROUGHNESS
from gen_art.renderer.surfaces.surface_maps import PER_WIDTH

__all__ = ["list_glow_solids", "shows_no_glow"]

_MOST_CELLS = 2  # of NearBins that a tile may reach into, along both sides


@ti.func
def shows_no_glow(scene: ti.template(), m):
    """Whether a collider's material shows no light of particles: it is black and dull, or the mirror, which shows them."""
    N, M = ti.static(scene.N, scene.M)
    black = M[m, 0] + M[m, 1] + M[m, 2] == 0.0 and M[m, METAL] == 0.0 and M[m, CHECKER] == 0.0
    black = black and M[m, IMAGE + PER_WIDTH] == 0.0
    return black and (N[MIRROR] == ti.cast(m, ti.f32) or (M[m, ROUGHNESS] >= DULL and M[m, PUDDLES + PER_WIDTH] == 0.0))


@ti.func
def list_glow_solids(scene: ti.template(), middle, radius, nearby: ti.template()):
    """List the solids that may hide the lamps of a LightTree from places in the ball of a tile.

    nearby : its numbers from SOLIDS_OF_TILE on take them, each as 256 times the solid plus the set of lamps, as bits
    Returns 256 times the set of lamps of which nothing is known, plus the number of solids in the list.
    """
    H = ti.static(scene.glow_lamps)
    count, unknown = 0, 0
    for lamp in range(scene.glow_parts.shape[0]):
        offset, width = ti.Vector([H[lamp, 0], H[lamp, 1], H[lamp, 2]]) - middle, H[lamp, LAMP_RADIUS]
        distance, found = offset.norm(), -1
        if distance > 2.0 * (radius + width):
            found = _with_lamp(scene, lamp, middle, radius, offset / distance, distance, width, nearby, count)
        if found < 0:
            unknown |= 1 << lamp
        else:
            count = found
    return (unknown << 8) | count


@ti.func
def _with_lamp(scene: ti.template(), lamp, middle, radius, to_lamp, distance, width, nearby: ti.template(), listed):
    """Add what may hide one lamp; `listed` solids are there already. Returns the new number, or -1 where that is not known."""
    B = ti.static(scene.B)
    count = listed
    # all places of the ball lie within this angle: 1.05 is more than angle / sine for a sine of a half
    angle, at = 1.05 * radius / distance, near_cell(-to_lamp)
    level = ti.sqrt(ti.max(1.0 - to_lamp[1] * to_lamp[1], 0.0)) - angle
    rows, columns = angle * (0.5 * ROWS), angle / ti.max(level, 1e-6) * (0.25 * COLUMNS)
    first = ti.cast(ti.floor(ti.Vector([at[0] - rows, at[1] - columns])), ti.i32)
    last = ti.cast(ti.floor(ti.Vector([at[0] + rows, at[1] + columns])), ti.i32)
    if (last - first).max() >= _MOST_CELLS or level < angle:
        count = -1
    # rays from the ball to the lamp stay in a cone that starts behind the ball
    start, tangent, cell = middle - to_lamp * radius, width / (distance - width), 0
    while cell < _MOST_CELLS * _MOST_CELLS and count >= 0:
        row, column = first[0] + cell // _MOST_CELLS, first[1] + cell % _MOST_CELLS
        cell += 1
        if row >= 0 and row < ROWS and row <= last[0] and column <= last[1]:
            here = (lamp * ROWS + row) * COLUMNS + (column + COLUMNS) % COLUMNS
            k, end = scene.near_starts[here], scene.near_starts[here + 1]
            while k < end and count >= 0:
                solid = scene.near_solids[k]
                k += 1
                offset = row_vector(B, solid, CENTER) - start
                along = offset.dot(to_lamp)
                reach = B[solid, BOUND] + radius + ti.max(along + B[solid, BOUND], 0.0) * tangent
                reaches = along > -reach and offset.dot(offset) - along * along < reach * reach * (
                    1.0 + tangent * tangent
                )
                if reaches:
                    reaches = (
                        solid_reaches_cone(B, solid, offset, to_lamp, tangent, radius, distance + radius + width) > 0
                    )
                if reaches:
                    count = _listed_with(nearby, count, solid, lamp)
    return count


@ti.func
def _listed_with(nearby: ti.template(), count, solid, lamp):
    """Note that a solid may hide a lamp; returns the new number of listed solids, or -1 where there is no room."""
    result, place = count, -1
    for k in range(SOLIDS_OF_TILE, SOLIDS_OF_TILE + count):
        if nearby[k] >> 8 == solid:
            place = k
    if place < 0:
        if count < SOLIDS_OF_TILE:
            place, result = SOLIDS_OF_TILE + count, count + 1
            nearby[place] = solid << 8
        else:
            result = -1
    if place >= 0:
        nearby[place] |= 1 << lamp
    return result
