"""Does cloth run faster than real time? A frame of 256 x 256 particles at 30 frames/s: wind, drag, pinned, by method xpbd."""

import time

import numpy as np
from _bench import Bench, alternate

import gen_art as ga
from gen_art.backend import runtime

bench = Bench("cloth", __doc__)
side, warm, rounds = (48, 5, 2) if bench.quick else (256, 45, 9)
FPS, MASS, STIFFNESS = 30, 0.2, 1000.0
bench.settings = {
    "side": side, "fps": FPS, "mass": MASS, "stiffness": STIFFNESS, "tether": 0.01, "sweeps": 1, "frames": rounds
}  # fmt: skip


def sheet(steps: int, pinned: str, wind: tuple, **more) -> ga.Simulation:
    """A square metre, `steps` steps a frame."""
    net = ga.cloth((-0.5, 0.5, 0), (1, 0, 0), (0, -1, 0), side, side, 0.1, 0.02)
    each = MASS / len(net.position)
    system = ga.ParticleSystem(
        position=net.position, mass=each, forces=[ga.forces.Gravity(), ga.forces.Drag(linear=4 * each)],
        medium=ga.Medium(wind=wind), fixed=net.pinned(pinned), integrator="semi_implicit_euler",
        interactions=[net.springs(STIFFNESS, 0.0, "xpbd", sweeps=1, **more)],
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=1 / FPS / steps)


def strain(sim: ga.Simulation) -> dict:
    """Mean strain of the vertical threads at the top edge, of all vertical ones, and of the horizontal ones."""
    x = sim["s"].position.astype(float).reshape(side, side, 3)
    down, across = (np.linalg.norm(np.diff(x, axis=k), axis=2) * (side - 1) - 1 for k in (0, 1))
    return {"top edge": float(down[0].mean()), "down": float(down.mean()), "across": float(across.mean())}


cases = {
    "4 steps, top edge, wind": (sheet(4, "top", (0, 0, 5), tether=0.01), 4),
    "10 steps, top edge, wind": (sheet(10, "top", (0, 0, 5), tether=0.01), 10),
    "10 steps, at rest, no tether": (sheet(10, "top", (0, 0, 0)), 10),
}
for sim, steps in cases.values():
    sim.step(warm * steps)
taken = alternate(
    rounds, **{name: lambda sim=sim, steps=steps: sim.step(steps) for name, (sim, steps) in cases.items()}
)
core = {}
for name, (sim, steps) in cases.items():
    before = time.process_time()
    sim.step(rounds * steps)
    core[name] = (time.process_time() - before) / rounds
found = {name: strain(sim) for name, (sim, _) in cases.items()}
rows = [("", "ms a frame", "core-ms", "strain at the top edge", "down", "across")]
for name, seconds in taken.items():
    parts = found[name]
    rows.append(
        (name, f"{1e3 * seconds:.1f}", f"{1e3 * core[name]:.1f}", *(f"{100 * c:.2f} %" for c in parts.values()))
    )
bench.table(rows)
bench.figures = {"threads": runtime.threads(), "seconds": taken, "core_seconds": core, "strain": found}
bench.require("seconds a frame over those it lasts", taken["4 steps, top edge, wind"] * FPS, at_most=1)
bench.require("strain at the top edge, at rest", found["10 steps, at rest, no tether"]["top edge"], at_most=0.01)
bench.require("strain at the top edge, in the wind", found["4 steps, top edge, wind"]["top edge"], at_most=0.011)
bench.finish()
