"""Orbital elements: from elements to positions and back, and of particles that move."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.simulation import orbit

EPS = np.finfo(float).eps
TURN = 2 * np.pi


def state(a, e, inclination, node, argument, anomaly, mu):
    """Position and velocity of a body on a conic section, by rotations of the orbit in its own plane."""
    p = a * (1 - e * e)
    r = p / (1 + e * np.cos(anomaly))
    x = r * np.array([np.cos(anomaly), np.sin(anomaly), 0])
    v = np.sqrt(mu / p) * np.array([-np.sin(anomaly), e + np.cos(anomaly), 0])

    def about_z(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    c, s = np.cos(inclination), np.sin(inclination)
    turned = about_z(node) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ about_z(argument)
    return turned @ x, turned @ v


ORBITS = {  # a, e, inclination, node, argument of pericentre, true anomaly
    "ellipse": (2.0, 0.3, 0.4, 1.0, 2.0, 3.0),
    "retrograde": (1.5, 0.6, 2.5, 5.0, 4.0, 0.3),
    "eccentric": (1.0, 0.97, 1.2, 0.1, 6.0, 3.1),
    "polar": (1.0, 0.2, np.pi / 2, 3.0, 0.5, 5.5),
    "hyperbola": (-2.0, 1.7, 0.8, 4.0, 1.0, 1.2),
    "incoming hyperbola": (-0.5, 3.0, 2.9, 2.0, 5.0, 5.0),
}


def off(one, other):
    """rad, the difference of two angles."""
    return abs((np.asarray(one) - other + np.pi) % TURN - np.pi)


@pytest.mark.parametrize("name", ORBITS)
def test_elements_come_back(name):
    """To a few hundred eps; angles worse by 1 / e and 1 / sin i, and where the position is nearly along the apsides."""
    a, e, i, node, argument, anomaly = ORBITS[name]
    mu = 3.0
    found = ga.orbital_elements(*state(a, e, i, node, argument, anomaly, mu), mu)
    loss = 1 / (abs(1 - e) * min(e, 1) * np.sin(i))
    assert found.semi_major_axis == pytest.approx(a, rel=100 * EPS * loss)
    assert found.eccentricity == pytest.approx(e, abs=100 * EPS * loss)
    for angle, expected in ((found.inclination, i), (found.node, node), (found.argument_of_pericenter, argument), (found.true_anomaly, anomaly)):  # fmt: skip
        assert off(angle, expected) <= 100 * EPS * loss and 0 <= angle < TURN
    assert found.period == (pytest.approx(TURN * np.sqrt(a**3 / mu), rel=200 * EPS * loss) if a > 0 else np.inf)


def test_many_at_once_are_each_alone():
    states = [state(*elements, 3.0) for elements in ORBITS.values()]
    x, v = (np.array(part) for part in zip(*states))
    together = ga.orbital_elements(x, v, np.full(len(x), 3.0))
    for k, (position, velocity) in enumerate(states):
        alone = ga.orbital_elements(position, velocity, 3.0)
        for field in alone.__dataclass_fields__:
            assert getattr(together, field)[k] == getattr(alone, field)


def test_a_circle_and_the_plane_of_reference_have_agreed_angles():
    """On a circle the pericentre is at the node; in the plane of reference the node is at the direction of reference."""
    circle = ga.orbital_elements((0, 2, 0), (-np.sqrt(0.5), 0, 0), 1.0)
    assert circle.semi_major_axis == pytest.approx(2, rel=4 * EPS) and circle.eccentricity < 4 * EPS
    assert (circle.inclination, circle.node, circle.argument_of_pericenter) == (0, 0, 0)
    assert circle.true_anomaly == pytest.approx(np.pi / 2, rel=4 * EPS)
    other_way = ga.orbital_elements((0, 2, 0), (np.sqrt(0.5), 0, 0), 1.0)
    assert other_way.inclination == np.pi and other_way.true_anomaly == pytest.approx(3 * np.pi / 2, rel=4 * EPS)
    x, v = state(1.0, 0.0, 0.7, 2.0, 0.0, 1.5, 1.0)
    tilted = ga.orbital_elements(x, v, 1.0)
    assert (
        tilted.argument_of_pericenter == 0
        and off(tilted.node, 2.0) < 16 * EPS
        and off(tilted.true_anomaly, 1.5) < 16 * EPS
    )
    x, v = state(1.0, 0.5, 0.0, 0.0, 0.9, 1.5, 1.0)
    flat = ga.orbital_elements(x, v, 1.0)
    assert flat.node == 0 and off(flat.argument_of_pericenter, 0.9) < 32 * EPS


def test_a_parabola():
    found = ga.orbital_elements((1, 0, 0), (0, np.sqrt(2 - 1e-300), 0), 1.0)
    assert found.eccentricity == pytest.approx(1, abs=8 * EPS) and abs(found.semi_major_axis) > 1e14
    exact = ga.orbital_elements((2, 0, 0), (0, 1, 0), 1.0)
    assert exact.semi_major_axis == np.inf and exact.period == np.inf and exact.eccentricity == 1


def test_another_plane_of_reference():
    """The same orbit with y up: its coordinates turned by (x, y, z) -> (z, x, y)."""
    x, v = state(*ORBITS["ellipse"], 3.0)
    plain = ga.orbital_elements(x, v, 3.0)
    turned = ga.orbital_elements(np.roll(x, -1), np.roll(v, -1), 3.0, axis=(0, 2, 0), reference=(0, 5, 7))
    for field in plain.__dataclass_fields__:
        assert getattr(turned, field) == pytest.approx(getattr(plain, field), rel=100 * EPS), field


@pytest.mark.parametrize("mutant", ["cross", "sum", "node"])
def test_mutants_are_found(mutant, monkeypatch):
    """A wrong sign of the angular momentum, a wrong factor of the energy, a node where the orbit sinks."""
    if mutant == "cross":
        real = np.cross
        monkeypatch.setattr(orbit.np, "cross", lambda a, b: real(b, a))
    elif mutant == "sum":
        real = orbit._length
        monkeypatch.setattr(orbit, "_length", lambda vectors: 2**0.5 * real(vectors))
    else:
        real = orbit._angle
        monkeypatch.setattr(orbit, "_angle", lambda one, other, axis: real(other, one, axis))
    with pytest.raises(AssertionError):
        test_elements_come_back("ellipse")


def test_particles_keep_their_elements_and_the_anomaly_goes_round():
    """Two bodies with self-gravity, by rk4: the elements stay to its error, and after a period the anomaly is back."""
    a, e, i, node, argument, anomaly = ORBITS["ellipse"]
    x, v = state(a, e, i, node, argument, anomaly, 4.0)  # masses 1 and 3, G = 1
    stars = ga.ParticleSystem(
        position=[-x / 4, 3 * x / 4], velocity=[-v / 4, 3 * v / 4], mass=[3.0, 1.0], integrator="rk4",
        interactions=[ga.interactions.SelfGravity(G=1.0, softening=0.0)],
    )  # fmt: skip
    steps = 2000
    sim = ga.Simulation({"stars": stars}, dt=TURN * np.sqrt(a**3 / 4.0) / steps, precision="f64")
    start = stars.orbital_elements(1, about=0)
    assert start.semi_major_axis == pytest.approx(a, rel=1e-13) and off(start.argument_of_pericenter, argument) < 1e-13
    sim.step(steps // 3)
    later = stars.orbital_elements([1], about=0)
    assert later.eccentricity.shape == (1,) and later.eccentricity[0] == pytest.approx(e, abs=1e-9)
    assert off(later.true_anomaly[0], anomaly) > 0.5 and off(later.node[0], node) < 1e-9
    sim.step(steps - steps // 3)
    assert off(stars.orbital_elements(1, about=0).true_anomaly, anomaly) < 1e-8
    swapped = stars.orbital_elements(0, about=1)  # the other body: the same orbit, half a turn on
    assert off(swapped.argument_of_pericenter, argument + np.pi) < 1e-8
    assert stars.orbital_elements(1, about=0, G=2.0).semi_major_axis < 0.9 * a


@pytest.mark.parametrize("call,words", [
    (lambda: ga.orbital_elements((0, 0, 0), (1, 0, 0), 1.0), "at the same place have no orbit"),
    (lambda: ga.orbital_elements((1, 1, 0), (2, 2, 0), 1.0), "no plane of its orbit"),
    (lambda: ga.orbital_elements((1, 0, 0), (0, 0, 0), 1.0), "no plane of its orbit"),
    (lambda: ga.orbital_elements((1, 0), (0, 1), 1.0), r"position must have the shape \(3,\) or \(n, 3\)"),
    (lambda: ga.orbital_elements((1, 0, 0), [(0, 1, 0)], 1.0), r"velocity must have the shape \(3,\) of position"),
    (lambda: ga.orbital_elements((1, 0, 0), (0, 1, 0), 0.0), "GM must be one number above 0"),
    (lambda: ga.orbital_elements((1, 0, 0), (0, 1, 0), [1.0, 2.0]), "GM must be one number above 0"),
    (lambda: ga.orbital_elements((1, 0, 0), (0, np.nan, 0), 1.0), "velocity holds numbers that are not finite"),
    (lambda: ga.orbital_elements((1, 0, 0), (0, 1, 0), 1.0, axis=(0, 0, 0)), "axis must not be the zero vector"),
    (lambda: ga.orbital_elements((1, 0, 0), (0, 1, 0), 1.0, reference=(0, 0, 3)), "reference must not lie along the axis"),
])  # fmt: skip
def test_nonsense_is_a_sentence(call, words):
    with pytest.raises(ga.UsageError, match=words):
        call()


def test_nonsense_of_particles_is_a_sentence():
    stars = ga.ParticleSystem(position=[(0, 0, 0), (1, 0, 0)], velocity=[(0, 0, 0), (0, 1, 0)])
    ga.Simulation({"stars": stars}, dt=0.01)
    with pytest.raises(ga.UsageError, match="give G: system 'stars' has no self_gravity"):
        stars.orbital_elements(1, about=0)
    with pytest.raises(ga.UsageError, match="no living particle 7"):
        stars.orbital_elements(7, about=0, G=1.0)
    with pytest.raises(ga.UsageError, match="about must be a whole number"):
        stars.orbital_elements(1, about=[0, 1], G=1.0)
    with pytest.raises(ga.UsageError, match="at the same place"):
        stars.orbital_elements([0, 1], about=0, G=1.0)
    assert stars.orbital_elements(1, about=0, G=1.0).eccentricity > 0
