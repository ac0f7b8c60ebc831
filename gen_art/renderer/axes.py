"""Axes with ticks and numbers, drawn into the developed picture."""

import math

import numpy as np

from gen_art.font import drawable
from gen_art.preset.axes import Axes, Axis
from gen_art.preset.colour_names import srgb
from gen_art.preset.labels import REFERENCE_ROWS
from gen_art.renderer.camera import CameraView
from gen_art.renderer.overlay import Line, Written, draw_over

__all__ = ["draw_axes", "tick_values"]

LINE_WIDTH, TICK, ARROW = 1.6, 5.0, 10.0  # pixels of a picture 720 high: of lines, half a tick, the arrow's sides
SPREAD = 0.4  # radians between the arrow's sides and the axis
APART, BEYOND = 0.95, 0.7  # sizes of the text: from the axis to a number, from its end to its name
TICKS = 5  # about, where no step is given
Point = tuple[float, float]
ROUND = (1.0, 2.0, 5.0, 10.0)


def tick_values(axis: Axis) -> list[float]:
    """The coordinates of an axis's ticks: the multiples of its step, or of a round step with about five of them."""
    low, high = axis.range.lo, axis.range.hi
    step = axis.step
    if step is None:
        wanted = (high - low) / TICKS
        power = 10.0 ** math.floor(math.log10(wanted))
        step = power * min(ROUND, key=lambda n: abs(math.log(n * power / wanted)))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [float(f"{k * step:.10g}") for k in range(first, last + 1)]


def draw_axes(picture: np.ndarray, axes: Axes, view: CameraView, unit: str) -> None:
    """Draw axes into a developed picture, in place.

    picture : (height, width, 3 or 4) uint8 or uint16, sRGB, with straight alpha if it has four channels
    unit : label of lengths
    """
    height, width = picture.shape[:2]
    pixel = height / REFERENCE_ROWS
    size = axes.size * pixel
    lines: list[Line] = []
    names: list[Written] = []
    numbers: list[Written] = []
    spines: list[Line] = []
    at_origin: set[float] = set()  # numbers where the axes meet: one that all share is written once
    for k, letter in enumerate("xyz"):
        axis = getattr(axes, letter)
        if axis is None:
            continue
        ends = _visible(axes, k, axis, view)
        if ends is None:
            continue
        (x0, y0), (x1, y1) = view.project(ends, (width, height))[:, :2].tolist()
        length = math.hypot(x1 - x0, y1 - y0)
        clipped = _clipped((x0, y0), (x1, y1), width, height)
        if length == 0.0 or clipped is None:
            continue
        along = np.array([x1 - x0, y1 - y0]) / length
        spines.append(Line(clipped[0], clipped[1], LINE_WIDTH * pixel))
        for turn in (SPREAD, -SPREAD):
            back = -ARROW * pixel * np.array(_turned(along, turn))
            lines.append(Line((x1, y1), (x1 + back[0], y1 + back[1]), LINE_WIDTH * pixel))
        text = axis.label or drawable(f"{letter} ({unit})")
        anchor = 0.5 - 0.5 * along[0]
        names.append(Written(text, x1 + along[0] * BEYOND * size, y1 + along[1] * (BEYOND + 0.3) * size, size, anchor))
        aside = np.array([-along[1], along[0]])  # below the axis, or at the left of a steep one
        if (aside[1] if abs(aside[1]) >= abs(aside[0]) else -aside[0]) < 0.0:
            aside = -aside
        for value in tick_values(axis):
            if length < 2.0 * size:
                break  # seen along its line
            point = _point(axes, k, value)
            if not _in_front(point, view):
                continue
            x, y, _ = view.project([point], (width, height))[0]
            if not (-width < x < 2 * width and -height < y < 2 * height):
                continue
            if math.hypot(x1 - x, y1 - y) < ARROW * pixel:
                continue  # under the arrow
            dx, dy = TICK * pixel * aside
            lines.append(Line((x - dx, y - dy), (x + dx, y + dy), LINE_WIDTH * pixel))
            if value == axes.origin[k]:
                if value in at_origin:
                    continue
                at_origin.add(value)
            x, y = x + aside[0] * APART * size, y + aside[1] * APART * size
            numbers.append(Written(f"{value:g}".replace("-", "−"), x, y, size * 0.9, 0.5 - 0.5 * aside[0]))
    free = [number for number in numbers if not any(_crosses(spine, number) for spine in spines)]
    draw_over(picture, [*spines, *lines, *_apart([*names, *free], 0.15 * size)], srgb(axes.color), size)


def _point(axes: Axes, k: int, value: float) -> np.ndarray:
    point = np.array(axes.origin)
    point[k] = value
    return point


def _in_front(point: np.ndarray, view: CameraView) -> bool:
    depth = ((point - view.position) * view.axes[2]).sum()
    return bool(depth >= view.near and (view.height is not None or depth > 0.0))


def _visible(axes: Axes, k: int, axis: Axis, view: CameraView) -> np.ndarray | None:
    """(2, 3) the ends of the part of an axis that is in front of the camera; None where there is none."""
    ends = np.array([_point(axes, k, axis.range.lo), _point(axes, k, axis.range.hi)])
    if view.height is not None:
        return ends
    near = max(view.near, 1e-3 * view.distance)
    depths = ((ends - view.position) * view.axes[2]).sum(axis=1)
    if (depths < near).all():
        return None
    for end in (0, 1):
        if depths[end] < near:
            share = (near - depths[1 - end]) / (depths[end] - depths[1 - end])
            ends[end] = ends[1 - end] + (ends[end] - ends[1 - end]) * share
    return ends


def _clipped(start: Point, end: Point, width: float, height: float, beside: float = 1.0) -> tuple[Point, Point] | None:
    """The part of a line within 0..width, 0..height or less than `beside` of it away (Liang and Barsky); None without any."""
    low, high = 0.0, 1.0
    for a, b, most in ((start[0], end[0], width), (start[1], end[1], height)):
        for p, q in ((a - b, a + beside * most), (b - a, (1.0 + beside) * most - a)):
            if p == 0.0:
                if q < 0.0:
                    return None
            elif p < 0.0:
                low = max(low, q / p)
            else:
                high = min(high, q / p)
    if low >= high:
        return None
    dx, dy = end[0] - start[0], end[1] - start[1]
    return (start[0] + dx * low, start[1] + dy * low), (start[0] + dx * high, start[1] + dy * high)


def _turned(direction: np.ndarray, angle: float) -> tuple[float, float]:
    cosine, sine = math.cos(angle), math.sin(angle)
    return direction[0] * cosine - direction[1] * sine, direction[0] * sine + direction[1] * cosine


def _crosses(line: Line, text: Written) -> bool:
    left, top, right, bottom = text.box()
    (x0, y0), (x1, y1) = line.start, line.end
    return _clipped((x0 - left, y0 - top), (x1 - left, y1 - top), right - left, bottom - top, 0.0) is not None


def _apart(texts: list[Written], gap: float) -> list[Written]:
    """The texts that touch no text before them."""
    kept: list[Written] = []
    for text in texts:
        left, top, right, bottom = text.box()
        others = (other.box() for other in kept)
        if all(right + gap < o[0] or o[2] + gap < left or bottom < o[1] or o[3] < top for o in others):
            kept.append(text)
    return kept
