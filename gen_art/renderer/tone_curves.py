"""Tone maps: from linear scene light to linear display light, as numbers for the tone map kernel.

Four of them work channel by channel between two matrices: y = N(s) / D(s), two cubics in the light s, limited to a range.
`neutral` and `log` work on the whole colour; the kernel holds their formulas.

- agx: T. Sobotka's AgX: primaries moved towards white, log2 from -10 to +6.5 stops about middle grey, a sigmoid of slope
  2.4 through it. The cubics fit it within 0.005 in the square root of light, about a step of an 8-bit picture.
- aces: S. Hill's fit of the ACES reference and output transforms.
- reinhard: Reinhard et al. 2002, equation 4: x (1 + x / white^2) / (1 + x).
- neutral: Khronos PBR Neutral (2024).
- log: log-density mapping of Draves & Reckase, The fractal flame algorithm (2003): light L becomes
  log(1 + density L) / log(1 + density white), and the colour is scaled with it.
- none: the light itself.
"""

import numpy as np

from gen_art.renderer.colour import LUMINANCE, rgb_to_xyz

__all__ = ["GREY", "matrices", "rational"]

GREY = 0.18
# light is limited to it: the square of the product of three channels' D is still a float32
MAX_LIGHT = 1e6

_ACES_IN = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
_ACES_OUT = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07603]]

# the light where N is 0; everything below is black
_ACES_BLACK = 0.5 * (np.sqrt(0.0245786**2 + 4.0 * 0.000090537) - 0.0245786)

_CUBICS = {  # (lowest light, highest, numerator, denominator)
    "agx": (
        GREY * 2.0**-10, GREY * 2.0**6.5,
        (-0.0001115836, 0.6328934, 10.77237, 3.42573), (1.0, 6.221913, 16.81256, 3.03369),
    ),
    "aces": (_ACES_BLACK, 1e3, (-0.000090537, 0.0245786, 1.0, 0.0), (0.238081, 0.4329510, 0.983729, 0.0)),
    "reinhard": (0.0, MAX_LIGHT, (0.0, 1.0, None, 0.0), (1.0, 1.0, 0.0, 0.0)),
}  # fmt: skip
_IDENTITY = (0.0, 1e12, (0.0, 1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


def rational(tone: str, white: float = 8.0) -> np.ndarray:
    """(10,) float64: lowest and highest light, four coefficients of N and four of D, lowest power first.

    white : the light that reinhard maps to 1
    """
    low, high, numerator, denominator = _CUBICS.get(tone, _IDENTITY)
    if tone == "reinhard":  # reinhard's N must stay within float32 too
        high = min(high, high * white)
    numbers = [1.0 / white**2 if n is None else n for n in numerator]
    return np.array([low, high, *numbers, *denominator], np.float64)


def _inset_primaries(amount: float) -> np.ndarray:
    """The matrix that moves the primaries towards white by `amount`; rows sum to 1."""
    white = np.array([0.3127, 0.3290])
    primaries = [
        tuple(white + (np.array(p) - white) * (1.0 - amount)) for p in ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
    ]
    return np.linalg.inv(rgb_to_xyz()) @ rgb_to_xyz(primaries)


def matrices(tone: str, saturation: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """The matrices before and after the curve. The latter applies `saturation` about luminance too. Rows sum to 1."""
    before: np.ndarray = np.eye(3)
    after: np.ndarray = before
    if tone == "agx":
        before = _inset_primaries(0.16)
        after = np.linalg.inv(before)
    elif tone == "aces":
        before, after = (m / m.sum(axis=1, keepdims=True) for m in (np.array(_ACES_IN), np.array(_ACES_OUT)))
    grey = np.tile(LUMINANCE, (3, 1))
    return before, (grey + (np.eye(3) - grey) * saturation) @ after
