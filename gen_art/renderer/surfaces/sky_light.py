"""The sky's light at places among balls and smoke, which hide a part of it.

At each node of a grid the light from the 14 directions of Lebedev's rule, each through what lies on its way, is kept as its
mean c0 and its slope c1: the radiance from the direction w is about c0 + c1.w. A surface with the normal n then has the
irradiance pi (c0 + 2/3 c1.n). For a sky that fades linearly from the zenith to the nadir both are exact.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.maths.array_functions import exp
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.smoke_density import DIRECTIONS, WEIGHTS, Smoke

__all__ = ["RESOLUTION", "SkyLight"]

RESOLUTION = 40  # cells along the longest side
_MARGIN = 0.35  # the grid extends beyond what hides the sky by this part of its longest side


@dataclass(frozen=True)
class SkyLight:
    """The sky's light on a grid along the axes of the world.

    origin : (3,) position of the first node, m
    cell : distance of two nodes, m
    shape : nodes along each axis
    light : (nodes, 12) float32, c0 of the three colours, then c1 along x, y and z of each
    open : (12,) the same where nothing hides the sky
    """

    origin: np.ndarray
    cell: float
    shape: tuple[int, int, int]
    light: np.ndarray
    open: np.ndarray

    @classmethod
    def of(cls, light: Lighting, positions, cross_sections, radii) -> "SkyLight":
        """The sky's light among particles of these extinction cross sections, m^2; no particles leave it open everywhere."""
        if not (np.asarray(cross_sections) > 0).any() or not light.ambient.any():
            return cls(np.zeros(3), 1.0, (1, 1, 1), _row(light.ambient)[None], _row(light.ambient))
        matter = Smoke.of(positions, cross_sections, radii, np.eye(3), RESOLUTION, _MARGIN)
        total = np.zeros((12, matter.extinction.size))  # rows: one array at a time stays in the processor's cache
        for direction, weight in zip(DIRECTIONS, WEIGHTS):
            towards = -direction / np.linalg.norm(direction)
            arriving = weight * exp(-matter.depth(direction).astype(np.float64)).ravel()
            basis = np.array([1.0, *(3.0 * towards)])
            for row, share in zip(total, _row(light.radiance(towards)[:, None] * basis)):
                row += arriving * share
        shape, nodes = matter.extinction.shape, np.ascontiguousarray(total.T, np.float32)
        return cls(matter.corner * matter.cell, matter.cell, shape, nodes, _row(light.ambient))


def _row(coefficients: np.ndarray) -> np.ndarray:
    """(3 colours, 4) -> (12,) float32: c0 of the colours, then c1 of each."""
    return np.concatenate([coefficients[:, 0], coefficients[:, 1:].ravel()]).astype(np.float32)
