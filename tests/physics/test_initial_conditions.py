"""Groups of bodies that hold together: where they are and how fast, against the formulas that they are drawn from."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.emitters import GalaxyHalo, GravitatingSphere, KeplerRings, KuzminDisc, two_body_orbit
from gen_art.emitters.gravitating_spheres import _structure, distribution_function
from tests.physics.test_galaxies import deviation

N = 20_000


def energies(drawn, G=1.0):
    """T and W of bodies, by all pairs."""
    x, v, m = drawn["position"], drawn["velocity"], drawn["mass"]
    potential = 0.0
    for i in range(0, len(x), 500):
        d = np.sqrt(((x[i : i + 500, None] - x[None]) ** 2).sum(2))
        d[np.arange(len(d)), i + np.arange(len(d))] = np.inf
        potential -= 0.5 * G * (m[i : i + 500, None] * m[None] / d).sum()
    return 0.5 * (m * (v * v).sum(1)).sum(), potential


def nfw(x, edge):
    """M(x) of the profile with its cut, by a fine sum."""
    fine = np.linspace(0, 8 * edge, 400_001)[1:]
    shell = fine / (1 + fine) ** 2 * np.exp(-((fine / edge) ** 2))
    return np.interp(x, fine, np.cumsum(shell))


MASS = {
    "plummer": lambda x, edge: (x / np.sqrt(1 + x * x)) ** 3,
    "hernquist": lambda x, edge: (x / (1 + x)) ** 2,
    "nfw": nfw,
    "uniform": lambda x, edge: np.minimum(x, 1) ** 3,
}


@pytest.mark.parametrize("profile", MASS)
def test_bodies_of_a_sphere_lie_where_its_profile_says(profile):
    edge = 10.0
    drawn = GravitatingSphere(G=1.0, mass=3.0, scale=2.0, profile=profile, edge=edge).arrays(N)
    x = np.sqrt((drawn["position"] ** 2).sum(1)) / 2.0
    inside = MASS[profile](edge, edge)
    assert deviation(x, lambda y: MASS[profile](y, edge) / inside) < 1.95
    assert deviation(x, lambda y: MASS[profile](y / 1.05, edge) / inside) > 1.95  # the mutant: another scale
    assert drawn["mass"].sum() == pytest.approx(3.0, rel=1e-12)
    assert np.abs(drawn["position"].mean(0)).max() < 1e-12 and np.abs(drawn["velocity"].mean(0)).max() < 1e-12


@pytest.mark.parametrize("profile", MASS)
def test_a_sphere_is_in_equilibrium_and_isotropic(profile):
    """2 T = abs(W): the sum over n bodies errs by about 2 / sqrt(n). Mutant: virial_ratio, which is the ratio itself."""
    n, noise = 8000, 4 / np.sqrt(8000)
    sphere = {"G": 2.0, "mass": 3.0, "scale": 0.5, "profile": profile, "edge": 50.0}
    drawn = GravitatingSphere(**sphere).arrays(n, seed=1)
    kinetic, potential = energies(drawn, 2.0)
    assert 2 * kinetic / abs(potential) == pytest.approx(1, abs=noise)
    slower = energies(GravitatingSphere(**sphere, virial_ratio=0.5).arrays(n, seed=1), 2.0)[0]
    assert slower == pytest.approx(0.5 * kinetic, rel=1e-9)
    directions = drawn["position"] / np.sqrt((drawn["position"] ** 2).sum(1))[:, None]
    radial = ((drawn["velocity"] * directions).sum(1) ** 2).mean()
    assert 3 * radial == pytest.approx((drawn["velocity"] ** 2).sum(1).mean(), rel=3 * noise)


def test_distribution_functions_are_those_in_closed_form():
    """Plummer's f = 24 sqrt(2) / (7 pi^3) E^(7/2), and Hernquist's (1990), equation 17; to 1% where there are bodies."""
    E, f = distribution_function(*[_structure("plummer", 20.0)[k] for k in (1, 3)])
    inner = (E > 0.05) & (E < 0.97)
    assert np.allclose(f[inner], 24 * np.sqrt(2) / (7 * np.pi**3) * E[inner] ** 3.5, rtol=0.01)
    E, f = distribution_function(*[_structure("hernquist", 20.0)[k] for k in (1, 3)])
    inner = (E > 0.03) & (E < 0.97)
    q = np.sqrt(E[inner])
    exact = (
        (3 * np.arcsin(q) + q * np.sqrt(1 - q * q) * (1 - 2 * q * q) * (8 * q**4 - 8 * q * q - 3))
        / (1 - q * q) ** 2.5 / (8 * np.sqrt(2) * np.pi**3)
    )  # fmt: skip
    assert np.allclose(f[inner], exact, rtol=0.01)
    assert not np.allclose(1.03 * f[inner], exact, rtol=0.01)  # the mutant


def test_speeds_are_drawn_from_the_distribution_function():
    """In a shell of a Plummer sphere u = v / v_escape has the density u^2 (1 - u^2)^(7/2). Mutant: another power."""
    drawn = GravitatingSphere(G=1.0, edge=500.0).arrays(60_000)
    x = np.sqrt((drawn["position"] ** 2).sum(1))
    shell = (x > 0.6) & (x < 1.2)
    u = np.sqrt((drawn["velocity"] ** 2).sum(1)) / np.sqrt(2 / np.sqrt(1 + x * x))
    fine = np.linspace(0, 1, 20_001)

    def share(power):
        density = fine**2 * (1 - fine**2) ** power
        whole = np.cumsum(density)
        return lambda y: np.interp(y, fine, whole / whole[-1])

    assert shell.sum() > 15_000
    assert deviation(u[shell], share(3.5)) < 1.95
    assert deviation(u[shell], share(3.0)) > 1.95


def test_kuzmins_disc():
    """Sigma, the circular speed, and Toomre's Q in a ring. Mutants: half the scale, twice Q."""
    disc = {"G": 1.0, "mass": 2.0, "scale": 0.5, "thickness": 0.02, "edge": 20.0}
    cold = KuzminDisc(**disc, toomre_q=0.05).arrays(N)
    x, v = cold["position"], cold["velocity"]
    R = np.hypot(x[:, 0], x[:, 2])
    inside = 1 - 1 / np.sqrt(1 + 20.0**2)
    assert deviation(R, lambda y: (1 - 0.5 / np.sqrt(y * y + 0.25)) / inside) < 1.95
    assert deviation(R, lambda y: (1 - 0.25 / np.sqrt(y * y + 0.0625)) / inside) > 1.95
    turning = (x[:, 2] * v[:, 0] - x[:, 0] * v[:, 2]) / R
    ring = np.abs(R - 0.7) < 0.03
    assert turning[ring].mean() == pytest.approx(np.sqrt(2 * 0.7**2 / (0.7**2 + 0.25) ** 1.5), rel=0.01)
    warm = KuzminDisc(**disc, toomre_q=1.2).arrays(200_000)
    x, v = warm["position"], warm["velocity"]
    R = np.hypot(x[:, 0], x[:, 2])
    ring = np.abs(R - 1.0) < 0.02
    outwards = ((x[:, 0] * v[:, 0] + x[:, 2] * v[:, 2]) / R)[ring].std()
    sigma, omega2 = 2 * 0.5 / (2 * np.pi * 1.25**1.5), 2 / 1.25**1.5
    kappa = np.sqrt(4 * omega2 - 3 * omega2 / 1.25)  # kappa^2 = 4 Omega^2 + R d(Omega^2) / dR
    assert outwards * kappa / (3.36 * sigma) == pytest.approx(1.2, rel=0.05)


