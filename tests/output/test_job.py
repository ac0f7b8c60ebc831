"""Jobs: films, sequences and stills agree; recipes make the same bytes; what cannot be written is refused first."""

import hashlib
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gen_art.commands.main import run
from gen_art.errors import MemoryRefused, OutputError, UsageError
from gen_art.output import job
from gen_art.output.probe import probe
from gen_art.output.read_recipe import read_recipe
from gen_art.output.rerun import rerun
from tests.output.piece import piece
from tests.output.test_video import exact

ROOT = Path(__file__).parents[2]


def pixels(path) -> np.ndarray:
    return np.asarray(Image.open(path))


def digest(path) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


@pytest.fixture(scope="module")
def sequence(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sequence")
    return job.render(piece(), folder / "a_###.png")


def test_a_sequence_has_a_file_a_frame_and_something_in_it(sequence):
    assert [p.name for p in sequence] == [f"a_{k:03d}.png" for k in range(10)]
    assert pixels(sequence[-1]).shape == (54, 96, 3)
    assert pixels(sequence[-1]).max() > 100
    assert not np.array_equal(pixels(sequence[3]), pixels(sequence[4]))


@pytest.mark.parametrize("frame", [0, 3, 9])
def test_a_still_is_the_film_s_frame_byte_for_byte_trails_included(sequence, tmp_path, frame):
    (path,) = job.still(piece(), tmp_path / "s.png", frame / 20)
    assert digest(path) == digest(sequence[frame])


def test_a_part_of_a_film_is_that_part(sequence, tmp_path):
    part = job.render(piece(), tmp_path / "a_###.png", frames=range(2, 9, 3))
    assert [digest(p) for p in part] == [digest(sequence[k]) for k in (2, 5, 8)]
    (one,) = job.render(piece(), tmp_path / "one.png", frames=4)
    assert digest(one) == digest(sequence[4])


def test_trails_last_their_half_life_whatever_the_fps(tmp_path):
    """The same film time at twice the frames a second has the same trails."""
    strong = {"systems__sparks__look__trail__strength": 6}
    slow = job.still(piece(**strong), tmp_path / "a.png", 0.4)[0]
    fast = job.still(piece(clock__fps=40, **strong), tmp_path / "b.png", 0.4)[0]
    bare = job.still(piece(systems__sparks__look__trail=None), tmp_path / "c.png", 0.4)[0]
    a, b, c = (pixels(p).astype(float) for p in (slow, fast, bare))
    assert a.mean() > 1.2 * c.mean(), "there is a trail"
    assert abs(a.mean() - b.mean()) < 0.15 * (a.mean() - c.mean())


def test_rerun_makes_the_same_bytes(sequence, tmp_path):
    assert digest(rerun(sequence[6], tmp_path / "again.png")[0]) == digest(sequence[6])
    for name, bits in (("a.png", 16), ("a.jpg", 8), ("a.webp", 8)):
        (path,) = job.still(piece(seed=8), tmp_path / name, 0.2, size=(60, 40), bits=bits, quality="draft")
        assert digest(rerun(path, tmp_path / f"again_{name}")[0]) == digest(path), name


def test_a_rerun_is_refused_what_does_not_fit_in_memory(sequence, tmp_path, monkeypatch):
    monkeypatch.setattr("gen_art.preset.estimate.available_memory", lambda: 1e8)
    with pytest.raises(MemoryRefused, match="need about"):
        rerun(sequence[6], tmp_path / "again.png")


def test_a_recipe_that_is_nested_too_deeply_is_refused(tmp_path, monkeypatch):
    import gen_art.output.stills as stills

    monkeypatch.setattr(stills, "encode", lambda recipe: '{"preset":' * 50_000 + "1" + "}" * 50_000)
    path = stills.write_still(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), {})
    with pytest.raises(UsageError, match="no recipe inside"):
        rerun(path, tmp_path / "b.png")


