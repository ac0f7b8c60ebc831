"""Writes pictures to a film file; when it is stopped early, the finished part stays as the partial film.

The partial film (partial_film.py) plays up to its last whole segment. Closing the writer makes the final film from it and
deletes it.
"""

import os
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("SVT_LOG", "1")  # SVT-AV1 prints errors only; it reads this when it is loaded

import av
import numpy as np

from gen_art.errors import EncoderError, OutputError
from gen_art.files import beside
from gen_art.output.formats import Format, check_film_size, find_format
from gen_art.output.partial_film import PartialFilm, partial_path
from gen_art.output.recipe import encode
from gen_art.output.segments import Segments, as_fraction
from gen_art.output.yuv import film_frame

__all__ = ["FilmWriter", "Kept", "film_writer", "partial_path"]


@dataclass(frozen=True)
class Kept:
    """The partial film that stays when a film was not finished."""

    path: Path
    frames: int

    def __str__(self) -> str:
        return f"the first {self.frames} frames are kept in {self.path}"


class FilmWriter:
    """Writes a film: `add` each picture, then `close`, or `abort`.

    Raises EncoderError when the encoder fails, OutputError when the operating system refuses (disk full, no permission).
    """

    def __init__(
        self, path: Path, film: Format, size, fps: float, recipe: dict | None, max_rate: int = 0, overwrite: bool = True
    ):  # fmt: skip
        check_film_size(film, size)
        self.path, self._film, self._fps, self._recipe, self._overwrite = path, film, fps, recipe, overwrite
        self._text = encode(recipe) if recipe is not None else None
        self._whole = False
        limit = {"maxrate": str(max_rate), "bufsize": str(max_rate)} if max_rate else {}
        partial = partial_path(path)
        with _encoding(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            self._segments = Segments(partial.suffix.lower(), film, size, fps, self._text, limit)
            self._partial = PartialFilm(partial, overwrite)
            self._segments.start(self._partial.file)

    def add(self, picture: np.ndarray) -> None:
        """Add a picture: (height, width, 3), or 4 channels in a transparent film; uint8, or uint16 for more than 8 bits."""
        with _encoding(self.path):
            self._segments.add(film_frame(picture, self._film.pixels, self._film.bits))

    def close(self) -> None:
        """Write the final film and delete the partial one, which stays locked until then."""
        with _encoding(self.path):
            self._segments.finish()
            with beside(self.path, self._overwrite) as temporary:
                self._finish(temporary)
            self._whole = True
        self._drop()

    def _drop(self) -> None:
        with _encoding(self._partial.path):
            self._partial.remove()
        self._partial.close()

    def _finish(self, temporary: Path) -> None:
        name = self._film.codec.name
        if name == "gif":
            from gen_art.output.animation import write_gif

            write_gif(self._partial.file, temporary, self._fps, self._recipe)
        elif name == "webp":
            from gen_art.output.animation import write_webp

            write_webp(self._partial.file, temporary, self._fps, self._recipe, self._film.profile)
        else:
            from gen_art.output.join_segments import join

            join(self._partial.file, temporary, self._film.extension, self._text, as_fraction(self._fps))

    def abort(self) -> Kept | None:
        """Stop early. Returns the partial film, which stays and plays, or None when no segment was finished."""
        frames = self._segments.stop()
        if self._whole or not frames:
            self._drop()
            return None
        self._partial.close()
        return Kept(self._partial.path, frames)


class _encoding:
    """Turns errors of the encoder into this package's: OutputError for the operating system's, EncoderError for the rest."""

    def __init__(self, path: Path):
        self._path = path

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if isinstance(error, av.FFmpegError) and not (isinstance(error, OSError) and (error.errno or 0) > 0):
            raise EncoderError(f"the encoder failed on {self._path.name}: {error.strerror or error}") from error
        if isinstance(error, OSError) and not isinstance(error, OutputError):
            raise OutputError(f"cannot write {self._path}: {error.strerror or error}") from error
        return False


def film_writer(
    path: Path, size, fps: float, recipe: dict | None = None, film: Format | None = None, max_rate: int = 0,
    overwrite: bool = True,
) -> FilmWriter:  # fmt: skip
    """A writer for a film of `size` (width, height).

    film : its format; the default of the file extension when None
    max_rate : the most bits a second of H.264 and H.265; 0 for no limit beyond the profile
    overwrite : replace a film or partial film that exists
    """
    return FilmWriter(path, film or find_format(path), size, fps, recipe, max_rate, overwrite)
