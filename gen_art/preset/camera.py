"""Where a picture is taken from: `camera:`. Angles are in degrees, as the camera takes them."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import ColourValue, Number, Vector
from gen_art.preset.types import Model

__all__ = ["CameraKey", "CameraSpec", "Easing", "Fog", "Lens", "Orbit", "Shake"]

Easing = Literal["linear", "smooth", "spline", "accelerate", "brake", "hold"]


class CameraKey(Model):
    """A stop on the camera's path; what is left out stays as the key before had it.

    easing: the word for the way from this stop to the next, where it differs from the camera's own. focus: the lens's
    focus distance.
    """

    time: Number
    position: Vector | None = None
    target: Vector | None = None
    up: Vector | None = None
    fov: Annotated[Number, Field(gt=0, lt=170)] | None = None
    height: Annotated[Number, Field(gt=0)] | None = None
    roll: Number | None = None
    focus: Annotated[Number, Field(gt=0)] | None = None
    easing: Easing | None = None


class Orbit(Model):
    """The camera turns about the axis through its target: `rate` degrees a film second, from `start` degrees."""

    rate: Number = 10.0
    start: Number = 0.0
    axis: Vector = (0.0, 1.0, 0.0)

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Orbit, dict)) else {"rate": value}

    @model_validator(mode="after")
    def _turning(self):
        if not any(self.axis):
            raise UsageError("an orbit's axis must not be [0, 0, 0]")
        return self


class Fog(Model):
    """Light dims as exp(-(d - start) / distance) beyond `start` from the camera, towards `color`."""

    distance: Annotated[Number, Field(gt=0)]
    start: Annotated[Number, Field(ge=0)] = 0.0
    color: ColourValue = "black"

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Fog, dict)) else {"distance": value}


class Shake(Model):
    """A hand that holds the camera: it pans and tilts by smooth noise of mean 0.

    amplitude: the standard deviation of the pan, and of the tilt, in degrees; the noise stays within 3.4 of them.
    frequency: Hz; the movement has parts from half of it to twice. roll: the standard deviation of the roll in degrees.
    seed: another hand. The noise is a function of the film time and the seed alone. An orthographic camera shifts
    instead, by what the same angle moves the picture of a camera of `fov` degrees.
    """

    amplitude: Annotated[Number, Field(ge=0, le=45)] = 0.3
    frequency: Annotated[Number, Field(gt=0, le=1000)] = 1.0
    roll: Annotated[Number, Field(ge=0, le=45)] = 0.0
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Shake, dict)) else {"amplitude": value}


class Lens(Model):
    """Depth of field: a thin lens of `radius` (world units) that is sharp at `focus` (world units along the line of
    sight; the distance to the target unless given).

    A point at depth d is drawn as a disc of radius * |1 / focus - 1 / d| pixels per unit of slope, with all its light.
    Perspective only.
    """

    radius: Annotated[Number, Field(ge=0)]
    focus: Annotated[Number, Field(gt=0)] | None = None

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Lens, dict)) else {"radius": value}


class CameraSpec(Model):
    """Where the picture is taken from. Perspective, `fov` degrees from bottom to top; with `height` (world units from
    bottom to top) orthographic. shutter: degrees of a frame it is open, 180 being half. near, far: nothing nearer or
    farther along the line of sight is drawn. path: stops in film time. easing of the way from stop to stop: `linear`,
    `smooth` (rests at each stop), `spline` (passes through them), `accelerate` (leaves from rest), `brake` (comes to
    rest) or `hold` (stays, then cuts). fov and height change by equal factors in equal times.
    subframes: moments of the open shutter whose pictures are averaged, evenly on steps of the clock (the largest divisor of
    the open steps up to it); one is enough where motion is drawn by streaks. supersample: the picture is drawn this many
    times as wide and high and averaged. size: the picture's default size [width, height].
    """

    position: Vector = (0.0, 0.0, 10.0)
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov: Annotated[Number, Field(gt=0, lt=170)] = 40.0
    height: Annotated[Number, Field(gt=0)] | None = None
    roll: Number = 0.0
    near: Annotated[Number, Field(gt=0)] | None = None
    far: Annotated[Number, Field(gt=0)] | None = None
    shutter: Annotated[Number, Field(ge=0, le=360)] = 180.0
    fog: Fog | None = None
    orbit: Orbit | None = None
    path: tuple[CameraKey, ...] = ()
    easing: Easing = "spline"
    shake: Shake | None = None
    lens: Lens | None = None
    subframes: Annotated[int, Field(ge=1, le=256)] = 1
    supersample: Annotated[int, Field(ge=1, le=8)] = 1
    size: tuple[Annotated[int, Field(ge=1, le=16384)], Annotated[int, Field(ge=1, le=16384)]] = (1280, 720)

    @model_validator(mode="after")
    def _consistent(self):
        if self.near is not None and self.far is not None and self.near >= self.far:
            raise UsageError(f"the camera's near ({self.near:g}) must be less than its far ({self.far:g})")
        if self.lens is not None and self.height is not None:
            raise UsageError(
                "an orthographic camera (`height`) has no lens: it stands infinitely far away, where all is equally sharp; "
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
