"""Images, puddles and waves on surfaces, against the files, the shares and the laws that they follow."""

import math

import numpy as np
import pytest
from PIL import Image

from gen_art.errors import PresetError
from gen_art.preset.surface import Puddles, Waves
from gen_art.preset.values import Range
from gen_art.renderer.surfaces.reflection import fresnel
from gen_art.renderer.surfaces.surface_maps import puddle_texels
from gen_art.renderer.surfaces.water_waves import patch_rows, wave_rows
from tests.render.test_surfaces import DARK, dot, matte, picture, preset

EVEN = {"intensity": 0, "ambient": "white", "ambient_intensity": 1.0}  # a white matte surface has the light 1
FROM_ABOVE = {"position": [0, 5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "height": 4}
CORNERS = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]]  # upper left, upper right, lower left, lower right


def image_file(folder, side=64):
    """A square of four colours."""
    square = np.zeros((side, side, 3), np.uint8)
    half = side // 2
    square[:half, :half], square[:half, half:], square[half:, :half], square[half:, half:] = CORNERS
    Image.fromarray(square).save(folder / "four.png")


def corners(got, left, top, side):
    """The colours in the middles of the quarters of a square of a picture, of 0 or 1."""
    places = [(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75)]
    return [[round(float(c)) * 255 for c in got[int(top + v * side), int(left + u * side), :3]] for v, u in places]


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_an_image_lies_the_right_way_round_on_a_floor(in_folder):
    """Its left side at x = 0, its upper side to -z. Mutants: u and v exchanged, v turned round."""
    image_file(in_folder)
    ground = matte("black", image={"file": "four.png", "size": 2})
    got = picture(ground=ground, light=EVEN, camera=FROM_ABOVE, size=(128, 128))  # 32 pixels a metre
    assert corners(got, 64, 64, 64) == CORNERS
    assert corners(got, 0, 0, 64) == CORNERS, "it repeats"


@pytest.mark.parametrize("side", [[0, 0, 3], [3, 0, 0], [0, 0, -3], [-3, 0, 0]])
def test_an_image_is_not_mirrored_on_a_wall(in_folder, side):
    """On each side of a block that stands at the origin, seen from there. Mutants: no change of sign with the normal, of walls
    that face x and of those that face z."""
    image_file(in_folder)
    block = {
        "block": {"min": [-1, -1, -1], "max": [1, 1, 1], "look": matte("black", image={"file": "four.png", "size": 2})}
    }
    camera = {"position": side, "target": [0, 0, 0], "height": 4}
    got = picture(colliders=block, light=EVEN, camera=camera, size=(128, 128))
    # the image begins at the middle of the side and repeats: its four quarters change places
    assert corners(got, 32, 32, 64) == CORNERS[::-1]


def test_an_image_moves_with_its_collider(in_folder):
    """A block that has moved by half a metre shows what one shows that stands, half a metre from there. Mutant: the image stays."""
    image_file(in_folder)
    look = matte("black", image={"file": "four.png", "size": 1.2})
    stand = {"block": {"min": [-1, -1, -1], "max": [1, 1, 1], "look": look}}
    move = {"block": {**stand["block"], "velocity": [1.0, 0, 0]}}
    camera = {**FROM_ABOVE, "position": [0.5, 5, 0], "target": [0.5, 0, 0]}
    moved = picture(colliders=move, light=EVEN, camera=camera, step=60, size=(96, 96))
    still = picture(colliders=stand, light=EVEN, camera=FROM_ABOVE, size=(96, 96))
    inside = (slice(26, 70), slice(26, 70))
    assert (
        np.abs(moved[inside] - still[inside]).mean() < 0.01 < np.abs(np.roll(moved, 12, axis=1) - still)[inside].mean()
    )


def test_an_image_far_away_has_its_mean_colour(in_folder):
    """The mean of the four colours is (1/2, 1/2, 1/2): from above and at a grazing angle. Mutant: the finest texels everywhere."""
    image_file(in_folder)
    ground = matte("black", image={"file": "four.png", "size": 0.5})
    high = {"position": [0, 900, 1], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 20}
    low = {"position": [0, 300, 0], "target": [0, 0, -1500], "fov": 20}
    for camera in (high, low):
        got = picture(ground=ground, light=EVEN, camera=camera)[..., :3]
        assert np.abs(got - 0.5).max() < 0.01


def test_what_is_transparent_in_an_image_shows_the_albedo(in_folder):
    clear = np.zeros((8, 8, 4), np.uint8)
    clear[:, 4:] = [255, 0, 0, 255]
    Image.fromarray(clear).save(in_folder / "half.png")
    got = picture(
        ground=matte("#0000ff", image={"file": "half.png", "size": 4}), light=EVEN, camera=FROM_ABOVE, size=(64, 64)
    )
    assert got[40, 40, :3] == pytest.approx([0, 0, 1], abs=1e-3) and got[40, 8, :3] == pytest.approx(
        [1, 0, 0], abs=1e-3
    )


