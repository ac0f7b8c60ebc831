"""Mipmaps: a square of texels and its halves, quarters and so on, down to one texel."""

import numpy as np

__all__ = ["mipmap_chain"]


def mipmap_chain(level: np.ndarray) -> np.ndarray:
    """A square of texels (side, side, 4), whose side is a power of two, and all its halves, (n, 4) float32."""
    levels = [level]
    while len(levels[-1]) > 1:
        upper, lower = levels[-1][0::2], levels[-1][1::2]
        levels.append((upper[:, 0::2] + upper[:, 1::2] + lower[:, 0::2] + lower[:, 1::2]) / 4.0)
    return np.concatenate([each.reshape(-1, 4) for each in levels]).astype(np.float32)
