"""The codecs and file extensions of films, and the choice of a format for an output file.

This module does not import the encoders, so a wrong option is refused before they are loaded.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import PurePath

from gen_art.errors import UsageError
from gen_art.registry import suggest

__all__ = ["CODECS", "EXTENSIONS", "PROFILES", "Codec", "Format", "find_format"]

PROFILES = ("preview", "web", "master")
_DEFAULTS = {".mp4": "h264", ".mov": "prores", ".webm": "vp9", ".mkv": "ffv1", ".gif": "gif", ".webp": "webp"}
EXTENSIONS = tuple(_DEFAULTS)
MUXERS = {".mp4": "mp4", ".mov": "mov", ".webm": "webm", ".mkv": "matroska"}
_FFMPEG_LIMIT = 2**28  # FFmpeg refuses a picture with (width + 128) (height + 128) at or above this
_HEVC_MOST = 142_606_336  # pixels of a picture at HEVC's highest level


def _x264(width: int, height: int) -> dict[str, str]:
    """Switch off the macroblock tree unless the width is a multiple of 128.

    x264's AVX-512 code for it reads past the end of rows that are not a multiple of eight macroblocks, and the film's
    bytes then differ from run to run.
    """
    return {} if width % 128 == 0 else {"mbtree": "0"}


def _x265(width: int, height: int) -> dict[str, str]:
    """Switch off the features of x265 that read or write memory they should not.

    The coding-unit tree (cutree) writes past the end of rows of fewer than four blocks of 16 pixels. Weighted prediction
    depends on uninitialised memory.
    """
    tree = "" if width > 48 else ":cutree=0"
    return {"x265-params": "log-level=none:open-gop=0:pools=4:frame-threads=2:info=0:weightp=0" + tree}


def _ffv1(width: int, height: int) -> dict[str, str]:
    """As many slices as keep each below 2^22 pixels, FFmpeg's limit."""
    return {"slices": str(next(n for n in (4, 16, 64, 256) if width * height <= 0.9 * n * 2**22))}


@dataclass(frozen=True)
class Codec:
    """One way to encode a film.

    encoder : FFmpeg's name of the encoder; for `gif` and `webp`, of the lossless film that they are made from
    second_encoder : of `gif` and `webp`, the encoder of the animation itself
    pixels : bits a channel -> pixel format; the first is the default
    alpha : the same for transparent films
    options : encoder options that every profile uses
    profiles : profile -> encoder options of that profile
    threads : threads of one encoder; fixed, whatever --threads is, because the film's bytes may depend on it
    options_for_size : (width, height) -> encoder options that depend on the size
    memory : bytes that the encoder holds for each pixel of a picture, measured
    seconds : length of one segment, s of film
    least : the least width and height (SVT-AV1 hangs below 28)
    widest, highest : the largest width and height
    most : the largest number of pixels
    """

    name: str
    title: str
    encoder: str
    extensions: tuple[str, ...]
    pixels: Mapping[int, str]
    profiles: Mapping[str, Mapping[str, str]]
    alpha: Mapping[int, str] = field(default_factory=dict)
    options: Mapping[str, str] = field(default_factory=dict)
    options_for_size: Callable[[int, int], Mapping[str, str]] = lambda width, height: {}
    tag: str = ""
    second_encoder: str = ""
    memory: int = 300
    threads: int = 4
    seconds: float = 2.0
    least: int = 1
    widest: int = 16384
    highest: int = 16384
    most: int = _FFMPEG_LIMIT


_LOSSLESS = {"level": "3", "g": "1", "slicecrc": "1", "context": "0"}
_NO_PROFILES: Mapping[str, Mapping[str, str]] = {profile: {} for profile in PROFILES}

