"""Makes the final film from the partial film: packets are copied, not encoded again."""

from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

from gen_art.output.containers import open_film, read_film
from gen_art.output.formats import MUXERS

__all__ = ["join"]

_FINAL = {"movflags": "+faststart+use_metadata_tags"}


def join(partial: BinaryIO, path: Path, extension: str, recipe: str | None, fps: Fraction) -> None:
    """Copy the film in the open file `partial` to `path`, starting at time 0; MP4 and MOV get their index in front."""
    muxer = MUXERS[extension]
    with read_film(partial, extension) as source:
        stream = source.streams.video[0]
        target = open_film(path, muxer, recipe, _FINAL if muxer in ("mp4", "mov") else {})
        try:
            copy = target.add_stream_from_template(stream, opaque=True)
            copy.time_base = stream.time_base
            copy.codec_context.framerate = fps
            if muxer in ("mp4", "mov"):
                copy.codec_context.codec_tag = stream.codec_context.codec_tag
            first = None
            for packet in source.demux(stream):
                if packet.pts is None or packet.dts is None:
                    continue
                first = packet.pts if first is None else first
                packet.pts -= first
                packet.dts -= first
                packet.stream = copy
                target.mux(packet)
        finally:
            target.close()
