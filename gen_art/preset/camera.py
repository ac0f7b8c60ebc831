"""The keys of `camera:`. Angles are in degrees."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.colour_names import srgb
from gen_art.preset.fields import NotNegative, Number, Parsed, Positive, Vector, Within, Words
from gen_art.preset.model import Model, about
from gen_art.preset.values import shown

__all__ = ["CameraKey", "CameraOrbit", "CameraSpec", "Easing", "Fit", "Fog", "Frame", "Lens", "Shake"]

Easing = Literal["linear", "smooth", "spline", "accelerate", "brake", "hold"]


FieldOfView = Annotated[float, Within(1e-6, 170, open_high=True)]  # less has no slope in float32


@dataclass(frozen=True)
class Fit:
    """What `frame` changes of a camera, at all times alike.

    move : (3,), added to the target, world units
    factor : of the distance to the target, or of an orthographic camera's height
    """

    move: tuple[float, float, float] = (0.0, 0.0, 0.0)
    factor: float = 1.0


class CameraKey(Model):
    """A stop on the camera's path; a key that is left out keeps its value from the stop before."""

    time: Number = about(..., "film time of the stop", unit="s")
    position: Vector | None = about(None, "where the camera is")
    target: Vector | None = about(None, "the point that the camera looks at")
    up: Vector | None = about(None, "the direction that is up in the picture")
    fov: FieldOfView | None = about(None, "angle of view from bottom to top", unit="degrees")
    height: Positive | None = about(None, "height of an orthographic camera's view, in world units")
    roll: Number | None = about(None, "rotation about the line of sight", unit="degrees")
    focus: Positive | None = about(None, "focus distance of the lens, in world units")
    easing: Easing | None = about(None, "motion from this stop to the next; the camera's `easing` when left out")


class CameraOrbit(Model):
    """The camera orbits the axis through its target; a number sets the `rate`."""

    rate: Number = about(10.0, "angle per second of film, right-handed about the axis", unit="degrees/s")
    start: Number = about(0.0, "angle at film time 0", unit="degrees")
    axis: Vector = about((0.0, 1.0, 0.0), "direction of the axis")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (CameraOrbit, dict)) else {"rate": value}

    @model_validator(mode="after")
    def _turning(self):
        if not any(self.axis):
            raise UsageError("an orbit's axis must not be [0, 0, 0]")
        return self


class Follow(Model):
    """The camera goes with a system: its position, target and path are relative to the mean position of the living particles."""

    system: str = about(
        ..., "the system that the camera follows; while no particle of it is alive, the origin takes its place"
    )
    turn: bool = about(
        False,
        "turn with it about the vertical: position, target and path are then as if it headed along x, with z to its right",
    )

    bank: Positive | None = about(
        None,
        "lean into turns as an aeroplane does, by atan(a / bank) with its acceleration a to the right: the gravity that it "
        "flies in. Needs `turn`",
        unit="m/s^2",
    )

    short_form = {"type": "string"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Follow, dict)) else {"system": value}

    @model_validator(mode="after")
    def _leaning(self):
        if self.bank is not None and not self.turn:
            raise UsageError("a camera that leans into turns (`bank`) turns with its system: give `turn: true`")
        return self


def _fog_colour(value):
    if value == "sky":
        return value
    srgb(value)
    return tuple(value) if isinstance(value, list) else value


class Fog(Model):
    """Beyond `start`, light fades towards `color` as exp(-(d - start) / distance); a number sets the `distance`."""

    distance: Positive = about(..., "distance over which light falls to 1/e, in world units")
    start: NotNegative = about(0.0, "distance from the camera at which the fog begins, in world units")
    color: Annotated[Any, Parsed(_fog_colour, {"type": ["string", "array"]})] = about(
        "black",
        "the colour of the fog; `sky` takes the light of the preset's sky at the horizon, as haze in the air does",
    )

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Fog, dict)) else {"distance": value}


class Shake(Model):
    """Camera shake: the camera pans and tilts by smooth noise of mean 0; a number sets the `amplitude`.

    The noise depends on the film time and the seed only. An orthographic camera shifts instead, by the distance that the
    same angle moves the picture of a camera of `fov` degrees.
    """

    amplitude: Annotated[float, Within(0, 45)] = about(
        0.3, "standard deviation of pan and tilt; they stay within 3.4 standard deviations", unit="degrees"
    )
    frequency: Annotated[float, Within(0, 1000, open_low=True)] = about(
        1.0, "middle frequency of the movement, which ranges from half of it to twice", unit="Hz"
    )
    roll: Annotated[float, Within(0, 45)] = about(0.0, "standard deviation of the roll", unit="degrees")
    seed: Annotated[int, Field(ge=0, lt=2**63)] = about(0, "another seed gives another movement")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Shake, dict)) else {"amplitude": value}


class Lens(Model):
    """Depth of field of a thin lens, for a perspective camera; a number sets the `radius`.

    A point at depth d is drawn as a disc with all of the point's light; the disc's radius in the picture, as the tangent of
    an angle of view, is radius * |1 / focus - 1 / d|.
    """

    radius: NotNegative = about(..., "radius of the lens, in world units")
    focus: Positive | None = about(
        None, "focus distance along the line of sight, in world units; the distance to the target when left out"
    )

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Lens, dict)) else {"radius": value}


