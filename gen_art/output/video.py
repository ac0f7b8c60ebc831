"""Films as files: H.264 in MP4 by PyAV, GIF and animated WebP by Pillow; and a probe of what a file holds.

x264's bytes depend on its number of threads, so that is fixed here, whatever the kernels use.
"""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc, Interpolation
from PIL import Image

from gen_art.errors import EncoderError, OutputError
from gen_art.output.recipe import encode
from gen_art.output.stills import exif
from gen_art.output.target import check_even

__all__ = ["Probe", "film_writer", "probe"]

ENCODER_THREADS = 4
_H264 = {
    "draft": {"preset": "veryfast", "crf": "26"},
    "preview": {"preset": "faster", "crf": "22"},
    "final": {"preset": "medium", "crf": "17"},
}


def as_fraction(fps: float) -> Fraction:
    """A frame rate as a fraction: 29.97 is 2997/100, 1/3 stays 1/3."""
    return Fraction(fps).limit_denominator(100_000)


class Mp4Writer:
    """H.264 yuv420p, tagged bt709 in limited range, the index in front (`faststart`)."""

    def __init__(self, path: Path, size, fps: float, recipe: dict | None, quality: str = "final", max_rate: int = 0):
        check_even(size)
        self._path = path
        self._container = av.open(str(path), "w", format="mp4", options={"movflags": "+faststart+use_metadata_tags"})
        if recipe is not None:
            self._container.metadata["comment"] = encode(recipe)
        stream = self._container.add_stream("libx264", rate=as_fraction(fps))
        stream.width, stream.height, stream.pix_fmt = size[0], size[1], "yuv420p"
        limit = {"maxrate": str(max_rate), "bufsize": str(max_rate)} if max_rate else {}
        stream.options = {**_H264[quality], **limit, "tune": "film", "profile": "high"}
        context = stream.codec_context
        context.thread_count, context.thread_type = ENCODER_THREADS, "FRAME"
        context.color_range, context.colorspace = ColorRange.MPEG, Colorspace.ITU709
        context.color_primaries, context.color_trc = ColorPrimaries.BT709, ColorTrc.BT709
        self._stream, self._count = stream, 0

    def add(self, picture: np.ndarray) -> None:
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture[..., :3]), format="rgb24").reformat(
            format="yuv420p",
            dst_colorspace=Colorspace.ITU709,
            src_color_range=ColorRange.JPEG,
            dst_color_range=ColorRange.MPEG,
            dst_color_trc=ColorTrc.BT709,
            dst_color_primaries=ColorPrimaries.BT709,
            interpolation=Interpolation.BICUBIC | Interpolation.ACCURATE_RND | Interpolation.FULL_CHR_H_INT,
            threads=1,
        )
        frame.pts = self._count
        frame.time_base = 1 / self._stream.codec_context.framerate
        self._container.mux(self._stream.encode(frame))
        self._count += 1

    def close(self) -> None:
        self._container.mux(self._stream.encode(None))
        self._container.close()

    def abort(self) -> None:
        self._container.close()


class PillowWriter:
    """Frames are kept and written together: GIF with one palette for the film, or animated WebP."""

    def __init__(self, path: Path, size, fps: float, recipe: dict | None, quality: str = "final", max_rate: int = 0):
        self._path, self._fps, self._quality = path, fps, quality
        self._text = encode(recipe) if recipe is not None else None
        self._frames: list[Image.Image] = []

    def add(self, picture: np.ndarray) -> None:
        self._frames.append(Image.fromarray(picture))

    def _durations(self, unit: int) -> list[int]:
        """Milliseconds each frame is shown, in whole `unit`s, without drift."""
        edges = [round(k * 1000 / self._fps / unit) * unit for k in range(len(self._frames) + 1)]
        return [max(b - a, unit) for a, b in zip(edges, edges[1:])]

    def close(self) -> None:
        if self._path.suffix.lower() == ".gif":
            self._gif()
        else:
            first, *rest = self._frames
            first.save(
                self._path, "WEBP", save_all=True, append_images=rest, duration=self._durations(1), loop=0,
                quality=80, method=4 if self._quality == "final" else 2, exif=exif(self._text),
            )  # fmt: skip

    def _gif(self) -> None:
        palette = self._palette()
        frames = [f.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG) for f in self._frames]
        comment = {"comment": self._text.encode("ascii")} if self._text else {}
        frames[0].save(
            self._path, "GIF", save_all=True, append_images=frames[1:], duration=self._durations(10), loop=0, **comment
        )  # fmt: skip

    def _palette(self) -> Image.Image:
        """256 colours from a mosaic of up to 16 frames."""
        chosen = self._frames[:: max(1, len(self._frames) // 16)][:16]
        width = min(320, chosen[0].width)
        height = max(1, round(chosen[0].height * width / chosen[0].width))
        mosaic = Image.new("RGB", (width, height * len(chosen)))
        for k, frame in enumerate(chosen):
            mosaic.paste(frame.convert("RGB").resize((width, height), Image.Resampling.NEAREST), (0, k * height))
        return mosaic.quantize(256, method=Image.Quantize.MEDIANCUT)

    def abort(self) -> None:
        self._frames.clear()


class FilmWriter:
    """A film at a temporary path: `add` pictures, then `close`; EncoderError for what the encoder refuses."""

    def __init__(self, path: Path, size, fps: float, recipe: dict | None, quality: str = "final", max_rate: int = 0):
        kind = Mp4Writer if path.suffix.lower() == ".mp4" else PillowWriter
        with _encoding(path):
            self._writer = kind(path, size, fps, recipe, quality, max_rate)
        self._path = path

    def add(self, picture: np.ndarray) -> None:
        with _encoding(self._path):
            self._writer.add(picture)

    def close(self) -> None:
        with _encoding(self._path):
            self._writer.close()

    def abort(self) -> None:
        with _encoding(self._path):
            self._writer.abort()


class _encoding:
    """The encoder's errors in this package's words: a system's refusal is an OutputError, the rest EncoderError."""

    def __init__(self, path: Path):
        self._path = path

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if isinstance(error, av.FFmpegError):
            if isinstance(error, OSError) and error.errno and error.errno > 0:
                raise OutputError(f"cannot write {self._path.name}: {error.strerror}") from error
            raise EncoderError(f"the encoder failed on {self._path.name}: {error}; nothing was kept") from error
        return False


def film_writer(
    path: Path, size, fps: float, recipe: dict | None = None, quality: str = "final", max_rate: int = 0
) -> FilmWriter:
    """A writer for .mp4, .gif or .webp. `max_rate` bounds an MP4's bits a second (0: the quality alone decides)."""
    return FilmWriter(path, size, fps, recipe, quality, max_rate)


@dataclass(frozen=True)
class Probe:
    """What a film holds. Colour tags are FFmpeg's numbers: 1 is bt709; range 1 is limited."""

    codec: str
    pixel_format: str
    size: tuple[int, int]
    fps: float
    frames: int
    duration: float
    primaries: int
    transfer: int
    matrix: int
    range: int


def probe(path) -> Probe:
    """Decode a film and say what it holds."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        context = stream.codec_context
        frames = sum(1 for _ in container.decode(stream))
        return Probe(
            codec=context.codec.canonical_name,
            pixel_format=context.pix_fmt or "",
            size=(context.width, context.height),
            fps=float(stream.average_rate or 0),
            frames=frames,
            duration=float(stream.duration * (stream.time_base or 0)) if stream.duration else 0.0,
            primaries=int(context.color_primaries),
            transfer=int(context.color_trc),
            matrix=int(context.colorspace),
            range=int(context.color_range),
        )
