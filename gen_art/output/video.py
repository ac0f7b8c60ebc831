"""Films as files: a writer that takes pictures and leaves a whole film, or what was finished of one.

While it is written, a film grows as `NAME.partial.EXT` beside its final name and plays up to its last whole segment;
GIF and WebP, which need the whole film, grow as a lossless `NAME.partial.mkv`. In the end it becomes the film and goes.
"""

import os
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("SVT_LOG", "1")  # SVT-AV1 speaks only of errors; it reads this when it starts

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
    """Where the film at `path` grows."""
    ending = ".mkv" if path.suffix.lower() in (".gif", ".webp") else path.suffix
    return path.with_name(f"{path.stem}.partial{ending}")


@dataclass(frozen=True)
class Kept:
    """What is left of a film that was not finished."""

    path: Path
    frames: int

    def __str__(self) -> str:
        return f"the first {self.frames} frames are kept in {self.path}"


class FilmWriter:
    """A film: `add` pictures, then `close`; or `abort`.

    Raises EncoderError for what the encoder refuses, OutputError for what the system does.
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
        """The next picture: (height, width, 3, or 4 where the film is transparent), uint8, or uint16 for more bits."""
        with _encoding(self.path):
            self._segments.add(film_frame(picture, self._film.pixels, self._film.bits))

    def close(self) -> None:
        """Finish the film at its final name."""
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

            join(self.partial, temporary, self._film.ending, self._text, as_fraction(self._fps))

    def abort(self) -> Kept | None:
        """Stop here: what was finished stays, playable, and is named; None when that is nothing."""
        frames = self._segments.stop()
        if frames:
            return Kept(self.partial, frames)
        self.partial.unlink(missing_ok=True)
        return None


class _encoding:
    """The encoder's errors in this package's words: a system's refusal is an OutputError, the rest EncoderError."""

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
    """A writer for a film of `size` (width, height), what its ending means unless `film` says more.

    max_rate : bounds the bits a second of H.264 and H.265 (0: the profile alone decides)
    """
    return FilmWriter(path, film or find_format(path), size, fps, recipe, max_rate)
