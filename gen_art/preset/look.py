"""How a system is drawn: `look:`. Frozen pydantic models; attribute names are the YAML keys."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.fields import (
    ColourValue,
    CurveValue,
    Fraction,
    GradientValue,
    NotNegative,
    Number,
    Positive,
    RangeValue,
    Vector,
    Within,
    Words,
)
from gen_art.preset.files import ImageFile, PresetFile
from gen_art.preset.model import Model, about
from gen_art.preset.values import Curve, Range, number

__all__ = ["BY", "Color", "Emission", "KeyLight", "Look", "Picture", "Ramp", "Ribbon", "Trail"]

BY = (
    "age", "seconds", "speed", "energy", "charge", "mass", "radius", "id", "random", "distance", "x", "y", "z",
    "acceleration",
)  # fmt: skip


class Ramp(Model):
    """A number that may follow a quantity of the particle: `3`, `[[0, 1], [1, 0]]` (by age) or a mapping.

    Quantities: `age` is the fraction of the lifetime, 0 at birth and 1 at death; `seconds` the age in simulated seconds;
    `speed` m/s; `acceleration` m/s^2, over the last time step; `energy` the kinetic energy in J; `charge` C;
    `distance` from the origin in m; `x`, `y`, `z`; `random` a number in 0..1 that is the particle's own; or a declared
    attribute such as `temperature`.
    """

    by: str = about("age", "the quantity")
    range: RangeValue | None = about(None, "the quantity at 0 and at 1 of the curve")
    curve: CurveValue = about(Curve(((0.0, 1.0),)), "a number, or points of a curve")

    short_form = {"type": ["number", "string", "array"], "description": "a number, or a curve over age"}

    @classmethod
    def from_short(cls, value):
        if isinstance(value, (Ramp, dict)):
            return value
        if isinstance(value, (list, tuple)):
            return {"curve": value}
        return {"curve": ((0.0, number(value)),)}

    @property
    def constant(self) -> bool:
        return len(self.curve.points) == 1


class Color(Model):
    """Colours by a quantity: a colour, a palette, or `{by: age, gradient: [white, crimson]}`.

    Further keys are tags of emitters, with gradients of their own: `{by: age, clean: [white, crimson], tail: [gold, teal]}`.
    """

    model_config = ConfigDict(frozen=True, extra="allow", arbitrary_types_allowed=True)
    __pydantic_extra__: dict[str, GradientValue]

    by: str = about("age", "the quantity, as for numbers")
    range: RangeValue | None = about(None, "the quantity at the two ends of the gradient")
    gradient: GradientValue = about(Gradient(((0.0, "white"),)), "a colour, a palette, or colours in a list")

    short_form = {"type": ["string", "array"], "description": "a colour, a palette or a gradient"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Color, dict)) else {"gradient": value}

    @model_validator(mode="after")
    def _has_range(self):
        several = any(len(g.stops) > 1 for g in (self.gradient, *self.tags.values()))
        if several and self.range is None and self.by not in ("age", "random"):
            raise UsageError(
                f"colours by {self.by} need a range: the values at the two ends of the gradient, as in 0..5"
            )
        return self

    @property
    def tags(self) -> dict[str, Gradient]:
        return self.__pydantic_extra__ or {}


class Emission(Model):
    """Light a particle gives off.

    For discs and streaks `intensity` is the brightness at the middle of the sprite; a point has the area of one pixel of a
    picture 720 rows high.
    """

    color: Color | None = about(None, "its colour; white when left out")
    intensity: Ramp = about(Ramp(), "its brightness")
    blackbody: Ramp | None = about(
        None, "temperature, or a curve of temperature over age (or over `by: seconds`); gives the colour", unit="K"
    )
    planck: Fraction = about(
        0.3,
        "how much of Planck's fall of brightness towards lower temperatures to keep, relative to the "
        "hottest: 0 none, 1 all",
    )
    strobe: RangeValue | None = about(None, "a rate, with a phase, drawn once a particle", unit="Hz")
    duty: Annotated[float, Within(0, 1, open_low=True)] = about(
        0.35, "the part of each period of the strobe that is lit"
    )

    short_form = {"type": ["string", "array"], "description": "a colour, a palette or a gradient"}

    @classmethod
    def from_short(cls, value):
        if isinstance(value, (str, list, tuple)):
            return {"color": value}
        return value


class KeyLight(Model):
    """A distant lamp that shines on smoke through the smoke itself, the sky around it, and the glow of other systems."""

    direction: Vector = about((-1.0, -1.0, -0.5), "the way the lamp's light travels")
    color: ColourValue = about("white", "the lamp's colour")
    intensity: NotNegative = about(3.0, "the lamp's brightness")
    ambient: ColourValue = about("white", "the sky's colour, from all sides")
    ground: ColourValue | None = about(None, "the colour of what comes from below; the sky's when left out")
    ambient_intensity: NotNegative = about(0.08, "the sky's brightness")
    phase: Annotated[float, Within(-1, 1, open_low=True, open_high=True)] = about(
        0.0, "Henyey-Greenstein's g: -1 back to 1 forward scattering, 0 even"
    )
    scatter: Fraction = about(
        0.2,
        "the part of the light that was scattered once before; it meets half the depth, and so on for that part of it",
    )
    depth: NotNegative = about(1.0, "factor on the optical depth this system casts into all light")
    resolution: Annotated[int, Field(ge=8, le=256)] = about(96, "cells along the longest side of the density grid")
    glow: Words = about((), "systems whose own light shines on this one")
    glow_intensity: NotNegative = about(1.0, "1 is as bright as they are")
    glow_softness: NotNegative = about(0.0, "widens their light near them, in world units")

    @model_validator(mode="after")
    def _pointing(self):
        if not any(self.direction):
            raise UsageError("a light's direction must not be [0, 0, 0]")
        return self


class Trail(Model):
    """The film keeps what the system drew and lets it fade, alike at any fps; the particles are drawn over it as ever.

    A number is its `half_life`. Trails start 16 half-lives before frame 0, or with the simulation.
    """

    half_life: Positive = about(..., "film time in which it fades to one half", unit="s")
    strength: NotNegative = about(1.0, "its brightness; at 1 a particle at rest builds up a trail as bright as itself")
    substeps: Annotated[int, Field(ge=1, le=64)] = about(
        1,
        "how many times the system is drawn from frame to frame (the largest divisor of a frame's steps up "
        "to it), so that fast curves stay smooth",
    )

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Trail, dict)) else {"half_life": value}


class Ribbon(Model):
    """Each particle draws the path it came along. Needs `draw: streak`, whose width it begins with; a number is its `length`.

    The emission's `intensity` is its brightness along the middle, whatever the particle's speed.
    """

    length: Positive = about(..., "how far back it goes, in simulated time", unit="s")
    points: Annotated[int, Field(ge=2, le=256)] = about(16, "positions that are remembered")
    taper: Fraction = about(0.0, "width at the old end, relative to the particle's")
    tail: Fraction = about(0.0, "brightness at the old end, relative to the particle's")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Ribbon, dict)) else {"length": value}


class Picture(Model):
    """A picture for every particle, `radius` from its middle to its sides; white paint takes the particle's colour."""

    image: Annotated[PresetFile, ImageFile] = about(..., "the file, in the preset's folder, with a transparent ground")
    turn: Literal["random"] | Number = about(0.0, "counter-clockwise; `random` turns each its own way", unit="degrees")
    spin: RangeValue = about(Range(0.0, 0.0), "turn a simulated second, drawn once a particle", unit="degrees/s")

    short_form = {"type": "string", "description": "the picture's file"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Picture, dict)) else {"image": value}


