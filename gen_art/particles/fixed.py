"""Fixed particles, which no force moves.

They are marked by a lifetime that is longer than any real one but finite. Their part of every step has the length 0.
"""

import numpy as np

from gen_art.backend.runtime import ti

__all__ = ["FIXED", "fixed_lifetimes", "is_fixed"]

FIXED = 3.0e38


@ti.func
def is_fixed(lifetime):
    return (lifetime > 2.0e38) & (lifetime < 3.3e38)


def fixed_lifetimes(lifetimes: np.ndarray) -> np.ndarray:
    """Bools: which of these lifetimes mark a fixed particle."""
    return (lifetimes > 2.0e38) & (lifetimes < 3.3e38)
