"""Checkers and images on a floor seen at an angle: means over the pixel's footprint, and no moire towards the horizon."""

import math

import numpy as np
import pytest
from PIL import Image

from tests.render.test_surface_maps import EVEN, in_folder
from tests.render.test_surfaces import matte, picture

__all__ = ["in_folder"]  # a fixture
SQUARE = 0.2
EYE = 1.6  # m, the camera's height over the floor
FOV = 45.0


def at_eye_height(heading: float) -> dict:
    """The camera of somebody who looks to the horizon."""
    a = math.radians(heading)
    target = [0.3 + 20 * math.sin(a), EYE, 6 - 20 * math.cos(a)]
    return {"position": [0.3, EYE, 6], "target": target, "fov": FOV}


def across_and_along(rows: int, heading: float) -> tuple[np.ndarray, np.ndarray]:
    """(rows / 2,) m, from the horizon down: the sides of a pixel's footprint in the middle column, across the view and along it."""
    tangent = (np.arange(rows // 2) + 0.5) / (rows / 2) * math.tan(math.radians(FOV / 2))
    pixel = math.tan(math.radians(FOV / 2)) / (rows / 2)
    return EYE / tangent * pixel, EYE / tangent**2 * pixel


def oblique(angle: float, height: float, turn: float = 0.0) -> dict:
    """Parallel rays that meet the floor at an angle: every footprint is a pixel wide and 1 / sin(angle) pixels long."""
    a, b = math.radians(angle), math.radians(turn)
    at = [50 * math.cos(a) * math.sin(b), 50 * math.sin(a), 50 * math.cos(a) * math.cos(b)]
    return {"position": at, "target": [0, 0, 0], "height": height}


@pytest.mark.parametrize("size", [(1280, 720), (320, 180)])
@pytest.mark.parametrize("heading", [0, 20, 45])
def test_a_checker_is_even_towards_the_horizon(size, heading):
    """Where a footprint spans more than 1.1 squares along an axis, the mean of both colours, to the round-off of float32.

    The box around a footprint is at least its length times cos(heading) or sin(heading) wide, whichever is more.
    Mutants: no filter; the box alone, which leaves a tenth of the contrast; half the footprint.
    """
    ground = matte("white", checker={"color": "black", "size": SQUARE})
    got = picture(ground=ground, light=EVEN, camera=at_eye_height(heading), size=size)[size[1] // 2 :, :, 0]
    _, along = across_and_along(size[1], heading)
    turned = math.radians(heading)
    column = slice(size[0] // 2 - 8, size[0] // 2 + 8)
    even = along * max(math.cos(turned), math.sin(turned)) > 1.12 * SQUARE
    assert even.sum() > 0.1 * len(along)
    assert np.abs(got[even, column] - 0.5).max() < 1e-5
    near = along < 0.3 * SQUARE
    assert got[near, column].std() > 0.25  # and a checker before it


@pytest.mark.parametrize("angle", [90, 40, 20])
def test_a_checker_is_the_mean_over_the_footprint(angle):
    """Beside 16 by 16 places in each pixel, seen along an axis of the squares, so that the box is the footprint. A place is on one
    side of an edge or on the other, so the mean is off by a sixteenth of an edge, or two.

    Mutants: a footprint of half or twice the size, its length as wide as its width, no filter.
    """
    height, rows = 3.2, 64
    ground = matte("white", checker={"color": "black", "size": 0.5})
    got = picture(ground=ground, light=EVEN, camera=oblique(angle, height), size=(rows, rows))[..., 0]
    at = ((np.arange(16 * rows) + 0.5) / 16 - rows / 2) * (height / rows)
    along = at / math.sin(math.radians(angle))
    dark = (np.floor(at[None, :] / 0.5) + np.floor(along[:, None] / 0.5)) % 2
    assert height / rows / math.sin(math.radians(angle)) < 0.6 * 0.5  # none fades yet
    mean = 1 - dark.reshape(rows, 16, rows, 16).mean(axis=(1, 3))
    assert np.abs(got - mean).max() <= 2 / 16 or np.abs(got - (1 - mean)).max() <= 2 / 16


def grating(folder, cycles: int, upright: bool) -> str:
    """The name of an image of 512 texels a side whose light is 0.5 + 0.45 cos(2 pi cycles x), x to the right or down."""
    light = 0.5 + 0.45 * np.cos(2 * np.pi * cycles * (np.arange(512) + 0.5) / 512)
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    rows = np.repeat(np.round(255 * code)[None, :], 512, axis=0).astype(np.uint8)
    Image.fromarray(np.repeat((rows if upright else rows.T)[..., None], 3, axis=2)).save(
        folder / f"{cycles}{upright}.png"
    )
    return f"{cycles}{upright}.png"


def transfer(frequency: float, texel: float) -> float:
    """What a version of an image with texels of this side leaves of a wave: texels are boxes, and bilinear weights are tents."""
    return float(np.sinc(frequency * texel) ** 3)


def kept(frequency: float, upright: bool, width: float, length: float, finest: float) -> float:
    """The contrast that map_at leaves of waves with this many periods a metre, across the view or along it.

    A footprint is covered by round(length / width) samples along its length, at most 16, and each is the mean of the two
    versions between whose texels the larger of its sides lies.
    """
    samples = min(max(math.ceil(length / width - 0.5), 1), 16)
    side = max(width, length / samples)
    texel = finest
    while side >= 2 * texel:
        texel *= 2
    share = 2 - side / texel if side > texel else 1.0
    result = share * transfer(frequency, texel) + (1 - share) * transfer(frequency, 2 * texel)
    if not upright:
        steps = (np.arange(samples) + 0.5) / samples - 0.5
        result *= float(np.cos(2 * np.pi * frequency * length * steps).mean())
    return result


@pytest.mark.parametrize("angle", [90, 30, 12, 3])
@pytest.mark.parametrize("upright", [True, False])
def test_an_image_keeps_the_contrast_of_its_footprint(in_folder, angle, upright):
    """A wave of which a quarter of a period falls into the sides of a pixel, across the view or along it, has the contrast that
    the footprint's samples leave of it. Texels are aligned with the wave only as a mean: 1% of the contrast.

    Mutants: a footprint of half or twice the size, as wide as it is long, or as long as it is wide; one sample; sixteen; the
    coarser version alone, the finer one alone.
    """
    rows, height, size = 96, 10.7, 4.0
    width = height / rows
    length = width / math.sin(math.radians(angle))
    quarter = width if upright else max(length, width)
    cycles = max(round(size / (4 * quarter)), 1)
    frequency = cycles / size
    name = grating(in_folder, cycles, upright)
    ground = matte("black", image={"file": name, "size": size})
    got = picture(ground=ground, light=EVEN, camera=oblique(angle, height), size=(rows, rows))[..., 0].astype(float)
    wave = got.mean(axis=0 if upright else 1) - 0.5
    at = (np.arange(rows) + 0.5) * (width if upright else length) * frequency * 2 * math.pi
    columns = np.stack([np.cos(at), np.sin(at), np.ones(rows)], axis=1)
    cosine, sine, _ = np.linalg.lstsq(columns, wave, rcond=None)[0]
    expected = kept(frequency, upright, width, length, size / 512)
    assert math.hypot(cosine, sine) / 0.45 == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("size", [(1280, 720), (320, 180)])
def test_an_image_is_even_where_it_is_smaller_than_its_samples(in_folder, size):
    """Where a sixteenth of the footprint is longer than the image, the mean of its texels, of 8 bits. Mutant: no smaller versions."""
    Image.fromarray(np.kron([[255, 0], [0, 255]], np.ones((32, 32))).astype(np.uint8)).save(in_folder / "two.png")
    ground = matte("black", image={"file": "two.png", "size": 2 * SQUARE})
    got = picture(ground=ground, light=EVEN, camera=at_eye_height(0), size=size)[size[1] // 2 :, :, 0]
    _, along = across_and_along(size[1], 0)
    even = along / 16 > 2 * SQUARE
    assert even.sum() >= 2
    assert np.abs(got[even] - 0.5).max() < 1e-4
