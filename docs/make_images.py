"""Draws the images of presets: dirt on roof tiles, soot, wood, a sewn flag, a room out of focus. Run it from the root.

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


def save(pixels, name, colours=0, quality=55):
    """A PNG of (rows, columns, 3) in 0..1 with a palette of this many colours, or of (rows, columns, 4) as it is."""
    image = Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8))
    if name.endswith(".webp"):
        image.save(PRESETS / name, quality=quality, method=6)
        return
    if pixels.shape[2] == 3:
        image = image.quantize(colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    image.save(PRESETS / name, optimize=True)


def roof_clay(side=256):
    """What years leave on clay tiles and bricks, over any colour: soot, a pale bloom, dots of lichen. Clear where clean."""
    shape = (side, side)
    dirt = np.clip(
        0.10 + 0.10 * bumps(shape, 7, 5, 1) + 0.06 * bumps(shape, 29, 23, 2) + 0.05 * bumps(shape, 96, 96, 3), 0, 0.5
    )
    bloom = np.clip(0.12 * bumps(shape, 9, 11, 4) + 0.06 * bumps(shape, 80, 80, 5) - 0.06, 0, 0.3)
    lichen = np.clip(2 * (0.7 * bumps(shape, 60, 60, 6) + 0.7 * bumps(shape, 8, 8, 7) - 1.9), 0, 0.6)
    layers = ((dirt, (0.10, 0.08, 0.07)), (bloom, (0.62, 0.55, 0.48)), (lichen, (0.58, 0.57, 0.42)))
    cover, colour = np.zeros(shape), np.zeros((*shape, 3))
    for alpha, over in layers:
        colour = colour * (1 - alpha[..., None]) + np.array(over) * alpha[..., None]
        cover = cover * (1 - alpha) + alpha
    colour = np.round(12 * colour / np.maximum(cover, 1e-6)[..., None]) / 12
    return np.concatenate([colour, np.round(cover * 24)[..., None] / 24], axis=2)


def pot_soot(side=128):
    """Soot on a chimney pot, dark at its top, run down by rain in streaks."""
    shape = (side, side)
    y = (np.arange(side)[:, None] + 0.5) / side
    reach = 0.68 + 0.05 * bumps(shape, 1, 24, 11) + 0.03 * bumps(shape, 24, 24, 12)
    alpha = np.clip((reach - y) / 0.38, 0, 1) * 0.8 + np.clip(0.05 * bumps(shape, 9, 32, 13), 0, 0.2)
    return stain(alpha, (0.07, 0.055, 0.05), 24)


def rings(radius):
    """How dark wood is at a distance from the heart, in rings: it darkens slowly over a year, whose end is sharp."""
    phase = radius - np.floor(radius)
    return np.clip(phase, 0, 1) ** 2.2 * np.clip((1 - phase) / 0.10, 0, 1)


def stain(alpha, colour=(0.30, 0.15, 0.05), levels=40):
    """Brown of this coverage, to lie over a colour."""
    brown = np.broadcast_to(np.array(colour), (*alpha.shape, 3))
    return np.concatenate([brown, np.round(np.clip(alpha, 0, 0.8) * levels)[..., None] / levels], axis=2)


def block_side(rows=256, columns=512):
    """Planed pine along x, cut beside the heart of the trunk: long rings that meet in arches, fine fibres, few pores.

    Its years run across four boards side by side, so that what one small block shows of it differs from the next.
    """
    shape = (rows, columns)
    v = (np.arange(rows)[:, None] + 0.5) / rows
    wander = 0.010 * bumps(shape, 6, 3, 31) + 0.004 * bumps(shape, 12, 9, 32)
    across = (4 * (v + wander)) % 1.0 - 0.5
    board = np.floor(4 * (v + wander)).astype(int) % 4
    depth = (0.16 + 0.07 * bumps((1, columns), 1, 2, 33) + 0.03 * bumps((1, columns), 1, 5, 34)) * np.ones(shape)
    depth = np.choose(board, [depth, 0.5 + 0 * depth, 1.4 * np.roll(depth, columns // 2, 1), 0.9 + 0 * depth])
    heart = np.choose(board, [0.0, 0.9, 0.1, -0.6])
    radius = 15 * np.sqrt((across - heart) ** 2 + depth**2)
    dark = rings(radius + 0.05 * bumps(shape, 40, 6, 35))
    fibres = np.clip(bumps(shape, 128, 10, 36), 0, 3) * 0.5 + np.clip(bumps(shape, 256, 20, 37), 0, 3) * 0.5
    pores = np.clip(bumps(shape, 256, 60, 38) - 2.0, 0, 1)
    tone = 0.03 * bumps(shape, 5, 3, 39)
    return stain(0.05 + tone + 0.26 * dark + 0.06 * fibres + 0.25 * pores)


def block_end(side=256):
    """The end grain of the same pine: arcs of years, darker than its sides, with rays across them and the marks of the saw."""
    shape = (side, side)
    y, x = (np.mgrid[0:side, 0:side] + 0.5) / side
    bend = 0.055 * np.cos(2 * np.pi * (x + 0.07 * np.sin(2 * np.pi * y)))
    radius = 18 * (y + bend) + 0.10 * bumps(shape, 12, 12, 41)
    dark = rings(radius)
    rays = np.clip(bumps(shape, 10, 128, 42) - 0.4, 0, 3)
    specks = np.clip(bumps(shape, 128, 128, 43), 0, 3)
    saw = np.sin(2 * np.pi * (22 * x + 3 * y)) * np.clip(bumps(shape, 4, 4, 44), 0, 1)
    return stain(0.20 + 0.34 * dark + 0.05 * rays + 0.05 * specks + 0.02 * saw, (0.27, 0.13, 0.045))


def table_top(side=1024, boards=9):
    """Oiled walnut boards along x, glued side by side, each of its own tone and figure, with fine fibres and dark pores."""
    shape = (side, side)
    random = np.random.Generator(np.random.PCG64(50))
    v = (np.arange(side)[:, None] + 0.5) / side * boards + np.zeros((1, side))
    board = np.floor(v).astype(int) % boards
    across = v - np.floor(v)
    light = np.zeros(shape)
    years = np.zeros(shape)
    for k in range(boards):
        here = board == k
        wander = 0.14 * bumps(shape, boards, 2, 51 + k) + 0.03 * bumps(shape, 6 * boards, 5, 71 + k)
        depth = 0.5 + 0.4 * random.random() + 0.20 * bumps((1, side), 1, 2, 91 + k)
        radius = 11 * np.sqrt((across - random.uniform(-1.2, 2.2)) ** 2 + depth**2) + wander
        figure = random.uniform(0.3, 1.0) * np.clip(0.65 + 0.4 * bumps(shape, boards, 3, 111 + k), 0.1, 1.4)
        years = np.where(here, rings(radius) * figure, years)
        light = np.where(here, 1 + 0.08 * random.standard_normal() + 0.05 * wander, light)
    fibres = 0.035 * bumps(shape, 512, 12, 81) + 0.035 * bumps(shape, 256, 6, 82) + 0.05 * bumps(shape, 40, 2, 84)
    pores = np.clip(bumps(shape, 512, 60, 83) - 1.7, 0, 1.5)
    joint = np.clip(np.minimum(across, 1 - across) / 0.008, 0, 1)
    light = light * (1 + fibres) * (1 - 0.26 * years) * (1 - 0.20 * pores) * (0.55 + 0.45 * joint)
    return np.stack([0.42 * light, 0.29 * light**1.06, 0.20 * light**1.12], axis=2)


def room(columns=800, rows=360):
    """A room out of focus: a window into a garden by day, its light on the wall, a plant, books, a lamp.

    The sky in the window is white, and all in the room is much darker, as it is indoors.
    """
    from PIL import ImageDraw, ImageFilter

    scale = 4  # drawn larger, so that edges fall between texels
    image = Image.new("RGB", (columns, rows))

    def layer():
        big = Image.new("RGBA", (columns * scale, rows * scale), (0, 0, 0, 0))
        pen = ImageDraw.Draw(big)

        def shape(kind, points, colour):
            where = [tuple(scale * c for c in p) for p in points]
            getattr(pen, kind)(where if kind == "polygon" else [*where[0], *where[1]], fill=colour)

        return big, shape

    def over(below, big, blur):
        small = big.resize((columns, rows), Image.Resampling.BOX)
        for _ in range(3):
            small = small.filter(ImageFilter.BoxBlur(blur))
        return Image.alpha_composite(below.convert("RGBA"), small).convert("RGB")

    random = np.random.Generator(np.random.PCG64(60))
    # the wall, lighter beside the window
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    near = np.exp(-(np.hypot((x - 160) / 190, (y - 110) / 170) ** 1.3))
    wall = np.stack([34 + 66 * near, 39 + 64 * near, 40 + 56 * near], axis=2)
    image = Image.fromarray(wall.astype(np.uint8))
    # through the window: sky, trees
    big, shape = layer()
    shape("rectangle", [(70, 0), (250, 236)], (255, 255, 255, 255))
    image = over(image, big, 3)
    crowns = 168 + 22 * bumps((1, columns), 1, 14, 61) + 6 * bumps((1, columns), 1, 60, 62)  # of trees
    leaves = 1 + 0.07 * bumps((rows, columns), 12, 26, 63) + 0.05 * bumps((rows, columns), 30, 66, 64)
    garden = 1 / (1 + np.exp((crowns - y) / 7)) * ((x > 66) & (x < 254) & (y < 236))
    green = leaves[..., None] * np.array([168, 186, 148]) * (1 - 0.25 * np.clip((y - 168) / 70, 0, 1))[..., None]
    picture = np.asarray(image, np.float64)
    picture += (green - picture) * 0.85 * garden[..., None]
    image = Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8))
    big, shape = layer()
    wood = (92, 88, 82, 255)
    shape("polygon", [(0, 238), (282, 238), (282, 262), (0, 262)], wood)  # its sill, frame and bars
    shape("rectangle", [(154, 0), (165, 238)], (112, 108, 104, 255))
    shape("rectangle", [(62, 116), (258, 123)], (112, 108, 104, 255))
    shape("rectangle", [(250, 0), (262, 238)], wood)
    for left, right, lean, colour in ((0, 84, 14, (150, 128, 98)), (240, 290, -10, (104, 88, 68))):  # curtains in folds
        folds = 6 if left == 0 else 5
        for k in range(folds):
            a, b = left + (right - left) * k / folds, left + (right - left) * (k + 1.05) / folds
            shade = (1.0, 0.72, 0.9, 0.62, 0.84, 0.7)[k]
            tone = tuple(int(shade * c) for c in colour)
            shape("polygon", [(a, 0), (b, 0), (b + lean, 290), (a + lean, 290)], (*tone, 255))
    for level, first in ((84, 600), (176, 600)):  # shelves with books
        shape("rectangle", [(first, level), (columns, level + 8)], (56, 38, 26, 255))
    covers = [(96, 40, 30), (40, 54, 72), (120, 96, 58), (60, 68, 46), (128, 122, 108), (72, 34, 40), (48, 42, 38)]
    for level, first, last in ((84, 608, 725), (176, 640, 790)):
        at = float(first)
        while at < last:
            wide, tall = random.uniform(8, 16), random.uniform(42, 70)
            cover = covers[int(random.integers(len(covers)))]
            shape("rectangle", [(at, level - tall), (at + wide - 1, level)], (*cover, 255))
            at += wide
    for _ in range(46):  # a plant
        cx, cy = 500 + 34 * random.standard_normal(), 112 + 30 * random.standard_normal()
        green, turn, long = int(random.uniform(30, 74)), random.uniform(-0.9, 0.9), random.uniform(16, 34)
        dx, dy = np.sin(turn) * long, np.cos(turn) * long
        leaf = [
            (cx - dx, cy + dy),
            (cx - 0.32 * dy, cy - 0.1 * dx),
            (cx + dx, cy - dy),
            (cx + 0.32 * dy, cy + 0.1 * dx),
        ]
        shape("polygon", leaf, (int(0.66 * green), green, int(0.42 * green), 255))
    shape("polygon", [(472, 186), (528, 186), (518, 268), (482, 268)], (92, 58, 40, 255))
    shape("polygon", [(700, 44), (748, 44), (764, 82), (684, 82)], (232, 184, 116, 255))  # a lamp
    shape("rectangle", [(0, 258), (columns, rows)], (46, 35, 27, 255))  # a sideboard
    image = over(image, big, 4)
    image = image.point([round(255 * (v / 255) ** 1.3) for v in range(256)] * 3)  # white stays, the room becomes darker
    image.putalpha(254)  # of a sprite without alpha, dark parts are transparent, and WebP leaves out an alpha of 255
    return np.asarray(image, np.float64) / 255.0


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
    save(roof_clay(), "roof_clay.png")
    save(pot_soot(), "pot_soot.png")
    save(block_side(), "course/block_side.png")
    save(block_end(), "course/block_end.png")
    save(table_top(), "course/table_top.webp")
    save(room(), "course/room.webp", quality=90)
    save(flag(), "course/flag.png", 120)
