"""Draws the liquids of a scene: bins, layers, smoothing and shading, one liquid after the other from the farthest on."""

from dataclasses import dataclass

import numpy as np

from gen_art.maths.array_functions import log
from gen_art.preset.liquid import Liquid
from gen_art.preset.surface import Finish
from gen_art.renderer.colour import linear
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.liquid.layers import COLOURS, SPREAD, PixelLayers
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
from gen_art.renderer.liquid.packing import packing
from gen_art.renderer.liquid.particle_bins import ParticleBins
from gen_art.renderer.liquid.smoothing import smooth, spread_lengths
from gen_art.renderer.shading import LIT_ALBEDO, LIT_EXTINCTION, LIT_POSITION, LIT_RADIUS, ProjectedParticles
from gen_art.renderer.sprite import ALPHA, BLUE, DEPTH, FOOTPRINT, RED
from gen_art.renderer.surfaces.shadow_casters import ShadowCasters
from gen_art.renderer.surfaces.surface_pass import SurfacePass

__all__ = ["LiquidPass", "LiquidSystem", "absorption"]

_ALIKE = 1e-5  # by which colours differ by rounding alone
_DARKEST = 1e-6  # what at least remains of light after the liquid's distance


def absorption(liquid: Liquid) -> np.ndarray:
    """(3,) absorption of linear light per length: -log(color) / distance."""
    return -log(np.maximum(linear(liquid.color).astype(np.float64), _DARKEST)) / liquid.distance


@dataclass(frozen=True, eq=False)
class LiquidSystem:
    """The liquid of one system, as its particles are shaded.

    liquid, finish : what light does in it, and at its surface
    projected : its particles, lit
    """

    liquid: Liquid
    finish: Finish
    projected: ProjectedParticles

    @property
    def radii(self) -> np.ndarray:
        """(n,) m, of all particles that exist."""
        lit = self.projected.lit[: self.projected.count]
        return lit[lit[:, LIT_EXTINCTION] > 0.0, LIT_RADIUS]

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) of all particles that exist."""
        lit = self.projected.lit[: self.projected.count]
        return lit[lit[:, LIT_EXTINCTION] > 0.0, LIT_POSITION]

    @property
    def distance(self) -> float:
        """The median distance of the visible particles along the line of sight."""
        seen = self.projected.used[DEPTH, self.projected.used[FOOTPRINT] >= 0.0]
        return float(np.median(seen)) if len(seen) else 0.0


class LiquidPass:
    """Draws liquids into framebuffers of one size."""

    def __init__(self, size: tuple[int, int]):
        self.size = size
        self._layers = PixelLayers(size)
        self._smooth, self._scratch = (np.zeros((size[1], size[0]), np.float32) for _ in range(2))
        self._lengths = np.zeros_like(self._layers.thickness)

    def draw(
        self, liquids: list[LiquidSystem], first_material: int, casters: ShadowCasters, surfaces: SurfacePass,
        framebuffer: FrameBuffer, sky_behind: bool,
    ) -> None:  # fmt: skip
        """Draw liquids over a framebuffer that surfaces were drawn into, and into the depths of `surfaces`.

        first_material : of the first liquid; the next has the next one
        sky_behind : whether a sky will be drawn behind everything, and is seen through the liquid
        """
        order = sorted(range(len(liquids)), key=lambda k: -liquids[k].distance)
        for k in order:
            self._draw_one(liquids[k], first_material + k, casters, surfaces, framebuffer, sky_behind)

    def _draw_one(self, system: LiquidSystem, material: int, casters, surfaces, framebuffer, sky_behind: bool) -> None:
        projected, liquid, layers = system.projected, system.liquid, self._layers
        radii, numbers = system.radii, surfaces.arrays.numbers
        if not len(radii):
            return
        paints = _paints(projected)
        coloured = bool(np.abs(paints - paints[:1]).max() > _ALIKE * max(float(paints[0].max()), 1.0))
        bins = ParticleBins.of(
            numbers, projected.channels, projected.lit, projected.count, self.size, SPREAD if coloured else 1.0
        )
        if not bins.starts[-1]:
            return
        layers.find(numbers, bins, 1.0 / packing(system.positions, radii))
        if coloured:
            layers.spread(numbers, bins, paints)
            colours = layers.colours
        else:
            colours = np.append(paints[0], 1.0).astype(np.float32).reshape(1, 1, COLOURS + 1)
        sphere = float(np.median(radii))
        smooth(numbers, layers.depth, liquid.smoothing * sphere, sphere, self._scratch, self._smooth)
        if liquid.clear:
            spread_lengths(numbers, self._smooth, liquid.smoothing * sphere, layers.thickness, self._lengths)
        own = np.zeros(LIQUID_NUMBERS, np.float32)
        own[ABSORPTION : ABSORPTION + 3] = absorption(liquid)
        own[SCATTERING] = 0.0 if liquid.scattering is None else 1.0 / liquid.scattering
        own[CLEAR], own[SPHERE], own[MATERIAL], own[SKY_BEHIND] = liquid.clear, sphere, material, sky_behind
        film, far = framebuffer.pixels.copy(), surfaces.depths[:, :, 0].copy()
        draw_liquid_kernel(casters.terms, coloured)(
            *surfaces.arrays, own, self._smooth, layers.cover, layers.thickness, colours, film, far, framebuffer.buffer,
            framebuffer.stride, surfaces.depths, surfaces.bounds,
        )  # fmt: skip


def _paints(projected: ProjectedParticles) -> np.ndarray:
    """(n, COLOURS) float32: albedo and emission of each particle; those off the picture have those of the first that is not."""
    area = projected.used[ALPHA]
    paints = np.zeros((projected.count, COLOURS), np.float32)
    seen = np.flatnonzero(area > 0.0)
    if len(seen):
        paints[:, :3] = projected.lit[: projected.count, LIT_ALBEDO] / np.maximum(area, 1e-30)[:, None]
        paints[:, 3:] = (projected.used[RED : BLUE + 1] / np.maximum(area, 1e-30)).T
        paints[area <= 0.0] = paints[seen[0]]
    return paints
