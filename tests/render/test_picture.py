"""Sprites that are pictures: their energy, their turn, and files that are refused."""

import math
import struct
import zlib

import numpy as np
import pytest
from PIL import Image
from pydantic import ValidationError

from gen_art.preset.files import FOLDER
from gen_art.preset.load import load_preset
from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.sprite_image import texels
from tests.render.particles import scene, state

SIZE = (300, 200)
PIXELS = Camera(position=(0, 0, 10), height=200.0)


@pytest.fixture
def folder(tmp_path):
    """With an arrow that points right, white on nothing."""
    arrow = np.zeros((40, 40, 4), np.uint8)
    y, x = np.mgrid[:40, :40]
    arrow[np.abs(y - 19.5) < 0.5 * (x < 30) * 6 + (x >= 22) * (39 - x) * 0.9] = 255
    Image.fromarray(arrow).save(tmp_path / "arrow.png")
    token = FOLDER.set(tmp_path)
    yield tmp_path
    FOLDER.reset(token)


def paint(look, position, **more):
    painter = Painter(SIZE, PIXELS, {"a": Look(**{"draw": "picture", "picture": "arrow.png", **look})})
    return np.array(painter.paint(scene(1.0, a=state(position, **more)), 0.0))


@pytest.mark.parametrize("radius", [0.3, 1.1, 4.0, 17.3, 60.0])
@pytest.mark.parametrize("turn", [0, 33, "random"])
def test_a_picture_gives_its_energy_at_any_size_place_and_turn(folder, radius, turn):
    place = np.random.default_rng(3).uniform(-20, 20, (5, 3)) * (1, 1, 0)
    got = paint({"radius": radius, "picture": {"image": "arrow.png", "turn": turn}}, place).sum(
        axis=(0, 1), dtype=float
    )
    cover = texels(folder / "arrow.png")[1]
    assert got[:3] == pytest.approx([5 * 4 * radius**2 * cover] * 3, rel=1e-5)


def middle_of_light(picture):
    light = picture[..., 0].astype(float)
    rows, columns = np.mgrid[: light.shape[0], : light.shape[1]] + 0.5
    return np.array([(light * columns).sum(), (light * rows).sum()]) / light.sum() - (150, 100)


def test_it_turns_counter_clockwise_and_spins_with_its_age(folder):
    look = {"radius": 30.0, "picture": {"image": "arrow.png"}}
    still = middle_of_light(paint(look, [[0, 0, 0]]))
    length = np.hypot(*still)
    assert abs(still[0]) > 3 and abs(still[1]) < 0.5
    turned = middle_of_light(paint({**look, "picture": {"image": "arrow.png", "turn": 90}}, [[0, 0, 0]]))
    assert turned == pytest.approx([0, -still[0]], abs=0.1), "a quarter turn takes right to up, which is less of a row"
    spun = middle_of_light(paint({**look, "picture": {"image": "arrow.png", "spin": 180}}, [[0, 0, 0]], birth=0.0))
    assert spun == pytest.approx(-still, abs=0.1) and length > 3


@pytest.mark.parametrize("roll", [-130.0, -20.0, 0.0, 35.0])
def test_an_upright_picture_stays_where_the_camera_rolls(folder, roll):
    """A camera's `roll` turns what it sees clockwise, and upright images with it. Mutant: the roll's sign."""

    def seen(upright, turn):
        look = {"radius": 30.0, "draw": "picture", "picture": {"image": "arrow.png", "turn": turn, "upright": upright}}
        camera = Camera(position=(0, 0, 10), height=200.0, roll=roll)
        return middle_of_light(Painter(SIZE, camera, {"a": Look(**look)}).paint(scene(1.0, a=state([[0, 0, 0]])), 0.0))

    length, angle = np.hypot(*seen(False, 0)), math.radians(90 - roll)
    assert seen(True, 90) == pytest.approx([length * math.cos(angle), -length * math.sin(angle)], abs=0.1)
    assert seen(False, 90) == pytest.approx([0, -length], abs=0.1)


def test_it_keeps_its_form_and_colour(folder):
    look = {"radius": 20.0, "emission": {"color": [1.0, 0.0, 0.0], "intensity": 2.0}}
    picture = paint(look, [[0, 0, 0]])
    assert picture[100, 150] == pytest.approx([2.0, 0, 0, 0], abs=0.1), "the shaft, as bright as said"
    assert picture[85, 140].max() < 0.02, "beside the shaft"


def test_an_opaque_picture_hides_where_it_is_painted(folder):
    looks = {
        "lamp": Look(draw="disc", radius=40.0),
        "arrow": Look(draw="picture", picture="arrow.png", blend="opaque", radius=20.0, albedo="black"),
    }
    systems = {"lamp": state([[0, 0, -1]]), "arrow": state([[0, 0, 0]])}
    picture = np.array(Painter(SIZE, PIXELS, looks).paint(scene(1.0, **systems), 0.0))
    assert picture[100, 150, 0] < 0.02 and picture[84, 145, 0] > 0.5


def test_a_picture_without_transparency_covers_where_it_is_bright(folder):
    Image.fromarray(np.full((8, 8), 255, np.uint8)).save(folder / "white.png")
    assert texels(folder / "white.png")[1] == pytest.approx(1.0)


@pytest.mark.parametrize("side", [48, 40, 1000])
def test_a_square_image_fills_its_square_whatever_its_size(folder, side):
    Image.fromarray(np.full((side, side, 4), 255, np.uint8)).save(folder / "full.png")
    assert texels(folder / "full.png")[2] == (1.0, 1.0)
    picture = paint({"radius": 40, "picture": "full.png"}, [[0.0, 0.0, 0.0]])[..., 1]
    assert picture[62:66, 112:116].mean() == pytest.approx(
        picture[100, 150], rel=1e-3
    )  # a corner is as bright as the middle


