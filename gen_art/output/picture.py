"""A developed picture as an array that a notebook shows as a picture."""

from io import BytesIO
from typing import Any

import numpy as np

__all__ = ["Picture"]


class Picture(np.ndarray):
    """An array of a picture's values, (height, width, 3 or 4), which a notebook shows as a picture.

    A part of it, picture[top:bottom, left:right], is a Picture as well. What arithmetic makes of it is an ordinary array.
    """

    def __array_wrap__(self, array: np.ndarray, context: Any = None, return_scalar: bool = False) -> Any:
        plain = array.view(np.ndarray)
        return plain if plain.ndim else plain[()]

    def _repr_png_(self) -> bytes | None:
        """The picture as a PNG file; None unless this is (height, width, 3 or 4) of uint8."""
        if self.dtype != np.uint8 or self.ndim != 3 or self.shape[2] not in (3, 4) or not self.size:
            return None
        from PIL import Image

        file = BytesIO()
        Image.fromarray(np.ascontiguousarray(self)).save(file, format="PNG")
        return file.getvalue()
