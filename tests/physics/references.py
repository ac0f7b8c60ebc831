"""One canonical instance of every force, and its formula written again in NumPy."""

import numpy as np

import gen_art as ga
from gen_art.forces.medium import Medium

F = ga.forces


def _column(v):
    return np.asarray(v, float)[:, None]


def _softened(p, center, soft):
    r = p.position - _column(center)
    return r, np.sqrt((r * r).sum(0) + soft**2)


def central(p):
    r, s = _softened(p, (0.1, 0.2, -0.3), 0.2)
    return -1.7 * s ** (-1.5 - 1) * r


def hernquist(p):
    r = p.position - _column((0.1, 0, 0))
    d = np.linalg.norm(r, axis=0)
    return -3.0 * r / (d * (d + 0.7) ** 2)


def spring(p):
    r = p.position - _column((0.1, 0.2, -0.3))
    d = np.linalg.norm(r, axis=0)
    return -2.5 * (d - 0.4) * r / d / p.mass


def point_gravity(p):
    r, s = _softened(p, (0.3, 0, 0), 0.1)
    return -2.0 * r / s**3


def vortex(p):
    n = np.array([0.0, 1.0, 0.0])
    r = p.position - _column((0.1, 0, 0))
    rho = r - np.outer(n, n @ r)
    return np.cross(n, rho.T).T * 3.0 / (2 * np.pi) / ((rho**2).sum(0) + 0.2**2)


def aperture(p):
    """Gradient of speed b atan(s) by central differences of the potential, s from oblate spheroidal coordinates."""

    def potential(x):
        y = x / 0.8
        z = y[2]
        d = (y * y).sum(0) - 1
        return 1.5 * 0.8 * np.arctan(np.sign(z) * np.sqrt(0.5 * (d + np.sqrt(d * d + 4 * z * z))))

    out, h = np.zeros_like(p.position), 1e-6
    for c in range(3):
        e = np.zeros((3, 1))
        e[c] = h
        out[c] = (potential(p.position + e) - potential(p.position - e)) / (2 * h)
    return out


def mirror(p):
    x, y, z = (p.position - _column((0, 0.1, 0))) / 1.3
    rho2 = x * x + z * z
    return 0.5 * np.stack([-x * y, 1 + y * y - 0.5 * rho2, -z * y])


def lift(p):
    n, w = np.array([0.2, 0.0, 3.0]), (p.velocity - p.flow).T
    across = np.cross(n, w)
    across /= np.linalg.norm(across, axis=1)[:, None]
    return (0.5 * 1.3 * (w * w).sum(1) * 0.6 * 0.8 * across.T) / p.mass


def panel(p):
    w, n = (p.velocity - p.flow).T, np.stack([p.normal_x, p.normal_y, p.normal_z], 1)
    speed = np.linalg.norm(w, axis=1)[:, None]
    way = w / speed
    sine = (way * n).sum(1)[:, None]
    lift = 1.7 * sine * (way * sine - n)
    drag = -(1.9 * sine**2 + 0.05 * (n * n).sum(1)[:, None]) * way
    return (0.5 * 1.3 * speed**2 * p.area[:, None] * (lift + drag)).T / p.mass


def aircraft(p):
    w = (p.velocity - p.flow).T
    speed = np.linalg.norm(w, axis=1)[:, None]
    ahead = w / speed
    up = np.array([0.0, 3.0, 4.0]) / 5
    above = up - (ahead @ up)[:, None] * ahead
    above /= np.linalg.norm(above, axis=1)[:, None]
    across = np.cos(0.3) * above + np.sin(0.3) * np.cross(ahead, above)
    lift = 4.5 * 0.1
    drag = 0.03 + lift**2 / (np.pi * 0.8 * 7.0)
    pressure = 0.5 * 1.3 * speed**2 * 0.6
    return ((pressure * lift * across - pressure * drag * ahead) + 0.4 * 2.0 * ahead).T / p.mass


def ballast(p):
    g = np.array([0.0, -3.0, -4.0])
    height = np.array([0.0, 0.6, 0.8]) @ p.position
    share = np.clip(0.5 + (0.1 - height) / 2.0, 0, 1)
    return -np.outer(g, 1.3 * (0.9 - 0.25 * 0.4) * share) / p.mass


def propeller(p):
    way = np.array([np.cos(0.2) * np.cos(0.7), np.sin(0.2), -np.cos(0.2) * np.sin(0.7)])
    return np.outer(way, 0.3 * 2.5 / p.mass)


