"""A system's particles as they are projected on the picture."""

import numpy as np

from gen_art.backend.runtime import aligned
from gen_art.particles.rows import POSITION
from gen_art.renderer.sprite import ALPHA, CHANNELS, FOOTPRINT, HIDDEN, OUTSIDE, RED, X

__all__ = ["LIT_ALBEDO", "LIT_COLUMNS", "LIT_EXTINCTION", "LIT_POSITION", "LIT_RADIUS", "ProjectedParticles"]

# columns of a lit particle: position, extinction cross section (m^2), albedo times coverage, radius of the sprite (m)
LIT_POSITION, LIT_EXTINCTION, LIT_ALBEDO, LIT_RADIUS = slice(0, 3), 3, slice(4, 7), 7
LIT_COLUMNS, FIRST_ALBEDO = 8, LIT_ALBEDO.start


class ProjectedParticles:
    """One system's particles on the picture; the arrays are reused from frame to frame.

    channels : (11, capacity) float32, of which the first `count` columns are in use; there is room for a whole tile at the end
    lit : (capacity, 8) float32, the columns LIT_... of a lit look's particles
    """

    def __init__(self):
        self.channels = np.zeros((CHANNELS, 0), np.float32)
        self.lit = np.zeros((1, LIT_COLUMNS), np.float32)
        self.count = 0

    def reserve(self, n: int, lit: bool) -> None:
        if n > self.channels.shape[1]:
            self.channels = aligned((CHANNELS, (n + n // 8) // 32 * 32 + 32), np.float32)
        if lit and n > len(self.lit):
            self.lit = np.empty((n + n // 8, LIT_COLUMNS), np.float32)
        self.count = n

    @property
    def used(self) -> np.ndarray:
        """The channels of the particles in use, (11, count): a view."""
        return self.channels[:, : self.count]

    def hide(self, which: np.ndarray) -> None:
        """Draw nothing of the particles that a mask (count,) names."""
        self.used[FOOTPRINT, which], self.used[X, which] = HIDDEN, OUTSIDE
        self.used[RED : ALPHA + 1, which] = 0.0

    def hide_behind(self, system, point, normal) -> None:
        """Hide the particles behind a plane."""
        positions = system.floats[POSITION, : self.count]
        self.hide(np.asarray(normal, np.float64) @ positions - float(np.dot(normal, point)) < 0.0)
