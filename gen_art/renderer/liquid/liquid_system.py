"""The liquid of one system: its particles as they are shaded, and what light does in it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen_art.maths.array_functions import log
from gen_art.preset.liquid import Liquid
from gen_art.preset.surface import Finish
from gen_art.renderer.colour import linear
from gen_art.renderer.liquid.packing import packing
from gen_art.renderer.projected_particles import (
    LIT_ALBEDO,
    LIT_EXTINCTION,
    LIT_POSITION,
    LIT_RADIUS,
    ProjectedParticles,
)
from gen_art.renderer.sprite import ALPHA, BLUE, DEPTH, FOOTPRINT, RED

__all__ = ["LiquidSystem", "absorption", "hiding_particles"]

_DARKEST = 1e-6  # what at least remains of light after the liquid's distance
_OPAQUE = 4.0  # optical depth of an opaque liquid over the radius of a particle, for the shadow that it casts


def absorption(liquid: Liquid) -> np.ndarray:
    """(3,) absorption of linear light per length: -log(color) / distance."""
    return -log(np.maximum(linear(liquid.color).astype(np.float64), _DARKEST)) / liquid.distance


@dataclass(frozen=True, eq=False)
class LiquidSystem:
    """The liquid of one system, as its particles are shaded.

    liquid, finish : what light does in it, and at its surface
    projected : its particles, lit
    velocities : (3, n) m/s
    """

    liquid: Liquid
    finish: Finish
    projected: ProjectedParticles
    velocities: np.ndarray

    @cached_property
    def _living(self) -> np.ndarray:
        lit = self.projected.lit[: self.projected.count]
        return lit[lit[:, LIT_EXTINCTION] > 0.0]

    @property
    def radii(self) -> np.ndarray:
        """(n,) m, of all particles that exist."""
        return self._living[:, LIT_RADIUS]

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) of all particles that exist."""
        return self._living[:, LIT_POSITION]

    @cached_property
    def sphere(self) -> float:
        """The median radius, m. There must be a particle."""
        return float(np.median(self.radii))

    @cached_property
    def packing(self) -> float:
        """The share of space that its spheres fill inside it."""
        return packing(self.positions, self.radii)

    @cached_property
    def distance(self) -> float:
        """The median distance of the visible particles along the line of sight."""
        seen = self.projected.used[DEPTH, self.projected.used[FOOTPRINT] >= 0.0]
        return float(np.median(seen)) if len(seen) else 0.0

    @property
    def extinction(self) -> np.ndarray:
        """(3,) optical depth per length of the light that it takes from what is in its shadow."""
        if not self.liquid.clear:
            return np.full(3, _OPAQUE / self.sphere)
        scattering = 0.0 if self.liquid.scattering is None else 1.0 / self.liquid.scattering
        return absorption(self.liquid) + scattering

    def paints(self) -> np.ndarray:
        """(n, 6) float32: albedo and emission of each particle; those off the picture have those of the first that is not."""
        projected = self.projected
        area = projected.used[ALPHA]
        paints = np.zeros((projected.count, 6), np.float32)
        seen = np.flatnonzero(area > 0.0)
        if len(seen):
            paints[:, :3] = projected.lit[: projected.count, LIT_ALBEDO] / np.maximum(area, 1e-30)[:, None]
            paints[:, 3:] = (projected.used[RED : BLUE + 1] / np.maximum(area, 1e-30)).T
            paints[area <= 0.0] = paints[seen[0]]
        return paints


def hiding_particles(liquids: list[LiquidSystem]):
    """(positions, extinction cross sections, radii) of the particles that hide the sky, or None: those of turbid liquids.

    A particle stands for the volume of its sphere over the packing; it hides no more than its sphere's outline.
    """
    turbid = [one for one in liquids if len(one.radii) and (one.liquid.scattering is not None or not one.liquid.clear)]
    if not turbid:
        return None
    areas = []
    for one in turbid:
        radii = one.radii.astype(np.float64)
        volumes = 4.0 / 3.0 * np.pi * radii**3 / one.packing
        areas.append(np.minimum(float(one.extinction[1]) * volumes, np.pi * radii**2))
    positions = np.concatenate([one.positions for one in turbid]).astype(np.float64)
    return positions, np.concatenate(areas), np.concatenate([one.radii for one in turbid]).astype(np.float64)
