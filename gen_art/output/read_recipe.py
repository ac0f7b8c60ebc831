"""Reads the recipe inside a picture or film, wherever its format keeps it."""

import json
from pathlib import Path

from gen_art.errors import OutputError, UsageError
from gen_art.output.exr import read_text
from gen_art.output.recipe import FORMAT, KEY
from gen_art.output.stills import EXIF_DESCRIPTION

__all__ = ["read_recipe"]


def read_recipe(path) -> dict:
    """The recipe inside a picture or film. OutputError when the file cannot be read, UsageError when it holds none."""
    path = Path(path)
    if not path.is_file():
        raise OutputError(f"{path}: {'is a directory' if path.is_dir() else 'there is no such file'}")
    read = {**dict.fromkeys((".mp4", ".mov", ".webm", ".mkv"), _film_text), ".exr": read_text}
    text = read.get(path.suffix.lower(), _picture_text)(path)
    try:
        recipe = json.loads(text) if text else None
    except ValueError:
        recipe = None
    if not isinstance(recipe, dict) or "preset" not in recipe or "format" not in recipe:
        raise UsageError(
            f"{path}: there is no recipe inside; it is not a picture of gen-art, or a program took its metadata away"
        )
    if recipe["format"] != FORMAT:
        raise UsageError(f"{path}: its recipe is of format {recipe['format']}; this gen-art reads format {FORMAT}")
    return recipe


def _picture_text(path: Path) -> str | None:
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            if picture.format == "PNG":
                return picture.text.get(KEY)  # type: ignore[attr-defined]
            if picture.format == "GIF":
                comment = picture.info.get("comment")
                return comment.decode("ascii", "replace") if comment else None
            return picture.getexif().get(EXIF_DESCRIPTION)
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise UsageError(f"{path}: cannot be read as a picture ({error})") from error


def _film_text(path: Path) -> str | None:
    import av

    try:
        with av.open(str(path)) as film:
            return film.metadata.get("comment") or film.metadata.get("COMMENT")  # Matroska's tags are capitals
    except (av.FFmpegError, OSError) as error:
        raise UsageError(f"{path}: cannot be read as a film ({error})") from error
