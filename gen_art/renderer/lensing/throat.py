"""Where things of the flat world stand in a wormhole, and which way its camera looks.

The two sides are two copies of the world that are joined along a disc of radius a: who goes through it comes out on the other
side. Oblate spheroidal coordinates about the disc are the wormhole's own, up to its metric:

    z = l cos(theta),    distance from the axis = sqrt(l^2 + a^2) sin(theta),    longitude = longitude

with l > 0 on this side and l < 0 on the other. The disc is l = 0. On the axis lengths are those of the metric, and a flow
through a hole in a wall (the field `aperture`) keeps theta. Directions of the camera are taken over by the unit vectors of
l, theta and the longitude, which are perpendicular in both.

A camera is on the side where its path begins until the path goes through the disc.
"""

import math
from dataclasses import dataclass

import numpy as np

from gen_art.errors import UsageError
from gen_art.preset.wormhole import Wormhole
from gen_art.renderer.camera import Camera, CameraView
from gen_art.renderer.lensing.ellis import ELLIS
from gen_art.renderer.lensing.image_table import image_table
from gen_art.renderer.lensing.lens import Lens

__all__ = ["Throat", "WorldPlace"]

_STEP = 1.0 / 60.0  # film seconds between the places of the camera's path that are tested


@dataclass(frozen=True)
class WorldPlace:
    """A point of the wormhole.

    l : proper distance to the throat, in units of a; below 0 on the other side
    normal : (3,) unit vector, its angles theta and longitude, in the axes of the throat
    frame : (3, 3), rows the unit vectors of l, theta and the longitude in the world
    sphere : (2, 3), rows the unit vectors of theta and the longitude in the axes of the throat
    """

    l: float
    normal: np.ndarray
    frame: np.ndarray
    sphere: np.ndarray


class Throat:
    """The wormhole of a preset.

    spec : the keys of `wormhole:`
    """

    def __init__(self, spec: Wormhole):
        self.spec = spec
        self.center = np.array(spec.center, np.float64)
        axis = np.array(spec.axis, np.float64)
        axis = axis / math.sqrt(float(np.sum(axis * axis)))
        first = np.zeros(3)
        first[int(np.argmin(np.abs(axis)))] = 1.0
        first -= axis * float(np.sum(first * axis))
        first /= math.sqrt(float(np.sum(first * first)))
        self.axes = np.stack([first, np.cross(axis, first), axis])
        self._sides: list[tuple[np.ndarray, bool]] = []
        self._table: tuple[float, np.ndarray] | None = None

    def lens(self, view: CameraView, film_time: float, camera: Camera | None) -> Lens:
        """The lens of a camera's view. Raises UsageError for parallel rays, which no camera in a wormhole has."""
        if view.height is not None:
            raise UsageError(
                "a wormhole is seen by a perspective camera: give `fov` in place of `height`, or leave `wormhole` out"
            )
        return self.lens_at(view.position, self._far_at(film_time, camera))

    def lens_at(self, position: np.ndarray, far: bool) -> Lens:
        """The lens of a camera at a world position (3,) on one of the sides."""
        place = self.place(position, far)
        far = math.copysign(1.0, place.l) < 0.0
        r = math.hypot(place.l, 1.0)
        u, w = abs(place.l) / r, 1.0 / r
        if self._table is None or self._table[0] != w:
            self._table = w, image_table(ELLIS, u, w)
        return Lens(
            bending=ELLIS, radius=self.spec.radius, position=position, center=self.center, axes=self.axes,
            uw=(u, w), far=far, normal=place.normal, outward=place.frame[0] * (-1.0 if far else 1.0),
            tangents=place.frame[1:].T @ place.sphere, aside=place.sphere[1], table=self._table[1],
        )  # fmt: skip

    def place(self, position, far: bool) -> WorldPlace:
        """The place of a world position (3,) on one of the sides."""
        x, y, z = (self.axes @ (np.asarray(position, np.float64) - self.center) / self.spec.radius).tolist()
        across = math.hypot(x, y)
        excess = across * across + z * z - 1.0
        root = math.sqrt(excess * excess + 4.0 * z * z)
        larger = 0.5 * (root + abs(excess))
        smaller = z * z / larger if larger > 0.0 else 0.0
        l2, cosine2 = (larger, smaller) if excess > 0.0 else (smaller, larger)
        l = math.copysign(math.sqrt(l2), -1.0 if far else 1.0)
        cosine = math.copysign(math.sqrt(min(cosine2, 1.0)), -z if far else z)
        sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
        c, s = (x / across, y / across) if across > 0.0 else (1.0, 0.0)
        level, around, up = np.array([c, s, 0.0]), np.array([-s, c, 0.0]), np.array([0.0, 0.0, 1.0])
        r = math.sqrt(1.0 + l2)
        size = math.sqrt(l2 * sine * sine + r * r * cosine * cosine)
        of_l, of_theta = level, -up  # at the edge of the disc, as from outside it
        if size > 1e-12:
            of_l = (l * sine * level + r * cosine * up) / size
            of_theta = (r * cosine * level - l * sine * up) / size
        frame = np.stack([of_l, of_theta, around]) @ self.axes
        sphere = np.stack([cosine * level - sine * up, around])
        return WorldPlace(l, sine * level + cosine * up, frame, sphere)

    def _far_at(self, film_time: float, camera: Camera | None) -> bool:
        """Whether the camera is on the other side: its path from 0 to then goes through the disc an odd number of times."""
        far = self.spec.camera == "far"
        if camera is None or not (camera.spec.path or camera.spec.orbit):
            return far
        number = max(math.floor(film_time / _STEP), 0)
        while len(self._sides) <= number:
            here = camera.at(len(self._sides) * _STEP).position
            if self._sides:
                before, far = self._sides[-1]
                far ^= self._crosses(before, here)
            self._sides.append((here, far))
        before, far = self._sides[number]
        return far ^ self._crosses(before, camera.at(film_time).position)

    def _crosses(self, before: np.ndarray, after: np.ndarray) -> bool:
        """Whether the straight way between two positions goes through the disc."""
        first, last = (self.axes @ (p - self.center) / self.spec.radius for p in (before, after))
        if (first[2] < 0.0) == (last[2] < 0.0):
            return False
        at = first + (last - first) * (first[2] / (first[2] - last[2]))
        return bool(at[0] * at[0] + at[1] * at[1] < 1.0)
