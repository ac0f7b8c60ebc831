"""Draw the images of presets/course/wet_street: setts, plaster, a café's wall and sign, curtains.

    .venv/bin/python docs/make_street_images.py

In the reliefs of the preset what is bright stands out. Images of walls begin where the world's coordinates are 0, so some
are turned by a part of their size, as their functions say.
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "presets" / "course"
FONT = ROOT / "gen_art" / "fonts" / "DejaVuSansCondensed-subset.ttf"
# granite: grey, blue grey, dark, brown, red, pale, and how often
GRANITE = [(112, 108, 102), (92, 94, 98), (76, 74, 72), (124, 112, 98), (104, 84, 72), (134, 130, 124)]
OFTEN = [0.28, 0.24, 0.2, 0.12, 0.06, 0.10]
BOTTLES = [(46, 70, 34), (120, 58, 18), (196, 140, 60), (40, 22, 14), (206, 196, 170), (120, 24, 20)]
WOOD, DARK_WOOD = (74, 40, 20), (52, 27, 12)


def filtered(rng, side, band):
    """White noise of mean 0 and deviation 1 whose waves have the amplitudes band(across, down), by waves along a side."""
    waves = np.fft.fftfreq(side) * side
    across, down = waves[None, :], waves[:, None]
    amplitude = band(across, down) * (np.hypot(across, down) > 0)
    x = np.fft.ifft2(np.fft.fft2(rng.standard_normal((side, side))) * amplitude).real
    return x / x.std()


def noise(rng, side, waves, octaves=1, gain=0.5):
    """Smooth noise that repeats, with about `waves` waves along a side, and twice as many in each further octave."""
    total = np.zeros((side, side))
    for k in range(octaves):
        width = waves * 2.0**k
        total += gain**k * filtered(rng, side, lambda a, b, width=width: np.exp(-(a * a + b * b) / width**2))
    return total / np.sqrt(sum(gain ** (2 * k) for k in range(octaves)))


def setts(rng, side=576, arches=2, rows=24, stones=12, rise=0.24):
    """Granite setts in segmental arches, worn and uneven: heights 0..1, and colours; both repeat.

    rise : of an arch, in parts of its width
    """
    y, x = np.mgrid[0:side, 0:side] / side
    x, y = x + 0.0035 * noise(rng, side, 7), y + 0.0035 * noise(rng, side, 7)
    arch, across = np.floor(x * arches).astype(int) % arches, x * arches % 1
    bent = y + rise / arches * (1 - (2 * across - 1) ** 2) + 0.5 * arch / rows
    row, v = np.floor(bent * rows).astype(int) % rows, bent * rows % 1
    ends = np.cumsum(rng.uniform(0.72, 1.28, (arches, rows, stones)), axis=2)
    ends = np.concatenate([np.zeros((arches, rows, 1)), ends / ends[..., -1:]], axis=2)
    stone = sum((across > ends[arch, row, k]).astype(int) for k in range(1, stones))
    u = (across - ends[arch, row, stone]) / (ends[arch, row, stone + 1] - ends[arch, row, stone])
    count, which = arches * rows * stones, (arch * rows + row) * stones + stone

    def of_stone(low, high):
        return rng.uniform(low, high, count)[which]

    # distance from a stone's middle in parts of the way to its rim, with rounded corners
    size, power = of_stone(0.80, 0.99), of_stone(3.2, 6.5)
    a, b = abs(2 * u - 1 + of_stone(-0.05, 0.05)) / size, abs(2 * v - 1 + of_stone(-0.05, 0.05)) / size
    rim = (a**power + b**power) ** (1 / power) + 0.05 * noise(rng, side, 60)
    top = 1 - (1 - np.clip((1.05 - rim) / of_stone(0.2, 0.85), 0, 1)) ** 3  # some are worn round
    lean = rng.normal(0, 0.09, (2, count))[:, which]
    level = of_stone(0.62, 1.0) + lean[0] * (2 * u - 1) + lean[1] * (2 * v - 1)
    level += 0.10 * (1 - np.clip(rim, 0, 1) ** 2) + 0.045 * noise(rng, side, 36, 3, 0.7)
    height = top * level + (1 - np.clip(1.5 * top, 0, 1)) * (0.30 + 0.02 * noise(rng, side, 30, 2))
    tone = np.array(GRANITE)[rng.choice(len(GRANITE), count, p=OFTEN)] * rng.uniform(0.75, 1.15, (count, 1))
    stones_seen = tone[which] * (1 + 0.10 * noise(rng, side, 70, 2))[..., None]
    joints = np.array([30, 26, 21]) * (1 + 0.15 * noise(rng, side, 50)[..., None])
    inside = np.clip((1.02 - rim) / 0.12, 0, 1)[..., None]
    return np.clip(height / 1.22, 0, 1), 0.62 * (stones_seen * inside + joints * (1 - inside))


def plaster(rng, side=256):
    """An old wall's plaster: stains that darken any colour, as RGBA, and heights 0..1; both repeat."""
    clouds = noise(rng, side, 3, 4, 0.6)
    runs = filtered(rng, side, lambda a, b: np.exp(-((a / 30) ** 2) - (b / 2) ** 2))  # where rain runs down
    stain = np.clip(0.30 + 0.16 * clouds + 0.13 * runs + 0.05 * noise(rng, side, 60, 2), 0, 0.85)
    colours = np.broadcast_to(np.array([34, 29, 24]), (side, side, 3))
    alpha = np.round(255 * stain / 8) * 8
    height = 0.5 + 0.118 * noise(rng, side, 20, 3, 0.7) + 0.063 * clouds
    return np.concatenate([colours, alpha[..., None]], axis=2), np.clip(height, 0, 1)


