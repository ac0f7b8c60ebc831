"""What surrounds the scene: light by direction, the sun and the stars, made of the keys of `sky:`."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gen_art.errors import UsageError
from gen_art.preset.sky import Sky
from gen_art.renderer.atmosphere import SUN_RADIUS
from gen_art.renderer.colour import gradient_table, linear
from gen_art.renderer.daylight import DISC_ROWS, daylight
from gen_art.renderer.sky_band import band_table
from gen_art.renderer.sky_softboxes import with_softboxes
from gen_art.renderer.sky_table import COLUMNS, HALF, ROWS, elevations, look_up, sky_radiance
from gen_art.renderer.stars import StarField, star_field

__all__ = ["SkyDome", "sky_radiance"]

_GRADIENT = 4097  # entries of a gradient's table, which is then read at the rows' elevations


@dataclass(frozen=True, eq=False)
class SkyDome:
    """What surrounds the scene, in linear light.

    table : (rows, columns, 3) float32 light by direction, as gen_art/renderer/sky_table.py lays it out; not below 0
    sun_direction : (3,) float64 unit vector from the scene to the sun, or None
    sun_irradiance : (3,) float64 of a plane that faces the sun, by the sun alone; a white one reflects 1 / pi of it as light
    sun_radius : of the sun's disc, rad; 0 without a sun
    disc : (rows, 3) float32 mean light of the drawn disc at each height, from its lower to its upper rim; 0 below the horizon
    stars : the stars that are drawn, or None
    """

    table: np.ndarray
    sun_direction: np.ndarray | None
    sun_irradiance: np.ndarray
    sun_radius: float
    disc: np.ndarray
    stars: StarField | None

    @classmethod
    def of(cls, spec: Sky) -> "SkyDome":
        """The sky of a preset's `sky:`. The arrays are shared by all callers; write to none of them."""
        if not isinstance(spec, Sky):
            raise UsageError(f"a sky dome is made of a ga.Sky, not of {type(spec).__name__}")
        return _dome(spec)

    def radiance(self, directions) -> np.ndarray:
        """(n, 3) float64 linear light from directions (n, 3) of any length but 0, without the sun's disc and the stars."""
        return look_up(self.table.astype(np.float64), directions)


@lru_cache(4)
def _dome(spec: Sky) -> SkyDome:
    stars = None if spec.stars is None else star_field(spec.stars)
    if spec.sun is None:
        around = COLUMNS if spec.band or spec.softboxes else 2
        rows = np.repeat(_rows(spec)[:, None], around, axis=1)
        if spec.band is not None:
            rows = rows + band_table(spec.band)
        rows = with_softboxes(rows, spec.softboxes) * spec.intensity
        stars = stars and StarField(stars.directions, stars.light * spec.intensity)
        return SkyDome(_frozen(rows), None, np.zeros(3), 0.0, np.zeros((DISC_ROWS, 3), np.float32), stars)
    day = daylight(spec)
    table = day.table
    if spec.band is not None:
        clear = np.concatenate([np.zeros((HALF, 3)), day.extinction])[:, None]
        table = table + band_table(spec.band) * clear
    if stars is not None:
        clear = np.repeat(np.concatenate([np.zeros((HALF, 3)), day.extinction])[:, None], 2, axis=1)
        stars = StarField(stars.directions, stars.light * look_up(clear, stars.directions) * spec.intensity)
    table = with_softboxes(table, spec.softboxes)
    disc = _frozen(day.disc * (spec.intensity * spec.sun.disc))
    irradiance = day.sun_irradiance * spec.intensity
    return SkyDome(_frozen(table * spec.intensity), day.sun_direction, irradiance, SUN_RADIUS, disc, stars)


def _frozen(values) -> np.ndarray:
    array = np.ascontiguousarray(values, np.float32)
    array.flags.writeable = False
    return array


def _rows(spec: Sky) -> np.ndarray:
    """(ROWS, 3) light by elevation of a gradient or an even colour; black for stars alone."""
    if spec.gradient is None:
        return np.repeat(np.zeros((1, 3)) if spec.color is None else linear(spec.color)[None], ROWS, axis=0)
    upper = elevations()
    position = 0.5 + np.concatenate([-upper[::-1], upper]) / np.pi
    table = gradient_table(spec.gradient, _GRADIENT)
    at = np.linspace(0.0, 1.0, _GRADIENT)
    return np.stack([np.interp(position, at, table[:, c]) for c in range(3)], axis=1)
