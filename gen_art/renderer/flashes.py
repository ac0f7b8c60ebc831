"""What flashes leave in a picture: the solids of a look as they were at earlier moments."""

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from gen_art.preset.look import Flashes
from gen_art.renderer.surfaces.solid_rows import SolidSystem

__all__ = ["FlashHistory", "exposures"]


class FlashHistory:
    """The solids of one look at the last flashes, as they were shaded then. They stand still."""

    def __init__(self, flashes: Flashes):
        self.flashes = flashes
        self._moments: deque[tuple[float, SolidSystem]] = deque(maxlen=flashes.number + 1)  # the last may be now

    def remember(self, solids: SolidSystem, time: float) -> None:
        """Keep what a flash at `time` (s) shows; a second one at the same moment does nothing."""
        if self._moments and self._moments[-1][0] >= time:
            return
        still, shapes = np.zeros_like(solids.velocities), solids.shapes
        if shapes is not None:
            shapes = replace(shapes, velocity=np.zeros_like(shapes.velocity), spin=np.zeros_like(shapes.spin))
        self._moments.append((time, replace(solids, velocities=still, shapes=shapes)))

    @property
    def opacities(self) -> np.ndarray:
        """(number,) of what each flash left, newest first."""
        age = np.arange(self.flashes.number) / max(self.flashes.number - 1, 1)
        return self.flashes.opacity * (1.0 - (1.0 - self.flashes.tail) * age)

    def before(self, time: float, least: float) -> list[SolidSystem]:
        """What the last flashes before `time` left, newest first, of opacity `least` or more."""
        left = [solids for moment, solids in reversed(self._moments) if moment < time]
        return [solids for solids, opacity in zip(left, self.opacities.tolist()) if opacity >= least]


def exposures(histories: Iterable[FlashHistory]) -> list[tuple[float, float]]:
    """(least opacity of what is drawn, weight) of the pictures whose weighted sum shows all as they hide.

    Something of opacity q is in the pictures whose weights sum to q.
    """
    opacities = {q for history in histories for q in history.opacities.tolist() if q > 0.0}
    levels = sorted({1.0, *opacities})
    return [(level, level - below) for level, below in zip(levels, [0.0, *levels])]
