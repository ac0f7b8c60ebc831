"""Sprites and the film they are drawn into: storage, the order of drawing, and films of smaller sizes for large discs."""

import numpy as np

from gen_art.errors import MemoryRefused
from gen_art.renderer.splat import BIN, CHUNKS, SLICES, count, draw, lay, list_bins
from gen_art.renderer.sprite import COLUMNS, DEPTH, FIRST, LAST, LEVEL

__all__ = ["Film", "Sprites", "splat"]


class Sprites:
    """Rows of sprites for one picture, reused from frame to frame: `rows` (capacity, 21) float32, `count` in use."""

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
    """A float32 buffer of linear premultiplied RGBA, (height, width, 4), padded to whole bins at the right and below."""

    def __init__(self, size: tuple[int, int]):
        self.width, self.height = size
        self.across, self.down = -(-self.width // BIN), -(-self.height // BIN)
        self.stride = 4 * BIN * self.across
        self.buffer = np.zeros(self.down * BIN * self.stride, np.float32)
        self._listed, self._touched = np.zeros(0, np.int32), np.zeros(0, np.int32)
        self._half: Film | None = None

    @property
    def pixels(self) -> np.ndarray:
        """The picture, (height, width, 4): a view."""
        return self.buffer.reshape(-1, self.stride // 4, 4)[: self.height, : self.width]

    @property
    def half(self) -> "Film":
        """The film of half the size, for large discs."""
        if self._half is None:
            self._half = Film(((self.width + 1) // 2, (self.height + 1) // 2))
        return self._half

    def clear(self):
        self.buffer.fill(0.0)

    def draw(self, sprites: Sprites, order: np.ndarray, level: int) -> np.ndarray:
        """Draw those of the sprites that are of this film's level; gives which bins they touch, (down, across) bool."""
        n, bins = len(order), self.across * self.down
        chunk = -(-n // CHUNKS)
        counts = np.zeros((CHUNKS, bins), np.int32)
        count(sprites.rows, order, n, float(level), chunk, self.across, counts)
        by_bin = counts.T.reshape(-1)
        ends = np.cumsum(by_bin, dtype=np.int64)
        total = int(ends[-1])
        touched = counts.any(axis=0).reshape(self.down, self.across)
        if total == 0:
            return touched
        if total >= 2**31:
            raise MemoryRefused(
                f"one picture would need {total} sprite pieces, more than 2^31: make sprites or picture smaller"
            )
        starts = np.ascontiguousarray((ends - by_bin).astype(np.int32).reshape(bins, CHUNKS).T)
        bounds = np.append(starts[0], total).astype(np.int32)
        if total > len(self._listed):
            self._listed, self._touched = (np.zeros(total * 5 // 4, np.int32) for _ in range(2))
        list_bins(sprites.rows, order, n, float(level), chunk, self.across, starts, self._listed, self._touched)
        draw(sprites.rows, self._listed, self._touched, bounds, self.across, bins, self.buffer, self.stride)
        return touched

    def lay(self, coarse: "Film", touched: np.ndarray, over: bool) -> np.ndarray:
        """Lay a film of half the size over or under this one, where it was touched; gives this film's bins it changed."""
        wide = np.zeros((coarse.down + 2, coarse.across + 2), bool)
        for dy in range(3):  # bilinear weights reach one pixel into the next bin
            for dx in range(3):
                wide[dy : dy + coarse.down, dx : dx + coarse.across] |= touched
        mine = wide[1:-1, 1:-1].repeat(2, axis=0).repeat(2, axis=1)[: self.down, : self.across]
        busy = np.flatnonzero(mine).astype(np.int32)
        if len(busy):
            lay(
                coarse.buffer, coarse.width, coarse.height, coarse.stride, self.buffer, self.stride, self.across, busy,
                len(busy), int(over),
            )  # fmt: skip
        return mine


def splat(sprites: Sprites, film: Film) -> None:
    """Draw the sprites into the film, over what it holds."""
    if sprites.count == 0:
        return
    order = sprites.order()
    coarsest = int(sprites.rows[: sprites.count, LEVEL].max())
    slices = SLICES if coarsest and sprites.layered else 1
    for part in np.array_split(order, slices):
        if coarsest:
            _draw_coarse(sprites, part, film, coarsest)
        film.draw(sprites, part, 0)


def _draw_coarse(sprites: Sprites, order: np.ndarray, film: Film, coarsest: int) -> None:
    """Levels 1 to `coarsest` of these sprites, each laid under the next finer one, and all over the film."""
    films = [film]
    for _ in range(coarsest):
        films.append(films[-1].half)
        films[-1].clear()
    below = None
    for level in range(coarsest, 0, -1):
        touched = films[level].draw(sprites, order, level)
        if below is not None:
            touched = touched | films[level].lay(films[level + 1], below, over=False)
        below = touched
    film.lay(films[1], below, over=True)
