"""Draw the images of presets/fireworks: a ridge of wooded hills, and a small town along the shore with lit windows.

    .venv/bin/python docs/make_fireworks_images.py

The lower half of each is its upper half mirrored: water hides it, and a mirror, which does not turn images upside down, shows it.
"""

from pathlib import Path

import numpy as np
from make_lake_images import fractal, noise
from PIL import Image, ImageDraw

FOLDER = Path(__file__).resolve().parent.parent / "presets"


def save(colour, alpha, name, quality):
    half = np.concatenate([np.clip(colour, 0, 1), np.clip(alpha, 0, 1)[..., None]], axis=2)
    pixels = (np.concatenate([half, half[::-1]]) * 255 + 0.5).astype(np.uint8)
    Image.fromarray(pixels).save(FOLDER / name, quality=quality, method=6, alpha_quality=80)


def hills(name, width=1024, rows=128, reach=0.85, finer=4):
    """Two ridges, the nearer one darker, with a fringe of trees; white beside what the preset gives as its colour."""
    x = ((np.arange(width * finer) + 0.5) / (width * finer) * 2 - 1) * reach
    y = (rows * finer - np.arange(rows * finer) - 0.5)[:, None] / (width * finer) * 2 * reach
    rough = fractal(x, 0 * x + 0.5, 0.0, 6.0, 7, 0.5, 5)
    far = 0.052 + 0.085 * np.exp(-(((x - 0.62) / 0.2) ** 2)) + 0.05 * np.exp(-(((x + 0.55) / 0.22) ** 2)) + 0.03 * rough
    near = (
        0.018 + 0.075 * np.exp(-(((x + 0.85) / 0.26) ** 2)) + 0.05 * np.exp(-(((x - 0.9) / 0.14) ** 2)) + 0.012 * rough
    )
    trees = 0.004 * np.abs(noise(x * 260, 0 * x + 0.5, 8)) + 0.005 * np.abs(noise(x * 90, 0 * x + 0.5, 9))
    alpha = (y < np.maximum(far, near + trees)[None, :]).astype(np.float64)
    shade = np.where(y < (near + trees)[None, :], 0.25, 1.0 - 0.45 * y / 0.14)
    mean = alpha.reshape(rows, finer, width, finer).mean(axis=(1, 3))
    grey = (shade * alpha).reshape(rows, finer, width, finer).mean(axis=(1, 3)) / np.maximum(mean, 1e-6)
    save(np.repeat(grey[..., None], 3, axis=2), mean, name, 80)


def town(name, width=1024, rows=72, finer=4):
    """Houses with gables, a church and trees, dark before the sky, with windows and lamps of a promenade."""
    rng = np.random.default_rng(12)
    big = (width * finer, rows * finer)
    alpha, light = Image.new("L", big), Image.new("RGB", big)
    mask, lamps = ImageDraw.Draw(alpha), ImageDraw.Draw(light)
    warm = [(255, 190, 90), (255, 160, 60), (255, 220, 150), (250, 235, 205)]

    def place(x, y):
        return x * finer, (rows - y) * finer

    def house(x, wide, tall, gable):
        mask.polygon(
            [place(x, 0), place(x, tall), place(x + wide / 2, tall + gable), place(x + wide, tall), place(x + wide, 0)],
            fill=255,
        )
        for wx in np.arange(x + 1.5, x + wide - 1.5, 3.4):
            for wy in np.arange(4.0, tall - 1.5, 4.6):
                if rng.uniform() < 0.24:
                    colour = tuple(int(c * rng.uniform(0.3, 1.0) ** 1.5) for c in warm[rng.integers(4)])
                    lamps.rectangle([*place(wx, wy + 1.9), *place(wx + 1.3, wy)], fill=colour)

    x = -4.0
    while x < width:
        t = abs(x / width * 2 - 1)
        if t < 0.62 or rng.uniform() < 0.25:
            wide = rng.uniform(8, 17)
            house(x, wide, rng.uniform(8, 19) * (1.15 - 0.5 * t), rng.uniform(3, 7))
            x += wide * rng.uniform(0.8, 1.25)
        else:
            for _ in range(3):
                r = rng.uniform(3, 7)
                px = x + rng.uniform(0, 12)
                mask.ellipse([*place(px - r, 2.1 * r), *place(px + r, -r)], fill=255)
            x += 12
    church = 0.40 * width
    house(church, 11, 27, 0)
    mask.polygon([place(church - 0.5, 27), place(church + 5.5, 54), place(church + 11.5, 27)], fill=255)
    house(church + 10, 30, 15, 9)
    for lamp in np.cumsum(rng.uniform(8, 30, 60)):
        if abs(lamp / width * 2 - 1) < 0.93:
            at = place(lamp + rng.uniform(-1, 1), 3.2)
            lamps.ellipse([at[0] - 3.4, at[1] - 3.4, at[0] + 3.4, at[1] + 3.4], fill=(255, 205, 130))
    mask.rectangle([0, (rows - 1.6) * finer, *big], fill=255)
    coverage = np.asarray(alpha.resize((width, rows), Image.Resampling.BOX)) / 255.0
    glow = np.asarray(light.resize((width, rows), Image.Resampling.BOX)) / 255.0
    save(np.maximum(glow, 0.02), np.maximum(coverage, glow.max(axis=2)), name, 88)


if __name__ == "__main__":
    hills("fireworks_hills.webp")
    town("fireworks_town.webp")
