"""The light on smoke and surfaces, put together from the keys of `light:` and the sky that surrounds the scene.

The lamp is that of `light:`; what it leaves out of direction, size, colour and brightness is the sun's, where the sky has one.
The light from all sides is the sky's, where there is one and `light:` names no `ambient` of its own, as its mean c0 and its slope
c1: the radiance from the unit direction w is about c0 + c1.w.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from gen_art.maths.array_functions import cos, sin
from gen_art.preset.light import Light
from gen_art.renderer.colour import linear
from gen_art.renderer.sky import SkyDome

__all__ = ["Lighting"]

ONCE_MORE = 0.2  # the part of smoke's light that was scattered before, where a look's own light does not say


@dataclass(frozen=True, eq=False)
class Lighting:
    """The lamp and the light from all sides.

    key : the keys of `light:`, for how smoke scatters
    direction : (3,) in which the lamp's light travels, unit
    size : diameter of the lamp, degrees
    lamp : (3,) linear brightness of the lamp; its irradiance is 4 pi times that
    ambient : (3 colours, 4) c0 and the three parts of c1
    dome : the sky, or None
    of_scene : whether it is the light of the whole scene, not that of one look
    """

    key: Light
    direction: np.ndarray
    size: float
    lamp: np.ndarray
    ambient: np.ndarray
    dome: SkyDome | None = field(default=None, repr=False)
    of_scene: bool = False

    @classmethod
    def of(cls, light: Light | None, dome: SkyDome | None = None, of_scene: bool = False) -> "Lighting":
        """The light of a preset; without `light:`, that of the sky, or a lamp's where there is no sky either."""
        key = light or Light()
        named = key.model_fields_set
        direction, size = np.asarray(key.direction, np.float64), key.size
        lamp, ambient = linear(key.color) * key.intensity, _hemispheres(key)
        if dome is not None and dome.sun_direction is not None:
            if "direction" not in named:
                direction = -dome.sun_direction
            if "size" not in named:
                size = 2.0 * math.degrees(dome.sun_radius)
            if not named & {"color", "intensity"}:
                lamp = dome.sun_irradiance / (4.0 * math.pi)
        elif dome is not None and light is None:
            lamp = np.zeros(3)
        if dome is not None and not named & {"ambient", "ambient_intensity", "ground"}:
            ambient = _mean_and_slope(dome)
        return cls(key, direction / np.linalg.norm(direction), size, lamp, ambient, dome, of_scene)

    @property
    def scatter(self) -> float | None:
        """The part of smoke's light that was scattered before, or None where light is followed until it leaves the smoke."""
        chosen = self.key.scatter
        if chosen is None:
            return None if self.of_scene else ONCE_MORE
        return None if chosen == "full" else float(chosen)

    @property
    def dark(self) -> bool:
        """Whether no light comes from anywhere, not even from particles."""
        return not (self.lamp.any() or self.ambient.any() or self.key.glow)

    def radiance(self, direction) -> np.ndarray:
        """(3,) light from a unit direction (3,), c0 + c1.w, not below 0."""
        return np.maximum(self.ambient[:, 0] + self.ambient[:, 1:] @ np.asarray(direction), 0.0)


def _hemispheres(light: Light) -> np.ndarray:
    """c0 and c1 of a sky that fades linearly from its colour at the zenith to the ground's at the nadir."""
    above, below = (
        linear(colour) * light.ambient_intensity
        for colour in (light.ambient, light.ambient if light.ground is None else light.ground)
    )
    ambient = np.zeros((3, 4))
    ambient[:, 0], ambient[:, 2] = 0.5 * (above + below), 0.5 * (above - below)
    return ambient


@lru_cache(8)
def _mean_and_slope(dome: SkyDome) -> np.ndarray:
    """c0 = mean of L and c1 = 3 mean of L w over the sphere, by rings of equal area."""
    rings, around = 64, 128
    height = (np.arange(rings) + 0.5) / rings * 2.0 - 1.0
    angle = (np.arange(around) + 0.5) / around * (2.0 * np.pi)
    level = np.sqrt(1.0 - height * height)
    w = np.stack(
        [
            level[:, None] * sin(angle)[None],
            np.broadcast_to(height[:, None], (rings, around)),
            -level[:, None] * cos(angle)[None],
        ],
        axis=-1,
    ).reshape(-1, 3)
    light = dome.radiance(w)
    slope = [[3.0 * float((light[:, k] * w[:, c]).mean()) for c in range(3)] for k in range(3)]
    return np.column_stack([light.mean(axis=0), slope])
