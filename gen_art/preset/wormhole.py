"""The keys of `wormhole:`, a throat through which light and particles reach another side."""

from typing import Literal

from pydantic import model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import Size, Vector
from gen_art.preset.model import Model, about
from gen_art.preset.sky import Sky

__all__ = ["Wormhole"]


class Wormhole(Model):
    """A wormhole, which bends the light of sprites, stars and sky by Ellis' metric; a number sets the `radius`.

    The two sides are two copies of space, joined along a disc: who goes through it comes out on the other side, at the same
    coordinates. The preset's `sky` surrounds this side. The wormhole looks like a ball from every direction.
    """

    center: Vector = about((0.0, 0.0, 0.0), "the middle of the disc")
    radius: Size = about(..., "radius of the disc, and of the throat", unit="m")
    axis: Vector = about((0.0, 0.0, 1.0), "direction of the disc's axis, on this side towards its front")
    sky: Sky | None = about(None, "what surrounds the other side; nothing when left out")
    camera: Literal["near", "far"] = about(
        "near",
        "the side on which the camera's path begins: `near` is this side, `far` the other. A path through the disc changes sides",
    )

    short_form = {"type": ["number", "string"], "description": "the radius"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Wormhole, dict)) else {"radius": value}

    @model_validator(mode="after")
    def _consistent(self):
        if not any(self.axis):
            raise UsageError("a wormhole's axis must not be [0, 0, 0]")
        if self.sky is not None and self.sky.sun is not None:
            raise UsageError("the skies of a wormhole have no sun: give `sky` a gradient, a color, stars or a band")
        return self
