"""Where a picture is taken from: `camera:`. Angles are in degrees, as the camera takes them."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import ColourValue, NotNegative, Number, Positive, Vector, Within
from gen_art.preset.model import Model, about

__all__ = ["CameraKey", "CameraSpec", "Easing", "Fog", "Lens", "CameraOrbit", "Shake"]

Easing = Literal["linear", "smooth", "spline", "accelerate", "brake", "hold"]


FieldOfView = Annotated[float, Within(0, 170, open_low=True, open_high=True)]


class CameraKey(Model):
    """A stop on the camera's path; what is left out stays as the stop before had it."""

    time: Number = about(..., "film time of the stop", unit="s")
    position: Vector | None = about(None, "where the camera is")
    target: Vector | None = about(None, "what it looks at")
    up: Vector | None = about(None, "the direction that is up in the picture")
    fov: FieldOfView | None = about(None, "angle of view from bottom to top", unit="degrees")
    height: Positive | None = about(None, "world units from bottom to top of an orthographic camera")
    roll: Number | None = about(None, "turn about the line of sight", unit="degrees")
    focus: Positive | None = about(None, "the lens's focus distance")
    easing: Easing | None = about(
        None, "the word for the way from this stop to the next, where it differs from the camera's own"
    )


class CameraOrbit(Model):
    """The camera turns about the axis through its target; a number is its `rate`."""

    rate: Number = about(10.0, "turn a film second, right-handed about the axis", unit="degrees/s")
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


class Fog(Model):
    """Light dims as exp(-(d - start) / distance) beyond `start` from the camera, towards `color`; a number is its `distance`."""

    distance: Positive = about(..., "over which light falls to 1/e")
    start: NotNegative = about(0.0, "clear air in front of the camera")
    color: ColourValue = about("black", "what everything turns into far away")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Fog, dict)) else {"distance": value}


class Shake(Model):
    """A hand that holds the camera: it pans and tilts by smooth noise of mean 0; a number is its `amplitude`.

    The noise is a function of the film time and the seed alone. An orthographic camera shifts instead, by what the same
    angle moves the picture of a camera of `fov` degrees.
    """

    amplitude: Annotated[float, Within(0, 45)] = about(
        0.3, "standard deviation of the pan, and of the tilt; it stays within 3.4 of them", unit="degrees"
    )
    frequency: Annotated[float, Within(0, 1000, open_low=True)] = about(
        1.0, "the movement has parts from half of it to twice", unit="Hz"
    )
    roll: Annotated[float, Within(0, 45)] = about(0.0, "standard deviation of the roll", unit="degrees")
    seed: Annotated[int, Field(ge=0, lt=2**63)] = about(0, "another hand")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Shake, dict)) else {"amplitude": value}


class Lens(Model):
    """Depth of field of a thin lens; a number is its `radius`. For a perspective camera.

    A point at depth d is drawn as a disc that has all its light; its radius in the picture is radius * |1 / focus - 1 / d|
    as a slope of sight.
    """

    radius: NotNegative = about(..., "radius of the lens, in world units")
    focus: Positive | None = about(
        None, "what is sharp, in world units along the line of sight; the distance to the target when left out"
    )

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Lens, dict)) else {"radius": value}


class CameraSpec(Model):
    """Where the picture is taken from: a perspective camera with `fov`, or an orthographic one with `height`."""

    position: Vector = about((0.0, 0.0, 10.0), "where it is")
    target: Vector = about((0.0, 0.0, 0.0), "what it looks at, the middle of the picture")
    up: Vector = about((0.0, 1.0, 0.0), "the direction that is up in the picture")
    fov: FieldOfView = about(40.0, "angle of view from bottom to top", unit="degrees")
    height: Positive | None = about(None, "world units from bottom to top: makes the camera orthographic")
    roll: Number = about(0.0, "turn about the line of sight", unit="degrees")
    near: Positive | None = about(None, "nothing nearer along the line of sight is drawn")
    far: Positive | None = about(None, "nothing farther along the line of sight is drawn")
    shutter: Annotated[float, Within(0, 360)] = about(
        180.0, "the part of a frame the shutter is open: 180 is half", unit="degrees"
    )
    fog: Fog | None = about(None, "haze that grows with distance")
    orbit: CameraOrbit | None = about(None, "a steady turn about the target")
    path: tuple[CameraKey, ...] = about((), "stops in film time; fov and height change by equal factors in equal times")
    easing: Easing = about(
        "spline",
        "the way from stop to stop: `smooth` rests at each stop, `spline` passes through them, "
        "`accelerate` leaves from rest, `brake` comes to rest, `hold` stays and then cuts",
    )
    shake: Shake | None = about(None, "a hand that holds the camera")
    lens: Lens | None = about(None, "depth of field")
    subframes: Annotated[int, Field(ge=1, le=256)] = about(
        1,
        "moments of the open shutter whose pictures are averaged, evenly on steps of the clock (the "
        "largest divisor of the open steps up to it); one is enough where streaks draw the motion",
    )
    supersample: Annotated[int, Field(ge=1, le=8)] = about(
        1, "the picture is drawn this many times as wide and high, and averaged"
    )
    size: tuple[Annotated[int, Field(ge=1, le=16384)], Annotated[int, Field(ge=1, le=16384)]] = about(
        (1280, 720), "default size of the picture, width and height in pixels"
    )

    @model_validator(mode="after")
    def _consistent(self):
        if self.near is not None and self.far is not None and self.near >= self.far:
            raise UsageError(f"the camera's near ({self.near:g}) must be less than its far ({self.far:g})")
        if self.lens is not None and self.height is not None:
            raise UsageError(
                "an orthographic camera (`height`) has no lens: it stands infinitely far away, where all "
                "is equally sharp;"
                "leave out `lens`, or give `fov` instead of `height`"
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
                raise UsageError("a path that changes `height` needs a `height` of the camera to begin with")
            if key.focus is not None and self.lens is None:
                raise UsageError("a path that changes `focus` needs a `lens` of the camera")
        return self
