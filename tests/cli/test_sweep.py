"""`gen-art sweep`: a file for each variation, the same as by hand; run again it leaves what it has made."""

from pathlib import Path

import pytest

from tests.cli.test_sheet import digest, piece

__all__ = ["piece"]
SMALL = ("--size", "64x36", "--frames", "0..2")


def test_each_film_has_the_bytes_of_its_render(gen_art, piece):
    made = gen_art("sweep", piece, "-o", "out/{seed}_{push}.mkv", "--seeds", "4,5", "--vary", "knobs.push=6,12", *SMALL)
    assert made.status == 0 and made.out.split() == [f"out/{seed}_{push}.mkv" for seed in (4, 5) for push in (6, 12)]
    assert len({digest(path) for path in made.out.split()}) == 4
    one = gen_art("render", piece, "-o", "one.mkv", *SMALL, "--seed", "5", "--set", "knobs.push=6")
    assert one.status == 0 and digest("one.mkv") == digest("out/5_6.mkv")


def test_pictures_and_their_time(gen_art, piece):
    assert (
        gen_art(
            "sweep", piece, "-o", "{push}.png", "--vary", "knobs.push=6,12", "--time", "0.5", "--size", "64x36"
        ).status
        == 0
    )
    assert (
        gen_art("still", piece, "-o", "one.png", "--time", "0.5", "--size", "64x36", "--set", "knobs.push=12").status
        == 0
    )
    assert digest("one.png") == digest("12.png") != digest("6.png")
    assert (
        gen_art(
            "sweep", piece, "-o", "{preset}_{seed}.webp", "--seeds", "1,2", "--time", "0.5", "--size", "64x36"
        ).status
        == 0
    )
    made = gen_art("sweep", piece, "-o", "{number}_{push}.jpg", "--mutate", "0.3", "--count", "3", "--size", "64x36")
    assert made.status == 0 and made.out.split()[0] == "1_9.jpg" and len(set(made.out.split())) == 3


def test_what_is_made_is_left_and_what_is_missing_is_made(gen_art, piece):
    command = ("sweep", piece, "-o", "{seed}.png", "--seeds", "1..3", "--size", "64x36", "--time", "0.5")
    assert gen_art(*command).status == 0
    before = {name: Path(name).stat().st_mtime_ns for name in ("1.png", "2.png", "3.png")}
    Path("2.png").unlink()
    again = gen_art(*command)
    assert again.status == 0 and "2 of 3 are made already" in again.err
    now = {name: Path(name).stat().st_mtime_ns for name in before}
    assert [name for name in before if now[name] != before[name]] == ["2.png"]
    plan = gen_art(*command, "--dry-run")
    assert plan.out.count("made already") == 3 and plan.out.startswith("1.png: seed 1, made already")


@pytest.mark.parametrize(
    "change", [("--size", "32x18"), ("--time", "0.25"), ("--set", "knobs.push=7"), ("--precision", "f64")]
)
def test_a_file_made_in_another_way_is_not_replaced_unasked(gen_art, piece, change):
    command = ["sweep", piece, "-o", "{seed}.png", "--seeds", "1,2", "--size", "64x36", "--time", "0.5"]
    assert gen_art(*command).status == 0
    before = digest("1.png")
    other = gen_art(*command, *change)
    assert other.status == 5 and "1.png exists already" in other.err and digest("1.png") == before
    assert gen_art(*command, *change, "--overwrite").status == 0 and digest("1.png") != before


@pytest.mark.parametrize(
    ("out", "arguments", "words"),
    [
        ("a.mp4", ("--seeds", "1,2"), "a.mp4 would be the file of two variations, seed 1 and seed 2: name what varies in -o, such as {seed}"),
        ("{sed}.mp4", ("--seeds", "1,2"), "nothing is called {sed}; did you mean 'seed'"),
        ("{lifetime}.mp4", ("--vary", "systems.drops.particle.lifetime=1,2", "--vary", "systems.splash.particle.lifetime=1,2"), "both called 'lifetime'"),
        ("{seed}.mp4", ("--seeds", "0..10000"), "10,001 variations"),
        ("{seed}_####.png", ("--seeds", "1,2"), "not a picture for each frame"),
        ("{seed}.avi", ("--seeds", "1,2"), "is not a"),
        ("{seed}.png", ("--seeds", "1,2", "--time", "1", "--codec", "h264"), "--time is of pictures"),
        ("{seed}.mp4", (), "say what varies"),
        ("{seed}.png", ("--seeds", "1,2", "--workers", "2", "--scheduler", "tcp://a:1"), "give one of them"),
        ("{seed}.png", ("--seeds", "1,2", "--time", "1", "--scheduler", "nowhere"), "is no address such as tcp://10.0.0.5:8786"),
    ],
)  # fmt: skip
def test_wrong_sweeps(gen_art, piece, tmp_path, out, arguments, words):
    result = gen_art("sweep", piece, "-o", out, *arguments)
    assert result.status == 2 and words in result.err
    assert [path.name for path in tmp_path.iterdir()] == ["piece.yaml"]


def test_a_wrong_variation_is_found_before_anything_is_made(gen_art, piece, tmp_path):
    result = gen_art("sweep", piece, "-o", "{cd}.png", "--vary", "forces.drag.cd=0.5,-1", "--time", "0.5")
    assert result.status == 3 and "this is the variation with cd -1" in result.err
    assert [path.name for path in tmp_path.iterdir()] == ["piece.yaml"]


def test_a_film_with_another_codec_is_another(gen_art, piece):
    command = (
        "sweep",
        piece,
        "-o",
        "{seed}.mp4",
        "--seeds",
        "1,2",
        *SMALL,
        "--quality",
        "draft",
        "--set",
        "camera.supersample=2",
    )
    assert gen_art(*command).status == 0
    assert "2 of 2 are made already" in gen_art(*command).err
    assert gen_art(*command, "--codec", "h265").status == 5
