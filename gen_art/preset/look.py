"""The keys of `look:`, which say how a system is drawn. Frozen pydantic models; attribute names are the YAML keys."""

from collections.abc import Collection
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, model_validator

from gen_art.errors import UsageError
from gen_art.font import missing
from gen_art.particles.entries import DISSIPATED, LedgerEntry
from gen_art.preset.colour_names import Gradient
from gen_art.preset.disc_shape import Spread, Stretch
from gen_art.preset.fields import (
    MOST_LIGHT,
    MOST_SIZE,
    Brightness,
    ColourValue,
    CurveValue,
    Fraction,
    GradientValue,
    NotNegative,
    Number,
    Parsed,
    Positive,
    RangeValue,
    Size,
    Within,
    Words,
)
from gen_art.preset.files import ImageFile, PresetFile
from gen_art.preset.light import Light
from gen_art.preset.liquid import Liquid
from gen_art.preset.model import Model, about
from gen_art.preset.surface import Finish
from gen_art.preset.values import Curve, Range, number, shown
from gen_art.registry import Bounds

__all__ = [
    "BY", "CORNERS", "Color", "Emission", "Flashes", "Legend", "Look", "Picture", "Ramp", "Ribbon", "Trail", "ledger_entry",
]  # fmt: skip

BY = (
    "age", "seconds", "speed", "energy", "charge", "mass", "radius", "id", "random", "distance", "x", "y", "z",
    "acceleration",
)  # fmt: skip
CORNERS = ("top left", "top right", "bottom left", "bottom right")


def _by(value):
    """The name of a quantity, or an entry of the ledger from its mapping."""
    if isinstance(value, (str, LedgerEntry)):
        return value
    if not isinstance(value, dict):
        raise UsageError(
            f"must be the name of a quantity, such as speed, or {{work: FORCE}} or {{dissipated: FORCE}}, not {shown(value)}"
        )
    return LedgerEntry.of(value)


_BY_SCHEMA = {
    "anyOf": [
        {"type": "string", "examples": [*BY, DISSIPATED.plain]},
        *(
            {
                "type": "object",
                "required": [kind],
                "additionalProperties": False,
                "properties": {kind: {"type": "string", "description": f"name of a force: {meaning} in J"}},
            }
            for kind, meaning in (
                ("work", "the work that it has done on the particle"),
                ("dissipated", "what it has taken out of the particle's mechanical energy"),
            )
        ),
    ]
}
Quantity = Annotated[Any, Parsed(_by, _BY_SCHEMA, lambda by: by.plain if isinstance(by, LedgerEntry) else by)]


def ledger_entry(by: "str | LedgerEntry") -> LedgerEntry | None:
    """The entry of the ledger that a `by` names, or None."""
    if isinstance(by, LedgerEntry):
        return by
    return DISSIPATED if by == DISSIPATED.plain else None


class Ramp(Model):
    """A number that may depend on a quantity of the particle: `3`, `[[0, 1], [1, 0]]` (by age) or a mapping.

    Quantities: `age` is the fraction of the lifetime, 0 at birth and 1 at death; `seconds` the age in simulated seconds;
    `speed` in m/s; `acceleration` in m/s^2, over the last time step; `energy` the kinetic energy in J; `charge` in C;
    `distance` from the origin in m; `x`, `y`, `z`; `random` a number in 0..1 that is fixed for each particle; a declared
    attribute such as `temperature`; or joules that the ledger books, since the particle's birth: `{work: drag}`,
    `{dissipated: drag}`, or `dissipated` by all forces on the system together.
    """

    by: Quantity = about("age", "the quantity on which the number depends")
    range: RangeValue | None = about(None, "the values of the quantity at 0 and at 1 of the curve")
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


def _within(most: float):
    """A check of a Ramp: no value of its curve beyond -most..most."""

    def check(ramp: Ramp) -> Ramp:
        Bounds(-most, most).check(ramp.curve.maximum)
        Bounds(-most, most).check(ramp.curve.minimum)
        return ramp

    return check


