"""Reads the recipe inside a picture (through Pillow or OpenEXR) or a film (through PyAV)."""

import json
from pathlib import Path

from gen_art.errors import OutputError, UsageError
from gen_art.output.exr import read_text
from gen_art.output.recipe import FORMAT, KEY
from gen_art.pictures import EXIF_DESCRIPTION, picture_metadata

__all__ = ["read_recipe"]


def read_recipe(path) -> dict:
    """The recipe inside a picture or film.

    Raises OutputError when the file does not exist, UsageError when it cannot be read as a picture or holds no recipe.
    """
    path = Path(path)
    if not path.is_file():
        raise OutputError(f"{path}: {'is a directory' if path.is_dir() else 'there is no such file'}")
    readers = {**dict.fromkeys((".mp4", ".mov", ".webm", ".mkv"), _film_text), ".exr": read_text}
    text = readers.get(path.suffix.lower(), _picture_text)(path)
    try:
        recipe = json.loads(text) if text else None
    except (ValueError, RecursionError):
        recipe = None
    if not isinstance(recipe, dict) or "preset" not in recipe or "format" not in recipe:
        raise UsageError(
            f"{path}: there is no recipe inside; it was not made by gen-art, or another program removed its metadata"
        )
    if recipe["format"] != FORMAT:
        raise UsageError(f"{path}: its recipe has format {recipe['format']!r}; this version reads format {FORMAT}")
    return recipe


def _picture_text(path: Path) -> str | None:
    metadata = picture_metadata(path)
    text = metadata.get(KEY) or metadata.get(EXIF_DESCRIPTION) or metadata.get("comment")
    if isinstance(text, bytes):
        return text.decode("ascii", "replace")
    return text if isinstance(text, str) else None


def _film_text(path: Path) -> str | None:
    import av

    from gen_art.output.containers import read_film

    try:
        with read_film(path) as film:
            return film.metadata.get("comment") or film.metadata.get("COMMENT")  # Matroska's tags are in capitals
    except (av.FFmpegError, OSError, ValueError) as error:
        raise UsageError(f"{path}: cannot be read as a film ({error})") from error
