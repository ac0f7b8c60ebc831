"""Discs drawn into the tiles of the framebuffer by whole vectors of four pixels (RGBA).

A tile of 8 x 8 pixels is sixteen vectors, which stay in the processor's registers from its first disc to its last. Discs that no
surface hides have the bits of tiled_splat.py.

The one-letter names in kernels are in docs/glossary.md.
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from functools import cache

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.picture_tiles import BIN, TILE, TILES
from gen_art.renderer.sprite import ALPHA, BLUE, FOOTPRINT, GREEN, NORM, RED, THICKNESS, X, Y
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS

__all__ = ["WIDE", "draw_discs_kernel"]

WIDE = 16  # floats of a vector
PARTS = 4 * TILE // WIDE  # vectors in a row of a tile
F1, F2, F3 = (ti.types.ndarray(ti.f32, n) for n in (1, 2, 3))
I1 = ti.types.ndarray(ti.i32, 1)
FLOATS = ti.types.ndarray(ti.types.vector(WIDE, ti.f32), 1)
_COLUMNS = [tuple(part * WIDE // 4 + lane // 4 + 0.5 for lane in range(WIDE)) for part in range(PARTS)]
_ROWS = tuple(lane + 0.5 for lane in range(WIDE))


@ti.func
def _all(x):
    """A vector with the same float in each lane."""
    return ti.Vector([ti.cast(x, ti.f32) for _ in ti.static(range(WIDE))])


@ti.func
def _profile(t):
    """sprite.profile of each lane."""
    one, s = _all(1.0), t * t
    s = ti.select(s < one, s, one)
    a = one - _all(0.3125) * s
    a2 = a * a
    a4 = a2 * a2
    b = one - s
    return a4 * a4 * (b * b)


@ti.func
def _clamped(x):
    """Each lane between 0 and 1."""
    zero, one = _all(0.0), _all(1.0)
    x = ti.select(x > zero, x, zero)
    return ti.select(x < one, x, one)


@cache
def draw_discs_kernel(surfaces_hide: bool):
    """The kernel that draws discs, of which surfaces may hide a part."""

    @ti.kernel
    def draw_discs(
        P: F2, entries: I1, tile_masks: I1, firsts: I1, ends: I1, across: ti.i32, bins: ti.i32, framebuffer: FLOATS,
        stride: ti.i32, depths: F1, surfaces: F3, tile_depths: F3,
    ):  # fmt: skip
        """Draw each bin's discs, entries[firsts[bin]] to entries[ends[bin] - 1].

        stride : vectors in a row of pixels
        depths : (n,) of the sprites
        surfaces, tile_depths : depths and tiles of SurfaceDepths
        """
        ti.loop_config(block_dim=1)
        for place in range(bins * TILES * TILES):
            bin, t = place // (TILES * TILES), place % (TILES * TILES)
            touched = 0
            for k in range(firsts[bin], ends[bin]):
                touched |= tile_masks[k] >> t
            if touched & 1:
                x0, y0 = (bin % across) * BIN + (t % TILES) * TILE, (bin // across) * BIN + (t // TILES) * TILE
                corner = y0 * stride + x0 * 4 // WIDE
                columns, rows = [ti.Vector(c) for c in ti.static(_COLUMNS)], ti.Vector(_ROWS)
                tile = [_all(0.0) for _ in ti.static(range(TILE * PARTS))]
                light, coverage = (
                    [_all(0.0) for _ in ti.static(range(PARTS))],
                    [_all(0.0) for _ in ti.static(range(PARTS))],
                )
                for v in ti.static(range(TILE * PARTS)):
                    tile[v] = framebuffer[corner + v // PARTS * stride + v % PARTS]
                low, high = 3e38, 3e38  # the least and the largest depth of surfaces in the tile
                solid = [_all(0.0) for _ in ti.static(range(TILE * PARTS * SUBPIXELS if surfaces_hide else 0))]
                if ti.static(surfaces_hide):
                    across_tile, down_tile = x0 // TILE, y0 // TILE
                    if down_tile < tile_depths.shape[0] and across_tile < tile_depths.shape[1]:
                        low, high = tile_depths[down_tile, across_tile, 0], tile_depths[down_tile, across_tile, 1]
                    for v in ti.static(range(TILE * PARTS)):
                        row = ti.min(y0 + v // PARTS, surfaces.shape[0] - 1)
                        for s in ti.static(range(SUBPIXELS)):
                            pixels = [0.0] * (WIDE // 4)
                            for p in ti.static(range(WIDE // 4)):
                                column = ti.min(x0 + v % PARTS * (WIDE // 4) + p, surfaces.shape[1] - 1)
                                pixels[p] = surfaces[row, column, s]
                            solid[v * SUBPIXELS + s] = ti.Vector([pixels[lane // 4] for lane in ti.static(range(WIDE))])
                for k in range(firsts[bin], ends[bin]):
                    if (tile_masks[k] >> t) & 1:
                        i = entries[k]
                        thickness, depth = P[i, THICKNESS], depths[i]
                        x, inverse, norm = (
                            _all(P[i, X] - ti.cast(x0, ti.f32)),
                            _all(1.0 / P[i, FOOTPRINT]),
                            _all(P[i, NORM]),
                        )
                        r, g, b, a = P[i, RED], P[i, GREEN], P[i, BLUE], P[i, ALPHA]
                        colour = ti.Vector([r, g, b, a] * (WIDE // 4))
                        for part in ti.static(range(PARTS)):
                            w = _profile((columns[part] - x) * inverse) * norm
                            light[part], coverage[part] = w * colour, w * _all(a)
                        down = _profile((rows - _all(P[i, Y] - ti.cast(y0, ti.f32))) * inverse)
                        whole = 1
                        if ti.static(surfaces_hide):
                            if thickness > 0.0 and depth + 0.5 * thickness > low:
                                whole = 0
                                if depth - 0.5 * thickness < high:
                                    per, middle, half = _all(1.0 / thickness), _all(depth), _all(0.5)
                                    for v in ti.static(range(TILE * PARTS)):
                                        share = _all(0.0)
                                        for s in ti.static(range(SUBPIXELS)):
                                            share += _clamped((solid[v * SUBPIXELS + s] - middle) * per + half)
                                        w = _all(down[v // PARTS] / SUBPIXELS) * share
                                        tile[v] = tile[v] + w * (light[v % PARTS] - tile[v] * coverage[v % PARTS])
                        if whole == 1:
                            for v in ti.static(range(TILE * PARTS)):
                                w = _all(down[v // PARTS])
                                tile[v] = tile[v] + w * (light[v % PARTS] - tile[v] * coverage[v % PARTS])
                for v in ti.static(range(TILE * PARTS)):
                    framebuffer[corner + v // PARTS * stride + v % PARTS] = tile[v]

    return kernel(draw_discs, vectors=True)