def room(rng):
    """A café's wall of 4.2 m x 2.95 m, with bottles on shelves and pictures; it begins 0.75 m to the right."""
    width, height = 420, 295
    image = Image.new("RGB", (width, height), (214, 150, 84))
    draw = ImageDraw.Draw(image)

    def box(x0, y0, x1, y1, fill):
        draw.rectangle([x0 * 100, height - y1 * 100, x1 * 100 - 1, height - y0 * 100 - 1], fill=fill)

    box(0, 0, 4.2, 1.0, (96, 52, 26))
    box(0, 0.98, 4.2, 1.05, (60, 30, 14))
    box(0.2, 1.15, 2.3, 2.6, WOOD)
    box(0.26, 1.2, 2.24, 2.54, (150, 104, 60))
    for shelf in (1.22, 1.66, 2.1):
        box(0.2, shelf, 2.3, shelf + 0.04, DARK_WOOD)
        x, low = 0.3, shelf + 0.04
        while x < 2.15:
            w, h = rng.uniform(0.06, 0.1), rng.uniform(0.2, 0.33)
            glass = BOTTLES[int(rng.integers(len(BOTTLES)))]
            box(x, low, x + w, low + 0.68 * h, glass)
            box(x + 0.36 * w, low + 0.6 * h, x + 0.64 * w, low + h, glass)
            label = tuple(min(255, int(1.5 * c + 25)) for c in glass)
            box(x + 0.1 * w, low + 0.2 * h, x + 0.9 * w, low + 0.45 * h, label)
            x += w + rng.uniform(0.01, 0.05)
    for x, y, w, h, fill in (
        (2.5, 1.4, 0.7, 0.95, (120, 66, 44)), (3.36, 1.75, 0.3, 0.45, (196, 180, 140)),
        (3.36, 1.3, 0.3, 0.35, (110, 130, 120)), (3.76, 1.35, 0.34, 0.85, (150, 80, 50)),
    ):  # fmt: skip
        box(x, y, x + w, y + h, DARK_WOOD)
        box(x + 0.05, y + 0.05, x + w - 0.05, y + h - 0.05, fill)
    box(2.64, 1.6, 3.06, 1.9, (60, 70, 50))
    box(2.7, 1.9, 2.95, 2.1, (210, 190, 150))
    image = image.filter(ImageFilter.GaussianBlur(0.7))
    return Image.fromarray(np.roll(np.asarray(image), 75, axis=1))


