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


def weathered(name, columns=512, rows=256):
    """Grey wood along x that stood in the rain for years: fibres, cracks, knots; it repeats along both sides."""
    v, u = (np.mgrid[0:rows, 0:columns] + 0.5) / 64.0
    across, down = columns // 64, rows // 64

    def grain(along, over, seed, x=u, y=v):
        """Noise of so many cells for each 64 pixels along the wood and over it."""
        return noise(x * along, y * over, seed, (round(across * along), round(down * over)))

    wavy = v + 0.25 * grain(0.5, 0.5, 3)
    fibre = sum(a * grain(f, g, 5 + g, y=wavy) for a, f, g in ((1.0, 0.5, 8), (0.7, 1, 16), (0.5, 2, 32)))
    crack = rise(0.24, 0.36, grain(0.5, 16, 11, y=wavy)) * rise(-0.1, 0.2, grain(0.5, 4, 12))
    stain = grain(0.5, 1, 13)
    light = 0.42 * (1 + 0.45 * fibre + 0.5 * stain) * (1 - 0.75 * crack)
    colour = light[..., None] * np.array([1.06, 1.0, 0.90])
    Image.fromarray((np.clip(colour, 0, 1) * 255 + 0.5).astype(np.uint8)).save(FOLDER / name, quality=60, method=6)


def angler(name, columns=512, rows=144):
    """A rowing boat from the side with an angler and his rod, and its mirror image."""
    k = FINER
    shape = Image.new("L", (columns * k, rows * k))
    draw = ImageDraw.Draw(shape)

    def place(x, y):  # m, with the boat's middle at 0 and water at y = 0, 100 pixels a metre
        return ((x * 100 + columns / 2) * k, (rows - y * 100) * k)

    def limb(points, width):
        draw.line([place(*p) for p in points], fill=255, width=int(width * 100 * k), joint="curve")
        for p in points:
            x, y = place(*p)
            r = width * 50 * k
            draw.ellipse([x - r, y - r, x + r, y + r], fill=255)

    t = np.linspace(0, 1, 60)
    rail = [place(-2.1 + 4.2 * a, 0.36 + 0.30 * (2 * a - 1) ** 2 + 0.10 * max(2 * a - 1, 0) ** 3) for a in t]
    keel = [place(2.05 - 4.0 * a, -0.02 + 0.02 * (2 * a - 1) ** 2) for a in (0.06, 0.94)]
    draw.polygon(rail + keel, fill=255)
    limb([(-0.55, 0.42), (-0.50, 0.62), (-0.38, 0.92)], 0.26)  # back
    limb([(-0.38, 0.92), (-0.34, 0.98)], 0.22)
    draw.ellipse([*place(-0.42, 1.28), *place(-0.22, 1.06)], fill=255)  # head
    draw.polygon(
        [place(-0.50, 1.20), place(-0.14, 1.18), place(-0.20, 1.23), place(-0.26, 1.34), place(-0.40, 1.34)], fill=255
    )
    limb([(-0.36, 0.90), (-0.16, 0.66), (0.10, 0.74)], 0.09)  # arm
    limb([(-0.5, 0.48), (-0.1, 0.62), (0.05, 0.42)], 0.14)  # knees
    rod = [(0.0, 0.70), (0.7, 1.02), (1.4, 1.24), (2.1, 1.34)]
    draw.line([place(*p) for p in rod], fill=255, width=int(2.2 * k))
    draw.line([place(2.1, 1.34), place(2.45, 0.0)], fill=90, width=k)
    limb([(0.9, 0.40), (1.35, 0.62)], 0.05)  # an oar over the rail
    alpha = np.asarray(shape.resize((columns, rows), Image.Resampling.BOX)) / 255.0
    mirrored(np.ones((rows, columns, 3)), alpha, name, 70)


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


def noise(x, y, seed, repeat=(256, 256)):
    """A smooth noise from -0.5 to 0.5 at the places x, y (of one shape): random numbers on a grid of side 1, joined smoothly.

    repeat : after how many cells it repeats along x and along y
    """
    across, down = repeat
    grid = np.random.Generator(np.random.PCG64(seed)).random((down, across)) - 0.5
    i, j = np.floor(y).astype(int), np.floor(x).astype(int)
    u, v = ((6 * t - 15) * t**4 + 10 * t**3 for t in (x - j, y - i))
    upper = grid[i % down, j % across] * (1 - u) + grid[i % down, (j + 1) % across] * u
    lower = grid[(i + 1) % down, j % across] * (1 - u) + grid[(i + 1) % down, (j + 1) % across] * u
    return upper * (1 - v) + lower * v


