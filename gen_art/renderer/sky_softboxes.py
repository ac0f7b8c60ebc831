"""Softboxes: rectangles of even light in the sky.

On the plane that touches the unit sphere at its middle, a box is seen at (x, y), to the right and up, in units of slope. Of a
direction it covers

    s(x, width) s(y, tall),    s(x, w) = S((tan(w / 2) - |x|) / e + 1/2),    e = 2 tan(edge / 2)

with the smooth step S(t) = t^2 (3 - 2 t) of t cut to 0..1: a half at its sides. It hides the sky behind it, but neither the
stars nor the sun's disc.
"""

from collections.abc import Sequence

import numpy as np

from gen_art.maths.array_functions import cos, sin
from gen_art.preset.sky import Softbox
from gen_art.renderer.colour import linear
from gen_art.renderer.sky_table import directions_of_table

__all__ = ["coverage", "with_softboxes"]

_SHARPEST = 0.5  # degrees, about the cells of the table


def coverage(box: Softbox, d: np.ndarray) -> np.ndarray:
    """(...) the part of unit directions d (..., 3) that a box covers, 0..1."""
    sin_h, cos_h, sin_a, cos_a = (f(np.radians(angle)) for angle in (box.height, box.azimuth) for f in (sin, cos))
    middle = cos_h * sin_a, sin_h, -cos_h * cos_a
    right = cos_a, 0.0, sin_a
    up = -sin_h * sin_a, cos_h, sin_h * cos_a
    ahead, x, y = (d[..., 0] * v[0] + d[..., 1] * v[1] + d[..., 2] * v[2] for v in (middle, right, up))
    fade = 2.0 * _half_slope(max(box.edge, _SHARPEST))
    share = np.where(ahead > 1e-6, 1.0, 0.0)
    for across, angle in ((x, box.width), (y, box.tall)):
        beside = np.abs(across) / np.maximum(ahead, 1e-6)
        t = np.clip((_half_slope(angle) - beside) / fade + 0.5, 0.0, 1.0)
        share = share * t * t * (3.0 - 2.0 * t)
    return share


def _half_slope(degrees: float) -> float:
    half = np.radians(degrees / 2.0)
    return float(sin(half) / cos(half))


def with_softboxes(table: np.ndarray, boxes: Sequence[Softbox]) -> np.ndarray:
    """A sky's table (rows, columns, 3) behind its boxes, of which later ones hide earlier ones."""
    if not boxes:
        return table
    directions = directions_of_table()
    for box in boxes:
        share = coverage(box, directions)[..., None]
        table = table + (linear(box.color) * box.intensity - table) * share
    return table
