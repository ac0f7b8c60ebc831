"""The rows of an array (8, pieces) of pieces of curved streaks, which curved_streaks.py writes and shading.py reads."""

import numpy as np

__all__ = ["NO_PIECES", "PIECE_HEAD", "PIECE_LIGHT", "PIECE_OLD", "PIECE_ROWS", "PIECE_WIDTH"]

PIECE_HEAD, PIECE_OLD = 0, 3  # both ends: right of, above and ahead of the camera
PIECE_LIGHT, PIECE_WIDTH = 6, 7  # factors of the light, and of the width at the head
PIECE_ROWS = 8
NO_PIECES = np.zeros((PIECE_ROWS, 1), np.float32)
