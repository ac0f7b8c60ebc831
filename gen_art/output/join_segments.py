"""Makes the final film from the partial film: packets are copied, not encoded again."""

from fractions import Fraction
from pathlib import Path

import av

from gen_art.output.formats import MUXERS
from gen_art.output.segments import open_film

__all__ = ["join"]

_FINAL = {"movflags": "+faststart+use_metadata_tags"}


def join(partial: Path, path: Path, extension: str, recipe: str | None, fps: Fraction) -> None:
    """Copy the film at `partial` to `path`, starting at time 0; MP4 and MOV get their index in front."""
    muxer = MUXERS[extension]
    with av.open(str(partial)) as source:
        stream = source.streams.video[0]
        target = open_film(str(path), muxer, recipe, _FINAL if muxer in ("mp4", "mov") else {})
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