class Frame(Model):
    """Moves the target, and sets the distance (or the `height`), so that the picture holds what is seen in the whole film.

    `auto` takes the values below; a number sets `fill`. At its largest over the film the subject fills this part of the
    picture's height, or of its width if it is wide, and a tenth of the picture stays free at every side. The direction of
    view and `fov` stay as they are, and so do the distances of near, far, fog and focus from the target.
    """

    fill: Annotated[float, Within(0.05, 0.8)] = about(
        0.65, "part of the picture's height or width that the subject fills"
    )
    stray: Annotated[float, Within(0, 0.5)] = about(
        0.01, "the part of the light, of the particles farthest out, that does not count at each moment"
    )

    of: Words | None = about(
        None, "the systems that are the subject, a name or a list; all that have a look when left out"
    )

    short_form = {"anyOf": [{"const": "auto"}, {"const": False}, {"type": ["number", "string"]}]}

    @classmethod
    def from_short(cls, value):
        if isinstance(value, (Frame, dict)):
            return value
        if value is True or value == "auto":
            return {}
        if isinstance(value, str) and not any(c.isdigit() for c in value):
            raise UsageError(f"must be auto, false or a number such as 0.65, not {shown(value)}")
        return {"fill": value}


def _frame(value):
    return None if value is False else value


class CameraSpec(Model):
    """The camera: perspective with `fov`, or orthographic with `height`."""

    position: Vector = about((0.0, 0.0, 10.0), "where the camera is")
    target: Vector = about((0.0, 0.0, 0.0), "the point that the camera looks at, the middle of the picture")
    up: Vector = about((0.0, 1.0, 0.0), "the direction that is up in the picture")
    fov: FieldOfView = about(40.0, "angle of view from bottom to top", unit="degrees")
    height: Positive | None = about(None, "height of the view in world units; makes the camera orthographic")
    frame: Annotated[Frame | None, BeforeValidator(_frame)] = about(
        None, "`auto` fits what is seen in the whole film into the picture, by distance (or `height`) and target"
    )
    roll: Number = about(0.0, "rotation about the line of sight", unit="degrees")
    near: Positive | None = about(None, "particles nearer than this along the line of sight are not drawn")
    far: Positive | None = about(None, "particles farther than this along the line of sight are not drawn")
    shutter: Annotated[float, Within(0, 360)] = about(
        180.0, "shutter angle: 180 means that the shutter is open for half of a frame", unit="degrees"
    )
    fog: Fog | None = about(None, "fog that increases with distance")
    orbit: CameraOrbit | None = about(None, "a steady orbit about the target")
    follow: Follow | None = about(None, "the camera goes with a system, given by its name or as a mapping")
    path: tuple[CameraKey, ...] = about(
        (), "stops in film time; between them fov and height change by equal factors in equal times"
    )
    easing: Easing = about(
        "spline",
        "motion between stops: `linear` at constant speed, `smooth` rests at each stop, `spline` passes through them "
        "smoothly, `accelerate` starts from rest, `brake` comes to rest, `hold` stays at a stop and then jumps to the next",
    )
    shake: Shake | None = about(None, "the shake of a hand-held camera")
    lens: Lens | None = about(None, "depth of field")
    subframes: Annotated[int, Field(ge=1, le=256)] = about(
        1,
        "number of moments within the open shutter whose pictures are averaged. They are evenly spaced on time steps, so "
        "the number is the largest divisor of the open steps that is not above this. One is enough where streaks draw "
        "the motion",
    )
    supersample: Annotated[int, Field(ge=1, le=8)] = about(
        1, "supersampling: the picture is drawn this many times wider and higher, and then averaged"
    )
    size: tuple[Annotated[int, Field(ge=1, le=16384)], Annotated[int, Field(ge=1, le=16384)]] = about(
        (1280, 720), "default size of the picture, width and height in pixels"
    )

    @property
    def moves(self) -> bool:
        """Whether its view changes with time."""
        return bool(self.path) or any(part is not None for part in (self.orbit, self.shake, self.follow))

    @model_validator(mode="after")
    def _consistent(self):
        if self.near is not None and self.far is not None and self.near >= self.far:
            raise UsageError(f"the camera's near ({self.near:g}) must be less than its far ({self.far:g})")
        if self.follow is not None and self.frame is not None:
            raise UsageError(
                "`frame` fits a whole film into the picture, which a camera with `follow` leaves: give one of them"
            )
        if self.lens is not None and self.height is not None:
            raise UsageError(
                "an orthographic camera (`height`) has no depth of field: leave out `lens`, or give `fov` instead of "
                "`height`"
            )
        for before, after in zip(self.path, self.path[1:]):
            if after.time <= before.time:
                raise UsageError(f"the path's times must increase: {after.time:g} follows {before.time:g}")
        position, target = self.position, self.target
        if position == target and not self.path:
            raise UsageError("the camera's position and target must differ")
        for key in self.path:
            position, target = key.position or position, key.target or target
            if position == target:
                raise UsageError(f"the camera's position and target must differ, also at {key.time:g} s of its path")
            if key.height is not None and self.height is None:
                raise UsageError("a path that changes `height` needs `height` in the camera")
            if key.focus is not None and self.lens is None:
                raise UsageError("a path that changes `focus` needs `lens` in the camera")
        return self
