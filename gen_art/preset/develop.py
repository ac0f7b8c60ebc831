"""From light to a picture: `develop:`."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.fields import GradientValue, Number, RangeValue
from gen_art.preset.types import Model
from gen_art.preset.values import Range

__all__ = ["AutoExposure", "Bloom", "DevelopSpec"]


class Bloom(Model):
    """Light that strays in the lens: `strength` of it, spread over halos of all sizes; radius 0 narrow .. 1 wide."""

    strength: Annotated[Number, Field(ge=0, le=1)] = 0.05
    radius: Annotated[Number, Field(ge=0, le=1)] = 0.5

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Bloom, dict)) else {"strength": value}


class AutoExposure(Model):
    """The exposure follows the light: what shines is brought to `key` (linear; middle grey is 0.18), in stops within `range`.

    It takes `half_life` film seconds to go half the way to a new exposure (0: at once), and looks back three half-lives.
    `exposure` is added to it.
    """

    key: Annotated[Number, Field(gt=0, le=100)] = 0.18
    half_life: Annotated[Number, Field(ge=0, le=60)] = 0.5
    range: RangeValue = Range(-6.0, 6.0)

    short_form = {"type": ["number", "string"], "description": "the key"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (AutoExposure, dict)) else {"key": value}

    @model_validator(mode="after")
    def _bounded(self):
        if not -60.0 <= self.range.lo <= self.range.hi <= 60.0:
            raise UsageError(f"an exposure's range lies within -60..60 stops, not {self.range}")
        return self


class DevelopSpec(Model):
    """From linear light to a picture: exposure in stops, bloom, vignette, background, tone map, grain, dither.

    contrast: a power about middle grey, before the tone map; saturation about luminance, after it (1 leaves them).
    white: what reinhard and log show as white; density, vibrancy: of log (how much of the colour goes with its light).
    background: a colour, a gradient from top to bottom, or `night`. It is seen as written where nothing hides
    it, whatever exposure and tone map are. grain: standard deviation at middle grey. vignette: stops lost in the corners.
    """

    exposure: Annotated[Number, Field(ge=-60, le=60)] = 0.0
    auto_exposure: AutoExposure | None = None
    bloom: Bloom = Bloom()
    vignette: Annotated[Number, Field(ge=0, le=8)] = 0.0
    tone: Literal["agx", "aces", "reinhard", "neutral", "log", "none"] = "agx"
    white: Annotated[Number, Field(gt=0, le=1e6)] = 8.0
    density: Annotated[Number, Field(gt=0, le=1e9)] = 100.0
    vibrancy: Annotated[Number, Field(ge=0, le=1)] = 1.0
    contrast: Annotated[Number, Field(gt=0, le=4)] = 1.0
    saturation: Annotated[Number, Field(ge=0, le=4)] = 1.0
    background: Literal["night"] | GradientValue = Gradient(((0.0, "black"),))
    grain: Annotated[Number, Field(ge=0, le=0.5)] = 0.0
    dither: bool = True
