"""Sprites into the film: points, soft discs and streaks, added or laid over each other, in the same order every time.

A sprite is a row of 16 float32 (`Sprites.rows`); the film is cut into bands of rows, each sprite is listed in the bands
it touches, in the order of drawing (counting sort over fixed chunks), and a band is drawn by one thread. The result
does not depend on the number of threads, and no sum is atomic.

A sprite's light is spread by weights that are divided by their sum over its whole footprint, so every sprite gives
exactly its energy wherever its middle lies between pixels; only the frame's border cuts.

Kernel of a disc, per axis: g(t) = (1 - 0.3125 t^2)^8 (1 - t^2)^2, t = distance / reach, reach = 3 standard deviations:
a Gaussian that ends softly. A streak is a disc swept along a segment: its profile along the longer axis is the
integral of the kernel between the ends, across it the kernel about the segment, with the covariance of the swept disc.
"""

import numpy as np

from gen_art.runtime import kernel, ti

__all__ = ["AREA", "BAND", "Film", "Sprites", "profile_integral", "splat"]

# columns of a sprite's row
X, Y, REACH, DX, DY, RED, GREEN, BLUE, ALPHA, DEPTH, FIRST, LAST, NORM_X, NORM_Y, TAIL, TAPER = range(16)
COLUMNS = 16
BAND = 16  # rows of film in a band
CHUNKS = 32  # fixed: the order of drawing must not depend on the number of threads
LANE = 32  # floats of film handled at a time (8 pixels)
SMALLEST = 1.5  # pixels of reach: half a pixel of standard deviation, or the kernel would alias
WIDE = 64.0  # pixels of reach from which the kernel's sum is its integral (to 1e-6)


def profile_integral() -> float:
    """The integral of g over -1..1."""
    t = (np.arange(200_000) + 0.5) / 200_000
    return float(2.0 * np.mean((1.0 - 0.3125 * t * t) ** 8 * (1.0 - t * t) ** 2))


LENGTH = profile_integral()
AREA = LENGTH * LENGTH  # area under a disc of reach 1 and height 1

F1, F2, I1, I2 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.i32, 1), (ti.i32, 2)))


@ti.func
def profile(t):
    """g(t), 0 outside -1..1."""
    s = ti.min(t * t, 1.0)
    a = 1.0 - 0.3125 * s
    a2 = a * a
    a4 = a2 * a2
    b = 1.0 - s
    return a4 * a4 * (b * b)


@ti.func
def line_sum(middle, reach):
    """The sum of g over all pixel centres of one axis."""
    total = LENGTH * reach
    if reach < WIDE:
        total = 0.0
        first = ti.cast(ti.floor(middle - reach), ti.i32)
        last = ti.cast(ti.floor(middle + reach), ti.i32)
        for k in range(first, last + 1):
            total += profile((ti.cast(k, ti.f32) + 0.5 - middle) / reach)
    return total


@ti.func
def _step(t):
    """A smooth step from 0 at t = -1 to 1 at t = 1, with the variance of a kernel of reach 1.134."""
    u = ti.min(ti.max(0.5 * t + 0.5, 0.0), 1.0)
    return u * u * u * (u * (6.0 * u - 15.0) + 10.0)


@ti.func
def along(a, span, reach, tail):
    """A streak's brightness at distance `a` from its old end along the longer axis (span > 0: its length there)."""
    value = 0.0
    if span < reach * 0.3333333:
        value = profile((a - 0.5 * span) / ti.sqrt(reach * reach + 0.75 * span * span))
    else:
        soft = reach * 0.8819171
        value = ti.max(_step(a / soft) - _step((a - span) / soft), 0.0)
    return value * (tail + (1.0 - tail) * ti.min(ti.max(a / span, 0.0), 1.0))


@ti.func
def streak_margin(span, reach):
    """How far a streak's light goes beyond its ends along the longer axis."""
    margin = reach
    if span < reach * 0.3333333:
        margin = ti.sqrt(reach * reach + 0.75 * span * span)
    return margin


@ti.func
def streak_slope(dm, dn, reach):
    """Slope of the middle line and reach across, for a streak dm along its longer axis and dn across."""
    var = reach * reach / 9.0
    xx, xy, yy = var + dm * dm / 12.0, dm * dn / 12.0, var + dn * dn / 12.0
    return xy / xx, 3.0 * ti.sqrt(ti.max(yy - xy * xy / xx, 0.0))


