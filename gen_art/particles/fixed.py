"""Fixed particles: held where they are, whatever pulls at them.

They are marked by a lifetime beyond every real one (but not infinite): their own part of every step is empty.
"""

import numpy as np

from gen_art.backend.runtime import ti

__all__ = ["FIXED", "fixed_lifetimes", "is_fixed"]

FIXED = 3.0e38


@ti.func
def is_fixed(lifetime):
    return (lifetime > 2.0e38) & (lifetime < 3.3e38)


def fixed_lifetimes(lifetimes: np.ndarray) -> np.ndarray:
    """Which of these lifetimes mark a fixed particle (bool)."""
    return (lifetimes > 2.0e38) & (lifetimes < 3.3e38)
