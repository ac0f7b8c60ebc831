"""The light buffer that sprites are drawn into, with smaller buffers for large discs.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import aligned, kernel, ti
from gen_art.errors import MemoryRefused
from gen_art.renderer import picture_splat, tiled_splat, vector_splat
from gen_art.renderer.coarse_framebuffer import composite
from gen_art.renderer.lanes import LANES
from gen_art.renderer.picture_tiles import BIN
from gen_art.renderer.sprite import COVERED_DISC, DISC, ELLIPSE, LEVEL, PICTURE
from gen_art.renderer.sprite_buffer import Sprites
from gen_art.renderer.surfaces.hidden_sprites import NOTHING_HIDES
from gen_art.renderer.tiled_splat import CHUNKS, kind_bits
from gen_art.renderer.vector_splat import VECTOR_KINDS

__all__ = ["FrameBuffer", "splat"]

# Where sprites hide each other, the order of drawing is cut into slices; in each slice the coarse framebuffers are drawn first.
SLICES = 8
DISCS, PICTURES = frozenset({DISC, COVERED_DISC}), frozenset({PICTURE})
OF_LEVELS = frozenset({DISC, ELLIPSE})  # the kinds that are drawn into coarse framebuffers where they are large
PARALLEL_CLEAR = 2**24  # bytes of a framebuffer from which several threads clear it faster than one
WIDE, CLEAR_PARTS = 16, 64  # floats of a vector; parts that threads clear
FLOATS = ti.types.ndarray(ti.types.vector(WIDE, ti.f32), 1)


@ti.kernel
def _clear(framebuffer: FLOATS):
    """Zeros written by vectors stay in the caches, where drawing needs them; NumPy's fill of a large array bypasses them."""
    ti.loop_config(block_dim=1)
    for part in range(CLEAR_PARTS):
        size, zero = (framebuffer.shape[0] + CLEAR_PARTS - 1) // CLEAR_PARTS, ti.Vector([0.0] * WIDE)
        for i in range(part * size, ti.min((part + 1) * size, framebuffer.shape[0])):
            framebuffer[i] = zero


_clear_kernel = kernel(_clear, vectors=True)


