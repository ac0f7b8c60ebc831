"""The keys of `axes:`: axes with ticks and numbers in the finished picture."""

from typing import Annotated

from pydantic import AfterValidator, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import ColourValue, Positive, RangeValue, Vector
from gen_art.preset.labels import Text, TextSize
from gen_art.preset.model import Model, about, collected

__all__ = ["Axes", "Axis"]

MOST_TICKS = 100


def _long(value):
    if value.lo == value.hi:
        raise UsageError(f"an axis runs from one coordinate to another: write a range such as 0..4, not {value.lo:g}")
    return value


class Axis(Model):
    """One axis of `axes`; a range such as 0..4 sets the `range`."""

    range: Annotated[RangeValue, AfterValidator(_long)] = about(..., "the coordinates at its two ends, in world units")
    label: Text | None = about(None, "the text at its end; its name and the unit of lengths, as `x (m)`, when left out")
    step: Positive | None = about(None, "distance from tick to tick, in world units; a round one when left out")

    short_form = {"type": ["string", "array"]}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (Axis, dict)) else {"range": value}

    @model_validator(mode="after")
    def _ticks(self):
        if self.step is not None and (self.range.hi - self.range.lo) / self.step > MOST_TICKS:
            number = (self.range.hi - self.range.lo) / self.step
            raise collected([(("step",), f"would make {number:,.0f} ticks, and an axis has {MOST_TICKS} at most")])
        return self


class Axes(Model):
    """Axes with ticks and numbers, drawn over the finished picture as labels are: two of them for a plane, three for space.

    Nothing hides them. Numbers that would touch each other are left out. EXR pictures have none.
    """

    x: Axis | None = about(None, "the x axis, as 0..4; none when left out")
    y: Axis | None = about(None, "the y axis")
    z: Axis | None = about(None, "the z axis")
    origin: Vector = about(
        (0.0, 0.0, 0.0), "the point through which all of them run, also where it is beyond their ends"
    )
    size: TextSize = about(20.0, "size of the letters, in pixels of a picture that is 720 pixels high")
    color: ColourValue = about("silver", "the colour, as it is in the finished picture")

    @model_validator(mode="after")
    def _some(self):
        if self.x is None and self.y is None and self.z is None:
            raise UsageError("needs x, y or z: the range of coordinates of an axis, such as x: 0..4")
        return self
