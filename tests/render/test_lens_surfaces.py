"""Surfaces through a lens: the circle of confusion against its formula, and what it hides.

Mutants that were tried, each of which fails a test here: pictures shifted the other way, or not at all; a lens of half the
radius; the margin's angle left out; sprites hidden by the surfaces of the lens's middle alone.
"""

import numpy as np
import pytest

from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset
from gen_art.renderer.lens_views import FEWEST, MOST, lens_shifts

SIZE = (128, 96)
GLOWS = {"albedo": "black", "ior": 1, "emission": "white"}
NOTHING = {"dot": {"emitters": {"one": {"count": 1, "shape": {"point": [0, 0, 1e6]}}}, "look": {"draw": "point"}}}


def playback(size=SIZE, lens=None, **keys):
    camera = {"position": [0, 0, 5], "target": [0, 0, 0], "fov": 30, **keys.pop("camera", {})}
    if lens is not None:
        camera["lens"] = lens
    basis = {
        "version": 1,
        "clock": {"duration": 1, "fps": 10, "step": 0.05},
        "light": {"intensity": 0, "ambient_intensity": 0},
    }
    return Playback(load_preset({**basis, "systems": NOTHING, "camera": camera, **keys}), size, "f32", None)


def picture(step=0, **keys):
    return playback(**keys).picture(step).copy()


def half_plane(z):
    """A thin glowing block whose edge is at x = 0."""
    return {"colliders": {"block": {"min": [-9, -9, z - 1e-3], "max": [0, 9, z], "look": GLOWS}}}


def disc_share(x):
    """The part of a disc of radius 1 that lies to the right of x."""
    x = np.clip(x, -1, 1)
    return 0.5 - (x * np.sqrt(1 - x * x) + np.arcsin(x)) / np.pi


@pytest.mark.parametrize("z", [2.0, -4.0])
def test_an_edge_out_of_focus_is_as_wide_as_its_circle(z):
    """Across the edge of a half-plane at the depth d, light falls as the part of a disc of the radius s R |1/f - 1/d| that lies on
    its side; n places on the lens give that part to one in n^(3/4) (an even set of points cut by a line), and a pixel's shift is
    rounded by half a pixel at most."""
    radius, depth = 0.25, 5 - z
    scale = 48 / np.tan(np.radians(15))
    circle = scale * radius * abs(1 / 5 - 1 / depth)
    got = picture(lens=radius, **half_plane(z))[48, :, 0]
    x = np.arange(128) + 0.5 - 64
    expected = disc_share(x / circle)
    assert circle > 3 and len(lens_shifts(scale * radius / 5)) == MOST
    # half a pixel of shift at the lens is |1 - f/d| half pixels in the picture, of a slope of at most 2 / (pi circle)
    tolerance = MOST**-0.75 + 0.5 * abs(1 - 5 / depth) * 2 / (np.pi * circle) + 0.25 * 2 / (np.pi * circle)
    assert np.abs(got - expected).max() < tolerance
    assert got.sum() == pytest.approx(expected.sum(), abs=0.5)


def test_what_is_in_focus_is_as_sharp_as_without_a_lens():
    square = {"colliders": {"block": {"min": [-0.4, -0.3, -1e-3], "max": [0.4, 0.3, 0], "look": GLOWS}}}
    sharp, through = picture(**square)[..., 0], picture(lens=0.25, **square)[..., 0]
    assert sharp.max() == 1 and sharp.sum() > 500 and np.abs(sharp - through).max() < 0.02


def test_a_ball_keeps_its_light_out_of_focus():
    ball = {"colliders": {"sphere": {"center": [0, 0, 2], "radius": 0.3, "look": GLOWS}}}
    sharp, through = picture(**ball)[..., 0], picture(lens=0.1, **ball)[..., 0]
    assert (sharp - through).max() > 0.05 and through.sum() == pytest.approx(sharp.sum(), rel=0.01)
    rows, columns = np.indices(sharp.shape)
    for place, middle in ((rows, 47.5), (columns, 63.5)):
        assert (place * through).sum() / through.sum() == pytest.approx(middle, abs=0.25)


def test_a_sprite_behind_an_edge_out_of_focus_is_hidden_by_what_the_lens_sees_of_it():
    """Where the edge covers half of the lens, half of the light of a point in focus behind it is left, to one of eight views."""
    black = {"colliders": {"block": {"min": [-9, -9, 1.999], "max": [0, 9, 2], "look": {"albedo": "black", "ior": 1}}}}
    scale, circle = 48 / np.tan(np.radians(15)), 48 / np.tan(np.radians(15)) * 0.25 * (1 / 3 - 1 / 5)
    for x in (-0.8, -0.4, 0.0, 0.4, 0.8):
        place = x * circle * 5 / scale  # in the plane of focus, behind that part of the edge
        spark = {"spark": {"emitters": {"one": {"count": 1, "shape": {"point": [place, 0, 0]}}},
                           "look": {"draw": "disc", "radius": 0.02, "emission": {"color": "white", "intensity": 20}}}}  # fmt: skip
        alone = picture(lens=0.25, systems=spark)[..., 0].sum()
        got = picture(lens=0.25, systems=spark, **black)[..., 0].sum()
        assert got / alone == pytest.approx(disc_share(-x), abs=0.15)


def test_places_on_the_lens_are_even():
    for reach in (0.5, 2.0, 5.0, 40.0):
        shifts = lens_shifts(reach)
        assert FEWEST <= len(shifts) <= MOST and np.abs(shifts).max() <= np.ceil(reach)
        assert np.abs(shifts.mean(axis=0)).max() <= 0.25 + 0.05 * reach
        if reach > 4:  # of an even disc, the variance along each axis is a quarter of the square of its radius
            assert shifts.var(axis=0) == pytest.approx(reach**2 / 4, rel=0.1)


def test_without_a_radius_or_without_surfaces_a_lens_changes_no_byte():
    assert np.array_equal(picture(lens=0, **half_plane(2.0)), picture(**half_plane(2.0)))


def test_a_film_and_the_still_of_its_frame_have_the_same_bytes_and_tiny_pictures_are_drawn():
    ball = {
        "particle": {"radius": 0.4},
        "emitters": {"one": {"count": 1, "shape": {"point": [0, 0.5, 1]}, "velocity": {"constant": [1, 0, 0]}}},
        "look": {"draw": "sphere", "blend": "opaque", "albedo": "grey"},
    }
    keys = {
        "systems": {"ball": ball}, "light": {}, "ground": {"albedo": "grey", "mirror": True, "roughness": 0.1},
        "camera": {"position": [0, 1, 5]}, "lens": 0.1,
    }  # fmt: skip
    film = playback(**keys)
    frames = [film.picture(step).copy() for step in (0, 2, 4)]
    assert np.array_equal(frames[-1], picture(4, **keys))
    for size in ((1, 1), (7, 5)):
        for systems in (keys["systems"], {"ball": {**ball, "emitters": {"one": {"count": 1, "at": 9}}}}):
            assert np.isfinite(picture(size=size, **{**keys, "systems": systems})).all()
