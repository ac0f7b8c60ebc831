"""The camera: perspective or orthographic; still, on a path or in orbit.

Right-handed, y up. The picture's rows run from top to bottom; pixel (row, column) covers [column, column + 1) x
[row, row + 1), so the centre of the frame is (width / 2, height / 2).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.preset.camera import CameraSpec, Fit
from gen_art.quantities import plain
from gen_art.renderer.camera_shake import shake_noise
from gen_art.renderer.colour import linear

__all__ = ["Camera", "CameraView"]

_UNITS = {"up": ""} | dict.fromkeys(("position", "target", "height", "near", "far"), "m")
_UNITS |= dict.fromkeys(("fov", "roll", "shutter"), "degrees")  # of a Camera's numbers


@dataclass(frozen=True)
class CameraView:
    """A camera at one moment; lengths in world units.

    position : (3,)
    axes : (3, 3), rows right, up, forward
    distance : to the target
    fov : degrees from bottom to top (perspective)
    height : world units from bottom to top (orthographic), or None
    near, far : clipping distances along the line of sight
    fog : (start, distance, colour), or None; the colour is None where it is the sky's, which `in_air` fills in
    lens : (radius, focus distance), or None for a pinhole. A point at depth d blurs into a disc with a radius of
        scale * radius * abs(1 / focus - 1 / d) pixels
    """

    position: np.ndarray
    axes: np.ndarray
    distance: float
    fov: float
    height: float | None
    near: float
    far: float
    fog: tuple[float, float, tuple[float, float, float] | None] | None
    lens: tuple[float, float] | None = None
    fog_is_sky: bool = False

    def in_air(self, sky) -> "CameraView":
        """The view with the sky's light at the horizon as the colour of its fog, if that is the sky's.

        sky : a SkyDome or None. Raises UsageError if the fog needs one and there is none.
        """
        if self.fog is None or self.fog[2] is not None:
            return self
        if sky is None:
            raise UsageError("fog of the colour `sky` needs a sky: give the preset a `sky:`, or the fog another colour")
        level = self.axes[2] * (1.0, 0.0, 1.0)
        ahead = level if level.any() else np.array([0.0, 0.0, -1.0])
        red, green, blue = sky.radiance((ahead + (0.0, 1e-3, 0.0))[None])[0].tolist()
        return replace(self, fog=(*self.fog[:2], (red, green, blue)), fog_is_sky=True)

    @property
    def roll(self) -> float:
        """Radians counter-clockwise in the picture from its up to the scene's (+y); 0 where the camera looks up or down."""
        return math.atan2(-self.axes[0, 1], self.axes[1, 1])

    def scale(self, rows: int) -> float:
        """Pixels per world unit (orthographic), or pixels per unit of slope (perspective)."""
        return rows / self.height if self.height else 0.5 * rows / math.tan(math.radians(self.fov) / 2)

    def carried(self, place, heading: float, bank: float = 0.0) -> "CameraView":
        """The view turned about the origin as an aeroplane that flies along x, and then moved.

        place : (3,) where the origin goes
        heading : radians from x towards z, where the x axis points afterwards
        bank : radians, by which the z axis goes down first
        """
        (c, s), (cb, sb) = ((math.cos(angle), math.sin(angle)) for angle in (heading, bank))
        turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        turn = turn @ np.array([[1.0, 0.0, 0.0], [0.0, cb, -sb], [0.0, sb, cb]])
        return replace(self, position=turn @ self.position + np.asarray(place), axes=self.axes @ turn.T)

    def mirrored(self, point, normal) -> "CameraView":
        """The view of the camera's mirror image in a plane. Its picture fits this one's pixel by pixel; its axes are left-handed.

        point, normal : (3,) of the plane, the normal of length 1
        """
        n = np.asarray(normal, np.float64)
        position = self.position - 2.0 * float((self.position - np.asarray(point)) @ n) * n
        return replace(self, position=position, axes=self.axes - 2.0 * np.outer(self.axes @ n, n))

    def project(self, points, size) -> np.ndarray:
        """(n, 3) column, row and depth of world points (n, 3) in a picture of size (width, height)."""
        local = (np.asarray(points, dtype=np.float64) - self.position) @ self.axes.T
        scale = self.scale(size[1]) / (1.0 if self.height else local[:, 2])
        return np.stack([0.5 * size[0] + local[:, 0] * scale, 0.5 * size[1] - local[:, 1] * scale, local[:, 2]], axis=1)


