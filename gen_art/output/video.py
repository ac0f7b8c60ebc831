"""Writes pictures to a film file; when it is stopped early, the finished part stays as the partial film.

The partial film `NAME.partial.EXT` lies beside the final name and plays up to its last whole segment. GIF and WebP are
made from all frames at once, so their partial film is a lossless `NAME.partial.mkv`. Closing the writer makes the final
film from the partial film and deletes it.
"""

import os
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("SVT_LOG", "1")  # SVT-AV1 prints errors only; it reads this when it is loaded

import av
import numpy as np

from gen_art.errors import EncoderError, OutputError
from gen_art.output.formats import Format, check_film_size, find_format
from gen_art.output.recipe import encode
from gen_art.output.segments import Segments, as_fraction
from gen_art.output.target import beside
from gen_art.output.yuv import film_frame

__all__ = ["FilmWriter", "Kept", "film_writer", "partial_path"]


def partial_path(path: Path) -> Path:
    """The path of the partial film of the film at `path`."""
    extension = ".mkv" if path.suffix.lower() in (".gif", ".webp") else path.suffix
    return path.with_name(f"{path.stem}.partial{extension}")


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

    def __init__(self, path: Path, film: Format, size, fps: float, recipe: dict | None, max_rate: int = 0):
        check_film_size(film, size)
        self.path, self._film, self._fps, self._recipe = path, film, fps, recipe
        self._text = encode(recipe) if recipe is not None else None
        self.partial = partial_path(path)
        limit = {"maxrate": str(max_rate), "bufsize": str(max_rate)} if max_rate else {}
        with _encoding(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            self._segments = Segments(
                self.partial, self.partial.suffix.lower(), film, size, fps, self._text, limit
            )  # fmt: skip

    def add(self, picture: np.ndarray) -> None:
        """Add a picture: (height, width, 3), or 4 channels in a transparent film; uint8, or uint16 for more than 8 bits."""
        with _encoding(self.path):
            self._segments.add(film_frame(picture, self._film.pixels, self._film.bits))

    def close(self) -> None:
        """Write the final film and delete the partial one."""
        with _encoding(self.path):
            self._segments.finish()
            with beside(self.path) as temporary:
                self._finish(temporary)
            self.partial.unlink(missing_ok=True)

    def _finish(self, temporary: Path) -> None:
        name = self._film.codec.name
        if name == "gif":
            from gen_art.output.animation import write_gif

            write_gif(self.partial, temporary, self._fps, self._recipe)
        elif name == "webp":
            from gen_art.output.animation import write_webp

            write_webp(self.partial, temporary, self._fps, self._recipe, self._film.profile)
        else:
            from gen_art.output.join_segments import join

            join(self.partial, temporary, self._film.extension, self._text, as_fraction(self._fps))

    def abort(self) -> Kept | None:
        """Stop early. Returns the partial film, which stays and plays, or None when no segment was finished."""
        frames = self._segments.stop()
        if frames:
            return Kept(self.partial, frames)
        self.partial.unlink(missing_ok=True)
        return None


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
    path: Path, size, fps: float, recipe: dict | None = None, film: Format | None = None, max_rate: int = 0
) -> FilmWriter:
    """A writer for a film of `size` (width, height).

    film : its format; the default of the file extension when None
    max_rate : the most bits a second of H.264 and H.265; 0 for no limit beyond the profile
    """
    return FilmWriter(path, film or find_format(path), size, fps, recipe, max_rate)
