"""The keys of `labels:` and `axes:`: text in the finished picture."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, PlainSerializer, WithJsonSchema, model_validator

from gen_art.errors import UsageError
from gen_art.font import missing, text_size
from gen_art.preset.camera import CameraSpec
from gen_art.preset.fields import ColourValue, NotNegative, Number, Parsed, Vector, Within
from gen_art.preset.model import Model, about, collected
from gen_art.preset.values import number, shown
from gen_art.registry import suggest

__all__ = ["PLACES", "REFERENCE_ROWS", "Label", "too_wide"]

PLACES = ("top left", "top", "top right", "bottom left", "bottom", "bottom right")
LONGEST = 200  # characters of a label
REFERENCE_ROWS = 720  # a pixel of a preset is a pixel of a picture this high
WIDEST = 0.96  # of the picture's width


def written(value) -> str:
    """Text that can be drawn. Raises UsageError for characters that the font does not have."""
    if not isinstance(value, str) or not value.strip():
        raise UsageError(f"must be text, not {shown(value)}")
    if len(value) > LONGEST:
        raise UsageError(f"must be at most {LONGEST} characters, not {len(value)}")
    if absent := missing(value):
        names = ", ".join(f"{c} (U+{ord(c):04X})" if c.isprintable() else f"U+{ord(c):04X}" for c in absent[:5])
        raise UsageError(f"the font has no {names}: it has Latin, Greek and mathematical characters")
    return value


def _place(value):
    if isinstance(value, str):
        if value not in PLACES:
            raise UsageError(
                f"must be one of {', '.join(PLACES)}, or [x, y] from 0 to 1; not {shown(value)}{suggest(value, PLACES)}"
            )
        return value
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise UsageError(f"must be one of {', '.join(PLACES)}, or [x, y] from 0 to 1; not {shown(value)}")
    x, y = number(value[0]), number(value[1])
    if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):
        raise UsageError(f"[x, y] run from 0 at the left and top to 1 at the right and bottom, not [{x:g}, {y:g}]")
    return x, y


def _pair(value):
    if isinstance(value, (str, dict)) or not hasattr(value, "__len__") or len(value) != 2:
        raise UsageError(f"must be two numbers [right, up], not {shown(value)}")
    right, up = number(value[0]), number(value[1])
    if max(abs(right), abs(up)) > 10_000:
        raise UsageError(f"must be at most 10,000 pixels, not {shown(value)}")
    return right, up


Text = Annotated[str, Parsed(written, {"type": "string", "minLength": 1, "maxLength": LONGEST})]
Place = Annotated[
    Any,
    BeforeValidator(_place),
    PlainSerializer(lambda place: list(place) if isinstance(place, tuple) else place),
    WithJsonSchema({"anyOf": [{"enum": list(PLACES)}, {"type": "array", "minItems": 2, "maxItems": 2}]}),
]
Pair = Annotated[tuple[float, float], Parsed(_pair, {"type": "array", "minItems": 2, "maxItems": 2}, list)]
TextSize = Annotated[float, Within(6, 360)]


class Label(Model):
    """Text in the finished picture, at a point in space or at a place of the picture; text alone is at the top left.

    It is drawn in sRGB over the developed picture, with a thin outline that stands out from it. A label is hidden where its point
    is behind the camera, and while no particle of the system that it follows is alive. Near the sides it is moved so far that all
    of it is in the picture, and where its point leaves the picture it leaves with it. EXR pictures have no labels.
    """

    text: Text = about(..., "the text; a line break begins a new line")
    at: Vector | None = about(None, "a point in space")
    follow: str | None = about(None, "a system; the label is at the mean position of its living particles")
    place: Place | None = about(
        None,
        "a place of the picture: `top left`, `top`, `top right`, `bottom left`, `bottom`, `bottom right`, or [x, y] from 0 at "
        "the left and top to 1",
    )
    size: TextSize = about(26.0, "size of the letters, in pixels of a picture that is 720 pixels high")
    color: ColourValue = about("white", "the text's colour, as it is in the finished picture")
    outline: ColourValue | None = about(
        None,
        "the colour around the letters, such as the paper's; when left out, black around light letters, white around dark ones",
    )
    anchor: Literal["left", "centre", "right"] | None = about(
        None, "the part of the text that is at its place; when left out, its nearest side, and `centre` above a point"
    )
    offset: Pair | None = about(
        None,
        "[right, up] from the point to the text's middle line, in pixels of a picture that is 720 pixels high; when left out, "
        "above the point, and above it to the right with a `line`",
    )
    line: bool = about(False, "a line from the text to the point")
    start: Number | None = about(
        None, "film time at which it appears; from the start when left out", unit="s", alias="from"
    )
    until: Number | None = about(None, "film time at which it is gone; never when left out", unit="s")
    fade: NotNegative = about(0.3, "film time in which it appears and disappears", unit="s")

    short_form = {"type": "string"}

    @classmethod
    def from_short(cls, value):
        return {"text": value, "place": "top left"} if isinstance(value, str) else value

    @model_validator(mode="after")
    def _consistent(self):
        if sum(v is not None for v in (self.at, self.follow, self.place)) != 1:
            raise UsageError("give one of at, follow and place")
        if self.place is not None and self.line:
            raise collected([(("line",), "a line leads to a point: give `at` or `follow` instead of `place`")])
        if self.place is not None and self.offset is not None:
            raise collected([(("offset",), "an offset is from a point: give `at` or `follow` instead of `place`")])
        if self.start is not None and self.until is not None and self.until <= self.start:
            raise collected([(("until",), f"must be later than `from`, {self.start:g} s; not {self.until:g}")])
        return self


def too_wide(preset) -> Iterator[tuple[tuple, str]]:
    """(path, problem) of every label that is wider or higher than the preset's picture."""
    width, height = (preset.camera or CameraSpec()).size
    for k, label in enumerate(preset.labels):
        wide, high = text_size(label.text, label.size)
        most = WIDEST * REFERENCE_ROWS * width / height
        if wide > most:
            fitting = max(6, int(label.size * most / wide))
            yield (
                ("labels", k, "text"),
                (
                    f"the text is {wide:.0f} pixels wide, and a picture of {width}x{height}, scaled to a height of 720, has room "
                    f"for {most:.0f}: "
                    f"make it shorter, break it into lines, or give a size of {fitting} or less"
                ),
            )
        elif high > WIDEST * REFERENCE_ROWS:
            yield (
                ("labels", k, "text"),
                (
                    f"the text is {high:.0f} pixels high, and a picture has room for {WIDEST * REFERENCE_ROWS:.0f} of 720: "
                    "give fewer lines or a smaller size"
                ),
            )
