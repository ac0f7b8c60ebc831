"""The proofs against closed forms once more, in both precisions, each with its tolerance.

A float32 figure is eps (6e-8, half a unit in the last place) times what it says beside it: a walk of n roundings comes to
some sqrt(n) eps where they are even, n eps where they lean one way; a difference of large numbers multiplies by their ratio.
"""

import numpy as np
import pytest

import gen_art as ga
from tests.physics.test_integrators import on_orbit

F, I = ga.forces, ga.interactions


def simulate(precision, dt, steps, **system):
    sim = ga.Simulation({"s": ga.ParticleSystem(**system)}, dt=dt, precision=precision)
    sim.step(steps)
    return sim, sim["s"].position.astype(float), sim["s"].velocity.astype(float)


def projectile(precision, wrong):
    """x = v t, y = v t - g t^2 / 2."""
    _, x, _ = simulate(
        precision, 0.01, 200, position=[[0, 0, 0]], velocity=[[3, 10, 0]], forces=[F.Gravity((0, -9.81 * wrong, 0))]
    )
    return np.abs(x[0] - (6, 20 - 9.81 * 2, 0)).max() / 20


def linear_drag(precision, wrong):
    """v = u + a/k + (v0 - u - a/k) exp(-k t), at k dt = 0.1."""
    k, u, a, v0 = 1.7, np.array([0.5, 0, 0.3]), np.array([0, -9.81, 0]), np.array([1.0, 2, -1])
    _, _, v = simulate(
        precision, 0.1 / k, 40, position=[[0, 0, 0]], velocity=[v0], forces=[F.Damping(k * wrong), F.Gravity(a)],
        medium=ga.Medium(wind=u),
    )  # fmt: skip
    return np.abs(v[0] - (u + a / k + (v0 - u - a / k) * np.exp(-4.0))).max() / 9.81


def quadratic_drag(precision, wrong):
    """v = sqrt(m g / k) tanh(t sqrt(g k / m))."""
    m, k, g = 1.3, 0.2, 9.81
    forces = [F.Drag(quadratic=k * wrong), F.Gravity((0, -g, 0))]
    _, _, v = simulate(precision, 0.005, 400, position=[[0, 0, 0]], mass=m, forces=forces)
    exact = np.sqrt(m * g / k) * np.tanh(2 * np.sqrt(g * k / m))
    return abs(v[0, 1] + exact) / exact


def rocket(precision, wrong):
    """Tsiolkovsky: v = u ln(m0 / m)."""
    forces = [F.Thrust((0, 1, 0), 300.0 * wrong, 0.5, duration=3.0)]
    _, _, v = simulate(precision, 1e-3, 3000, position=[[0, 0, 0]], mass=2.0, forces=forces, integrator="rk4")
    return abs(v[0, 1] / (300 * np.log(4.0)) - 1)


def oscillator(precision, wrong):
    """x = exp(-zeta w0 t) (cos w t + ...), underdamped, after three periods."""
    w0, rate = 5.0, 0.6
    w = np.sqrt(w0**2 - rate**2 / 4)
    forces = [F.Spring(stiffness=w0**2 * wrong), F.Damping(rate)]
    sim, x, _ = simulate(precision, 1e-3, 3770, position=[[1, 0, 0]], forces=forces)
    t = sim.time
    return abs(x[0, 0] - np.exp(-rate * t / 2) * (np.cos(w * t) + rate / (2 * w) * np.sin(w * t)))


def kepler(precision, wrong):
    """An orbit with e = 0.5 after a period, by Kepler's equation."""
    steps = 2000
    sim, x, _ = simulate(
        precision, 2 * np.pi / steps, steps, position=[[0.5, 0, 0]], velocity=[[0, np.sqrt(3.0), 0]],
        forces=[F.PointGravity(GM=1.0 * wrong)], integrator="yoshida4",
    )  # fmt: skip
    return np.linalg.norm(x[0] - on_orbit(sim.time, 0.5))


def escape(precision, wrong):
    """At the escape speed r = (1 + 1.5 sqrt(2 GM) t)^(2/3)."""
    sim, x, _ = simulate(
        precision, 0.005, 4000, position=[[1, 0, 0]], velocity=[[np.sqrt(6.0), 0, 0]], forces=[F.PointGravity(GM=3.0 * wrong)],
        integrator="rk4",
    )  # fmt: skip
    r = (1 + 1.5 * np.sqrt(6.0) * sim.time) ** (2 / 3)
    return abs(x[0, 0] / r - 1)


def two_bodies(precision, wrong):
    """Masses 1 and 3 at distance 1 come back after a period."""
    start = np.array([[0.75, 0, 0], [-0.25, 0, 0]])
    _, x, _ = simulate(
        precision, np.pi / 200, 200, position=start, velocity=[[0, 1.5, 0], [0, -0.5, 0]], mass=[1, 3],
        interactions=[I.SelfGravity(G=1.0 * wrong)], integrator="yoshida4",
    )  # fmt: skip
    return np.abs(x - start).max()


def there_and_back(precision, wrong):
    """Leapfrog forwards, then with the velocities turned round."""
    r = np.random.default_rng(0)
    x, v = r.normal(size=(20, 3)), r.normal(size=(20, 3))
    laws = {"forces": [F.Spring(stiffness=3.0), F.Gravity()]}
    _, far, fast = simulate(precision, 0.01, 400, position=x, velocity=v, **laws)
    _, near, _ = simulate(precision, 0.01, 400, position=far, velocity=-fast * wrong, **laws)
    return np.abs(near - x).max()


