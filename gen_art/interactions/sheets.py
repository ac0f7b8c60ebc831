"""Triangles between the particles of a cloth, to be drawn."""

import numpy as np

from gen_art.errors import UsageError

__all__ = ["NO_FACES", "checked_faces", "whole_faces"]

NO_FACES = np.zeros((0, 3), np.int64)


def checked_faces(faces, pairs: np.ndarray) -> np.ndarray:
    """(k, 3) int64 from what a script gives. Raises UsageError unless they are triangles of particles that springs join.

    pairs : (m, 2), ids of the particles that springs join
    """
    try:
        found = np.asarray(faces)
    except ValueError:
        raise UsageError("faces must be whole numbers of the shape (k, 3); some face is no triangle") from None
    if found.size == 0:
        return NO_FACES
    if found.ndim != 2 or found.shape[1] != 3 or not np.issubdtype(found.dtype, np.integer):
        raise UsageError(f"faces must be whole numbers of the shape (k, 3), not {found.dtype} of {found.shape}")
    joined = np.isin(found, pairs)
    if not joined.all():
        raise UsageError(f"faces: no spring holds particle {found[~joined][0]}")
    return found.astype(np.int64)


def whole_faces(faces: np.ndarray, ids: np.ndarray, broken: np.ndarray) -> np.ndarray:
    """(n, 3), slots of the triangles whose corners are alive and along whose sides no spring is broken.

    faces : (k, 3), ids of corners
    ids : (count,), rising, of the living particles
    broken : (b, 2), ids that broken springs joined
    """
    if not len(ids):
        return NO_FACES
    slots = np.minimum(np.searchsorted(ids, faces), len(ids) - 1)
    kept = (ids[slots] == faces).all(axis=1)
    if len(broken):
        sides = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        kept &= ~np.isin(_keys(sides), _keys(broken)).reshape(-1, 3).any(axis=1)
    return slots[kept]


def _keys(pairs: np.ndarray) -> np.ndarray:
    """One number for each pair, whatever the order of its two."""
    low, high = np.sort(pairs.astype(np.int64), axis=1).T
    return (low << 32) | high
