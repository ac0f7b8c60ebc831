"""Draw the images of presets/fire: bark, and the floor of a wood with needles, pebbles and the ash of earlier fires.

.venv/bin/python docs/make_fire_images.py
"""

from pathlib import Path

import numpy as np
from make_lake_images import fractal, noise, rise
from PIL import Image, ImageDraw

FOLDER = Path(__file__).resolve().parent.parent / "presets"


def save(light, name, quality):
    pixels = (np.clip(light, 0, 1) * 255 + 0.5).astype(np.uint8)
    Image.fromarray(pixels).save(FOLDER / name, quality=quality, method=6)


def bark(name, columns=256, rows=256):
    """Plates of bark along y with deep cracks between them; it repeats along both sides."""
    v, u = (np.mgrid[0:rows, 0:columns] + 0.5) / 256.0
    bend = 0.06 * noise(u * 4, v * 4, 3, (4, 4)) + 0.03 * noise(u * 8, v * 8, 4, (8, 8))
    plates = np.minimum(
        np.abs(noise((u + bend) * 32, v * 4, 5, (32, 32))), 1.5 * np.abs(noise((u + bend) * 16, v * 8, 6, (16, 16)))
    )
    crack = 1 - rise(0.02, 0.16, plates)
    grain = noise(u * 64, v * 16, 7, (64, 64)) + 0.6 * noise(u * 128, v * 64, 8, (128, 128))
    light = (0.17 + 0.08 * grain + 0.07 * noise(u * 8, v * 8, 9, (8, 8))) * (1 - 0.85 * crack)
    save(light[..., None] * np.array([1.0, 0.86, 0.72]), name, 70)


def floor(name, side=1024, metres=4.0):
    """Soil with pebbles and needles, grey with ash around the corner, so that it lies around the origin."""
    rng = np.random.default_rng(4)
    v, u = ((np.mgrid[0:side, 0:side] + 0.5) / side - 0.5) * metres
    soil = 0.34 + 0.16 * fractal(u, v, metres / side, 2.0, 6, 0.62, 11) + 0.12 * noise(u * 90, v * 90, 12)
    colour = soil[..., None] * np.array([1.0, 0.80, 0.60])
    picture = Image.fromarray((np.clip(colour, 0, 1) * 255).astype(np.uint8))
    draw = ImageDraw.Draw(picture)
    scale = side / metres
    for _ in range(5200):  # needles, dead grass and twigs
        x, y = rng.uniform(0, side, 2)
        away = np.hypot(x - side / 2, y - side / 2) / scale
        if away < 0.5 + 0.2 * rng.uniform():
            continue
        angle, length = rng.uniform(0, np.pi), rng.uniform(0.02, 0.09) * scale
        tone = rng.uniform(0.35, 1.0)
        base = np.array([(120, 84, 48), (150, 116, 66), (84, 60, 40), (96, 96, 52)][rng.integers(4)])
        ends = [x, y, x + length * np.cos(angle), y + length * np.sin(angle)]
        draw.line([e + 1.2 for e in ends], fill=(22, 16, 11), width=1)
        draw.line(ends, fill=tuple(int(c) for c in base * tone), width=1 + int(rng.uniform() < 0.15))
    for _ in range(420):  # pebbles
        x, y = rng.uniform(0, side, 2)
        r = rng.uniform(0.004, 0.016) * scale
        grey = int(rng.uniform(60, 135))
        draw.ellipse([x - r + 1, y - r + 1.5, x + r + 1, y + r + 1.5], fill=(18, 14, 11))
        draw.ellipse([x - r, y - 0.8 * r, x + r, y + 0.8 * r], fill=(grey, int(0.93 * grey), int(0.85 * grey)))
    colour = np.asarray(picture, np.float64) / 255.0
    away = np.hypot(u, v) + 0.12 * fractal(u, v, metres / side, 3.0, 4, 0.6, 21)
    ash = 1 - rise(0.28, 0.52, away)
    grey = 0.42 + 0.2 * fractal(u, v, metres / side, 9.0, 5, 0.6, 31)
    char = rise(-0.05, 0.25, fractal(u, v, metres / side, 6.0, 4, 0.6, 41))
    bed = (grey * (1 - 0.75 * char))[..., None] * np.array([1.0, 0.97, 0.94])
    light = colour + (bed - colour) * (0.9 * ash)[..., None]
    save(np.roll(light, side // 2, axis=(0, 1)), name, 72)  # a floor's image begins at the origin: there is the ash


if __name__ == "__main__":
    bark("fire_bark.webp")
    floor("fire_floor.webp")