class Color(Model):
    """A colour that may depend on a quantity: a colour, a palette, or `{by: age, gradient: [white, crimson]}`.

    Further keys are tags of emitters with their gradients: `{by: age, clean: [white, crimson], tail: [gold, teal]}`.
    """

    model_config = ConfigDict(frozen=True, extra="allow", arbitrary_types_allowed=True)
    __pydantic_extra__: dict[str, GradientValue]

    by: Quantity = about("age", "the quantity on which the colour depends, as for numbers")
    range: RangeValue | None = about(None, "the values of the quantity at the two ends of the gradient")
    gradient: GradientValue = about(Gradient(((0.0, "white"),)), "a colour, a palette, or a list of colours")

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
    """The light that a particle emits.

    For discs and streaks `intensity` is the brightness at the middle of the sprite; a point has the area of one pixel of a
    picture that is 720 pixels high.
    """

    color: Color | None = about(None, "colour of the light; white when left out")
    intensity: Annotated[Ramp, AfterValidator(_within(MOST_LIGHT))] = about(Ramp(), "brightness of the light")
    blackbody: Ramp | None = about(
        None, "temperature, or a curve of it over age (or `by: seconds`), that sets the colour of the light", unit="K"
    )
    planck: Fraction = about(
        0.3,
        "how much darker lower temperatures are, relative to the hottest: 0 equally bright, 1 as in Planck's law",
    )
    strobe: RangeValue | None = about(None, "flash rate; a rate and a phase are drawn for each particle", unit="Hz")
    duty: Annotated[float, Within(0, 1, open_low=True)] = about(
        0.35, "the part of each period of the strobe in which the particle is lit"
    )

    short_form = {"type": ["string", "array"], "description": "a colour, a palette or a gradient"}

    @classmethod
    def from_short(cls, value):
        if isinstance(value, (str, list, tuple)):
            return {"color": value}
        return value


class Trail(Model):
    """What the system drew stays in the picture and fades, at the same speed for any fps; the particles are drawn over it.

    A number sets the `half_life`. Trails start 16 half-lives before frame 0, or at the start of the simulation.
    """

    half_life: Positive = about(..., "film time in which the trail fades to one half", unit="s")
    strength: Brightness = about(
        1.0, "brightness of the trail; at 1 the trail of a particle at rest becomes as bright as the particle"
    )
    substeps: Annotated[int, Field(ge=1, le=64)] = about(
        1,
        "how many times a frame the system is added to the trail, so that fast curves stay smooth; the number used is the "
        "largest divisor of a frame's steps that is not above this",
    )

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Trail, dict)) else {"half_life": value}


class Ribbon(Model):
    """Draws the past path of each particle. Needs `draw: streak`, which sets the width at the particle.

    A number sets the `length`. The emission's `intensity` is the brightness along the middle, at any speed of the particle.
    """

    length: Positive = about(..., "length of the path, in simulated time", unit="s")
    points: Annotated[int, Field(ge=2, le=256)] = about(16, "number of past positions that are stored")
    taper: Fraction = about(0.0, "width at the old end, relative to that at the particle")
    tail: Fraction = about(0.0, "brightness at the old end, relative to that at the particle")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Ribbon, dict)) else {"length": value}


class Flashes(Model):
    """Balls, bodies and threads stay in the picture as they were at earlier moments, as in a photograph by flashes.

    A number sets `every`. Flashes come at every multiple of that time from the start of the film; what they leave stands still,
    casts shadows and hides what is behind it. What it emits does not light other things.
    """

    every: Positive = about(..., "simulated time from one flash to the next, rounded to whole steps", unit="s")
    number: Annotated[int, Field(ge=1, le=64)] = about(
        8, "number of flashes that stay, the last ones before the picture"
    )
    opacity: Fraction = about(
        1.0,
        "opacity of what the last flash left; below 1 the picture is drawn with it and without it, and both are averaged by "
        "weight",
    )
    tail: Fraction = about(
        1.0,
        "opacity of what the oldest flash left, relative to `opacity`; between them it falls evenly, and each different opacity "
        "takes one more drawing",
    )

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Flashes, dict)) else {"every": value}

    @property
    def fades(self) -> bool:
        """Whether the picture is the mean of several."""
        return self.opacity < 1.0 or (self.tail < 1.0 and self.number > 1)


