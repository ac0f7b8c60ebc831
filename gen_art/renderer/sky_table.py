"""The table in which a sky's light stands, direction by direction, and how it is read.

(ROWS, COLUMNS, 3) of linear light. The first half of the rows is below the horizon, from straight down to the horizon, the second
above it, from the horizon to straight up, so that light may jump at the horizon. With x right, y up, -z away:

    latitude     t = y / (|y| + sqrt(x^2 + z^2)),  -1..1;  the row goes as sqrt(|t|), which makes rows dense at the horizon
    longitude    q = x / (|x| + |z|), continued to 0..4 clockwise from -z over +x; the last column is the first once more

Neither needs more than divisions and roots, which have the same bits on every processor.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.maths.array_functions import arctan2, cos, sin

__all__ = ["COLUMNS", "HALF", "ROWS", "azimuths", "directions_of_table", "elevations", "look_up", "sky_radiance"]

HALF = 160  # rows above the horizon, and below it
ROWS, COLUMNS = 2 * HALF, 4 * 128 + 1


def elevations() -> np.ndarray:
    """(HALF,) rad, 0 to pi/2: the rows above the horizon; those below it have the negatives in reversed order."""
    t = (np.arange(HALF) / (HALF - 1.0)) ** 2
    return arctan2(t, 1.0 - t)


def azimuths() -> np.ndarray:
    """(COLUMNS,) rad, 0 to 2 pi, clockwise from -z seen from above."""
    p = np.arange(COLUMNS) * (4.0 / (COLUMNS - 1))
    quarter = np.minimum(p.astype(np.int64), 3)
    u = p - quarter
    return arctan2(u, 1.0 - u) + quarter * (np.pi / 2)


def directions_of_table() -> np.ndarray:
    """(ROWS, COLUMNS, 3) unit vectors of the entries of a sky's table."""
    upper, around = elevations(), azimuths()
    up = np.concatenate([-upper[::-1], upper])[:, None]
    level = cos(up)
    return np.stack(np.broadcast_arrays(level * sin(around), sin(up), -level * cos(around)), axis=-1)


def _place(x, y, z):
    """Row, column and whether they are below the horizon, of directions of any length."""
    level = np.sqrt(x * x + z * z)
    down = y < 0.0
    t = np.sqrt(np.abs(y) / np.maximum(np.abs(y) + level, 1e-30)) * (HALF - 1)
    row = np.where(down, HALF - 1 - t, HALF + t)
    q = x / np.maximum(np.abs(x) + np.abs(z), 1e-30)
    p = np.where(z > 0.0, 2.0 - q, np.where(x >= 0.0, q, 4.0 + q))
    return row, p * ((COLUMNS - 1) / 4.0), down


def look_up(table: np.ndarray, directions) -> np.ndarray:
    """(n, 3) light of directions (n, 3) of any length but 0, between the entries of a table (ROWS, any columns, 3)."""
    d = np.asarray(directions, np.float64)
    row, column, down = _place(d[:, 0], d[:, 1], d[:, 2])
    column = column * ((table.shape[1] - 1) / (COLUMNS - 1))
    i = np.clip(row.astype(np.int64), np.where(down, 0, HALF), np.where(down, HALF, ROWS) - 2)
    j = np.clip(column.astype(np.int64), 0, table.shape[1] - 2)
    a, b = (row - i)[:, None], (column - j)[:, None]
    upper = table[i, j] + (table[i, j + 1] - table[i, j]) * b
    lower = table[i + 1, j] + (table[i + 1, j + 1] - table[i + 1, j]) * b
    return upper + (lower - upper) * a


@ti.func
def sky_radiance(table: ti.template(), x, y, z):
    """Light (r, g, b) of the sky from the direction (x, y, z), of any length but 0; without the sun's disc and the stars.

    table : the float32 `table` of a SkyDome
    """
    level = ti.sqrt(x * x + z * z)
    t = ti.sqrt(ti.abs(y) / ti.max(ti.abs(y) + level, 1e-30)) * ti.static(HALF - 1.0)
    q = x / ti.max(ti.abs(x) + ti.abs(z), 1e-30)
    p = ti.select(z > 0.0, 2.0 - q, ti.select(x >= 0.0, q, 4.0 + q))
    column = p * (0.25 * ti.cast(table.shape[1] - 1, ti.f32))
    first = ti.select(y < 0.0, 0, HALF)
    row = ti.select(y < 0.0, ti.static(HALF - 1.0) - t, t)  # in its half of the table
    i = ti.min(ti.max(ti.cast(row, ti.i32), 0), HALF - 2)
    j = ti.min(ti.max(ti.cast(column, ti.i32), 0), table.shape[1] - 2)
    a, b = row - ti.cast(i, ti.f32), column - ti.cast(j, ti.f32)
    i += first
    light = ti.Vector([0.0, 0.0, 0.0])
    for c in ti.static(range(3)):
        upper = table[i, j, c] + (table[i, j + 1, c] - table[i, j, c]) * b
        lower = table[i + 1, j, c] + (table[i + 1, j + 1, c] - table[i + 1, j, c]) * b
        light[c] = upper + (lower - upper) * a
    return light
