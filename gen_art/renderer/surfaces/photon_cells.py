"""Photons in cells of space, and the light that those near a place bring.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.scene_numbers import PHOTON_CELL

__all__ = ["NO_PHOTONS", "PHOTON_FLOATS", "Photons", "photon_light"]

PHOTON_FLOATS = 7  # place relative to the camera, light, radius of its disc
_SLOTS = 1 << 17
_ENOUGH, _WIDEST = 100.0, 2.0  # photons beside one from which on its disc is not wider; how much wider it may be
_PRIMES = (73856093, 19349663, 83492791)  # Teschner et al., Optimized spatial hashing, VMV 2003


@dataclass(frozen=True)
class Photons:
    """Photons, listed by slots that cells of space share.

    rows : (n, PHOTON_FLOATS) float32
    starts : (_SLOTS + 1,) int32, the first of each slot
    cell : side of a cell, twice the largest radius; 0 without photons
    """

    rows: np.ndarray
    starts: np.ndarray
    cell: float

    @classmethod
    def of(cls, rows: np.ndarray) -> "Photons":
        """The photons among these rows that have a radius, which grows where they lie sparsely."""
        rows = rows[rows[:, 6] > 0.0]
        if not len(rows):
            return NO_PHOTONS
        slot = _slots(rows, 2.0 * float(rows[:, 6].max()))
        beside = np.bincount(slot, minlength=_SLOTS)[slot]
        rows[:, 6] *= np.clip(np.sqrt(_ENOUGH / beside), 1.0, _WIDEST)
        cell = 2.0 * float(rows[:, 6].max())
        slot = _slots(rows, cell)
        order = np.argsort(slot, kind="stable")
        starts = np.searchsorted(slot[order], np.arange(_SLOTS + 1)).astype(np.int32)
        return cls(np.ascontiguousarray(rows[order]), starts, cell)


def _slots(rows: np.ndarray, cell: float) -> np.ndarray:
    """(n,) the slot of each photon's cell."""
    place = np.floor(rows[:, :3] / np.float32(cell)).astype(np.int64)
    return (place[:, 0] * _PRIMES[0] ^ place[:, 1] * _PRIMES[1] ^ place[:, 2] * _PRIMES[2]) & (_SLOTS - 1)


NO_PHOTONS = Photons(np.zeros((1, PHOTON_FLOATS), np.float32), np.zeros(2, np.int32), 0.0)


@ti.func
def photon_light(scene: ti.template(), x):
    """(3,) the radiance of a white surface at x (relative to the camera) in the light of photons."""
    N, P = ti.static(scene.N, scene.photons)
    result = ti.Vector([0.0, 0.0, 0.0])
    if N[PHOTON_CELL] > 0.0:
        corner = ti.Vector([0, 0, 0])
        for c in ti.static(range(3)):
            corner[c] = ti.cast(ti.floor(x[c] / N[PHOTON_CELL] - 0.5), ti.i32)
        for k in range(8):
            i, j, l = corner[0] + (k >> 2), corner[1] + ((k >> 1) & 1), corner[2] + (k & 1)
            slot = (i * _PRIMES[0] ^ j * _PRIMES[1] ^ l * _PRIMES[2]) & (_SLOTS - 1)
            for q in range(scene.photon_starts[slot], scene.photon_starts[slot + 1]):
                a, b, c = P[q, 0] - x[0], P[q, 1] - x[1], P[q, 2] - x[2]
                radius2, cell = P[q, 6] * P[q, 6], ti.Vector([P[q, 0], P[q, 1], P[q, 2]]) / N[PHOTON_CELL]
                near = 1.0 - (a * a + b * b + c * c) / radius2
                if near > 0.0:
                    # slots are shared, so a photon counts only in the cell where it is
                    same = ti.floor(cell[0]) == i and ti.floor(cell[1]) == j and ti.floor(cell[2]) == l
                    if same:
                        weight = near * (2.0 / 3.14159265) / radius2
                        for e in ti.static(range(3)):
                            result[e] += weight * P[q, 3 + e]
    return result
