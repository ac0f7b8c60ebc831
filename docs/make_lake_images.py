"""Draw the images of presets/course/lake: gulls in three positions of their wings, reeds, hills and woods.

    .venv/bin/python docs/make_lake_images.py

All are white with transparency, so that the preset's colours are theirs.
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

FOLDER = Path(__file__).resolve().parent.parent / "presets" / "course"
FINER = 8  # times the picture's pixels, in which forms are drawn before they are averaged


def save(shape, side, name):
    alpha = shape.resize((side, side), Image.Resampling.BOX)
    image = Image.new("RGBA", (side, side), (255, 255, 255, 0))
    image.putalpha(alpha)
    image.save(FOLDER / name, optimize=True)


def gull(lift, tip, lean, name, side=128):
    """A gull from behind: `lift` and `tip` are the heights of its wrists and wing tips, `lean` the slope of a turn."""
    size = side * FINER
    shape = Image.new("L", (size, size))
    draw = ImageDraw.Draw(shape)
    along = np.linspace(0, 1, 80)
    for hand in (-1, 1):
        x = hand * along * (1.0 - 0.12 * abs(tip))
        bend = np.where(
            along < 0.42,
            lift * np.sin(along / 0.42 * np.pi / 2),
            lift + (tip - lift) * (np.maximum(along - 0.42, 0) / 0.58) ** 1.3,
        )
        y = bend + lean * x
        half = 0.05 * (1 - along) ** 0.55 + 0.006
        half = half * np.where(along < 0.42, 1.0, 0.9)
        upper, lower = np.stack([x, y + half], 1), np.stack([x, y - 0.8 * half], 1)[::-1]
        points = np.concatenate([upper, lower]) * (0.46 * size, -0.46 * size) + 0.5 * size
        draw.polygon([tuple(p) for p in points], fill=255)
    middle, width, height = 0.5 * size, 0.048 * size, 0.058 * size
    draw.ellipse([middle - width, middle - 0.6 * height, middle + width, middle + 1.4 * height], fill=255)
    save(shape, side, name)


def reeds(name, side=512):
    """A clump of reeds with leaves and plumes, leaning with the wind."""
    rng = np.random.default_rng(5)
    size = side * 4
    shape = Image.new("L", (size, size))
    draw = ImageDraw.Draw(shape)
    t = np.linspace(0, 1, 60)
    for _ in range(26):
        foot, top = rng.uniform(0.2, 0.8), rng.uniform(0.45, 0.96)
        lean = rng.uniform(-0.05, 0.2)
        x, y = foot + lean * t**2, 1.0 - top * t
        half = 0.0028 * (1.0 - 0.7 * t)
        stem = np.concatenate([np.stack([x - half, y], 1), np.stack([x + half, y], 1)[::-1]]) * size
        draw.polygon([tuple(p) for p in stem], fill=255)
        for _ in range(3):
            at = int(rng.integers(10, 42))
            long, side_of, droop = rng.uniform(0.14, 0.34), rng.choice([-1, 1, 1]), rng.uniform(0.3, 1.0)
            lx = x[at] + side_of * long * (0.22 * t + 0.4 * t**2)
            ly = y[at] - long * (1.0 * t - 0.6 * droop * t**3)
            wide = 0.0045 * np.sin(np.pi * np.clip(t * 0.97 + 0.03, 0, 1)) ** 0.6
            leaf = np.concatenate([np.stack([lx, ly - wide], 1), np.stack([lx, ly + wide], 1)[::-1]]) * size
            draw.polygon([tuple(p) for p in leaf], fill=255)
        if rng.uniform() < 0.7:  # a plume
            for _ in range(90):
                u = rng.uniform(0.0, 1.0)
                px, py = x[-1] + 0.006 * (1 - u), y[-1] + 0.1 * u - 0.04
                out = 0.03 * np.sin(np.pi * (0.12 + 0.88 * u)) * rng.uniform(-0.35, 1.0)
                ends = [px * size, py * size, (px + out) * size, (py - 0.02 + 0.6 * abs(out)) * size]
                draw.line(ends, fill=255, width=max(2, int(0.0014 * size)))
    save(shape, side, name)


def shore(name, seed, height, rough, fade, side=1024):
    """A far shore, and the same upside down below the middle of the picture, where water hides it and a mirror shows it.

    height : of the land, in sides; rough : of its outline, as trees make it; fade : how much of the right it leaves free
    """
    rng = np.random.default_rng(seed)
    x = (np.arange(side * 2) + 0.5) / (side * 2)
    land = np.zeros(side * 2)
    for k in range(1, 9):
        land += rng.uniform(0.4, 1.0) / k**1.25 * np.sin(2 * np.pi * (k * 0.9 * x + rng.uniform()))
    land = 0.55 + 0.45 * land / np.abs(land).max()
    trees = np.zeros(side * 2)
    for _ in range(int(rough * 1600)):
        at, wide, tall = rng.uniform(), rng.uniform(0.001, 0.004), rng.uniform(0.3, 1.0)
        trees = np.maximum(trees, tall * np.sqrt(np.maximum(1 - ((x - at) / wide) ** 2, 0)))
    top = height * (land + rough * trees)
    top *= np.clip((1.0 - fade - x) / 0.14, 0, 1) ** 0.6 if fade else 1.0
    y = np.abs(np.arange(side * 4) + 0.5 - side * 2) / (side * 4)
    shape = (y[:, None] < top[None, :]).astype(np.uint8) * 255
    alpha = Image.fromarray(shape).resize((side, side), Image.Resampling.BOX)
    image = Image.new("RGBA", (side, side), (255, 255, 255, 0))
    image.putalpha(alpha)
    image.save(FOLDER / name, optimize=True)


def main():
    shore("hills.png", 4, 0.05, 0.0, 0.0)
    shore("woods.png", 9, 0.016, 0.7, 0.42)
    gull(0.2, 0.02, 0.1, "gull_glide.png")
    gull(0.34, 0.42, -0.12, "gull_up.png")
    gull(0.06, -0.3, 0.2, "gull_down.png")
    reeds("reeds.png")


if __name__ == "__main__":
    main()
