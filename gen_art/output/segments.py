"""The partial film: closed segments appended to one file, which plays up to its last whole segment when writing stops.

Each segment has its own encoder with a fixed number of threads, so its bytes do not depend on the segments before it. Two
segments are encoded at a time on other threads: one encoder is flushed while the next one receives frames.
"""

import contextlib
import io
import queue
from concurrent.futures import Future, ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from types import ModuleType

import av

from gen_art.errors import OutputError
from gen_art.output.formats import MUXERS, Format
from gen_art.output.fragments import split
from gen_art.output.yuv import tag

fcntl: ModuleType | None = None
with contextlib.suppress(ImportError):  # Windows has no fcntl: the file is then not locked
    import fcntl

__all__ = ["Segments", "as_fraction", "encoder_stream", "open_film"]

WAITING = 2  # frames that may wait for an encoder
ENCODERS = 2  # at a time
_MAX_DELAY = 16  # the most frames that an encoder holds back to reorder them
_FRAGMENTED = {  # fragmented MP4 that keeps the packets' timestamps
    "movflags": "frag_keyframe+empty_moov+default_base_moof+frag_discont+use_metadata_tags",
    "use_editlist": "0",
    "avoid_negative_ts": "disabled",
}


def as_fraction(fps: float) -> Fraction:
    """A frame rate as a fraction: 29.97 is 2997/100, 1/3 stays 1/3."""
    return Fraction(fps).limit_denominator(100_000)


def open_film(target, muxer: str, recipe: str | None, options: dict[str, str]):
    """A container to write to, with the recipe as its comment. Bit-exact: it stores no dates or library versions."""
    container = av.open(target, "w", format=muxer, options={"fflags": "+bitexact", **options})
    if recipe is not None:
        container.metadata["comment"] = recipe
    return container


def encoder_stream(container, film: Format, size, fps: float, options: dict[str, str]):
    """A new stream of the container with its own encoder."""
    stream = container.add_stream(film.codec.encoder, rate=as_fraction(fps))
    stream.width, stream.height, stream.pix_fmt = size[0], size[1], film.pixels
    chroma = {"chroma_sample_location": "left"} if film.halved else {}
    stream.options = {**chroma, **options}
    context = stream.codec_context
    context.thread_count, context.thread_type = film.codec.threads, "FRAME"
    if film.codec.tag:
        context.codec_tag = film.codec.tag
    tag(context, film.rgb)
    return stream


def open_locked(path: Path):
    """Open an empty file at `path` for writing and lock it. Raises OutputError while another process holds the lock."""
    file = open(path, "ab", buffering=0)  # noqa: SIM115  # the caller closes it
    if fcntl is not None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.close()
            raise OutputError(f"{path} is being written by another render") from None
    file.truncate(0)
    return file


class Segments:
    """Writes frames to the partial film at `path`, segment by segment.

    path : the partial film
    extension : its file type, .mp4 .mov .webm .mkv
    options : further encoder options
    length : frames of a segment
    frames : number of frames in the whole segments on disk
    """

    def __init__(
        self, path: Path, extension: str, film: Format, size, fps: float, recipe: str | None, options: dict[str, str]
    ):
        self.path, self.frames, self._film, self._size, self._fps = path, 0, film, size, fps
        self.length = max(1, round(fps * film.codec.seconds))
        self._muxer, self._recipe = MUXERS[extension], recipe
        self._options = {"g": str(self.length), **film.options(size), **options}
        self._delay, self._bytes, self._count = 0, 0, 0  # delay: frames between first decoding and first display
        self._failure: BaseException | None = None
        _, container, _ = self._new()
        container.start_encoding()  # options that the encoder refuses fail here, before anything is computed
        container.close()
        self._file = open_locked(path)
        self._pool = ThreadPoolExecutor(ENCODERS, thread_name_prefix="gen-art-encoder")
        self._frames: queue.Queue | None = None  # of the segment in progress; None ends it
        self._last: Future | None = None

    def add(self, frame: av.VideoFrame) -> None:
        """Encode the next frame; waits while the encoders are busy. Raises the error of an earlier frame."""
        if self._failure is not None:
            raise self._failure
        if self._count % self.length == 0:
            self._end_segment()
            self._frames = queue.Queue(WAITING)
            self._last = self._pool.submit(self._segment, self._count, self._frames, self._last)
        self._frames.put(frame)  # type: ignore[union-attr]  # a segment has begun
        self._count += 1

    def finish(self) -> None:
        """Write the remaining frames as a shorter segment. Raises the error of an earlier frame."""
        self.stop()
        if self._failure is not None:
            raise self._failure

    def stop(self) -> int:
        """End the partial film, also after an error, and return the number of frames in it."""
        self._end_segment()
        self._pool.shutdown()
        self._file.close()
        return self.frames

    def _end_segment(self) -> None:
        if self._frames is not None:
            self._frames.put(None)
            self._frames = None

    def _new(self):
        options = _FRAGMENTED if self._muxer in ("mp4", "mov") else {}
        buffer = io.BytesIO()
        container = open_film(buffer, self._muxer, self._recipe, options)
        return buffer, container, encoder_stream(container, self._film, self._size, self._fps, self._options)

    def _segment(self, first: int, frames: queue.Queue, previous: Future | None) -> None:
        """Encode one segment and write it after the previous ones. An error is kept for the caller's next `add`."""
        try:
            buffer, container, packets, received = self._encode(frames)
            if previous is not None:
                previous.result()
            if self.frames == first and len(packets) == received:
                self._write(buffer, container, packets, first)
                self.frames += received
        except BaseException as error:
            self._failure = self._failure or error

    def _encode(self, frames: queue.Queue):
        """(buffer, container, packets, number of frames): a frame that fails ends the segment before that frame."""
        packets: list[av.Packet] = []
        received, frame = 0, frames.get()
        try:
            buffer, container, stream = self._new()
            while frame is not None:
                frame.pts, frame.time_base = received, 1 / as_fraction(self._fps)
                packets += stream.encode(frame)
                received += 1
                frame = frames.get()
        except BaseException as error:
            self._failure = self._failure or error
            while (
                frame is not None
            ):  # empty the queue: the caller, who sees the error at its next frame, must not block
                frame = frames.get()
            if received == 0:
                raise
        packets += stream.encode(None)
        return buffer, container, packets, received

    def _write(self, buffer: io.BytesIO, container, packets: list, first: int) -> None:
        """Append a segment's packets to the file; if the disk is full, the part that was written is removed again."""
        if first == 0:  # where frames are reordered, decoding begins some frames before display
            needed = max(k - packet.pts for k, packet in enumerate(packets))
            # of a film shorter than its delay, x265 reports uninitialised memory
            reported = -packets[0].dts
            self._delay = reported if needed <= reported <= _MAX_DELAY else needed
        for k, packet in enumerate(packets):
            packet.pts += first + self._delay
            packet.dts = first + k
        container.mux(packets)
        container.close()
        head, body = split(buffer.getvalue(), self._muxer)
        data = memoryview(head + body if first == 0 else body)
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError:
            self._file.truncate(self._bytes)
            raise
        self._bytes = self._file.tell()