class FrameBuffer:
    """A float32 buffer of linear premultiplied RGBA, (height, width, 4), padded to whole bins at the right and below."""

    def __init__(self, size: tuple[int, int]):
        self.width, self.height = size
        self.across, self.down = -(-self.width // BIN), -(-self.height // BIN)
        self.stride = 4 * BIN * self.across
        self.buffer = aligned(self.down * BIN * self.stride, np.float32)
        self._bin_entries, self._tile_masks = np.zeros(0, np.int32), np.zeros(0, np.int32)
        self._half: FrameBuffer | None = None

    @property
    def pixels(self) -> np.ndarray:
        """The picture, (height, width, 4): a view."""
        return self.buffer.reshape(-1, self.stride // 4, 4)[: self.height, : self.width]

    @property
    def half(self) -> "FrameBuffer":
        """The framebuffer of half the size, for large discs."""
        if self._half is None:
            self._half = FrameBuffer(((self.width + 1) // 2, (self.height + 1) // 2))
        return self._half

    def clear(self) -> None:
        if self.buffer.nbytes < PARALLEL_CLEAR:
            self.buffer.view(np.uint8).fill(0)  # as bytes: faster than with floats
        else:
            _clear_kernel(self.buffer.reshape(-1, WIDE))

    def draw(self, sprites: Sprites, order: np.ndarray, level: int, kinds: frozenset) -> np.ndarray:
        """Draw those of the sprites that belong to this framebuffer's level; returns which bins they touch, (down, across) bool.

        kinds : the kinds of the sprites. Bins of VECTOR_KINDS alone, or of images alone, have kernels of their own
        Raises MemoryRefused when the sprites touch 2^31 bins or more in all.
        """
        if level:
            kinds = kinds & OF_LEVELS
        if not sprites.layered and kinds & VECTOR_KINDS and kinds - VECTOR_KINDS:  # light is added in any order
            return self._draw(sprites, order, level, kinds & VECTOR_KINDS) | self._draw(
                sprites, order, level, kinds - VECTOR_KINDS
            )
        return self._draw(sprites, order, level, kinds)

    def _draw(self, sprites: Sprites, order: np.ndarray, level: int, kinds: frozenset) -> np.ndarray:
        n, bins, listed = len(order), self.across * self.down, kind_bits(kinds)
        chunk = -(-n // CHUNKS)
        counts, kinds_there = (np.zeros((CHUNKS, bins), np.int32) for _ in range(2))
        tiled_splat.count_bin_entries(sprites.headers, order, n, level, listed, chunk, self.across, counts, kinds_there)
        bin_counts = counts.T.reshape(-1)
        ends = np.cumsum(bin_counts, dtype=np.int64)
        total = int(ends[-1])
        touched = counts.any(axis=0)
        if total == 0:
            return touched.reshape(self.down, self.across)
        if total >= 2**31:
            raise MemoryRefused(
                f"one picture would need {total} sprite pieces, more than 2^31: make sprites or picture smaller"
            )
        starts = np.ascontiguousarray((ends - bin_counts).astype(np.int32).reshape(bins, CHUNKS).T)
        bounds = np.append(starts[0], total).astype(np.int32)
        if total > len(self._bin_entries):
            self._bin_entries, self._tile_masks = (np.zeros(total * 5 // 4, np.int32) for _ in range(2))
        entries, tile_masks = self._bin_entries, self._tile_masks
        tiled_splat.list_bin_entries(
            sprites.headers, order, n, level, listed, chunk, self.across, starts, entries, tile_masks
        )
        firsts, there = bounds[:-1].copy(), np.bitwise_or.reduce(kinds_there, axis=0)
        of_vectors, of_pictures = (touched & (there & ~kind_bits(alone) == 0) for alone in (VECTOR_KINDS, PICTURES))
        of_others = touched & ~of_vectors & ~of_pictures
        surfaces_hide = sprites.hidden_by is not NOTHING_HIDES
        if of_vectors.any():
            drawn = kinds & VECTOR_KINDS
            # of discs the kind says whether surfaces hide a part; smaller framebuffers hold no such sprites
            partly_hidden = surfaces_hide and level == 0 and drawn != {DISC}
            discs = frozenset({DISC} if drawn & DISCS else ())
            vector_splat.draw_kernel(drawn - DISCS | discs, partly_hidden)(
                sprites.rows, sprites.headers, entries, tile_masks, firsts, np.where(of_vectors, bounds[1:], firsts), self.across,
                bins, self.buffer.reshape(-1, LANES), self.stride // LANES, sprites.depths, sprites.hidden_by.depths,
                sprites.hidden_by.tiles,
            )  # fmt: skip
        if of_pictures.any():
            picture_splat.draw_pictures(
                sprites.rows, sprites.texels, sprites.headers, entries, firsts, np.where(of_pictures, bounds[1:], firsts),
                self.across, bins, self.buffer.reshape(-1, 4), self.stride // 4, sprites.depths, sprites.hidden_by.depths,
            )  # fmt: skip
        if of_others.any():
            tiled_splat.draw_kernel(kinds, surfaces_hide)(
                sprites.rows, sprites.texels, sprites.headers, entries, tile_masks, firsts,
                np.where(of_others, bounds[1:], firsts), self.across, bins, self.buffer, self.stride, sprites.depths,
                sprites.hidden_by.depths,
            )  # fmt: skip
        return touched.reshape(self.down, self.across)

    def composite(self, coarse: "FrameBuffer", touched: np.ndarray, over: bool) -> np.ndarray:
        """Composite a framebuffer of half the size over or under this one, where it was touched.

        touched : (down, across) bool, the bins of `coarse` that hold light
        over : whether `coarse` goes over this one
        Returns the bins of this framebuffer that changed, in the same form.
        """
        reached = np.zeros((coarse.down + 2, coarse.across + 2), bool)
        for dy in range(3):  # bilinear weights reach one pixel into the next bin
            for dx in range(3):
                reached[dy : dy + coarse.down, dx : dx + coarse.across] |= touched
        changed = reached[1:-1, 1:-1].repeat(2, axis=0).repeat(2, axis=1)[: self.down, : self.across]
        changed_bins = np.flatnonzero(changed).astype(np.int32)
        if len(changed_bins):
            composite(
                coarse.buffer.reshape(-1, 4), coarse.width, coarse.height, coarse.stride // 4, self.buffer.reshape(-1, 4),
                self.stride // 4, self.across, changed_bins, len(changed_bins), int(over),
            )  # fmt: skip
        return changed


def splat(sprites: Sprites, framebuffer: FrameBuffer) -> None:
    """Draw the sprites into the framebuffer, over what it holds."""
    kinds = sprites.kinds
    if not kinds:
        return
    order = sprites.order()
    coarsest = int(sprites.headers[: sprites.count, LEVEL].max())
    slices = SLICES if coarsest and sprites.layered else 1
    for part in np.array_split(order, slices):
        if not coarsest:
            framebuffer.draw(sprites, part, 0, kinds)
            continue
        levels = sprites.headers[part, LEVEL]
        by_level = [part[levels == level] for level in range(coarsest + 1)]
        _draw_coarse(sprites, by_level, framebuffer, kinds)
        framebuffer.draw(sprites, by_level[0], 0, kinds)


def _draw_coarse(sprites: Sprites, by_level: list[np.ndarray], framebuffer: FrameBuffer, kinds: frozenset) -> None:
    """Draw the sprites of levels 1 and up, each level composited under the next finer one and level 1 over all.

    by_level : of each level, the order of its sprites
    """
    coarsest = len(by_level) - 1
    framebuffers = [framebuffer]
    for _ in range(coarsest):
        framebuffers.append(framebuffers[-1].half)
        framebuffers[-1].clear()
    coarser_bins: np.ndarray | None = None
    for level in range(coarsest, 0, -1):
        touched = framebuffers[level].draw(sprites, by_level[level], level, kinds)
        if coarser_bins is not None:
            touched = touched | framebuffers[level].composite(framebuffers[level + 1], coarser_bins, over=False)
        coarser_bins = touched
    assert coarser_bins is not None  # coarsest is at least 1
    framebuffer.composite(framebuffers[1], coarser_bins, over=True)
