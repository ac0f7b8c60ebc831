"""Gases of spheres, long: an elastic one in a box comes to Maxwell's speeds, an inelastic one cools by Haff's law."""

import math

import numpy as np
import pytest

import gen_art as ga

Contacts = ga.interactions.Contacts


def lattice(per_side, side, seed, jitter=0.0):
    """per_side^3 places in a cube about the origin."""
    r = np.random.default_rng(seed)
    at = (np.arange(per_side) + 0.5) / per_side * side - side / 2
    x = np.stack(np.meshgrid(at, at, at), -1).reshape(-1, 3)
    return x + r.uniform(-jitter, jitter, x.shape), r


def kolmogorov_smirnov(values, cdf):
    """p of the largest distance between the distribution of the values and a given one (Kolmogorov's limit)."""
    values = np.sort(values)
    n = len(values)
    steps = np.arange(n + 1) / n
    at = np.array([cdf(v) for v in values])
    d = max((steps[1:] - at).max(), (at - steps[:-1]).max())
    t = (math.sqrt(n) + 0.12 + 0.11 / math.sqrt(n)) * d
    return 2 * sum((-1) ** (k - 1) * math.exp(-2 * k * k * t * t) for k in range(1, 100))


@pytest.mark.proof
@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-11), ("f32", 1e-6)])
def test_an_elastic_gas_comes_to_maxwells_distribution(precision, tolerance):
    """A thousand spheres of one speed; after some ten collisions each, every component is normal; the walls' impulse is booked.

    In float32 a thousand momenta of 1 N s are rounded in 3600 kicks: sqrt(3.6e6) eps = 1e-4 N s of their sum.
    """
    side = 1.75
    x, r = lattice(10, side, 5)
    v = r.normal(size=x.shape)
    v /= np.linalg.norm(v, axis=1)[:, None]
    walls = ga.colliders.Box(min=(-side / 2,) * 3, max=(side / 2,) * 3, restitution=1.0)
    system = ga.ParticleSystem(
        position=x, velocity=v, radius=0.05, colliders=[walls], interactions=[Contacts(restitution=1.0, duration=5e-3)],
        integrator="leapfrog",
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=2.5e-4, precision=precision, ledger=True)
    start = sim.diagnostics()
    sim.step(3600)
    end, account = sim.diagnostics(), sim.ledger()
    assert end.kinetic_energy + end.potential_energy == pytest.approx(start.energy, rel=5e-3)
    moved = account.impulse["s.box"]
    assert np.abs(moved).max() > 1 and np.abs(end.momentum - start.momentum - moved).max() < tolerance * 1000
    width = math.sqrt(2 * end.kinetic_energy / 3 / len(x))

    def normal(u):
        return 0.5 * (1 + math.erf(u / width / math.sqrt(2)))

    for c in range(3):
        assert kolmogorov_smirnov(sim["s"].velocity[:, c], normal) > 0.01
        assert kolmogorov_smirnov(v[:, c], normal) < 0.01  # the same test refuses the speeds of the start


def restitution_met(e, dt, T):
    """Speed after over before of two spheres, the mean over where in a step they meet."""
    found = []
    for k in range(8):
        system = ga.ParticleSystem(
            position=[[-0.051 - k * dt / 8, 0, 0], [0.051, 0, 0]], velocity=[[1.0, 0, 0], [-1.0, 0, 0]], radius=0.05,
            interactions=[Contacts(restitution=e, duration=T)], integrator="leapfrog",
        )  # fmt: skip
        sim = ga.Simulation({"s": system}, dt=dt, precision="f64")
        sim.step(round(3 * T / dt))
        found.append(np.diff(sim["s"].velocity[:, 0])[0] / 2)
    return float(np.mean(found))


def kept(q):
    """The share of directions from a place in a cube, d away for d = q sides, that end in it too, over all places: what
    collisions walls leave of those of a gas without them. The mean of (1 - q abs(x)) (1 - q abs(y)) (1 - q abs(z)) over the
    sphere: 1/2, 2 / (3 pi) and 1 / (4 pi) are the means of abs(x), abs(x y) and abs(x y z)."""
    return 1 - 3 * q / 2 + 2 / math.pi * q**2 - q**3 / (4 * math.pi)


