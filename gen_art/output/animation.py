"""GIF and animated WebP, made from the lossless partial film with one frame in memory at a time.

GIF takes two passes: the first chooses one palette of 256 colours for all frames (FFmpeg's palettegen, a median cut of the
whole film's histogram), the second maps each frame to that palette with error diffusion.
"""

import struct
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

import av
from av.filter import Graph

from gen_art.output.containers import open_film, read_film
from gen_art.output.formats import CODECS
from gen_art.output.recipe import encode
from gen_art.output.stills import exif

__all__ = ["write_gif", "write_webp"]

_WEBP = {"preview": ("70", "1"), "web": ("80", "4"), "master": ("95", "6")}  # quality, effort
_PARTIAL = ".mkv"  # the film that they are made from
_CENTISECONDS, _MILLISECONDS = 100, 1000


def _frames(film: BinaryIO, pixels: str) -> Iterator[av.VideoFrame]:
    with read_film(film, _PARTIAL) as source:
        for frame in source.decode(video=0):
            yield frame.reformat(format=pixels)


def _input(graph: Graph, frame: av.VideoFrame, name: str):
    return graph.add_buffer(
        width=frame.width, height=frame.height, format=frame.format, time_base=frame.time_base, name=name
    )


def _palette(film: BinaryIO) -> av.VideoFrame:
    """The palette of the whole film, as 16 x 16 pixels."""
    graph: Any = None
    source: Any = None
    for frame in _frames(film, "rgb32"):
        if source is None:
            graph = Graph()
            source = _input(graph, frame, "film")
            finder = graph.add("palettegen", "reserve_transparent=0:stats_mode=full")
            source.link_to(finder)
            finder.link_to(graph.add("buffersink"))
            graph.configure()
        source.push(frame)
    source.push(None)
    return graph.pull()


def _reduced(film: BinaryIO, palette: av.VideoFrame) -> Iterator[av.VideoFrame]:
    """The film's frames in the palette's colours."""
    graph: Any = None
    source: Any = None
    for frame in _frames(film, "rgb32"):
        if source is None:
            graph = Graph()
            source, colours = _input(graph, frame, "film"), _input(graph, palette, "palette")
            use = graph.add("paletteuse", "dither=sierra2_4a:diff_mode=rectangle")
            source.link_to(use, 0, 0)
            colours.link_to(use, 0, 1)
            use.link_to(graph.add("buffersink"))
            graph.configure()
            colours.push(palette)
            colours.push(None)
        source.push(frame)
        yield from _pulled(graph)
    source.push(None)
    yield from _pulled(graph)


def _pulled(graph: Graph) -> Iterator[av.VideoFrame]:
    while True:
        try:
            yield graph.pull()  # type: ignore[misc]  # the graph has no audio frames
        except (av.BlockingIOError, av.EOFError):
            return


def _encode(path: Path, muxer: str, codec: str, frames, pixels: str, fps: float, unit: int, options: dict) -> None:
    """Encode frames whose times are multiples of 1/unit s; each time is rounded by itself, so errors do not add up."""
    stream: Any = None
    durations: dict[int, int] = {}  # by presentation time, in units
    with open_film(path, muxer, None, {"loop": "0"}) as container:
        for k, frame in enumerate(frames):
            if stream is None:
                stream = container.add_stream(codec, rate=unit, options=options)
                stream.width, stream.height, stream.pix_fmt = frame.width, frame.height, pixels
                stream.codec_context.thread_count = 1
            frame.pts, frame.time_base = round(k * unit / fps), Fraction(1, unit)
            durations[frame.pts] = round((k + 1) * unit / fps) - frame.pts
            for packet in stream.encode(frame):
                packet.duration = durations[packet.pts]
                container.mux(packet)
        container.mux(stream.encode(None))


def write_gif(film: BinaryIO, path: Path, fps: float, recipe: dict | None) -> None:
    """Write the film as a GIF that repeats for ever, with the recipe as its comment."""
    _encode(path, "gif", CODECS["gif"].second_encoder, _reduced(film, _palette(film)), "pal8", fps, _CENTISECONDS, {})
    if recipe is not None:
        data = path.read_bytes()
        # the comment goes after the screen descriptor and the global colour table
        at = 13 + (3 << (data[10] & 7) + 1 if data[10] & 0x80 else 0)
        text = encode(recipe).encode("ascii")
        blocks = b"".join(bytes([len(part)]) + part for k in range(0, len(text), 255) if (part := text[k : k + 255]))
        path.write_bytes(data[:at] + b"\x21\xfe" + blocks + b"\0" + data[at:])


def write_webp(film: BinaryIO, path: Path, fps: float, recipe: dict | None, profile: str) -> None:
    """Write the film as an animated WebP that repeats for ever, with the recipe as its EXIF description."""
    quality, effort = _WEBP[profile]
    options = {"quality": quality, "compression_level": effort}
    pixels = "bgra"
    _encode(path, "webp", CODECS["webp"].second_encoder, _frames(film, pixels), pixels, fps, _MILLISECONDS, options)
    if recipe is not None:
        data = path.read_bytes()
        text = exif(encode(recipe)).tobytes()
        flags = data[20] | 0x08  # the extended header says that there is EXIF
        chunks = data[12:20] + bytes([flags]) + data[21:] + b"EXIF" + struct.pack("<I", len(text)) + text
        chunks += b"\0" * (len(text) % 2)
        path.write_bytes(b"RIFF" + struct.pack("<I", len(chunks) + 4) + b"WEBP" + chunks)
