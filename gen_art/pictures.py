"""Picture files, read through Pillow: textures, maps, and the text inside a picture.

Only the formats named here are opened, and a file's format is told by its content: for others, Pillow may start another program.
Films are PyAV's (gen_art/output); OpenEXR pictures are read and written in gen_art/output/exr.py.
"""

import contextlib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gen_art.errors import GenArtError, UsageError
from gen_art.files import check_input

__all__ = ["picture_metadata", "picture_size", "read_picture"]

LARGEST = 64_000_000  # pixels of a picture that is read
EXIF_DESCRIPTION = 0x010E
_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF")
_NAMES = "PNG, JPEG, WebP and TIFF are read"


@contextlib.contextmanager
def _opened(path: str | Path, name: str, formats=_FORMATS) -> Iterator[Any]:
    """A picture whose header is read. Raises UsageError, with `name`, for what is no picture of these formats."""
    from PIL import Image, UnidentifiedImageError

    check_input(Path(path))
    most, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None  # `read_picture` has a limit of its own
    try:
        with warnings.catch_warnings(action="ignore"), Image.open(path, formats=formats) as image:
            yield image
    except (GenArtError, MemoryError):
        raise
    except UnidentifiedImageError:
        raise UsageError(f"{name}: cannot be read as a picture; {_NAMES}") from None
    except Exception as error:  # of a damaged file, Pillow's readers raise errors of many kinds
        raise UsageError(f"{name}: cannot be read as a picture ({error or type(error).__name__})") from error
    finally:
        Image.MAX_IMAGE_PIXELS = most


def picture_size(path: str | Path, name: str) -> tuple[int, int]:
    """(width, height) of a picture file, from its header. Raises UsageError, with `name`, for what is no picture."""
    with _opened(path, name) as image:
        return image.size


def read_picture(path: str | Path, name: str, mode: str | None = None, largest: int = LARGEST) -> np.ndarray:
    """A picture's values, uint8: (height, width), or (height, width, channels) with 2 to 4 channels, or in `mode`, as "RGB".

    16 bits a channel become 8. Raises UsageError, with `name`, for a file that is no picture or has more than `largest` pixels.
    """
    with _opened(path, name) as image:
        width, height = image.size
        if width * height > largest:
            raise UsageError(f"{name}: has {width * height:,} pixels; at most {largest:,} are read")
        if image.mode in ("I", "F"):
            raise UsageError(f"{name}: has 32 bits a channel; at most 16 are read")
        plain = _with_8_bits(image)
        return np.array(plain.convert(mode) if mode else plain)


def _with_8_bits(image: Any) -> Any:
    """The picture with the mode L, LA, RGB or RGBA."""
    from PIL import Image

    if image.mode.startswith("I;16"):
        return Image.fromarray((np.asarray(image) >> 8).astype(np.uint8))
    if image.mode == "P":
        return image.convert("RGBA" if "transparency" in image.info else image.palette.mode)
    if image.mode in ("L", "LA", "RGB", "RGBA"):
        return image
    return image.convert("L" if image.mode == "1" else "RGB")


def picture_metadata(path: str | Path) -> dict:
    """The metadata of a picture file: PNG texts by name, EXIF's description by its number, a GIF's "comment".

    Raises UsageError for no picture.
    """
    with _opened(path, str(path), (*_FORMATS, "GIF")) as image:
        return {**image.info, EXIF_DESCRIPTION: image.getexif().get(EXIF_DESCRIPTION)}
