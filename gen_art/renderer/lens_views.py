"""Surfaces as a lens shows them: the mean of pictures from places all over the lens, each shifted so that they agree in the
plane of focus.

From a place (a, b) beside the middle of the lens, a point of the plane of focus at the distance f is seen `scale a / f` pixels
beside where the middle sees it. Shifted back by that, points of this plane fall together, and one at the depth d is spread over a
disc of `scale radius |1 / f - 1 / d|` pixels, as sprites are. The places are such that the shifts are whole pixels.
Source: Haeberli and Akeley, The accumulation buffer, SIGGRAPH 1990; the spiral of places: Vogel, Math. Biosci. 44 (1979).
"""

import math
from dataclasses import replace

import numpy as np

from gen_art.maths.array_functions import cos, sin
from gen_art.renderer.picture_tiles import TILE
from gen_art.renderer.surfaces.hidden_sprites import SurfaceDepths
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS

__all__ = ["draw_through_lens", "lens_shifts"]

FEWEST, MOST = 8, 48  # places on the lens
DEPTHS = 8  # of them, whose depths are kept to hide sprites
_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
_MARGIN = 16  # the pictures' margins are whole multiples of this, so that memory is used again while the focus changes


def lens_shifts(reach: float) -> np.ndarray:
    """(n, 2) whole pixels to the right and down by which the pictures from places on the lens are shifted.

    reach : pixels, of a place at the lens's rim
    """
    count = int(min(max(math.ceil(reach * reach), FEWEST), MOST))
    k = np.arange(count)
    radius = reach * np.sqrt((k + 0.5) / count)
    return np.rint(np.stack([radius * cos(k * _GOLDEN), radius * sin(k * _GOLDEN)], axis=1)).astype(np.int64)


def draw_through_lens(painter, sim, view, film_time: float, smoke: dict, emitted) -> SurfaceDepths:
    """Replace the surfaces in a painter's framebuffer by those that the view's lens shows. Returns what they hide.

    smoke, emitted : the light among them, as for the view itself
    """
    width, height = painter.size
    scale, (radius, focus) = view.scale(height), view.lens
    shifts = lens_shifts(scale * radius / focus)
    margin = int(np.abs(shifts).max()) // _MARGIN * _MARGIN + _MARGIN
    inner = painter.with_margin(margin)
    # a wider picture with as many pixels for each angle
    wider = (height + 2.0 * margin) / height
    fov = 2.0 * math.degrees(math.atan(math.tan(math.radians(view.fov) / 2.0) * wider))
    total = np.zeros((height, width, 4), np.float32)
    depths = np.zeros((height, width, DEPTHS), np.float32)
    kept = [round((k + 0.5) * len(shifts) / DEPTHS - 0.5) for k in range(DEPTHS)]
    for k, (right, down) in enumerate(shifts.tolist()):
        aside = (right * view.axes[0] - down * view.axes[1]) * (focus / scale)
        seen = replace(view, position=view.position + aside, fov=fov, lens=None)
        pixels, found = inner.draw_surfaces_alone(sim, seen, film_time, smoke, emitted)
        rows = slice(margin - down, margin - down + height)
        columns = slice(margin - right, margin - right + width)
        total += pixels[rows, columns]
        for place in np.flatnonzero(np.array(kept) == k).tolist():
            depths[:, :, place] = found[rows, columns, place % SUBPIXELS]
    painter.framebuffer.pixels[:] = total * np.float32(1.0 / len(shifts))
    tiles = np.stack([_by_tiles(depths.min(axis=2), np.minimum), _by_tiles(depths.max(axis=2), np.maximum)], axis=2)
    return SurfaceDepths.of(depths, tiles, 1.0 / scale, False)


def _by_tiles(values: np.ndarray, reduce) -> np.ndarray:
    """The least or the largest of the pixels of each tile."""
    for axis in (0, 1):
        values = reduce.reduceat(values, np.arange(0, values.shape[axis], TILE), axis=axis)
    return values