def sign():
    """The light of a sign of 0.9 m x 0.45 m."""
    width, height = 4 * 192, 4 * 96
    image = Image.new("RGB", (width, height), (30, 4, 3))
    draw = ImageDraw.Draw(image)
    draw.rectangle([20, 20, width - 21, height - 21], outline=(255, 70, 46), width=12)
    draw.text(
        (width // 2, height // 2 + 6), "CAFÉ", fill=(255, 84, 52), font=ImageFont.truetype(str(FONT), 200), anchor="mm",
        stroke_width=6, stroke_fill=(255, 60, 36),
    )  # fmt: skip
    return image.resize((192, 96), Image.Resampling.BOX)


def curtains():
    """The light of a window of 1 m x 1.7 m, drawn curtains and a lamp behind them; its foot is 1.15 m above the street."""
    width, height = 160, 272
    y, x = np.mgrid[0:height, 0:width]
    u, v = (x + 0.5) / width, 1 - (y + 0.5) / height
    lit = 0.30 + 0.7 * np.exp(-((u - 0.58) ** 2) / 0.10 - (v - 0.52) ** 2 / 0.16)
    edge = 0.29 + 0.07 * np.sin(3 * v) - 0.05 * v
    cloth = (u < edge) | (u > 1 - 0.9 * edge)
    folds = 0.55 + 0.25 * np.sin(95 * u + 2 * np.sin(4 * v)) + 0.1 * np.sin(47 * u)
    seen = np.where((v <= 0.19)[..., None], 0.55, 1.0) * np.array([255, 190, 112]) * lit[..., None]
    shade = (abs(u - 0.60) < 0.07 + 0.6 * (0.62 - v)) & (v > 0.5) & (v < 0.62)
    stand, table = (abs(u - 0.60) < 0.012) & (v > 0.2) & (v <= 0.5), (v < 0.22) & (v > 0.19) & (u > 0.4) & (u < 0.8)
    for where, colour in ((shade, (255, 232, 180)), (stand, (70, 40, 20)), (table, (60, 32, 16))):
        seen[where] = colour
    drawn = np.array([255, 150, 84]) * ((0.30 + 0.35 * lit) * folds)[..., None]
    image = grey_or_colour(np.where(cloth[..., None], drawn, seen)).filter(ImageFilter.GaussianBlur(0.8))
    return Image.fromarray(np.roll(np.asarray(image), -round(1.15 / 1.7 * height), axis=0))


def grey_or_colour(values):
    """An image of numbers 0..255, (rows, columns) or (rows, columns, 3 or 4)."""
    return Image.fromarray(np.clip(values, 0, 255).astype(np.uint8))


def save(image, name, colours):
    image.quantize(colours, dither=Image.Dither.NONE).save(FOLDER / f"{name}.png", optimize=True)


def main():
    heights, colours = setts(np.random.default_rng(11))
    grey_or_colour(255 * heights).save(FOLDER / "street_setts.webp", quality=72, method=6)
    save(grey_or_colour(colours).resize((288, 288), Image.Resampling.BOX), "street_stone", 48)
    stains, heights = plaster(np.random.default_rng(5))
    grey_or_colour(stains).save(FOLDER / "street_plaster.png", optimize=True)
    grey_or_colour(255 * heights).save(FOLDER / "street_plaster_relief.webp", quality=75, method=6)
    save(room(np.random.default_rng(3)), "street_cafe", 48)
    save(sign(), "street_sign", 32)
    save(curtains(), "street_curtains", 48)


if __name__ == "__main__":
    main()
