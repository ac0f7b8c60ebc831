"""Draws the images of presets: dirt on roof tiles, soot, wood, a sewn flag, a table. Run it from the root.

Each is small, repeats where it has to, and comes out the same every time (NumPy's PCG64 with a fixed seed).
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

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


def table_top(side=1024, boards=4):
    """Oiled walnut boards along x, glued side by side: each is sawn from another part of a trunk, so that its years lie close
    together and straight, or meet in long arches. Dark pores are short strokes along the fibres.
    """
    shape = (side, side)
    random = np.random.Generator(np.random.PCG64(50))
    v = (np.arange(side)[:, None] + 0.5) / side * boards + np.zeros((1, side))
    board = np.floor(v).astype(int) % boards
    across = v - np.floor(v)
    light, years = np.ones(shape), np.zeros(shape)
    cuts = (
        (0.5, 0.10, 0.30, 14),
        (-1.6, 0.6, 0.1, 13),
        (1.3, 0.3, 0.2, 12),
        (2.6, 0.7, 0.1, 13),
    )  # heart, depth, its change, rings
    for k, (heart, depth, change, rings_across) in enumerate(cuts):
        here = board == k
        wander = 0.012 * bumps(shape, 2 * boards, 3, 51 + k) + 0.004 * bumps(shape, 10 * boards, 8, 71 + k)
        down = depth + change * (1 + bumps((1, side), 1, 2, 91 + k))
        radius = rings_across * (np.sqrt((across - heart) ** 2 + down**2) + wander)
        years = np.where(here, rings(radius + 0.06 * bumps(shape, 160, 10, 111 + k)), years)
        light = np.where(here, random.uniform(0.86, 1.12) * (1 + 0.05 * bumps(shape, 3 * boards, 2, 131 + k)), light)
    fibres = 0.05 * bumps(shape, 512, 14, 81) + 0.05 * bumps(shape, 256, 8, 82) + 0.04 * bumps(shape, 64, 4, 84)
    pores = np.clip(bumps(shape, 512, 40, 83) - 1.3, 0, 1.2) * (0.5 + 0.8 * years)
    joint = np.clip(np.minimum(across, 1 - across) / 0.006, 0, 1)
    light = light * (1 + fibres) * (1 - 0.26 * years) * (1 - 0.34 * pores) * (0.5 + 0.5 * joint)
    return np.stack([0.34 * light, 0.235 * light**1.08, 0.165 * light**1.14], axis=2)


def stripe(side=64, width=0.17):
    """A band of white paint across the middle, clear beside it."""
    x = (np.arange(side) + 0.5) / side - 0.5
    band = np.clip((0.5 * width - np.abs(x)) * side + 0.5, 0, 1)
    return np.stack([np.full((side, side), 0.96)] * 3 + [np.tile(band, (side, 1))], axis=2)


def gingham(side=768, stripes=22, threads=256):
    """A whole checked cloth: stripes of red and white threads both ways, the mixed colour where they cross, and a sewn
    hem along its edges, with a row of stitches.
    """
    y, x = (np.mgrid[0:side, 0:side] + 0.5) / side
    across, down = (0.5 - 0.5 * np.clip(np.cos(np.pi * stripes * v) * 9, -1, 1) for v in (x, y))  # soft by a thread
    above = (np.floor(x * threads) + np.floor(y * threads)) % 2  # whether the thread that runs down lies above
    red = 0.5 * (across + down) + 0.025 * np.where(above > 0, 1, -1) * (across - down)
    weave = 1 + 0.03 * bumps((side, side), threads, 12, 31) + 0.03 * bumps((side, side), 12, threads, 32)
    hem = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    red = np.where(hem < 0.013, 1, red)
    stitches = (np.abs(hem - 0.0095) < 0.0012) & (
        np.floor(np.where(np.minimum(x, 1 - x) < np.minimum(y, 1 - y), y, x) * 160) % 2 > 0
    )
    weave *= np.where(np.abs(hem - 0.0140) < 0.0010, 0.78, 1)
    white, pink, full = (
        np.array(c)[:, None, None] for c in ((0.93, 0.90, 0.84), (0.86, 0.44, 0.42), (0.66, 0.05, 0.07))
    )
    colour = np.where(red < 0.5, white + 2 * red * (pink - white), pink + (2 * red - 1) * (full - pink))
    return np.moveaxis(np.where(stitches, white, colour) * weave, 0, 2)


def cork(side=256):
    """Cork: pale grains of many sizes between dark pores, which repeat."""
    grain = (
        0.5 * bumps((side, side), 14, 14, 51)
        + 0.35 * bumps((side, side), 30, 30, 52)
        + 0.25 * bumps((side, side), 64, 64, 53)
    )
    pores = np.clip(bumps((side, side), 40, 40, 54) - 1.1, 0, 1) * 0.7
    tone = np.clip(0.72 + 0.12 * grain - pores, 0.1, 1.2)
    return np.array([0.80, 0.55, 0.32]) * tone[..., None]


def ice(side=256):
    """Ice: white and a little blue, with bright cracks and clouds of air, which repeat."""
    folds = (
        0.8 * bumps((side, side), 6, 6, 65)
        + 0.5 * bumps((side, side), 17, 17, 66)
        + 0.3 * bumps((side, side), 40, 40, 67)
    )
    cracks = sum(w * np.exp(-np.abs(folds - at) / 0.05) for w, at in ((0.35, -0.5), (0.25, 0.7)))
    cloud = (
        0.5 * bumps((side, side), 5, 5, 71)
        + 0.35 * bumps((side, side), 13, 13, 72)
        + 0.3 * bumps((side, side), 45, 45, 73)
    )
    tone = np.clip(0.55 + 0.28 * cloud + cracks, 0, 1)[..., None]
    return np.array([0.62, 0.78, 0.86]) * (1 - tone) + np.array([0.97, 0.99, 1.0]) * tone


def brushed_steel(columns=512, rows=256):
    """Brushed steel: fine bright and dark lines along x, a few scratches, which repeat."""
    lines = bumps((rows, columns), rows, 4, 81) + 0.4 * bumps((rows, columns), rows // 3, 3, 82)
    scratch = np.clip(bumps((rows, columns), rows, 18, 84) - 2.4, 0, 1)
    tone = np.clip(0.88 + 0.05 * lines + 0.2 * scratch, 0, 1)
    return np.array([0.97, 0.99, 1.0]) * tone[..., None]


def toy_block(side=192, border=0.14):
    """One side of a toy block: a frame of pale wood around a red panel with a letter m, for its mass."""
    font = ImageFont.truetype(str(PRESETS.parent / "gen_art/fonts/DejaVuSansCondensed-subset.ttf"), int(0.62 * side))
    letter = Image.new("L", (side, side))
    ImageDraw.Draw(letter).text((side / 2, 0.69 * side), "m", 255, font, anchor="ms")
    letter = np.asarray(letter, float) / 255
    y, x = (np.mgrid[0:side, 0:side] + 0.5) / side
    inside = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y)) - border
    worn = 0.006 * bumps((side, side), 24, 24, 91)
    panel = np.clip((inside + worn) * side / 2, 0, 1)
    groove = 1 - 0.45 * np.exp(-((inside / 0.012) ** 2))
    fibre = bumps((side, side), side // 2, 3, 92) + 0.7 * bumps((side, side), side // 6, 2, 93)
    wood = np.array([0.86, 0.68, 0.44]) * (1 + 0.055 * fibre)[..., None]
    red = np.array([0.74, 0.13, 0.08]) * (1 + 0.05 * fibre)[..., None]
    paint = np.clip(panel - letter, 0, 1)[..., None]
    return (wood * (1 - paint) + red * paint) * groove[..., None]


def bubble(side=96):
    """A bubble of air in water, lit from above: the sky in a bright rim, clear within, the lamp in its upper left."""
    y, x = 1 - (np.mgrid[0:side, 0:side] + 0.5)[0] / side * 2, (np.mgrid[0:side, 0:side] + 0.5)[1] / side * 2 - 1
    far = np.hypot(x, y) / 0.96
    inside = np.clip((1 - far) * side * 0.48, 0, 1)
    rim = np.clip(far, 0, 1) ** 7
    light = rim * (0.55 + 0.45 * y) + 0.10 * np.clip(-y, 0, 1) * far**2 + 0.05
    for u, v, size, much in ((-0.36, 0.46, 0.13, 1.0), (0.34, -0.50, 0.16, 0.35)):
        light = light + much * np.exp(-((x - u) ** 2 + (y - v) ** 2) / size**2)
    alpha = np.clip(light, 0, 1) * inside
    return np.dstack([np.ones((side, side, 3)), alpha])


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
    save(table_top(), "course/table_top.webp", quality=60)
    save(stripe(), "course/stripe.png")
    save(gingham(), "course/gingham.webp", quality=70)
    save(cork(), "course/cork.webp", quality=75)
    save(ice(), "course/ice.webp", quality=75)
    save(brushed_steel(), "course/brushed_steel.webp", quality=70)
    save(toy_block(), "course/toy_block.webp", quality=80)
    save(bubble(), "course/bubble.webp", quality=80)
    save(flag(), "course/flag.png", 120)
