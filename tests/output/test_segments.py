"""Films that stop half way: what is on disk plays, is named, and nothing else is left."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import av
import numpy as np
import pytest

from gen_art.errors import EncoderError, OutputError
from gen_art.output import job, segments
from gen_art.output.formats import find_format
from gen_art.output.fragments import split
from gen_art.output.probe import probe
from gen_art.output.read_recipe import read_recipe
from gen_art.output.video import film_writer, partial_path
from tests.output.piece import piece

ROOT = Path(__file__).parents[2]
SIZE = (32, 24)


def pictures(n, size=SIZE):
    """Noise, so that a film has some size; the same each time."""
    rng = np.random.default_rng(4)
    for _ in range(n):
        yield rng.integers(0, 256, (size[1], size[0], 3), dtype=np.uint8)


def frames_of(path):
    """The film's pictures; every frame must decode."""
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.webm", "a.mkv", "a.gif"])
def test_the_partial_film_plays_up_to_the_last_whole_segment(tmp_path, name):
    path = tmp_path / name
    film = find_format(path)
    writer = film_writer(path, SIZE, 5, {"format": 1, "preset": {}})
    length = round(5 * film.codec.seconds)
    for picture in pictures(length * 4 + 1):
        writer.add(picture)
    # two segments are encoded at a time, so the first is written when the third has begun
    partial = frames_of(partial_path(path))
    assert len(partial) >= length and len(partial) % length == 0
    assert read_recipe(partial_path(path))["preset"] == {}
    writer.close()
    if name != "a.gif":
        whole = frames_of(path)
        assert len(whole) == length * 4 + 1
        assert all(np.array_equal(one, two) for one, two in zip(partial, whole)), "joining changes no picture"
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_segments_do_not_depend_on_what_was_before(tmp_path):
    """Frames 10 to 19 have the same packets in a film of 30 as in one of 20."""

    def packets(n):
        path = tmp_path / f"{n}.mp4"
        writer = film_writer(path, SIZE, 5)
        for picture in pictures(n):
            writer.add(picture)
        writer.close()
        with av.open(str(path)) as film:
            return [bytes(packet) for packet in film.demux(video=0) if packet.pts is not None]

    long, short = packets(30), packets(20)
    assert short == long[:20] and len(set(long)) > 20


def test_times_do_not_come_from_encoders_that_hold_too_few_frames(tmp_path):
    """x265 dates packets by memory it never wrote where a film has fewer frames than it holds back."""
    film, before = find_format("a.mov", codec="h265", bits=10), []
    shown = [p.astype(np.uint16) * 257 for p in pictures(4, (96, 54))]
    for k in range(90):
        before.append(np.full(1000 * (k % 37 + 1), 255, np.uint8))
        writer = film_writer(tmp_path / "a.mov", (96, 54), 5, {"format": 1, "preset": {"x": "y" * 3000}}, film)
        for picture in shown[: 2 + k % 3]:
            writer.add(picture)
        writer.close()
        found = probe(tmp_path / "a.mov")
        assert (found.frames, found.duration) == (2 + k % 3, (2 + k % 3) / 5)


def test_the_index_lies_in_front(tmp_path):
    for name in ("a.mp4", "a.mov"):
        writer = film_writer(tmp_path / name, SIZE, 5)
        for picture in pictures(12):
            writer.add(picture)
        writer.close()
        data = (tmp_path / name).read_bytes()
        assert 0 < data.find(b"moov") < data.find(b"mdat") and b"moof" not in data


def test_films_taken_apart_lose_nothing(tmp_path):
    for muxer, name, kinds in (
        ("mp4", "a.mp4", (b"ftyp", b"moof")),
        ("matroska", "a.mkv", (b"\x1a\x45\xdf\xa3", b"\x1f\x43\xb6\x75")),
    ):
        writer = film_writer(tmp_path / name, SIZE, 5)
        for picture in pictures(3):
            writer.add(picture)
        writer.abort()
        data = partial_path(tmp_path / name).read_bytes()
        if muxer == "mp4":
            head, body = split(data, muxer)
            assert head + body == data and kinds[0] in head and body[4:8] == kinds[1]
        else:
            assert data.startswith(kinds[0]) and data.count(kinds[1]) >= 1


_KILLED = """
import os, signal, sys
sys.path.insert(0, {root!r})
from gen_art.output import job
from tests.output.piece import piece
def stop(event):
    if event["frame"] == 89:
        os.kill(os.getpid(), signal.SIGKILL)
job.render(piece(clock__duration=5, camera__size=[32, 18]), sys.argv[1], progress=stop)
"""