CODECS: dict[str, Codec] = {
    codec.name: codec
    for codec in (
        Codec(
            "h264", "H.264", "libx264", (".mp4", ".mov"), {8: "yuv420p", 10: "yuv420p10le"},
            {"preview": {"preset": "veryfast", "crf": "23"}, "web": {"preset": "medium", "crf": "17"},
             "master": {"preset": "slow", "crf": "10"}}, options={"tune": "film"}, options_for_size=_x264, least=2, memory=270,
        ),
        Codec(
            "h265", "H.265", "libx265", (".mp4", ".mov"), {8: "yuv420p", 10: "yuv420p10le"},
            {"preview": {"preset": "ultrafast", "crf": "25"}, "web": {"preset": "fast", "crf": "19"},
             "master": {"preset": "slow", "crf": "12"}}, options_for_size=_x265, tag="hvc1", least=16,
            most=_HEVC_MOST, memory=350,
        ),
        Codec(
            "prores", "ProRes 4444", "prores_ks", (".mov",), {10: "yuv444p10le"},
            {"preview": {"profile": "4444", "bits_per_mb": "1000"}, "web": {"profile": "4444"},
             "master": {"profile": "4444xq"}}, alpha={10: "yuva444p10le"},
            options={"vendor": "apl0", "alpha_bits": "16"}, seconds=0.5, memory=95,
        ),
        Codec(
            "ffv1", "FFV1", "ffv1", (".mkv",), {8: "bgr0", 16: "gbrp16le"},
            {"preview": {"coder": "rice"}, "web": {"coder": "range_def"}, "master": {"coder": "range_def"}},
            alpha={8: "bgra", 16: "gbrap16le"}, options=_LOSSLESS, options_for_size=_ffv1, seconds=0.5, least=2, memory=105,
        ),
        Codec(
            "vp9", "VP9", "libvpx-vp9", (".webm", ".mkv"), {8: "yuv420p"},
            {"preview": {"crf": "34", "deadline": "realtime", "cpu-used": "7"},
             "web": {"crf": "22", "deadline": "good", "cpu-used": "4"},
             "master": {"crf": "10", "deadline": "good", "cpu-used": "2"}},
            alpha={8: "yuva420p"}, options={"b": "0", "row-mt": "1", "tile-columns": "1", "auto-alt-ref": "0"},
            least=2, memory=335,
        ),
        Codec(
            "av1", "AV1", "libsvtav1", (".mp4", ".webm", ".mkv"), {8: "yuv420p", 10: "yuv420p10le"},
            {"preview": {"preset": "11", "crf": "36"}, "web": {"preset": "8", "crf": "25"},
             "master": {"preset": "5", "crf": "14"}}, options={"svtav1-params": "lp=2"}, least=32,
            highest=8704, memory=660,
        ),
        Codec(
            "gif", "GIF", "ffv1", (".gif",), {8: "bgr0"}, _NO_PROFILES, options={**_LOSSLESS, "coder": "rice"},
            options_for_size=_ffv1, second_encoder="gif", seconds=0.5, least=2, memory=335,
        ),
        Codec(
            "webp", "WebP", "ffv1", (".webp",), {8: "bgr0"}, _NO_PROFILES, alpha={8: "bgra"},
            options={**_LOSSLESS, "coder": "rice"}, options_for_size=_ffv1, second_encoder="libwebp_anim", seconds=0.5, least=2,
            widest=16383, highest=16383, memory=105,
        ),
    )
}  # fmt: skip


@dataclass(frozen=True)
class Format:
    """The format of one film: a codec with its profile, bits a channel, file extension and transparency."""

    codec: Codec
    profile: str
    bits: int
    extension: str
    transparent: bool = False

    @property
    def pixels(self) -> str:
        """FFmpeg's name of the pixel format."""
        return (self.codec.alpha if self.transparent else self.codec.pixels)[self.bits]

    @property
    def halved(self) -> bool:
        """Whether chroma has half the width and height (4:2:0)."""
        return "420" in self.pixels

    @property
    def rgb(self) -> bool:
        """Whether the film stores RGB, not luma and chroma."""
        return "yuv" not in self.pixels

    def options(self, size) -> dict[str, str]:
        """The encoder's options for films of `size` (width, height)."""
        return {**self.codec.options, **self.codec.profiles[self.profile], **self.codec.options_for_size(*size)}

    @property
    def depth(self) -> int:
        """Bits a channel of the pictures that are given to the encoder: 8, or 16 for a film of more than 8."""
        return 8 if self.bits == 8 else 16


