"""OpenEXR: the film's light as it is, with its layers, its recipe and the exposure noted."""

import builtins
import hashlib
from pathlib import Path

import numpy as np
import pytest

from gen_art.errors import OutputError, UsageError
from gen_art.output import job
from gen_art.output.exr import write_exr
from gen_art.output.playback import Playback
from gen_art.output.read_recipe import read_recipe
from gen_art.output.rerun import rerun
from tests.output.piece import piece

OpenEXR = pytest.importorskip("OpenEXR")
RECIPE = {"format": 1, "preset": {"name": "ä"}}


def digest(path) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def read(path):
    with OpenEXR.File(str(path)) as file:
        return {name: channel.pixels.copy() for name, channel in file.channels().items()}, dict(file.header())


@pytest.fixture
def light():
    rng = np.random.default_rng(1)
    return (rng.random((7, 11, 4)) ** 4 * 50).astype(np.float32)


@pytest.mark.parametrize("bits, kind", [(16, np.float16), (32, np.float32)])
def test_light_and_layers_come_back(tmp_path, light, bits, kind):
    layers = {"Z": light[..., 0] + 1000.1, "velocity.x": light[..., 1] - 7, "velocity.y": light[..., 2] - 7}
    path = write_exr(tmp_path / "a.exr", light, layers, bits, RECIPE, exposure=-1.5)
    channels, header = read(path)
    assert set(channels) == {"RGBA", "Z", "velocity.x", "velocity.y"}
    assert channels["RGBA"].dtype == kind and np.array_equal(channels["RGBA"], light.astype(kind))
    assert channels["Z"].dtype == np.float32 and np.array_equal(channels["Z"], layers["Z"])
    assert channels["velocity.y"].dtype == kind and np.array_equal(
        channels["velocity.y"], layers["velocity.y"].astype(kind)
    )
    assert header["exposure"] == -1.5 and header["compression"] == OpenEXR.ZIP_COMPRESSION
    assert read_recipe(path) == RECIPE
    again = write_exr(tmp_path / "b.exr", light, layers, bits, RECIPE, exposure=-1.5)
    assert digest(path) == digest(again)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.exr", "b.exr"]


def test_what_half_cannot_hold_is_its_largest(tmp_path, light):
    light[0, 0] = 1e6
    channels, _ = read(write_exr(tmp_path / "a.exr", light))
    assert np.all(channels["RGBA"][0, 0] == 65504) and np.isfinite(channels["RGBA"]).all()


def test_a_still_is_the_film_s_linear_light(tmp_path):
    preset = piece(develop__exposure=2, develop__bloom=0.5)
    (path,) = job.still(preset, tmp_path / "a.exr", 0.3, bits=32)
    channels, header = read(path)
    run = Playback(preset, (96, 54), "f32", None)
    assert np.array_equal(channels["RGBA"], run.picture(run.step_of(0.3)))
    assert channels["RGBA"][..., :3].max() > 0.1 and header["exposure"] == 2


def test_a_sequence_holds_the_stills_and_reruns(tmp_path):
    paths = job.render(piece(), tmp_path / "a_##.exr", frames=range(3, 6))
    assert [p.name for p in paths] == ["a_03.exr", "a_04.exr", "a_05.exr"]
    (still,) = job.still(piece(), tmp_path / "s.exr", 4 / 20)
    assert digest(still) == digest(paths[1]) != digest(paths[2])
    assert read(still)[0]["RGBA"].dtype == np.float16
    assert digest(rerun(paths[2], tmp_path / "again.exr")[0]) == digest(paths[2])
    (deep,) = job.still(piece(), tmp_path / "d.exr", 0.2, bits=32)
    assert digest(rerun(deep, tmp_path / "deep.exr")[0]) == digest(deep)


def test_layers_of_depth_and_motion(tmp_path):
    (path,) = job.still(piece(), tmp_path / "a.exr", 0.3)
    channels, _ = read(path)
    assert {"Z", "velocity.x", "velocity.y"} <= set(channels)
    assert channels["Z"].shape == (54, 96) == channels["velocity.x"].shape


def test_surfaces_have_layers_under_names_that_compositors_group(tmp_path):
    """Each name is LAYER.CHANNEL with a channel of one letter, which OpenEXR groups: R, G, B and X, Y, Z."""
    (path,) = job.still(piece(ground="#808080", light={}), tmp_path / "a.exr", 0.3)
    with OpenEXR.File(str(path), separate_channels=True) as file:
        assert set(file.channels()) == {
            "R", "G", "B", "A", "Z", "velocity.x", "velocity.y", "albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y",
            "normal.Z", "shadow",
        }  # fmt: skip
        assert file.channels()["albedo.R"].pixels.dtype == np.float16


def test_without_the_package_a_sentence_says_how_to_get_it(tmp_path, monkeypatch):
    real = builtins.__import__

    def none(name, *args, **more):
        if name == "OpenEXR":
            raise ImportError(name)
        return real(name, *args, **more)

    monkeypatch.setattr(builtins, "__import__", none)
    with pytest.raises(UsageError, match="pip install OpenEXR"):
        job.still(piece(), tmp_path / "a.exr", 0)
    with pytest.raises(UsageError, match="pip install OpenEXR"):
        job.render(piece(), tmp_path / "a_##.exr")
    assert not list(tmp_path.iterdir())


def test_what_the_system_refuses(tmp_path, light, monkeypatch):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(OutputError):
        write_exr(tmp_path / "file" / "a.exr", light)
    (tmp_path / "b.exr").write_bytes(b"no picture")
    with pytest.raises(UsageError, match="cannot be read"):
        read_recipe(tmp_path / "b.exr")
    monkeypatch.setattr(OpenEXR.File, "write", _full)
    with pytest.raises(OutputError, match="No space"):
        write_exr(tmp_path / "c.exr", light)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["b.exr", "file"]


def _full(*args):
    raise RuntimeError("No space left on device")