def test_a_killed_render_leaves_a_film_that_plays(tmp_path):
    path = tmp_path / "a.mp4"
    done = subprocess.run([sys.executable, "-c", _KILLED.format(root=str(ROOT)), str(path)], capture_output=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["a.partial.mp4"]
    found = probe(tmp_path / "a.partial.mp4")
    assert found.frames in (40, 80), "whole segments of two seconds at 20 frames a second"
    partial = frames_of(tmp_path / "a.partial.mp4")
    (whole,) = job.render(piece(clock__duration=5, camera__size=[32, 18]), path, overwrite=True)
    assert all(np.array_equal(a, b) for a, b in zip(partial, frames_of(whole)))
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"], "the next render takes the killed one's place"


@pytest.mark.parametrize(
    "signal_, status, word",
    [(signal.SIGINT, 130, "stopped"), (signal.SIGTERM, 143, "terminated"), (signal.SIGHUP, 129, "terminated")],
)
def test_a_stopped_render_names_what_it_keeps(tmp_path, signal_, status, word):
    preset = tmp_path / "small.yaml"
    preset.write_text(json.dumps(piece(clock__duration=2000).resolved()))
    # tests in the background of a shell run with SIGINT or SIGHUP ignored, which a child inherits: the child heeds them again
    start = "import runpy, signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); signal.signal(signal.SIGHUP, signal.SIG_DFL); runpy.run_path(sys.argv.pop(1), run_name='__main__')"
    command = [sys.executable, "-c", start, str(ROOT / "cli.py"), "render", str(preset), "-o", str(tmp_path / "a.mp4"), "--size", "32x18", "--progress", "json"]  # fmt: skip
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=ROOT) as process:
        for line in process.stderr:
            if '"frame": 4,' in line:
                process.send_signal(signal_)
                break
        words = process.stderr.read()
        assert process.wait(60) == status
    assert f"gen-art: {word}" in words and "frames are kept in" in words and "a.partial.mp4" in words, words
    preset.unlink()
    assert [p.name for p in tmp_path.iterdir()] == ["a.partial.mp4"]
    kept = probe(tmp_path / "a.partial.mp4").frames
    assert kept >= 5 and f"first {kept} frames" in words


def test_an_encoder_that_fails_half_way_keeps_what_was_finished(tmp_path, monkeypatch):
    real, made = segments.encoder_stream, []

    class Failing:
        def __init__(self, stream):
            self._stream, self._calls, self._fails = stream, 0, len(made) > 4
            self.codec_context = stream.codec_context

        def encode(self, frame):
            self._calls += 1
            if self._fails and self._calls > 3:
                raise av.error.ExternalError(1, "it broke")
            return self._stream.encode(frame)

    def stream(*args):
        made.append(1)
        return Failing(real(*args))

    monkeypatch.setattr(segments, "encoder_stream", stream)
    with pytest.raises(
        EncoderError, match=r"the encoder failed on a\.mp4.*first 80 frames are kept in .*a\.partial\.mp4"
    ) as error:
        job.render(piece(clock__duration=6, camera__size=[32, 18]), tmp_path / "a.mp4")
    assert error.value.exit_code == 6
    assert [p.name for p in tmp_path.iterdir()] == ["a.partial.mp4"]
    assert probe(tmp_path / "a.partial.mp4").frames == 80


def test_nothing_is_left_where_nothing_was_finished(tmp_path, monkeypatch):
    def stream(container, *args):
        raise av.error.ExternalError(1, "no such encoder")

    monkeypatch.setattr(segments, "encoder_stream", stream)
    with pytest.raises(EncoderError):
        job.render(piece(), tmp_path / "a.mp4")
    assert not list(tmp_path.iterdir())


def test_an_error_in_between_keeps_the_frames_before_it(tmp_path):
    def stop(event):
        if event["frame"] == 6:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as error:
        job.render(piece(), tmp_path / "a.webm", progress=stop)
    assert "the first 7 frames are kept in" in error.value.__notes__[0]
    assert probe(tmp_path / "a.partial.webm").frames == 7


_FULL = """
import resource, signal, sys
sys.path.insert(0, {root!r})
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from gen_art.commands.main import run
import tests.output.test_segments as t
from gen_art.errors import OutputError
from gen_art.backend import runtime
runtime.init("cpu")
path = t.Path(sys.argv[1])
writer = t.film_writer(path, (64, 48), 5)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
try:
    for picture in t.pictures(45, (64, 48)):
        writer.add(picture)
    writer.close()
except OutputError as error:
    print(error.exit_code, error, "|", writer.abort())
"""


@pytest.mark.parametrize("name, limit", [("a.mp4", 120_000), ("a.mkv", 100_000), ("a.gif", 100_000)])
def test_a_full_disk_is_an_output_error_and_keeps_whole_segments(tmp_path, name, limit):
    code = _FULL.format(root=str(ROOT))
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / name), str(limit)], capture_output=True, text=True
    )
    assert done.stdout.startswith("5 cannot write"), done.stdout + done.stderr
    kept = partial_path(tmp_path / name)
    assert list(tmp_path.iterdir()) == [kept]
    count = probe(kept).frames
    assert count > 0 and f"first {count} frames are kept in {kept}" in done.stdout
    assert count % round(5 * find_format(name).codec.seconds) == 0


def test_a_disk_that_fills_while_the_film_is_joined_keeps_it_all(tmp_path, monkeypatch):
    from gen_art.output import join_segments

    def full(*args):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(join_segments, "join", full)
    with pytest.raises(OutputError, match=r"No space left.*first 10 frames are kept"):
        job.render(piece(), tmp_path / "a.mp4")
    assert [p.name for p in tmp_path.iterdir()] == ["a.partial.mp4"]


def test_two_renders_do_not_write_one_film(tmp_path):
    first = film_writer(tmp_path / "a.mp4", SIZE, 5)
    with pytest.raises(OutputError, match="another render"):
        film_writer(tmp_path / "a.mp4", SIZE, 5)
    first.abort()


def test_a_sequence_keeps_the_pictures_before_a_failure(tmp_path):
    def stop(event):
        if event["frame"] == 8:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        job.render(piece(), tmp_path / "a_##.png", progress=stop)
    kept = sorted(p.name for p in tmp_path.iterdir())
    assert kept and all(name.endswith(".png") and not name.startswith(".") for name in kept)
    assert kept[0] == "a_00.png"
