"""The contract of an interaction: forces between particles, summed by a pair kernel into an array of accelerations."""

from typing import ClassVar

import numpy as np

from gen_art.registry import Parametric, Registry

__all__ = ["INTERACTIONS", "Interaction", "interaction"]

INTERACTIONS = Registry("interaction")
interaction = INTERACTIONS


class Interaction(Parametric):
    """Acts between particles.

    `accelerate(targets, n, sources, out, precision)` writes the acceleration (3, n) of the first n target positions,
    `targets` (3 or more rows, capacity), under `sources` (4, m): x, y, z and weight. `energy(...)` gives the potential
    energy in joules. `weight` names the row a source acts by. `sources` is None (this system itself) or another system.
    """

    weight: ClassVar[str] = "mass"
    conservative: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True

    @property
    def source_system(self) -> str | None:
        """The other system whose particles act, or None: the particles of the system act on each other."""
        return self.values.get("sources")

    def accelerate(self, targets: np.ndarray, n: int, sources: np.ndarray, out: np.ndarray, precision: str) -> None:
        raise NotImplementedError

    def energy(self, targets: np.ndarray, weights: np.ndarray, precision: str) -> float:
        raise NotImplementedError
