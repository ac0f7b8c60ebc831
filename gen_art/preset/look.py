"""How a system is drawn: `look:`. Frozen pydantic models; attribute names are the YAML keys."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.fields import ColourValue, CurveValue, GradientValue, Number, RangeValue, Vector
from gen_art.preset.files import ImageFile
from gen_art.preset.types import Model, Words
from gen_art.preset.values import Curve, Range, number

__all__ = ["BY", "Color", "Emission", "KeyLight", "Look", "Picture", "Ramp", "Ribbon", "Trail"]

BY = (
    "age", "seconds", "speed", "energy", "charge", "mass", "radius", "id", "random", "distance", "x", "y", "z",
    "acceleration",
)  # fmt: skip


class Ramp(Model):
    """A number that may follow a quantity of the particle: `3`, `[[0, 1], [1, 0]]` (by age) or a mapping.

    by: `age` is the fraction of the lifetime, 0 at birth and 1 at death; `seconds` the age in simulated seconds; `speed`
    m/s; `energy` the kinetic energy in J; `random` a number in 0..1 that is the particle's own; `distance` from the
    origin in m; `x`, `y`, `z`; `acceleration` m/s^2, over the last time step; or a declared attribute such as `temperature`.
    `range: lo..hi` maps the quantity to 0..1 before the curve is read.
    """

    by: str = "age"
    range: RangeValue | None = None
    curve: CurveValue = Curve(((0.0, 1.0),))

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
    """Colours by a quantity: a colour, a palette, or `{by: age, gradient: [white, crimson]}`; other keys are tags of
    emitters with gradients of their own: `{by: age, clean: [white, crimson], tail: [gold, teal]}`.

    `range: lo..hi` says which values of the quantity are the two ends (needed for all but age and random).
    """

    model_config = ConfigDict(frozen=True, extra="allow", arbitrary_types_allowed=True)
    __pydantic_extra__: dict[str, GradientValue]

    by: str = "age"
    range: RangeValue | None = None
    gradient: GradientValue = Gradient(((0.0, "white"),))

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
    """Light a particle gives off. For discs and streaks `intensity` is the brightness at the middle of the sprite;
    a point has the area of one pixel of a picture 720 rows high.

    blackbody: kelvin, or a curve of kelvin over age (or over `by: seconds`). planck: how much of Planck's fall of
    brightness towards lower temperatures to keep, relative to the hottest (0 none, 1 all). strobe: lo..hi in Hz, a
    rate and phase drawn per particle; it is lit for `duty` of each period.
    """

    color: Color | None = None
    intensity: Ramp = Ramp()
    blackbody: Ramp | None = None
    planck: Annotated[Number, Field(ge=0, le=1)] = 0.3
    strobe: RangeValue | None = None
    duty: Annotated[Number, Field(gt=0, le=1)] = 0.35

    short_form = {"type": ["string", "array"], "description": "a colour, a palette or a gradient"}

    @classmethod
    def from_short(cls, value):
        if isinstance(value, (str, list, tuple)):
            return {"color": value}
        return value


class KeyLight(Model):
    """A distant lamp that shines on smoke through the smoke itself, the sky around it and the glow of other systems.

    direction: the way the lamp's light travels. phase: -1 back to 1 forward scattering (Henyey-Greenstein), 0 even.
    scatter: the part of the light that has been scattered once before; its depth counts half, and so on for that part
    of it. ambient: the sky, from all sides; ground: what comes from below (the sky's colour unless given). depth scales
    the optical depth that this system casts into all light. resolution: cells along the longest side of the density grid.
    glow: systems whose own light shines on this one; glow_intensity 1 is as bright as they are; glow_softness (world
    units) widens their light near them. All systems with a light stand in each other's shadow.
    """

    direction: Vector = (-1.0, -1.0, -0.5)
    color: ColourValue = "white"
    intensity: Annotated[Number, Field(ge=0)] = 3.0
    ambient: ColourValue = "white"
    ground: ColourValue | None = None
    ambient_intensity: Annotated[Number, Field(ge=0)] = 0.08
    phase: Annotated[Number, Field(gt=-1, lt=1)] = 0.0
    scatter: Annotated[Number, Field(ge=0, le=1)] = 0.2
    depth: Annotated[Number, Field(ge=0)] = 1.0
    resolution: Annotated[int, Field(ge=8, le=256)] = 96
    glow: Words = ()
    glow_intensity: Annotated[Number, Field(ge=0)] = 1.0
    glow_softness: Annotated[Number, Field(ge=0)] = 0.0

    @model_validator(mode="after")
    def _pointing(self):
        if not any(self.direction):
            raise UsageError("a light's direction must not be [0, 0, 0]")
        return self


class Trail(Model):
    """The film keeps what the system drew and lets it fade: to one half in `half_life` film seconds, whatever the fps.

    The particles themselves are drawn over it as ever. strength: the trail's brightness; a particle at rest builds up
    a trail as bright as itself at 1. substeps: how many times the system is drawn between two frames (the largest
    divisor of a frame's steps up to it), so that fast curves stay smooth. Trails start 16
    half-lives before frame 0, or with the simulation.
    """

    half_life: Annotated[Number, Field(gt=0)]
    strength: Annotated[Number, Field(ge=0)] = 1.0
    substeps: Annotated[int, Field(ge=1, le=64)] = 1

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Trail, dict)) else {"half_life": value}


class Ribbon(Model):
    """Each particle draws its path of the last `length` simulated seconds through `points` remembered positions.

    Needs `draw: streak`, whose width it begins with. taper, tail: width and brightness at the old end, relative to the
    particle's. `intensity` of the emission is a ribbon's brightness along its middle, whatever the particle's speed.
    """

    length: Annotated[Number, Field(gt=0)]
    points: Annotated[int, Field(ge=2, le=256)] = 16
    taper: Annotated[Number, Field(ge=0, le=1)] = 0.0
    tail: Annotated[Number, Field(ge=0, le=1)] = 0.0

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Ribbon, dict)) else {"length": value}


class Picture(Model):
    """A picture for every particle, `radius` from its middle to its sides; white paint on transparent ground takes the
    particle's colour. It lies in the preset's folder.

    turn: degrees, counter-clockwise; `random` turns each its own way. spin: degrees a simulated second, or lo..hi.
    """

    image: Annotated[str, ImageFile]
    turn: Literal["random"] | Number = 0.0
    spin: RangeValue = Range(0.0, 0.0)

    short_form = {"type": "string", "description": "the picture's file"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Picture, dict)) else {"image": value}


class Look(Model):
    """How a system's particles are drawn.

    draw: `point` (a bilinear dot), `disc` (a soft Gaussian sprite; its radius is 2.2 standard deviations), `streak`
    (the path of the last `length` seconds, by default the time the shutter is open), `sphere` (an even disc with a sharp
    rim) or `picture` (an image of its own, see `picture`). radius, width: world units; without them the particle's own
    radius. pixels: the size in pixels of a picture 720 rows high instead. size multiplies either. blend `add` is light,
    `alpha` also hides what is behind it, `opaque` hides all of it.
    opacity: optical depth at a sprite's middle; with `reference` (m) it is that of a sprite of that radius and falls
    as (reference / r)^2, so that a growing sprite keeps its extinction cross section. tail, taper: a streak's
    brightness and width at its old end, relative to its head. falloff: `inverse_square` dims points as 1/d^2, with 1
    at the camera's target.
    """

    draw: Literal["point", "disc", "streak", "sphere", "picture"] = "point"
    picture: Picture | None = None
    blend: Literal["add", "alpha", "opaque"] = "add"
    radius: Annotated[Number, Field(gt=0)] | None = None
    width: Annotated[Number, Field(gt=0)] | None = None
    pixels: Annotated[Number, Field(gt=0, le=4096)] | None = None
    size: Ramp = Ramp()
    length: Annotated[Number, Field(ge=0)] | None = None
    tail: Annotated[Number, Field(ge=0, le=1)] = 1.0
    taper: Annotated[Number, Field(ge=0, le=1)] = 1.0
    emission: Emission | None = None
    opacity: Ramp = Ramp()
    reference: Annotated[Number, Field(gt=0)] | None = None
    albedo: Color = Color.model_validate({})
    light: KeyLight | None = None
    falloff: Literal["none", "inverse_square"] = "none"
    trail: Trail | None = None
    ribbon: Ribbon | None = None

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