@ti.func
def finish(P: ti.template(), i, rows):
    """Fill in a sprite's first and last row of film and its norms; x, y, reach, dx, dy, tail, taper must be there."""
    x, y, reach, dx, dy = P[i, X], P[i, Y], P[i, REACH], P[i, DX], P[i, DY]
    low = ti.min(y, y - dy)
    high = ti.max(y, y - dy)
    if reach <= 0.0:
        low, high = y - 0.5, y + 0.5
    elif ti.max(abs(dx), abs(dy)) < 1e-3:
        low, high = low - reach, high + reach
        P[i, DX], P[i, DY] = 0.0, 0.0
        P[i, NORM_X], P[i, NORM_Y] = 1.0 / line_sum(x, reach), 1.0 / line_sum(y, reach)
    else:
        dm, dn, end = dx, dy, x
        if abs(dy) > abs(dx):
            dm, dn, end = dy, dx, y
        span = abs(dm)
        sign = dm / span
        margin = streak_margin(span, reach)
        slope, across = streak_slope(dm, dn, reach)
        start = end - dm
        first = ti.cast(ti.floor(ti.min(start, end) - margin), ti.i32)
        last = ti.cast(ti.floor(ti.max(start, end) + margin), ti.i32)
        total = 0.0
        for k in range(first, last + 1):
            total += along((ti.cast(k, ti.f32) + 0.5 - start) * sign, span, reach, P[i, TAIL])
        P[i, NORM_X] = 1.0 / ti.max(total, 1e-30)
        if abs(dy) > abs(dx):
            low, high = low - margin, high + margin
        else:
            swing = ti.max(across + abs(slope) * margin, reach) + 1.0
            low, high = low - swing, high + swing
    first_row = ti.cast(ti.floor(ti.max(low, 0.0)), ti.i32)
    last_row = ti.cast(ti.floor(ti.min(high, ti.cast(rows, ti.f32) - 0.5)), ti.i32)
    if reach <= 0.0:
        first_row = ti.cast(ti.floor(ti.max(low, 0.0)), ti.i32)
        last_row = ti.min(ti.cast(ti.floor(high), ti.i32), rows - 1)
    P[i, FIRST], P[i, LAST] = ti.cast(first_row, ti.f32), ti.cast(last_row, ti.f32)


