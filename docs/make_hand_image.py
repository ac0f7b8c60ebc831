"""Draw the image of presets/course/hand: a fist with a sparkler, lit by its tip, which is in the middle of the image.

.venv/bin/python docs/make_hand_image.py
"""

from pathlib import Path

import numpy as np
from PIL import Image

PLACE = Path(__file__).resolve().parent.parent / "presets" / "course" / "hand.webp"
SIDE, FINER = 512, 3
SKIN, SLEEVE, WIRE = (0.86, 0.58, 0.44), (0.13, 0.15, 0.24), (0.30, 0.30, 0.32)
ALONG, ACROSS = np.array([0.66, -0.75, 0.0]), np.array([0.75, 0.66, 0.0])  # the wire, and the fingers around it


def rods():
    """(start, end, radius at both, colour) of round rods; x to the right, y upwards, z towards the viewer, tip at 0."""
    fist = 0.50 * ALONG
    yield np.zeros(3), 0.68 * ALONG, 0.006, 0.006, WIRE
    for k, length in enumerate((0.055, 0.064, 0.066, 0.058)):
        at = fist + (0.036 * k - 0.05) * ALONG + np.array([0, 0, 0.03])
        yield at - length * ACROSS, at + 0.05 * ACROSS, 0.02, 0.023, SKIN
        yield at + 0.05 * ACROSS, at + 0.06 * ACROSS - np.array([0, 0, 0.05]), 0.023, 0.025, SKIN
    yield (
        fist - 0.05 * ALONG + 0.03 * ACROSS,
        fist + 0.06 * ALONG + 0.04 * ACROSS,
        0.05,
        0.058,
        SKIN,
    )  # the back of the hand
    yield fist - 0.075 * ALONG - 0.055 * ACROSS, fist - 0.06 * ALONG + 0.045 * ACROSS, 0.019, 0.026, SKIN  # the thumb
    wrist, elbow = fist + np.array([0.10, -0.05, -0.02]), fist + np.array([0.62, -0.42, -0.1])
    yield fist + 0.03 * ACROSS, wrist, 0.055, 0.046, SKIN
    yield wrist + 0.2 * (elbow - wrist) * 0.6, elbow, 0.066, 0.09, SLEEVE


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
    cover = (height > -9) * np.clip((0.98 - np.hypot(x, y)) / 0.35, 0, 1)  # the arm goes into the dark
    rgba = np.concatenate([np.clip(paint * (warm + cool), 0, 1) ** (1 / 2.2), cover[..., None]], axis=2)
    rgba[..., :3] *= cover[..., None]
    mean = rgba.reshape(SIDE, FINER, SIDE, FINER, 4).mean(axis=(1, 3))
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-6)
    Image.fromarray((mean * 255 + 0.5).astype(np.uint8)).save(PLACE, quality=88, method=6)


if __name__ == "__main__":
    main()
