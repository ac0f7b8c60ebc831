"""Tone maps: from linear scene light to linear display light, as two matrices around a curve read from a table.

The table is indexed by the bits of a float32: STEPS entries an octave from 2^LOW to 2^HIGH, linear between them, so a kernel
needs no logarithm and gives the same bits everywhere.
Sources: AgX after T. Sobotka (log2 encoding of -10 to +6.5 stops, inset primaries, sigmoid through middle grey);
ACES as S. Hill's fit of RRT + ODT; Reinhard et al. 2002, equation 4; Khronos PBR Neutral (2024).
"""

import numpy as np

from gen_art.renderer.colour import encode_srgb, rgb_to_xyz

__all__ = ["HIGH", "LOW", "STEPS", "curve_table", "encode_table", "matrices"]

LOW, HIGH, STEPS_LOG = -24, 20, 7
STEPS = 1 << STEPS_LOG
GREY = 0.18

_ACES_IN = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
_ACES_OUT = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07603]]


def abscissae() -> np.ndarray:
    """The light values of the table's entries."""
    k = np.arange((HIGH - LOW) * STEPS + 1)
    return 2.0 ** (LOW + k // STEPS) * (1.0 + (k % STEPS) / STEPS)


def _sigmoid(x, pivot, grey, slope, power):
    """From (0, 0) through (pivot, grey) with a slope to (1, 1), bent by `power` on either side."""

    def bend(distance, longest, tallest):
        scale = (tallest**-power - (slope * longest) ** -power) ** (-1.0 / power)
        s = slope * distance
        return s / (1.0 + (s / scale) ** power) ** (1.0 / power)

    above = grey + bend(np.maximum(x - pivot, 0.0), 1.0 - pivot, 1.0 - grey)
    below = grey - bend(np.maximum(pivot - x, 0.0), pivot, grey)
    return np.where(x >= pivot, above, below)


def _agx(x):
    stops = np.clip((np.log2(np.maximum(x, 1e-12) / GREY) + 10.0) / 16.5, 0.0, 1.0)
    return np.clip(_sigmoid(stops, 10.0 / 16.5, GREY ** (1 / 2.2), 2.4, 1.5), 0.0, 1.0) ** 2.2


def _aces(x):
    return np.clip((x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081), 0.0, None)


def _reinhard(x, white=8.0):
    return x * (1.0 + x / white**2) / (1.0 + x)


_CURVES = {"agx": _agx, "aces": _aces, "reinhard": _reinhard, "neutral": lambda x: x, "none": lambda x: x}


def curve_table(tone: str, contrast: float = 1.0) -> np.ndarray:
    """The tone map's curve, float32, with contrast as a power about middle grey."""
    y = _CURVES[tone](abscissae())
    if contrast != 1.0 and tone != "neutral":
        y = GREY * (np.maximum(y, 0.0) / GREY) ** contrast
    return y.astype(np.float32)


def encode_table() -> np.ndarray:
    """The sRGB transfer over the same abscissae (1 above 1), float32."""
    return encode_srgb(np.minimum(abscissae(), 1.0)).astype(np.float32)


def _inset(amount: float) -> np.ndarray:
    """The matrix that draws the primaries towards white by `amount`; rows sum to 1."""
    white = np.array([0.3127, 0.3290])
    primaries = [
        tuple(white + (np.array(p) - white) * (1.0 - amount)) for p in ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
    ]
    return np.linalg.inv(rgb_to_xyz()) @ rgb_to_xyz(primaries)


def matrices(tone: str) -> tuple[np.ndarray, np.ndarray]:
    """What goes before the curve and after it."""
    if tone == "agx":
        inset = _inset(0.16)
        return inset, np.linalg.inv(inset)
    if tone == "aces":
        into, out = np.array(_ACES_IN), np.array(_ACES_OUT)
        return into / into.sum(axis=1, keepdims=True), out / out.sum(axis=1, keepdims=True)
    return np.eye(3), np.eye(3)