def test_rings_turn_on_circles_about_their_centre():
    """After a third of a turn every body is as far out as before, in a plane across the axis. Mutant: a speed without the root."""
    rings = KeplerRings(
        G=1.0, central_mass=2.0, inner=1.0, outer=2.0, rings=3, axis=(1, 1, 0), center=(3, 0, 0), drift=(0, 0, 0.1)
    )
    drawn = rings.arrays(300)
    pull = ga.forces.PointGravity(GM=2.0, center=(3, 0, 0))
    drawn["velocity"] = drawn["velocity"] - [0, 0, 0.1]
    system = ga.ParticleSystem(position=drawn["position"], velocity=drawn["velocity"], forces=[pull])
    sim = ga.Simulation({"s": system}, dt=0.002, precision="f64")
    before = np.sqrt(((sim["s"].position - [3, 0, 0]) ** 2).sum(1))
    assert set(np.round(before, 9)) == {1.0, 1.5, 2.0}
    sim.step(1000)
    after = sim["s"].position - [3, 0, 0]
    assert np.allclose(np.sqrt((after**2).sum(1)), before, rtol=1e-5)
    assert np.abs(after @ [1, 1, 0]).max() < 1e-9
    turning = np.cross(after, sim["s"].velocity)
    assert (turning @ [1, 1, 0] > 0).all()