def fractal(x, y, step, first, octaves, fall, seed):
    """Noise of several sizes, from 1 / first on, each half the one before; what is smaller than `step` is left out."""
    total = 0.0
    for k in range(octaves):
        frequency, c, s = first * 2.03**k, np.cos(1.1 * k), np.sin(1.1 * k)
        seen = fall**k * np.exp(-((0.9 * frequency * step) ** 2))
        total = total + seen * noise(
            (x * c - y * s) * frequency + 17.3 * k, (x * s + y * c) * frequency + 5.1 * k, seed + k
        )
    return total


def rise(low, high, t):
    t = np.clip((t - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mirrored(colour, alpha, name, quality):
    """A WebP of this upper half, straight colours and coverage in 0..1, and of the same upside down below it.

    Water hides the lower half, and a mirror, which does not turn images upside down, shows it.
    """
    half = np.concatenate([np.clip(colour, 0, 1), np.clip(alpha, 0, 1)[..., None]], axis=2)
    pixels = (np.concatenate([half, half[::-1]]) * 255 + 0.5).astype(np.uint8)
    Image.fromarray(pixels).save(FOLDER / name, quality=quality, method=6, alpha_quality=70)


def clouds(name, width=768, rows=216, reach=0.75, sun=(0.158, 0.055)):
    """Sheets of cloud and fibres of cirrus above a low sun, seen from below: they are level, so they shrink towards the horizon.

    reach : half the image's width, as the tangent of an angle; sun : where it is, in the same unit
    """
    x = ((np.arange(width) + 0.5) / width * 2 - 1)[None, :] * reach
    y = ((rows - np.arange(rows) - 0.5) / width * 2)[:, None] * reach
    low = y + 0.012  # on a round Earth the layer ends behind the horizon
    east, north = x / low, 1 / low + 0 * x
    east, north = east * np.cos(0.5) - north * np.sin(0.5), east * np.sin(0.5) + north * np.cos(0.5)
    step = 2 * reach / width / low**2 + 0 * x
    bend_x, bend_y = (0.9 * fractal(east, north, step, 0.5, 4, 0.5, seed) for seed in (31, 41))
    sheet = fractal(0.28 * east + bend_x, 0.9 * north + bend_y, step, 0.45, 4, 0.55, 51)
    cells = fractal(east + 0.5 * bend_x, 1.3 * north + 0.5 * bend_y, step, 3.2, 5, 0.55, 61)
    fibres = fractal(0.12 * east + 0.3 * bend_x, 1.6 * north + bend_y, step, 1.4, 6, 0.62, 81)
    fibres = fibres + 0.35 * fractal(east, north, step, 0.3, 3, 0.5, 91)
    thick = 2.4 * rise(0.02, 1.1, 1.6 * sheet + 1.0 * cells) ** 1.1 * rise(0.02, 0.07, y)
    thin = 0.5 * rise(-0.1, 0.8, fibres) * rise(0.02, 0.08, y)
    # thin cloud before the sun is the brightest, as droplets scatter forwards; thick cloud shows its dark side
    away = np.sqrt((x - sun[0]) ** 2 + (y - sun[1]) ** 2)
    forward = np.exp(-away / 0.10) + 0.55 * np.exp(-away / 0.35)
    lit = (1 - np.exp(-1.6 * thick)) * np.exp(-0.9 * thick) + 0.9 * (1 - np.exp(-1.6 * thin)) * np.exp(-0.3 * thin)
    warm, rose, grey = np.array([1.0, 0.60, 0.30]), np.array([0.85, 0.40, 0.32]), np.array([0.17, 0.16, 0.185])
    near = np.clip(forward, 0, 1)[..., None]
    light = (warm * near + rose * (1 - near)) * ((1.5 * forward + 0.14) * lit)[..., None]
    light = light + grey * 0.5 * (1 - np.exp(-0.8 * thick))[..., None]
    # dust near the ground, lit by the red light that is left of a low sun
    dust = (0.48 * np.exp(-y / 0.13) + 0.14) * (0.5 + 0.5 * np.clip(forward, 0, 1))
    red = np.array([1.0, 0.42, 0.17]) * near + np.array([0.62, 0.32, 0.30]) * (1 - near)
    passed = np.exp(-1.15 * thick - 0.6 * thin)
    light = light + red * ((1.15 * forward + 0.25) * dust * (0.4 + 0.6 * passed))[..., None]
    alpha = 1 - passed * (1 - dust)
    straight = light / np.maximum(alpha, 1e-3)[..., None] / 1.6
    mirrored(straight ** (1 / 2.2), alpha, name, 88)


def land(name, top, mist, width=1024, rows=96, reach=0.75, finer=4, grain=0.0):
    """Land up to `top` at the places x of -reach..reach, both as tangents of an angle: white, and paler with mist at its foot.

    top : a function of x; mist : how dark the top is beside the foot, 0..1; grain : of woods on its slopes
    """
    x = ((np.arange(width * finer) + 0.5) / (width * finer) * 2 - 1) * reach
    y = (rows * finer - np.arange(rows * finer) - 0.5)[:, None] / (width * finer) * 2 * reach
    height = top(x)[None, :]
    alpha = (y < height).astype(np.float64)
    shade = 1 - mist * rise(0.0, 1.0, y / np.maximum(height, 1e-6)) * rise(0.0, 0.06, height)
    if grain:
        shade = shade * (1 + grain * fractal(25 * x[None, :] + 0 * y, 60 * y, 0.0, 1.0, 4, 0.6, 71))
    mean = alpha.reshape(rows, finer, width, finer).mean(axis=(1, 3))
    grey = shade.reshape(rows, finer, width, finer).mean(axis=(1, 3))
    mirrored(np.repeat(grey[..., None], 3, axis=2), mean, name, 70)


def ridge(seed, peaks, rough):
    """A function of x: bumps of (place, width, height), and the noise of `rough` of their height."""

    def top(x):
        base = sum(height / (1 + ((x - place) / wide) ** 2) ** 1.5 for place, wide, height in peaks)
        return base * (1 + rough * fractal(x, 0 * x + 0.5, 0.0, 9.0, 7, 0.5, seed))

    return top


def woods(seed, height, tallest, end):
    """A function of x: a shore with spruces and round trees, which ends at x = `end`."""
    rng = np.random.default_rng(seed)
    trees = []
    at = -0.76
    while at < end:
        far = rise(0.0, 0.35, end - at)  # they are smaller, as they are farther away, towards the end
        grove = noise(np.array([at * 14 + 50]), np.array([0.5]), seed)[0]  # spruces and round trees stand together
        tall = tallest * (0.3 + 0.7 * far) * (0.72 + 0.5 * grove) * rng.uniform(0.55, 1.0) ** 0.7
        trees.append((at, tall, rng.uniform() < 0.5 + 1.3 * grove, rng.uniform(0.13, 0.2), rng.integers(1 << 30)))
        at += tallest * (0.3 + 0.7 * far) * rng.uniform(0.02, 0.16)

    def top(x):
        ground = height * rise(0.0, 0.25, end - x) * (1 + 0.5 * fractal(x, 0 * x, 0.0, 5.0, 3, 0.5, seed))
        crown = np.zeros_like(x)
        for place, tall, spruce, slim, each in trees:
            near = np.abs(x - place) < 0.5 * tall
            u = (x[near] - place) / tall
            ragged = 0.16 * noise(u * 40 + 100, 0 * u + 0.5, each % 1000) + 0.12 * noise(
                u * 90 + 200, 0 * u + 0.5, each % 997
            )
            if spruce:
                form = 1 - np.abs(u) / slim * 0.8 + ragged * 1.3
            else:
                form = 0.72 * np.sqrt(np.maximum(1 - (u / (2.0 * slim)) ** 2, 0)) + ragged * 0.6
            form = np.where(np.abs(u) < (1.1 * slim if spruce else 2.0 * slim), form, 0)
            crown[near] = np.maximum(crown[near], tall * np.maximum(form, 0))
        return np.where(x < end, ground + crown, 0)

    return top


def main():
    clouds("lake_clouds.webp")
    far = ridge(3, [(-0.42, 0.16, 0.075), (-0.12, 0.10, 0.045), (0.5, 0.22, 0.085), (0.72, 0.1, 0.03)], 0.5)
    land("lake_mountains.webp", far, 0.35)
    land("lake_hills.webp", ridge(7, [(0.62, 0.26, 0.075), (-0.7, 0.2, 0.03)], 0.55), 0.6, grain=0.12)
    land("lake_woods.webp", woods(9, 0.006, 0.030, -0.03), 0.45, finer=8)
    weathered("weathered_wood.webp")
    angler("lake_angler.webp")
    gull(0.2, 0.02, 0.1, "gull_glide.png")
    gull(0.34, 0.42, -0.12, "gull_up.png")
    gull(0.06, -0.3, 0.2, "gull_down.png")
    reeds("reeds.png")


if __name__ == "__main__":
    main()
