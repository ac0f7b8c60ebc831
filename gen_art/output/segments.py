"""A film as closed segments in one growing file, which plays up to the last whole segment whenever writing stops.

Each segment has an encoder of its own, with a fixed number of threads, so its bytes depend on nothing before it. Two
segments are encoded at a time, behind the caller: one encoder runs dry while the next one fills.
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
with contextlib.suppress(ImportError):  # where there is none, nobody is asked
    import fcntl

__all__ = ["Segments", "as_fraction", "encoder_stream", "open_film"]

WAITING = 2  # frames that may wait for an encoder
ENCODERS = 2  # at a time
_DEEPEST = 16  # frames that any encoder here holds back to reorder them
_GROWING = {  # a segment's times stay as they are
    "movflags": "frag_keyframe+empty_moov+default_base_moof+frag_discont+use_metadata_tags",
    "use_editlist": "0",
    "avoid_negative_ts": "disabled",
}


def as_fraction(fps: float) -> Fraction:
    """A frame rate as a fraction: 29.97 is 2997/100, 1/3 stays 1/3."""
    return Fraction(fps).limit_denominator(100_000)


def open_film(target, muxer: str, recipe: str | None, options: dict[str, str]):
    """A container to write to, the same bytes each time, with the recipe as its comment."""
    container = av.open(target, "w", format=muxer, options={"fflags": "+bitexact", **options})
    if recipe is not None:
        container.metadata["comment"] = recipe
    return container


def encoder_stream(container, film: Format, size, fps: float, options: dict[str, str]):
    """A stream with a fresh encoder in the container."""
    stream = container.add_stream(film.codec.encoder, rate=as_fraction(fps))
    stream.width, stream.height, stream.pix_fmt = size[0], size[1], film.pixels
    sited = {"chroma_sample_location": "left"} if film.halved else {}
    stream.options = {**sited, **options}
    context = stream.codec_context
    context.thread_count, context.thread_type = film.codec.threads, "FRAME"
    if film.codec.tag:
        context.codec_tag = film.codec.tag
    tag(context, film.rgb)
    return stream


def _alone(path: Path):
    """The file at `path`, empty, to write to. OutputError while another process writes it."""
    file = open(path, "ab", buffering=0)  # noqa: SIM115  # it stays open
    if fcntl is not None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.close()
            raise OutputError(f"{path} is being written by another render") from None
    file.truncate(0)
    return file


class Segments:
    """Frames in, a growing film at `path` out.

    path : the file that grows      ending : what kind of file it is, .mp4 .mov .webm .mkv      options : of the encoder
    length : frames of a segment      frames : how many lie in whole segments on disk
    """

    def __init__(
        self, path: Path, ending: str, film: Format, size, fps: float, recipe: str | None, options: dict[str, str]
    ):
        self.path, self.frames, self._film, self._size, self._fps = path, 0, film, size, fps
        self.length = max(1, round(fps * film.codec.seconds))
        self._muxer, self._recipe = MUXERS[ending], recipe
        self._options = {"g": str(self.length), **film.options(size), **options}
        self._lead, self._bytes, self._count = 0, 0, 0
        self._failure: BaseException | None = None
        _, container, _ = self._new()
        container.start_encoding()  # what the encoder refuses, it refuses before anything is computed
        container.close()
        self._file = _alone(path)
        self._pool = ThreadPoolExecutor(ENCODERS, thread_name_prefix="gen-art-encoder")
        self._inbox: queue.Queue | None = None
        self._last: Future | None = None

    def add(self, frame: av.VideoFrame) -> None:
        """The next frame; waits while the encoders are behind. Raises what went wrong with frames before."""
        if self._failure is not None:
            raise self._failure
        if self._count % self.length == 0:
            self._end_segment()
            self._inbox = queue.Queue(WAITING)
            self._last = self._pool.submit(self._segment, self._count, self._inbox, self._last)
        self._inbox.put(frame)  # type: ignore[union-attr]  # a segment has begun
        self._count += 1

    def finish(self) -> None:
        """Write what is left, as a shorter segment. Raises what went wrong."""
        self.stop()
        if self._failure is not None:
            raise self._failure

    def stop(self) -> int:
        """End here, whatever happened: how many frames the file holds, which plays."""
        self._end_segment()
        self._pool.shutdown()
        self._file.close()
        return self.frames

    def _end_segment(self) -> None:
        if self._inbox is not None:
            self._inbox.put(None)
            self._inbox = None

    def _new(self):
        options = _GROWING if self._muxer in ("mp4", "mov") else {}
        buffer = io.BytesIO()
        container = open_film(buffer, self._muxer, self._recipe, options)
        return buffer, container, encoder_stream(container, self._film, self._size, self._fps, self._options)

    def _segment(self, first: int, inbox: queue.Queue, before: Future | None) -> None:
        """Encode one segment and write it when all before it is written. What goes wrong is kept for the caller."""
        try:
            buffer, container, packets, received = self._encode(inbox)
            if before is not None:
                before.result()
            if self.frames == first and len(packets) == received:
                self._write(buffer, container, packets, first)
                self.frames += received
        except BaseException as error:
            self._failure = self._failure or error

    def _encode(self, inbox: queue.Queue):
        """(bytes to be, container, packets, frames received): a frame that fails ends the segment with what came before it."""
        packets: list[av.Packet] = []
        received, frame = 0, inbox.get()
        try:
            buffer, container, stream = self._new()
            while frame is not None:
                frame.pts, frame.time_base = received, 1 / as_fraction(self._fps)
                packets += stream.encode(frame)
                received += 1
                frame = inbox.get()
        except BaseException as error:
            self._failure = self._failure or error
            while frame is not None:  # the caller learns of it with its next frame; until then nobody may wait
                frame = inbox.get()
            if received == 0:
                raise
        packets += stream.encode(None)
        return buffer, container, packets, received

    def _write(self, buffer: io.BytesIO, container, packets: list, first: int) -> None:
        """Append a segment's packets to the file; a part that does not fit is taken off again."""
        if first == 0:  # decoding begins before what is shown where frames are reordered
            needed = max(k - packet.pts for k, packet in enumerate(packets))
            told = -packets[0].dts  # by less frames than it holds back, x265 says what lay in memory
            self._lead = told if needed <= told <= _DEEPEST else needed
        for k, packet in enumerate(packets):
            packet.pts += first + self._lead
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