FILMS = [
    ("mp4", {}), ("mp4", {"bits": 10}), ("mp4", {"codec": "h265"}), ("mp4", {"codec": "av1", "bits": 10}),
    ("mp4", {"max_rate": 200_000}), ("mov", {"transparent": True}), ("mov", {"codec": "h265", "bits": 10}),
    ("mkv", {"bits": 16}), ("mkv", {"transparent": True}), ("webm", {"profile": "master"}), ("webm", {"codec": "av1"}),
    ("webm", {"transparent": True}), ("gif", {}), ("webp", {"transparent": True}), ("webp", {"profile": "master"}),
]  # fmt: skip


@pytest.mark.parametrize("extension, asked", FILMS)
def test_films_repeat_and_hold_their_recipe(tmp_path, extension, asked):
    (path,) = job.render(piece(), tmp_path / f"a.{extension}", frames=range(1, 6), quality="preview", **asked)
    recipe = read_recipe(path)
    assert recipe["frames"] == [1, 5, 1] and recipe["preset"] == piece().resolved() and recipe["size"] == [96, 54]
    assert digest(rerun(path, tmp_path / f"b.{extension}")[0]) == digest(path)
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"a.{extension}", f"b.{extension}"], "nothing else is left"


def test_recipes_say_what_the_encoder_was_asked(tmp_path):
    (path,) = job.render(piece(), tmp_path / "a.mov", codec="h265", bits=10, frames=range(2))
    assert {k: read_recipe(path)[k] for k in ("codec", "profile", "bits")} == {
        "codec": "h265",
        "profile": "web",
        "bits": 10,
    }
    for quality, profile, found in (
        ("draft", None, "preview"),
        ("preview", None, "preview"),
        ("draft", "master", "master"),
    ):
        target, _ = job.check_target(piece(), tmp_path / "b.mp4", quality=quality, profile=profile)
        assert target.film.profile == found
    (other,) = rerun(path, tmp_path / "b.mkv")
    assert read_recipe(other)["codec"] == "ffv1", "another extension has its own codec"


@pytest.mark.parametrize("bits, transparent", [(8, False), (16, False), (8, True), (16, True)])
def test_a_lossless_film_s_frames_are_the_stills(tmp_path, bits, transparent):
    (film,) = job.render(piece(), tmp_path / "a.mkv", bits=bits, transparent=transparent)
    frames = list(exact(film))
    assert len(frames) == 10
    for k in (0, 4, 9):
        (path,) = job.still(piece(), tmp_path / f"{k}.png", k / 20, bits=bits, transparent=transparent)
        if bits == 8:
            assert np.array_equal(frames[k], pixels(path))
        else:  # Pillow reads the upper eight bits only
            again = job.still(piece(), tmp_path / f"{k}.mkv.png", k / 20, bits=16, transparent=transparent)[0]
            assert digest(again) == digest(path) and np.array_equal(frames[k] >> 8, pixels(path))
            assert len(np.unique(frames[k] & 255)) > 50, "there is something in the lower eight"


def test_deep_films_are_developed_deep(tmp_path):
    """A 10-bit film has more levels than an 8-bit picture has."""
    import av

    (path,) = job.render(piece(), tmp_path / "a.mov", frames=range(9, 10), profile="master")
    with av.open(str(path)) as film:
        luma = next(film.decode(video=0)).planes[0]
    assert len(np.unique(np.frombuffer(luma, np.uint16))) > 300


def test_sequences_take_16_bits(tmp_path):
    (path,) = job.render(piece(), tmp_path / "a_#.png", frames=4, bits=16)
    assert path.read_bytes()[24] == 16
    assert digest(job.still(piece(), tmp_path / "s.png", 0.2, bits=16)[0]) == digest(path)


