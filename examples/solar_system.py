"""The Solar System for a year: the Sun, eight planets and the Moon under each other's gravity.

python examples/solar_system.py            where each stands after 365.25 days, from the Sun, in au
python examples/solar_system.py 3652.5     after another number of days

The states are heliocentric, of J2000.0 (JD 2451545.0 TDB), on the ICRF's axes, in au and au/day; masses are GM in
au^3/day^2, so that G is 1. The Earth's row holds the Moon's pull: without a Moon take the barycentre of the two.
"""

import argparse
import csv
from pathlib import Path

import numpy as np

import gen_art as ga

SUN = 2.9591220828e-4
GM = {
    "mercury": 4.9125e-11, "venus": 7.24345e-10, "earth": 8.88769e-10, "moon": 1.09319e-11, "mars": 9.54955e-11,
    "jupiter": 2.82535e-7, "saturn": 8.45971e-8, "uranus": 1.29203e-8, "neptune": 1.52436e-8,
}  # fmt: skip
STEP = 0.25  # days


def states() -> tuple[list[str], np.ndarray]:
    """The bodies' names and their heliocentric states at J2000.0, (n, 6): au and au/day."""
    with open(Path(__file__).with_name("solar_system_j2000.csv"), encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return [row["body"] for row in rows], np.array(
        [[float(row[c]) for c in ("x", "y", "z", "vx", "vy", "vz")] for row in rows]
    )


def positions(days: float, step: float = STEP) -> dict[str, np.ndarray]:
    """Where the bodies stand after so many days, from the Sun, in au. `step`, in days, divides them."""
    names, state = states()
    mass = np.array([SUN, *(GM[name] for name in names)])
    state = np.concatenate([np.zeros((1, 6)), state])
    state -= (mass[:, None] * state).sum(axis=0) / mass.sum()  # at rest about the centre of mass
    bodies = ga.ParticleSystem(
        position=state[:, :3], velocity=state[:, 3:], mass=mass,
        interactions=[ga.interactions.SelfGravity(G=1.0)], integrator="yoshida4",
    )  # fmt: skip
    sim = ga.Simulation({"bodies": bodies}, dt=step, precision="f64")
    sim.advance(days)
    place = sim["bodies"].position
    return dict(zip(names, place[1:] - place[0]))


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("days", nargs="?", type=float, default=365.25, help=f"a multiple of {STEP}")
    try:
        places = positions(words.parse_args().days)
    except ga.UsageError as error:
        words.error(str(error))
    for name, (x, y, z) in places.items():
        print(f"{name:8} {x:16.9f} {y:16.9f} {z:16.9f} au")
