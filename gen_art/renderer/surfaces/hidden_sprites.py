"""What surfaces hide of the sprites behind them.

A sprite that lies before all surfaces in the parts of the picture that it covers needs no test, and one behind all of them is
left out. The others are tested pixel by pixel while they are drawn. A sprite of radius r counts as r deep: it fades where it
enters a surface, instead of being cut along a line.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.picture_tiles import TILES
from gen_art.renderer.sprite import ALPHA, BLUE, DEPTH, FOOTPRINT, GREEN, HIDDEN, RED, X, Y
from gen_art.renderer.surfaces.hiding import visible_share

__all__ = ["NOTHING_HIDES", "SurfaceDepths", "hide_small_sprites"]


F2, F3 = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.f32, 3)


@dataclass(frozen=True)
class SurfaceDepths:
    """The distances of surfaces along the line of sight.

    depths : (rows, columns, SUBPIXELS)
    bins, tiles : (down, across, 2), the least and the largest of each bin and of each tile of the framebuffer
    pixel : world units of a pixel (orthographic), or per unit of distance (perspective)
    parallel : whether the camera is orthographic
    """

    depths: np.ndarray
    bins: np.ndarray
    tiles: np.ndarray
    pixel: float
    parallel: bool

    @classmethod
    def of(cls, depths: np.ndarray, tiles: np.ndarray, pixel: float, parallel: bool) -> "SurfaceDepths":
        """From what a SurfacePass keeps.

        tiles : (down, across, 2), the least and the largest depth of each tile
        """
        low, high = _by_bins(tiles[..., 0], np.minimum), _by_bins(tiles[..., 1], np.maximum)
        return cls(depths, np.stack([low, high], axis=2), tiles, pixel, parallel)


def _by_bins(values: np.ndarray, reduce) -> np.ndarray:
    """The least or the largest of the tiles of each bin."""
    for axis in (0, 1):
        values = reduce.reduceat(values, np.arange(0, values.shape[axis], TILES), axis=axis)
    return values


NOTHING_HIDES = SurfaceDepths(np.zeros((1, 1, 1), np.float32), *(np.zeros((0, 1, 2), np.float32),) * 2, 1.0, False)


@ti.kernel
def _hide(C: F2, n: ti.i32, depths: F3, most: ti.f32):
    """Dim each particle whose footprint is at most `most` pixels by what surfaces hide of its pixel."""
    ti.loop_config(block_dim=1)
    for block in range((n + 2047) // 2048):
        for i in range(block * 2048, ti.min((block + 1) * 2048, n)):
            column, row = ti.cast(ti.floor(C[X, i]), ti.i32), ti.cast(ti.floor(C[Y, i]), ti.i32)
            inside = column >= 0 and row >= 0 and column < depths.shape[1] and row < depths.shape[0]
            if inside and C[FOOTPRINT, i] >= 0.0 and C[FOOTPRINT, i] <= most:
                share = visible_share(depths, row, column, C[DEPTH, i], 1e-3 * C[DEPTH, i])
                if share == 0.0:
                    C[FOOTPRINT, i] = HIDDEN
                for c in ti.static((RED, GREEN, BLUE, ALPHA)):
                    C[c, i] = C[c, i] * share


_hide_kernel = kernel(_hide)


def hide_small_sprites(channels: np.ndarray, count: int, hidden_by: SurfaceDepths, most: float) -> None:
    """Dim projected particles (11, n) of a footprint up to `most` pixels by what surfaces hide of them, in place."""
    if count:
        _hide_kernel(channels, count, hidden_by.depths, most)