@pytest.mark.parametrize("share", [0.0, 0.25, 0.6, 1.0])
def test_puddles_cover_their_share(share):
    texels = puddle_texels(Puddles(share=share))
    wet = texels[: 512 * 512, 3].reshape(512, 512)
    assert wet.mean() == pytest.approx(share, abs=1e-6) and texels[-1, 3] == pytest.approx(share, abs=1e-5)
    # it repeats without a seam: across it, texels differ no more than elsewhere
    assert np.abs(wet[:, 0] - wet[:, -1]).max() <= np.abs(np.diff(wet, axis=1)).max()


def test_a_floor_under_water_reflects_as_water_does():
    """A black floor wholly under water has Fresnel's share of an even sky. Mutant: the floor's index instead of water's."""
    a = math.radians(70)
    camera = {"position": [0, 3 * math.cos(a), 3 * math.sin(a)], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 1}
    ground = {"albedo": "black", "roughness": 0.6, "ior": 2, "puddles": 1.0}
    got = picture(ground=ground, light=EVEN, camera=camera, size=(33, 33))[16, 16, 0]
    assert got == pytest.approx(float(fresnel(math.cos(a), 1.33)), abs=2e-4)


def test_damp_ground_is_darker_and_dry_ground_is_not():
    dry, damp = (
        picture(ground=matte("white", puddles={"share": 0, "damp": d}), light=EVEN, camera=FROM_ABOVE)[..., 0].mean()
        for d in (0.0, 1.0)
    )
    assert dry == pytest.approx(1.0, rel=1e-3) and damp == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("number", [32, 200])
def test_waves_have_their_slope_and_travel_as_on_deep_water(number):
    """Mutants: the frequency without its gravity part, without its capillary part; a slope for each wave, not for all; the
    slope of 32 waves for any number."""
    waves = Waves(slope=0.1, length=Range(0.005, 3.0), direction=30, spread=50, number=number)
    now, later = wave_rows(waves, 0.0).astype(np.float64), wave_rows(waves, 0.01).astype(np.float64)
    k = np.hypot(now[:, 0], now[:, 1])
    assert len(now) == number and (0.5 * now[:, 2] ** 2).sum() == pytest.approx(0.01, rel=1e-6)
    assert k.min() > 2 * math.pi / 3.01 and k.max() < 2 * math.pi / 0.0049
    heading = np.degrees(np.arctan2(now[:, 1], now[:, 0]))
    assert np.abs(heading - 30).max() <= 50.01 and np.ptp(heading) > 30
    turned = np.mod(now[:, 3] - later[:, 3], 2 * math.pi)
    expected = np.sqrt(9.81 * k + 7.28e-5 * k**3) * 0.01
    assert turned == pytest.approx(np.mod(expected, 2 * math.pi), abs=2e-5)


@pytest.mark.parametrize("slope,patches,seed", [(0.1, 0.0, 0), (0.04, 0.5, 5)])
def test_a_wave_tilts_the_mirror_by_its_slope(slope, patches, seed):
    """Waves far longer than the scene are a level of water that leans: an image moves by twice the slope, which in a patch far
    larger than the scene is multiplied by 1 and the sum of the patches' sines.

    Mutants: by the slope; the sum without 1, and the sum added to the slope.
    """
    waves = {
        "slope": slope,
        "length": "5000..5000",
        "spread": 0,
        "direction": 90,
        "patches": patches,
        "patch_size": 9e4,
        "seed": seed,
    }
    made = Waves.model_validate({**waves, "length": Range(5000.0, 5000.0)})
    rows, uneven = wave_rows(made, 0.0).astype(np.float64), patch_rows(made).astype(np.float64)
    factor = 1 + (uneven[:, 2] * np.cos(uneven[:, 3])).sum()
    assert patches == 0.0 or abs(factor - 1) > 0.2
    leaning = factor * float((rows[:, 2] * np.cos(rows[:, 3])).sum())  # along +z, to the camera
    camera = {"position": [0, 1.2, 4], "target": [0, 0.0, -4], "fov": 40}
    mirror = {"albedo": "white", "metal": 1, "roughness": 0, "mirror": True}
    common = {"light": {"intensity": 0, **DARK}, "camera": camera, "size": (320, 240)}
    far = dot(0.0, "sphere")
    far["dot"]["emitters"] = {"one": {"count": 1, "shape": {"point": [0, 30, -400]}}}
    far["dot"]["look"] = {"draw": "sphere", "radius": 2, "emission": "white"}
    flat, wavy = (
        picture(systems=far, ground={**mirror, **more}, **common)[75:, :, 0] for more in ({}, {"waves": waves})
    )
    row = np.arange(len(flat))
    moved = (wavy.sum(axis=1) @ row / wavy.sum()) - (flat.sum(axis=1) @ row / flat.sum())
    pixels = 120 / math.tan(math.radians(20))  # a radian
    assert abs(leaning) > 0.01 and moved == pytest.approx(2 * leaning * pixels, rel=0.1)


