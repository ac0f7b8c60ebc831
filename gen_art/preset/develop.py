"""From light to a picture: `develop:`."""

from typing import Annotated, Literal

from pydantic import model_validator

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.fields import Fraction, GradientValue, RangeValue, Within
from gen_art.preset.model import Model, about
from gen_art.preset.values import Range

__all__ = ["AutoExposure", "Bloom", "DevelopSpec"]


class Bloom(Model):
    """Light that strays in the lens, spread over halos of all sizes, whose sum it keeps; a number is its `strength`."""

    strength: Fraction = about(0.05, "the part of the light that strays")
    radius: Fraction = about(0.5, "0 narrow .. 1 wide")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Bloom, dict)) else {"strength": value}


class AutoExposure(Model):
    """The exposure follows the light; a number is its `key`.

    It is a mean over the last three half-lives of film time, so that a frame has one exposure whichever frames are made.
    """

    key: Annotated[float, Within(0, 100, open_low=True)] = about(
        0.18, "what shines is brought to this light (linear: middle grey is 0.18)"
    )
    half_life: Annotated[float, Within(0, 60)] = about(
        0.5, "film time in which it goes half the way to a new exposure; 0 is at once", unit="s"
    )
    range: RangeValue = about(Range(-6.0, 6.0), "the least and the most of it", unit="stops")

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
    """From linear light to a picture: exposure, bloom, vignette, tone map, background, grain, dither, in this order."""

    exposure: Annotated[float, Within(-60, 60)] = about(0.0, "light is multiplied by 2 to this", unit="stops")
    auto_exposure: AutoExposure | None = about(None, "follows the light; `exposure` is added to it")
    bloom: Bloom = about(Bloom(), "light that strays in the lens")
    vignette: Annotated[float, Within(0, 8)] = about(0.0, "light lost in the corners", unit="stops")
    tone: Literal["agx", "aces", "reinhard", "neutral", "log", "none"] = about("agx", "the tone map")
    white: Annotated[float, Within(0, 1e6, open_low=True)] = about(8.0, "what reinhard and log show as white")
    density: Annotated[float, Within(0, 1e9, open_low=True)] = about(100.0, "of log: how much it lifts the dark")
    vibrancy: Fraction = about(1.0, "of log: how much of a colour goes with its light, 0 to 1")
    contrast: Annotated[float, Within(0, 4, open_low=True)] = about(
        1.0, "a power about middle grey, before the tone map"
    )
    saturation: Annotated[float, Within(0, 4)] = about(1.0, "about luminance, after the tone map")
    background: Literal["night"] | GradientValue = about(
        Gradient(((0.0, "black"),)),
        "a colour, a gradient from top to bottom, or `night`; seen as written where nothing hides it, whatever "
        "exposure and tone map are",
    )
    grain: Annotated[float, Within(0, 0.5)] = about(0.0, "its standard deviation at middle grey")
    dither: bool = about(True, "hashed, in 8 bits: dark gradients show no bands")
