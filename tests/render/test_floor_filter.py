"""Checkers and images on a floor seen at an angle: means over the pixel's footprint, and no moire towards the horizon."""

import math

import numpy as np
import pytest
from PIL import Image

from tests.render.test_sheets import cloth
from tests.render.test_surface_images import block
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

    Mutants: a footprint of half or twice the size, of one of its sides alone, no filter.
    """
    height, rows = 3.2, 64
    ground = matte("white", checker={"color": "black", "size": 0.47})
    got = picture(ground=ground, light=EVEN, camera=oblique(angle, height), size=(rows, rows))[..., 0]
    at = ((np.arange(16 * rows) + 0.5) / 16 - rows / 2) * (height / rows)
    along = at / math.sin(math.radians(angle))
    dark = (np.floor(at[None, :] / 0.47) + np.floor(along[:, None] / 0.47)) % 2
    assert height / rows / math.sin(math.radians(angle)) < 0.6 * 0.47  # none fades yet
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


def kept(frequency: float, upright: bool, east: np.ndarray, south: np.ndarray, finest: float) -> float:
    """The contrast that map_at leaves of waves with this many periods a metre, to the right or down.

    east, south : (2,) m, from one pixel to the next
    A footprint is covered by round(length / width) samples along its longer step, at most 16, and each is the mean of the two
    versions between whose texels the larger of its sides lies. Its width is its area divided by its length.
    """
    along = east if np.linalg.norm(east) >= np.linalg.norm(south) else south
    length = float(np.linalg.norm(along))
    width = abs(east[0] * south[1] - east[1] * south[0]) / length
    samples = min(max(math.ceil(length / width - 0.5), 1), 16)
    side = max(width, length / samples)
    texel = finest
    while side >= 2 * texel:
        texel *= 2
    share = 2 - side / texel if side > texel else 1.0
    steps = (np.arange(samples) + 0.5) / samples - 0.5
    sampled = float(np.cos(2 * np.pi * frequency * along[0 if upright else 1] * steps).mean())
    return sampled * (share * transfer(frequency, texel) + (1 - share) * transfer(frequency, 2 * texel))


def contrast(got: np.ndarray, frequency: float, upright: bool, east: np.ndarray, south: np.ndarray) -> float:
    """The amplitude of the waves in a picture, divided by that in the image."""
    row, column = np.indices(got.shape)
    at = 2 * np.pi * frequency * (column * east[0 if upright else 1] + row * south[0 if upright else 1])
    waves = np.stack([np.cos(at), np.sin(at), np.ones(got.shape)], axis=-1).reshape(-1, 3)
    cosine, sine, mean = np.linalg.lstsq(waves, got.reshape(-1).astype(float), rcond=None)[0]
    return math.hypot(cosine, sine) / (0.9 * mean)


def steps(pixel: float, angle: float, roll: float) -> tuple[np.ndarray, np.ndarray]:
    """(2,) and (2,) m to the right and down: from one pixel to the next on a floor, of a camera that leans over by `roll`."""
    c, s = math.cos(math.radians(roll)), -math.sin(math.radians(roll))
    longer = 1 / math.sin(math.radians(angle))
    return pixel * np.array([c, s * longer]), pixel * np.array([-s, c * longer])


@pytest.mark.parametrize("angle, roll", [(90, 0), (30, 0), (12, 0), (3, 0), (12, 35), (3, 45)])
@pytest.mark.parametrize("upright", [True, False])
def test_an_image_keeps_the_contrast_of_its_footprint(in_folder, angle, roll, upright):
    """A wave of which a quarter of a period falls into the steps of a pixel, to the right or down, has the contrast that the
    footprint's samples leave of it. Texels are aligned with the wave only as a mean: 1% of the contrast.

    Mutants: a footprint of half or twice the size, as wide as it is long, or as long as it is wide; one sample; sixteen; the
    coarser version alone, the finer one alone; the shorter step as the width where the steps are not at right angles.
    """
    rows, size = 96, 4.0
    pixel = 10.7 / rows
    east, south = steps(pixel, angle, roll)
    quarter = np.hypot(east, south)[0 if upright else 1]
    cycles = max(round(size / (4 * quarter)), 1)
    name = grating(in_folder, cycles, upright)
    ground = matte("black", image={"file": name, "size": size})
    camera = {**oblique(angle, 10.7), "roll": roll}
    got = picture(ground=ground, light=EVEN, camera=camera, size=(rows, rows))[..., 0]
    expected = kept(cycles / size, upright, east, south, size / 512)
    assert contrast(got, cycles / size, upright, east, south) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("what", ["body", "cloth"])
@pytest.mark.parametrize("angle", [90, 35])
@pytest.mark.parametrize("upright", [True, False])
def test_bodies_and_cloth_keep_it_too(in_folder, what, angle, upright):
    """On the level side of a body and on a level cloth. Mutants: footprints four times as long; a step to the right of 0."""
    rows, size, height = 96, 4.0, 5.35
    east, south = steps(height / rows, angle, 0)
    cycles = max(round(size / (4 * (east[0] if upright else south[1]))), 1)
    name = grating(in_folder, cycles, upright)
    finish = {"finish": {"ior": 1, "image": {"file": name, "size": size}}}
    systems = block(side=14.0, look=finish, position=(0, -7, 0))
    if what == "cloth":
        systems = cloth(corner=(-7, 0, -7), across=(14, 0, 0), down=(0, 0, 14), **finish)
    got = picture(systems=systems, light=EVEN, camera=oblique(angle, height), size=(rows, rows))[..., 0]
    expected = kept(cycles / size, upright, east, south, size / 512)
    assert contrast(got, cycles / size, upright, east, south) == pytest.approx(expected, abs=0.015)


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
