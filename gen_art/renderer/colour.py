"""Colour: linear Rec.709 inside; sRGB transfer, OKLab gradients, black-body light, and tables of them.

Everything here is NumPy in float64. Kernels get float32 tables of 256 entries, which are run-time data.
Sources: IEC 61966-2-1 (sRGB); Ottosson, A perceptual color space for image processing (2020); Wyman, Sloan and Shirley,
Simple analytic approximations to the CIE XYZ color matching functions, JCGT 2013; Planck's law.
"""

import numpy as np

from gen_art.preset.colour_names import Gradient, srgb

__all__ = [
    "LUMINANCE", "TABLE", "blackbody", "colour_matching", "encode_srgb", "gradient_table", "linear", "luminance_of",
    "bytes_to_linear", "planck_luminance", "rgb_to_xyz", "to_linear", "to_oklab", "from_oklab",
]  # fmt: skip

TABLE = 256
LUMINANCE = np.array([0.2126390058715104, 0.7151686787677559, 0.0721923153607337])
_WHITE = (0.3127, 0.3290)
_PRIMARIES = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))


def rgb_to_xyz(primaries=_PRIMARIES, white=_WHITE) -> np.ndarray:
    """The 3x3 matrix from linear RGB of the given chromaticities (x, y) to XYZ, in which white has Y = 1."""
    columns = np.array([[x / y, 1.0, (1.0 - x - y) / y] for x, y in primaries]).T
    scale = np.linalg.solve(columns, np.array([white[0] / white[1], 1.0, (1.0 - white[0] - white[1]) / white[1]]))
    return columns * scale


def to_linear(encoded) -> np.ndarray:
    """Linear light of sRGB-encoded values (inverse of `encode_srgb`)."""
    e = np.asarray(encoded, dtype=np.float64)
    return np.where(e <= 0.04045, e / 12.92, ((np.maximum(e, 0.0) + 0.055) / 1.055) ** 2.4)


def bytes_to_linear(encoded: np.ndarray) -> np.ndarray:
    """Linear light of sRGB-encoded uint8 values, 0..255 for 0..1."""
    return to_linear(np.arange(256) / 255.0)[encoded]


def encode_srgb(light) -> np.ndarray:
    """sRGB-encoded values of linear light in 0..1."""
    x = np.asarray(light, dtype=np.float64)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def linear(colour) -> np.ndarray:
    """Linear Rec.709 (3,) of a colour as presets write it. Raises UsageError when it is not a colour."""
    return to_linear(srgb(colour))


def luminance_of(rgb) -> np.ndarray:
    """Relative luminance of linear Rec.709 (..., 3)."""
    return np.asarray(rgb) @ LUMINANCE


_RGB_TO_LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_LMS_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def to_oklab(rgb) -> np.ndarray:
    """OKLab (..., 3) of linear Rec.709 (..., 3)."""
    return np.cbrt(np.asarray(rgb) @ _RGB_TO_LMS.T) @ _LMS_TO_LAB.T


def from_oklab(lab) -> np.ndarray:
    """Linear Rec.709 (..., 3) of OKLab; components outside the gamut are negative or above 1."""
    return (np.asarray(lab) @ np.linalg.inv(_LMS_TO_LAB).T) ** 3 @ np.linalg.inv(_RGB_TO_LMS).T


def gradient_table(gradient: Gradient, size: int = TABLE) -> np.ndarray:
    """(size, 3) float64 linear Rec.709: the gradient over 0..1, interpolated in OKLab."""
    positions = np.array([p for p, _ in gradient.stops])
    stops = np.array([linear(c) for _, c in gradient.stops])
    if len(stops) == 1:
        return np.repeat(stops, size, axis=0)
    lab = to_oklab(stops)
    x = np.linspace(0.0, 1.0, size)
    mixed = from_oklab(np.stack([np.interp(x, positions, lab[:, c]) for c in range(3)], axis=1))
    return np.maximum(mixed, 0.0)


def _lobe(x, peak, left, right):
    """A Gaussian with different widths on the left and on the right of its peak."""
    return np.exp(-0.5 * ((x - peak) / np.where(x < peak, left, right)) ** 2)


def colour_matching(nm) -> np.ndarray:
    """(n, 3) the CIE 1931 functions x, y, z at wavelengths (n,) in nm, by the fit of Wyman, Sloan and Shirley."""
    nm = np.asarray(nm, dtype=np.float64)
    return np.stack(
        [
            1.056 * _lobe(nm, 599.8, 37.9, 31.0)
            + 0.362 * _lobe(nm, 442.0, 16.0, 26.7)
            - 0.065 * _lobe(nm, 501.1, 20.4, 26.2),
            0.821 * _lobe(nm, 568.8, 46.9, 40.5) + 0.286 * _lobe(nm, 530.9, 16.3, 31.1),
            1.217 * _lobe(nm, 437.0, 11.8, 36.0) + 0.681 * _lobe(nm, 459.0, 26.0, 13.8),
        ],
        axis=1,
    )


_NM = np.arange(360.0, 831.0, 2.0)
_CMF = colour_matching(_NM)


def _planck_xyz(kelvin) -> np.ndarray:
    t = np.maximum(np.atleast_1d(np.asarray(kelvin, dtype=np.float64)), 100.0)
    metres = _NM * 1e-9
    exponent = np.minimum(1.438776877e-2 / (metres * t[:, None]), 700.0)
    return (metres**-5 / np.expm1(exponent)) @ _CMF * 1e-32


def blackbody(kelvin) -> np.ndarray:
    """(n, 3) linear Rec.709 chromaticity of a black body, largest channel 1; components outside the gamut are clipped."""
    rgb = np.maximum(_planck_xyz(kelvin) @ np.linalg.inv(rgb_to_xyz()).T, 0.0)
    return rgb / np.maximum(rgb.max(axis=1, keepdims=True), 1e-300)


def planck_luminance(kelvin) -> np.ndarray:
    """(n,) luminance of a black body per unit area, in arbitrary units: only ratios have a meaning."""
    return _planck_xyz(kelvin)[:, 1]
