"""Files that a preset names. They are in the preset's folder or below, and a picture's recipe has their sha256."""

from contextvars import ContextVar
from pathlib import Path

from gen_art.arguments import shown
from gen_art.errors import UsageError
from gen_art.files import LARGEST_INPUT, below
from gen_art.pictures import LARGEST, picture_size
from gen_art.preset.fields import Parsed

__all__ = ["FOLDER", "ImageFile", "PresetFile", "inside"]

LONGEST_NAME = 200
FOLDER: ContextVar[Path] = ContextVar("folder", default=Path())  # the folder of the preset that is being read
_IMAGE = {"type": "string", "description": "a picture in the preset's folder or below: spark.png"}


class PresetFile(str):
    """A file's name as written in the preset; `place` is its path."""

    place: Path

    def __new__(cls, written: str, place: Path):
        file = super().__new__(cls, written)
        file.place = place
        return file


def inside(value) -> PresetFile:
    """The file of that name in the preset's folder or below. Raises UsageError if it does not exist or is elsewhere."""
    if isinstance(value, PresetFile):
        return value
    if not isinstance(value, str) or not value:
        raise UsageError(f"must be the name of a file, not {shown(value)}")
    if len(value) > LONGEST_NAME or not value.isprintable():
        raise UsageError(
            f"a file's name has at most {LONGEST_NAME} characters, all of them printable, not {shown(value)}"
        )
    folder = FOLDER.get()
    place = below(folder, value)
    if not place.is_file():
        raise UsageError(f"{value}: there is no such file in {folder.resolve()}")
    if place.stat().st_size > LARGEST_INPUT:
        raise UsageError(f"{value}: has {place.stat().st_size:,} bytes; at most {LARGEST_INPUT:,} are read")
    return PresetFile(value, place)


def _image(value) -> PresetFile:
    file = inside(value)
    width, height = picture_size(file.place, file)
    if width * height > LARGEST:
        raise UsageError(f"{file}: a sprite has at most {LARGEST // 10**6} million pixels; 1024x1024 is enough")
    return file


ImageFile = Parsed(_image, _IMAGE)
