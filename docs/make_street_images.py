"""Draw the images of presets/course/wet_street and rain: setts, plaster, cut stone, granite, a café's windows and sign.

    .venv/bin/python docs/make_street_images.py

In the reliefs of the preset what is bright stands out. Images of walls begin where the world's coordinates are 0.
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "presets" / "course"
FONT = ROOT / "gen_art" / "fonts" / "DejaVuSansCondensed-subset.ttf"
# granite: grey, blue grey, dark, brown, red, pale, and how often
GRANITE = [(112, 108, 102), (92, 94, 98), (76, 74, 72), (124, 112, 98), (104, 84, 72), (134, 130, 124)]
OFTEN = [0.28, 0.24, 0.2, 0.12, 0.06, 0.10]


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


def setts(rng, side=768, width=2.6, rows=20, stones=13):
    """Granite setts in courses of a bond: heights 0..1, colours, and where water stands; all repeat.

    width : of the image [m]
    Tops are flat with rounded edges. Water fills the joints to a level that differs from place to place, and lies level.
    """
    y, x = np.mgrid[0:side, 0:side] / side
    x, y = x + 0.0022 * noise(rng, side, 9), y + 0.0022 * noise(rng, side, 9)
    depths = np.cumsum(np.concatenate([[0.0], rng.uniform(0.86, 1.14, rows)]))
    depths /= depths[-1]
    y = y % 1
    row = np.clip(np.searchsorted(depths, y, side="right") - 1, 0, rows - 1)
    across = (x + (0.5 * row + rng.uniform(-0.2, 0.2, rows)[row]) / stones) % 1
    ends = np.cumsum(rng.uniform(0.7, 1.3, (rows, stones)), axis=1)
    ends = np.concatenate([np.zeros((rows, 1)), ends / ends[:, -1:]], axis=1)
    stone = sum((across > ends[row, k]).astype(int) for k in range(1, stones))
    left, right = ends[row, stone], ends[row, stone + 1]
    count, which = rows * stones, row * stones + stone

    def of_stone(low, high):
        return rng.uniform(low, high, count)[which]

    # distance from the cell's edge, in metres, with rounded corners
    near_x = width * np.minimum(across - left, right - across)
    near_y = width * np.minimum(y - depths[row], depths[row + 1] - y)
    corner = of_stone(0.018, 0.04)
    gap = np.hypot(np.maximum(corner - near_x, 0), np.maximum(corner - near_y, 0))
    inner = np.minimum(near_x, near_y)
    edge = np.where(inner < corner, corner - gap, inner) + 0.0016 * noise(rng, side, 70, 2)
    joint, worn = of_stone(0.004, 0.008), of_stone(0.010, 0.024)
    e = np.clip((edge - joint) / worn, 0, 1)
    top = np.sqrt(1 - (1 - e) ** 2)
    u, v = (across - left) / (right - left) - 0.5, (y - depths[row]) / (depths[row + 1] - depths[row]) - 0.5
    lean = rng.normal(0, 0.07, (2, count))[:, which]
    level = (
        of_stone(0.72, 0.96)
        + lean[0] * u
        + lean[1] * v
        + 0.035 * noise(rng, side, 28, 2)
        + 0.012 * noise(rng, side, 150, 2)
    )
    water = 0.38 + 0.16 * noise(rng, side, 3, 2)
    height = np.maximum(top * level, water)
    tone = np.array(GRANITE)[rng.choice(len(GRANITE), count, p=OFTEN)] * rng.uniform(0.6, 1.2, (count, 1))
    grains = 1 + 0.16 * noise(rng, side, 190)[..., None] + 0.10 * noise(rng, side, 30, 2)[..., None]
    joints = np.array([20, 17, 14]) * np.ones((side, side, 1))
    inside = np.clip((edge - joint) / 0.008, 0, 1)[..., None]
    return np.clip(height, 0, 1), 0.55 * (tone[which] * grains * inside + joints * (1 - inside))


def ashlar(rng, side=512, width=5.12, courses=16):
    """A wall of cut stones, wet at its foot, the lower edge: what darkens any colour, as RGBA, and heights 0..1."""
    y, x = np.mgrid[0:side, 0:side] / side
    up = 1 - y
    x = (x + 0.0008 * noise(rng, side, 20)) % 1
    course = np.minimum((up * courses).astype(int), courses - 1)
    blocks = 8
    ends = np.cumsum(rng.uniform(0.7, 1.3, (courses, blocks)), axis=1)
    ends = np.concatenate([np.zeros((courses, 1)), ends / ends[:, -1:]], axis=1)
    across = (x + rng.uniform(0, 1, courses)[course]) % 1
    stone = sum((across > ends[course, k]).astype(int) for k in range(1, blocks))
    which = course * blocks + stone
    near = width * np.minimum(
        np.minimum(across - ends[course, stone], ends[course, stone + 1] - across),
        np.minimum(up * courses - course, course + 1 - up * courses) / courses,
    )
    near += 0.003 * noise(rng, side, 60, 2)
    inside = np.clip((near - 0.006) / 0.014, 0, 1)
    lean = rng.normal(0, 0.06, courses * blocks)[which]
    height = inside * (0.75 + lean + 0.05 * noise(rng, side, 40, 3, 0.7))
    foot = np.exp(-((width * up / (0.55 + 0.12 * noise(rng, side, 6, 3)[-1:, :])) ** 2))  # rain splashes up
    runs = filtered(rng, side, lambda a, b: np.exp(-((a / 40) ** 2) - (b / 5) ** 2))
    stain = 0.22 + rng.uniform(-0.12, 0.22, courses * blocks)[which] + 0.07 * runs + 0.06 * noise(rng, side, 5, 5, 0.7)
    stain = 1 - (1 - np.clip(stain, 0, 0.8)) * (0.35 + 0.65 * inside) * (1 - 0.6 * foot)
    colours = np.broadcast_to(np.array([26, 23, 20]), (side, side, 3))
    return np.concatenate([colours, np.round(255 * stain / 8)[..., None] * 8], axis=2), np.clip(height, 0, 1)


def plaster(rng, side=256):
    """An old wall's plaster: stains that darken any colour, as RGBA, and heights 0..1; both repeat."""
    clouds = noise(rng, side, 3, 4, 0.6)
    runs = filtered(rng, side, lambda a, b: np.exp(-((a / 30) ** 2) - (b / 2) ** 2))  # where rain runs down
    stain = np.clip(0.30 + 0.16 * clouds + 0.13 * runs + 0.05 * noise(rng, side, 60, 2), 0, 0.85)
    colours = np.broadcast_to(np.array([34, 29, 24]), (side, side, 3))
    alpha = np.round(255 * stain / 8) * 8
    height = 0.5 + 0.118 * noise(rng, side, 20, 3, 0.7) + 0.063 * clouds
    return np.concatenate([colours, alpha[..., None]], axis=2), np.clip(height, 0, 1)


