"""Draws the liquids of a scene: bins, layers, smoothing and shading, one liquid after the other from the farthest on."""

import numpy as np

from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.liquid.layers import COLOURS, SPREAD, PixelLayers
from gen_art.renderer.liquid.liquid_depths import put_depths
from gen_art.renderer.liquid.liquid_shading import (
    ABSORPTION,
    CLEAR,
    LIQUID_NUMBERS,
    MATERIAL,
    SCATTERING,
    SKY_BEHIND,
    SPHERE,
    draw_liquid_kernel,
)
from gen_art.renderer.liquid.liquid_system import LiquidSystem, absorption
from gen_art.renderer.liquid.particle_bins import ParticleBins
from gen_art.renderer.liquid.smoothing import smooth, spread_lengths
from gen_art.renderer.surfaces.scene_numbers import LIQUID_BIAS, LIQUID_CELL, SKY_CELL, SKY_LIFT
from gen_art.renderer.surfaces.shadow_casters import ShadowCasters
from gen_art.renderer.surfaces.surface_layers import NO_LAYERS, SurfaceLayers
from gen_art.renderer.surfaces.surface_pass import SurfacePass

__all__ = ["LiquidPass"]

_NO_FLOW = np.zeros((1, 1, COLOURS + 1), np.float32)
_ALIKE = 1e-5  # by which colours differ by rounding alone


class LiquidPass:
    """Draws liquids into framebuffers of one size."""

    def __init__(self, size: tuple[int, int]):
        self.size = size
        self._layers = PixelLayers(size)
        self._smooth, self._scratch = (np.zeros((size[1], size[0]), np.float32) for _ in range(2))
        self._lengths = np.zeros_like(self._layers.thickness)

    def draw(
        self, liquids: list[LiquidSystem], first_material: int, casters: ShadowCasters, surfaces: SurfacePass,
        framebuffer: FrameBuffer, sky_behind: bool, layers: SurfaceLayers | None = None,
    ) -> None:  # fmt: skip
        """Draw liquids over a framebuffer that surfaces were drawn into, and into the depths of `surfaces`.

        first_material : of the first liquid; the next has the next one
        sky_behind : whether a sky will be drawn behind everything, and is seen through the liquid
        layers : over which the liquids' own are put, or None
        """
        order = sorted(range(len(liquids)), key=lambda k: -liquids[k].distance)
        for k in order:
            self._draw_one(liquids[k], first_material + k, casters, surfaces, framebuffer, sky_behind, layers)

    def _draw_one(
        self, system: LiquidSystem, material: int, casters, surfaces, framebuffer, sky_behind: bool, wanted
    ) -> None:
        projected, liquid, layers = system.projected, system.liquid, self._layers
        if not len(system.radii):
            return
        numbers, sphere, paints = surfaces.arrays.numbers, system.sphere, system.paints()
        coloured = bool(np.abs(paints - paints[:1]).max() > _ALIKE * max(float(paints[0].max()), 1.0))
        bins = ParticleBins.of(
            numbers, projected.channels, projected.lit, projected.count, self.size, SPREAD if coloured else 1.0
        )
        if not bins.starts[-1]:
            return
        self._find_surface(numbers, bins, system)
        if coloured:
            layers.spread(numbers, bins, paints)
            colours = layers.colours
        else:
            colours = np.append(paints[0], 1.0).astype(np.float32).reshape(1, 1, COLOURS + 1)
        if liquid.clear:
            spread_lengths(numbers, self._smooth, liquid.smoothing * sphere, layers.thickness, self._lengths)
        own = np.zeros(LIQUID_NUMBERS, np.float32)
        own[ABSORPTION : ABSORPTION + 3] = absorption(liquid)
        own[SCATTERING] = 0.0 if liquid.scattering is None else 1.0 / liquid.scattering
        own[CLEAR], own[SPHERE], own[MATERIAL], own[SKY_BEHIND] = liquid.clear, sphere, material, sky_behind
        shared = surfaces.arrays._replace(numbers=_received(numbers, liquid.clear, sphere))
        filled = wanted or NO_LAYERS
        flow = _NO_FLOW if wanted is None else self._flow(numbers, system)
        film, far = framebuffer.pixels.copy(), surfaces.depths[:, :, 0].copy()
        draw_liquid_kernel(casters.terms, coloured, wanted is not None)(
            *shared, own, self._smooth, layers.cover, layers.thickness, colours, film, far, framebuffer.buffer,
            framebuffer.stride, surfaces.depths, surfaces.bounds, filled.values, filled.earlier, flow,
        )  # fmt: skip

    def find_depths(self, liquids: list[LiquidSystem], surfaces: SurfacePass) -> None:
        """Put the depths of liquids alone into those of `surfaces`, without drawing them."""
        numbers = surfaces.arrays.numbers
        for system in liquids:
            if len(system.radii):
                projected = system.projected
                bins = ParticleBins.of(numbers, projected.channels, projected.lit, projected.count, self.size, 1.0)
                self._find_surface(numbers, bins, system)
                put_depths(numbers, self._smooth, self._layers.cover, surfaces.depths, surfaces.bounds)

    def _find_surface(self, numbers: np.ndarray, bins: ParticleBins, system: LiquidSystem) -> None:
        """Find the particles' layers and the smoothed surface of a liquid."""
        self._layers.find(numbers, bins, 1.0 / system.packing)
        reach = system.liquid.smoothing * system.sphere
        smooth(numbers, self._layers.depth, reach, system.sphere, self._scratch, self._smooth)

    def _flow(self, numbers: np.ndarray, system: LiquidSystem) -> np.ndarray:
        """(rows, columns, COLOURS + 1), of which the first three are the mean velocity of the particles near the surface."""
        projected, velocities = system.projected, np.zeros((system.projected.count, COLOURS), np.float32)
        velocities[:, :3] = system.velocities.T
        bins = ParticleBins.of(numbers, projected.channels, projected.lit, projected.count, self.size, SPREAD)
        kept, self._layers.colours = self._layers.colours, np.zeros((1, 1, COLOURS + 1), np.float32)
        self._layers.spread(numbers, bins, velocities)
        flow, self._layers.colours = self._layers.colours, kept
        return flow


def _received(numbers: np.ndarray, clear: bool, sphere: float) -> np.ndarray:
    """N for a liquid's own surface.

    A clear one does not shadow itself, an opaque one from two radii below its surface on. The sky's light is read where the
    liquid, which is blurred in the grid of that light, no longer hides it from its own surface.
    """
    numbers = numbers.copy()
    numbers[SKY_LIFT] = 2.0 * numbers[SKY_CELL]
    numbers[LIQUID_BIAS] = 2.0 * sphere
    if clear:
        numbers[LIQUID_CELL] = 0.0
    return numbers
