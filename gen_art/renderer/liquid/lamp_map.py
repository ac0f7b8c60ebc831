"""The map of the lamp's light through liquids, made as a picture of them that the lamp takes."""

import numpy as np

from gen_art.maths.array_functions import log
from gen_art.renderer.liquid.layers import PixelLayers
from gen_art.renderer.liquid.liquid_system import LiquidSystem
from gen_art.renderer.liquid.particle_bins import ParticleBins
from gen_art.renderer.projected_particles import LIT_COLUMNS, LIT_RADIUS
from gen_art.renderer.sprite import CHANNELS, DEPTH, X, Y
from gen_art.renderer.surfaces.liquid_shadow import NO_LIQUID, LiquidShadow
from gen_art.renderer.surfaces.reflection import fresnel
from gen_art.renderer.surfaces.scene_numbers import NUMBERS, PARALLEL, ROWS, SCALE, WIDTH
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["lamp_map"]

_TEXELS = 1024  # most along a side of the map
_MARGIN = 2  # texels around the liquid


def lamp_map(liquids: list[LiquidSystem], axes: np.ndarray) -> LiquidShadow:
    """The map of liquids.

    axes : (3, 3), rows: two directions across the lamp's rays, then the direction in which they travel
    """
    liquids = [liquid for liquid in liquids if len(liquid.radii)]
    if not liquids:
        return NO_LIQUID
    places = [liquid.positions.astype(np.float64) @ axes.T for liquid in liquids]
    largest = max(float(liquid.radii.max()) for liquid in liquids)
    low = np.min([place[:, :2].min(axis=0) for place in places], axis=0) - largest
    high = np.max([place[:, :2].max(axis=0) for place in places], axis=0) + largest
    cell = max(min(liquid.sphere for liquid in liquids), float((high - low).max()) / (_TEXELS - 2 * _MARGIN))
    corner = low - _MARGIN * cell
    columns, rows = (int(n) + 2 * _MARGIN + 1 for n in (high - low) / cell)
    numbers = np.zeros(NUMBERS, np.float32)
    numbers[SCALE], numbers[PARALLEL], numbers[WIDTH], numbers[ROWS] = 1.0 / cell, 1.0, columns, rows
    layers = PixelLayers((columns, rows))
    first, depths = np.full((rows, columns), NEVER, np.float32), np.zeros((rows, columns, 4), np.float32)
    for liquid, place in zip(liquids, places):
        channels = np.zeros((CHANNELS, len(place)), np.float32)
        channels[X], channels[Y] = (place[:, :2] - corner).T / cell
        channels[DEPTH] = place[:, 2]
        lit = np.zeros((len(place), LIT_COLUMNS), np.float32)
        lit[:, LIT_RADIUS] = liquid.radii
        bins = ParticleBins.of(numbers, channels, lit, len(place), (columns, rows), 1.0)
        layers.find(numbers, bins, 1.0 / liquid.packing)
        length = layers.thickness.repeat(2, axis=0).repeat(2, axis=1)[:rows, :columns]
        first = np.minimum(first, layers.depth)
        depths[:, :, :3] += length[:, :, None] * liquid.extinction.astype(np.float32)
        depths[:, :, 3] += length
        if liquid.liquid.clear:  # what the surface reflects
            depths[:, :, :3] -= layers.cover[:, :, None] * np.float32(log(1.0 - float(fresnel(1.0, liquid.finish.ior))))
    return LiquidShadow(corner, cell, first, depths)
