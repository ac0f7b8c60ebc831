"""Tiles that one plain surface fills, in a light that varies little over them: shaded in nine pixels, even in between.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.preset.surface import TRACED_ROUGHNESS
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.surfaces.collider_rays import without_itself
from gen_art.renderer.surfaces.ray_tree import LIGHT_PARTS
from gen_art.renderer.surfaces.scene_numbers import LAMP_TANGENT, LIQUID_CELL, PHOTON_CELL, SCALE
from gen_art.renderer.surfaces.solids import MATERIAL
from gen_art.renderer.surfaces.surface_detail import (
    CHECKER,
    IMAGE,
    LIGHT,
    PUDDLES,
    RELIEF,
    ROUGHNESS,
    TRANSMISSION,
    WAVES,
)

__all__ = ["NODES", "even_light", "is_even", "may_be_even", "node_pixel"]

NODES = 9  # pixels of a tile that are shaded, in three rows and columns: the first, the middle and the last
_MIDDLE, _LAST = TILE // 2, TILE - 1
_EVEN = 0.008  # of the light: the most by which a node between two others may differ from a straight line
_KINDS = LIGHT_PARTS // 3
_LOBE = 4.0  # pixels: the least width of the lamp's highlight, so that no node misses it


@ti.func
def node_pixel(node):
    """The number of a node's pixel in its tile."""
    return _place(node // 3) * TILE + _place(node % 3)


@ti.func
def _place(k):
    return ti.select(k == 2, _LAST, k * _MIDDLE)


@ti.func
def may_be_even(
    kinds: ti.template(), surfaces: ti.template(), follows: ti.template(), scene: ti.template(), owner, casters
):
    """1 if nothing but the angle of the view and the distance changes the light over a tile, as far as its lists say; else 0.

    owner : the surface or solid that fills the tile; casters : of tile_casters
    """
    N, M = ti.static(scene.N, scene.M)
    m = 0
    if owner < surfaces:
        if ti.static(surfaces > 0):
            m = scene.owners[owner]
    else:
        m = ti.cast(scene.B[owner - surfaces, MATERIAL], ti.i32)
    patterned = M[m, CHECKER]
    if ti.static(scene.mapped):
        for first in ti.static((IMAGE, PUDDLES, LIGHT, RELIEF, WAVES)):
            patterned += M[m, first + 1]
    rough = M[m, ROUGHNESS]
    plain = patterned == 0.0 and M[m, TRANSMISSION] == 0.0
    if ti.static(follows):
        plain = plain and rough > TRACED_ROUGHNESS
    wide = ti.max(rough * rough, 0.5 * N[LAMP_TANGENT]) * N[SCALE] > _LOBE
    hiding = without_itself(kinds, casters[0], owner) | without_itself(kinds, casters[1], owner)
    shadowed = hiding != ti.i64(0) or casters[2] != ti.i64(0)
    through = N[PHOTON_CELL] > 0.0 or N[LIQUID_CELL] > 0.0
    return ti.cast(plain and wide and not shadowed and not through, ti.i32)


@ti.func
def is_even(nodes: ti.template()):
    """1 if the light varies so evenly from node to node that what lies between follows from them, else 0.

    nodes : (NODES * LIGHT_PARTS,) as light_along returns them
    """
    brightest, even = ti.Vector([0.0] * _KINDS), 1  # colour of each kind of part in the tile's middle
    for k in ti.static(range(_KINDS)):
        for c in ti.static(range(3)):
            brightest[k] = ti.max(brightest[k], abs(nodes[4 * LIGHT_PARTS + 3 * k + c]))
    # own light and the lamp's are seen as one
    brightest[0] = ti.max(brightest[0], brightest[1])
    brightest[1] = brightest[0]
    for line in range(6):
        first, step = ti.select(line < 3, 3 * line, line - 3), ti.select(line < 3, 1, 3)
        for k in range(LIGHT_PARTS):
            a, b = nodes[first * LIGHT_PARTS + k], nodes[(first + 2 * step) * LIGHT_PARTS + k]
            straight = a + (b - a) * (_MIDDLE / _LAST)
            if not abs(nodes[(first + step) * LIGHT_PARTS + k] - straight) <= _EVEN * brightest[k // 3]:
                even = 0
    return even


@ti.func
def even_light(nodes: ti.template(), pixel, parts):
    """(LIGHT_PARTS,) of a pixel of a tile, linear along rows and columns between the nodes; zeros from number `parts` on."""
    row, column = pixel // TILE, pixel % TILE
    i, j = ti.cast(row >= _MIDDLE, ti.i32), ti.cast(column >= _MIDDLE, ti.i32)
    down = ti.cast(row - i * _MIDDLE, ti.f32) / ti.select(i == 1, 1.0 * (_LAST - _MIDDLE), 1.0 * _MIDDLE)
    across = ti.cast(column - j * _MIDDLE, ti.f32) / ti.select(j == 1, 1.0 * (_LAST - _MIDDLE), 1.0 * _MIDDLE)
    first, result = (3 * i + j) * LIGHT_PARTS, ti.Vector([0.0] * LIGHT_PARTS)
    for k in range(parts):
        left, right = nodes[first + k], nodes[first + LIGHT_PARTS + k]
        left += (nodes[first + 3 * LIGHT_PARTS + k] - left) * down
        right += (nodes[first + 4 * LIGHT_PARTS + k] - right) * down
        result[k] = left + (right - left) * across
    return result
