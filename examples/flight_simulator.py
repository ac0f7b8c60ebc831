"""A flight simulator: an aeroplane trimmed for level flight, and then flown by a recorded file of control inputs.

python examples/flight_simulator.py                 trimmed at 55 m/s, let go 2 m/s too fast: its phugoid
python examples/flight_simulator.py inputs.csv      with the columns time (s), angle_of_attack, bank (degrees), throttle (0 to 1)
"""

import argparse
import math

import numpy as np

import gen_art as ga

MASS, AIR, G, SPEED = 1100.0, 1.225, 9.81, 55.0  # kg, kg/m^3, m/s^2, m/s
STEP = 0.01  # s


def fly(controls=None, faster: float = 0.0, seconds: float = 60.0) -> np.ndarray:
    """(n, 6): place and velocity, m and m/s, every tenth of a second, of an aeroplane that starts level at 1000 m."""
    attack, throttle = ga.forces.Aircraft().trim(SPEED, MASS, AIR, G)
    wings = ga.forces.Aircraft(controls=controls, angle_of_attack=attack, throttle=throttle, density=AIR)
    plane = ga.ParticleSystem(
        position=[[0, 1000, 0]], velocity=[[SPEED + faster, 0, 0]], mass=MASS,
        forces=[ga.forces.Gravity((0, -G, 0)), wings], integrator="rk4",
    )  # fmt: skip
    sim = ga.Simulation({"plane": plane}, dt=STEP, precision="f64")
    flown = []
    for _ in range(round(seconds / 0.1)):
        flown.append(np.concatenate([sim["plane"].position[0], sim["plane"].velocity[0]]))
        sim.advance(0.1)
    return np.array(flown)


def phugoid(flown: np.ndarray) -> float:
    """The mean time between moments when the aeroplane passes from sinking to rising, s."""
    climb = flown[:, 4]
    k = np.flatnonzero((climb[:-1] < 0) & (climb[1:] >= 0))
    return float(np.diff(k - climb[k] / (climb[k + 1] - climb[k])).mean() * 0.1)


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("inputs", nargs="?", help="a .csv file of control inputs")
    given = words.parse_args().inputs
    try:
        path = fly(given) if given else fly(faster=2.0, seconds=90.0)
    except ga.UsageError as error:
        words.error(str(error))
    if given:
        for k, (x, y, z, *v) in enumerate(path[::50]):
            print(
                f"{5 * k:3} s   height {y:7.1f} m   east {x:8.1f} m   south {z:8.1f} m   speed {math.hypot(*v):5.1f} m/s"
            )
    else:
        print(
            f"phugoid {phugoid(path):.2f} s; Lanchester's pi sqrt(2) V / g is {math.pi * math.sqrt(2) * SPEED / G:.2f} s"
        )
