"""The partial film: its name, its lock, and what a stop at the worst moment leaves of it."""

import os
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

from gen_art.errors import OutputError
from gen_art.output import join_segments, segments
from gen_art.output.formats import CODECS, EXTENSIONS, find_format
from gen_art.output.probe import probe
from gen_art.output.video import film_writer, partial_path
from gen_art.output.yuv import film_frame
from tests.output.test_segments import SIZE, frames_of, pictures


def test_no_two_films_have_the_same_partial_film(tmp_path):
    names = [f"a{middle}{ending}" for middle in ("", *EXTENSIONS, ".partial") for ending in EXTENSIONS]
    assert len({partial_path(tmp_path / name) for name in names}) == len(names)
    assert partial_path(tmp_path / "a.mp4").name == "a.partial.mp4"


def test_a_gif_that_starts_takes_no_frames_from_a_webp_of_that_name(tmp_path):
    webp = film_writer(tmp_path / "a.webp", SIZE, 20)
    for picture in pictures(60):
        webp.add(picture)
    gif = film_writer(tmp_path / "a.gif", SIZE, 20)
    webp.close()
    for picture in pictures(29):
        gif.add(picture)
    gif.close()
    data = (tmp_path / "a.webp").read_bytes()
    assert data.count(b"ANMF") == 60, "one chunk a frame"
    assert probe(tmp_path / "a.gif").frames == 29
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.gif", "a.webp"]


@pytest.mark.parametrize("name", ["a.mp4", "a.mkv", "a.gif"])
def test_the_film_is_locked_until_it_is_whole(tmp_path, monkeypatch, name):
    refused = []

    def second(function):
        def try_first(*args):
            for overwrite in (False, True):
                with pytest.raises(OutputError, match="another render"):
                    film_writer(tmp_path / name, SIZE, 20, overwrite=overwrite)
                refused.append(overwrite)
            return function(*args)

        return try_first

    monkeypatch.setattr(join_segments, "join", second(join_segments.join))
    from gen_art.output import animation

    monkeypatch.setattr(animation, "write_gif", second(animation.write_gif))
    writer = film_writer(tmp_path / name, SIZE, 20)
    for picture in pictures(12):
        writer.add(picture)
    writer.close()
    assert refused == [False, True] and probe(tmp_path / name).frames == 12


def test_a_file_that_takes_the_partial_films_place_is_neither_read_nor_deleted(tmp_path):
    for name in ("a.mp4", "a.gif"):
        writer = film_writer(tmp_path / name, SIZE, 20)
        for picture in pictures(12):
            writer.add(picture)
        partial = partial_path(tmp_path / name)
        partial.unlink()
        partial.write_text("mine")
        writer.close()
        assert probe(tmp_path / name).frames == 12 and partial.read_text() == "mine"


