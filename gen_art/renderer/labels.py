"""Labels: where each is at a moment, and how it is drawn into the developed picture."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from gen_art.font import text_size
from gen_art.preset.colour_names import srgb
from gen_art.preset.labels import REFERENCE_ROWS, Label
from gen_art.renderer.camera import CameraView
from gen_art.renderer.overlay import Dot, Line, Written, draw_over

__all__ = ["draw_labels", "opacity_at"]

MARGIN = 24.0  # pixels between a label and the sides of a picture that is 720 pixels high
ABOVE, ASIDE = (0.0, 30.0), (56.0, 48.0)  # the offsets when left out, in those pixels: without and with a line
LINE_WIDTH, DOT = 1.8, 3.0  # of the line, and radius of the dot at its end
GAP = 0.25  # between the text and its line, in sizes of the text
ANCHORS = {"left": 0.0, "centre": 0.5, "right": 1.0}


def opacity_at(label: Label, time: float) -> float:
    """0..1: how far a label has appeared, or not yet disappeared, at film time `time`, s."""
    parts = []
    if label.start is not None:
        parts.append((time - label.start) / label.fade if label.fade else float(time >= label.start))
        if label.start <= 0.0 <= time:
            parts = []  # it is there from the first frame on
    if label.until is not None:
        parts.append((label.until - time) / label.fade if label.fade else float(time < label.until))
    shown = min(1.0, max(0.0, min(parts, default=1.0)))
    return shown * shown * (3.0 - 2.0 * shown)


def draw_labels(
    picture: np.ndarray, labels: Sequence[Label], view: CameraView, time: float, means: Mapping[str, np.ndarray],
    taken: Mapping[str, int] | None = None,
) -> None:  # fmt: skip
    """Draw the labels of film time `time` (s) into a developed picture, in place.

    picture : (height, width, 3 or 4) uint8 or uint16, sRGB, with straight alpha if it has four channels
    means : (3,) by system, the mean position of its living particles; a system without any has no entry
    taken : by corner, pixels that legends take; labels of one place stand one below the other
    """
    height, width = picture.shape[:2]
    rows = dict(taken or {})
    for label in labels:
        opacity = opacity_at(label, time)
        if opacity <= 0.0:
            continue
        size = _fitting(label, width, height)
        if label.place is not None:
            marks = [_placed(label, size, width, height, rows)]
        else:
            point = label.at if label.at is not None else means.get(str(label.follow))
            marks = _at_point(label, size, point, view, width, height) if point is not None else []
        draw_over(picture, marks, srgb(label.color), size, opacity, srgb(label.outline) if label.outline else None)


def _fitting(label: Label, width: int, height: int) -> float:
    """The letters' size in pixels: smaller than asked for where a narrow picture has no room."""
    size = label.size * height / REFERENCE_ROWS
    wide, _ = text_size(label.text, size)
    room = width - MARGIN * height / REFERENCE_ROWS
    return size if wide <= room else size * room / wide


def _placed(label: Label, size: float, width: int, height: int, rows: dict[str, int]) -> Written:
    wide, high = text_size(label.text, size)
    margin = MARGIN * height / REFERENCE_ROWS
    if isinstance(label.place, tuple):
        x, y = label.place[0] * width, label.place[1] * height
        anchor = (
            ANCHORS[label.anchor]
            if label.anchor
            else 0.0
            if label.place[0] < 1 / 3
            else 0.5
            if label.place[0] <= 2 / 3
            else 1.0
        )
        x += _inwards(x - anchor * wide, x + (1.0 - anchor) * wide, width, 0.5 * margin)
        return Written(label.text, x, y + _inwards(y - 0.5 * high, y + 0.5 * high, height, 0.5 * margin), size, anchor)
    place = str(label.place)
    side = 0.0 if place.endswith("left") else 1.0 if place.endswith("right") else 0.5
    anchor = ANCHORS[label.anchor] if label.anchor else side
    first = max(rows.get(place, 0), round(margin))
    rows[place] = math.ceil(first + high)
    left = margin + side * (width - 2.0 * margin - wide)
    y = first + 0.5 * high
    return Written(label.text, left + anchor * wide, y if place.startswith("top") else height - y, size, anchor)


def _at_point(label: Label, size: float, point, view: CameraView, width: int, height: int) -> list:
    depth = float(((point - view.position) * view.axes[2]).sum())
    if not (view.near <= depth <= view.far and (view.height is not None or depth > 0.0)):
        return []
    x, y, _ = view.project([point], (width, height))[0]
    pixel = height / REFERENCE_ROWS
    right, up = label.offset or (ASIDE if label.line else ABOVE)
    towards = 0.0 if right > 0.0 else 1.0 if right < 0.0 else 0.5
    anchor = ANCHORS[label.anchor] if label.anchor else towards
    text = Written(label.text, x + right * pixel, y - up * pixel, size, anchor)
    left, top, far, bottom = text.box()
    inside = min(max(x, 0.0), width), min(max(y, 0.0), height)  # beyond the sides, the label leaves with its point
    dx, dy = x - inside[0], y - inside[1]
    if abs(dx) > width or abs(dy) > height:
        return []
    text = Written(
        label.text, text.x + _inwards(left - dx, far - dx, width, 0.25 * size),
        text.y + _inwards(top - dy, bottom - dy, height, 0.25 * size), size, anchor,
    )  # fmt: skip
    marks: list = [text]
    if label.line:
        marks += [Dot(x, y, DOT * pixel), *_leader(text, x, y, size, pixel)]
    return marks


def _leader(text: Written, x: float, y: float, size: float, pixel: float) -> list[Line]:
    """The line from the nearest side of the text to the point; none where the point is inside the text."""
    left, top, right, bottom = text.box()
    gap = GAP * size
    start = min(max(x, left - gap), right + gap), min(max(y, top), bottom)
    if left - gap < x < right + gap:  # above or below: from the middle of that side
        start = 0.5 * (left + right), start[1]
    else:
        start = start[0], text.y
    if left - gap < x < right + gap and top < y < bottom:
        return []
    return [Line(start, (x, y), LINE_WIDTH * pixel)]


def _inwards(low: float, high: float, most: float, margin: float) -> float:
    """The move that brings low..high within margin..most - margin; its middle to the middle where there is no room."""
    if high - low > most - 2.0 * margin:
        return 0.5 * most - 0.5 * (low + high)
    return max(0.0, margin - low) + min(0.0, most - margin - high)