def test_patches_have_their_deviation_and_size():
    """Mutants: an amplitude of `patches` for each sine; lengths of a quarter of the size and more alone."""
    rows = patch_rows(Waves(patches=0.4, patch_size=8.0)).astype(np.float64)
    assert (0.5 * rows[:, 2] ** 2).sum() == pytest.approx(0.16, rel=1e-6)
    length = 2 * math.pi / np.hypot(rows[:, 0], rows[:, 1])
    assert 1.99 < length.min() < 3 and 13 < length.max() < 16.01
    assert len(patch_rows(Waves())) == 0


def test_a_calm_sea_reflects_as_a_flat_one():
    """Of waves of hardly any slope, what they reflect as a mean is Fresnel's share."""
    for angle in (0, 50, 80):
        a = math.radians(angle)
        camera = {
            "position": [0, 300 * math.cos(a), 300 * math.sin(a)],
            "target": [0, 0, 0],
            "up": [0, 0, -1],
            "fov": 0.1,
        }
        sea = {"albedo": "black", "roughness": 0, "ior": 1.33, "waves": {"slope": 0.001, "length": "0.01..0.02"}}
        got = picture(ground=sea, light=EVEN, camera=camera, size=(33, 33))[16, 16, 0]
        assert got == pytest.approx(float(fresnel(math.cos(a), 1.33)), rel=0.02)


def mean_over_slopes(angle, deviation):
    """Fresnel's share as the mean over facets with Gaussian slopes, by the area that each shows to the viewer."""
    u = deviation * np.linspace(-5, 5, 801)
    x, y = np.meshgrid(u, u)
    length = np.sqrt(1 + x**2 + y**2)
    cosine = np.maximum((math.cos(angle) - x * math.sin(angle)) / length, 0)
    weight = np.exp(-(x**2 + y**2) / (2 * deviation**2)) * cosine * length
    return (weight * fresnel(np.maximum(cosine, 1e-6), 1.33)).sum() / weight.sum()


@pytest.mark.parametrize("angle", [0, 70, 80, 85])
def test_a_rough_sea_reflects_the_mean_of_its_facets(angle):
    """Waves that are all smaller than a pixel, by a direct sum; the fit of Bruneton and others is within 15% of it. Mutant: Fresnel's
    share of the flat water, which at 80 and 85 degrees is 38% and 80% more."""
    a = math.radians(angle)
    camera = {
        "position": [0, 1200 * math.cos(a), 1200 * math.sin(a)],
        "target": [0, 0, 0],
        "up": [0, 0, -1],
        "fov": 0.1,
    }
    sea = {
        "albedo": "black",
        "roughness": 0,
        "ior": 1.33,
        "waves": {"slope": 0.2, "length": "0.01..0.02", "spread": 180},
    }
    got = picture(ground=sea, light=EVEN, camera=camera, size=(33, 33))[16, 16, 0]
    assert got == pytest.approx(mean_over_slopes(a, 0.2 / math.sqrt(2)), rel=0.15)


def test_patches_smaller_than_a_pixel_make_it_rougher():
    """Slopes of the deviation s that a factor 1 + f multiplies have the mean square s^2 (1 + mean f^2). Mutant: s^2 alone."""
    a, sea = math.radians(80), {"albedo": "black", "roughness": 0, "ior": 1.33}
    camera = {
        "position": [0, 1200 * math.cos(a), 1200 * math.sin(a)],
        "target": [0, 0, 0],
        "up": [0, 0, -1],
        "fov": 0.1,
    }
    waves = {"length": "0.001..0.002", "spread": 180}
    uneven, even, calm = (
        picture(ground={**sea, "waves": {**waves, **more}}, light=EVEN, camera=camera, size=(33, 33))[16, 16, 0]
        for more in (
            {"slope": 0.15, "patches": 0.8, "patch_size": 0.001},
            {"slope": 0.15 * math.sqrt(1.64)},
            {"slope": 0.15},
        )
    )
    assert uneven == pytest.approx(even, rel=0.01) and abs(calm - even) > 0.05 * even


@pytest.mark.parametrize(
    "keys,words",
    [
        ({"ground": {"image": "nowhere.png"}}, "there is no such file"),
        ({"colliders": {"sphere": {"look": {"waves": 0.1}}}}, "`waves` are for the ground"),
        ({"colliders": {"plane": {"normal": [1, 1, 0], "look": {"puddles": 0.1}}}}, "`puddles` are for the ground"),
        ({"ground": {"waves": {"slope": 2}}}, "slope"),
        ({"ground": {"waves": {"number": 4}}}, "number"),
        ({"ground": {"waves": {"patches": 1.5}}}, "patches"),
        ({"ground": {"puddles": 2}}, "must be from 0 to 1"),
    ],
)
def test_errors_are_sentences(in_folder, keys, words):
    with pytest.raises((PresetError, ValueError), match=words):
        preset(**keys)
        picture(**keys)
