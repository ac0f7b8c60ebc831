"""The squares of pixels that pictures are drawn in: bins, for lists of what lies in them, and tiles, the arrays of kernels."""

__all__ = ["BIN", "TILE", "TILES"]

BIN = 32  # pixels along the side of a bin
TILE = 8  # pixels along the side of a tile
TILES = BIN // TILE  # tiles along the side of a bin
