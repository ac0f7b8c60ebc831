"""Draws the images that presets lay on surfaces: roof tiles, the grain of wood, a sewn flag. Run it from the repository's root.

Each is small, repeats where it has to, and comes out the same every time (NumPy's PCG64 with a fixed seed).
"""

from pathlib import Path

import numpy as np
from PIL import Image

PRESETS = Path(__file__).resolve().parent.parent / "presets"


def bumps(shape, rows, columns, seed):
    """A repeated smooth noise of mean 0 and deviation 1: a grid of rows x columns random numbers, joined by cosines."""
    values = np.random.Generator(np.random.PCG64(seed)).standard_normal((rows, columns))
    for axis, (n, cells) in enumerate(zip(shape, (rows, columns))):
        at = (np.arange(n) + 0.5) * cells / n
        first = np.floor(at).astype(int)
        t = 0.5 - 0.5 * np.cos(np.pi * (at - first))
        t = t[:, None] if axis == 0 else t[None, :]
        values = np.take(values, first % cells, axis) * (1 - t) + np.take(values, (first + 1) % cells, axis) * t
    return (values - values.mean()) / values.std()


def save(pixels, name, colours=0):
    """A PNG of (rows, columns, 3) in 0..1 with a palette of this many colours, or of (rows, columns, 4) as it is."""
    image = Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8))
    if pixels.shape[2] == 3:
        image = image.quantize(colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    image.save(PRESETS / name, optimize=True)


def roof_tiles(side=256, courses=6, across=4):
    """Plain clay tiles in courses that overlap: each has its own colour, a dark lower edge and gaps to its neighbours."""
    random = np.random.Generator(np.random.PCG64(3))
    y, x = np.mgrid[0:side, 0:side] / side
    course = np.floor(y * courses).astype(int)
    along = x * across + 0.5 * (course % 2)
    tile = np.floor(along).astype(int) % across
    shade = (1 + 0.13 * random.standard_normal((courses, across)))[course, tile]
    warm = (0.05 * random.standard_normal((courses, across)))[course, tile]
    down, left = y * courses - course, along - np.floor(along)
    edge = np.clip(down / 0.12, 0, 1) * np.clip(np.minimum(left, 1 - left) / 0.02, 0.25, 1)
    dirt = 1 + 0.06 * bumps((side, side), 64, 64, 1) + 0.08 * bumps((side, side), 8, 8, 2)
    base = np.stack([0.50 + warm, 0.27 + 0 * warm, 0.19 - 0.5 * warm], axis=2)
    return base * (shade * dirt * (0.35 + 0.65 * edge) * (1.06 - 0.12 * down))[..., None]


def wood_grain(rows=256, columns=512):
    """Dark fibres and growth rings of a plank along x, to lie over a colour: transparent where there is none."""
    shape = (rows, columns)
    wander = 0.05 * bumps(shape, 3, 2, 11) + 0.012 * bumps(shape, 8, 6, 12)
    rings = (np.arange(rows)[:, None] + 0.5) / rows * 9 + 9 * wander
    phase = rings - np.floor(rings)
    late = np.clip((phase - 0.55) / 0.4, 0, 1) ** 2 * np.clip((1 - phase) / 0.05, 0, 1)
    fibres = np.clip(0.5 * bumps(shape, 128, 14, 13) + 0.35 * bumps(shape, 256, 24, 14), 0, 3)
    pores = np.clip(bumps(shape, 256, 40, 15) - 1.6, 0, 1)
    alpha = 0.06 + 0.30 * late + 0.11 * fibres + 0.35 * pores
    colour = np.broadcast_to(np.array([0.20, 0.11, 0.05]), (*shape, 3))
    return np.concatenate([colour, np.round(np.clip(alpha, 0, 0.75) * 28)[..., None] / 28], axis=2)


def flag(columns=600, rows=400, width=1.5, height=1.0):
    """Three sewn stripes of bunting with hems, seams of two rows of stitches, and a canvas heading with eyelets."""
    v, u = np.mgrid[0:rows, 0:columns]
    x, y = (u + 0.5) * width / columns, (v + 0.5) * height / rows  # m
    wave = 0.0012 * bumps((1, columns), 1, 24, 21)
    first, second = 0.42 + wave, 0.58 + 0.0012 * bumps((1, columns), 1, 24, 22)
    teal, cream, red, canvas = (
        np.array(c) / 255 for c in ([22, 84, 104], [226, 215, 190], [186, 54, 36], [222, 212, 190])
    )
    stripe = np.where((y < first)[..., None], teal, np.where((y < second)[..., None], cream, red))
    shade = np.ones((rows, columns))
    # cloth that lies double at hems and seams lets less light through
    hem = np.minimum(np.minimum(y, height - y), width - x)
    shade *= np.where(hem < 0.024, 0.82, 1.0)
    for seam in (first, second):
        shade *= np.where(np.abs(y - seam) < 0.010, 0.84, 1.0)
    stitch_x, stitch_y = (np.floor(x / 0.006) % 2 == 0), (np.floor(y / 0.006) % 2 == 0)
    for offset in (0.007, -0.007):
        for seam in (first, second):
            shade *= np.where((np.abs(y - seam - offset) < 0.0014) & stitch_x, 0.72, 1.0)
    for depth in (0.019, 0.004):
        row = np.minimum(y, height - y)
        shade *= np.where((np.abs(row - depth) < 0.0014) & stitch_x, 0.72, 1.0)
    for depth in (0.004, 0.012, 0.020):
        shade *= np.where((np.abs(width - x - depth) < 0.0014) & stitch_y, 0.72, 1.0)
    # threads of uneven thickness, both ways, and the weather
    shade *= 1 + 0.022 * bumps((rows, columns), 200, 20, 23) + 0.022 * bumps((rows, columns), 14, 300, 24)
    shade *= 1 + 0.035 * bumps((rows, columns), 5, 7, 25) + 0.02 * bumps((rows, columns), 14, 20, 26)
    fade = (0.10 * np.clip(x / width, 0, 1) ** 2)[..., None]
    cloth = (stripe * (1 - fade) + fade * 0.75) * shade[..., None]
    # the heading, with a stitched edge and an eyelet at each end
    heading = x < 0.05
    weave = 1 + 0.03 * bumps((rows, columns), 200, 300, 27) - 0.10 * (np.abs(x - 0.046) < 0.0012)
    cloth = np.where(heading[..., None], canvas * weave[..., None], cloth)
    for centre in (0.045, 0.955):
        far = np.sqrt((x - 0.024) ** 2 + (y - centre) ** 2)
        cloth = np.where((far < 0.013)[..., None], np.array([0.62, 0.47, 0.18]), cloth)
        cloth = np.where((far < 0.006)[..., None], np.array([0.08, 0.07, 0.06]), cloth)
    return cloth


if __name__ == "__main__":
    save(roof_tiles(), "roof_tiles.png", 48)
    save(wood_grain(), "course/wood_grain.png")
    save(flag(), "course/flag.png", 120)
