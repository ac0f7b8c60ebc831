"""Files that are damaged, or not what their name says: a sentence, whatever reads them."""

import contextlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gen_art.errors import GenArtError, UsageError
from gen_art.forces.grid_file import read_grid
from gen_art.output.exr import write_exr
from gen_art.output.read_recipe import read_recipe
from gen_art.output.stills import write_still
from gen_art.output.target import find_target
from gen_art.output.video import film_writer
from gen_art.pictures import picture_size, read_picture

ROOT = Path(__file__).parents[2]
RECIPE = {"format": 1, "preset": {"name": "ä"}, "numbers": [1.5, 2]}
PICTURE = np.random.default_rng(0).integers(0, 256, (24, 32, 3), dtype=np.uint8)


def _made(path: Path) -> Path:
    if path.suffix in (".png", ".jpg", ".webp") and "film" not in path.stem:
        return write_still(path, PICTURE, RECIPE)
    if path.suffix == ".exr":
        pytest.importorskip("OpenEXR")
        return write_exr(path, np.zeros((4, 4, 4), np.float32), recipe=RECIPE)
    if path.suffix == ".tif":
        Image.fromarray(PICTURE).save(path, compression="tiff_lzw")
        return path
    if path.suffix == ".npy":
        np.save(path, np.zeros((3, 3, 3, 3)))
        return path
    writer = film_writer(path, (32, 24), 10, RECIPE)
    for _ in range(3):
        writer.add(PICTURE)
    writer.close()
    return path


def _damaged(data: bytes, rng):
    """Copies that are cut, or have some bytes changed, most of them near the beginning."""
    for k in range(120):
        copy = bytearray(data)
        for _ in range(1 + k % 8):
            copy[min(len(data) - 1, int(rng.exponential(len(data) / (2 + k % 9))))] = rng.choice([0, 1, 127, 128, 255])
        yield bytes(copy[: int(rng.integers(0, len(data)))] if k % 4 == 0 else copy)


@pytest.mark.parametrize(
    "name", ["a.png", "a.jpg", "a.webp", "a.exr", "a.tif", "a.npy", "a.mp4", "a.mov", "a.webm", "a.mkv", "a.gif", "film.webp"]
)  # fmt: skip
def test_damaged_files_are_read_or_refused(tmp_path, name):
    path = _made(tmp_path / name)
    data, rng = path.read_bytes(), np.random.default_rng(len(name))
    for damaged in _damaged(data, rng):
        path.write_bytes(damaged)
        readers = [read_recipe]
        if path.suffix in (".png", ".jpg", ".webp", ".tif"):
            readers += [
                lambda p: read_picture(p, "a"),
                lambda p: read_picture(p, "a", "RGB"),
                lambda p: picture_size(p, "a"),
            ]
        if path.suffix == ".npy":
            readers = [read_grid]
        for read in readers:
            try:
                read(path)
            except GenArtError as error:
                assert str(error)


def test_metadata_that_is_no_utf_8_is_a_sentence(tmp_path):
    for name in ("a.mp4", "a.mkv", "a.mov", "a.webm"):
        path = _made(tmp_path / name)
        data = path.read_bytes()
        assert data.count(b"numbers") >= 1
        path.write_bytes(data.replace(b"numbers", b"\xff\xfe\x80bers"))
        assert read_recipe(path)["preset"] == RECIPE["preset"]
        path.write_bytes(data.replace(b'"format', b'\xff\xfe"ormat').replace(b'{"', b"\xff\xfe"))
        with pytest.raises(UsageError, match="no recipe inside"):
            read_recipe(path)


_EPS = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 32 24\n%%EndComments\nshowpage\n"


@pytest.mark.parametrize("kind", ["eps", "bmp", "gif", "tga", "ppm", "ico", "jp2", "psd"])
@pytest.mark.parametrize("ending", [".png", ".jpg", ".webp", ".tif", ".exr"])
def test_a_picture_of_another_format_is_not_opened_whatever_its_name(tmp_path, monkeypatch, kind, ending):
    """An EPS would start another program, Ghostscript."""
    from PIL import EpsImagePlugin

    monkeypatch.setattr(EpsImagePlugin, "Ghostscript", lambda *_: pytest.fail("Ghostscript was started"))
    path = tmp_path / f"a{ending}"
    if kind in ("eps", "psd"):
        path.write_bytes(
            _EPS if kind == "eps" else b"8BPS\0\1" + bytes(6) + b"\0\3\0\0\0\4\0\0\0\4\0\x08\0\3" + bytes(100)
        )
    else:
        try:
            Image.fromarray(PICTURE).save(path, {"jp2": "JPEG2000"}.get(kind, kind.upper()))
        except (OSError, KeyError):
            pytest.skip(f"this Pillow does not write {kind}")
    for read in (picture_size, read_picture, lambda p, name: read_grid(p)):
        with pytest.raises(UsageError, match="picture"):
            read(path, "a picture")


@pytest.mark.parametrize("ending", [".png", ".jpg", ".webp", ".tif"])
def test_the_content_says_the_format(tmp_path, ending):
    for kind in ("PNG", "JPEG", "WEBP", "TIFF"):
        path = tmp_path / f"a{ending}"
        Image.fromarray(PICTURE).save(path, kind)
        assert read_picture(path, "a").shape == PICTURE.shape and picture_size(path, "a") == (32, 24)


