"""OpenEXR pictures: the linear light before it is developed, with AOVs (extra layers) of depth, motion and surfaces.

Needs the extra `exr` (the package OpenEXR); it is imported only when such a picture is read or written.
"""

from pathlib import Path

import numpy as np

from gen_art.errors import OutputError, UsageError
from gen_art.files import beside
from gen_art.output.recipe import KEY, encode

__all__ = ["read_text", "write_exr"]

_LARGEST_HALF = 65504.0


def _library():
    try:
        import OpenEXR
    except ImportError:
        raise UsageError("OpenEXR pictures need OpenEXR, which is not installed: pip install OpenEXR") from None
    return OpenEXR


def check_exr() -> None:
    """Raise UsageError unless the package OpenEXR is installed."""
    _library()


def write_exr(
    path, linear: np.ndarray, aovs: dict[str, np.ndarray] | None = None, bits: int = 16, recipe: dict | None = None,
    exposure: float = 0.0, overwrite: bool = True,
) -> Path:  # fmt: skip
    """Write (height, width, 4) float32, linear Rec.709 and premultiplied, as R G B A with lossless ZIP compression.

    aovs : name -> (height, width), of gen_art.renderer.aovs: `Z` in metres, `velocity.x` and `velocity.y` in pixels a frame ...
    bits : 16 (half floats, clipped to +-65504) or 32; Z always has 32
    exposure : stops that `develop` would apply; written to the header, not applied
    The file appears under its final name only when it is complete. Raises UsageError when OpenEXR is not installed,
    OutputError when the operating system refuses, and for a file that exists by then (unless overwrite).
    """
    library, path = _library(), Path(path)
    kind = np.float16 if bits == 16 else np.float32
    channels = {"RGBA": _as(linear, kind)}
    for name, values in (aovs or {}).items():
        channels[name] = _as(values, np.float32 if name == "Z" else kind)
    header = {
        "compression": library.ZIP_COMPRESSION,
        "type": library.scanlineimage,
        "chromaticities": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),  # Rec.709, white D65
        "exposure": float(exposure),
    }
    if recipe is not None:
        header[KEY] = encode(recipe)
    with beside(path, overwrite) as temporary:
        try:
            with library.File(header, channels) as file:
                file.write(str(temporary))
        except RuntimeError as error:  # OpenEXR reports errors of the operating system as RuntimeError
            raise OutputError(f"cannot write {path}: {error}") from error
    return path


def _as(values: np.ndarray, kind) -> np.ndarray:
    if kind is np.float16:
        values = np.clip(values, -_LARGEST_HALF, _LARGEST_HALF)
    return np.ascontiguousarray(values, dtype=kind)


def read_text(path: Path) -> str | None:
    """The recipe's text in a picture's header; None when there is none. Raises UsageError if the file cannot be read."""
    library = _library()
    try:
        with library.File(str(path), header_only=True) as file:
            text = file.header().get(KEY)
            return text if isinstance(text, str) else None
    except MemoryError:
        raise
    except Exception as error:  # of a damaged file, OpenEXR raises errors of several kinds
        raise UsageError(f"{path}: cannot be read as a picture ({error})") from error