def hand(p):
    share = (p.time - 0.5) / 0.5  # of the way from the row at 0.5 s to the one at 1 s
    r = p.position - _column((0.1 + share * 0.3, -0.2 - share * 0.5, 0.3))
    d = np.linalg.norm(r, axis=0)
    return -2.5 * np.maximum(d - 0.9, 0) * r / d / p.mass


def attractor(p):
    share = (p.time - 0.5) / 0.5  # of the way from the row at 0.5 s to the one at 1 s
    r, s = _softened(p, (0.1 + share * 0.3, -0.2 - share * 0.5, 0.3), 0.2)
    return (share - 0.25) * -1.7 * r / s**3


def thruster(p):
    share = (p.time - 0.5) / 0.5
    jets = np.array([share, 0.95, -0.3])
    return np.outer(2.5 * jets / np.linalg.norm(jets), 1 / p.mass)


def driver(p):
    n = np.array([1.0, 2.0, 2.0]) / 3.0
    return np.outer(n, 0.7 * np.cos(2 * np.pi * 1.3 * p.time + 0.4) / p.mass)


def _mixed(h):
    h = (h ^ (h >> 16)) * 0x85EBCA6B & 0xFFFFFFFF
    h = (h ^ (h >> 13)) * 0xC2B2AE35 & 0xFFFFFFFF
    return h ^ (h >> 16)


def random_driver(p, strength=1.4, time=0.6, seed=3, harmonics=5):
    key, out = p.key.astype(np.uint64), 0.0
    for k in range(harmonics):
        h = _mixed(_mixed(key[0] ^ np.uint64((seed * 64 + k) * 0x165667B1 & 0xFFFFFFFF)) ^ key[1])
        u = [((_mixed((h + c * 0x9E3779B9) & 0xFFFFFFFF) >> 8) + 0.5) / 2**24 for c in range(5)]
        w = np.sqrt(-2 * np.log(u[0])) * np.cos(2 * np.pi * u[1]) * np.sqrt(np.pi / 2) / time
        out = out + np.cos(w * p.time + 2 * np.pi * np.array(u[2:]))
    return strength * np.sqrt(2 / (3 * harmonics)) * out / p.mass


def flat_gravity(p):
    up = np.array([0.0, 0.6, 0.8])
    h = np.maximum(up @ (p.position - _column((0.1, 0, 0))), 0)
    return np.outer(up, -3.0) * (1.5 / (1.5 + h)) ** 2


def thrust(p):
    """Lit from 0.5 to 1.0 s of age; the probe's step is 0.1 s."""
    share = np.clip(np.minimum(p.age + 0.1, 1.0) - np.maximum(p.age, 0.5), 0, None) / 0.1
    return np.outer((0.6, 0.0, 0.8), 3.0 * 0.2 * share / p.mass)


GRID = np.random.default_rng(7).normal(size=(4, 3, 5, 3))
LOW, HIGH = np.array([-1.5, -1.0, -2.0]), np.array([1.0, 2.0, 1.5])


def sampled(p):
    """Trilinear blend, one axis after the other; nothing outside."""
    g = (p.position.T - LOW) / (HIGH - LOW) * (np.array(GRID.shape[:3]) - 1)
    out = np.zeros_like(g)
    for n, at in enumerate(g):
        if (at < 0).any() or (at > np.array(GRID.shape[:3]) - 1).any():
            continue
        block = GRID
        for c in range(3):  # each blend takes the first axis away
            k = min(int(at[c]), block.shape[0] - 2)
            block = block[k] * (1 - (at[c] - k)) + block[k + 1] * (at[c] - k)
        out[n] = block
    return 1.7 * out.T


def magnetic_dipole(p):
    m, r = np.array([0.4, -1.0, 0.7]) * 1e7, (p.position - _column((0.1, 0, 0))).T
    s2 = (r * r).sum(1)[:, None] + 0.3**2
    return 1e-7 * ((3 * (r @ m)[:, None] * r + (2 * 0.09 - (s2 - 0.09)) * m) / s2**2.5).T


def _from_axis(p, center, n):
    n = np.array(n) / np.linalg.norm(n)
    r = p.position - _column(center)
    z = n @ r
    return n, z, r - np.outer(n, z)


