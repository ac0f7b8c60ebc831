"""A submarine with ballast tanks, a propeller and drag, whose crew floods and blows the tanks by a recorded file.

python examples/submarine.py                 hovers at 30 m, dives for 20 s, blows its tanks and comes up
python examples/submarine.py tanks.csv       with the columns time (s) and flooded (0 to 1)
"""

import argparse

import gen_art as ga

MASS, WATER, G = 1.0e6, 1025.0, 9.81  # kg, kg/m^3, m/s^2
VOLUME, TANKS, HEIGHT = 1005.0, 60.0, 8.0  # m^3, m^3, m
HOVER = (VOLUME - MASS / WATER) / TANKS  # of the tanks, flooded: the mass of the water it takes the place of is its own
DIVE = {"time": [0, 10, 20, 40, 60], "flooded": [HOVER, HOVER, 0.6, 0.6, 0.3]}


def dive(controls=None, seconds: float = 240.0) -> list[tuple[float, float, float]]:
    """(time in s, depth of the middle in m, speed ahead in m/s) every ten seconds."""
    boat = ga.ParticleSystem(
        position=[[0, -30, 0]], velocity=[[4, 0, 0]], mass=MASS,
        forces=[
            ga.forces.Gravity((0, -G, 0)),
            ga.forces.Ballast(controls=controls or DIVE, volume=VOLUME, tanks=TANKS, density=WATER, height=HEIGHT),
            ga.forces.Propeller(max_thrust=1.6e5, throttle=0.5), ga.forces.Drag(quadratic=5.0e3),
        ],
    )  # fmt: skip
    sim = ga.Simulation({"boat": boat}, dt=0.02, precision="f64")
    log = []
    for _ in range(round(seconds / 10)):
        log.append((sim.time, -sim["boat"].position[0, 1], sim["boat"].velocity[0, 0]))
        sim.advance(10.0)
    return log


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("tanks", nargs="?", help="a .csv file of how far the tanks are flooded")
    try:
        log = dive(words.parse_args().tanks)
    except ga.UsageError as error:
        words.error(str(error))
    for time, depth, speed in log:
        print(f"{time:4.0f} s   depth {depth:6.1f} m   speed ahead {speed:4.1f} m/s")
