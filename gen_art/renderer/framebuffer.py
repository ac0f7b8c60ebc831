"""Sprites and the film they are drawn into: storage, the order of drawing, and films of smaller sizes for large discs."""

import math

import numpy as np

from gen_art.backend.runtime import aligned, kernel, ti
from gen_art.errors import MemoryRefused
from gen_art.renderer.sprite import FIRST, KIND, LAST, LEVEL, MARKS, ROW, finish
from gen_art.renderer.sprite_image import NO_TEXELS, finish_pictures, texels
from gen_art.renderer.tiled_splat import BIN, CHUNKS, SLICES, count, drawing, lay, list_bins

__all__ = ["FrameBuffer", "Sprites", "splat"]


LARGE = 2**24  # bytes of a film that threads are woken to clear
WIDE, RUNS = 16, 64  # floats of a vector, parts of a film
FLOATS = ti.types.ndarray(ti.types.vector(WIDE, ti.f32), 1)


@ti.kernel
def _clear(film: FLOATS):
    """In the caches, where the light will find it; NumPy's own way is past them."""
    ti.loop_config(block_dim=1)
    for run in range(RUNS):
        part, none = (film.shape[0] + RUNS - 1) // RUNS, ti.Vector([0.0] * WIDE)
        for i in range(run * part, ti.min((run + 1) * part, film.shape[0])):
            film[i] = none


_clear_kernel = kernel(_clear, vectors=True)


