"""Images of light and of relief on surfaces, against the light of inclined planes and of rough ones."""

import math

import numpy as np
import pytest
from PIL import Image

from gen_art.renderer.surfaces.surface_maps import relief_texels
from tests.render.test_surface_maps import CORNERS, EVEN, FROM_ABOVE, corners, image_file
from tests.render.test_surfaces import DARK, matte, picture

DEPTH, SIDE = 0.6, 256


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ramp(folder, down=False):
    """A picture that becomes brighter to the right, or down, by one grey value a pixel: in 2 m, an incline of `incline()` up to its
    seam."""
    values = np.tile(np.arange(SIDE, dtype=np.uint8), (SIDE, 1))
    Image.fromarray(values.T if down else values).save(folder / ("down.png" if down else "ramp.png"))


def incline(depth=DEPTH, size=2.0):
    return depth / 255 * SIDE / size


def test_an_image_of_light_shines_by_itself(in_folder):
    """Mutants: the factor is left out; the light is scattered as an albedo is, so that none is seen in the dark."""
    image_file(in_folder)
    ground = matte("white", emission_image={"file": "four.png", "size": 2}, emission_intensity=0.5)
    got = picture(ground=ground, light={"intensity": 0, **DARK}, camera=FROM_ABOVE, size=(128, 128))
    assert got[..., :3].max() == pytest.approx(0.5, rel=1e-6)
    assert corners(got * 2, 64, 64, 64) == CORNERS


def test_where_an_image_of_light_is_transparent_the_emission_shows(in_folder):
    clear = np.zeros((8, 8, 4), np.uint8)
    clear[:, 4:] = [255, 0, 0, 255]
    Image.fromarray(clear).save(in_folder / "half.png")
    ground = matte("black", emission="#0000ff", emission_image={"file": "half.png", "size": 4}, emission_intensity=3)
    got = picture(ground=ground, light=EVEN, camera=FROM_ABOVE, size=(64, 64))
    assert got[40, 8, :3] == pytest.approx([3, 0, 0], abs=3e-3)
    assert got[40, 40, :3] == pytest.approx([0, 0, 3], abs=3e-3)


@pytest.mark.parametrize("depth", [DEPTH, -DEPTH])
@pytest.mark.parametrize("angle", [-50, 0, 30])
def test_a_relief_has_the_light_of_its_incline(in_folder, angle, depth):
    """A white floor that rises to +x, under a lamp that stands `angle` to the side of +x: 4 I times the cosine with its normal.

    Mutants: the normal leans uphill; half the slope; slopes along x and z exchanged.
    """
    ramp(in_folder)
    a, s = math.radians(angle), incline(depth)
    light = {"direction": [-math.sin(a), -math.cos(a), 0], "intensity": 0.25, **DARK}
    ground = matte(relief={"file": "ramp.png", "size": 2, "depth": depth})
    got = picture(ground=ground, light=light, camera=FROM_ABOVE, size=(128, 128))[64, 70:120, 0]  # between two seams
    cosine = (math.cos(a) - s * math.sin(a)) / math.hypot(1, s)
    assert got == pytest.approx(cosine, rel=2e-3)


OBLIQUE = {"position": [3, 2, 4], "target": [0.9, 0, 0.9], "height": 0.6}


@pytest.mark.parametrize("camera", [{**FROM_ABOVE, "target": [0, 0, 0]}, OBLIQUE, {**OBLIQUE, "roll": 40}])
@pytest.mark.parametrize("down", [False, True])
def test_a_relief_has_its_light_from_everywhere(in_folder, camera, down):
    """What rises to +x, or to +z as its image brightens downwards, seen from above, at an angle and with a camera that leans over.

    Mutants: the sign of the slope downwards; the sign of the product of a pixel's two steps, which are at right angles from above.
    """
    ramp(in_folder, down)
    s = incline()
    to_lamp = np.array([0.5, 0.8, 0.0] if not down else [0.0, 0.8, 0.5])
    light = {"direction": (-to_lamp).tolist(), "intensity": 0.25, **DARK}
    ground = matte(relief={"file": "down.png" if down else "ramp.png", "size": 2, "depth": DEPTH})
    got = picture(ground=ground, light=light, camera=camera, size=(64, 64))[..., 0]
    normal = np.array([0, 1, -s] if down else [-s, 1, 0]) / math.hypot(1, s)
    cosine = float(normal @ to_lamp) / float(np.linalg.norm(to_lamp))
    inner = got[36:60, 36:60]  # between two seams
    assert inner == pytest.approx(cosine, rel=2e-3)


