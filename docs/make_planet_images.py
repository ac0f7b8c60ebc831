"""Draws the planets of the course, lit from one side: presets/course/planet_*.webp; and the bands of Saturn, unlit.

python docs/make_planet_images.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

SIZE = 1000  # pixels of the image
RIM = 1.06  # radii from the middle of the image to its edge: the air reaches a little beyond the ground


def fractal(x, seed, first, octaves, gain=0.55):
    """Smooth noise about 0 of the points x (..., 3), in octaves; `first` waves in one radius."""
    lattice = np.random.default_rng(seed).standard_normal((64, 64, 64))
    total, weight = 0.0, 1.0
    for octave in range(octaves):
        place = x * first * 2**octave + 17.3 * octave
        corner = np.floor(place).astype(int)
        t = place - corner
        t = t * t * (3 - 2 * t)
        value = 0.0
        for k in range(8):
            bits = np.array([k & 1, k >> 1 & 1, k >> 2 & 1])
            share = np.prod(np.where(bits == 1, t, 1 - t), axis=-1)
            a, b, c = np.moveaxis((corner + bits) % 64, -1, 0)
            value = value + share * lattice[a, b, c]
        total, weight = total + weight * value, weight * gain
    return total


def rise(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mix(one, other, share):
    return one + (np.asarray(other, float) - one) * share[..., None]


def ball(tilt, radius, below):
    """(distance from the planet's middle in radii, normals towards the viewer, the same in the planet's own axes).

    radius, below : its radius, and how far its middle is below that of the image, in halves of the image's side over RIM
    """
    v, u = RIM * (1 - (np.mgrid[0:SIZE, 0:SIZE] + 0.5) / SIZE * 2) * np.array([1, -1])[:, None, None]
    v, u = (v + below) / radius, u / radius
    far = np.hypot(u, v)
    normal = np.stack([u, v, np.sqrt(np.clip(1 - far**2, 0, None))], axis=-1)
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    return far, normal, normal @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]).T


def ocean(own):
    """Seas, land and clouds: (colours, how much each place shines like water)."""
    height = fractal(own + 3.1, 5, 1.4, 7) + 0.25 * np.abs(own[..., 1]) - 0.5
    land = rise(0.0, 0.06, height)
    dry = rise(-0.3, 0.7, fractal(own, 8, 3, 5) + 0.8 * np.exp(-(((np.abs(own[..., 1]) - 0.4) / 0.18) ** 2)))
    sea = mix(np.array([0.01, 0.045, 0.13]), [0.03, 0.16, 0.24], rise(-0.35, 0.0, height))
    ground = mix(np.array([0.06, 0.12, 0.035]) + 0 * own, [0.42, 0.31, 0.17], dry)
    ground = mix(ground, [0.25, 0.22, 0.2], rise(0.5, 1.2, height))
    colour = mix(sea, ground, land)
    colour = mix(colour, [0.85, 0.88, 0.92], rise(0.86, 0.93, np.abs(own[..., 1]) + 0.05 * fractal(own, 9, 6, 4)))
    swirl = own + 0.16 * np.stack([fractal(own, seed, 2.5, 4) for seed in (21, 22, 23)], axis=-1)
    cloud = rise(0.15, 1.1, fractal(swirl * np.array([1, 1.7, 1]), 13, 2.6, 7, 0.6) + 0.1)
    return mix(colour, [0.92, 0.93, 0.95], 0.92 * cloud), (1 - land) * (1 - cloud)


def seas(own):
    """Seas and clouds from a low orbit: (colours, how much each place shines like water)."""
    own = own[..., [0, 2, 1]] * np.array([3, 3, 0.2])  # no ice
    sea = mix(np.array([0.008, 0.035, 0.11]) + 0 * own, [0.015, 0.06, 0.14], rise(-0.6, 0.8, fractal(own, 4, 2, 5)))
    own = own * np.array([1, 1, 15])
    swirl = own + 0.12 * np.stack([fractal(own, seed, 3, 4) for seed in (21, 22, 23)], axis=-1)
    fields = rise(-0.7, 0.7, fractal(swirl, 15, 1.6, 4))
    cloud = fields * rise(-0.5, 1.1, fractal(swirl, 13, 9, 7, 0.68))
    return mix(sea, [0.92, 0.93, 0.95], 0.95 * cloud), 0.3 * (1 - cloud)


def draw(path, surface, sun, tilt, air, night, radius=1.0, below=0.0):
    """A planet below light from `sun`; its air scatters the colour `air` at the rim of its lit side."""
    far, normal, own = ball(tilt, radius, below)
    sun = np.array(sun, float) / np.linalg.norm(sun)
    colour, shine = surface(own)
    light = normal @ sun
    half = (sun + np.array([0, 0, 1])) / np.linalg.norm(sun + np.array([0, 0, 1]))
    day = np.clip(light + 0.02, 0, 1) ** 0.9
    dusk = np.exp(-(((light - 0.03) / 0.09) ** 2))
    lit = colour * (day[..., None] + dusk[..., None] * np.array([0.09, 0.03, 0.0])) + colour * night
    lit += (shine * 0.7 * np.clip(normal @ half, 0, 1) ** 60 * day)[..., None] * np.array([1.0, 0.95, 0.85])
    haze = (1 - normal[..., 2]) ** 3 * np.clip(light + 0.25, 0, 1)
    lit = lit + 0.8 * haze[..., None] * np.array(air)
    edge = 1.5 / SIZE / radius
    inside = rise(1.0 + edge, 1.0 - edge, far)
    towards = (
        np.stack([*np.moveaxis(normal[..., :2] / np.maximum(far, 1e-9)[..., None], -1, 0), 0 * far], axis=-1) @ sun
    )
    glow = (
        np.exp(-np.clip(far - 1, 0, None) / 0.012 * radius) * np.clip(towards + 0.25, 0, 1) * (far < RIM) * (1 - inside)
    )
    out = lit * inside[..., None] + glow[..., None] * np.array(air) * 0.9
    alpha = np.clip(inside + 0.8 * glow, 0, 1)
    out = out / np.maximum(alpha, 1e-6)[..., None]
    srgb = np.where(out < 0.0031308, 12.92 * out, 1.055 * np.clip(out, 1e-9, None) ** (1 / 2.4) - 0.055)
    pixels = np.dstack([np.clip(srgb, 0, 1), alpha]) * 255 + 0.5
    Image.fromarray(pixels.astype(np.uint8)).save(path, quality=82, method=6)


SATURN = (
    (1.0, (128, 122, 102)), (0.985, (150, 138, 110)), (0.943, (172, 155, 120)), (0.887, (198, 177, 136)),
    (0.831, (176, 153, 111)), (0.775, (204, 180, 136)), (0.719, (193, 167, 122)), (0.663, (203, 177, 133)),
    (0.607, (216, 190, 144)), (0.551, (212, 181, 134)), (0.495, (221, 193, 146)), (0.439, (204, 176, 129)),
    (0.383, (211, 180, 131)), (0.327, (204, 172, 121)), (0.271, (208, 176, 127)), (0.215, (228, 204, 158)),
    (0.159, (236, 214, 176)), (0.103, (246, 230, 190)), (0.047, (233, 215, 177)), (-0.009, (244, 226, 185)),
    (-0.065, (252, 235, 195)), (-0.121, (236, 214, 173)), (-0.177, (224, 200, 156)), (-0.29, (220, 191, 141)),
    (-0.402, (212, 180, 128)), (-0.57, (204, 173, 125)), (-0.738, (207, 178, 131)), (-0.85, (195, 168, 123)),
    (-0.906, (176, 156, 113)), (-1.0, (140, 128, 100)),
)  # the sine of the latitude, and the colour there  # fmt: skip


def saturn(path, width=512, height=1024):
    """Saturn's clouds by latitude, 13 wide and 26 high: the globe from the side in the middle, its pole at the corners."""
    y, x = (np.mgrid[0:height, 0:width] + 0.5) / width * 13
    from_axis = np.hypot(np.minimum(x, 13 - x), np.minimum(y, 26 - y))
    above = np.sqrt(np.clip(1 - (np.clip(from_axis - 0.5904, 0, None) / 5.4364) ** 2, 0, 1))
    sine = np.where(np.abs(13 - y) < 6.4, np.clip((13 - y) / 5.4364, -1, 1), above)
    at, colours = np.array([s for s, _ in SATURN[::-1]]), np.array([c for _, c in SATURN[::-1]]) / 255
    linear = np.where(colours > 0.04045, ((colours + 0.055) / 1.055) ** 2.4, colours / 12.92)
    colour = np.stack([np.interp(sine, at, linear[:, k]) for k in range(3)], axis=-1)
    fine = fractal(np.stack([sine, 0 * sine, 0 * sine], axis=-1), 7, 20, 4, 0.85)[..., None]
    grey = colour.mean(axis=-1, keepdims=True)
    colour = 0.41 * (grey + 1.3 * (colour - grey)) * (1 + 0.07 * fine * np.array([0.8, 1, 1.3])) * (grey / 0.5) ** 0.6
    srgb = np.where(colour < 0.0031308, 12.92 * colour, 1.055 * np.clip(colour, 1e-9, None) ** (1 / 2.4) - 0.055)
    Image.fromarray((np.clip(srgb, 0, 1) * 255 + 0.5).astype(np.uint8)).save(path, quality=90, method=6)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent.parent / "presets" / "course"
    draw(folder / "planet_ocean.webp", ocean, (-0.75, 0.45, 0.5), 20, (0.25, 0.5, 1.0), 0.004)
    draw(folder / "planet_limb.webp", seas, (-0.3, 0.75, 0.6), 12, (0.25, 0.5, 1.0), 0.004, 5.0, 5.1)
    saturn(folder / "saturn_bands.webp")