def test_mp4_is_h264_tagged_bt709_limited(tmp_path):
    (path,) = job.render(piece(), tmp_path / "a.mp4")
    found = probe(path)
    assert (found.codec, found.pixel_format, found.size, found.frames) == ("h264", "yuv420p", (96, 54), 10)
    assert (found.primaries, found.transfer, found.matrix, found.range) == (1, 1, 1, 1)
    assert found.fps == 20 and found.duration == pytest.approx(0.5)


def test_progress_counts_frames_and_particles(tmp_path):
    events = []
    job.render(piece(), tmp_path / "a_##.png", frames=range(4), progress=events.append)
    assert [(e["event"], e["frame"], e["frames"]) for e in events] == [("frame", k, 4) for k in range(4)]
    assert all(e["particles"] > 200 and e["fps"] > 0 for e in events) and events[-1]["eta"] == 0
    json.dumps(events)


def test_a_draft_draws_each_pixel_once(tmp_path):
    """Mutant: a draft with the preset's supersample, which its picture then shows."""
    fine = piece(**{"camera.supersample": 2})
    paths = [
        *job.still(fine, tmp_path / "draft.png", 0.2, size=(120, 80), quality="draft"),
        *job.still(piece(), tmp_path / "small.png", 0.2, size=(60, 40)),
        *job.still(fine, tmp_path / "fine.png", 0.2, size=(60, 40)),
    ]
    draft, small, averaged = (np.asarray(Image.open(path)) for path in paths)
    assert np.array_equal(draft, small) and not np.array_equal(draft, averaged)
    assert np.array_equal(np.asarray(Image.open(rerun(paths[0], tmp_path / "again.png")[0])), draft)


def test_sizes_scale_and_draft_halves(tmp_path):
    assert job.picture_size(piece()) == (96, 54)
    assert job.picture_size(piece(), scale=0.5) == (48, 27)
    assert job.picture_size(piece(), scale=0.5, even=True) == (48, 28)
    assert job.picture_size(piece(), (200, 100), quality="draft") == (100, 50)
    (path,) = job.render(piece(), tmp_path / "a.mp4", scale=0.5, frames=range(2))
    assert probe(path).size == (48, 28)


def test_names_are_filled_in(tmp_path):
    (path,) = job.still(piece(), tmp_path / "{preset}_{seed}.png", 0)
    assert path.name == "small_5.png" and path.exists()


def test_transparent_pictures_have_holes(tmp_path):
    (path,) = job.still(piece(develop__background="teal"), tmp_path / "a.png", 0.3, transparent=True)
    alpha = pixels(path)[..., 3]
    assert alpha[0, 0] == 0 and alpha.max() > 150