class Picture(Model):
    """An image for every particle, `radius` from its middle to its sides; its colours are multiplied by the particle's."""

    image: Annotated[PresetFile, ImageFile] = about(..., "image file in the preset's folder, with transparency")
    turn: Literal["random"] | Number = about(
        0.0, "rotation, counter-clockwise; `random` draws one for each particle", unit="degrees"
    )
    spin: RangeValue = about(
        Range(0.0, 0.0), "rotation per simulated second, drawn for each particle", unit="degrees/s"
    )
    upright: bool = about(
        False,
        "start with the image's top towards the scene's up (+y), however the camera is rolled; else towards the camera's up",
    )

    short_form = {"type": "string", "description": "the picture's file"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Picture, dict)) else {"image": value}


LONGEST_LABEL = 60


def _label(value) -> str:
    """The words of a legend, in characters that the font has."""
    if not isinstance(value, str) or not value.strip():
        raise UsageError(f"must be text, not {shown(value)}")
    if len(value) > LONGEST_LABEL or missing(value) or "\n" in value:
        raise UsageError(
            f"must be at most {LONGEST_LABEL} characters of those that the font has, Latin, Greek and mathematical ones, not "
            f"{shown(value)}"
        )
    return value


class Legend(Model):
    """A legend in the finished picture: the colours with the joules at their ends, and the ledger's total at that time.

    `true` places it at the bottom left. It needs a colour or a number that goes by joules; the first one is shown.
    """

    place: Literal["top left", "top right", "bottom left", "bottom right"] = about(
        "bottom left", "the corner of the picture"
    )
    label: Annotated[str, Parsed(_label, {"type": "string", "maxLength": LONGEST_LABEL})] | None = about(
        None, "words before the total; the entry's own, such as `work of drag`, when left out"
    )

    short_form = {"enum": [True, False, *CORNERS], "description": "true, or a corner; false for none"}

    @classmethod
    def from_short(cls, value):
        if value is True:
            return {}
        return {"place": value} if isinstance(value, str) else value


def _legend(value):
    return None if value is False else value