def test_even_rings_have_no_noise_in_any_sector():
    """Of 16 x 16 cells of equal mass each has its share: within a few bodies instead of the square root of their number."""

    def counts(**more):
        drawn = KeplerRings(G=1.0, inner=1.0, outer=3.0, **more).arrays(65_536)
        x, _, z = drawn["position"].T
        cell = np.floor(2 * (x * x + z * z - 1)), np.floor((np.arctan2(-z, x) / (2 * np.pi) % 1) * 16)
        return np.bincount((16 * np.clip(cell[0], 0, 15) + cell[1]).astype(int), minlength=256)

    assert counts().std() > 12  # at random: 16
    assert counts(even=True).std() < 4


def test_even_circles_are_evenly_filled():
    drawn = KeplerRings(G=1.0, inner=1.0, outer=2.0, rings=8, even=True).arrays(8 * 500)
    x, _, z = drawn["position"].T
    radius, angle = np.hypot(x, z), np.arctan2(-z, x) % (2 * np.pi)
    for circle in np.unique(radius.round(4)):
        around = np.sort(angle[np.abs(radius - circle) < 1e-3])
        assert len(around) == 500
        assert np.diff(around) == pytest.approx(2 * np.pi / 500, rel=1e-2)


@pytest.mark.parametrize("eccentricity", [0.5, 1.0, 1.7])
def test_an_encounter_comes_as_close_as_its_pericenter(eccentricity):
    """Two groups on one orbit, as points: their centre of mass rests, and their smallest distance is the pericenter."""
    meeting = {"G": 1.0, "pericenter": 1.5, "eccentricity": eccentricity, "separation": 4.0}
    one = KeplerRings(**meeting, central_mass=3.0, companion=1.0).whole_motion()
    two = KeplerRings(**meeting, central_mass=1.0, companion=3.0, second=True).whole_motion()
    assert np.allclose(3 * one[0] + two[0], 0, atol=1e-12) and np.allclose(3 * one[1] + two[1], 0, atol=1e-12)
    system = ga.ParticleSystem(
        position=[one[0], two[0]], velocity=[one[1], two[1]], mass=[3.0, 1.0],
        interactions=[ga.interactions.SelfGravity(G=1.0)], integrator="yoshida4",
    )  # fmt: skip
    sim = ga.Simulation({"s": system}, dt=0.004, precision="f64")
    distances = []
    for _ in range(2500):
        sim.step(1)
        distances.append(np.linalg.norm(sim["s"].position[1] - sim["s"].position[0]))
    assert distances[0] < 4.0 and min(distances) == pytest.approx(1.5, rel=1e-5)
    assert np.cross(two[0] - one[0], two[1] - one[1])[1] > 0  # anticlockwise seen from +y
    assert two_body_orbit(1.0, 3.0, 1.0, 1.6, eccentricity, 4.0)[0][0] != pytest.approx(
        (two[0] - one[0])[0]
    )  # the mutant


def test_an_orbit_that_cannot_be_is_one_sentence():
    for wrong, words in (
        ({"separation": 0.5}, "at least the pericenter, 1, not 0.5"),
        ({"eccentricity": 0.5, "separation": 9.0}, "at most 3, where this orbit turns back, not 9"),
        ({"axis": (0, 0, 0)}, "axis must not be the null vector"),
    ):
        with pytest.raises(ga.UsageError, match=words):
            GravitatingSphere(companion=1.0, **wrong)
    with pytest.raises(ga.UsageError, match="outer must be at least inner"):
        KeplerRings(inner=2.0, outer=1.0)


def test_a_live_halo_has_the_halos_mass_and_profile():
    drawn = GalaxyHalo(halo_mass=5e11, halo_scale=20.0, edge=15.0).arrays(N)
    r = np.sqrt((drawn["position"] ** 2).sum(1))
    inside = (15 / 16) ** 2
    assert deviation(r, lambda x: (x / (x + 20)) ** 2 / inside) < 1.95
    assert deviation(r, lambda x: (x / (x + 21)) ** 2 / inside) > 1.95  # the mutant
    assert drawn["mass"].sum() == pytest.approx(inside * 5e11, rel=1e-12)


def test_the_same_seed_draws_the_same_and_another_another():
    sphere = GravitatingSphere(G=1.0)
    a, b, c = sphere.arrays(50, seed=3), sphere.arrays(50, seed=3), sphere.arrays(50, seed=4)
    assert (a["position"] == b["position"]).all() and not (a["position"] == c["position"]).any()
    with pytest.raises(ga.UsageError, match="one by one"):
        ga.Emitter().arrays(3)