@ti.kernel
def _finish_all(P: F2, n: ti.i32, rows: ti.i32):
    ti.loop_config(block_dim=1)
    for b in range((n + 4095) // 4096):
        for i in range(b * 4096, ti.min((b + 1) * 4096, n)):
            finish(P, i, rows)


@ti.kernel
def _count(P: F2, order: I1, n: ti.i32, chunk: ti.i32, bands: ti.i32, counts: I2):
    ti.loop_config(block_dim=1)
    for c in range(CHUNKS):
        for b in range(bands):
            counts[b, c] = 0
        for j in range(c * chunk, ti.min((c + 1) * chunk, n)):
            i = order[j]
            if P[i, LAST] >= P[i, FIRST]:
                for b in range(ti.cast(P[i, FIRST], ti.i32) // BAND, ti.cast(P[i, LAST], ti.i32) // BAND + 1):
                    counts[b, c] = counts[b, c] + 1


@ti.kernel
def _list(P: F2, order: I1, n: ti.i32, chunk: ti.i32, starts: I2, listed: I1):
    ti.loop_config(block_dim=1)
    for c in range(CHUNKS):
        for j in range(c * chunk, ti.min((c + 1) * chunk, n)):
            i = order[j]
            if P[i, LAST] >= P[i, FIRST]:
                for b in range(ti.cast(P[i, FIRST], ti.i32) // BAND, ti.cast(P[i, LAST], ti.i32) // BAND + 1):
                    listed[starts[b, c]] = i
                    starts[b, c] = starts[b, c] + 1


@ti.func
def _over(film: ti.template(), o, w, r, g, b, a):
    keep = 1.0 - a * w
    film[o] = film[o] * keep + r * w
    film[o + 1] = film[o + 1] * keep + g * w
    film[o + 2] = film[o + 2] * keep + b * w
    film[o + 3] = film[o + 3] * keep + a * w


@ti.func
def _point(P: ti.template(), i, film: ti.template(), stride, width, top, bottom):
    x, y = P[i, X] - 0.5, P[i, Y] - 0.5
    x0, y0 = ti.floor(x), ti.floor(y)
    for v in range(2):
        row = ti.cast(y0, ti.i32) + v
        if row >= top and row < bottom:
            wy = ti.select(v == 1, y - y0, 1.0 - (y - y0))
            for u in range(2):
                column = ti.cast(x0, ti.i32) + u
                if column >= 0 and column < width:
                    wx = ti.select(u == 1, x - x0, 1.0 - (x - x0))
                    _over(film, row * stride + column * 4, wx * wy, P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA])


@ti.func
def _disc(P: ti.template(), i, film: ti.template(), stride, width, top, bottom, weights: ti.template(), band):
    x, y, reach = P[i, X], P[i, Y], P[i, REACH]
    left = ti.max(ti.cast(ti.floor(x - reach), ti.i32), 0)
    right = ti.min(ti.cast(ti.floor(x + reach), ti.i32), width - 1)
    lanes = (right - left) // 8 + 1
    base = band * stride
    for k in range(lanes * 8):
        w = 0.0
        if left + k <= right:
            w = profile((ti.cast(left + k, ti.f32) + 0.5 - x) / reach) * P[i, NORM_X]
        weights[base + 4 * k], weights[base + 4 * k + 1] = w, w
        weights[base + 4 * k + 2], weights[base + 4 * k + 3] = w, w
    colour = ti.Vector([0.0] * LANE)
    for j in range(LANE // 4):
        colour[4 * j], colour[4 * j + 1] = P[i, RED], P[i, GREEN]
        colour[4 * j + 2], colour[4 * j + 3] = P[i, BLUE], P[i, ALPHA]
    alpha = P[i, ALPHA]
    for row in range(top, bottom):
        wy = profile((ti.cast(row, ti.f32) + 0.5 - y) / reach) * P[i, NORM_Y]
        for lane in range(lanes):
            o = row * stride + (left + lane * 8) * 4
            m = base + lane * LANE
            mixed = ti.Vector([0.0] * LANE)
            for j in range(LANE):
                w = weights[m + j] * wy
                mixed[j] = film[o + j] * (1.0 - alpha * w) + colour[j] * w
            for j in range(LANE):
                film[o + j] = mixed[j]


@ti.func
def _streak(P: ti.template(), i, film: ti.template(), stride, width, top, bottom):
    x, y, reach, dx, dy = P[i, X], P[i, Y], P[i, REACH], P[i, DX], P[i, DY]
    upright = abs(dy) > abs(dx)
    dm, dn, end, side = dx, dy, x, y - 0.5 * dy
    low, high, low_n, high_n = 0, width, top, bottom  # the limits along and across
    step_m, step_n = 4, stride
    if upright:
        dm, dn, end, side = dy, dx, y, x - 0.5 * dx
        low, high, low_n, high_n = top, bottom, 0, width
        step_m, step_n = stride, 4
    span = abs(dm)
    sign = dm / span
    margin = streak_margin(span, reach)
    slope, across = streak_slope(dm, dn, reach)
    start = end - dm
    first = ti.max(ti.cast(ti.floor(ti.min(start, end) - margin), ti.i32), low)
    last = ti.min(ti.cast(ti.floor(ti.max(start, end) + margin), ti.i32), high - 1)
    if not upright and abs(slope) > 0.05:  # only the columns whose light reaches this band
        pad = across + 1.0
        a = ((ti.cast(top, ti.f32) - pad) - side) / slope
        b = ((ti.cast(bottom, ti.f32) + pad) - side) / slope
        centre = end - 0.5 * dm
        first = ti.max(first, ti.cast(ti.floor(ti.max(centre + ti.min(a, b), -1.0)), ti.i32))
        last = ti.min(last, ti.cast(ti.floor(ti.min(centre + ti.max(a, b), ti.cast(width, ti.f32))), ti.i32))
    for m in range(first, last + 1):
        c = ti.cast(m, ti.f32) + 0.5
        a = (c - start) * sign
        weight = along(a, span, reach, P[i, TAIL]) * P[i, NORM_X]
        middle = side + slope * (c - (end - 0.5 * dm))
        wide = ti.max(across * (P[i, TAPER] + (1.0 - P[i, TAPER]) * ti.min(ti.max(a / span, 0.0), 1.0)), SMALLEST)
        weight = weight / line_sum(middle, wide)
        first_n = ti.max(ti.cast(ti.floor(middle - wide), ti.i32), low_n)
        last_n = ti.min(ti.cast(ti.floor(middle + wide), ti.i32), high_n - 1)
        for n in range(first_n, last_n + 1):
            w = weight * profile((ti.cast(n, ti.f32) + 0.5 - middle) / wide)
            _over(film, m * step_m + n * step_n, w, P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA])


@ti.kernel
def _draw(
    P: F2, listed: I1, bounds: I1, bands: ti.i32, film: F1, weights: F1, stride: ti.i32, width: ti.i32, rows: ti.i32
):
    ti.loop_config(block_dim=1)
    for band in range(bands):
        for j in range(bounds[band], bounds[band + 1]):
            i = listed[j]
            top = ti.max(band * BAND, ti.cast(P[i, FIRST], ti.i32))
            bottom = ti.min(ti.min(band * BAND + BAND, rows), ti.cast(P[i, LAST], ti.i32) + 1)
            if P[i, REACH] <= 0.0:
                _point(P, i, film, stride, width, top, bottom)
            elif P[i, DX] == 0.0 and P[i, DY] == 0.0:
                _disc(P, i, film, stride, width, top, bottom, weights, band)
            else:
                _streak(P, i, film, stride, width, top, bottom)


finish_all, count, list_bands, draw = (kernel(k) for k in (_finish_all, _count, _list, _draw))


class Sprites:
    """Rows of sprites for one picture, reused from frame to frame: `rows` (capacity, 16) float32, `count` in use."""

    def __init__(self):
        self.rows = np.zeros((0, COLUMNS), np.float32)
        self.count = 0
        self.layered = False  # whether any of them hides what is behind it

    def clear(self):
        self.count, self.layered = 0, False

    def reserve(self, n: int) -> int:
        """Room for n more; gives the index of the first."""
        start, need = self.count, self.count + n
        if need > len(self.rows):
            grown = np.zeros((max(need, len(self.rows) * 3 // 2), COLUMNS), np.float32)
            grown[:start] = self.rows[:start]
            self.rows = grown
        self.count = need
        return start

    def order(self) -> np.ndarray:
        """The order of drawing (int32): as listed, or back to front when something hides; ties in listed order."""
        n = self.count
        if not self.layered or n == 0:
            return np.arange(n, dtype=np.int32)
        depth = self.rows[:n, DEPTH]
        seen = self.rows[:n, LAST] >= self.rows[:n, FIRST]
        if not seen.any():
            return np.arange(n, dtype=np.int32)
        near, far = float(depth[seen].min()), float(depth[seen].max())
        steps = 65535.0 / max(far - near, 1e-30)
        bins = np.where(seen, (far - depth) * np.float32(steps), 0.0).astype(np.uint16)
        return np.argsort(bins, kind="stable").astype(np.int32)


class Film:
    """A float32 buffer of linear premultiplied RGBA, (height, width, 4), with padding at the end of each row."""

    def __init__(self, size: tuple[int, int]):
        self.width, self.height = size
        self.stride = 4 * ((self.width + 7) // 8 * 8 + 8)
        self.buffer = np.zeros(self.height * self.stride, np.float32)
        self.bands = -(-self.height // BAND)
        self._weights = np.zeros(self.bands * self.stride, np.float32)
        self._listed = np.zeros(0, np.int32)

    @property
    def pixels(self) -> np.ndarray:
        """The picture, (height, width, 4): a view."""
        return self.buffer.reshape(self.height, -1)[:, : 4 * self.width].reshape(self.height, self.width, 4)

    def clear(self):
        self.buffer.fill(0.0)


def splat(sprites: Sprites, film: Film) -> None:
    """Draw the sprites into the film, over what it holds."""
    n = sprites.count
    if n == 0:
        return
    order = sprites.order()
    chunk = -(-n // CHUNKS)
    counts = np.zeros((film.bands, CHUNKS), np.int32)
    count(sprites.rows, order, n, chunk, film.bands, counts)
    ends = np.cumsum(counts.reshape(-1), dtype=np.int64)
    total = int(ends[-1])
    if total == 0:
        return
    if total >= 2**31:
        raise MemoryError(f"{total} sprite pieces do not fit in one picture")
    starts = (ends - counts.reshape(-1)).astype(np.int32).reshape(counts.shape)
    bounds = np.append(starts[:, 0], total).astype(np.int32)
    if total > len(film._listed):
        film._listed = np.zeros(total * 5 // 4, np.int32)
    list_bands(sprites.rows, order, n, chunk, starts, film._listed)
    draw(
        sprites.rows, film._listed, bounds, film.bands, film.buffer, film._weights, film.stride, film.width, film.height
    )
