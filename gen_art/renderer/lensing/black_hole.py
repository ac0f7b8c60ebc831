"""The black hole of a preset: the lens that it is for a camera.

World coordinates about the middle are those of the metric: r is the distance to it, and directions stay what they are.
"""

import math

import numpy as np

from gen_art.errors import UsageError
from gen_art.preset.black_hole import BlackHole
from gen_art.renderer.camera import Camera, CameraView
from gen_art.renderer.lensing.image_table import image_table
from gen_art.renderer.lensing.lens import Lens
from gen_art.renderer.lensing.schwarzschild import SCHWARZSCHILD

__all__ = ["Hole"]

_CLOSEST = 1.5  # radii: nearer, light that runs in circles would reach the camera from ahead


class Hole:
    """The black hole of a preset.

    spec : the keys of `black_hole:`
    """

    def __init__(self, spec: BlackHole):
        self.spec = spec
        self.center = np.array(spec.center, np.float64)
        self._table: tuple[float, np.ndarray] | None = None

    def lens(self, view: CameraView, film_time: float, camera: Camera | None) -> Lens:
        """The lens of a camera's view. Raises UsageError for parallel rays, and for a camera too near to it."""
        if view.height is not None:
            raise UsageError(
                "a black hole is seen by a perspective camera: give `fov` in place of `height`, or leave `black_hole` out"
            )
        offset = (np.asarray(view.position, np.float64) - self.center) / self.spec.radius
        r = math.sqrt(float(np.sum(offset * offset)))
        if not r > _CLOSEST:
            raise UsageError(
                f"the camera is at {r:.3g} radii of the black hole at {film_time:g} s: keep it beyond 1.5, where light circles it"
            )
        normal, w = offset / r, 1.0 / r
        aside = np.zeros(3)
        aside[int(np.argmin(np.abs(normal)))] = 1.0
        aside -= normal * float(np.sum(aside * normal))
        aside /= math.sqrt(float(np.sum(aside * aside)))
        if self._table is None or self._table[0] != w:
            self._table = w, image_table(SCHWARZSCHILD, 0.0, w)
        return Lens(
            bending=SCHWARZSCHILD, radius=self.spec.radius, position=view.position, center=self.center, axes=np.eye(3),
            uw=(0.0, w), far=False, normal=normal, outward=normal, tangents=np.eye(3) - np.outer(normal, normal),
            aside=aside, table=self._table[1],
        )  # fmt: skip