def magnetic_wire(p):
    n, _, rho = _from_axis(p, (0.1, 0, 0), (1.0, 2.0, 2.0))
    return np.cross(n, rho.T).T * 2e-7 * 3e6 / ((rho**2).sum(0) + 0.2**2)


def magnetic_loop(p):
    """Biot and Savart, summed around the loop: the trapezoidal rule converges exponentially."""
    n = np.array([0.0, 0.6, 0.8])
    e = np.array([1.0, 0, 0])
    phi = np.linspace(0, 2 * np.pi, 4000, endpoint=False)[:, None]
    at = np.array([0.1, 0, 0]) + 0.9 * (np.cos(phi) * e + np.sin(phi) * np.cross(n, e))
    dl = 0.9 * (-np.sin(phi) * e + np.cos(phi) * np.cross(n, e)) * 2 * np.pi / len(phi)
    r = p.position.T[:, None] - at
    return (1e-7 * 4e6 * np.cross(dl, r) / (np.linalg.norm(r, axis=2) ** 3)[..., None]).sum(1).T


def electric_dipole(p):
    d, r = np.array([0.4, -1.0, 0.7]), (p.position - _column((0.1, 0, 0))).T
    s = np.sqrt((r * r).sum(1) + 0.3**2)[:, None]
    return 8.9875517923 * (3 * (r @ d)[:, None] * r / s**5 - d / s**3).T * p.charge / p.mass


def electric_wire(p):
    _, _, rho = _from_axis(p, (0.1, 0, 0), (1.0, 2.0, 2.0))
    return 2 * 8.9875517923 * 0.7 * rho / ((rho**2).sum(0) + 0.2**2) * p.charge / p.mass


def electric_quadrupole(p):
    n, z, rho = _from_axis(p, (0.1, 0, 0), (1.0, 2.0, 2.0))
    return -3.0 / (2 * 0.8**2) * (2 * np.outer(n, z) - rho) * p.charge / p.mass


