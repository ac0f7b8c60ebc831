"""Which codecs of gen_art.output.formats the installed FFmpeg libraries can encode."""

from dataclasses import dataclass

from gen_art.output.formats import CODECS, Codec

__all__ = ["Encodable", "encodable", "library_version"]


@dataclass(frozen=True)
class Encodable:
    """A codec, and what the libraries lack for it: an encoder, or a pixel format of it; empty if its films can be made."""

    codec: Codec
    missing: str


def encodable() -> list[Encodable]:
    """All codecs. Raises ImportError where PyAV, which holds the libraries, cannot be loaded."""
    import av

    return [Encodable(codec, _missing(codec, av)) for codec in CODECS.values()]


def library_version() -> str:
    """The version of PyAV and of the FFmpeg library that encodes."""
    import av

    return f"PyAV {av.__version__}, libavcodec {'.'.join(map(str, av.library_versions['libavcodec']))}"


def _missing(codec: Codec, av) -> str:
    for name in filter(None, (codec.encoder, codec.second_encoder)):
        try:
            encoder = av.Codec(name, "w")
        except av.codec.codec.UnknownCodecError:
            return f"the encoder {name}"
        if name == codec.encoder:
            formats = {kind.name for kind in encoder.video_formats or ()}
            if lacking := sorted({*codec.pixels.values(), *codec.alpha.values()} - formats):
                return f"{', '.join(lacking)} of the encoder {name}"
    return ""