@pytest.mark.parametrize(
    "name, more, error, words",
    [
        ("a.mp4", {"size": (97, 54)}, UsageError, "96x54 and 98x54"),
        ("a.mp4", {"transparent": True}, UsageError, "cannot be transparent"),
        ("a_##.jpg", {"transparent": True}, UsageError, "cannot be transparent"),
        ("a.mp4", {"codec": "h264x"}, UsageError, "did you mean 'h264'"),
        ("a.mp4", {"codec": "vp9"}, UsageError, r"VP9 needs the extension \.webm or \.mkv"),
        ("a_##.png", {"codec": "h264"}, UsageError, "for films"),
        ("a_##.png", {"profile": "web"}, UsageError, "for films"),
        ("a_##.png", {"bits": 10}, UsageError, r"\.png 8 or 16"),
        ("a_##.exr", {"bits": 8}, UsageError, r"\.exr 16 or 32"),
        ("a.mp4", {"bits": 16}, UsageError, "8 or 10 bits"),
        ("a.webm", {"size": (96, 55)}, UsageError, "96x54 and 96x56"),
        ("a.mp5", {}, UsageError, "did you mean '.mp4'"),
        ("a", {}, UsageError, "has no extension"),
        ("a.exr", {}, UsageError, r"a_####\.exr"),
        ("a.png", {}, UsageError, "a_####.png"),
        ("-", {}, UsageError, "path"),
        ("a.mp4", {"size": (0, 10)}, UsageError, "1 to 16384"),
        ("a.mp4", {"size": (20000, 10)}, UsageError, "16384"),
        ("a.mp4", {"quality": "best"}, UsageError, "draft, preview, final"),
        ("a.mp4", {"frames": range(0)}, UsageError, "no frames"),
        ("a.mp4", {"frames": [3, 1]}, UsageError, "in order"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path, name, more, error, words):
    with pytest.raises(error, match=words):
        job.render(piece(), tmp_path / name if name != "-" else name, **more)
    assert not list(tmp_path.iterdir())


def test_existing_output_is_kept_unless_overwritten(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"mine")
    with pytest.raises(OutputError, match="--overwrite"):
        job.still(piece(), path, 0)
    assert path.read_bytes() == b"mine"
    job.still(piece(), path, 0, overwrite=True)
    assert pixels(path).shape == (54, 96, 3)
    with pytest.raises(OutputError, match="directory"):
        job.still(piece(), _folder(tmp_path / "d.png"), 0)
    (tmp_path / "f_01.png").write_bytes(b"")
    with pytest.raises(OutputError, match=r"f_01\.png exists"):
        job.render(piece(), tmp_path / "f_##.png")
    assert not (tmp_path / "f_00.png").exists()


def _folder(path):
    path.mkdir()
    return path


def test_a_file_in_the_way_of_the_folder_is_named(tmp_path):
    (tmp_path / "x").write_bytes(b"")
    with pytest.raises(OutputError, match="x is not a folder"):
        job.still(piece(), tmp_path / "x" / "a.png", 0)


def test_times_between_steps_are_refused_with_the_nearest(tmp_path):
    with pytest.raises(UsageError, match=r"nearest is 0\.1 s"):
        job.still(piece(), tmp_path / "a.png", 0.101)
    with pytest.raises(UsageError):
        job.still(piece(), tmp_path / "a.png", -1)


def test_recipes_of_other_versions_or_without_their_plugins_are_refused(tmp_path, sequence):
    from gen_art.output.stills import write_still

    recipe = read_recipe(sequence[0])
    for change, words in (
        ({"gen_art": "9.9"}, "9.9"),
        ({"plugins": [{"name": "swirl.py", "sha256": "ab" * 32}]}, "swirl.py"),
        ({"format": 99}, "format 99"),
    ):
        changed = write_still(tmp_path / f"{words}.png", np.zeros((4, 4, 3), np.uint8), {**recipe, **change})
        with pytest.raises(UsageError, match=words):
            rerun(changed, tmp_path / "out.png")
    Image.new("RGB", (4, 4)).save(tmp_path / "bare.png")
    with pytest.raises(UsageError, match="no recipe"):
        rerun(tmp_path / "bare.png", tmp_path / "out.png")
    (tmp_path / "no.png").write_bytes(b"no picture")
    with pytest.raises(UsageError, match="cannot be read"):
        rerun(tmp_path / "no.png", tmp_path / "out.png")
    with pytest.raises(OutputError, match="no such file"):
        rerun(tmp_path / "none.png", tmp_path / "out.png")


@pytest.fixture
def pictured(tmp_path):
    """A preset in a folder of its own, with a sprite."""
    (tmp_path / "own").mkdir()
    sprite = np.zeros((8, 8, 4), np.uint8)
    sprite[2:6, 1:7] = 255
    Image.fromarray(sprite).save(tmp_path / "own" / "spark.png")
    data = piece().resolved()
    data["systems"]["sparks"]["look"] = {"draw": "picture", "picture": "spark.png", "radius": 0.2}
    (tmp_path / "own" / "pictured.yaml").write_text(json.dumps(data))
    return tmp_path / "own" / "pictured.yaml"


def test_recipes_name_the_preset_s_files_and_rerun_finds_them(tmp_path, pictured, monkeypatch):
    (path,) = job.still(pictured, tmp_path / "a.png", 0.3)
    (entry,) = read_recipe(path)["files"]
    assert (entry["path"], entry["sha256"]) == ("spark.png", digest(pictured.parent / "spark.png"))
    again = rerun(path, tmp_path / "b.png", folder=pictured.parent)[0]
    assert digest(again) == digest(path)
    monkeypatch.chdir(pictured.parent)
    assert digest(rerun(path, tmp_path / "c.png")[0]) == digest(path)
    (film,) = job.render("pictured.yaml", pictured.parent / "d.mkv", frames=range(2))
    monkeypatch.chdir(tmp_path)
    assert digest(rerun(film, tmp_path / "e.mkv")[0]) == digest(film), "beside the picture"


def test_small_files_travel_in_the_recipe(tmp_path, pictured):
    (path,) = job.still(pictured, tmp_path / "a.png", 0.3)
    (pictured.parent / "spark.png").unlink()
    assert digest(rerun(path, tmp_path / "b.png")[0]) == digest(path)
    with pytest.raises(UsageError, match=r"spark\.png, which is not in .* give --folder"):
        rerun(path, tmp_path / "c.png", folder=pictured.parent)


def test_a_file_that_several_systems_name_travels_once(tmp_path, pictured):
    data = json.loads(pictured.read_text())
    data["systems"]["more"] = data["systems"]["sparks"]
    pictured.write_text(json.dumps(data))
    (path,) = job.still(pictured, tmp_path / "a.png", 0.3, size=(32, 18))
    assert [("data" in file) for file in read_recipe(path)["files"]] == [True]


@pytest.mark.parametrize(
    "damage", [{"path": "../spark.png"}, {"path": "/tmp/spark.png"}, {"data": "AAAA"}, {"data": "?"}, {"data": 3}]
)
def test_a_damaged_file_in_a_recipe_is_refused(tmp_path, pictured, damage):
    from gen_art.output.stills import write_still

    (path,) = job.still(pictured, tmp_path / "a.png", 0.3)
    (pictured.parent / "spark.png").unlink()
    recipe = read_recipe(path)
    recipe["files"][0] |= damage
    write_still(path, np.zeros((4, 4, 3), np.uint8), recipe)
    with pytest.raises(UsageError):
        rerun(path, tmp_path / "b.png")
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix == ".png") == ["a.png"]


def test_a_large_sprite_that_changed_or_is_gone_is_a_sentence(tmp_path, pictured):
    noise = np.random.default_rng(0).integers(0, 255, (120, 120, 4), dtype=np.uint8)
    Image.fromarray(noise).save(pictured.parent / "spark.png")
    (path,) = job.still(pictured, tmp_path / "a.png", 0.3)
    assert "data" not in read_recipe(path)["files"][0]
    with pytest.raises(UsageError, match=r"spark\.png, which is not in .* give --folder"):
        rerun(path, tmp_path / "b.png")
    Image.new("RGBA", (8, 8), "red").save(pictured.parent / "spark.png")
    with pytest.raises(UsageError, match=r"spark\.png is not the file that the picture was made with \(sha256"):
        rerun(path, tmp_path / "b.png", folder=pictured.parent)
    assert not (tmp_path / "b.png").exists()


def test_a_picture_of_another_version_is_made_on_request(tmp_path, sequence):
    from gen_art.output.stills import write_still

    older = write_still(
        tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), {**read_recipe(sequence[2]), "gen_art": "0.0.9"}
    )
    with pytest.raises(UsageError, match=r"made by gen-art 0\.0\.9; .* --other-version"):
        rerun(older, tmp_path / "b.png")
    with pytest.warns(UserWarning, match=r"made by gen-art 0\.0\.9"):
        rerun(older, tmp_path / "b.png", other_version=True)
    assert digest(tmp_path / "b.png") == digest(sequence[2])
    assert run(["rerun", str(older), "-o", str(tmp_path / "c.png"), "--other-version"]) == 0
    assert digest(tmp_path / "c.png") == digest(sequence[2])