@dataclass(frozen=True)
class Camera:
    """Camera(position, target, up, fov) is a perspective camera; with `height`, an orthographic one.

    position, target, up : (3,) world units
    fov : degrees, bottom to top
    height : world units, bottom to top
    roll : degrees, by which the picture turns clockwise
    near, far : clipping distances along the line of sight (default of near: a thousandth of the distance to the target; an
        orthographic camera by default also sees what is behind it)
    shutter : degrees of a frame, 0 to 360
    lens : (radius, focus distance or None for the target's), world units; perspective only
    spec : path, easing, orbit, follow, shake and fog, as in a preset's `camera:` (see preset/camera.py)
    fit : what the preset's `frame` changes, or None (see renderer/fitting.py)
    Raises UsageError for a camera whose view is undefined.
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
    lens: tuple[float, float | None] | None = None
    spec: CameraSpec = field(default=CameraSpec(), repr=False)
    fit: Fit | None = None

    def __post_init__(self):
        for name in ("position", "target", "up"):
            object.__setattr__(self, name, arguments.vector(f"the camera's {name}", getattr(self, name), _UNITS[name]))
        for name in ("fov", "height", "roll", "near", "far", "shutter"):
            if getattr(self, name) is not None or name in ("fov", "roll", "shutter"):
                label = f"the camera's {name}"
                number = arguments.number(label, plain(getattr(self, name), _UNITS[name], label))
                object.__setattr__(self, name, number)
        if not isinstance(self.spec, CameraSpec):
            raise UsageError(f"the camera's spec must be the `camera` of a preset, not {arguments.shown(self.spec)}")
        if not 0.0 <= self.shutter <= 360.0:
            raise UsageError(f"the camera's shutter must be from 0 to 360 degrees, not {self.shutter:g}")
        if not any(self.up):
            raise UsageError("the camera's up must not be [0, 0, 0]")
        if self.position == self.target and not self.spec.path:
            raise UsageError("the camera's position and target must differ")
        if not 0.0 < self.fov < 170.0:
            raise UsageError(f"the camera's fov must be between 0 and 170 degrees, not {self.fov:g}")
        if self.height is not None and not self.height > 0.0:
            raise UsageError("the camera's height must be above 0")
        if self.lens is not None:
            object.__setattr__(self, "lens", _checked_lens(self.lens))
            if self.height is not None:
                raise UsageError("an orthographic camera has no lens: leave out lens, or give fov instead of height")

    @classmethod
    def from_spec(cls, spec: CameraSpec, fit: Fit | None = None) -> "Camera":
        """The camera that a preset describes; without `fit` as if it had no `frame`."""
        fields = ("position", "target", "up", "fov", "height", "roll", "near", "far", "shutter")
        lens = (spec.lens.radius, spec.lens.focus) if spec.lens else None
        return cls(**{name: getattr(spec, name) for name in fields}, lens=lens, spec=spec, fit=fit)

    @classmethod
    def framing(cls, points: ArrayLike, aspect: float = 16 / 9) -> "Camera":
        """A camera in front (on +z) with all but the farthest hundredth of the points (n, 3) in its frame."""
        finite = _points(points)
        finite = finite[np.isfinite(finite).all(axis=1)]
        aspect = arguments.number("aspect", aspect, above=0.0)
        if not len(finite):
            return cls()
        low, high = np.percentile(finite, [1, 99], axis=0) if len(finite) > 200 else (finite.min(0), finite.max(0))
        centre, half_extent = 0.5 * (low + high), 0.5 * (high - low)
        radius = max(half_extent[1], half_extent[0] / aspect, half_extent[2] * 0.5, 1e-9 * (1.0 + np.abs(centre).max()))
        if radius < 1e-6:
            radius = 1.0
        distance = 1.25 * radius / math.tan(math.radians(20.0)) + half_extent[2]
        return cls(position=tuple(centre + (0.0, 0.0, distance)), target=tuple(centre))

    @property
    def moves(self) -> bool:
        """Whether its view changes with time."""
        return self.spec.moves

    def at(self, time: float = 0.0) -> CameraView:
        """The camera at film time `time` (seconds). Raises UsageError if it then stands at its target.

        Of a camera that follows a system it is the view as if the system were at the origin, heading along x: see `carried`.
        """
        time = arguments.number("time", time, "s")
        state = self._path_state(time)
        position, target, up = state["position"], state["target"], state["up"]
        orbit, fog, shake = self.spec.orbit, self.spec.fog, self.spec.shake
        if orbit is not None:
            position = target + _rotated(position - target, orbit.axis, math.radians(orbit.start + orbit.rate * time))
        forward = target - position
        distance = float(np.linalg.norm(forward))
        if distance == 0.0:
            raise UsageError(f"the camera reaches its target at {time:g} s and looks nowhere")
        axes = _axes(forward / distance, up, state["roll"])
        back = 0.0  # how much farther the camera is from its target than `frame` found it
        if self.fit is not None:
            if state["height"] is not None:
                state["height"] *= self.fit.factor
            else:
                back = (self.fit.factor - 1.0) * distance
            position = position + self.fit.move - axes[2] * back
            distance += back
        if shake is not None:
            tilt, pan, roll = np.radians([shake.amplitude, shake.amplitude, shake.roll]) * shake_noise(
                time, shake.frequency, shake.seed
            )
            if state["height"] is not None:
                units_per_slope = 0.5 * state["height"] / math.tan(0.5 * math.radians(state["fov"]))
                position = position + units_per_slope * (math.tan(pan) * axes[0] + math.tan(tilt) * axes[1])
                pan = tilt = 0.0
            axes = _rotated_axes(axes, pan, tilt, roll)
        near = self.near
        if near is not None:
            near = max(near + back, 1e-6 * distance)
        else:
            near = 1e-3 * distance if state["height"] is None else -math.inf
        focus = max(state["focus"] + back, 1e-6 * distance) if state["focus"] is not None else distance
        return CameraView(
            position=position,
            axes=axes,
            distance=distance,
            fov=state["fov"],
            height=state["height"],
            near=near,
            far=self.far + back if self.far is not None else math.inf,
            fog=(fog.start + back, fog.distance, None if fog.color == "sky" else tuple(linear(fog.color)))
            if fog
            else None,
            lens=(self.lens[0], focus) if self.lens and self.lens[0] > 0.0 else None,
        )

    def _path_state(self, time: float) -> dict:
        """The values that the stops of a path may change, at film time `time`: vectors as arrays, the rest as floats or None.

        If any stop has `focus`, a stop without one focuses on its own target.
        """
        state = {name: getattr(self, name) for name in _INTERPOLATION if name != "focus"} | {
            "focus": self.lens[1] if self.lens else None
        }
        if self.spec.path:
            rows = [state]
            for key in self.spec.path:
                rows.append({n: old if getattr(key, n) is None else getattr(key, n) for n, old in rows[-1].items()})
            rows = rows[1:]
            if any(row["focus"] is not None for row in rows):
                for row in rows:
                    row["focus"] = row["focus"] or math.dist(row["position"], row["target"])
            times = [key.time for key in self.spec.path]
            easings = [key.easing or self.spec.easing for key in self.spec.path]
            for name, (to_scale, from_scale) in _INTERPOLATION.items():
                column = [row[name] for row in rows]
                if None not in column:
                    values = to_scale(np.array(column, dtype=np.float64).reshape(len(rows), -1))
                    value = from_scale(_ease(times, values, time, easings))
                    state[name] = value if len(value) == 3 else float(value[0])
        return state | {name: np.array(state[name], dtype=np.float64) for name in ("position", "target", "up")}


def _points(given) -> np.ndarray:
    try:
        return np.asarray(plain(given, "m", "points"), dtype=np.float64).reshape(-1, 3)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"points must be numbers of the shape (n, 3), not {arguments.shown(given)}") from None


def _checked_lens(lens) -> tuple[float, float | None]:
    if not isinstance(lens, (tuple, list)) or len(lens) != 2:
        raise UsageError(
            f"the camera's lens must be a pair (radius, focus distance or None), not {arguments.shown(lens)}"
        )
    label = "the radius of the camera's lens"
    radius = arguments.number(label, plain(lens[0], "m", label), low=0.0)
    if lens[1] is None:
        return radius, None
    label = "the focus distance of the camera's lens"
    return radius, arguments.number(label, plain(lens[1], "m", label), above=0.0)


def _identity(x):
    return x


def _half_tangent(fov):
    return np.log(np.tan(np.radians(fov) / 2))


def _fov_of(half_tangent):
    return np.minimum(np.degrees(2 * np.arctan(np.exp(half_tangent))), 169.9)  # a spline may overshoot its stops


# the scale in which a path interpolates each value, and back: zooms by equal factors in equal times
_INTERPOLATION: dict[str, tuple[Callable, Callable]] = {
    "position": (_identity, _identity),
    "target": (_identity, _identity),
    "up": (_identity, _identity),
    "fov": (_half_tangent, _fov_of),
    "height": (np.log, np.exp),
    "roll": (_identity, _identity),
    "focus": (np.log, np.exp),
}


def _axes(forward, up, roll: float) -> np.ndarray:
    """Rows right, up, forward of a camera that looks along `forward` (unit) with `up` above it, rolled by degrees."""
    right = np.cross(forward, up)
    if np.linalg.norm(right) < 1e-9 * max(
        float(np.linalg.norm(up)), 1e-30
    ):  # looking along `up`: any other direction serves
        right = np.cross(forward, [0.0, 0.0, -1.0] if abs(forward[2]) < 0.9 else [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    return _rotated_axes(np.stack([right, np.cross(right, forward), forward]), 0.0, 0.0, math.radians(roll))


def _rotated_axes(axes, pan: float, tilt: float, roll: float) -> np.ndarray:
    """Axes rotated right by `pan`, then up by `tilt`, then about the line of sight by `roll` (radians)."""
    right, up, forward = axes
    forward, right = (
        math.cos(pan) * forward + math.sin(pan) * right,
        math.cos(pan) * right - math.sin(pan) * forward,
    )
    forward, up = (
        math.cos(tilt) * forward + math.sin(tilt) * up,
        math.cos(tilt) * up - math.sin(tilt) * forward,
    )
    right, up = (
        math.cos(roll) * right + math.sin(roll) * up,
        math.cos(roll) * up - math.sin(roll) * right,
    )
    return np.stack([right, up, forward])


def _rotated(vector, axis, angle: float) -> np.ndarray:
    """`vector` rotated by `angle` (radians) about `axis` (Rodrigues)."""
    k = np.asarray(axis, dtype=np.float64)
    k = k / np.linalg.norm(k)
    return vector * math.cos(angle) + np.cross(k, vector) * math.sin(angle) + k * (k @ vector) * (1.0 - math.cos(angle))


_EASINGS = {
    "linear": lambda u: u,
    "smooth": lambda u: u * u * (3.0 - 2.0 * u),
    "accelerate": lambda u: u * u,
    "brake": lambda u: u * (2.0 - u),
    "hold": lambda u: 0.0,
}


def _ease(times, values, time: float, easings) -> np.ndarray:
    """Values (n, c) given at `times`, read at `time`; constant outside.

    easings[i] is the word for the interval from i to i + 1; `spline` is Catmull-Rom on uneven times.
    """
    if time <= times[0] or len(times) == 1:
        return values[0]
    if time >= times[-1]:
        return values[-1]
    i = int(np.searchsorted(times, time, side="right")) - 1
    span = times[i + 1] - times[i]
    u = (time - times[i]) / span
    if easings[i] != "spline":
        return values[i] + (values[i + 1] - values[i]) * _EASINGS[easings[i]](u)

    def slope(k):
        a, b = max(k - 1, 0), min(k + 1, len(times) - 1)
        return (values[b] - values[a]) / (times[b] - times[a])

    m0, m1 = slope(i) * span, slope(i + 1) * span
    u2, u3 = u * u, u * u * u
    return (
        (2 * u3 - 3 * u2 + 1) * values[i] + (u3 - 2 * u2 + u) * m0 + (3 * u2 - 2 * u3) * values[i + 1] + (u3 - u2) * m1
    )
