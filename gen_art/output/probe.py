"""Reads the properties of a film file by decoding it."""

from dataclasses import dataclass
from pathlib import Path

import av

from gen_art.output.containers import read_film

__all__ = ["Probe", "probe"]


@dataclass(frozen=True)
class Probe:
    """Properties of a film.

    primaries, transfer, matrix : FFmpeg's numbers of the colour tags: 1 is BT.709; transfer 13 is sRGB, matrix 0 is RGB
    range : 1 is limited, 2 full
    duration : s
    keyframes : numbers of the frames that can be decoded without others
    """

    codec: str
    tag: str
    pixel_format: str
    size: tuple[int, int]
    fps: float
    frames: int
    duration: float
    primaries: int
    transfer: int
    matrix: int
    range: int
    keyframes: tuple[int, ...]


def probe(path) -> Probe:
    """Decode a film and return its properties."""
    with read_film(Path(path)) as container:
        stream = container.streams.video[0]
        context = stream.codec_context
        keys = [frame.key_frame for frame in container.decode(stream)]
        if stream.duration:
            duration = float(stream.duration * (stream.time_base or 0))
        else:
            duration = float((container.duration or 0) / av.time_base)
        return Probe(
            codec=context.codec.canonical_name,
            tag=context.codec_tag,
            pixel_format=context.pix_fmt or "",
            size=(context.width, context.height),
            fps=float(stream.average_rate or 0),
            frames=len(keys),
            duration=duration,
            primaries=int(context.color_primaries),
            transfer=int(context.color_trc),
            matrix=int(context.colorspace),
            range=int(context.color_range),
            keyframes=tuple(k for k, key in enumerate(keys) if key),
        )
