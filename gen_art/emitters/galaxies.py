"""Initial conditions of a disc galaxy in near-equilibrium: an exponential disc and a Hernquist sphere, inside a halo.

Both need the mass of all three components for their circular speed: Freeman's for the disc, Hernquist's for bulge and halo.
Sources: Freeman (1970), ApJ 160, 811; Hernquist (1993), ApJS 86, 389; Abramowitz & Stegun 9.8 (Bessel).
"""

import numpy as np

from gen_art.emitters.base import emitter
from gen_art.emitters.discs import disc_bodies, frequencies
from gen_art.emitters.placed import PlacedEmitter
from gen_art.errors import UsageError
from gen_art.maths.array_functions import cos, exp, log, sin
from gen_art.registry import param

__all__ = ["ExponentialDisc", "GalaxyHalo", "HernquistSphere"]


def bessel_products(y: np.ndarray) -> np.ndarray:
    """I0(y) K0(y) - I1(y) K1(y) for y > 0, to 1e-6: the shape of Freeman's rotation curve."""
    y = np.asarray(y, float)
    small, large = np.minimum(y, 2.0), np.maximum(y, 2.0)
    t = (y / 3.75) ** 2
    i0s = np.polyval([0.0045813, 0.0360768, 0.2659732, 1.2067492, 3.0899424, 3.5156229, 1.0], t)
    i1s = y * np.polyval([0.00032411, 0.00301532, 0.02658733, 0.15084934, 0.51498869, 0.87890594, 0.5], t)
    u = 3.75 / np.maximum(y, 3.75)
    i0l = np.polyval(
        [0.00392377, -0.01647633, 0.02635537, -0.02057706, 0.00916281, -0.00157565, 0.00225319, 0.01328592, 0.39894228],
        u,
    )
    i1l = np.polyval(
        [
            -0.00420059,
            0.01787654,
            -0.02895312,
            0.02282967,
            -0.01031555,
            0.00163801,
            -0.00362018,
            -0.03988024,
            0.39894228,
        ],
        u,
    )
    far = np.maximum(y, 3.75)
    root = np.sqrt(far)
    h = (small / 2) ** 2
    log_half = log(small / 2)
    i0k, i1k = np.where(y < 3.75, i0s, 0), np.where(y < 3.75, i1s, 0)
    k0s = -log_half * i0k + np.polyval(
        [0.0000074, 0.0001075, 0.00262698, 0.0348859, 0.23069756, 0.4227842, -0.57721566], h
    )
    k1s = log_half * i1k + (1 / small) * np.polyval(
        [-0.00004686, -0.00110404, -0.01919402, -0.18156897, -0.67278579, 0.15443144, 1.0], h
    )
    v = 2 / large
    k0l = np.polyval([0.00053208, -0.0025154, 0.00587872, -0.01062446, 0.02189568, -0.07832358, 1.25331414], v)
    k1l = np.polyval([-0.00068245, 0.00325614, -0.00780353, 0.01504268, -0.0365562, 0.23498619, 1.25331414], v)
    decay = exp(-large) / np.sqrt(large)
    near = np.where(y <= 2.0, i0s * k0s - i1s * k1s, (i0s * k0l - i1s * k1l) * decay)
    return np.where(y < 3.75, near, (i0l * k0l - i1l * k1l) / (root * np.sqrt(large)))


class _Galaxy(PlacedEmitter):
    """The masses and scales of a galaxy's components, and its circular speed."""

    G: float = param(4.30091e-6, min=0, doc="constant of gravitation in the preset's units")
    disc_mass: float = param(4e10, min=0, doc="mass of the disc")
    disc_scale: float = param(3.0, min=1e-30, doc="scale length of the disc")
    bulge_mass: float = param(1e10, min=0, doc="mass of the bulge")
    bulge_scale: float = param(0.5, min=1e-30, doc="Hernquist's scale of the bulge")
    halo_mass: float = param(1e12, min=0, doc="mass of the halo")
    halo_scale: float = param(30.0, min=1e-30, doc="Hernquist's scale of the halo")

    @property
    def total_mass(self) -> float:
        return sum(self.values[f"{part}_mass"] for part in ("disc", "bulge", "halo"))

    def circular_speed_squared(self, R: np.ndarray) -> np.ndarray:
        """v_c^2(R) = G M y^2 2 (I0 K0 - I1 K1) / R_d + the two Hernquist spheres, y = R / (2 R_d)."""
        v = self.values
        y = R / (2 * v["disc_scale"])
        disc = 2 * v["G"] * v["disc_mass"] / v["disc_scale"] * y * y * bessel_products(np.maximum(y, 1e-6))
        spheres = sum(v["G"] * v[f"{part}_mass"] * R / (R + v[f"{part}_scale"]) ** 2 for part in ("bulge", "halo"))
        return disc + spheres


