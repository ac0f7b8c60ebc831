"""The keys of `light:`: a distant lamp and the sky, which light smoke, balls, colliders and the ground."""

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import MOST_SIZE, Brightness, ColourValue, Fraction, NotNegative, Vector, Within, Words
from gen_art.preset.model import Model, about
from gen_art.preset.values import number, shown

__all__ = ["Light"]


class Light(Model):
    """The light: a distant lamp, which things shadow, the sky, and the light of other systems.

    At the top level of a preset it lights everything that reflects light; in a look it lights that system alone. A particle of
    smoke and a white surface that face a lamp of brightness 1 have the radiance 1 and 4: the lamp's irradiance is 4 pi, and
    smoke scatters it to all sides, a surface to one side only.
    """

    direction: Vector = about((-1.0, -1.0, -0.5), "direction in which the lamp's light travels")
    size: Annotated[float, Within(0, 90, open_low=True)] = about(
        0.53,
        "diameter of the lamp as things see it, which makes the edges of shadows soft: the sun has 0.53",
        unit="degrees",
    )
    color: ColourValue = about("white", "colour of the lamp")
    intensity: Brightness = about(3.0, "brightness of the lamp")
    ambient: ColourValue = about("white", "colour of the sky, which shines from all sides")
    ground: ColourValue | None = about(None, "colour of the light from below; the sky's when left out")
    ambient_intensity: Brightness = about(0.08, "brightness of the sky")
    phase: Annotated[float, Within(-1, 1, open_low=True, open_high=True)] = about(
        0.0, "Henyey-Greenstein's g of smoke: -1 is backward scattering, 0 isotropic, 1 forward scattering"
    )
    scatter: Fraction | Literal["full"] | None = about(
        None,
        "`full` follows light through smoke until it leaves it, however often it is scattered; a number is the part of its "
        "light that was already scattered once, which half the optical depth attenuates. When left out, `full` in the preset's "
        "light and 0.2 in the light of a look",
    )
    depth: NotNegative = about(1.0, "factor on the optical depth with which smoke shadows light")
    resolution: Annotated[int, Field(ge=8, le=256)] = about(96, "cells along the longest side of smoke's density grid")
    glow: Words = about((), "systems whose emission lights this one")
    glow_intensity: Brightness = about(1.0, "factor on the light of those systems")
    glow_softness: Annotated[float, Within(0, MOST_SIZE)] = about(
        0.0, "radius over which their light is softened near them, in world units"
    )

    @field_validator("scatter", mode="before")
    @classmethod
    def _full_or_number(cls, value):
        if isinstance(value, str) and value != "full":
            try:
                number(value)
            except UsageError:
                raise UsageError(f"must be `full` or a number from 0 to 1, not {shown(value)}") from None
        return value

    @model_validator(mode="after")
    def _pointing(self):
        if not any(self.direction):
            raise UsageError("a light's direction must not be [0, 0, 0]")
        return self