def find_format(
    out, *, codec: str | None = None, profile: str | None = None, bits: int | None = None, transparent: bool = False,
    size=None,
) -> Format:  # fmt: skip
    """The format of the film `out`: the default codec of its file extension, or `codec`.

    Raises UsageError, listing the choices, for an unknown codec, profile or extension, for choices that do not go together,
    and for a size the format cannot have.
    """
    name = PurePath(str(out)).name
    extension = PurePath(name).suffix.lower()
    if extension not in EXTENSIONS:
        raise UsageError(
            f"{name}: '{extension}' is not a film extension{suggest(extension, EXTENSIONS)}; "
            f"there are {' '.join(EXTENSIONS)}"
        )
    named = [k for k in CODECS if CODECS[k].extensions[0] not in (".gif", ".webp")]
    if codec is not None and codec not in named:
        raise UsageError(f"there is no codec '{codec}'{suggest(codec, named)}; there are {', '.join(named)}")
    chosen = CODECS[codec or _DEFAULTS[extension]]
    if extension not in chosen.extensions:
        fitting = [k for k in named if extension in CODECS[k].extensions]
        takes = f"{extension} takes {' or '.join(fitting)}" if fitting else f"{extension} takes no --codec"
        raise UsageError(f"{name}: {chosen.title} needs the extension {' or '.join(chosen.extensions)}; {takes}")
    profile = profile or "web"
    if profile not in PROFILES:
        raise UsageError(
            f"there is no profile '{profile}'{suggest(profile, PROFILES)}; there are {', '.join(PROFILES)}"
        )
    if transparent and not chosen.alpha:
        with_alpha = [f"{k} ({' '.join(c.extensions)})" for k, c in CODECS.items() if c.alpha]
        raise UsageError(f"{name}: {chosen.title} cannot be transparent; {', '.join(with_alpha)} can")
    depths = chosen.alpha if transparent else chosen.pixels
    if bits is not None and bits not in depths:
        raise UsageError(f"{name}: {chosen.title} has {' or '.join(map(str, depths))} bits a channel, not {bits}")
    film = Format(chosen, profile, bits or next(iter(depths)), extension, transparent)
    if size is not None:
        check_film_size(film, size)
    return film


def check_film_size(film: Format, size) -> None:
    """Raise UsageError for a size the format cannot have; with 4:2:0 chroma the message names the nearest even sizes."""
    width, height = size
    codec, asked = film.codec, f"not {width}x{height}"
    if min(size) < codec.least:
        raise UsageError(f"{codec.title} is at least {codec.least}x{codec.least} pixels, {asked}")
    if width > codec.widest or height > codec.highest:
        raise UsageError(f"{codec.title} is at most {codec.widest}x{codec.highest} pixels, {asked}")
    if width * height > codec.most:
        raise UsageError(f"{codec.title} has at most {codec.most} pixels, {asked} (which has {width * height})")
    if (width + 128) * (height + 128) >= _FFMPEG_LIMIT:
        most = (_FFMPEG_LIMIT - 1) // (width + 128) - 128
        raise UsageError(f"a film that is {width} pixels wide is at most {most - most % 2} high, {asked}")
    if film.halved and (width % 2 or height % 2):
        low, high = (width - width % 2, height - height % 2), (width + width % 2, height + height % 2)
        near = " and ".join(dict.fromkeys(f"{w}x{h}" for w, h in (low, high)))
        raise UsageError(
            f"{codec.title} in {film.pixels} needs an even width and height, {asked}; the nearest are {near}"
        )