def test_an_incline_that_a_pixel_shows_is_no_rougher(in_folder):
    """Its highlight is that of a level floor, seen and lit from directions that lean by as much the other way.

    Mutant: the slope that is seen counts as one that is not, which takes 40% of the highlight.
    """
    ramp(in_folder)
    a = math.atan(incline(0.1))
    light = {"intensity": 1, **DARK}
    finish = {"albedo": "black", "ior": 1.5, "roughness": 0.3}
    relief = {"file": "ramp.png", "size": 2, "depth": 0.1}
    upright, leaning = {"direction": [0, -1, 0]}, {"direction": [-math.sin(a), -math.cos(a), 0]}
    inclined = picture(
        ground={**finish, "relief": relief}, light={**light, **upright}, camera=FROM_ABOVE, size=(128, 128)
    )
    at = [5 * math.sin(a), 5 * math.cos(a), 0]
    level = picture(ground=finish, light={**light, **leaning}, camera={**FROM_ABOVE, "position": at}, size=(128, 128))
    assert inclined[64, 70:120, 0] == pytest.approx(level[64, 70:120, 0], rel=5e-3)


SIDES = [([0, 0, 3], [1, 0, 0]), ([3, 0, 0], [0, 0, -1]), ([-3, 0, 0], [0, 0, 1]), ([0, 0, -3], [-1, 0, 0])]


@pytest.mark.parametrize("side,right", SIDES)
def test_a_relief_on_a_wall_rises_as_its_image_brightens(in_folder, side, right):
    """On four sides of a block, the lamp 30 degrees to the right of whoever looks. Mutant: no change of sign with the normal."""
    ramp(in_folder)
    a, s = math.radians(30), incline()
    normal = np.asarray(side) / 3
    light = {"direction": [*(-math.cos(a) * normal - math.sin(a) * np.asarray(right))], "intensity": 0.25, **DARK}
    look = matte(relief={"file": "ramp.png", "size": 2, "depth": DEPTH})
    block = {"block": {"min": [-1, -1, -1], "max": [1, 1, 1], "look": look}}
    camera = {"position": [side[0], 0.3, side[2]], "target": [0, 0.3, 0], "height": 4}
    got = picture(colliders=block, light=light, camera=camera, size=(128, 128))[64, 70:90, 0]
    assert got == pytest.approx((math.cos(a) - s * math.sin(a)) / math.hypot(1, s), rel=2e-3)


def test_slopes_that_a_pixel_does_not_show_make_it_rougher(in_folder):
    """From afar, a relief has the highlight of a floor with roughness^4 + s^2, s^2 its mean square slope (alpha = roughness^2).

    Mutants: the slopes are lost with distance; half of their squares.
    """
    ramp(in_folder)
    texels, _ = relief_texels(in_folder / "ramp.png", 2.0, 0.05)
    square = float(texels[-1, 2] - texels[-1, 0] ** 2 - texels[-1, 1] ** 2)
    light = {"direction": [0, -1, 0], "intensity": 1, **DARK}
    camera = {"position": [0, 4000, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 40}
    # black on black: a checker is shaded in each pixel, not in nine of a tile
    finish = {"albedo": "black", "ior": 1.5, "checker": {"size": 1, "color": "black"}}
    wavy = picture(
        ground={**finish, "roughness": 0.3, "relief": {"file": "ramp.png", "size": 2, "depth": 0.05}},
        light=light, camera=camera,
    )  # fmt: skip
    rough = picture(ground={**finish, "roughness": (0.3**4 + square) ** 0.25}, light=light, camera=camera)
    smooth = picture(ground={**finish, "roughness": 0.3}, light=light, camera=camera)
    assert wavy[..., 0] == pytest.approx(rough[..., 0], rel=1e-3)
    assert smooth[..., 0].max() > 1.2 * rough[..., 0].max()


def test_the_slopes_of_a_relief_are_those_of_its_heights(in_folder):
    """A sine of the depth d over the size w has the mean square slope (pi d / w)^2 / 2, to the roundness of 8 bits."""
    wave = np.round(127.5 + 127.5 * np.sin(2 * np.pi * np.arange(SIDE) / SIDE)).astype(np.uint8)
    Image.fromarray(np.tile(wave[:, None], (1, SIDE // 2))).save(in_folder / "sine.png")  # twice as high as wide
    texels, height = relief_texels(in_folder / "sine.png", 1.5, 0.2)
    assert height == pytest.approx(3.0)
    # a rounded height errs by 1/sqrt(12) of a grey value: two of them over two steps add step^2 / 24 as a mean; twice that is allowed
    step = 0.2 / 255 / (3.0 / SIDE)
    expected = (math.pi * 0.2 / 3.0) ** 2 / 2
    assert float(texels[-1, 2]) == pytest.approx(expected, abs=step**2 / 12 + 1e-3 * expected)
    assert texels[-1, :2] == pytest.approx([0, 0], abs=1e-7)


def test_water_levels_a_relief(in_folder):
    """A floor under water has the light of a level one. Mutant: the relief shows through."""
    ramp(in_folder)
    light = {"direction": [-0.5, -1, 0], "intensity": 0.25, **DARK}
    common = {"albedo": "white", "puddles": 1.0}
    relief = {"file": "ramp.png", "size": 2, "depth": DEPTH}
    level, inclined = (
        picture(ground={**common, **more}, light=light, camera=FROM_ABOVE) for more in ({}, {"relief": relief})
    )
    assert inclined == pytest.approx(level, rel=1e-5)
