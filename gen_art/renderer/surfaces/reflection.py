"""What a surface reflects: Fresnel's formulas, the microfacet model of rough surfaces, and its energy.

The layer of a surface reflects the part C of light that comes evenly from all sides, and what it lets through is scattered
below it (Lambert): the two add up to the albedo's part of the light, and to all of it for an albedo of 1.
For a metal C is albedo A + B, with Schlick's approximation; light that a rough metal reflects twice is added back.
Source: Trowbridge and Reitz (1975); Walter et al., Microfacet models for refraction (2007); Heitz, Understanding the
masking-shadowing function, JCGT 2014; Schlick (1994); Turquin, Practical multiple scattering compensation (2019).
"""

from functools import lru_cache

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.maths.array_functions import cos

__all__ = ["ANGLES", "SMOOTH", "fresnel", "fresnel_of", "microfacets", "reflected_share"]

ANGLES = 33  # entries of a table over the cosine of the angle of view, from 0 to 1
_SAMPLES = 48  # along each of the two random numbers of the integral
SMOOTH = 1e-3  # roughness up to which a surface reflects as a mirror


def fresnel(cosine, ior: float) -> np.ndarray:
    """The reflectance of a smooth dielectric for unpolarised light, (Rs + Rp) / 2.

    cosine : of the angle of incidence, 0..1
    ior : refractive index of the inner side relative to the outer, at least 1
    """
    c = np.asarray(cosine, np.float64)
    t = np.sqrt(ior * ior - 1.0 + c * c)  # ior times the cosine inside
    with np.errstate(invalid="ignore"):
        s = (c - t) / (c + t)
        p = (t - ior * ior * c) / (t + ior * ior * c)
    return np.where(c + t > 0.0, 0.5 * (s * s + p * p), 0.0 if ior == 1.0 else 1.0)


@ti.func
def fresnel_of(c, ior):
    """`fresnel` in a kernel."""
    t = ti.sqrt(ti.max(ior * ior - 1.0 + c * c, 0.0))
    s = (c - t) / ti.max(c + t, 1e-20)
    p = (t - ior * ior * c) / ti.max(t + ior * ior * c, 1e-20)
    return 0.5 * (s * s + p * p)


@ti.func
def microfacets(nl, nv, nh, alpha):
    """D V of the Trowbridge-Reitz distribution with Smith's height-correlated masking, per steradian.

    nl, nv, nh : cosines of the normal with the light, the view and the half vector
    alpha : width of the distribution, roughness squared
    """
    a2 = alpha * alpha
    d = nh * nh * (a2 - 1.0) + 1.0
    distribution = a2 / ti.max(3.14159265 * d * d, 1e-20)
    masking = nl * ti.sqrt(nv * nv * (1.0 - a2) + a2) + nv * ti.sqrt(nl * nl * (1.0 - a2) + a2)
    return distribution * 0.5 / ti.max(masking, 1e-20)


@lru_cache(64)
def reflected_share(roughness: float, ior: float) -> np.ndarray:
    """(ANGLES, 3) float32: A, B and C over the cosine of the angle of view. See the file's docstring.

    The integral over the hemisphere is a mean over half vectors that are drawn from the distribution.
    """
    cosine = np.linspace(0.0, 1.0, ANGLES)
    if roughness <= SMOOTH:
        schlick = (1.0 - cosine) ** 5
        return np.stack([1.0 - schlick, schlick, fresnel(cosine, ior)], axis=1).astype(np.float32)
    a2 = roughness**4
    u = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    nh2 = (1.0 - u) / (1.0 + (a2 - 1.0) * u)
    nh, sh = np.sqrt(nh2)[:, None], np.sqrt(1.0 - nh2)[:, None]
    azimuth = cos(np.pi * u)[None, :]  # symmetrical: half of the circle is enough
    out = np.zeros((ANGLES, 3))
    for k, c in enumerate(np.maximum(cosine, 1e-3)):
        vh = np.maximum(np.sqrt(1.0 - c * c) * sh * azimuth + c * nh, 1e-9)
        nl = 2.0 * vh * nh - c
        above = nl > 0.0
        nl = np.maximum(nl, 1e-9)
        masking = nl * np.sqrt(c * c * (1.0 - a2) + a2) + c * np.sqrt(nl * nl * (1.0 - a2) + a2)
        weight = np.where(above, 2.0 * nl * vh / (masking * nh), 0.0)
        schlick = (1.0 - vh) ** 5
        for column, factor in enumerate((1.0 - schlick, schlick, fresnel(vh, ior))):
            out[k, column] = float((weight * factor).mean())
    return np.minimum(out, 1.0).astype(np.float32)