def _other(kind: str, path, tmp_path):
    """Something at `path` that is no partial film of ours; a function that says whether it is untouched."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    if kind == "file":
        path.write_text("precious")
        return lambda: path.read_text() == "precious"
    if kind == "fifo":
        os.mkfifo(path)
        return lambda: path.is_fifo()
    path.symlink_to(victim if kind == "symlink" else tmp_path / "nowhere")
    return lambda: path.is_symlink()


@pytest.mark.parametrize("kind", ["file", "symlink", "dangling", "fifo"])
def test_what_lies_at_the_partial_films_name_is_kept_without_overwrite(tmp_path, kind):
    from gen_art.output import job
    from tests.output.piece import piece

    path = tmp_path / "a.mp4"
    untouched = _other(kind, partial_path(path), tmp_path)
    with pytest.raises(OutputError, match=r"a\.partial\.mp4 exists already.*--overwrite"):
        job.check_target(piece(), path)
    with pytest.raises(OutputError, match=r"a\.partial\.mp4 exists already.*--overwrite"):
        film_writer(path, SIZE, 20, overwrite=False)
    assert untouched() and not path.exists() and not (tmp_path / "nowhere").exists()
    writer = film_writer(path, SIZE, 20, overwrite=True)
    for picture in pictures(4):
        writer.add(picture)
    writer.close()
    assert probe(path).frames == 4 and not os.path.lexists(partial_path(path))
    assert (tmp_path / "victim").read_text() == "precious" and not (tmp_path / "nowhere").exists()


def test_a_film_that_appears_meanwhile_is_kept_without_overwrite(tmp_path):
    path = tmp_path / "a.mp4"
    writer = film_writer(path, SIZE, 20, overwrite=False)
    for picture in pictures(4):
        writer.add(picture)
    path.write_text("precious")
    with pytest.raises(OutputError, match="exists already"):
        writer.close()
    kept = writer.abort()
    assert path.read_text() == "precious" and probe(kept.path).frames == kept.frames == 4


def _hold_last_flush(monkeypatch, number: int):
    """Interrupt the main thread while segment `number` is flushed, which then goes on half a second later."""
    real, made = segments.encoder_stream, []

    class Held:
        def __init__(self, stream, held):
            self._stream, self._held = stream, held

        def __getattr__(self, name):
            return getattr(self._stream, name)

        def encode(self, frame):
            if frame is None and self._held:
                while not raised.is_set():  # Python misses a signal just before its main thread goes to sleep
                    signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
                    raised.wait(0.2)
                threading.Event().wait(0.5)
            return self._stream.encode(frame)

    def stream(*args):
        made.append(1)
        return Held(real(*args), len(made) == number + 1)  # the first is the trial of the encoder's options

    raised = threading.Event()

    def stop(*_):
        if not raised.is_set():
            raised.set()
            raise KeyboardInterrupt

    monkeypatch.setattr(segments, "encoder_stream", stream)
    return signal.signal(signal.SIGINT, stop)


@pytest.mark.parametrize("name, fps", [("a.mp4", 20), ("a.mkv", 20), ("a.webm", 20)])
def test_a_signal_while_the_last_segment_is_encoded_loses_no_frame(tmp_path, monkeypatch, name, fps):
    path = tmp_path / name
    before = _hold_last_flush(monkeypatch, 1)
    writer = film_writer(path, SIZE, fps)
    try:
        for picture in pictures(9):
            writer.add(picture)
        with pytest.raises(KeyboardInterrupt):
            writer.close()
        kept = writer.abort()
    finally:
        signal.signal(signal.SIGINT, before)
    assert kept is not None and kept.frames == 9
    assert probe(kept.path).frames == 9


@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.webm", "a.mkv", "a.gif", "av1.mp4", "h265.mov"])
def test_half_a_second_of_film_is_on_disk_before_many_more_frames_are_taken(tmp_path, name):
    codec = name.split(".")[0]
    path, film = tmp_path / name, find_format(name, codec=codec if codec in CODECS else None)
    size = (64, 48)
    writer = film_writer(path, size, 30, film=film)
    for picture in pictures(15 + segments.WAITING, size):  # the last waits until there is room
        writer.add(picture)
    assert len(frames_of(partial_path(path))) == 15
    writer.abort()


_WRITES = 4  # of a segment after the first: its length, a header that skips it, its body, its header


class _Recorder:
    """A file that notes what is written where."""

    def __init__(self, file):
        self._file, self.writes = file, []

    def write(self, data) -> int:
        self.writes.append((self._file.tell(), bytes(data)))
        return self._file.write(data)

    def truncate(self, size: int) -> int:
        self.writes.append((size, b""))
        return self._file.truncate(size)

    def __getattr__(self, name):
        return getattr(self._file, name)


@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.webm", "a.mkv", "h265.mp4"])
def test_a_render_that_is_killed_while_it_writes_leaves_the_segments_before(tmp_path, name):
    """Each write cut at several bytes: SIGKILL stops a write in its middle."""
    codec = name.split(".")[0]
    film, size = find_format(name, codec=codec if codec in CODECS else None), (32, 24)
    encoding = segments.Segments(tmp_path.joinpath(name).suffix, film, size, 20, None, {})
    with open(tmp_path / "whole", "w+b", buffering=0) as file:
        recorder = _Recorder(file)
        encoding.start(recorder)
        for picture in pictures(60, size):
            encoding.add(film_frame(picture, film.pixels, film.bits))
        assert encoding.stop() == 60
    cut, data, least = tmp_path / f"cut{Path(name).suffix}", bytearray(), 0
    rng = np.random.default_rng(2)
    (_, head), *writes = recorder.writes
    data += head
    for number, (start, written) in enumerate(writes):
        data += bytes(max(0, start - len(data)))
        ends = {0, 1, 8, 9, len(written) - 1, *rng.integers(0, len(written), 5)} if len(written) > 9 else {0}
        for end in sorted(ends) if least else ():
            cut.write_bytes(data[:start] + written[:end] + data[start + end :])
            assert len(frames_of(cut)) == least, (start, end)
        data[start : start + len(written)] = written
        if number % _WRITES == _WRITES - 1:  # the header is put right: one more segment plays
            cut.write_bytes(data)
            assert len(frames_of(cut)) > least
            least = len(frames_of(cut))
    assert least == 60
