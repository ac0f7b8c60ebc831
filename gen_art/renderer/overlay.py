"""Text, lines and dots drawn over a developed picture: in sRGB, with a thin halo, and with an alpha of their own."""

import math
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from gen_art.font import font, lines_of, text_size

__all__ = ["Dot", "Line", "Written", "draw_over", "lay"]

FINER = 4  # everything is drawn so many times larger and averaged, and placed to that part of a pixel
HALO, HALO_OPACITY = 0.09, 0.75  # width in sizes of the text, and opacity at the letters
DARK_TEXT = 0.18  # luminance below which a colour has a light halo, not a dark one


@dataclass(frozen=True)
class Written:
    """Text: its middle line's point in pixels, with the anchor (0 left, 0.5 centre, 1 right) there, letters of `size` pixels."""

    text: str
    x: float
    y: float
    size: float
    anchor: float

    def box(self) -> tuple[float, float, float, float]:
        """(left, top, right, bottom) in pixels."""
        width, height = text_size(self.text, self.size)
        left, top = self.x - self.anchor * width, self.y - 0.5 * height
        return left, top, left + width, top + height

    def draw(self, ink: ImageDraw.ImageDraw, halo: ImageDraw.ImageDraw, left: float, top: float, rim: float) -> None:
        size = max(1, round(self.size * FINER))
        letters, lines = font(size), lines_of(self.text)
        box = self.box()
        x, y = (box[0] + self.anchor * (box[2] - box[0]) - left) * FINER, (box[1] - top) * FINER
        for k, line in enumerate(lines):
            at = round(x - self.anchor * letters.getlength(line)), round(y + k * sum(letters.getmetrics()))
            ink.text(at, line, fill=255, font=letters)
            halo.text(at, line, fill=255, font=letters, stroke_width=round(rim * FINER))


@dataclass(frozen=True)
class Line:
    """A straight line from one point to another, in pixels, `width` pixels wide."""

    start: tuple[float, float]
    end: tuple[float, float]
    width: float

    def box(self) -> tuple[float, float, float, float]:
        (x0, y0), (x1, y1) = self.start, self.end
        return min(x0, x1) - self.width, min(y0, y1) - self.width, max(x0, x1) + self.width, max(y0, y1) + self.width

    def draw(self, ink: ImageDraw.ImageDraw, halo: ImageDraw.ImageDraw, left: float, top: float, rim: float) -> None:
        for canvas, wider in ((ink, 0.0), (halo, rim)):
            canvas.polygon(_strip(self.start, self.end, 0.5 * self.width + wider, wider, left, top), fill=255)


@dataclass(frozen=True)
class Dot:
    """A filled circle, in pixels."""

    x: float
    y: float
    radius: float

    def box(self) -> tuple[float, float, float, float]:
        return self.x - self.radius, self.y - self.radius, self.x + self.radius, self.y + self.radius

    def draw(self, ink: ImageDraw.ImageDraw, halo: ImageDraw.ImageDraw, left: float, top: float, rim: float) -> None:
        x, y = (self.x - left) * FINER - 0.5, (self.y - top) * FINER - 0.5
        for canvas, radius in ((ink, self.radius * FINER), (halo, (self.radius + rim) * FINER)):
            canvas.ellipse((x - radius, y - radius, x + radius, y + radius), fill=255)


def _strip(start, end, half: float, longer: float, left: float, top: float) -> list[tuple[float, float]]:
    """The corners of a line with a width, on the finer canvas."""
    (x0, y0), (x1, y1) = start, end
    length = math.hypot(x1 - x0, y1 - y0) or 1.0
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    ends = ((x0 - ux * longer, y0 - uy * longer), (x1 + ux * longer, y1 + uy * longer))
    corners = [(x + s * uy * half, y - s * ux * half) for (x, y), sides in zip(ends, ((1, -1), (-1, 1))) for s in sides]
    return [((x - left) * FINER - 0.5, (y - top) * FINER - 0.5) for x, y in corners]


def draw_over(
    picture: np.ndarray, marks, colour: tuple[float, float, float], size: float, opacity: float = 1.0,
    outline: tuple[float, float, float] | None = None,
) -> None:  # fmt: skip
    """Draw marks of one colour into a developed picture, in place; what is outside of it is cut off.

    picture : (height, width, 3 or 4) uint8 or uint16, sRGB, with straight alpha if it has four channels
    marks : Written, Line and Dot, in pixels: pixel (row, column) covers column..column + 1 and row..row + 1
    colour : sRGB, 0..1
    size : pixels of the text, of which the halo's width is a part
    opacity : 0..1 of all of it
    outline : sRGB, 0..1, of the halo; black or white, whichever stands out from the colour, when None
    """
    if not marks or opacity <= 0.0:
        return
    rim = max(1.0, HALO * size)
    boxes = np.array([mark.box() for mark in marks])
    height, width = picture.shape[:2]
    left, top = (max(0, math.floor(side - rim - 1)) for side in boxes[:, :2].min(axis=0))
    right, bottom = (
        min(most, math.ceil(side + rim + 1)) for side, most in zip(boxes[:, 2:].max(axis=0), (width, height))
    )
    if right <= left or bottom <= top:
        return
    canvases = [Image.new("L", ((right - left) * FINER, (bottom - top) * FINER)) for _ in range(2)]
    ink, halo = (ImageDraw.Draw(canvas) for canvas in canvases)
    for mark in marks:
        mark.draw(ink, halo, left, top, rim)
    inked, around = (np.asarray(canvas.reduce(FINER), np.float64)[..., None] / 255.0 for canvas in canvases)
    rest = HALO_OPACITY * around * (1.0 - inked)
    if outline is None:
        light = sum(c**2.2 * share for c, share in zip(colour, (0.2126, 0.7152, 0.0722)))
        outline = (1.0, 1.0, 1.0) if light < DARK_TEXT else (0.0, 0.0, 0.0)
    lay(picture, opacity * (inked * np.array(colour) + rest * np.array(outline)), opacity * (inked + rest), top, left)


def lay(picture: np.ndarray, colour: np.ndarray, cover: np.ndarray, top: int, left: int) -> None:
    """Lay a rectangle over a developed picture, in place, with its corner at (top, left); what does not fit is cut off.

    colour : (rows, columns, 3) sRGB times cover, 0..1
    cover : (rows, columns, 1) opacity, 0..1
    """
    under = picture[top : top + colour.shape[0], left : left + colour.shape[1]]
    colour, cover = (part[: under.shape[0], : under.shape[1]] for part in (colour, cover))
    most = float(np.iinfo(picture.dtype).max)
    below = under[..., :3] / most
    if picture.shape[2] == 4:
        alpha = under[..., 3:] / most
        joint = cover + alpha * (1.0 - cover)
        mixed = (colour + below * alpha * (1.0 - cover)) / np.maximum(joint, 1e-9)
        under[..., 3:] = np.round(most * joint)
    else:
        mixed = colour + below * (1.0 - cover)
    under[..., :3] = np.round(most * np.clip(mixed, 0.0, 1.0))
