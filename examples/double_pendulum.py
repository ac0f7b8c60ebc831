"""Two rods on hinges: joints between rigid bodies, from Python. The energy stays, although the motion is chaotic.

Run it:   python examples/double_pendulum.py
"""

import numpy as np

import gen_art as ga

ROD = {"box": [0.05, 1, 0.05]}
JOINTS = {
    "shoulder": {"hinge": ["upper", "world"], "at": [0, 0, 0], "axis": [0, 0, 1]},
    "elbow": {"hinge": ["lower", "upper"], "at": [1, 0, 0], "axis": [0, 0, 1]},
}


def simulate(seconds: float, dt: float = 1e-3) -> ga.Simulation:
    """The rods are let go from the level, the lower one upright; mass 1 kg, length 1 m each."""
    rods = ga.bodies(
        [
            ga.body(ROD, mass=1, position=(0.5, 0, 0), turn=(0, 0, np.pi / 2), name="upper"),
            ga.body(ROD, mass=1, position=(1, 0.5, 0), turn=(0, 0, np.pi), name="lower"),
        ]
    )
    system = rods.system(forces=[ga.forces.Gravity()], integrator="leapfrog", rigid={"joints": JOINTS})
    sim = ga.Simulation({"pendulum": system}, dt=dt, precision="f64", ledger=True)
    sim.step(round(seconds / dt))
    return sim


def main(seconds: float = 1.0) -> None:
    sim = simulate(seconds)
    start, now, ledger = simulate(0.0).diagnostics(), sim.diagnostics(), sim.ledger()
    error = (now.energy - start.energy) / (2 * 9.81)
    print(
        f"after {seconds:g} s: the energy is {error:.1e} m g l off; the shoulder bore {ledger.impulse['pendulum.shoulder']} N s"
    )

    assert abs(error) < 1e-4  # (w h)^2 at 10 rad/s; it comes and goes with the speed and does not grow
    assert abs(ledger.residual) < 1e-11 * ledger.scale
    # what the shoulder gave and what gravity gave is the momentum
    assert np.abs(ledger.impulse.total - now.momentum).max() < 1e-10


if __name__ == "__main__":
    main()
