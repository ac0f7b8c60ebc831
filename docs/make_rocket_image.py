"""Draw the image of presets/course/rocket: a rocket with a pointed nose and three fins, round by its shading.

.venv/bin/python docs/make_rocket_image.py
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

PLACE = Path(__file__).resolve().parent.parent / "presets" / "course" / "rocket.webp"
SIDE, FINER = 512, 4


def main():
    size = SIDE * FINER
    shape, paint = Image.new("L", (size, size)), Image.new("RGB", (size, size), (236, 238, 242))
    cut, colour = ImageDraw.Draw(shape), ImageDraw.Draw(paint)

    def place(x, y):  # in parts of the side, x from the middle, y from below
        return ((0.5 + x) * size, (1 - y) * size)

    half, shoulder, foot = 0.052, 0.70, 0.06
    t = np.linspace(0, 1, 60)
    nose = [(half * np.sqrt(max(1 - s**1.7, 0)), shoulder + 0.26 * s) for s in t]  # an ogive
    body = [(half, foot), *nose, *[(-x, y) for x, y in nose[::-1]], (-half, foot)]
    cut.polygon([place(*p) for p in body], fill=255)
    for side in (-1, 1):
        fin = [(side * half, 0.30), (side * 0.15, 0.12), (side * 0.15, 0.02), (side * half, 0.08)]
        cut.polygon([place(*p) for p in fin], fill=255)
        colour.polygon([place(*p) for p in fin], fill=(196, 44, 38))
    cut.polygon([place(*p) for p in [(-0.034, foot), (-0.046, 0.025), (0.046, 0.025), (0.034, foot)]], fill=255)
    colour.rectangle([*place(-half, 1.0), *place(half, 0.80)], fill=(196, 44, 38))
    for low, high in ((0.60, 0.62), (0.30, 0.40)):
        colour.rectangle([*place(-half, high), *place(half, low)], fill=(40, 44, 54))
    colour.rectangle([*place(-0.05, 0.06), *place(0.05, 0.0)], fill=(52, 50, 52))
    colour.polygon(
        [place(*p) for p in [(-0.008, 0.28), (0.008, 0.28), (0.012, 0.03), (-0.012, 0.03)]], fill=(150, 32, 28)
    )
    x = ((np.arange(size) + 0.5) / size - 0.5)[None, :]
    across = np.clip(x / half, -1, 1)
    light = np.where(np.abs(x) < half, 0.30 + 0.85 * np.clip(0.75 * np.sqrt(1 - across**2) - 0.62 * across, 0, 1), 0.75)
    pixels = np.asarray(paint, np.float64) / 255 * light[..., None]
    rgba = np.concatenate([pixels * 255, np.asarray(shape, np.float64)[..., None]], axis=2)
    mean = np.clip(rgba, 0, 255).reshape(SIDE, FINER, SIDE, FINER, 4).mean(axis=(1, 3))
    Image.fromarray((mean + 0.5).astype(np.uint8)).save(PLACE, quality=85, method=6)


if __name__ == "__main__":
    main()
