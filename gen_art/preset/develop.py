"""The keys of `develop:`, which turns linear light into a picture."""

from typing import Annotated, Literal

from pydantic import model_validator

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.fields import Fraction, GradientValue, RangeValue, Within
from gen_art.preset.model import Model, about
from gen_art.preset.values import Range

__all__ = ["AutoExposure", "Bloom", "DevelopSpec"]


class Bloom(Model):
    """Bloom: a part of the light is spread over halos of all sizes; the total is kept. A number sets the `strength`."""

    strength: Fraction = about(0.05, "the part of the light that is spread")
    radius: Fraction = about(0.5, "size of the halos, from 0 (narrow) to 1 (wide)")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Bloom, dict)) else {"strength": value}


class AutoExposure(Model):
    """Automatic exposure, which follows the brightness of the picture; a number sets the `key`.

    It is a weighted mean over the last three half-lives of film time, so the exposure of a frame does not depend on which
    frames are rendered.
    """

    key: Annotated[float, Within(0, 100, open_low=True)] = about(
        0.18, "the light to which the bright parts are brought (linear: middle grey is 0.18)"
    )
    half_life: Annotated[float, Within(0, 60)] = about(
        0.5, "film time in which half of a change of exposure is made; 0 means at once", unit="s"
    )
    range: RangeValue = about(Range(-6.0, 6.0), "the least and the largest automatic exposure", unit="stops")

    short_form = {"type": ["number", "string"], "description": "the key"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (AutoExposure, dict)) else {"key": value}

    @model_validator(mode="after")
    def _bounded(self):
        if not -60.0 <= self.range.lo <= self.range.hi <= 60.0:
            raise UsageError(f"the range of an exposure must lie within -60..60 stops, not {self.range}")
        return self


class DevelopSpec(Model):
    """Turns linear light into a picture: exposure, bloom, vignette, tone map, background, grain, dither, in this order."""

    exposure: Annotated[float, Within(-60, 60)] = about(0.0, "the light is multiplied by 2 to this power", unit="stops")
    auto_exposure: AutoExposure | None = about(None, "automatic exposure, to which `exposure` is added")
    bloom: Bloom = about(Bloom(), "halos around bright light")
    vignette: Annotated[float, Within(0, 8)] = about(0.0, "darkening of the corners", unit="stops")
    tone: Literal["agx", "aces", "reinhard", "neutral", "log", "none"] = about("agx", "the tone map")
    white: Annotated[float, Within(0, 1e6, open_low=True)] = about(8.0, "the light that reinhard and log map to white")
    density: Annotated[float, Within(0, 1e9, open_low=True)] = about(100.0, "for log: how much dark parts are lifted")
    vibrancy: Fraction = about(1.0, "for log: 1 keeps the ratios of a colour's channels, 0 maps each channel by itself")
    contrast: Annotated[float, Within(0, 4, open_low=True)] = about(
        1.0, "exponent of the light relative to middle grey, before the tone map"
    )
    saturation: Annotated[float, Within(0, 4)] = about(
        1.0, "factor on the difference from grey of equal luminance, after the tone map"
    )
    background: Literal["night"] | GradientValue = about(
        Gradient(((0.0, "black"),)),
        "what is seen where no particle is: a colour, a gradient from top to bottom, or `night`; exposure and tone map do "
        "not change it",
    )
    grain: Annotated[float, Within(0, 0.5)] = about(0.0, "standard deviation of the film grain at middle grey")
    dither: bool = about(True, "dither pictures of 8 bits, so that dark gradients show no bands")