def granite(rng, side=384):
    """Polished granite: pale and rosy feldspar, grey quartz and black mica, as crystals a few texels wide; they repeat."""
    pale, rosy, mica = (noise(rng, side, waves, 2, 0.7) for waves in (34, 28, 46))
    colours = np.broadcast_to(np.array([118.0, 116, 116]), (side, side, 3)).copy()
    for part, colour in ((pale - 0.3, (196, 190, 182)), (rosy - 1.0, (172, 138, 122)), (mica - 0.85, (30, 30, 34))):
        colours += (np.array(colour) - colours) * np.clip(part * 4, 0, 1)[..., None]
    return colours * (1 + 0.05 * noise(rng, side, 5, 3)[..., None])


def glass(rng, side=512):
    """The light of a café through condensed glass of 2.95 m x 2.95 m: blurred lamps and shapes; drops have run down it."""
    y, x = np.mgrid[0:side, 0:side] / side
    up = 1 - y
    light = np.full((side, side, 3), 0.0) + np.array([0.70, 0.27, 0.05])
    light *= (0.09 + 0.5 * np.exp(-(((up - 0.72) / 0.24) ** 2)))[..., None]
    for _ in range(26):  # people, chairs, bottles: nothing is told but that they are there
        cx, cy = rng.uniform(0, 1), rng.uniform(0.05, 0.5)
        w, h = rng.uniform(0.02, 0.07), rng.uniform(0.06, 0.22)
        away = np.minimum(abs(x - cx), 1 - abs(x - cx))
        light *= (1 - 0.9 * np.exp(-((away / w) ** 4) - (abs(up - cy) / h) ** 4))[..., None]
    for cx, cy, r, power, tint in (
        (0.12, 0.76, 0.055, 3.2, (1, 0.72, 0.38)), (0.38, 0.70, 0.040, 2.2, (1, 0.70, 0.36)),
        (0.66, 0.77, 0.050, 3.0, (1, 0.74, 0.40)), (0.88, 0.69, 0.035, 1.8, (1, 0.66, 0.30)),
        (0.52, 0.56, 0.028, 0.7, (1, 0.35, 0.16)), (0.80, 0.54, 0.022, 0.6, (0.6, 0.8, 0.5)),
    ):  # fmt: skip
        away = np.minimum(abs(x - cx), 1 - abs(x - cx))
        d = np.hypot(away, up - cy)
        light += (
            (power / (1 + np.exp((d - r) / (0.16 * r))) + 0.22 * power * np.exp(-((d / 0.13) ** 2)))[..., None]
            * np.array(tint)
            * 0.4
        )
    mist = np.clip(0.5 + 0.22 * noise(rng, side, 5, 4, 0.6), 0, 1)
    mean = light.mean(axis=(0, 1))
    light = light * (1 - 0.2 * mist[..., None]) + 0.12 * mist[..., None] * mean
    tracks = np.zeros((side, side))
    for _ in range(24):
        cx, top, foot = rng.uniform(0, 1), rng.uniform(0.5, 1), rng.uniform(0.05, 0.6)
        bend = 0.004 * np.cumsum(rng.standard_normal(side)) / 6
        away = abs(x - cx - bend[:, None])
        tracks = np.maximum(
            tracks, np.exp(-((away / rng.uniform(0.0015, 0.004)) ** 2)) * ((up < top) & (up > top - foot))
        )
    light *= (1 - 0.3 * tracks)[..., None] * (1 + 0.04 * noise(rng, side, 120)[..., None])
    return grey_or_colour(255 * np.clip(light, 0, 1) ** (1 / 2.2))


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


