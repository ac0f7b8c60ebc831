"""Writes one picture with its recipe inside: 8-bit PNG, JPEG and WebP through imageio, 16-bit PNG by this module."""

import struct
import zlib
from pathlib import Path

import numpy as np
from PIL import Image, PngImagePlugin

from gen_art.errors import UsageError
from gen_art.files import beside
from gen_art.output.recipe import KEY, encode

__all__ = ["EXIF_DESCRIPTION", "write_still"]

EXIF_DESCRIPTION = 0x010E
_EXIF_LIMIT = 65_000
_FILTER_UP = 2  # PNG's filter that stores the difference from the row above
_RGB, _RGBA = 2, 6  # PNG's colour types


def write_still(path, picture: np.ndarray, recipe: dict | None = None, overwrite: bool = True) -> Path:
    """Write (height, width, 3 or 4) uint8, or uint16 for PNG, in the format of the path's extension.

    The file appears under its final name only when it is complete. JPEG has quality 95 without chroma subsampling, WebP
    quality 96. Raises OutputError when the operating system refuses, and for a file that exists by then (unless overwrite).
    """
    from imageio.v3 import imwrite

    path = Path(path)
    extension, text = path.suffix.lower(), encode(recipe) if recipe is not None else None
    options: dict
    if extension == ".png":
        # level 4 takes half the time of level 6, and a thirtieth more bytes
        options = {"pnginfo": _png_info(text), "compress_level": 4}
    elif extension in (".jpg", ".jpeg"):
        options = {"quality": 95, "subsampling": 0, "exif": exif(text), "optimize": True}
    else:
        options = {"quality": 96, "method": 6, "exif": exif(text)}
    with beside(path, overwrite) as temporary:
        if picture.dtype == np.uint16:
            temporary.write_bytes(_png16(picture, text))
        else:
            imwrite(temporary, picture, plugin="pillow", extension=extension, **options)
    return path


def exif(text: str | None) -> Image.Exif:
    """EXIF metadata with the text as the picture's description. Raises UsageError for a text longer than EXIF holds."""
    metadata = Image.Exif()
    if text is not None:
        if len(text) > _EXIF_LIMIT:
            raise UsageError(f"the recipe ({len(text)} bytes) does not fit in this format's metadata; write a .png")
        metadata[EXIF_DESCRIPTION] = text
    return metadata


def _png_info(text: str | None) -> PngImagePlugin.PngInfo:
    info = PngImagePlugin.PngInfo()
    info.add(b"sRGB", b"\0")
    if text is not None:
        info.add_itxt(KEY, text, zip=True)
    return info


def _png16(picture: np.ndarray, text: str | None) -> bytes:
    """A PNG of 16 bits a channel, which imageio and Pillow cannot write in colour. Every row has the filter "up"."""
    height, width, channels = picture.shape
    rows = np.ascontiguousarray(picture.astype(">u2")).view(np.uint8).reshape(height, -1)
    filtered = np.empty((height, rows.shape[1] + 1), np.uint8)
    filtered[:, 0] = _FILTER_UP
    filtered[0, 1:] = rows[0]
    filtered[1:, 1:] = rows[1:] - rows[:-1]

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    parts = [b"\x89PNG\r\n\x1a\n"]
    colour_type = _RGBA if channels == 4 else _RGB
    parts.append(chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, colour_type, 0, 0, 0)))
    parts.append(chunk(b"sRGB", b"\0"))
    if text is not None:
        parts.append(chunk(b"iTXt", KEY.encode() + b"\0\1\0\0\0" + zlib.compress(text.encode())))
    parts.append(chunk(b"IDAT", zlib.compress(filtered.tobytes(), 6)))
    parts.append(chunk(b"IEND", b""))
    return b"".join(parts)