def test_rerun_says_the_path_and_nothing_else(tmp_path, sequence):
    """Whatever is imported first, Taichi's greeting stays off standard output."""
    command = [sys.executable, str(ROOT / "cli.py"), "rerun", str(sequence[2]), "-o", str(tmp_path / "b.png")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"{tmp_path / 'b.png'}\n"), done.stderr
    done = subprocess.run(
        [*command[:3], str(ROOT / "cli.py"), *command[4:], "--overwrite"], capture_output=True, text=True
    )
    assert done.returncode == 2 and "Traceback" not in done.stderr and done.stdout == ""


@pytest.mark.parametrize(
    "words, says",
    [
        (["--codec", "h256"], "did you mean 'h265'"),
        (["--codec", "divx"], "there are h264, h265, prores, ffv1, vp9, av1"),
        (["--profile", "wb"], "did you mean 'web'"),
        (["--bits", "12"], "there are 8, 10, 16, 32"),
        (["--bits", "32"], "8 or 10 bits"),
        (["--codec", "prores"], "h264 or h265 or av1"),
        (["--codec", "h265", "--size", "14x14"], "at least 16x16"),
        (["--size", "641x360"], "640x360 and 642x360"),
        (["--size", "20000x10"], "16384x16384"),
        (["--transparent"], r"prores \(.mov\)"),
    ],
)
def test_the_command_line_says_what_there_is(tmp_path, capsys, words, says):
    assert run(["render", "fire", "-o", str(tmp_path / "a.mp4"), "--dry-run", *words]) == 2
    said = capsys.readouterr()
    assert re.search(says, said.err) and "Traceback" not in said.err and not said.out


