"""Discs of bodies: what a disc of any profile shares, and Kuzmin's."""

from collections.abc import Callable

import numpy as np

from gen_art.emitters.base import emitter
from gen_art.emitters.placed import PlacedEmitter
from gen_art.maths.array_functions import arctanh, cos, sin
from gen_art.registry import param

__all__ = ["KuzminDisc", "disc_bodies", "frequencies"]


def frequencies(circular_speed_squared: Callable, scale: float, edge: float, R: np.ndarray) -> tuple[np.ndarray, ...]:
    """v_c^2, the epicyclic frequency kappa and the angular frequency Omega at R, in a disc up to `edge` scale lengths."""
    grid = np.linspace(1e-3, 1.2 * edge, 3000) * scale
    vc2 = circular_speed_squared(grid)
    omega2 = vc2 / grid**2
    kappa2 = np.maximum(4 * omega2 + grid * np.gradient(omega2, grid), 0.1 * omega2)
    return np.interp(R, grid, vc2), np.sqrt(np.interp(R, grid, kappa2)), np.sqrt(np.interp(R, grid, omega2))


def disc_bodies(r, R, phi, sigma, slope, known, thickness: float, toomre_q: float, G: float) -> dict:
    """Places and velocities of bodies of a disc with +y as its axis, anticlockwise seen from +y.

    across the disc sech^2(z / thickness)
    sigma_R = Q 3.36 G Sigma / kappa, sigma_phi = sigma_R kappa / (2 Omega), sigma_z^2 = pi G Sigma thickness
    The mean rotation is reduced by the asymmetric drift.
    r : the random streams; R, phi : radii and azimuths
    sigma, slope : the surface density Sigma, and d ln Sigma / d ln R
    known : what `frequencies` returns
    """
    vc2, kappa, omega = known
    z = thickness * arctanh(np.clip(2 * r.uniform(3) - 1, -0.9999, 0.9999))
    sigma_R = np.minimum(toomre_q * 3.36 * G * sigma / np.maximum(kappa, 1e-30), 0.5 * np.sqrt(vc2))
    axis_ratio = kappa / (2 * np.maximum(omega, 1e-30))
    mean_vphi = np.sqrt(np.maximum(vc2 + sigma_R**2 * (1 - axis_ratio**2 + 2 * slope), 0.05 * vc2))
    vR, vphi = sigma_R * r.normal(4), mean_vphi + sigma_R * axis_ratio * r.normal(5)
    vz = np.sqrt(np.pi * G * sigma * thickness) * r.normal(6)
    c, s = cos(phi), sin(phi)
    return {
        "position": np.stack([R * c, z, -R * s]),
        "velocity": np.stack([vR * c - vphi * s, vz, -vR * s - vphi * c]),
    }


@emitter("kuzmin_disc")
class KuzminDisc(PlacedEmitter):
    """Kuzmin's disc: a flat disc whose field is that of a point below it.

    Sigma = mass scale / (2 pi (R^2 + scale^2)^(3/2)), v_c^2 = G mass R^2 / (R^2 + scale^2)^(3/2)
    across the disc sech^2(z / thickness)
    sigma_R = Q 3.36 G Sigma / kappa, sigma_phi = sigma_R kappa / (2 Omega), sigma_z^2 = pi G Sigma thickness
    The mean rotation is reduced by the asymmetric drift. The mass of each particle is mass / n.
    Source: Kuzmin (1956); Toomre (1963), ApJ 138, 385; Toomre (1964), ApJ 139, 1217.
    """

    G: float = param(
        6.67430e-11, unit="m^3/(kg s^2)", min=0, doc="constant of gravitation; units.G of the preset when left out"
    )
    mass: float = param(1.0, unit="kg", min=0, doc="mass of the whole disc; what is beyond the edge is drawn inside it")
    scale: float = param(1.0, unit="m", min=1e-30, doc="scale length")
    thickness: float = param(0.05, unit="m", min=0, doc="scale height")
    toomre_q: float = param(1.3, min=0, max=10, doc="Toomre's Q: below 1 the disc breaks into clumps")
    edge: float = param(6.0, min=0.5, max=50, doc="radius of the edge, in scale lengths")

    def sample(self, r, n):
        v = self.values
        a = v["scale"]
        inside = 1 - 1 / np.sqrt(1 + v["edge"] * v["edge"])  # M(R) / M = 1 - a / sqrt(R^2 + a^2)
        left = 1 - inside * r.uniform(1)
        R = np.maximum(a * np.sqrt(1 / (left * left) - 1), 1e-4 * a)
        s2 = R * R + a * a
        sigma = v["mass"] * a / (2 * np.pi * s2 * np.sqrt(s2))
        known = frequencies(self.circular_speed_squared, a, v["edge"], R)
        phi = 2 * np.pi * r.uniform(2)
        born = disc_bodies(r, R, phi, sigma, -3 * R * R / s2, known, v["thickness"], v["toomre_q"], v["G"])
        return self.placed({**born, "mass": np.full(n, v["mass"] / n)})

    def circular_speed_squared(self, R: np.ndarray) -> np.ndarray:
        """v_c^2(R) of the whole disc."""
        s2 = R * R + self.values["scale"] ** 2
        return self.values["G"] * self.values["mass"] * R * R / (s2 * np.sqrt(s2))
