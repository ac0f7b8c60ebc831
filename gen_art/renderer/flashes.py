"""What flashes leave in a picture: the solids of a look as they were at earlier moments.

A picture in which something is partly transparent is the weighted sum of several: something of opacity q is drawn in those whose
weights sum to q.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gen_art.preset.look import Flashes, Look
from gen_art.renderer.projected_particles import LIT_EXTINCTION, LIT_POSITION, LIT_RADIUS
from gen_art.renderer.surfaces.solid_rows import SolidSystem

__all__ = ["FlashAlbum"]

_USUAL = 0.5  # opacity from which a layer of depth, or a trail, takes something as there
_MOVED = 1e-3  # of a solid's size, or rad: what has moved by less since the next flash is in the same place


class FlashAlbum:
    """What the last flashes left, of all looks that have them. All painters of one picture share one.

    flashes : of the looks that have some
    least : the opacity that a thing has at least, to be drawn
    """

    def __init__(self, looks: Mapping[str, Look | None]):
        self.flashes: dict[str, Flashes] = {
            name: look.flashes for name, look in looks.items() if look is not None and look.flashes is not None
        }
        self.least = _USUAL
        # by look, the newest last; which may be of the moment of the picture
        self._moments: dict[str, deque[tuple[float, SolidSystem]]] = {
            name: deque(maxlen=flashes.number + 1) for name, flashes in self.flashes.items()
        }

    def remember(self, name: str, solids: SolidSystem, time: float) -> None:
        """Keep what a flash at `time` (s) shows; a second one at the same moment does nothing."""
        moments = self._moments[name]
        if moments and moments[-1][0] >= time:
            return
        still, shapes = np.zeros_like(solids.velocities), solids.shapes
        if shapes is not None:
            shapes = replace(shapes, velocity=np.zeros_like(shapes.velocity), spin=np.zeros_like(shapes.spin))
        moments.append((time, replace(solids, velocities=still, shapes=shapes)))

    def left(self, name: str, now: SolidSystem, time: float) -> list[SolidSystem]:
        """What the last flashes before `time` left that is opaque enough, newest first.

        now : the solids at `time`; what is where it was at the next flash, or is now, is there once
        """
        found, newer = [], now
        for solids, opacity in self._before(name, time):
            if opacity >= self.least:
                found.append(_where_moved(solids, newer))
                newer = solids
        return found

    def exposures(self, time: float) -> list[tuple[float, float]]:
        """(`least`, weight) of the pictures whose weighted sum is the picture at `time`."""
        opacities = {opacity for name in self.flashes for _, opacity in self._before(name, time) if opacity > 0.0}
        levels = sorted({1.0, *opacities})
        return [(level, level - below) for level, below in zip(levels, [0.0, *levels])]

    def expose(self, least: float = _USUAL) -> None:
        """Draw what is as opaque as `least` from now on."""
        self.least = least

    def _before(self, name: str, time: float) -> list[tuple[SolidSystem, float]]:
        """(solids, opacity) of the last flashes before `time`, newest first."""
        flashes = self.flashes[name]
        age = np.arange(flashes.number) / max(flashes.number - 1, 1)
        opacities = flashes.opacity * (1.0 - (1.0 - flashes.tail) * age)
        solids = [solids for moment, solids in reversed(self._moments[name]) if moment < time]
        return list(zip(solids, opacities.tolist()))


def _where_moved(solids: SolidSystem, newer: SolidSystem) -> SolidSystem:
    """Solids without those that are where they are at a later moment."""
    if solids.columns.shape != newer.columns.shape:
        return solids
    old, new = solids.shapes, newer.shapes
    if old is None or new is None:
        size = solids.columns[:, LIT_RADIUS]
        resting = np.abs(solids.columns[:, LIT_POSITION] - newer.columns[:, LIT_POSITION]).max(axis=1) <= _MOVED * size
    else:
        if not np.array_equal(old.particle, new.particle):
            return solids
        size = np.maximum(old.half.max(axis=1), np.nan_to_num(old.radius))
        moved = np.abs(old.center - new.center).max(axis=1) > _MOVED * size
        moved |= np.abs(old.axes - new.axes).max(axis=(1, 2)) > _MOVED
        resting = np.ones(len(solids.columns), bool)
        resting[old.particle[moved]] = False
    if not resting.any():
        return solids
    columns = solids.columns.copy()
    columns[resting, LIT_EXTINCTION] = 0.0
    return replace(solids, columns=columns)
