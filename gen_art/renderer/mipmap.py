"""Mipmaps: a square of texels and its halves, quarters and so on, down to one texel."""

import numpy as np

__all__ = ["mipmap_chain"]


def mipmap_chain(level: np.ndarray) -> np.ndarray:
    """A square of texels (side, side, 4), whose side is a power of two, and all its halves, (n, 4) float32.

    Texels are averaged in float64. Rows above and below all that is not 0, as an image has that is wider than high, take no time.
    """
    side = len(level)
    chain = np.zeros(((4 * side * side - 1) // 3, 4), np.float32)
    chain[: side * side] = level.reshape(-1, 4)
    used = np.flatnonzero(level.any(axis=(1, 2)))
    if not len(used):
        return chain
    first, rows, start = int(used[0]), level[used[0] : used[-1] + 1].astype(np.float64), side * side
    while side > 1:
        rows = np.pad(rows, ((first % 2, (first + len(rows)) % 2), (0, 0), (0, 0)))
        upper, lower = rows[0::2], rows[1::2]
        rows = (upper[:, 0::2] + upper[:, 1::2] + lower[:, 0::2] + lower[:, 1::2]) / 4.0
        first, side = first // 2, side // 2
        place = start + first * side
        chain[place : place + len(rows) * side] = rows.reshape(-1, 4)
        start += side * side
    return chain