@pytest.mark.parametrize(
    "change",
    [{"size": 3}, {"time": "now"}, {"files": [1]}, {"plugins": [{"name": 3}]}, {"kind": "film"}, {"quality": "best"},
     {"precision": "f16"}, {"size": ["a", 2]}, {"size": [1]}, {"files": [{}]}, {"preset": {"systems": 3}}, {"bits": "x"},
     {"kind": "film", "frames": [0]}, {"kind": "film", "frames": [0, 9, 0]}, {"kind": "film", "frames": ["a", 1, 1]},
     {"kind": "film", "frames": [0, 10**30, 1]}, {"time": 1e30}, {"time": -1}, {"kind": []}, {"codec": [], "kind": "film"}],
)  # fmt: skip
def test_damaged_recipes_are_refused(tmp_path, sequence, change):
    from gen_art.errors import GenArtError
    from gen_art.output.stills import write_still

    damaged = {**read_recipe(sequence[0]), **change}
    path = write_still(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), damaged)
    with pytest.raises(GenArtError):
        rerun(path, tmp_path / "b.png")
    assert not (tmp_path / "b.png").exists()


_FILM = """
import sys
sys.path.insert(0, {root!r})
from gen_art.output import job
from tests.output.piece import piece
for name, more in (("a.mp4", {{}}), ("b.mov", {{}}), ("c.webm", {{"codec": "av1"}}), ("d.mp4", {{"codec": "h265"}}), ("e.gif", {{}})):
    job.render(piece(clock__duration=2.2, camera__size=[48, 32]), sys.argv[2] + name, threads=int(sys.argv[1]), **more)
"""


def test_one_two_and_four_threads_write_the_same_films(tmp_path):
    root = str(ROOT)
    for n in (1, 2, 4):
        subprocess.run([sys.executable, "-c", _FILM.format(root=root), str(n), f"{tmp_path}/{n}"], check=True)
    for name in ("a.mp4", "b.mov", "c.webm", "d.mp4", "e.gif"):
        assert digest(tmp_path / f"1{name}") == digest(tmp_path / f"2{name}") == digest(tmp_path / f"4{name}"), name
