"""Legends: a colour bar with the joules at its ends, and the ledger's total, in the finished picture.

They are drawn in sRGB after development, so that exposure and tone map change neither the text nor the colours of the bar. Each
stands on a plate of half-transparent black, which keeps white text readable on any picture and does not flicker in a film.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from gen_art.font import drawable, font
from gen_art.preset.look import Look, Ramp
from gen_art.renderer.colour import TABLE, encode_srgb
from gen_art.renderer.look_tables import INTENSITY, OPACITY, SIZE, LookTables, domain
from gen_art.renderer.overlay import lay

__all__ = ["DrawnLegend", "draw_legends", "joules_text", "legend_of"]

PLATE = 0.75  # opacity of the plate: white text on it has a contrast of 9 to 1 on a white picture
TEXT = (245, 245, 245)
ROWS_PER_TEXT = 36  # the picture's height divided by that of the text
LEAST_TEXT, SMALLEST_TEXT = 12, 6  # pixels: the least height of the text, and that to which a narrow picture shrinks it
# pixels: smaller text is drawn this high or higher and averaged, or else whole pixels would crowd its letters
DRAWN_TEXT = 40
BAR_WIDTH, BAR_HEIGHT, PADDING, GAP = 13.0, 0.7, 0.7, 0.35  # in heights of the text
_CURVES = {("emission", "intensity"): INTENSITY, ("opacity",): OPACITY, ("size",): SIZE}


@dataclass(frozen=True)
class DrawnLegend:
    """What one legend shows.

    place : the corner of the picture
    title : the line of text above the bar
    low, high : the values at the ends of the bar, as text
    colours : (256, 3) sRGB, 0..1, from end to end
    heights : (256,) the bar's height, 0..1: 1 for a colour, the curve for a number
    """

    place: str
    title: str
    low: str
    high: str
    colours: np.ndarray
    heights: np.ndarray


def joules_text(value: float, unit: str = "J", digits: int = 3, zeros: bool = True) -> str:
    """A value with a few digits and its unit: 3.20 J, 48210 J, 1.30e-06 J.

    zeros : keep zeros at the end, so that a number that changes from frame to frame keeps its length
    """
    text = f"{value:{'#' if zeros and value else ''}.{digits}g}".rstrip(".")
    if "e" in text and 1.0 <= abs(value) < 1e6:
        text = f"{value:.0f}"
    return f"{text} {unit}"


def legend_of(look: Look, tables: LookTables, totals: dict, unit: str, attributes=()) -> DrawnLegend | None:
    """The legend of a look; None where it has none, or none of its joules are booked.

    totals : by LedgerEntry, the ledger's entries, J
    attributes : names that the particles declare
    """
    if look.legend is None:
        return None
    shown = [(path, *found) for path, found in look.ledger_ramps(attributes).items() if found[0] in totals]
    if not shown:
        return None
    path, entry, ramp = shown[0]
    colours, heights = tables.colours[2, :, :3], np.ones(TABLE)
    if path in (("albedo",), ("emission", "blackbody")):
        colours = tables.colours[1 if path == ("albedo",) else 0, :, :3]
    elif isinstance(ramp, Ramp):
        curve = tables.curves[_CURVES[path]].astype(np.float64)
        colours, heights = np.repeat(colours[:1], TABLE, axis=0), np.abs(curve) / max(np.abs(curve).max(), 1e-300)
    low, high = domain(ramp)
    title = f"{look.legend.label or entry.title}: {joules_text(totals[entry], unit)} in all"
    low_text, high_text = (drawable(joules_text(end, unit, 6, zeros=False)) for end in (low, high))
    srgb = np.clip(encode_srgb(np.clip(colours, 0.0, 1.0)), 0.0, 1.0)
    return DrawnLegend(look.legend.place, drawable(title), low_text, high_text, srgb, heights)


def _width(letters, text: str) -> int:
    return round(letters.getlength(text))


def _plate(legend: DrawnLegend, size: int) -> Image.Image:
    """The legend as an RGBA image with text of `size` pixels."""
    finer = -(-DRAWN_TEXT // size)
    size *= finer
    letters = font(size)
    pad, gap, bar_height = (max(1, round(part * size)) for part in (PADDING, GAP, BAR_HEIGHT))
    ends = _width(letters, legend.low) + _width(letters, legend.high) + size
    width = max(round(BAR_WIDTH * size), _width(letters, legend.title), ends)
    width += -width % size  # the plate of a film does not follow every change of a digit's width
    line = sum(letters.getmetrics())
    image = Image.new(
        "RGBA", (width + 2 * pad, 2 * line + bar_height + 2 * gap + 2 * pad), (0, 0, 0, round(255 * PLATE))
    )
    draw = ImageDraw.Draw(image)
    draw.text((pad, pad), legend.title, fill=TEXT, font=letters)
    top = pad + line + gap
    image.paste(_bar(legend, width, bar_height, finer), (pad, top))
    below = top + bar_height + gap
    draw.text((pad, below), legend.low, fill=TEXT, font=letters)
    draw.text((pad + width - _width(letters, legend.high), below), legend.high, fill=TEXT, font=letters)
    return image.reduce(finer)


def _bar(legend: DrawnLegend, width: int, height: int, rim: int) -> Image.Image:
    """The bar, filled to its height at each column, on dark grey and with a rim, so that black ends are seen."""
    at = np.round(np.linspace(0, TABLE - 1, width)).astype(int)
    filled = np.arange(height)[::-1, None] < np.round(legend.heights[at] * height)[None]
    pixels = np.where(filled[..., None], np.round(255 * legend.colours[at]), 60).astype(np.uint8)
    for side in (np.s_[:rim], np.s_[-rim:], np.s_[:, :rim], np.s_[:, -rim:]):
        pixels[side] = np.maximum(pixels[side], 90)
    return Image.fromarray(pixels)


def draw_legends(picture: np.ndarray, legends: Iterable[DrawnLegend]) -> dict[str, int]:
    """Draw legends into a developed picture, in place; those of one corner stand one above the other.

    Returns the pixels from the top or bottom that they take, by corner.

    picture : (height, width, 3 or 4) uint8 or uint16, sRGB, with straight alpha if it has four channels
    """
    height, width = picture.shape[:2]
    taken: dict[str, int] = {}
    for legend in legends:
        size = max(LEAST_TEXT, round(height / ROWS_PER_TEXT))
        plate = _plate(legend, size)
        while size > SMALLEST_TEXT and (plate.width + size > width or plate.height + size > height):
            size -= 1
            plate = _plate(legend, size)
        margin = size // 2
        offset = taken.get(legend.place, margin)
        taken[legend.place] = offset + plate.height + margin
        top = offset if legend.place.startswith("top") else height - offset - plate.height
        left = margin if legend.place.endswith("left") else width - margin - plate.width
        rgba = np.asarray(plate) / 255.0
        lay(picture, rgba[..., :3] * rgba[..., 3:], rgba[..., 3:], max(top, 0), max(left, 0))
    return taken
