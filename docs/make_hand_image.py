"""Draw the image of presets/course/hand: a sparkler, lit by its burning tip, which is in the middle of the image.

.venv/bin/python docs/make_hand_image.py
"""

from pathlib import Path

import numpy as np
from PIL import Image

PLACE = Path(__file__).resolve().parent.parent / "presets" / "course" / "hand.webp"
SIDE, FINER = 512, 3
COAT, WIRE = (0.34, 0.30, 0.28), (0.42, 0.42, 0.45)
ALONG = np.array([0.66, -0.75, 0.0])


def rods():
    """(start, end, radius at both, colour) of round rods; x to the right, y upwards, z towards the viewer, tip at 0."""
    yield np.zeros(3), 0.46 * ALONG, 0.013, 0.015, COAT
    yield 0.46 * ALONG, 0.72 * ALONG, 0.007, 0.007, WIRE


def main():
    size = SIDE * FINER
    x, y = np.meshgrid((np.arange(size) + 0.5) / size * 2 - 1, 1 - (np.arange(size) + 0.5) / size * 2)
    height, normal = np.full((size, size), -9.0), np.zeros((size, size, 3))
    paint = np.zeros((size, size, 3))
    for a, b, ra, rb, colour in rods():
        way = b - a
        t = np.clip(((x - a[0]) * way[0] + (y - a[1]) * way[1]) / max(way[:2] @ way[:2], 1e-9), 0, 1)
        radius = ra + (rb - ra) * t
        dx, dy = x - a[0] - t * way[0], y - a[1] - t * way[1]
        inside = radius**2 - dx**2 - dy**2
        rise = np.sqrt(np.maximum(inside, 0))
        z = a[2] + t * way[2] + rise
        here = (inside > 0) & (z > height)
        height[here] = z[here]
        normal[here] = (np.stack([dx, dy, rise], axis=2) / radius[..., None])[here]
        paint[here] = colour
    to_tip = np.stack([-x, -y, 0.12 - height], axis=2)
    distance = np.sqrt((to_tip**2).sum(axis=2))
    facing = np.clip((normal * to_tip).sum(axis=2) / distance, 0, 1)
    warm = np.array([1.0, 0.82, 0.55]) * (0.22 * facing / (0.05 + distance**2))[..., None]
    cool = np.array([0.10, 0.13, 0.22]) * (0.55 + 0.45 * normal[..., 1:2])
    cover = (height > -9) * np.clip((0.98 - np.hypot(x, y)) / 0.35, 0, 1)  # its end goes into the dark
    rgba = np.concatenate([np.clip(paint * (warm + cool), 0, 1) ** (1 / 2.2), cover[..., None]], axis=2)
    rgba[..., :3] *= cover[..., None]
    mean = rgba.reshape(SIDE, FINER, SIDE, FINER, 4).mean(axis=(1, 3))
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-6)
    Image.fromarray((mean * 255 + 0.5).astype(np.uint8)).save(PLACE, quality=88, method=6)


if __name__ == "__main__":
    main()