@emitter("exponential_disc")
class ExponentialDisc(_Galaxy):
    """A disc of stars: exponential, of a given thickness and a chosen Toomre Q.

    Sigma = disc_mass / (2 pi R_d^2) exp(-R / R_d), R_d = disc_scale
    across the disc sech^2(z / z_0), z_0 = thickness
    sigma_R = Q 3.36 G Sigma / kappa, sigma_phi = sigma_R kappa / (2 Omega), sigma_z^2 = pi G Sigma z_0
    The mean rotation is reduced by the asymmetric drift. The mass of each particle is that inside
    the edge times share / n, or 0 if massless: gas and stars of one disc are several emitters.
    With `arms`, the azimuths are shifted towards logarithmic spirals at constant R:
    phi += -(arm_strength / arms) sin(arms (phi - ln(R / R_d) / tan pitch))
    Source: Hernquist (1993), ApJS 86, 389; Toomre (1964), ApJ 139, 1217.
    """

    thickness: float = param(0.3, min=0, doc="scale height z_0")
    toomre_q: float = param(1.3, min=0, max=10, doc="Toomre's Q: below 1 the disc breaks into clumps")
    share: float = param(1.0, min=0, max=1, doc="the part of the disc's mass that these particles have together")
    massless: bool = param(False, doc="test particles without mass")
    edge: float = param(6.0, min=0.5, max=50, doc="radius of the edge, in scale lengths")
    arms: int = param(0, min=0, max=12, doc="seeded spiral arms")
    arm_strength: float = param(0.0, min=0, max=1, doc="how strongly the arms are seeded")
    pitch: float = param(0.35, unit="rad", min=0.02, max=1.5, doc="angle between arms and circles")

    def sample(self, r, n):
        v = self.values
        scale = v["disc_scale"]
        x = np.linspace(0, v["edge"], 4001)
        mass_fraction = 1 - (1 + x) * exp(-x)
        R = np.maximum(np.interp(r.uniform(1) * mass_fraction[-1], mass_fraction, x), 1e-4) * scale
        phi = 2 * np.pi * r.uniform(2)
        if v["arms"]:
            tangent = sin(v["pitch"]) / cos(v["pitch"])
            phase = v["arms"] * (phi + log(R / scale) / tangent)
            amplitude = v["arm_strength"] * np.clip(R / scale - 0.4, 0, 1)
            phi = phi - amplitude / v["arms"] * sin(phase)
        sigma = v["disc_mass"] / (2 * np.pi * scale * scale) * exp(-R / scale)
        known = frequencies(self.circular_speed_squared, scale, v["edge"], R)
        born = disc_bodies(r, R, phi, sigma, -R / scale, known, v["thickness"], v["toomre_q"], v["G"])
        inside = 0.0 if v["massless"] else v["share"] * v["disc_mass"] * mass_fraction[-1]
        return self.placed({**born, "mass": np.full(n, inside / n)})


class _HernquistPart(_Galaxy):
    """A Hernquist sphere of a galaxy, with isotropic velocities from Jeans's equation in the whole galaxy's field."""

    part = "bulge"
    edge: float = param(20.0, min=1, max=1000, doc="radius of the edge, in scale lengths")

    def sample(self, r, n):
        v = self.values
        mass, a, edge = v[f"{self.part}_mass"], v[f"{self.part}_scale"], v["edge"]
        if mass <= 0:
            raise UsageError(f"{self.name} needs a {self.part}_mass above 0")
        root = np.sqrt(r.uniform(1)) * (edge / (1 + edge))
        radius = np.maximum(a * root / (1 - root), 1e-4 * a)
        grid = a * exp(np.linspace(log(1e-4), log(200 * edge), 4000))
        rho = 1 / (grid * (grid + a) * (grid + a) * (grid + a))
        acceleration = self.circular_speed_squared(grid) / grid
        areas = 0.5 * (rho[1:] * acceleration[1:] + rho[:-1] * acceleration[:-1]) * np.diff(grid)
        pressure = np.append(np.cumsum(areas[::-1])[::-1], 0.0)
        drops = 0.5 * (acceleration[1:] + acceleration[:-1]) * np.diff(grid)
        potential_drop = np.append(np.cumsum(drops[::-1])[::-1], 0.0)
        sigma = np.sqrt(np.interp(radius, grid, pressure / rho))
        velocity = sigma * np.stack([r.normal(2), r.normal(3), r.normal(4)])
        speed_limit = 0.95 * np.sqrt(2 * np.interp(radius, grid, potential_drop))
        speed = np.maximum(np.linalg.norm(velocity, axis=0), 1e-30)
        return self.placed(
            {
                "position": radius * r.sphere(5),
                "velocity": velocity * np.minimum(1.0, speed_limit / speed),
                "mass": np.full(n, mass * (edge / (1 + edge)) ** 2 / n),
            }
        )


@emitter("hernquist_sphere")
class HernquistSphere(_HernquistPart):
    """The bulge of a galaxy, after Hernquist.

    rho ~ a / (r (r + a)^3), a = bulge_scale
    sigma^2(r) = (1 / rho) integral from r of rho v_c^2 / r dr, with the circular speed v_c of the whole galaxy
    Each velocity component is normal with this sigma; speeds are limited to 0.95 of the local escape speed.
    The mass of each particle is that inside the edge, bulge_mass (edge / (1 + edge))^2, over n.
    Source: Hernquist (1990), ApJ 356, 359.
    """


@emitter("galaxy_halo")
class GalaxyHalo(_HernquistPart):
    """The halo of a galaxy as bodies: with exponential_disc and hernquist_sphere, a galaxy without a fixed field.

    The same as hernquist_sphere, with halo_mass and a = halo_scale.
    Source: Hernquist (1993), ApJS 86, 389.
    """

    part = "halo"