class Sprites:
    """Rows of sprites for one picture, reused from frame to frame: `rows` (capacity, 16) float32, `marks` (capacity, 6)
    int16 and `depths` (capacity,) float32, of which `count` are in use; `layered`: whether any hides what is behind it.
    """

    def __init__(self):
        self._allocate(0)
        self.clear()

    def _allocate(self, capacity: int) -> None:
        self.rows = np.empty((capacity, ROW), np.float32)
        self.marks = np.empty((capacity, MARKS), np.int16)
        self.depths = np.empty(capacity, np.float32)

    def clear(self) -> None:
        self.count, self.layered, self.texels = 0, False, NO_TEXELS

    def _reserve(self, n: int) -> int:
        """Room for n more; gives the index of the first."""
        base = self.count
        if base + n > len(self.rows):
            old = self.rows, self.marks, self.depths
            self._allocate(max(base + n, len(self.rows) * 3 // 2))
            for new, before in zip((self.rows, self.marks, self.depths), old):
                new[:base] = before[:base]
        self.count += n
        return base

    def add(self, columns, kind: int, film: "FrameBuffer", tail: float, taper: float, least: float) -> None:
        """Append a system's columns but for what has a reach of `least` pixels or less."""
        n, base = columns.count, self._reserve(columns.count)
        if n:
            finish(
                columns.rows, 0, n, self.rows, self.marks, self.depths, base, film.width, film.height, kind, tail, taper,
                least,
            )  # fmt: skip

    def add_pictures(self, columns, picture, film: "FrameBuffer") -> None:
        """Append a system's columns as images; `picture` as a look has it."""
        image, _ = texels(picture.image.place)
        first = len(self.texels)
        self.texels = np.concatenate([self.texels, image])
        side = round(((3 * len(image) + 1) / 4) ** 0.5)
        n, base = columns.count, self._reserve(columns.count)
        everywhere = picture.turn == "random"
        lo, hi = math.radians(picture.spin.lo), math.radians(picture.spin.hi)
        if n:
            finish_pictures(
                columns.rows, n, self.texels, first, side, 0.0 if everywhere else math.radians(picture.turn),
                math.tau if everywhere else 0.0, lo, hi - lo, self.rows, self.marks, self.depths, base, film.width,
                film.height,
            )  # fmt: skip

    @property
    def kinds(self) -> frozenset:
        """What there is to draw."""
        marks = self.marks[: self.count]
        seen = marks[marks[:, LAST] >= marks[:, FIRST], KIND]
        return frozenset(np.flatnonzero(np.bincount(seen, minlength=1)).tolist())

    def order(self) -> np.ndarray:
        """The order of drawing (int32): as listed, or back to front when something hides; ties in listed order."""
        n = self.count
        if not self.layered:
            return np.arange(n, dtype=np.int32)
        seen = np.flatnonzero(self.marks[:n, LAST] >= self.marks[:n, FIRST]).astype(np.int32)
        bits = self.depths[seen].view(np.uint32)
        far_first = np.where(bits >> 31, bits, ~bits & np.uint32(0x7FFFFFFF))  # floats fall as these whole numbers rise
        order = np.argsort(far_first.astype(np.uint16), kind="stable")  # a radix sort, 16 bits at a time
        return seen[order[np.argsort((far_first >> 16).astype(np.uint16)[order], kind="stable")]]


class FrameBuffer:
    """A float32 buffer of linear premultiplied RGBA, (height, width, 4), padded to whole bins at the right and below."""

    def __init__(self, size: tuple[int, int]):
        self.width, self.height = size
        self.across, self.down = -(-self.width // BIN), -(-self.height // BIN)
        self.stride = 4 * BIN * self.across
        self.buffer = aligned(self.down * BIN * self.stride, np.float32)
        self._listed, self._touched = np.zeros(0, np.int32), np.zeros(0, np.int32)
        self._half: FrameBuffer | None = None

    @property
    def pixels(self) -> np.ndarray:
        """The picture, (height, width, 4): a view."""
        return self.buffer.reshape(-1, self.stride // 4, 4)[: self.height, : self.width]

    @property
    def half(self) -> "FrameBuffer":
        """The film of half the size, for large discs."""
        if self._half is None:
            self._half = FrameBuffer(((self.width + 1) // 2, (self.height + 1) // 2))
        return self._half

    def clear(self) -> None:
        if self.buffer.nbytes < LARGE:
            self.buffer.view(np.uint8).fill(0)  # sooner done than with floats
        else:
            _clear_kernel(self.buffer.reshape(-1, WIDE))

    def draw(self, sprites: Sprites, order: np.ndarray, level: int, kinds: frozenset) -> np.ndarray:
        """Draw those of the sprites that are of this film's level; gives which bins they touch, (down, across) bool."""
        n, bins = len(order), self.across * self.down
        chunk = -(-n // CHUNKS)
        counts = np.zeros((CHUNKS, bins), np.int32)
        count(sprites.marks, order, n, level, chunk, self.across, counts)
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
        list_bins(sprites.marks, order, n, level, chunk, self.across, starts, self._listed, self._touched)
        drawing(kinds)(
            sprites.rows, sprites.texels, sprites.marks, self._listed, self._touched, bounds, self.across, bins, self.buffer,
            self.stride,
        )  # fmt: skip
        return touched

    def lay(self, coarse: "FrameBuffer", touched: np.ndarray, over: bool) -> np.ndarray:
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


def splat(sprites: Sprites, film: FrameBuffer) -> None:
    """Draw the sprites into the film, over what it holds."""
    kinds = sprites.kinds
    if not kinds:
        return
    order = sprites.order()
    coarsest = int(sprites.marks[: sprites.count, LEVEL].max())
    slices = SLICES if coarsest and sprites.layered else 1
    for part in np.array_split(order, slices):
        if coarsest:
            _draw_coarse(sprites, part, film, coarsest, kinds)
        film.draw(sprites, part, 0, kinds)


def _draw_coarse(sprites: Sprites, order: np.ndarray, film: FrameBuffer, coarsest: int, kinds: frozenset) -> None:
    """Levels 1 to `coarsest` of these sprites, each laid under the next finer one, and all over the film."""
    films = [film]
    for _ in range(coarsest):
        films.append(films[-1].half)
        films[-1].clear()
    below = None
    for level in range(coarsest, 0, -1):
        touched = films[level].draw(sprites, order, level, kinds)
        if below is not None:
            touched = touched | films[level].lay(films[level + 1], below, over=False)
        below = touched
    film.lay(films[1], below, over=True)
