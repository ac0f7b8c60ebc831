"""Two bodies about each other, from arrays: the engine as a library whose conservation laws are asserted.

Run it:   python examples/orbit.py
"""

import numpy as np

import gen_art as ga


def simulate(eccentricity: float = 0.5, steps: int = 2000) -> ga.Simulation:
    """One Kepler orbit of masses 1 and 3 (G = 1, semi-major axis 1), started at its farthest point."""
    masses = np.array([1.0, 3.0])
    period = 2 * np.pi / np.sqrt(masses.sum())
    distance = 1 + eccentricity
    speed = np.sqrt(masses.sum() * (1 - eccentricity) / distance)
    shares = np.array([masses[1], -masses[0]]) / masses.sum()  # about the centre of mass
    bodies = ga.ParticleSystem(
        position=np.outer(shares, [distance, 0, 0]),
        velocity=np.outer(shares, [0, speed, 0]),
        mass=masses,
        interactions=[ga.interactions.SelfGravity(G=1.0)],
        integrator="leapfrog",
    )
    sim = ga.Simulation({"bodies": bodies}, dt=period / steps, precision="f64", ledger=True)
    sim.step(steps)
    return sim


def main() -> None:
    sim = simulate()
    d, ledger = sim.diagnostics(), sim.ledger()
    print(f"after one period: energy {d.energy:.12f} J, of which the scheme erred by {ledger.residual:.2e} J")

    # U + T = -G m1 m2 / 2a; the orbit closes; nothing pushes the pair
    assert abs(d.energy + 1.5) < 1e-5
    assert np.abs(sim["bodies"].position[0] - [0.75 * 1.5, 0, 0]).max() < 1e-3
    assert np.abs(d.momentum).max() < 1e-12
    assert np.abs(d.center_of_mass).max() < 1e-12

    # gravity is conservative: the ledger books no work, and what remains is the integrator's error
    assert ledger.work.total == 0.0 and ledger.dissipated.total == 0.0
    assert abs(ledger.residual) < 1e-5 * ledger.scale
    # leapfrog is of order 2: half the step, a quarter of the error in where the orbit closes
    coarse, fine = (abs(simulate(steps=n)["bodies"].position[0, 1]) for n in (1000, 2000))
    assert 3.8 < coarse / fine < 4.2


if __name__ == "__main__":
    main()