class Look(Model):
    """How a system's particles are drawn. All sizes scale with the picture's height."""

    draw: Literal["point", "pixel", "disc", "streak", "sphere", "picture", "body", "thread", "cloth", "surface"] = (
        about(
            "point",
            "`point` is a dot placed between pixels, `pixel` lights only the pixel that it falls in, `disc` is a soft Gaussian "
            "sprite whose radius is 2.2 standard deviations, `streak` the path of the last `length` seconds, `sphere` an even "
            "disc with a sharp rim, or a ball where it is opaque in the preset's `light`, `picture` an image, `body` the shapes "
            "of rigid bodies, `thread` the springs between particles as rods, `cloth` a cloth as a smooth sheet with two sides, "
            "`surface` the smooth surface of a liquid",
        )
    )
    tag: Words = about(
        (), "only the particles of emitters (or choices) with one of these tags; all of them when left out"
    )
    picture: Picture | None = about(None, "the image of `draw: picture`")
    blend: Literal["add", "alpha", "opaque"] = about(
        "add", "`add` adds light, `alpha` partly hides what is behind the sprite, `opaque` hides it completely"
    )
    radius: Size | None = about(None, "radius of the sprite in world units; the particle's radius when left out")
    width: Size | None = about(None, "width of a streak in world units, two radii")
    pixels: Annotated[float, Within(0, 4096, open_low=True)] | None = about(
        None, "radius in pixels of a picture that is 720 pixels high, instead of `radius`"
    )
    size: Annotated[Ramp, AfterValidator(_within(MOST_SIZE))] = about(Ramp(), "a factor on radius, width or pixels")
    length: NotNegative | None = about(
        None, "length of a streak in simulated time; the time that the shutter is open when left out", unit="s"
    )
    tail: Fraction = about(1.0, "brightness of a streak at its old end, relative to its head")
    taper: Fraction = about(1.0, "width of a streak at its old end, relative to its head")
    emission: Emission | None = about(
        None,
        "the light that a particle emits; when left out, white of intensity 1 with `blend: add`, and none otherwise",
    )
    opacity: Annotated[Ramp, AfterValidator(_within(MOST_LIGHT))] = about(
        Ramp(), "optical depth at the middle of a sprite"
    )
    reference: Size | None = about(
        None,
        "the radius at which the optical depth is `opacity`: the depth falls as (reference / r)^2, so that a growing sprite "
        "keeps its extinction cross section",
        unit="m",
    )
    albedo: Color = about(Color.model_validate({}), "the part of the light that is scattered, by colour")
    light: Light | None = about(None, "the light on smoke; the preset's `light` when left out")
    finish: Finish = about(
        Finish.model_validate({}),
        "how balls, bodies, threads and cloth reflect; balls are `draw: sphere` with `blend: opaque` in the preset's `light`. Of "
        "a clear liquid, what it leaves out is water's: roughness 0, ior 1.33",
    )
    back: ColourValue | None = about(
        None, "with `draw: cloth`, the albedo of the side that is not seen with column 0 on the left; both sides have the "
        "`albedo` when left out"
    )  # fmt: skip
    edge: NotNegative = about(
        0.0,
        "with `draw: body`, the radius to which edges of boxes are rounded; the bodies themselves keep sharp ones",
        unit="m",
    )
    strands: Literal[0, 2, 3, 4] = about(
        0, "with `draw: thread`, the strands of which ropes are laid; 0 for smooth rods"
    )
    translucency: Fraction = about(
        0.0, "with `draw: cloth`, the part of the scattered light that leaves on the other side: 0.3 is thin cotton"
    )
    liquid: Liquid = about(Liquid.model_validate({}), "what light does inside the surface of `draw: surface`")
    mirrored: bool = about(True, "whether a ground or plane with `mirror: true` shows the system")
    falloff: Literal["none", "inverse_square"] = about(
        "none", "`inverse_square` dims points as 1/d^2, with a factor of 1 at the camera's target"
    )
    side: Literal["near", "far", "through"] = about(
        "near",
        "with `wormhole`, the side on which the particles are: this one, the other one, or `through` for particles that go "
        "through the disc, which are on the other side where they are behind it",
    )
    stretch: Stretch | None = about(
        None, "soft discs become ellipsoids: wisps along the flow, or threads and sheets of neighbours"
    )
    spread: Spread | None = about(None, "soft discs far from others become wide and thin: haze in place of stray beads")
    trail: Trail | None = about(None, "an afterglow that fades")
    ribbon: Ribbon | None = about(None, "the past path of each particle")
    flashes: Flashes | None = about(None, "balls, bodies and threads as they were at earlier moments, too")
    legend: Annotated[Legend | None, BeforeValidator(_legend)] = about(
        None, "a legend of the joules that a colour or number goes by"
    )

    @property
    def shapes(self) -> bool:
        """Whether the shapes of bodies, threads or cloth are drawn instead of the particles."""
        return self.draw in ("body", "thread", "cloth")

    @property
    def is_liquid(self) -> bool:
        """Whether the particles are drawn together as the surface of a liquid."""
        return self.draw == "surface"

    @property
    def liquid_finish(self) -> Finish:
        """How the surface of the liquid reflects."""
        if not self.liquid.clear:
            return self.finish
        return Finish(**{"roughness": 0.0, "ior": 1.33, **self.finish.model_dump(exclude_unset=True)})

    def ramps(self) -> "dict[tuple[str, ...], Ramp | Color]":
        """The numbers and colours that may depend on a quantity, by their keys: first those that a legend shows first."""
        light = self.emission
        ramps: dict[tuple[str, ...], Ramp | Color | None] = {}
        if light is not None:
            ramps = {("emission", key): getattr(light, key) for key in ("color", "blackbody", "intensity")}
        ramps |= {("albedo",): self.albedo, ("opacity",): self.opacity, ("size",): self.size}
        return {path: ramp for path, ramp in ramps.items() if ramp is not None}

    def goes_by(self, quantity: str) -> bool:
        """Whether any number or colour depends on this quantity."""
        return any(ramp.by == quantity for ramp in self.ramps().values())

    def ledger_ramps(
        self, attributes: Collection[str] = ()
    ) -> "dict[tuple[str, ...], tuple[LedgerEntry, Ramp | Color]]":
        """The numbers and colours that go by joules of the ledger: (entry, ramp) by their keys.

        attributes : names that the particles declare; one called `dissipated` is not the ledger's
        """
        found = {
            path: (ledger_entry(ramp.by), ramp) for path, ramp in self.ramps().items() if ramp.by not in attributes
        }
        return {path: (entry, ramp) for path, (entry, ramp) in found.items() if entry is not None}

    def ledger_entries(self, attributes: Collection[str] = ()) -> tuple[LedgerEntry, ...]:
        """The entries of the ledger that numbers and colours go by."""
        return tuple(dict.fromkeys(entry for entry, _ in self.ledger_ramps(attributes).values()))

    @model_validator(mode="after")
    def _consistent(self):
        if sum(v is not None for v in (self.radius, self.width, self.pixels)) > 1:
            raise UsageError("give one of radius, width and pixels")
        if self.draw == "pixel" and self.pixels is not None:
            raise UsageError("draw: pixel has no size: leave out `pixels`, or give draw: disc")
        if (self.draw == "picture") != (self.picture is not None):
            raise UsageError("`draw: picture` and `picture: spark.png` need each other")
        if self.shapes and self.tag:
            raise UsageError(f"draw: {self.draw} shows what all particles are joined to: leave out `tag`")
        if (self.shapes or self.is_liquid) and self.blend != "add":
            raise UsageError(f"draw: {self.draw} hides what is behind it: leave out `blend`")
        if self.liquid != Liquid.model_validate({}) and not self.is_liquid:
            raise UsageError("`liquid` is of a surface: give draw: surface, or leave it out")
        if self.is_liquid and self.liquid.clear and self.finish.metal > 0.0:
            raise UsageError("a metal lets no light through: give liquid: {clear: false}, or leave out `metal`")
        if self.is_liquid and self.finish.transmission > 0.0:
            raise UsageError("what goes through a liquid stands in `liquid`: leave out `transmission`")
        if (self.shapes or self.is_liquid) and (self.trail is not None or self.light is not None):
            raise UsageError(f"draw: {self.draw} has no {'trail' if self.trail else 'light of its own'}: leave it out")
        ball = self.draw == "sphere" and self.blend == "opaque"
        if self.finish.image is not None and not ball and self.draw not in ("body", "cloth"):
            raise UsageError("`finish.image` needs draw: body, draw: cloth, or draw: sphere with blend: opaque")
        of_bodies = {"edge": self.edge > 0.0}
        if self.finish.image is not None:
            of_bodies["finish.image.shifted"] = self.finish.image.shifted
            of_bodies["finish.image.ends"] = self.finish.image.ends is not None
        for name, wanted in of_bodies.items():
            if wanted and self.draw != "body":
                raise UsageError(f"`{name}` needs draw: body")
        if self.strands and self.draw != "thread":
            raise UsageError("`strands` needs draw: thread")
        if self.draw == "cloth":
            fields = type(self).model_fields
            sizes = ("length", "pixels", "radius", "size", "tail", "taper", "width")
            given = [key for key in sizes if getattr(self, key) != fields[key].default]
            if given:
                raise UsageError(f"draw: cloth is a sheet without thickness: leave out `{given[0]}`")
            if self.finish.transmission > 0.0:
                raise UsageError(
                    "draw: cloth has no inside for light to go through: give `translucency` in place of `transmission`"
                )
        elif self.back is not None or self.translucency > 0.0:
            raise UsageError(f"`{'back' if self.back is not None else 'translucency'}` needs draw: cloth")
        if self.blend == "alpha" and self.draw not in ("disc", "sphere", "picture"):
            raise UsageError("blend: alpha needs draw: disc, sphere or picture")
        for key in ("stretch", "spread"):
            if getattr(self, key) is not None and self.draw != "disc":
                raise UsageError(f"{key} needs draw: disc")
        if self.blend == "opaque" and self.draw not in ("sphere", "picture"):
            raise UsageError("blend: opaque needs draw: sphere or picture")
        if self.light is not None and self.blend != "alpha":
            raise UsageError("a light needs blend: alpha")
        if self.trail is not None and self.blend != "add":
            raise UsageError("a trail needs blend: add")
        if self.flashes is not None and not ball and self.draw not in ("body", "thread"):
            raise UsageError("flashes need draw: body, draw: thread, or draw: sphere with blend: opaque")
        if self.ribbon is not None and self.draw != "streak":
            raise UsageError("a ribbon needs draw: streak")
        if self.ribbon is not None and self.trail is not None:
            raise UsageError("give a ribbon or a trail")
        if self.legend is not None and not self.ledger_ramps():
            raise UsageError(
                "a legend shows joules of the ledger: let a colour or a number go `by: {work: FORCE}`, `by: {dissipated: FORCE}` "
                "or `by: dissipated`"
            )
        return self