class Look(Model):
    """How a system's particles are drawn. The `size` of all kinds scales with the picture's height."""

    draw: Literal["point", "pixel", "disc", "streak", "sphere", "picture"] = about(
        "point",
        "`point` is a dot placed between pixels, `pixel` light in the one pixel it falls in, `disc` a soft "
        "Gaussian sprite whose radius is 2.2 standard deviations, "
        "`streak` the way of the last `length` seconds, `sphere` an even disc with a sharp rim, `picture` "
        "an image",
    )
    picture: Picture | None = about(None, "the image of `draw: picture`")
    blend: Literal["add", "alpha", "opaque"] = about(
        "add", "`add` is light, `alpha` also hides what is behind it, `opaque` hides all of it"
    )
    radius: Positive | None = about(None, "of the sprite in world units; the particle's own when left out")
    width: Positive | None = about(None, "of a streak in world units: two radii")
    pixels: Annotated[float, Within(0, 4096, open_low=True)] | None = about(
        None, "radius in pixels of a picture 720 rows high instead"
    )
    size: Ramp = about(Ramp(), "a factor on radius, width or pixels")
    length: NotNegative | None = about(
        None, "of a streak in simulated time; as long as the shutter is open when left out", unit="s"
    )
    tail: Fraction = about(1.0, "a streak's brightness at its old end, relative to its head")
    taper: Fraction = about(1.0, "a streak's width at its old end, relative to its head")
    emission: Emission | None = about(None, "the light it gives off; white, 1 when nothing else is given")
    opacity: Ramp = about(Ramp(), "optical depth at the middle of a sprite")
    reference: Positive | None = about(
        None,
        "the radius of which `opacity` speaks: the depth falls as (reference / r)^2, so that a growing "
        "sprite keeps its extinction cross section",
        unit="m",
    )
    albedo: Color = about(Color.model_validate({}), "the part of the light that it scatters, by colour")
    light: KeyLight | None = about(None, "what shines on it")
    falloff: Literal["none", "inverse_square"] = about(
        "none", "`inverse_square` dims points as 1/d^2, with 1 at the camera's target"
    )
    trail: Trail | None = about(None, "an afterglow on the film")
    ribbon: Ribbon | None = about(None, "the path it came along")

    def goes_by(self, quantity: str) -> bool:
        """Whether any number or colour follows this quantity."""
        light = self.emission
        ramps: list[Ramp | Color] = [self.size, self.opacity, self.albedo]
        ramps += [r for r in (light.intensity, light.blackbody, light.color) if r is not None] if light else []
        return any(ramp.by == quantity for ramp in ramps)

    @model_validator(mode="after")
    def _consistent(self):
        if sum(v is not None for v in (self.radius, self.width, self.pixels)) > 1:
            raise UsageError("give one of radius, width and pixels")
        if self.draw == "pixel" and self.pixels is not None:
            raise UsageError("draw: pixel has no size: leave out `pixels`, or give draw: disc")
        if (self.draw == "picture") != (self.picture is not None):
            raise UsageError("draw: picture and a picture go together: `draw: picture` and `picture: spark.png`")
        if self.blend == "alpha" and self.draw not in ("disc", "sphere", "picture"):
            raise UsageError("blend: alpha needs draw: disc, sphere or picture")
        if self.blend == "opaque" and self.draw not in ("sphere", "picture"):
            raise UsageError("blend: opaque needs draw: sphere or picture")
        if self.light is not None and self.blend != "alpha":
            raise UsageError("a light needs blend: alpha")
        if self.trail is not None and self.blend != "add":
            raise UsageError("a trail needs blend: add")
        if self.ribbon is not None and self.draw != "streak":
            raise UsageError("a ribbon needs draw: streak")
        if self.ribbon is not None and self.trail is not None:
            raise UsageError("give a ribbon or a trail")
        return self
