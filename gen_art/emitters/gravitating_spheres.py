"""Spheres of bodies that hold together by their own gravity: clusters of stars, halos, and clouds that collapse."""

import math

import numpy as np

from gen_art.emitters.base import emitter
from gen_art.emitters.placed import PlacedEmitter
from gen_art.maths.array_functions import exp, log
from gen_art.registry import param

__all__ = ["GravitatingSphere", "distribution_function"]

_NODES = 400  # of the tables of energies and of speeds
_OUTERMOST = 1e4  # scale lengths to which the density is followed


def _density(profile: str, x: np.ndarray, edge: float) -> np.ndarray:
    """rho(x) without its factor, at x scale lengths."""
    if profile == "plummer":
        return 1 / ((1 + x * x) * (1 + x * x) * np.sqrt(1 + x * x))
    if profile == "hernquist":
        return 1 / (x * (1 + x) * (1 + x) * (1 + x))
    return exp(-(x / edge) * (x / edge)) / (x * (1 + x) * (1 + x))  # nfw, whose mass would be infinite


def _structure(profile: str, edge: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """x, rho, M and psi = -potential on a logarithmic grid outwards, for G = M(infinity) = scale = 1."""
    outermost = 20 * edge if profile == "nfw" else _OUTERMOST
    x = exp(np.linspace(log(1e-5), log(outermost), 8000))
    rho = _density(profile, x, edge)
    if profile == "plummer":
        psi = 1 / np.sqrt(1 + x * x)
        mass = x * x * x * psi * psi * psi
    elif profile == "hernquist":
        mass, psi = x / (1 + x) * (x / (1 + x)), 1 / (1 + x)
    else:
        shells = 4 * np.pi * rho * x * x * x  # dM / d ln x
        step = np.diff(log(x))
        mass = np.append(0.0, np.cumsum(0.5 * (shells[1:] + shells[:-1]) * step)) + 2 * np.pi * x[0] * x[0]
        rho, mass = rho / mass[-1], mass / mass[-1]
        falls = mass / x
        psi = 1 / x[-1] + np.append(np.cumsum((0.5 * (falls[1:] + falls[:-1]) * step)[::-1])[::-1], 0.0)
        return x, rho, mass, psi
    return x, rho * {"plummer": 3 / (4 * np.pi), "hernquist": 1 / (2 * np.pi)}[profile], mass, psi


def distribution_function(rho: np.ndarray, psi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eddington's f(E) of an isotropic sphere, the mass per volume and per velocity space at the energy E = psi - v^2 / 2.

    f(E) = 1 / (sqrt(8) pi^2) [integral from 0 to E of rho''(psi) / sqrt(E - psi) dpsi + rho'(0) / sqrt(E)]
    rho, psi : on a grid outwards. Returns energies, upwards, and f at them.
    rho' is taken as linear between the nodes, over which the integral is then exact.
    Source: Binney & Tremaine, Galactic Dynamics, section 4.3.1.
    """
    nodes = np.unique(np.linspace(0, len(psi) - 1, 2 * _NODES).astype(int))[::-1]
    E, slope = psi[nodes], np.gradient(rho, psi)[nodes]
    second = np.diff(slope) / np.diff(E)
    roots = np.sqrt(np.maximum(E[:, None] - E[None, :], 0.0))
    integral = (2 * second * (roots[:, :-1] - roots[:, 1:])).sum(1) + 2 * slope[0] / E[0] * (
        np.sqrt(E) - np.sqrt(np.maximum(E - E[0], 0))
    )
    return E, np.maximum(integral / (np.sqrt(8) * np.pi**2), 0.0)


@emitter("gravitating_sphere")
class GravitatingSphere(PlacedEmitter):
    """A sphere of bodies in equilibrium under their own gravity, isotropic, or colder than that.

    plummer    rho ~ (1 + x^2)^(-5/2), x = r / scale: clusters of stars
    hernquist  rho ~ 1 / (x (1 + x)^3): elliptical galaxies, bulges
    nfw        rho ~ exp(-(x / edge)^2) / (x (1 + x)^2): halos of dark matter
    uniform    the same density up to r = scale, with normal velocities: clouds that collapse
    Speeds are drawn from Eddington's distribution function f(E) of the profile, times sqrt(virial_ratio); those of `uniform` so
    that 2 T = virial_ratio abs(W). Without softening 2 T = abs(W) in equilibrium. The mass of each body is mass / n, and the
    centre of mass is at rest at the centre.
    edge : radius, in scale lengths, beyond which no bodies are drawn; the mass is that inside it
    Sources: Plummer (1911); Hernquist (1990), ApJ 356, 359; Navarro, Frenk & White (1996); Aarseth, Henon & Wielen (1974).
    """

    G: float = param(
        6.67430e-11, unit="m^3/(kg s^2)", min=0, doc="constant of gravitation; units.G of the preset when left out"
    )
    mass: float = param(1.0, unit="kg", min=0, doc="mass of all bodies")
    scale: float = param(1.0, unit="m", min=1e-30, doc="scale length")
    profile: str = param("plummer", choices=("plummer", "hernquist", "nfw", "uniform"))
    edge: float = param(20.0, min=0.5, max=1000, doc="radius of the edge, in scale lengths")
    virial_ratio: float = param(1.0, min=0, max=2, doc="1 is equilibrium, 0 is at rest")

    def sample(self, r, n):
        v = self.values
        radius, speed = self._uniform(r) if v["profile"] == "uniform" else self._isotropic(r)
        speed = speed * np.sqrt(v["virial_ratio"] * v["G"] * v["mass"] / v["scale"])
        born = {"position": radius * v["scale"] * r.sphere(5), "velocity": speed, "mass": np.full(n, v["mass"] / n)}
        for name in ("position", "velocity"):
            born[name] = born[name] - np.array([[math.fsum(row) / n] for row in born[name]])
        return self.placed(born)

    def _uniform(self, r):
        sigma = np.sqrt(1 / 5)  # 2 T = 3 M sigma^2 = 3 G M^2 / (5 R) = abs(W)
        return exp(log(np.maximum(r.uniform(1), 1e-300)) / 3), sigma * np.stack([r.normal(2), r.normal(3), r.normal(4)])

    def _isotropic(self, r):
        """Radii in scale lengths, and velocities in units of sqrt(G M / scale), with the mass M inside the edge."""
        edge = self.values["edge"]
        x, rho, mass, psi = _structure(self.values["profile"], edge)
        inside = np.interp(edge, x, mass)
        radius = exp(np.interp(r.uniform(1) * inside, mass, log(x)))
        E, f = distribution_function(rho, psi)
        levels = E[
            :: max(1, len(E) // _NODES)
        ]  # psi of a body; its speed has the density u^2 f(psi (1 - u^2)), u = v / v_escape
        u = np.linspace(0, 1, _NODES + 1)
        density = u * u * np.interp(levels[:, None] * (1 - u * u), np.append(0.0, E), np.append(0.0, f))
        share = np.concatenate(
            [np.zeros((len(levels), 1)), np.cumsum(0.5 * (density[:, 1:] + density[:, :-1]), axis=1)], axis=1
        )
        chances = np.linspace(0, 1, _NODES + 1)
        table = np.stack([np.interp(chances, row / row[-1], u) for row in share])
        depth = np.interp(radius, x, psi)
        level = np.interp(log(depth), log(levels), np.arange(len(levels)))
        chance = r.uniform(6) * _NODES
        i, j = np.minimum(level.astype(int), len(levels) - 2), np.minimum(chance.astype(int), _NODES - 1)
        a, b = level - i, chance - j
        low, high = table[i, j] * (1 - b) + table[i, j + 1] * b, table[i + 1, j] * (1 - b) + table[i + 1, j + 1] * b
        return radius, (low * (1 - a) + high * a) * np.sqrt(2 * depth / inside) * r.sphere(7)
