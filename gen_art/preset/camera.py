"""Where a picture is taken from: `camera:`. Angles are in degrees, as the camera takes them."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import ColourValue, Number, Vector
from gen_art.preset.types import Model

__all__ = ["CameraKey", "CameraSpec", "Fog", "Orbit"]


class CameraKey(Model):
    """A stop on the camera's path; what is left out stays as the key before had it."""

    time: Number
    position: Vector | None = None
    target: Vector | None = None
    up: Vector | None = None
    fov: Annotated[Number, Field(gt=0, lt=170)] | None = None
    height: Annotated[Number, Field(gt=0)] | None = None
    roll: Number | None = None


class Orbit(Model):
    """The camera turns about the axis through its target: `rate` degrees a film second, from `start` degrees."""

    rate: Number = 10.0
    start: Number = 0.0
    axis: Vector = (0.0, 1.0, 0.0)

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Orbit, dict)) else {"rate": value}


class Fog(Model):
    """Light dims as exp(-(d - start) / distance) beyond `start` from the camera, towards `color`."""

    distance: Annotated[Number, Field(gt=0)]
    start: Annotated[Number, Field(ge=0)] = 0.0
    color: ColourValue = "black"

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Fog, dict)) else {"distance": value}


class CameraSpec(Model):
    """Where the picture is taken from. Perspective, `fov` degrees from bottom to top; with `height` (world units from
    bottom to top) orthographic. shutter: degrees of a frame it is open, 180 being half. near: nothing nearer is drawn.
    path: stops in film time; easing `linear`, `smooth` (rests at each stop) or `spline` (passes through them).
    size: the picture's default size [width, height].
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
    easing: Literal["linear", "smooth", "spline"] = "spline"
    size: tuple[Annotated[int, Field(ge=1, le=16384)], Annotated[int, Field(ge=1, le=16384)]] = (1280, 720)

    @model_validator(mode="after")
    def _consistent(self):
        if self.position == self.target:
            raise UsageError("the camera's position and target must differ")
        for before, after in zip(self.path, self.path[1:]):
            if after.time <= before.time:
                raise UsageError(f"the path's times must increase: {after.time:g} follows {before.time:g}")
        return self
