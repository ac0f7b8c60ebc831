"""The keys of `sky:`, what surrounds the scene: an atmosphere, a gradient or an even colour, stars and softboxes."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.colour_names import COLOURS, Gradient
from gen_art.preset.fields import Brightness, ColourValue, GradientValue, NotNegative, Vector, Within
from gen_art.preset.model import Model, about
from gen_art.preset.palettes import palette
from gen_art.preset.values import shown
from gen_art.registry import suggest

__all__ = ["SHORT_NAMES", "Band", "Sky", "Softbox", "Stars", "Sun"]

# what the short names stand for. The studio has a lit floor that runs into its wall, and soft light from above
SHORT_NAMES: dict[str, dict] = {
    "studio": {
        "gradient": [
            [0.0, "#8f8e8c"], [0.35, "#b4b3b1"], [0.47, "#cbcac9"], [0.53, "#d2d2d1"], [0.7, "#e6e6e7"], [1.0, "#ffffff"],
        ]
    },
    "paper": {"color": "#f6f3ec"},
    "night": {"stars": True},
}  # fmt: skip


class Sun(Model):
    """The sun in the atmosphere; a number sets the `height`."""

    height: Annotated[float, Within(-6, 90)] = about(
        ..., "height of its middle above the horizon; below 0 it is twilight", unit="degrees"
    )
    azimuth: Annotated[float, Within(-360, 360)] = about(
        0.0, "direction, clockwise seen from above: 0 is -z, where a new camera looks, 90 is +x", unit="degrees"
    )
    disc: Brightness = about(1.0, "factor on the light of the disc that is drawn; 0 hides it")

    short_form = {"type": ["number", "string"], "description": "the height"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Sun, dict)) else {"height": value}


class Stars(Model):
    """Stars at random places, as many and as bright as those of the real sky; a number sets the `magnitude`.

    `true` shows those that the naked eye sees. The number of stars brighter than magnitude m is 5.1 * 10^(m / 2).
    """

    magnitude: Annotated[float, Within(0, 9)] = about(
        6.5, "the magnitude of the faintest stars: 6.5 shows 9,000, one more shows three times as many"
    )
    intensity: Brightness = about(
        1.0,
        "factor on their light; at 1 a star of magnitude 0 has the light of a disc of light 1 and 0.1 degrees radius",
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] = about(0, "another seed gives another sky")

    short_form = {"type": ["boolean", "number", "string"], "description": "true, or the magnitude; false for none"}

    @classmethod
    def from_short(cls, value):
        if value is True:
            return {}
        return value if isinstance(value, (Stars, dict)) else {"magnitude": value}


class Band(Model):
    """The band of stars too far to be seen singly, with dark clouds of dust before it; a number sets the `intensity`."""

    intensity: Brightness = about(1.0, "factor on its light; at 1 its brightest places have about the light 1")
    color: Annotated[GradientValue, BeforeValidator(lambda value: _several_colours(value))] = about(
        Gradient.of(["#1b2a4a", "#6f86b8", "#e8dcc8", "#fff2dc"]), "colours from its dark rims to its brightest places"
    )
    width: Annotated[float, Within(0.5, 60)] = about(8.0, "standard deviation of its height", unit="degrees")
    normal: Vector = about((0.0, 1.0, 0.0), "direction across its plane")
    core: Vector = about((0.0, 0.0, -1.0), "direction of its middle, where it is brightest and thickest")
    dust: NotNegative = about(1.0, "amount of the dust that darkens it; 0 has none")
    seed: Annotated[int, Field(ge=0, lt=2**63)] = about(0, "another seed gives other clouds")

    short_form = {"type": ["boolean", "number", "string"], "description": "true, or the intensity; false for none"}

    @classmethod
    def from_short(cls, value):
        if value is True:
            return {}
        return value if isinstance(value, (Band, dict)) else {"intensity": value}

    @model_validator(mode="after")
    def _consistent(self):
        a, b = self.normal, self.core
        across = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        if not any(across):
            raise UsageError("a band's `core` lies in its plane: give it another direction than `normal`")
        return self


class Softbox(Model):
    """A rectangle of even light far away, as the softboxes of a photographer's studio: metal and gloss have it to reflect.

    It lights what stands in the scene as the rest of the sky does, evenly from its side, and throws no shadow of its own.
    A camera that looks towards it sees it.
    """

    height: Annotated[float, Within(-90, 90)] = about(..., "of its middle above the horizon", unit="degrees")
    azimuth: Annotated[float, Within(-360, 360)] = about(
        0.0, "direction of its middle, clockwise seen from above: 0 is -z, where a new camera looks, 90 is +x",
        unit="degrees",
    )  # fmt: skip
    width: Annotated[float, Within(1, 160)] = about(30.0, "angle that it is wide", unit="degrees")
    tall: Annotated[float, Within(1, 160)] = about(30.0, "angle that it is tall", unit="degrees")
    edge: Annotated[float, Within(0, 60)] = about(
        3.0, "angle over which its light fades at each side, half of it outside", unit="degrees"
    )
    color: ColourValue = about("white", "of its light")
    intensity: Brightness = about(2.0, "light of its middle")


def _stars(value):
    return None if value is False else value


def _several(gradient: Gradient) -> Gradient:
    if len(gradient.stops) < 2:
        raise UsageError("a sky's gradient needs two colours or more; `color` makes an even sky")
    return gradient


def _several_colours(value):
    return value if value is None else _several(Gradient.of(value))


class Sky(Model):
    """What surrounds the scene, in linear light: it lies behind everything, and exposure and tone map act on it.

    One of `sun`, `gradient` and `color`, or `stars`, a `band` and `softboxes` alone before black. `studio` and `paper` are names
    of even, soft surroundings, `night` of stars before black; a colour stands for `color`, a palette or a list of colours for
    `gradient`.
    """

    sun: Sun | None = about(None, "the air, lit by the sun")
    gradient: Annotated[GradientValue, BeforeValidator(_several_colours)] | None = about(
        None, "colours from straight down (0) over the horizon (0.5) to straight up (1), by the angle"
    )
    color: ColourValue | None = about(None, "one colour in every direction")
    stars: Annotated[Stars | None, BeforeValidator(_stars)] = about(None, "stars, behind the air")
    band: Annotated[Band | None, BeforeValidator(_stars)] = about(
        None, "a band of distant stars like the Milky Way, behind the air"
    )
    softboxes: tuple[Softbox, ...] = about((), "rectangles of light before all of this")
    haze: Annotated[float, Within(0, 30)] = about(
        1.0, "for `sun`: amount of dust and droplets in the air; 0 is pure air, 1 a clear day, 10 a hazy one"
    )
    ground: ColourValue = about("#77746e", "for `sun`: the part of the light that the ground scatters, by colour")
    intensity: Brightness = about(
        1.0, "factor on all of this light; at 1 the sun in the zenith and its sky light a white floor with light 1"
    )

    short_form = {
        "type": ["string", "array"],
        "description": "studio, paper, night, a colour, a palette or a list of colours from straight down to straight up",
    }

    @classmethod
    def from_short(cls, value: Any) -> Any:
        """The mapping that a name, a colour, a palette or a list of colours stands for. Raises UsageError for another name."""
        if isinstance(value, str):
            if value.strip() in SHORT_NAMES:
                return SHORT_NAMES[value.strip()]
            if value.strip()[:1] != "#" and value.strip().lower() not in COLOURS and palette(value) is None:
                near = suggest(value, [*SHORT_NAMES, *COLOURS])
                names = ", ".join(SHORT_NAMES)
                raise UsageError(f"no sky named {shown(value)}{near or f'; write {names}, a colour or a palette'}")
        if isinstance(value, (str, list, tuple)):
            gradient = Gradient.of(value)
            return {"color": gradient.stops[0][1]} if len(gradient.stops) == 1 else {"gradient": gradient}
        return value

    @model_validator(mode="after")
    def _consistent(self):
        given = [name for name in ("sun", "gradient", "color") if getattr(self, name) is not None]
        if len(given) > 1:
            raise UsageError(f"give one of sun, gradient and color, not {' and '.join(given)}")
        if not (given or self.stars or self.band or self.softboxes):
            raise UsageError(
                "needs one of sun, gradient, color, stars, band and softboxes, or is a name such as studio"
            )
        if self.sun is None:
            for name in ("haze", "ground"):
                if name in self.model_fields_set:
                    raise UsageError(f"`{name}` is of the air that a `sun` lights: give `sun`, or leave it out")
        return self
