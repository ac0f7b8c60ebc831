"""A film as closed segments appended to one file, which plays up to its last whole segment when writing stops.

Each segment has its own encoder with a fixed number of threads, so its bytes do not depend on the segments before it. Two
segments are encoded at a time on other threads: one encoder is flushed while the next one receives frames.
"""

import io
import queue
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from fractions import Fraction
from typing import BinaryIO

import av

from gen_art.output.containers import open_film
from gen_art.output.formats import MUXERS, Format
from gen_art.output.fragments import skipping_header, split
from gen_art.output.thread_priority import kept_priority
from gen_art.output.yuv import tag

__all__ = ["Segments", "as_fraction", "encoder_stream"]

WAITING = 2  # frames that may wait for an encoder
_FIRST_SECONDS = 0.5  # of film: a film that is stopped early plays up to here
_LEAST = 4  # frames of the first segment: more than an encoder reorders, so that it reports its delay
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


class Segments:
    """Writes frames to the partial film, segment by segment.

    extension : its file type, .mp4 .mov .webm .mkv
    options : further encoder options
    length : frames of a segment; the first of this length is written as two, the shorter one first
    frames : number of frames in the whole segments on disk

    `add` and `stop` may be interrupted by a signal's exception at any point: they only pass frames on to a thread, which no
    signal interrupts, and wait for it. `stop` can be called again.
    """

    def __init__(self, extension: str, film: Format, size, fps: float, recipe: str | None, options: dict[str, str]):
        self.frames, self._film, self._size, self._fps = 0, film, size, fps
        self.length = max(1, round(fps * film.codec.seconds))
        self._first_end = min(self.length, max(_LEAST, round(fps * _FIRST_SECONDS)))
        self._muxer, self._recipe = MUXERS[extension], recipe
        self._options = {"g": str(self.length), **film.options(size), **options}
        self._delay, self._bytes = 0, 0  # delay: frames between first decoding and first display
        self._failure: BaseException | None = None
        _, container, _ = self._new()
        container.start_encoding()  # options that the encoder refuses fail here, before anything is computed
        container.close()
        self._waiting: queue.SimpleQueue = queue.SimpleQueue()  # frames; None ends the film
        self._room = threading.Semaphore(WAITING)
        self._stopped = threading.Event()

    def start(self, file: BinaryIO) -> None:
        """Begin to write to an empty file."""
        self._file = file
        threading.Thread(target=self._run, name="gen-art-film").start()

    def add(self, frame: av.VideoFrame) -> None:
        """Encode the next frame; waits while the encoders are busy. Raises the error of an earlier frame."""
        if self._failure is not None:
            raise self._failure
        self._room.acquire()
        self._waiting.put(frame)

    def finish(self) -> None:
        """Write the remaining frames as a shorter segment. Raises the error of an earlier frame."""
        self.stop()
        if self._failure is not None:
            raise self._failure

    def stop(self) -> int:
        """End the partial film, also after an error, and return the number of frames in it."""
        self._waiting.put(None)
        self._stopped.wait()
        return self.frames

    def _run(self) -> None:
        """Pass the frames on to the encoders until the film ends."""
        try:
            with ThreadPoolExecutor(ENCODERS, thread_name_prefix="gen-art-encoder") as pool:
                self._distribute(pool)
        except BaseException as error:
            self._failure = self._failure or error
            while self._next() is not None:  # the caller, who sees the error at its next frame, must not block
                self._room.release()
        finally:
            self._stopped.set()

    def _distribute(self, pool: ThreadPoolExecutor) -> None:
        frames: queue.Queue | None = None  # of the segment in progress; None ends it
        last: Future | None = None
        count = 0
        try:
            while (frame := self._next()) is not None:
                if frames is None:
                    frames = queue.Queue(1)
                    last = pool.submit(self._segment, count, frames, last)
                frames.put(frame)
                count += 1
                if count == self._first_end or count % self.length == 0:
                    frames.put(None)
                    frames = None
                if last is not None and count == self._first_end:
                    last.result()  # the film can be played from here on, before many more frames are computed
                self._room.release()
        finally:
            if frames is not None:
                frames.put(None)

    def _next(self) -> av.VideoFrame | None:
        """The next frame; None at the end, and where the program ends without `stop`."""
        while True:
            try:
                return self._waiting.get(timeout=1.0)
            except queue.Empty:
                if not threading.main_thread().is_alive():
                    return None

    def _new(self):
        options = _FRAGMENTED if self._muxer in ("mp4", "mov") else {}
        buffer = io.BytesIO()
        container = open_film(buffer, self._muxer, self._recipe, options)
        stream = encoder_stream(container, self._film, self._size, self._fps, self._options)
        with kept_priority():
            stream.codec_context.open(strict=False)
        return buffer, container, stream

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
        try:
            self._append(head if first == 0 else b"", body)
        except OSError:
            self._file.truncate(self._bytes)
            raise
        self._bytes = self._file.tell()

    def _append(self, head: bytes, body: bytes) -> None:
        """Append bytes so that readers skip the body until all of it is there: the process may be killed at any time."""
        header = skipping_header(len(body), self._muxer)
        self._write_all(head)
        start = self._file.tell()
        self._file.truncate(start + len(body))  # a reader looks for more in what it can only skip a part of
        self._write_all(header)
        self._write_all(body[len(header) :])
        end = self._file.tell()
        self._file.seek(start)
        self._write_all(body[: len(header)])
        self._file.seek(end)

    def _write_all(self, data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[self._file.write(rest) :]