def modes(precision, wrong):
    """The second mode of four masses on five springs, w = 2 sqrt(k / m) sin(2 pi / 10), passes through rest after T / 4."""
    k, shape = 40.0, np.sin(2 * np.pi * np.arange(6) / 5)
    start = np.stack([np.arange(6.0), 0 * shape, 0 * shape], 1) + 1e-2 * np.stack([shape, 0 * shape, 0 * shape], 1)
    springs = I.Springs(pairs=[[j, j + 1] for j in range(5)], stiffness=k * wrong, rest_length=1.0)
    w = 2 * np.sqrt(k) * np.sin(np.pi / 5)
    _, x, _ = simulate(
        precision, np.pi / w / 400, 200, position=start, fixed=[0, 5], interactions=[springs], integrator="leapfrog"
    )
    return np.abs(x[:, 0] - np.arange(6)).max() / 1e-2


def gyration(precision, wrong):
    """A charge comes back after a turn, with the exact phase."""
    B = 2.0
    _, x, _ = simulate(
        precision, 2 * np.pi / B / 100, 100, position=[[0, 0, 0]], velocity=[[1, 0, 0]], charge=1.0, integrator="boris",
        exact_gyration=True, forces=[F.MagneticField((0, 0, B * wrong))],
    )  # fmt: skip
    return np.abs(x).max() * B


def crossed_fields(precision, wrong):
    """At E x B / B^2 a charge stays."""
    forces = [F.ElectricField((0.3 * wrong, 0, 0)), F.MagneticField((0, 0, 2.0))]
    _, x, _ = simulate(
        precision,
        0.05,
        100,
        position=[[0, 0, 0]],
        velocity=[[0, -0.15, 0]],
        charge=1.0,
        integrator="boris",
        forces=forces,
    )
    return np.abs(x[0] - (0, -0.75, 0)).max()


def hyperbolic(precision, wrong):
    """A steady push on a fast charge: x = c^2 m / F (gamma - 1)."""
    sim, x, _ = simulate(
        precision, 0.01, 1000, position=[[0, 0, 0]], charge=1.0, integrator="vay", speed_of_light=3.0,
        forces=[F.ElectricField((1.5 * wrong, 0, 0))],
    )  # fmt: skip
    exact = 9 / 1.5 * (np.sqrt(1 + (1.5 * sim.time / 3) ** 2) - 1)
    return abs(x[0, 0] / exact - 1)


def bounces(precision, wrong):
    """A ball at rest again after sqrt(2 h / g) (1 + e) / (1 - e): its height at a tenth before."""
    e, h, g, radius = 0.8, 1.0, 9.81, 0.01
    floor = ga.colliders.Plane(restitution=min(e * wrong, 1.0))
    fall = np.sqrt(2 * h / g)
    t = fall * (1 + 2 * (e + e**2 + e**3 / 2))  # the top after the third bounce
    _, x, _ = simulate(
        precision,
        t / 1000,
        1000,
        position=[[0, h + radius, 0]],
        radius=radius,
        forces=[F.Gravity((0, -g, 0))],
        colliders=[floor],
    )
    return abs(x[0, 1] - radius - e**6 * h)


# what: (tolerance in f64, in f32, a factor that is noticed)
PROOFS = {
    projectile: (1e-13, 3e-6, 1.001),  # 200 roundings of x and v: eps 200 / 4 at the worst
    linear_drag: (1e-12, 2e-7, 1.001),  # what is rounded dies out as the speed does: 3 eps
    quadratic_drag: (1e-7, 1e-6, 1.01),  # the scheme's 3e-8; the terminal speed forgets: some eps
    rocket: (1e-11, 4e-4, 1.01),  # 3000 takings of 5e-4 kg off 2 kg, all rounded one way: eps 3000
    oscillator: (2e-6, 4e-6, 1.01),  # the scheme's 6e-7; sqrt(3770) eps
    kepler: (5e-8, 1e-4, 1.001),  # sqrt(6000) eps, and an error of the energy grows by 3 pi a period
    escape: (1e-8, 1e-5, 1.001),  # sqrt(16,000) eps
    two_bodies: (1e-5, 3e-5, 1.001),  # sqrt(600) eps, and 3 pi
    there_and_back: (1e-12, 1e-5, 1.001),  # 800 roundings of positions of up to 7 m: sqrt(800) 4 eps
    modes: (1e-4, 1e-3, 1.01),  # a swing of 1e-2 m on 5 m is a difference: 500 eps
    gyration: (1e-14, 1e-6, 1.001),  # sqrt(100) eps
    crossed_fields: (1e-14, 1e-5, 1.01),  # PHYSICS: 1e-5; eps of the fields leaves a speed of 1e-8 that turns, 100 roundings
    hyperbolic: (2e-6, 5e-6, 1.01),  # the scheme's 5e-7; 1000 roundings of x that grows
    bounces: (1e-12, 1e-5, 1.01),  # sqrt(1000) eps
}  # fmt: skip


SLOW = (bounces,)  # to compile


@pytest.mark.parametrize(
    "proof", [pytest.param(p, marks=[pytest.mark.proof] * (p in SLOW), id=p.__name__) for p in PROOFS]
)
def test_a_closed_form_holds_in_both_precisions(proof):
    double, single, wrong = PROOFS[proof]
    found, rough = proof("f64", 1.0), proof("f32", 1.0)
    assert found <= double and rough <= single
    assert rough > found  # float32 is not float64
    assert proof("f64", wrong) > 3 * double  # the mutant
    assert proof("f32", wrong) > single
