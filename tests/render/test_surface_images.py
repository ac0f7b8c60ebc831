"""Images on bodies and on cloth, and rounded edges of boxes, against the quarters of an image and the area of an outline."""

import math

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.errors import GenArtError, PresetError
from gen_art.pictures import read_picture
from tests.render.test_sheets import cloth
from tests.render.test_surface_maps import CORNERS, EVEN, FROM_ABOVE, corners, image_file, in_folder
from tests.render.test_surfaces import picture, preset

__all__ = ["in_folder"]  # a fixture
FROM_BEFORE = {"position": [0, 0, 5], "target": [0, 0, 0], "height": 4}


def block(turn=(0, 0, 0), side=2.0, grid=(1, 1, 1), look=None, position=(0, 0, 0)):
    """Bodies that stand still: cubes of this side around the position, half of it apart."""
    body = {"shape": {"box": [side] * 3}, "turn": list(turn), "position": list(position), "static": True}
    return {
        "block": {
            "integrator": "leapfrog", "interactions": {"rigid": {}},
            "emitters": {"one": {"body": {**body, "grid": list(grid), "pitch": [1.5 * side] * 3}}},
            "look": {"draw": "body", "albedo": "black", **(look or {})},
        }
    }  # fmt: skip


def painted(size=2.0, **more):
    return {"finish": {"ior": 1, "image": {"file": "four.png", "size": size, **more}}}


@pytest.mark.parametrize("camera", [FROM_ABOVE, FROM_BEFORE])
def test_an_image_has_its_middle_in_the_middle_of_a_body_s_side(in_folder, camera):
    """An image as wide as the side fills it. Mutants: the image begins in the middle of the side; u and v exchanged."""
    image_file(in_folder)
    got = picture(systems=block(look=painted()), light=EVEN, camera=camera, size=(128, 128))
    assert corners(got, 32, 32, 64) == CORNERS


def test_an_image_turns_with_its_body(in_folder):
    """By a quarter turn counter-clockwise, the upper right quarter comes to the upper left. Mutant: along the world's axes."""
    image_file(in_folder)
    got = picture(systems=block((0, 0, 90), look=painted()), light=EVEN, camera=FROM_BEFORE, size=(128, 128))
    assert corners(got, 32, 32, 64) == [CORNERS[k] for k in (1, 3, 0, 2)]


@pytest.mark.parametrize("camera", [FROM_ABOVE, FROM_BEFORE])
def test_an_image_lies_on_a_ball_along_the_axes(in_folder, camera):
    """Its middle lies where the axis leaves the ball. Mutants: no axes of a ball; the image refused."""
    image_file(in_folder)
    look = {"draw": "sphere", "blend": "opaque", "radius": 1.0, "albedo": "black", **painted()}
    ball = {"ball": {"emitters": {"one": {"count": 1, "shape": {"point": [0, 0, 0]}}}, "look": look}}
    got = picture(systems=ball, light=EVEN, camera=camera, size=(128, 128))
    assert corners(got, 48, 48, 32) == CORNERS


def test_each_body_shows_another_part_where_the_image_is_shifted(in_folder):
    """Two bodies side by side. Mutant: one shift for all."""
    image_file(in_folder)
    sides = []
    for shifted in (False, True):
        look = painted(1.0, shifted=shifted)
        systems = block(side=1.0, grid=(2, 1, 1), look=look, position=(-0.75, 0, 0))
        got = picture(systems=systems, light=EVEN, camera=FROM_BEFORE, size=(128, 128))
        sides.append(np.abs(got[52:76, 28:52] - got[52:76, 76:100]).mean())
    assert sides[0] < 0.01 and sides[1] > 0.1


@pytest.mark.parametrize("edge", [0.0, 0.1])
@pytest.mark.parametrize("place", [[5, 0, 0], [-5, 0, 0], [0, 0, 5], [0, 5, 0]])
def test_the_ends_of_a_body_lie_across_its_x_axis(in_folder, place, edge):
    """They alone show the image of the ends. Mutants: across another axis; the image of the ends on all sides, or on one end."""
    image_file(in_folder)
    Image.new("RGB", (4, 4), (255, 0, 255)).save(in_folder / "ends.png")
    camera = {"position": place, "target": [0, 0, 0], "height": 4, "up": [0, 0, -1] if place[1] else [0, 1, 0]}
    look = painted(ends="ends.png") | {"edge": edge}
    got = picture(systems=block(look=look), light=EVEN, camera=camera, size=(128, 128))
    assert corners(got, 32, 32, 64) == ([[255, 0, 255]] * 4 if place[0] else CORNERS)


