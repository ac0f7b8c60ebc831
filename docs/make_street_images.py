"""Draw the images of presets/course/wet_street: fronts of houses and a café, what shines in their windows, setts and slabs.

    .venv/bin/python docs/make_street_images.py

A front is 8 m wide and 8 m high. The lamp of the preset hangs at y = 0, 4 m above the street, and images of walls begin at
y = 0, so each one is turned by half its height. In the reliefs of the preset what is bright stands out.
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "presets" / "course"
FONT = ROOT / "gen_art" / "fonts" / "DejaVuSansCondensed-subset.ttf"
METRE = 128  # pixels
SIDE = 8 * METRE
WARM, DIM, COOL = (255, 176, 92), (226, 120, 52), (150, 180, 220)


def box(draw, x0, y0, x1, y1, fill):
    """A rectangle, in metres from the left and up from the street."""
    draw.rectangle([x0 * METRE, SIDE - y1 * METRE, x1 * METRE - 1, SIDE - y0 * METRE - 1], fill=fill)


def bricks(rng, base):
    """A wall of bricks of 22 x 7.5 cm, each of its own shade, and darker where rain runs down."""
    rows, columns = 107, 37
    shade = rng.uniform(0.72, 1.12, (rows, columns + 1))
    y, x = np.mgrid[0:SIDE, 0:SIDE]
    row = (y * rows) // SIDE
    along = x * columns / SIDE + 0.5 * (row % 2)
    column = along.astype(int) % (columns + 1)
    mortar = ((y * rows / SIDE) % 1 < 0.14) | (along % 1 < 0.05)
    streaks = np.repeat(rng.uniform(0.82, 1.0, SIDE // 16), 16)[None, :]
    value = shade[row, column] * streaks * np.where(mortar, 0.5, 1.0)
    foot = np.clip(0.7 + (SIDE - y) / (1.2 * METRE) * 0.3, 0.0, 1.0)  # wet at its foot
    return Image.fromarray((np.asarray(base) * (value * foot)[..., None]).clip(0, 255).astype(np.uint8))


def window(draw, x, y, width=1.1, height=1.7, frame=(150, 146, 138)):
    """A sash window with a sill, a lintel, a frame and glazing bars; its panes are nearly black. Returns the panes."""
    box(draw, x - 0.12, y + height, x + width + 0.12, y + height + 0.28, (128, 122, 112))
    box(draw, x - 0.14, y - 0.14, x + width + 0.14, y, (150, 144, 134))
    box(draw, x - 0.14, y - 0.2, x + width + 0.14, y - 0.14, (20, 18, 16))
    box(draw, x - 0.03, y, x + width + 0.03, y + height, (14, 12, 11))
    box(draw, x + 0.03, y + 0.03, x + width - 0.03, y + height - 0.03, frame)
    panes = []
    w, h = (width - 0.16) / 2, (height - 0.22) / 3
    for i in range(2):
        for j in range(3):
            left, low = x + 0.06 + i * (w + 0.04), y + 0.07 + j * (h + 0.04)
            panes.append((left, low, left + w, low + h))
            box(draw, *panes[-1], (9, 9, 11))
    return panes


def front(rng):
    """A house with a door and two windows below, three windows above, and a cornice: the picture and the panes by window."""
    wall = bricks(rng, (132, 92, 74))
    draw, panes = ImageDraw.Draw(wall), []
    box(draw, 0, 0, 8, 0.55, (92, 88, 82))
    box(draw, 0, 0.52, 8, 0.56, (40, 38, 36))
    box(draw, 0, 3.55, 8, 3.78, (124, 118, 108))
    box(draw, 0, 3.5, 8, 3.55, (34, 32, 30))
    box(draw, 0, 7.55, 8, 8, (120, 114, 104))
    box(draw, 0, 7.48, 8, 7.55, (24, 22, 20))
    for x in (1.0, 3.3):
        panes.append(window(draw, x, 1.25, 1.2, 1.7))
    for x in (1.0, 3.3, 5.75):
        panes.append(window(draw, x, 4.5, 1.2, 2.0))
    box(draw, 5.55, 0.0, 7.05, 3.05, (126, 120, 110))
    box(draw, 5.72, 0.12, 6.88, 2.95, (12, 11, 10))
    box(draw, 5.78, 0.14, 6.82, 2.35, (38, 58, 50))
    for low, high in ((0.3, 0.95), (1.15, 2.15)):
        for left in (5.9, 6.36):
            box(draw, left, low, left + 0.34, high, (20, 30, 27))
            box(draw, left + 0.03, low + 0.04, left + 0.31, high - 0.03, (44, 66, 57))
    box(draw, 6.66, 1.08, 6.74, 1.16, (190, 160, 90))
    panes.append([(5.8, 2.45, 6.8, 2.88)])  # the light above the door
    box(draw, *panes[-1][0], (9, 9, 11))
    box(draw, 5.4, 0.0, 7.2, 0.12, (140, 134, 124))
    box(draw, 7.72, 0.0, 7.84, 7.5, (52, 52, 52))  # a downpipe
    for y in (1.0, 3.0, 5.0, 7.0):
        box(draw, 7.69, y, 7.87, y + 0.07, (80, 80, 80))
    return wall, panes


def shine(size, lit, rng):
    """The light of windows: `lit` lists panes of windows, their colours and brightness."""
    light = np.zeros((SIDE, size, 3))
    for panes, colour, strength, shift in lit:
        left, right = min(p[0] for p in panes), max(p[2] for p in panes)
        low, high = min(p[1] for p in panes), max(p[3] for p in panes)
        curtain = rng.uniform(0.16, 0.3)
        for x0, y0, x1, y1 in panes:
            i0, i1 = int(SIDE - y1 * METRE), int(SIDE - y0 * METRE)
            j0, j1 = int((x0 + shift) * METRE), int((x1 + shift) * METRE)
            y, x = np.mgrid[i0:i1, j0:j1]
            u = (x / METRE - shift - left) / (right - left)
            v = ((SIDE - y) / METRE - low) / (high - low)
            value = 0.35 + 0.65 * np.exp(-((u - 0.55) ** 2) / 0.12 - (v - 0.85) ** 2 / 0.25)
            folds = 0.5 + 0.12 * np.sin(u * 90.0)
            value = np.where((u < curtain) | (u > 1 - curtain), folds * value, value)
            light[i0:i1, j0:j1] = (strength * value)[..., None] * np.asarray(colour)
    return Image.fromarray(light.clip(0, 255).astype(np.uint8))


def cafe(rng):
    """A café: its front, and what shines in it, with guests as dark forms before the lit room."""
    wall, panes = front(rng)
    draw, light = ImageDraw.Draw(wall), Image.new("RGB", (SIDE, SIDE))
    lit = shine(SIDE, [(panes[3], WARM, 0.5, 0.0)], rng)
    glow = ImageDraw.Draw(light)
    green, dark = (24, 46, 40), (10, 18, 16)
    box(draw, 0.3, 0.0, 7.6, 3.5, green)
    box(draw, 0.3, 3.42, 7.6, 3.5, (60, 80, 70))
    box(draw, 0.45, 2.82, 7.45, 3.36, dark)
    font = ImageFont.truetype(str(FONT), 62)
    draw.text((4.0 * METRE, SIDE - 3.09 * METRE), "C A F É   D U   P O N T", (196, 160, 88), font=font, anchor="mm")
    # the room behind the glass: a wall lit from above, shelves with bottles, a counter, lamps and guests
    glass = [(0.6, 0.7, 2.35, 2.7), (2.45, 0.7, 4.2, 2.7), (5.75, 0.7, 7.3, 2.7), (4.5, 0.9, 5.45, 2.45)]
    y, x = np.mgrid[0:SIDE, 0:SIDE] / METRE
    up = 8.0 - y
    room = 0.28 + 0.72 * np.exp(-((up - 2.6) ** 2) / 1.2) * (0.7 + 0.3 * np.cos((x - 1.4) * 2.6))
    room_light = Image.fromarray((room[..., None] * np.array(WARM) * 0.8).clip(0, 255).astype(np.uint8))
    inside = ImageDraw.Draw(room_light)
    for shelf in (1.55, 1.95):
        box(inside, 0.6, shelf - 0.05, 4.2, shelf, (70, 34, 12))
        for k in range(26):
            left = 0.68 + 0.135 * k
            height = rng.uniform(0.16, 0.3)
            tint = [(60, 90, 30), (120, 50, 14), (170, 110, 40), (36, 20, 10)][int(rng.integers(4))]
            box(inside, left, shelf, left + 0.075, shelf + 0.7 * height, tint)
            box(inside, left + 0.025, shelf + 0.7 * height, left + 0.05, shelf + height, tint)
    box(inside, 0.6, 0.7, 4.2, 1.12, (60, 28, 10))
    box(inside, 5.75, 0.7, 7.3, 1.0, (60, 28, 10))
    for lamp in (1.2, 2.9, 6.5):
        cx, cy = lamp * METRE, SIDE - 2.34 * METRE
        inside.line([cx, cy - 60, cx, cy], fill=(30, 16, 8), width=3)
        inside.pieslice([cx - 26, cy - 22, cx + 26, cy + 22], 180, 360, fill=(255, 236, 180))
    for guest, tall, hat in ((1.75, 1.66, 1), (3.55, 1.5, 0), (3.02, 1.46, 0), (6.25, 1.62, 1)):
        cx, head, dark_form = guest * METRE, SIDE - tall * METRE, (24, 11, 5)
        inside.ellipse([cx - 13, head - 17, cx + 13, head + 17], fill=dark_form)
        if hat:
            inside.rectangle([cx - 23, head - 13, cx + 23, head - 9], fill=dark_form)
            inside.rectangle([cx - 13, head - 26, cx + 13, head - 10], fill=dark_form)
        shoulders = [
            (cx - 7, head + 8),
            (cx + 7, head + 8),
            (cx + 9, head + 24),
            (cx + 31, head + 33),
            (cx + 38, head + 60),
        ]
        arms = [
            (cx + 40, SIDE - 0.7 * METRE),
            (cx - 40, SIDE - 0.7 * METRE),
            (cx - 38, head + 60),
            (cx - 31, head + 33),
        ]
        inside.polygon([*shoulders, *arms, (cx - 9, head + 24)], fill=dark_form)
    room_light = room_light.filter(ImageFilter.GaussianBlur(2.2))  # steam on the glass
    for x0, y0, x1, y1 in glass:
        box(draw, x0 - 0.07, y0 - 0.07, x1 + 0.07, y1 + 0.07, (58, 84, 74))
        box(draw, x0, y0, x1, y1, (8, 8, 9))
        area = (int(x0 * METRE), int(SIDE - y1 * METRE), int(x1 * METRE), int(SIDE - y0 * METRE))
        light.paste(room_light.crop(area), area[:2])
    for x0, y0, x1, _ in (*glass[:3],):
        box(draw, x0, 2.22, x1, 2.27, (58, 84, 74))
        box(glow, x0, 2.22, x1, 2.27, (4, 4, 4))
        box(draw, x0, 0.12, x1, y0 - 0.16, (34, 62, 54))
    box(glow, 4.95, 0.9, 5.0, 2.45, (6, 6, 5))
    light.paste(lit.crop((0, 0, SIDE, SIDE // 2)), (0, 0))
    for y0 in range(2):
        box(glow, 4.5, 1.3 + 0.6 * y0, 5.45, 1.34 + 0.6 * y0, (6, 6, 5))
    return wall, light


def stones(rng, side, rows, columns, joint, rough, low, high):
    """Domed stones in courses with joints, repeated, as grey values from low to high."""
    y, x = np.mgrid[0:side, 0:side] / side
    row = (y * rows).astype(int) % rows
    offset = 0.5 * (row % 2) + rng.uniform(-0.12, 0.12, rows)[row]
    along = (x * columns + offset) % columns
    column = along.astype(int)
    u, v = along % 1, (y * rows) % 1
    across, down = np.minimum(u, 1 - u) * rows / columns * 1.0, np.minimum(v, 1 - v)
    edge = np.minimum(across * columns / rows / joint, down / (joint * columns / rows) * (columns / rows))
    dome = np.clip(edge, 0, 1)
    dome = dome * dome * (3 - 2 * dome)
    level = rng.uniform(0.62, 1.0, (rows, columns))[row, column]
    lean = rng.uniform(-rough, rough, (2, rows, columns))
    tilt = lean[0][row, column] * (u - 0.5) + lean[1][row, column] * (v - 0.5)
    grain = rng.uniform(-1, 1, (side, side))
    for _ in range(2):
        grain = (grain + sum(np.roll(grain, s, a) for a in (0, 1) for s in (-1, 1))) / 5
    value = dome * (level + tilt + 0.12 * rough * grain)
    return Image.fromarray((low + (high - low) * value.clip(0, 1)).astype(np.uint8))


def main():
    rng = np.random.default_rng(7)
    house, panes = front(rng)
    coffee, coffee_light = cafe(rng)
    lit = [
        (panes[2], WARM, 0.75, 0.0),
        (panes[1], DIM, 0.7, 8.0),
        (panes[4], COOL, 0.4, 8.0),
        (panes[3], WARM, 0.7, 16.0),
    ]
    lit += [(panes[5], WARM, 0.8, 0.0), (panes[0], DIM, 0.6, 16.0), (panes[5], DIM, 0.7, 16.0)]
    windows = shine(3 * SIDE, lit, rng).resize((3 * SIDE // 2, SIDE // 2), Image.Resampling.BOX)
    turned = lambda image: Image.fromarray(np.roll(np.asarray(image), image.height // 2, axis=0))  # noqa: E731
    pictures = {
        "street_front": turned(house),
        "street_cafe": turned(coffee),
        "street_cafe_light": turned(coffee_light),
        "street_windows": turned(windows),
    }
    for name, image in pictures.items():
        image.quantize(64, dither=Image.Dither.NONE).save(FOLDER / f"{name}.png", optimize=True)
    stones(rng, 256, 14, 9, 0.16, 0.5, 14, 120).save(FOLDER / "street_setts.png", optimize=True)
    stones(rng, 256, 3, 2, 0.018, 0.0, 40, 130).save(FOLDER / "street_slabs.png", optimize=True)


if __name__ == "__main__":
    main()
