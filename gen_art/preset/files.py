"""Files that a preset names. They are in the preset's folder or below, and a picture's recipe has their sha256."""

from contextvars import ContextVar
from pathlib import Path, PurePosixPath

from gen_art.errors import UsageError
from gen_art.pictures import LARGEST, picture_size
from gen_art.preset.fields import Parsed

__all__ = ["FOLDER", "ImageFile", "PresetFile", "inside"]

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
        raise UsageError(f"must be the name of a file, not {value!r}")
    parts = PurePosixPath(value.replace("\\", "/"))
    if parts.is_absolute() or ".." in parts.parts or ":" in value:
        raise UsageError(f"{value}: a preset's files must be in its own folder or below")
    folder = FOLDER.get()
    place = folder / parts
    if not place.resolve().is_relative_to(folder.resolve()):
        raise UsageError(f"{value}: leads out of the preset's folder")
    if not place.is_file():
        raise UsageError(f"{value}: there is no such file in {folder.resolve()}")
    return PresetFile(value, place)


def _image(value) -> PresetFile:
    file = inside(value)
    width, height = picture_size(file.place, file)
    if width * height > LARGEST:
        raise UsageError(f"{file}: a sprite has at most {LARGEST // 10**6} million pixels; 512x512 is enough")
    return file


ImageFile = Parsed(_image, _IMAGE)
