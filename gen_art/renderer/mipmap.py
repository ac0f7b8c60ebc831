"""Mipmaps: a square of texels and its halves, quarters and so on, down to one texel."""

import numpy as np

__all__ = ["mipmap_chain"]


def mipmap_chain(rows: np.ndarray, first: int = 0) -> np.ndarray:
    """A square of texels, whose side is a power of two, and all its halves, (n, 4) float32.

    rows : (m, side, 4), the square's rows from row `first` on; the others are 0 and take no time, as those above and below an
        image that is wider than high
    Texels are averaged in float64.
    """
    side = rows.shape[1]
    chain = np.zeros(((4 * side * side - 1) // 3, 4), np.float32)
    chain[first * side : (first + len(rows)) * side] = rows.reshape(-1, 4)
    start = side * side
    while side > 1:
        above, below = first % 2, (first + len(rows)) % 2
        if above or below:
            rows = np.pad(rows, ((above, below), (0, 0), (0, 0)))
        pairs = np.add(rows[0::2], rows[1::2], dtype=np.float64)
        rows = (pairs[:, 0::2] + pairs[:, 1::2]) / 4.0
        first, side = first // 2, side // 2
        place = start + first * side
        chain[place : place + len(rows) * side] = rows.reshape(-1, 4)
        start += side * side
    return chain
