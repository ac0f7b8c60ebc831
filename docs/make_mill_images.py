"""Draw the images of presets/course/mill.yaml: the colours and the relief of an old wall of rubble, mossy where it is damp.

    .venv/bin/python docs/make_mill_images.py

Images of walls begin where the world's coordinates are 0, so the rows are rolled to have the foot of the wall where the water is.
"""

from pathlib import Path

import numpy as np
from make_street_images import noise
from PIL import Image

FOLDER = Path(__file__).resolve().parent.parent / "presets" / "course"
SIDE, WIDTH, FOOT = 1024, 5.0, -1.3  # texels, m, m: the image is as high as it is wide, from FOOT up
STONES = [(150, 134, 106), (128, 116, 98), (168, 148, 112), (112, 104, 94), (140, 116, 86), (98, 94, 90)]
OFTEN = [0.28, 0.22, 0.18, 0.14, 0.1, 0.08]


def cells(rng):
    """Rectangles (left, bottom, right, top), m: courses of unequal height; now and then two or three stones lie on each other."""
    bottom = 0.0
    heights = rng.choice([0.13, 0.17, 0.21, 0.26, 0.32], 40, p=[0.2, 0.25, 0.25, 0.2, 0.1]) * rng.uniform(0.9, 1.1, 40)
    total = np.cumsum(heights)
    heights = heights[: np.searchsorted(total, WIDTH)]
    for height in heights * WIDTH / heights.sum():
        widths = height * rng.uniform(0.9, 3.0, 80)
        widths = widths[: np.searchsorted(np.cumsum(widths), WIDTH)]
        left = rng.uniform(0, WIDTH)
        for width in widths * WIDTH / widths.sum():
            if height > 0.2 and rng.random() < 0.34:
                cut = height * rng.uniform(0.35, 0.65)
                part = width * rng.uniform(0.35, 0.65)
                yield left, bottom, left + width, bottom + cut
                if width > 0.4:
                    yield left, bottom + cut, left + part, bottom + height
                    yield left + part, bottom + cut, left + width, bottom + height
                else:
                    yield left, bottom + cut, left + width, bottom + height
            else:
                yield left, bottom, left + width, bottom + height
            left += width
        bottom += height


def wall(rng):
    """Colours 0..255 and heights 0..1 of the wall, row 0 at its top; both repeat."""
    step = WIDTH / SIDE
    y, x = np.mgrid[0:SIDE, 0:SIDE] * step
    up = WIDTH - y
    bent_x = x + 0.016 * noise(rng, SIDE, 14, 3, 0.6)
    bent_y = up + 0.013 * noise(rng, SIDE, 10, 3, 0.6)
    edge, height, colour = np.full((SIDE, SIDE), -1.0), np.zeros((SIDE, SIDE)), np.zeros((SIDE, SIDE, 3))
    for left, bottom, right, top in cells(rng):
        middle, half = ((left + right) / 2, (bottom + top) / 2), ((right - left) / 2, (top - bottom) / 2)
        dx = (bent_x - middle[0] + WIDTH / 2) % WIDTH - WIDTH / 2
        dy = (bent_y - middle[1] + WIDTH / 2) % WIDTH - WIDTH / 2
        turn = rng.normal(0, 0.035)
        dx, dy = dx + turn * dy, dy - turn * dx
        gap, corner = rng.uniform(0.003, 0.012), rng.uniform(0.02, 0.06)
        qx, qy = abs(dx) - half[0] + gap + corner, abs(dy) - half[1] + gap + corner
        inner = corner - np.hypot(np.maximum(qx, 0), np.maximum(qy, 0)) - np.minimum(np.maximum(qx, qy), 0)
        here = inner > np.maximum(edge, 0)
        lean = rng.normal(0, 0.28, 2)
        level = rng.uniform(0.55, 0.9) + lean[0] * dx + lean[1] * dy
        tone = np.array(STONES)[rng.choice(len(STONES), p=OFTEN)] * rng.uniform(0.72, 1.14)
        edge, height = np.where(here, inner, edge), np.where(here, level, height)
        colour[here] = tone
    inside = np.clip(edge / 0.016, 0, 1)
    round_ = np.sqrt(1 - (1 - np.clip(edge / 0.03, 0, 1)) ** 2)
    rough = 0.09 * noise(rng, SIDE, 60, 4, 0.75) + 0.05 * noise(rng, SIDE, 16, 2)
    height = np.clip(np.where(edge > 0, round_ * (height + rough), 0) + (edge <= 0) * (0.08 + 0.4 * rough), 0, 1)
    grain = 1 + 0.10 * noise(rng, SIDE, 90, 3, 0.8) + 0.09 * noise(rng, SIDE, 9, 3, 0.6)
    mortar = np.array([92, 84, 70]) * (1 + 0.1 * noise(rng, SIDE, 70, 2))[..., None]
    colour = grain[..., None] * (colour * inside[..., None] + mortar * (1 - inside[..., None]))
    # lichen in pale spots; damp, darker and greener towards the foot, with moss in joints and on what is damp
    above = up + FOOT + 1.05  # the water
    lichen = np.clip((noise(rng, SIDE, 26, 3, 0.7) - 1.35) * 2, 0, 0.55)[..., None] * (above > 0.7)[..., None]
    colour = colour + lichen * (np.array([176, 172, 140]) - colour)
    tide = above + 0.13 * noise(rng, SIDE, 7, 4, 0.65)
    damp = 1 / (1 + np.exp((tide - 0.55) / 0.09))
    colour = colour * (1 - damp[..., None] * np.array([0.56, 0.53, 0.62]))
    spots = noise(rng, SIDE, 24, 4, 0.75) + 1.1 * (1 - inside) - 0.35 * inside
    want = np.exp(-(((tide - 0.42) / 0.34) ** 2)) * 1.7 - 0.75 - 1.2 * (tide < 0.1) - 0.7 * np.clip(tide - 0.8, 0, 1)
    moss = np.clip((spots + 1.4 * want - 0.2) * 2.2, 0, 0.92)[..., None]
    green = (
        np.array([58, 68, 20]) * (1 + 0.36 * noise(rng, SIDE, 120, 2))[..., None]
        + np.array([22, 16, 4]) * noise(rng, SIDE, 18, 2)[..., None]
    )
    colour = colour + moss * (np.clip(green, 8, 120) - colour)
    height = np.clip(height + 0.25 * moss[..., 0] * (0.4 + 0.35 * noise(rng, SIDE, 110, 2)), 0, 1)
    slime = 1 / (1 + np.exp((above + 0.03 * noise(rng, SIDE, 20, 3) - 0.1) / 0.02))
    colour = colour * (1 - 0.6 * slime[..., None])
    rows = round(FOOT / WIDTH * SIDE)  # so that the row of height 0 is the lower edge
    return np.roll(colour, -rows, axis=0), np.roll(height, -rows, axis=0)


if __name__ == "__main__":
    colours, heights = wall(np.random.default_rng(5))
    Image.fromarray(np.clip(colours, 0, 255).astype(np.uint8)).save(FOLDER / "mill_wall.webp", quality=42, method=6)
    Image.fromarray((255 * heights).astype(np.uint8)).save(FOLDER / "mill_wall_relief.webp", quality=26, method=6)
    for name in ("mill_wall.webp", "mill_wall_relief.webp"):
        print(name, (FOLDER / name).stat().st_size, "bytes")
