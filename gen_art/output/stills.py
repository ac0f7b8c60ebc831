"""One picture as a file: PNG of 8 or 16 bits, JPEG, WebP, with its recipe as metadata."""

import struct
import zlib
from pathlib import Path

import numpy as np
from PIL import Image, PngImagePlugin

from gen_art.errors import UsageError
from gen_art.output.recipe import KEY, encode
from gen_art.output.target import beside

__all__ = ["EXIF_DESCRIPTION", "write_still"]

EXIF_DESCRIPTION = 0x010E
_EXIF_LIMIT = 65_000


def write_still(path, picture: np.ndarray, recipe: dict | None = None) -> Path:
    """Write (height, width, 3 or 4) uint8, or for PNG uint16, by the path's ending; the final name appears whole.

    JPEG has quality 95 without colour subsampling, WebP quality 96. Raises OutputError when the system refuses.
    """
    path = Path(path)
    text = encode(recipe) if recipe is not None else None
    with beside(path) as temporary:
        if path.suffix.lower() == ".png":
            if picture.dtype == np.uint16:
                temporary.write_bytes(_png16(picture, text))
            else:
                Image.fromarray(picture).save(temporary, "PNG", pnginfo=_png_info(text), compress_level=6)
        elif path.suffix.lower() in (".jpg", ".jpeg"):
            Image.fromarray(picture).save(temporary, "JPEG", quality=95, subsampling=0, exif=exif(text), optimize=True)
        else:
            Image.fromarray(picture).save(temporary, "WEBP", quality=96, method=6, exif=exif(text))
    return path


def exif(text: str | None) -> Image.Exif:
    """Metadata with the text as the picture's description. UsageError when it is longer than EXIF holds."""
    made = Image.Exif()
    if text is not None:
        if len(text) > _EXIF_LIMIT:
            raise UsageError(f"the recipe ({len(text)} bytes) does not fit in this format's metadata; write a .png")
        made[EXIF_DESCRIPTION] = text
    return made


def _png_info(text: str | None) -> PngImagePlugin.PngInfo:
    info = PngImagePlugin.PngInfo()
    info.add(b"sRGB", b"\0")
    if text is not None:
        info.add_itxt(KEY, text, zip=True)
    return info


def _png16(picture: np.ndarray, text: str | None) -> bytes:
    """A PNG of 16 bits a channel (Pillow writes 8). Rows are filtered by what is above them."""
    height, width, channels = picture.shape
    rows = np.ascontiguousarray(picture.astype(">u2")).view(np.uint8).reshape(height, -1)
    filtered = np.empty((height, rows.shape[1] + 1), np.uint8)
    filtered[:, 0] = 2
    filtered[0, 1:] = rows[0]
    filtered[1:, 1:] = rows[1:] - rows[:-1]

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    parts = [b"\x89PNG\r\n\x1a\n"]
    parts.append(chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 6 if channels == 4 else 2, 0, 0, 0)))
    parts.append(chunk(b"sRGB", b"\0"))
    if text is not None:
        parts.append(chunk(b"iTXt", KEY.encode() + b"\0\1\0\0\0" + zlib.compress(text.encode())))
    parts.append(chunk(b"IDAT", zlib.compress(filtered.tobytes(), 6)))
    parts.append(chunk(b"IEND", b""))
    return b"".join(parts)