def test_a_large_image_keeps_1024_texels_a_side(folder):
    """Stripes of two texels of an image of 2048 become stripes of one. Mutant: 512, where they are an even grey."""
    stripes = np.zeros((2048, 2048, 4), np.uint8)
    stripes[:, :, 3], stripes[:, (np.arange(2048) // 2) % 2 == 0, :3] = 255, 255
    Image.fromarray(stripes).save(folder / "stripes.png")
    largest = texels(folder / "stripes.png")[0][: 1024 * 1024, 0].reshape(1024, 1024)
    assert (largest[:, ::2] == 1.0).all() and (largest[:, 1::2] == 0.0).all()


def _huge_png(path):
    """A header that says 20,000 x 20,000."""
    data = struct.pack(">IIBBBBB", 20_000, 20_000, 8, 0, 0, 0, 0)
    chunk = struct.pack(">I", len(data)) + b"IHDR" + data + struct.pack(">I", zlib.crc32(b"IHDR" + data))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk + struct.pack(">I", 0) + b"IDAT" + struct.pack(">I", zlib.crc32(b"IDAT"))
    )


@pytest.mark.parametrize(
    "image, says",
    [
        ("nowhere.png", "no such file"),
        ("/etc/passwd", "own folder"),
        ("../secret.png", "own folder"),
        ("link.png", "leads out"),
        ("text.png", "cannot be read as a picture"),
        ("huge.png", "million pixels"),
        ("", "name of a file"),
    ],
)
def test_files_that_are_refused(folder, image, says):
    (folder / "text.png").write_text("no picture")
    (folder / "link.png").symlink_to("/etc/hosts")
    _huge_png(folder / "huge.png")
    with pytest.raises(ValidationError, match=says):
        Look(draw="picture", picture=image)


def test_a_preset_s_picture_is_found_beside_it_and_named_in_its_files(folder, tmp_path, monkeypatch):
    monkeypatch.chdir("/")
    text = """version: 1
clock: {duration: 1, fps: 10, step: 0.1}
systems:
  a:
    emitters: {e: {count: 3, shape: {point: [0, 0, 0]}}}
    look: {draw: picture, picture: {image: arrow.png, turn: random}, radius: 0.2}
"""
    (tmp_path / "arrows.yaml").write_text(text)
    token = FOLDER.set(FOLDER.get())
    preset = load_preset(tmp_path / "arrows.yaml")
    FOLDER.reset(token)
    assert [f.place for f in preset.files] == [tmp_path / "arrow.png"] and preset.files == ["arrow.png"]
    again = load_preset(preset, overrides={"clock.fps": 5})
    assert again.files[0].place == tmp_path / "arrow.png"


def test_a_picture_goes_with_its_draw(folder):
    with pytest.raises(ValidationError, match="need each other"):
        Look(draw="disc", picture="arrow.png")
    with pytest.raises(ValidationError, match="need each other"):
        Look(draw="picture")


def test_a_large_picture_gives_its_energy(folder):
    """Its coverage is not summed over its pixels. Mutants: no factor 4; the mean of another image of the picture."""
    camera, size = Camera(position=(0, 0, 10), height=1300.0), (1300, 1300)
    square = np.full((8, 8, 4), 255, np.uint8)
    Image.fromarray(square).save(folder / "square.png")
    for before in ([], ["square.png"]):
        looks = {"a": Look(draw="picture", picture="arrow.png", radius=620.0)}
        looks |= {f"b{k}": Look(draw="picture", picture=name, radius=1.0) for k, name in enumerate(before)}
        systems = {f"b{k}": state([[-640, 640, 0]]) for k in range(len(before))} | {"a": state([[0, 0, 0]])}
        got = Painter(size, camera, looks).paint(scene(1.0, **systems), 0.0)[..., 0].sum(dtype=float)
        assert got == pytest.approx(4 * 620.0**2 * texels(folder / "arrow.png")[1] + 4 * len(before), rel=1e-4)


def test_pictures_stay_what_they_are_from_frame_to_frame(folder):
    """Two images in either order of drawing. Mutant: the second picture begins where the first one does."""
    Image.fromarray(np.full((8, 8, 4), 255, np.uint8)).save(folder / "square.png")
    looks = {name: Look(draw="picture", picture=f"{name}.png", radius=20.0) for name in ("arrow", "square")}
    painter = Painter(SIZE, PIXELS, looks)
    one, two = state([[-50, 0, 0]]), state([[50, 0, 0]])
    first = np.array(painter.paint(scene(1.0, arrow=one, square=two), 0.0))
    painter.paint(scene(1.0, square=two), 0.0)
    assert (painter.paint(scene(1.0, arrow=one, square=two), 0.0) == first).all()
    assert not (first[:, :150] == first[:, 150:]).all()


def test_a_picture_in_no_light_shows_its_own(folder):
    """`light` without any light costs nothing and changes nothing. Mutant: `dark` where the lamp shines."""
    look = {
        "blend": "alpha",
        "radius": 20.0,
        "opacity": 1,
        "albedo": "white",
        "emission": {"color": "white", "intensity": 0.5},
    }
    dark = {"intensity": 0, "ambient_intensity": 0}
    unlit, faint, bright = (
        paint({**look, "light": dark | more}, [[0, 0, 0], [60, 30, 5]])
        for more in ({}, {"ambient_intensity": 1e-9}, {"ambient_intensity": 1})
    )
    assert unlit == pytest.approx(faint, abs=1e-6) and unlit.max() > 0.4
    assert bright.sum() > 1.01 * unlit.sum()