def test_a_decompression_bomb_is_a_sentence(tmp_path, recwarn):
    import struct
    import zlib

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    for side in (9_000, 12_000, 100_000):  # below Pillow's warning, between it and Pillow's error, above both
        header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
        path = tmp_path / "a.png"
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b""))
        with pytest.raises(UsageError, match=rf"has {side**2:,} pixels; at most"):
            read_picture(path, "a.png")
    assert not recwarn.list


@pytest.mark.parametrize("mode, bits", [("I;16", 16), ("1", 1), ("CMYK", 8), ("P", 8), ("LA", 8)])
def test_other_kinds_of_pixels_become_8_bits(tmp_path, mode, bits):
    path = tmp_path / "a.tif"
    if bits == 16:
        Image.fromarray(np.arange(0, 65536, 1024, dtype=np.uint16).reshape(8, 8)).save(path)
        assert np.array_equal(read_picture(path, "a"), (np.arange(64, dtype=np.uint8) * 4).reshape(8, 8))
    else:
        Image.fromarray(PICTURE).convert(mode).save(path)
        assert read_picture(path, "a").dtype == np.uint8
    assert read_picture(path, "a", "RGB").shape[2] == 3
    Image.fromarray(np.zeros((4, 4), np.float32)).save(path)
    with pytest.raises(UsageError, match="32 bits"):
        read_picture(path, "a")


def _gen_art(*arguments, folder, redirect=""):
    command = f'exec "$0" "$@" {redirect}'
    return subprocess.run(
        ["sh", "-c", command, sys.executable, str(ROOT / "cli.py"), *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
    )


def test_closed_standard_files_are_sentences(tmp_path):
    done = _gen_art("list", folder=tmp_path, redirect=">&-")
    assert (done.returncode, done.stderr) == (5, "gen-art: cannot print the result: standard output is closed\n")
    done = _gen_art("show", "-", folder=tmp_path, redirect="<&-")
    assert done.returncode == 2 and "standard input, which is closed" in done.stderr and done.stderr.count("\n") == 1
    done = _gen_art("validate", "fire", folder=tmp_path, redirect="2>&-")
    assert (done.returncode, done.stdout) == (0, "fire: ok\n")
    done = _gen_art("list", folder=tmp_path, redirect=">/dev/full")
    assert done.returncode == 5 and done.stderr == "gen-art: No space left on device\n"


@pytest.mark.parametrize("name", ["12:30.mp4", "http:a.mkv", "concat:b.gif", "12:30.webp", "a%d.mov", "12:30.png"])
def test_a_name_with_a_colon_is_a_file(tmp_path, monkeypatch, name):
    from gen_art.output import job
    from gen_art.output.probe import probe
    from tests.output.piece import piece

    monkeypatch.chdir(tmp_path)
    job.render(piece(camera__size=[32, 18]), name, frames=range(1 if name.endswith("png") else 3))
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert read_recipe(name)["name"] == "small"
    if not name.endswith(("webp", "png")):
        assert probe(name).frames == 3


def test_a_nul_in_a_name_is_a_sentence(tmp_path, monkeypatch, capsys):
    from gen_art.commands.main import run

    monkeypatch.chdir(tmp_path)
    bad = "a\0b"
    for words in (["render", "fire", "-o", f"{bad}.mp4"], ["still", f"{bad}.yaml", "-o", "a.png"], ["rerun", f"{bad}.mp4", "-o", "a.mp4"],
                  ["list", "--plugin", f"{bad}.py"], ["new", bad], ["audit", "fire", "-o", f"{bad}.png"], ["gallery", "-o", bad]):  # fmt: skip
        assert run(words) == 2 and "bug" not in capsys.readouterr().err
    with pytest.raises(UsageError):
        find_target(f"{bad}.mp4", moving=True)
    assert not list(tmp_path.iterdir())


def test_a_damaged_snapshot_is_a_sentence(tmp_path):
    import json
    import zipfile

    from gen_art.simulation import Simulation
    from gen_art.simulation.snapshot import read
    from tests.output.piece import piece

    sim, path = Simulation(piece()), tmp_path / "a.gas"
    sim.step(5)
    sim.save(path)
    data = path.read_bytes()
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    for damaged in _damaged(data, np.random.default_rng(3)):
        path.write_bytes(damaged)
        with contextlib.suppress(GenArtError):
            read(path)
    head = json.loads(parts["head.json"])
    sparks = head["systems"]["sparks"]
    for change in ({"systems": []}, {"preset": 3}, {"preset": "fire"}, {"preset": None}, {"dt": "x"}, {"seed": -1}, {"steps": "a"},
                   {"precision": "f16"}, {"systems": {"sparks": 3}}, {"systems": {**head["systems"], "sparks": {**sparks, "count": 3}}}):  # fmt: skip
        with zipfile.ZipFile(path, "w") as archive:
            for name, content in parts.items():
                archive.writestr(name, json.dumps({**head, **change}) if name == "head.json" else content)
        with pytest.raises(GenArtError):
            Simulation.restore(path)


def test_a_folder_that_is_a_broken_link_is_refused_before_anything_is_computed(tmp_path):
    from gen_art.errors import OutputError
    from gen_art.output.target import check_writable

    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(OutputError, match="loop is not a folder"):
        check_writable([tmp_path / "loop" / "a.mp4"], overwrite=False)
