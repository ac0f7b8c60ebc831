"""Files: what is written is what was given, in every format, with the recipe in it, whole or not at all."""

import numpy as np
import pytest
from PIL import Image

from gen_art.errors import OutputError, UsageError
from gen_art.files import beside
from gen_art.output.read_recipe import read_recipe
from gen_art.output.stills import write_still

RECIPE = {"format": 1, "preset": {"name": "ä"}, "numbers": [1.5, 2]}


@pytest.fixture
def picture():
    x, y = np.meshgrid(np.linspace(0, 255, 80), np.linspace(0, 255, 48))
    return np.stack([x, y, 255 - x], axis=2).astype(np.uint8)


@pytest.mark.parametrize("name, most", [("a.png", 0), ("a.jpg", 4), ("a.jpeg", 4), ("a.webp", 8)])
def test_stills_hold_the_picture_and_the_recipe(tmp_path, picture, name, most):
    path = write_still(tmp_path / name, picture, RECIPE)
    assert np.abs(np.asarray(Image.open(path)).astype(int) - picture).mean() <= most
    assert read_recipe(path) == RECIPE
    assert [p.name for p in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("channels", [3, 4])
def test_png_of_16_bits(tmp_path, channels):
    deep = np.random.default_rng(1).integers(0, 65536, (20, 33, channels), dtype=np.uint16)
    path = write_still(tmp_path / "a.png", deep, RECIPE)
    assert read_recipe(path) == RECIPE
    data = path.read_bytes()
    assert data[24] == 16, "bit depth of the header"
    assert np.array_equal(np.asarray(Image.open(path)), deep >> 8), "another reader takes the upper eight"


def test_a_failure_leaves_nothing_and_keeps_what_was_there(tmp_path):
    target = tmp_path / "a.png"
    target.write_bytes(b"before")
    with pytest.raises(RuntimeError), beside(target) as temporary:
        temporary.write_bytes(b"half")
        raise RuntimeError
    assert target.read_bytes() == b"before" and len(list(tmp_path.iterdir())) == 1


def test_the_system_s_refusal_is_an_output_error(tmp_path):
    with pytest.raises(OutputError, match="cannot write"), beside(tmp_path / "a.png"):
        raise OSError(28, "No space left on device")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(OutputError):
        write_still(tmp_path / "file" / "a.png", np.zeros((2, 2, 3), np.uint8))


def test_recipes_too_long_for_exif_are_refused(tmp_path):
    long = {**RECIPE, "words": "x" * 70_000}
    with pytest.raises(UsageError, match=r"write a \.png"):
        write_still(tmp_path / "a.jpg", np.zeros((2, 2, 3), np.uint8), long)
    assert read_recipe(write_still(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8), long)) == long


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.exr", "a.gas"])
def test_a_temporary_file_follows_no_link_that_waits_for_it(tmp_path, picture, name):
    """Links of any name that this process could have used before it chose a random one."""
    import os

    from gen_art.output.exr import write_exr
    from gen_art.simulation import Simulation
    from tests.output.piece import piece

    victim = tmp_path / "victim"
    victim.write_text("precious")
    for part in (f".a.{os.getpid()}.part{name[1:]}", f".{name}.{os.getpid()}.part"):
        (tmp_path / part).symlink_to(victim)
    if name == "a.gas":
        Simulation(piece()).save(tmp_path / name)
    elif name == "a.exr":
        pytest.importorskip("OpenEXR")
        write_exr(tmp_path / name, np.zeros((4, 4, 4), np.float32))
    else:
        write_still(tmp_path / name, picture)
    assert victim.read_text() == "precious" and (tmp_path / name).is_file()


def test_a_file_that_appears_meanwhile_is_kept_without_overwrite(tmp_path):
    path = tmp_path / "a.png"
    with pytest.raises(OutputError, match="exists already"), beside(path, overwrite=False) as temporary:
        temporary.write_text("new")
        path.write_text("precious")
    assert path.read_text() == "precious" and list(tmp_path.iterdir()) == [path]


def test_a_link_is_replaced_and_not_followed(tmp_path):
    from gen_art.output.target import check_writable

    (tmp_path / "a.png").symlink_to(tmp_path / "nowhere")
    with pytest.raises(OutputError, match="exists already"):
        check_writable([tmp_path / "a.png"], overwrite=False)
    with beside(tmp_path / "a.png") as temporary:
        temporary.write_text("new")
    assert (tmp_path / "a.png").read_text() == "new" and not (tmp_path / "nowhere").exists()