def test_what_walls_leave_of_collisions():
    r = np.random.default_rng(0)
    way = r.normal(size=(200_000, 3))
    there = r.uniform(size=way.shape) + 0.2 * way / np.linalg.norm(way, axis=1)[:, None]
    assert ((there > 0) & (there < 1)).all(1).mean() == pytest.approx(kept(0.2), abs=4e-3)
    assert kept(0.2) < 0.75


@pytest.mark.proof
def test_a_granular_gas_cools_by_haffs_law():
    """T = T0 / (1 + t / tau)^2 within 3 % (0.8 % measured), and tau within 3 % of kinetic theory:

    1/tau = (1 - e^2) nu / 6, nu = 4 n d^2 g sqrt(pi T0 / m), n in the volume the centres may take, g = (1 - phi/2) / (1 - phi)^3,
    times 1 + 3 a2 / 16 for speeds that are not Maxwell's (van Noije and Ernst 1998), a2 = 16 (1 - e) (1 - 2 e^2) /
    (81 - 17 e + 30 e^2 (1 - e)), times what the walls leave of the collisions, 0.956 here: the sphere beside a wall meets no one on
    that side. Contacts that last take of the rate 1.2 % a millisecond at 8 collisions a second (14,000 spheres: 4.4 % at
    4 ms, 2.1 % at 2 ms, 0.9 % at 1 ms: none at no length), so they are short here. Of 20,000 collisions the noise is 1 %.
    """
    e, d, dt, T = 0.85, 0.1, 1.25e-4, 1e-3
    per_side, side = 16, 10 / 3 + d
    x, r = lattice(per_side, side - d, 3)
    v = r.normal(size=x.shape)
    v -= v.mean(0)
    v /= math.sqrt((v**2).mean())
    walls = ga.colliders.Box(min=(-side / 2,) * 3, max=(side / 2,) * 3, restitution=1.0)
    system = ga.ParticleSystem(
        position=x, velocity=v, radius=d / 2, colliders=[walls], interactions=[Contacts(restitution=e, duration=T)],
        integrator="leapfrog",
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=dt)
    sim.step(2400)  # from the lattice to a gas
    times, temperatures = [], []
    for _ in range(12):
        times.append(sim.time)
        temperatures.append(2 * sim.diagnostics().kinetic_energy / 3 / len(x))
        sim.step(1000)
    times, temperatures = np.array(times) - times[0], np.array(temperatures)
    n = len(x) / (side - d) ** 3
    phi = n * math.pi / 6 * d**3
    g = (1 - phi / 2) / (1 - phi) ** 3
    met = restitution_met(e, dt, T)
    a2 = 16 * (1 - e) * (1 - 2 * e**2) / (81 - 17 * e + 30 * e**2 * (1 - e))
    free = (1 - met**2) / 6 * 4 * n * d**2 * g * math.sqrt(math.pi * temperatures[0]) * (1 + 3 * a2 / 16)
    slope, start = np.polyfit(times, temperatures**-0.5, 1)  # the law is a straight line
    law = (start + slope * times) ** -2
    assert temperatures[-1] < 0.5 * temperatures[0]
    assert np.abs(temperatures / law - 1).max() < 0.03
    assert slope / start == pytest.approx(free * kept(d / (side - d)), rel=0.03)
    assert slope / start != pytest.approx(free, rel=0.03)  # the mutant: a gas without walls

    def from_exponential(values):
        fall, first = np.polyfit(times, np.log(values), 1)
        return np.abs(values / np.exp(first + fall * times) - 1).max()

    # an exponential fits worse by far, and as badly as it fits the law itself, to the noise
    assert from_exponential(temperatures) > 2.5 * np.abs(temperatures / law - 1).max()
    assert from_exponential(temperatures) == pytest.approx(from_exponential(law), abs=0.01)
