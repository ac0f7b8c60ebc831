"""OpenEXR pictures: the film's linear light before it is developed, with layers of depth and motion.

Needs the extra `exr` (the package OpenEXR); it is imported only when such a picture is read or written.
"""

from pathlib import Path

import numpy as np

from gen_art.errors import OutputError, UsageError
from gen_art.output.recipe import KEY, encode
from gen_art.output.target import beside

__all__ = ["read_text", "write_exr"]

_LARGEST_HALF = 65504.0


def _library():
    try:
        import OpenEXR
    except ImportError:
        raise UsageError("OpenEXR pictures need a package that is not installed: pip install 'gen-art[exr]'") from None
    return OpenEXR


def check_exr() -> None:
    """UsageError unless OpenEXR pictures can be written."""
    _library()


def write_exr(
    path, linear: np.ndarray, layers: dict[str, np.ndarray] | None = None, bits: int = 16, recipe: dict | None = None,
    exposure: float = 0.0,
) -> Path:  # fmt: skip
    """Write (height, width, 4) float32, linear Rec.709 and premultiplied, as R G B A; the final name appears whole.

    layers : name -> (height, width): `Z` in metres, `velocity.x` and `velocity.y` in pixels a frame
    bits : 16 (half; what lies above 65504 becomes that) or 32, of all but Z, which keeps 32
    exposure : in stops, what `develop` would apply; noted in the header, not applied
    Compressed without loss (ZIP). Raises UsageError without the package, OutputError when the system refuses.
    """
    library, path = _library(), Path(path)
    kind = np.float16 if bits == 16 else np.float32
    channels = {"RGBA": _as(linear, kind)}
    for name, values in (layers or {}).items():
        channels[name] = _as(values, np.float32 if name == "Z" else kind)
    header = {
        "compression": library.ZIP_COMPRESSION,
        "type": library.scanlineimage,
        "chromaticities": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),  # Rec.709, white D65
        "exposure": float(exposure),
    }
    if recipe is not None:
        header[KEY] = encode(recipe)
    with beside(path) as temporary:
        try:
            with library.File(header, channels) as file:
                file.write(str(temporary))
        except RuntimeError as error:  # what the system refuses comes as words
            raise OutputError(f"cannot write {path}: {error}") from error
    return path


def _as(values: np.ndarray, kind) -> np.ndarray:
    if kind is np.float16:
        values = np.clip(values, -_LARGEST_HALF, _LARGEST_HALF)
    return np.ascontiguousarray(values, dtype=kind)


def read_text(path: Path) -> str | None:
    """The recipe's text in a picture's header, None when there is none."""
    library = _library()
    try:
        with library.File(str(path), header_only=True) as file:
            return file.header().get(KEY)
    except (RuntimeError, OSError, ValueError) as error:
        raise UsageError(f"{path}: cannot be read as a picture ({error})") from error