def grey_or_colour(values):
    """An image of numbers 0..255, (rows, columns) or (rows, columns, 3 or 4)."""
    return Image.fromarray(np.clip(values, 0, 255).astype(np.uint8))


def save(image, name, colours):
    image.quantize(colours, dither=Image.Dither.NONE).save(FOLDER / f"{name}.png", optimize=True)


def main():
    heights, colours = setts(np.random.default_rng(11))
    grey_or_colour(255 * heights).save(FOLDER / "street_setts.webp", quality=90, method=6)
    save(grey_or_colour(colours).resize((384, 384), Image.Resampling.BOX), "street_stone", 48)
    stains, heights = plaster(np.random.default_rng(5))
    grey_or_colour(stains).save(FOLDER / "street_plaster.png", optimize=True)
    grey_or_colour(255 * heights).save(FOLDER / "street_plaster_relief.webp", quality=75, method=6)
    stains, heights = ashlar(np.random.default_rng(7))
    grey_or_colour(stains).save(FOLDER / "street_ashlar.png", optimize=True)
    grey_or_colour(255 * heights).save(FOLDER / "street_ashlar_relief.webp", quality=75, method=6)
    glass(np.random.default_rng(3)).save(FOLDER / "street_glass.webp", quality=80, method=6)
    save(sign(), "street_sign", 32)
    grey_or_colour(granite(np.random.default_rng(2))).save(FOLDER / "granite.webp", quality=80, method=6)


if __name__ == "__main__":
    main()