# name: (instance, what it gives, the NumPy formula); "push" is compared after multiplying fields by charge / mass
CASES = {
    "gravity": (F.Gravity((1.0, -9.81, 0.5)), "push", lambda p: np.tile(_column((1.0, -9.81, 0.5)), p.mass.size)),
    "height_gravity": (F.HeightGravity(3.0, 1.5, (0.1, 0.0, 0.0), (0.0, 3.0, 4.0)), "push", flat_gravity),
    "aircraft": (
        F.Aircraft(
            area=0.6, lift_slope=4.5, drag_coefficient=0.03, aspect_ratio=7.0, max_thrust=2.0, angle_of_attack=0.1, bank=0.3,
            throttle=0.4, up=(0.0, 3.0, 4.0), density=1.3,
        ),
        "push",
        aircraft,
    ),
    "ballast": (
        F.Ballast(volume=0.9, tanks=0.4, flooded=0.25, density=1.3, gravity=(0.0, -3.0, -4.0), surface=0.1, height=2.0),
        "push",
        ballast,
    ),
    "panel": (F.Panel(lift=1.7, drag=1.9, friction=0.05, density=1.3), "push", panel),
    "propeller": (F.Propeller(max_thrust=2.5, throttle=0.3, heading=0.7, pitch=0.2), "push", propeller),
    "hand": (
        F.Hand({"time": [0.0, 0.5, 1.0], "x": [0, 0.1, 0.4], "y": [3.0, -0.2, -0.7]}, stiffness=2.5, rest_length=0.9, z=0.3),
        "push",
        hand,
    ),
    "attractor": (
        F.Attractor(
            {"time": [0.0, 0.5, 1.0], "x": [0, 0.1, 0.4], "y": [3.0, -0.2, -0.7], "pull": [1, -0.25, 0.75]},
            GM=1.7, softening=0.2, pull=0.5, z=0.3,
        ),
        "push",
        attractor,
    ),
    "thruster": (F.Thruster({"time": [0.0, 0.5, 1.0], "x": [0, 0, 1]}, max_thrust=2.5, y=0.95, z=-0.3), "push", thruster),
    "lift": (F.Lift(0.8, 0.6, (0.2, 0.0, 3.0), 1.3), "push", lift),
    "thrust": (F.Thrust((3.0, 0.0, 4.0), 3.0, 0.2, 0.5, 0.5), "push", thrust),
    "vector_field": (F.VectorField(GRID, (LOW, HIGH), 1.7), "push", sampled),
    "magnetic_dipole": (F.MagneticDipole((4e6, -1e7, 7e6), (0.1, 0.0, 0.0), 0.3), "magnetic", magnetic_dipole),
    "magnetic_wire": (F.MagneticWire(3e6, (0.1, 0.0, 0.0), (1.0, 2.0, 2.0), 0.2), "magnetic", magnetic_wire),
    "magnetic_loop": (F.MagneticLoop(4e6, 0.9, (0.1, 0.0, 0.0), (0.0, 3.0, 4.0)), "magnetic", magnetic_loop),
    "magnetic_grid": (F.MagneticGrid(GRID, (LOW, HIGH), 1.7), "magnetic", sampled),
    "electric_dipole": (F.ElectricDipole((4e-10, -1e-9, 7e-10), (0.1, 0.0, 0.0), 0.3), "push", electric_dipole),
    "electric_wire": (F.ElectricWire(0.7e-9, (0.1, 0.0, 0.0), (1.0, 2.0, 2.0), 0.2), "push", electric_wire),
    "electric_quadrupole": (
        F.ElectricQuadrupole(3.0, 0.8, (0.1, 0.0, 0.0), (1.0, 2.0, 2.0)), "push", electric_quadrupole
    ),
    "electric_grid": (F.ElectricGrid(GRID, (LOW, HIGH), 1.7), "push", lambda p: sampled(p) * p.charge / p.mass),
    "driver": (F.Driver(0.7, 1.3, 0.4, (1.0, 2.0, 2.0)), "push", driver),
    "random_driver": (F.RandomDriver(1.4, 0.6, 3, 5), "push", random_driver),
    "wind": (F.Wind((1.0, 2.0, 3.0)), "push", lambda p: np.tile(_column((1.0, 2.0, 3.0)), p.mass.size)),
    "drag": (
        F.Drag(linear=0.3, quadratic=0.2, cd=0.5, density=1.2),
        "damping",
        lambda p: np.stack([0.3 / p.mass, (0.2 + 0.5 * 1.2 * 0.5 * np.pi * p.radius**2) / p.mass]),
    ),
    "langevin": (
        F.Langevin(300.0, 0.4), "damping", lambda p: np.stack([np.full(p.mass.size, 0.4), np.zeros(p.mass.size)])
    ),
    "damping": (F.Damping(0.7), "damping", lambda p: np.stack([np.full(p.mass.size, 0.7), np.zeros(p.mass.size)])),
    "buoyancy": (
        F.Buoyancy(1.3, (0.0, -9.0, 1.0)),
        "push",
        lambda p: -1.3 * 4 / 3 * np.pi * p.radius**3 / p.mass * _column((0.0, -9.0, 1.0)),
    ),
    "thermal_lift": (
        F.ThermalLift(400.0, 300.0, 0.8, 290.0),
        "push",
        lambda p: np.outer((0, 9.81, 0), (300 + 100 * np.exp(-p.age / 0.8)) / 290.0 - 1),
    ),
    "spring": (F.Spring((0.1, 0.2, -0.3), 2.5, 0.4), "push", spring),
    "central_force": (F.CentralForce((0.1, 0.2, -0.3), 1.7, -1.5, 0.2), "push", central),
    "point_gravity": (F.PointGravity((0.3, 0.0, 0.0), 2.0, 0.1), "push", point_gravity),
    "hernquist": (F.Hernquist(3.0, 0.7, (0.1, 0.0, 0.0)), "push", hernquist),
    "vortex": (F.Vortex((0.1, 0.0, 0.0), (0.0, 2.0, 0.0), 3.0, 0.2), "push", vortex),
    "aperture": (F.Aperture(1.5, 0.8), "push", aperture),
    "curl_noise": (F.CurlNoise(1.2, 0.6, 0.8, 3), "noise", None),
    "electric_field": (
        F.ElectricField((1.0, 2.0, -3.0)), "push", lambda p: _column((1.0, 2.0, -3.0)) * p.charge / p.mass
    ),
    "magnetic_field": (F.MagneticField((1.0, 2.0, -3.0)), "magnetic", lambda p: np.tile(_column((1.0, 2.0, -3.0)), p.mass.size)),
    "magnetic_mirror": (F.MagneticMirror(0.5, 1.3, (0.0, 0.1, 0.0), (0.0, 3.0, 0.0)), "magnetic", mirror),
}  # fmt: skip

STILL = Medium()