@pytest.mark.parametrize("side,want", [(1, CORNERS), (-1, [CORNERS[k] for k in (1, 0, 3, 2)])])
def test_an_image_lies_along_the_threads_of_cloth(in_folder, side, want):
    """Its upper left corner on row 0 and column 0, and mirrored from behind. Mutants: u and v exchanged; not mirrored."""
    image_file(in_folder)
    sheet = cloth(corner=(-1, 0, -1), across=(2, 0, 0), down=(0, 0, 2), **painted())
    camera = {**FROM_ABOVE, "position": [0, 5 * side, 0]}
    assert corners(picture(systems=sheet, light=EVEN, camera=camera, size=(128, 128)), 32, 32, 64) == want


def test_an_image_on_cloth_far_away_has_its_mean_colour(in_folder):
    """A grey of 1/2, where many repeats fall into a pixel; the sky's light on cloth is right to 6%.

    Mutant: the finest texels everywhere, which show the image's colours.
    """
    image_file(in_folder)
    camera = {**FROM_ABOVE, "height": 4}
    got = picture(systems=cloth(**painted(0.011)), light=EVEN, camera=camera, size=(32, 32))
    inside = got[4:28, 4:28, :3]
    assert np.abs(inside - 0.5).max() < 0.06 * 0.5 + 1e-3 and np.ptp(inside, axis=2).max() < 0.003


@pytest.mark.parametrize("edge", [0.0, 0.2, 0.5, 1.0, 7.0])
def test_a_rounded_box_has_the_outline_of_one(edge):
    """Area a^2 - (4 - pi) r^2, with r the edge or at most half the side. Mutants: a box that grows by its edge; r = 2 edge.

    A pixel at the outline is covered in steps of a quarter, so the sum over P of them is off by sqrt(P) / 8 pixels or so.
    """
    got = picture(systems=block(look={"edge": edge}), light=EVEN, camera=FROM_ABOVE, size=(128, 128))
    r = min(edge, 1.0)
    assert got[..., 3].sum() / 32**2 == pytest.approx(4.0 - (4.0 - math.pi) * r * r, abs=0.02)


def test_rounding_is_only_seen():
    """The simulation's bits are the same with and without `edge`."""
    falls = block(look={"edge": 0.3})
    falls["block"]["emitters"]["one"]["body"] |= {"static": False, "spin": [1, 2, 3]}
    sharp = {"block": {**falls["block"], "look": {"draw": "body"}}}
    states = []
    for systems in (falls, sharp):
        sim = ga.Simulation(preset(systems=systems, light=EVEN))
        sim.step(20)
        states.append(sim.members["block"].state.floats.tobytes())
    assert states[0] == states[1]


@pytest.mark.parametrize(
    "look,words",
    [
        ({"draw": "thread", "finish": {"image": "four.png"}}, "image"),
        ({"draw": "cloth", "finish": {"image": {"file": "four.png", "shifted": True}}}, "shifted"),
        ({"draw": "cloth", "finish": {"image": {"file": "four.png", "ends": "four.png"}}}, "ends"),
        ({"draw": "cloth", "edge": 0.1}, "edge"),
    ],
)
def test_what_has_no_sense_is_refused(in_folder, look, words):
    image_file(in_folder)
    systems = cloth()
    systems["flag"]["look"] = look
    with pytest.raises(PresetError, match=words):
        preset(systems=systems)


@pytest.mark.parametrize("key", ["image", "emission_image"])
def test_a_collider_has_no_ends(in_folder, key):
    image_file(in_folder)
    with pytest.raises(PresetError, match=f"`{key}.ends` is for"):
        preset(ground={key: {"file": "four.png", "ends": "four.png"}}, systems=cloth())


def test_a_sheet_of_a_script_takes_no_image(in_folder):
    image_file(in_folder)
    look = preset(systems=cloth(**painted())).systems["flag"].look
    net = ga.cloth((-1, 0, -1), (2, 0, 0), (0, 0, 2), 5, 5)
    system = ga.ParticleSystem(net.position, mass=0.01, interactions=[net.springs(1.0)], look=look)
    with pytest.raises(GenArtError, match="image lies on the `cloth:`"):
        ga.render_frame(ga.Simulation({"flag": system}, dt=0.01), (16, 16))


def test_a_palette_keeps_its_transparency(in_folder):
    """Mutant: the palette's mode, RGB, whatever the file says of transparency."""
    four = Image.new("P", (2, 1))
    four.putpalette([255, 0, 0, 0, 255, 0])
    four.putdata([0, 1])
    four.save(in_folder / "palette.png", transparency=0)
    assert read_picture("palette.png", "p").tolist() == [[[255, 0, 0, 0], [0, 255, 0, 255]]]
