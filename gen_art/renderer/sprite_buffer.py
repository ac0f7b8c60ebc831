"""The sprites of one picture: their storage, and the order in which they are drawn."""

import math

import numpy as np

from gen_art.backend.runtime import aligned
from gen_art.renderer.elliptic_splat import write_ellipses
from gen_art.renderer.sprite import BOTTOM, KIND, SPRITE_FLOATS, SPRITE_INTS, TOP
from gen_art.renderer.sprite_image import NO_TEXELS, texels, write_image_sprites
from gen_art.renderer.sprite_rows import write_sprites
from gen_art.renderer.surfaces.hidden_sprites import NOTHING_HIDES

__all__ = ["Sprites", "streak_ends"]


class Sprites:
    """Storage for the sprites of one picture, reused from frame to frame; the first `count` of each array are in use.

    rows : (capacity, 16) float32
    headers : (capacity, 6) int16
    depths : (capacity,) float32
    texels : (n, 4) float32, the mipmap chains of all images, which stay from picture to picture
    layered : whether any sprite hides what is behind it
    hidden_by : SurfaceDepths of the surfaces behind which sprites are hidden
    """

    def __init__(self):
        self._allocate(0)
        self.texels = NO_TEXELS
        self._chains: dict[object, int] = {}  # the first texel of each image
        self.clear()

    def _allocate(self, capacity: int) -> None:
        self.rows = np.empty((capacity, SPRITE_FLOATS), np.float32)
        self.headers = np.empty((capacity, SPRITE_INTS), np.int16)
        self.depths = np.empty(capacity, np.float32)

    def clear(self) -> None:
        self.count, self.layered, self.hidden_by = 0, False, NOTHING_HIDES

    def _reserve(self, n: int) -> int:
        """Make room for n more sprites; returns the index of the first."""
        base = self.count
        if base + n > len(self.rows):
            old: tuple[np.ndarray, ...] = (self.rows, self.headers, self.depths)
            self._allocate(max(base + n, len(self.rows) * 3 // 2))
            arrays: tuple[np.ndarray, ...] = (self.rows, self.headers, self.depths)
            for new, previous in zip(arrays, old):
                new[:base] = previous[:base]
        self.count += n
        return base

    def add(self, projected, kinds: int | np.ndarray, framebuffer, ends: np.ndarray, min_footprint: float) -> None:
        """Append a system's particles, except those with a footprint of `min_footprint` pixels or less.

        kinds : of all, or (n,) of each
        ends : (2, n) or (2, 1) float32, a streak's brightness and width at its old end, divided by those at its head
        """
        n, base = projected.count, self._reserve(projected.count)
        if n:
            write_sprites(
                projected.channels, 0, n, self.rows, self.headers, self.depths, base, framebuffer.width, framebuffer.height,
                np.atleast_1d(np.asarray(kinds, np.int32)), ends, min_footprint, *self._hiding,
            )  # fmt: skip

    def add_ellipses(self, projected, ellipses: np.ndarray, framebuffer) -> None:
        """Append a system's discs, stretched to ellipses (3, n) of elliptic_splat.py."""
        n, base = projected.count, self._reserve(projected.count)
        if n:
            write_ellipses(
                projected.channels, ellipses, n, self.rows, self.headers, self.depths, base, framebuffer.width,
                framebuffer.height, *self._hiding,
            )  # fmt: skip

    def add_images(self, projected, picture, roll: float, framebuffer) -> None:
        """Append a system's particles as images.

        picture : the look's entry
        roll : the camera's, radians; upright images are turned by it
        """
        image, _, parts = texels(picture.image.place)
        if picture.image.place not in self._chains:
            self._chains[picture.image.place] = len(self.texels)
            before, self.texels = self.texels, aligned((len(self.texels) + len(image), 4), np.float32)
            self.texels[: len(before)], self.texels[len(before) :] = before, image
        first = self._chains[picture.image.place]
        side = round(((3 * len(image) + 1) / 4) ** 0.5)
        n, base = projected.count, self._reserve(projected.count)
        random_angle = picture.turn == "random"
        angle = (0.0 if random_angle else math.radians(picture.turn)) + (roll if picture.upright else 0.0)
        lo, hi = math.radians(picture.spin.lo), math.radians(picture.spin.hi)
        if n:
            write_image_sprites(
                projected.channels, n, self.texels, first, side, first + len(image) - 1, *parts,
                angle, math.tau if random_angle else 0.0, lo, hi - lo, self.rows, self.headers, self.depths, base,
                framebuffer.width, framebuffer.height, *self._hiding,
            )  # fmt: skip

    @property
    def _hiding(self) -> tuple:
        hidden_by = self.hidden_by
        return hidden_by.bins, hidden_by.tiles, hidden_by.pixel, int(hidden_by.parallel)

    @property
    def kinds(self) -> frozenset:
        """The kinds of the sprites that touch the picture."""
        headers = self.headers[: self.count]
        visible = headers[headers[:, BOTTOM] >= headers[:, TOP], KIND]
        return frozenset(np.flatnonzero(np.bincount(visible, minlength=1)).tolist())

    def order(self) -> np.ndarray:
        """The order of drawing (int32): as listed, or back to front when any sprite hides another. Ties stay in listed order."""
        n = self.count
        if not self.layered:
            return np.arange(n, dtype=np.int32)
        visible = np.flatnonzero(self.headers[:n, BOTTOM] >= self.headers[:n, TOP]).astype(np.int32)
        bits = self.depths[visible].view(np.uint32)
        keys = np.where(bits >> 31, bits, ~bits & np.uint32(0x7FFFFFFF))  # ascending keys are descending depths
        order = np.argsort(keys.astype(np.uint16), kind="stable")  # a radix sort, 16 bits at a time
        return visible[order[np.argsort((keys >> 16).astype(np.uint16)[order], kind="stable")]]


def streak_ends(tail: float, taper: float) -> np.ndarray:
    """(2, 1): the brightness and the width of all streaks at their old ends, divided by those at their heads."""
    return np.array([[tail], [taper]], np.float32)
