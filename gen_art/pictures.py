"""Picture files, read through imageio: textures, maps, and the text inside a picture.

Films are PyAV's (gen_art/output); OpenEXR pictures are read and written in gen_art/output/exr.py.
"""

from pathlib import Path
from typing import Any

import numpy as np

from gen_art.errors import UsageError

__all__ = ["picture_metadata", "picture_size", "read_picture"]

LARGEST = 64_000_000  # pixels of a picture that is read
EXIF_DESCRIPTION = "ImageDescription"


def _imageio() -> Any:
    import imageio.v3  # takes 0.05 s, so only where a picture is read

    return imageio.v3


def _refusals() -> tuple[type[BaseException], ...]:
    from PIL import Image, UnidentifiedImageError

    return UnidentifiedImageError, Image.DecompressionBombError, OSError, SyntaxError, ValueError


def picture_size(path: str | Path, name: str) -> tuple[int, int]:
    """(width, height) of a picture file, from its header. Raises UsageError, with `name`, for what is no picture."""
    from PIL import Image

    try:
        shape = _imageio().improps(path, plugin="pillow").shape
    except _refusals() as error:
        if any(isinstance(e, Image.DecompressionBombError) for e in (error, error.__cause__, error.__context__)):
            return 100_000, 100_000  # the header names more pixels than Pillow opens
        raise UsageError(f"{name}: cannot be read as a picture") from error
    if len(shape) > 3:  # an animated one
        shape = shape[1:]
    return int(shape[1]), int(shape[0])


def read_picture(path: str | Path, name: str, mode: str | None = None, largest: int = LARGEST) -> np.ndarray:
    """A picture's values: (height, width) or (height, width, channels) uint8, or in `mode`, as "RGB" or "RGBA".

    Raises UsageError, with `name`, for a file that is no picture or has more than `largest` pixels.
    """
    width, height = picture_size(path, name)
    if width * height > largest:
        raise UsageError(f"{name}: has {width * height:,} pixels; at most {largest:,} are read")
    try:
        return _imageio().imread(path, plugin="pillow", index=0, **({"mode": mode} if mode else {}))
    except _refusals() as error:
        raise UsageError(f"{name}: cannot be read as a picture ({error})") from error


def picture_metadata(path: str | Path) -> dict:
    """The metadata of a picture file: PNG texts and EXIF tags by name, a GIF's "comment". Raises UsageError for no picture."""
    try:
        return dict(_imageio().immeta(path, plugin="pillow", index=0, exclude_applied=False))
    except _refusals() as error:
        raise UsageError(f"{path}: cannot be read as a picture ({error})") from error
