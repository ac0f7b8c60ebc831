"""Where the picture is taken from: perspective or orthographic, still, on a path or in orbit.

Right-handed, y up. The picture's rows run from top to bottom; pixel (row, column) covers [column, column + 1) x
[row, row + 1), so the middle of the frame is (width / 2, height / 2).
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from gen_art.errors import UsageError
from gen_art.preset.camera import CameraSpec
from gen_art.renderer.colour import linear

__all__ = ["Camera", "View"]


@dataclass(frozen=True)
class View:
    """A camera at one moment: `position` (3,), rows of `axes` right, up, forward; lengths in world units.

    fov in degrees from bottom to top, or `height` in world units (orthographic) when that is not None.
    """

    position: np.ndarray
    axes: np.ndarray
    distance: float
    fov: float
    height: float | None
    near: float
    far: float
    fog: tuple[float, float, tuple[float, float, float]] | None

    def scale(self, rows: int) -> float:
        """Pixels per world unit (orthographic), or pixels per unit of slope (perspective)."""
        return rows / self.height if self.height else 0.5 * rows / math.tan(math.radians(self.fov) / 2)

    def project(self, points, size) -> np.ndarray:
        """(n, 3) column, row and depth of world points (n, 3) in a picture of size (width, height)."""
        local = (np.asarray(points, dtype=np.float64) - self.position) @ self.axes.T
        scale = self.scale(size[1]) / (1.0 if self.height else local[:, 2])
        return np.stack([0.5 * size[0] + local[:, 0] * scale, 0.5 * size[1] - local[:, 1] * scale, local[:, 2]], axis=1)


@dataclass(frozen=True)
class Camera:
    """Camera(position, target, up, fov) is a perspective camera; with `height`, an orthographic one.

    position, target, up : (3,) world units      fov : degrees, bottom to top      height : world units, bottom to top
    roll : degrees, the picture turns clockwise      near, far : distances of clipping (near: a thousandth of the
    distance to the target unless given)      shutter : degrees of a frame, 0 to 360
    path, easing, orbit, fog : as in a preset's `camera:` (see preset/look.py)
    Raises UsageError for a camera that looks nowhere.
    """

    position: tuple = (0.0, 0.0, 10.0)
    target: tuple = (0.0, 0.0, 0.0)
    up: tuple = (0.0, 1.0, 0.0)
    fov: float = 40.0
    height: float | None = None
    roll: float = 0.0
    near: float | None = None
    far: float | None = None
    shutter: float = 180.0
    spec: CameraSpec = field(default=CameraSpec(), repr=False)

    def __post_init__(self):
        for name in ("position", "target", "up"):
            vector = tuple(float(c) for c in getattr(self, name))
            if len(vector) != 3 or not all(map(math.isfinite, vector)):
                raise UsageError(f"the camera's {name} must be three finite numbers")
            object.__setattr__(self, name, vector)
        if self.position == self.target:
            raise UsageError("the camera's position and target must differ")
        if not 0.0 < self.fov < 170.0:
            raise UsageError(f"the camera's fov must be between 0 and 170 degrees, not {self.fov:g}")
        if self.height is not None and not self.height > 0.0:
            raise UsageError("the camera's height must be above 0")

    @classmethod
    def from_spec(cls, spec: CameraSpec) -> "Camera":
        """The camera a preset describes."""
        plain = ("position", "target", "up", "fov", "height", "roll", "near", "far", "shutter")
        return cls(**{name: getattr(spec, name) for name in plain}, spec=spec)

    @classmethod
    def framing(cls, points, aspect: float = 16 / 9) -> "Camera":
        """A camera in front (on +z) that has all but the farthest hundredth of the points (n, 3) in its frame."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return cls()
        low, high = np.percentile(points, [1, 99], axis=0) if len(points) > 200 else (points.min(0), points.max(0))
        centre, half = 0.5 * (low + high), 0.5 * (high - low)
        radius = max(half[1], half[0] / aspect, half[2] * 0.5, 1e-9 * (1.0 + np.abs(centre).max()))
        if radius < 1e-6:
            radius = 1.0
        distance = 1.25 * radius / math.tan(math.radians(20.0)) + half[2]
        return cls(position=tuple(centre + (0.0, 0.0, distance)), target=tuple(centre))

    def at(self, time: float = 0.0) -> View:
        """The camera at film time `time` (seconds)."""
        state = self._on_path(time)
        position, target, up = (np.array(getattr(state, n), dtype=np.float64) for n in ("position", "target", "up"))
        orbit = self.spec.orbit
        if orbit is not None:
            position = target + _turn(position - target, orbit.axis, math.radians(orbit.start + orbit.rate * time))
        forward = target - position
        distance = float(np.linalg.norm(forward))
        if distance == 0.0:
            raise UsageError(f"the camera reaches its target at {time:g} s and looks nowhere")
        forward /= distance
        right = np.cross(forward, up)
        if np.linalg.norm(right) < 1e-9 * max(np.linalg.norm(up), 1e-30):  # looking along `up`: any other will do
            right = np.cross(forward, [0.0, 0.0, -1.0] if abs(forward[2]) < 0.9 else [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        above = np.cross(right, forward)
        angle = math.radians(state.roll)
        right, above = (
            math.cos(angle) * right + math.sin(angle) * above,
            math.cos(angle) * above - math.sin(angle) * right,
        )
        fog = self.spec.fog
        return View(
            position=position,
            axes=np.stack([right, above, forward]),
            distance=distance,
            fov=state.fov,
            height=state.height,
            near=self.near if self.near is not None else 1e-3 * distance,
            far=self.far if self.far is not None else math.inf,
            fog=(fog.start, fog.distance, tuple(linear(fog.color))) if fog else None,
        )

    def _on_path(self, time: float) -> "Camera":
        if not self.spec.path:
            return self
        names = ("position", "target", "up", "fov", "height", "roll")
        rows, current = [], {n: getattr(self, n) for n in names}
        for key in self.spec.path:
            current = {n: current[n] if getattr(key, n) is None else getattr(key, n) for n in names}
            rows.append(current)
        times = [key.time for key in self.spec.path]
        mixed = {}
        for name in names:
            if rows[0][name] is None or rows[-1][name] is None:
                mixed[name] = None
                continue
            values = np.array([np.atleast_1d(row[name]) for row in rows], dtype=np.float64)
            value = _ease(times, values, time, self.spec.easing)
            mixed[name] = tuple(value.tolist()) if len(value) == 3 else float(value[0])
        return replace(self, **mixed)


def _turn(vector, axis, angle: float) -> np.ndarray:
    """`vector` turned by `angle` (radians) about `axis` (Rodrigues)."""
    k = np.asarray(axis, dtype=np.float64)
    k = k / np.linalg.norm(k)
    return vector * math.cos(angle) + np.cross(k, vector) * math.sin(angle) + k * (k @ vector) * (1.0 - math.cos(angle))


def _ease(times, values, time: float, easing: str) -> np.ndarray:
    """Values (n, c) at `times`, read at `time`; constant outside. `spline` is Catmull-Rom on uneven times."""
    if time <= times[0] or len(times) == 1:
        return values[0]
    if time >= times[-1]:
        return values[-1]
    i = int(np.searchsorted(times, time, side="right")) - 1
    span = times[i + 1] - times[i]
    u = (time - times[i]) / span
    if easing == "linear":
        return values[i] + (values[i + 1] - values[i]) * u
    if easing == "smooth":
        return values[i] + (values[i + 1] - values[i]) * (u * u * (3.0 - 2.0 * u))

    def slope(k):
        a, b = max(k - 1, 0), min(k + 1, len(times) - 1)
        return (values[b] - values[a]) / (times[b] - times[a])

    m0, m1 = slope(i) * span, slope(i + 1) * span
    u2, u3 = u * u, u * u * u
    return (
        (2 * u3 - 3 * u2 + 1) * values[i] + (u3 - 2 * u2 + u) * m0 + (3 * u2 - 2 * u3) * values[i + 1] + (u3 - u2) * m1
    )
