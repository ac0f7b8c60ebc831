"""Which solids may stand between a near lamp and the places around it.

The directions from each lamp are cut into cells: rows by the height y of the unit direction, columns by the angle around the
vertical, as the ratio of x and z in each quarter, so that a kernel finds a direction's cell without trigonometry. A solid is
listed in the cells of the cone, as seen from the lamp, within which it may hide any part of it.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.maths.array_functions import arctan2, cos, sin
from gen_art.renderer.surfaces.cell_lists import cell_lists

__all__ = ["COLUMNS", "ROWS", "NearBins", "near_cell", "quarter_angle"]

ROWS, COLUMNS = 16, 32
_MARGIN = 1e-3  # of an angle, for round-off


def quarter_angle(x, z) -> np.ndarray:
    """0..4, rising with the angle of (x, z): x / (|x| + |z|) bent around the four quarters."""
    reach = np.maximum(np.abs(x) + np.abs(z), 1e-30)
    return np.where(z >= 0.0, 1.0 - x / reach, 3.0 + x / reach)


@ti.func
def near_cell(d):
    """The number of the cell, among those of a lamp, of a unit direction from it."""
    ratio = d[0] / ti.max(abs(d[0]) + abs(d[2]), 1e-30)
    angle = ti.select(d[2] >= 0.0, 1.0 - ratio, 3.0 + ratio)
    row = ti.min(ti.max(ti.cast((1.0 + d[1]) * (0.5 * ROWS), ti.i32), 0), ROWS - 1)
    return row * COLUMNS + ti.min(ti.max(ti.cast(angle * (COLUMNS / 4.0), ti.i32), 0), COLUMNS - 1)


@dataclass(frozen=True)
class NearBins:
    """Cell (lamp * ROWS + row) * COLUMNS + column holds solids[starts[cell] : starts[cell + 1]]."""

    starts: np.ndarray
    solids: np.ndarray

    @classmethod
    def of(cls, lamps, widths, positions, radii, own, holding=None) -> "NearBins":
        """The bins of solids around lamps.

        lamps, widths : (k, 3), (k,) their centres and radii
        positions, radii : (n, 3), (n,) of the balls around the solids
        own : (n,) bool, solids that give the light themselves, which do not hide it
        holding : (k, n) bool, solids around a lamp's middle, which do not hide it; when left out, they are those balls
        """
        firsts, lasts, which = [], [], []
        solid = np.flatnonzero(~np.asarray(own, bool))
        for k, (lamp, width) in enumerate(zip(lamps, widths)):
            offset = positions[solid] - lamp
            distance = np.sqrt((offset**2).sum(axis=1))
            outside = distance > radii[solid] if holding is None else ~holding[k, solid]
            here, offset, distance = solid[outside], offset[outside], np.maximum(distance[outside], 1e-30)
            sine = np.minimum((radii[here] + width) / distance, 1.0)
            first, last, one = _cells(offset / distance[:, None], sine)
            firsts.append(first + [k * ROWS, 0])
            lasts.append(last + [k * ROWS, 0])
            which.append(here[one])
        if not which:
            return cls(np.zeros(2, np.int32), np.zeros(1, np.int32))
        starts, things = cell_lists(np.concatenate(firsts), np.concatenate(lasts), (len(lamps) * ROWS, COLUMNS))
        things = np.concatenate(which)[things].astype(np.int32)
        return cls(starts, things if len(things) else np.zeros(1, np.int32))


def _cells(direction, sine) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First and last (row, column) of rectangles of cells, and whose cone each is; cones across the seam have two.

    direction, sine : (n, 3), (n,) axes of cones and the sine of half their angle, 1 for a half space or more
    """
    cosine = np.sqrt(1.0 - sine * sine)
    y, level = direction[:, 1], np.sqrt(np.maximum(1.0 - direction[:, 1] ** 2, 0.0))
    wide = sine >= 1.0
    # the highest direction of a cone is the zenith if the cone contains it
    top = np.where(wide | (y >= cosine), 1.0, y * cosine + level * sine)
    bottom = np.where(wide | (y <= -cosine), -1.0, y * cosine - level * sine)
    rows = np.stack([(bottom + 1.0) * 0.5 * ROWS - _MARGIN, (top + 1.0) * 0.5 * ROWS + _MARGIN], axis=1)
    rows = np.clip(np.floor(rows).astype(np.int64), 0, ROWS - 1)
    around = wide | (level <= sine * 1.0001)
    ratio = np.where(around, 0.0, sine / np.maximum(level, 1e-30))
    half = arctan2(ratio, np.sqrt(np.maximum(1.0 - ratio * ratio, 0.0))) + _MARGIN
    angle = arctan2(direction[:, 2], direction[:, 0])
    low, high = (_quarters(angle + sign * half) for sign in (-1.0, 1.0))
    columns = np.stack([np.floor(low * COLUMNS / 4.0), np.floor(high * COLUMNS / 4.0)], axis=1).astype(np.int64)
    columns = np.clip(columns, 0, COLUMNS - 1)
    columns[around] = (0, COLUMNS - 1)
    seam = np.flatnonzero(columns[:, 0] > columns[:, 1])
    one = np.concatenate([np.arange(len(y)), seam])
    first, last = np.stack([rows[:, 0], columns[:, 0]], axis=1), np.stack([rows[:, 1], columns[:, 1]], axis=1)
    again_first, again_last = first[seam].copy(), last[seam].copy()
    again_first[:, 1] = 0
    last[seam, 1] = COLUMNS - 1
    return np.concatenate([first, again_first]), np.concatenate([last, again_last]), one


def _quarters(angle) -> np.ndarray:
    return quarter_angle(cos(angle), sin(angle))
