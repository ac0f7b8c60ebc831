"""Colours as written in presets: names, `#rrggbb`, [r, g, b], and gradients of colours or palettes. All are sRGB-encoded.

The renderer converts them to linear light (renderer/colour.py).
"""

from dataclasses import dataclass

from gen_art.errors import UsageError
from gen_art.preset.palettes import PALETTES, hint, palette
from gen_art.preset.values import number, shown

__all__ = ["COLOURS", "PALETTES", "Gradient", "srgb"]

COLOURS = {
    "black": "#000000", "white": "#ffffff", "gray": "#808080", "grey": "#808080", "charcoal": "#2b2b30",
    "silver": "#d3dbe6", "smoke": "#c9c6c2", "ash": "#8d8782", "bone": "#ece3d0", "ivory": "#fff8e7",
    "red": "#ff1a1a", "crimson": "#e0102f", "scarlet": "#ff3b1d", "ruby": "#b8123f", "maroon": "#6d0f1e",
    "rose": "#ff6f91", "pink": "#ff9ec4", "magenta": "#ff2bd6", "plum": "#7d3c98",
    "orange": "#ff8a1e", "ember": "#c83200", "rust": "#9a3b12", "copper": "#c9703a", "bronze": "#a8753a",
    "amber": "#ffb52e", "gold": "#ffcf5a", "yellow": "#ffe834", "lemon": "#fff27a", "sand": "#e3cfa0",
    "brown": "#6e4325", "olive": "#7d8a2e", "lime": "#a6ff3c", "green": "#27d860", "emerald": "#12b77a",
    "forest": "#175c38", "mint": "#9ff0cf", "teal": "#16a79c", "turquoise": "#38e0d0", "cyan": "#35e6ff",
    "sky": "#8fd0ff", "azure": "#3d9bff", "blue": "#2f6bff", "cobalt": "#1d3fae", "navy": "#0e1a45",
    "midnight": "#070b1d", "indigo": "#4038b8", "violet": "#8a4dff", "lavender": "#c7b5ff",
}  # fmt: skip

_FORMS = "; write a name, '#rrggbb' or [r, g, b]"


def srgb(value) -> tuple[float, float, float]:
    """An sRGB-encoded triple in 0..1 from a name, `#rgb`, `#rrggbb` or [r, g, b]. Raises UsageError otherwise."""
    if isinstance(value, str):
        text = COLOURS.get(value.strip().lower(), value.strip())
        if text.startswith("#") and len(text) in (4, 7):
            digits = text[1:] if len(text) == 7 else "".join(2 * c for c in text[1:])
            try:
                red, green, blue = (int(digits[i : i + 2], 16) / 255.0 for i in (0, 2, 4))
                return red, green, blue
            except ValueError:
                pass
        if palette(value):
            raise UsageError(f"{shown(value)} is a palette, but this must be one colour")
        raise UsageError(f"no colour named {shown(value)}{hint(value, COLOURS) or _FORMS}")
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise UsageError(f"must be a colour: a name, '#rrggbb' or [r, g, b] from 0 to 1; not {shown(value)}")
    triple = number(value[0]), number(value[1]), number(value[2])
    if not all(0.0 <= c <= 1.0 for c in triple):
        raise UsageError(f"a colour's [r, g, b] run from 0 to 1, not {list(triple)}")
    return triple


def _is_colour(value) -> bool:
    return isinstance(value, str) or (isinstance(value, (list, tuple)) and len(value) == 3 and _all_numbers(value))


def _all_numbers(values) -> bool:
    return all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values)


@dataclass(frozen=True, slots=True)
class Gradient:
    """Colours at increasing positions 0..1, interpolated in OKLab: ((position, colour), ...).

    Written as a colour, a palette's name (`magma`, `magma reversed`), a list of colours, or a list of [position, colour].
    """

    stops: tuple[tuple[float, object], ...]

    def __post_init__(self):
        for (before, _), (after, _) in zip(self.stops, self.stops[1:]):
            if after <= before:
                raise UsageError(f"a gradient's positions must increase: {after:g} follows {before:g}")
        for position, colour in self.stops:
            if not 0.0 <= position <= 1.0:
                raise UsageError(f"a gradient's positions run from 0 to 1, not {position:g}")
            srgb(colour)

    @classmethod
    def of(cls, value) -> "Gradient":
        """A Gradient from any of its written forms. Raises UsageError otherwise."""
        if isinstance(value, Gradient):
            return value
        if isinstance(value, str):
            known = palette(value)
            if known is None and value.strip()[:1] != "#" and value.strip().lower() not in COLOURS:
                raise UsageError(f"no colour or palette named {shown(value)}{hint(value, COLOURS) or _FORMS}")
            value = known or value
        if _is_colour(value):
            return cls(((0.0, _frozen(value)),))
        if not isinstance(value, (list, tuple)) or not value:
            raise UsageError(f"must be a colour, a palette or a list of colours, not {shown(value)}")
        if all(_is_colour(v) for v in value):
            last = max(len(value) - 1, 1)
            return cls(tuple((i / last, _frozen(v)) for i, v in enumerate(value)))
        if all(isinstance(v, (list, tuple)) and len(v) == 2 and _is_colour(v[1]) for v in value):
            return cls(tuple((number(p), _frozen(c)) for p, c in value))
        raise UsageError("a gradient is a list of colours, or of [position, colour] pairs")

    def written(self):
        """The gradient as plain data for YAML."""
        if len(self.stops) == 1:
            colour = self.stops[0][1]
            return list(colour) if isinstance(colour, tuple) else colour
        return [[p, list(c) if isinstance(c, tuple) else c] for p, c in self.stops]


def _frozen(colour):
    return tuple(colour) if isinstance(colour, list) else colour
