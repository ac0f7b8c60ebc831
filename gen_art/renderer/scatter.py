"""Small sprites that only add light: straight into the film, without lists.

The particles are cut into two halves, whatever the number of threads; one adds to the film, the other to a film beside
it, which is added in the end. Pixels are vectors of four, so that a pixel is read, added to and written as one.
"""

import numpy as np

from gen_art.renderer.shade import LANES
from gen_art.renderer.sprite import BLUE, GREEN, POINT, REACH, RED, X, Y, profile
from gen_art.runtime import kernel, ti

__all__ = ["FEW", "LARGEST", "scatter"]

LARGEST = 4.0  # pixels of reach of a disc that is drawn here
PARTS = 2
TAPS = 10  # pixels that such a disc may touch along one side; `steps` below counts them
FEW = 32768  # for no more particles a second film is not worth its adding: they are drawn as any other sprites

PIXEL = ti.types.vector(4, ti.f32)
F1, F2, FILM = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(PIXEL, 1)


@ti.func
def _range(n, part):
    """The tiles of a part: the first, and the one after the last."""
    tiles = (n + LANES - 1) // LANES
    return tiles // PARTS * part, ti.select(part + 1 < PARTS, tiles // PARTS * (part + 1), tiles)


@ti.kernel
def _points(C: F2, n: ti.i32, films: FILM, pixels: ti.i32, stride: ti.i32, width: ti.i32, rows: ti.i32):
    """Bilinear dots: pixel centres within a pixel of the point get (1 - |dx|) (1 - |dy|) of its light."""
    ti.loop_config(block_dim=1)
    for part in range(PARTS):
        w, h = ti.cast(width, ti.f32), ti.cast(rows, ti.f32)
        begin, end = _range(n, part)
        for tile in range(begin, end):
            place = ti.Vector([0] * LANES)
            a, b = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
            c, d = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
            for j in range(LANES):
                i = tile * LANES + j
                u, v = C[X, i] - 0.5, C[Y, i] - 0.5
                x, y = ti.min(ti.max(ti.floor(u), 0.0), w - 1.0), ti.min(ti.max(ti.floor(v), 0.0), h - 1.0)
                here = (C[REACH, i] == 0.0) & (i < n)
                u, v = u - x, v - y  # what lies beyond the border weighs nothing
                left, right = ti.max(1.0 - abs(u), 0.0), ti.select(x + 1.0 < w, ti.max(1.0 - abs(u - 1.0), 0.0), 0.0)
                top, low = ti.max(1.0 - abs(v), 0.0), ti.select(y + 1.0 < h, ti.max(1.0 - abs(v - 1.0), 0.0), 0.0)
                place[j] = ti.select(here, part * pixels + ti.cast(y, ti.i32) * stride + ti.cast(x, ti.i32), -1)
                a[j], b[j], c[j], d[j] = left * top, right * top, left * low, right * low
            for j in range(LANES):
                i, o = tile * LANES + j, place[j]
                if o >= 0:
                    light = PIXEL(C[RED, i], C[GREEN, i], C[BLUE, i], 0.0)
                    films[o] = films[o] + light * a[j]
                    films[o + 1] = films[o + 1] + light * b[j]
                    films[o + stride] = films[o + stride] + light * c[j]
                    films[o + stride + 1] = films[o + stride + 1] + light * d[j]


@ti.kernel
def _discs(C: F2, n: ti.i32, films: FILM, pixels: ti.i32, stride: ti.i32, width: ti.i32, rows: ti.i32):
    """Soft discs of a reach of LARGEST at most, each by the weights of its columns and its rows."""
    ti.loop_config(block_dim=1)
    for part in range(PARTS):
        begin, end = _range(n, part)
        for tile in range(begin, end):
            left, top, taps = ti.Vector([0] * LANES), ti.Vector([0] * LANES), ti.Vector([0] * LANES)
            x, y, inverse = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
            sum_x, sum_y = ti.Vector([0.0] * LANES), ti.Vector([0.0] * LANES)
            # k, kept from the compiler: it takes a pixel as one vector where it cannot split it into four running offsets
            steps = ti.Vector([0, 1, 2, 3, 4, 5, 6, 7, 8, 9])
            across, down = ti.Vector([0.0] * (TAPS * LANES)), ti.Vector([0.0] * (TAPS * LANES))
            for j in range(LANES):
                i = tile * LANES + j
                here = (C[REACH, i] > 0.0) & (C[REACH, i] <= LARGEST) & (i < n)
                reach = ti.select(here, C[REACH, i], 1.0)
                left[j], top[j] = ti.cast(ti.floor(C[X, i] - reach), ti.i32), ti.cast(ti.floor(C[Y, i] - reach), ti.i32)
                x[j], y[j] = C[X, i] - 0.5 - ti.cast(left[j], ti.f32), C[Y, i] - 0.5 - ti.cast(top[j], ti.f32)
                inverse[j] = 1.0 / reach
                taps[j] = ti.select(here, ti.cast(ti.ceil(2.0 * reach), ti.i32) + 1, 0)
            for t in range(TAPS):
                for j in range(LANES):
                    u = profile((ti.cast(t, ti.f32) - x[j]) * inverse[j])
                    v = profile((ti.cast(t, ti.f32) - y[j]) * inverse[j])
                    across[t * LANES + j], down[t * LANES + j] = u, v
                    sum_x[j], sum_y[j] = sum_x[j] + u, sum_y[j] + v
            for j in range(LANES):
                i = tile * LANES + j
                light = PIXEL(C[RED, i], C[GREEN, i], C[BLUE, i], 0.0) * (1.0 / (sum_x[j] * sum_y[j]))
                first, last = ti.max(-left[j], 0), ti.min(taps[j], width - left[j])
                for t in range(ti.max(-top[j], 0), ti.min(taps[j], rows - top[j])):
                    row = light * down[t * LANES + j]
                    o = part * pixels + (top[j] + t) * stride + left[j]
                    for k in range(first, last):
                        at = o + steps[k]
                        films[at] = films[at] + row * across[k * LANES + j]


@ti.kernel
def _merge(films: F1, rows: ti.i32, length: ti.i32, second: ti.i32):
    """Add the second film to the first and clear it, row by row."""
    ti.loop_config(block_dim=8)
    for row in range(rows):
        for s in range(length // 16):
            o = row * length + s * 16
            both = ti.Vector([0.0] * 16)
            for j in range(16):
                both[j] = films[o + j] + films[second + o + j]
            for j in range(16):
                films[o + j] = both[j]
            for j in range(16):
                films[second + o + j] = 0.0


points, discs, merge = kernel(_points), kernel(_discs), kernel(_merge)


def scatter(columns: np.ndarray, n: int, kind: int, film) -> None:
    """Add the points, or the discs of a reach up to LARGEST, among the first n of these columns (11, ...) to a film."""
    draw = points if kind == POINT else discs
    pixels = len(film.buffer) // 4
    draw(columns, n, film.both.reshape(-1, 4), pixels, film.stride // 4, film.width, film.height)
    merge(film.both, film.height, film.stride, len(film.buffer))
