"""The keys of a look that change the shape and the size of its soft discs."""

from typing import Annotated, Literal

from pydantic import model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import NotNegative, Positive, Within
from gen_art.preset.model import Model, about

__all__ = ["Spread", "Stretch"]


class Stretch(Model):
    """Stretches soft discs to ellipsoids of the same volume, with the same light. Needs `draw: disc`.

    By `motion` a disc follows the particle's velocity, by `neighbours` the spread of the particles around it: threads and
    sheets of particles become continuous, and an even cloud stays a cloud of balls. A number sets the `time`.
    """

    by: Literal["motion", "neighbours"] = about("motion", "what a disc is stretched along")
    time: NotNegative | None = about(
        None,
        "by motion: each disc is as long as if it were swept along its velocity for this simulated time",
        unit="s",
    )
    reach: Positive | None = about(
        None, "by neighbours: how far they are looked for; a thread or a sheet needs ten or more in it", unit="m"
    )
    most: Annotated[float, Within(1, 16)] = about(4.0, "the largest ratio of length to width")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Stretch, dict)) else {"time": value}

    @model_validator(mode="after")
    def _consistent(self):
        needed, other = ("time", "reach") if self.by == "motion" else ("reach", "time")
        if getattr(self, needed) is None:
            raise UsageError(f"by: {self.by} needs `{needed}`")
        if getattr(self, other) is not None:
            raise UsageError(f"by: {self.by} has no `{other}`: leave it out")
        return self


class Spread(Model):
    """Widens soft discs that are far from others: the radius follows the distance to the neighbours. Needs `draw: disc`.

    The light of a disc and its extinction cross section stay, so that a stray one becomes thin haze; none becomes smaller. A
    number sets the `reach`.
    """

    reach: Positive = about(
        ..., "how far neighbours are looked for; the distance counts as 0.86 reach at most", unit="m"
    )
    overlap: Positive = about(1.0, "radius of a disc, divided by the distance to its neighbours")
    most: Annotated[float, Within(1, 64)] = about(8.0, "the largest factor on the radius")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Spread, dict)) else {"reach": value}
