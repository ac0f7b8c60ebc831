"""What does a `for` loop over a few bodies cost? Ten under gravity: one step a call, and their positions read, beside NumPy.

The loop in NumPy takes the same steps (compared first) as one would write them: all pairs at once by broadcasting.
"""

import numpy as np
from _bench import Bench, alternate

import gen_art as ga

bench = Bench("small_loops", __doc__)
N, STEPS, ROUNDS = (10, 50, 1) if bench.quick else (10, 2_000, 9)
G, SOFTENING, DT = 1.0, 0.1, 1e-3
bench.settings = {"bodies": N, "steps": STEPS, "rounds": ROUNDS, "step": DT}

rng = np.random.default_rng(1)
start = {"position": rng.normal(size=(N, 3)), "velocity": rng.normal(size=(N, 3)) * 0.1, "mass": np.full(N, 0.1)}


def simulation() -> ga.Simulation:
    gravity = ga.interactions.SelfGravity(G=G, softening=SOFTENING)
    return ga.Simulation({"s": ga.ParticleSystem(**start, interactions=[gravity])}, dt=DT)


class ByHand:
    """The leapfrog of the same bodies in float32."""

    def __init__(self):
        self.x, self.v, self.m = (start[key].astype(np.float32) for key in ("position", "velocity", "mass"))
        self.a = self.pull()

    def pull(self):
        d = self.x[None] - self.x[:, None]
        s2 = (d * d).sum(axis=2) + np.float32(SOFTENING**2)
        return np.float32(G) * ((self.m / (s2 * np.sqrt(s2)))[..., None] * d).sum(axis=1)

    def step(self):
        self.v += np.float32(DT / 2) * self.a
        self.x += np.float32(DT) * self.v
        self.a = self.pull()
        self.v += np.float32(DT / 2) * self.a


ours, hand = simulation(), ByHand()
ours.step(500)
for _ in range(500):
    hand.step()
apart = float(np.abs(ours["s"].position - hand.x).max())
bodies = ours["s"]


def step():
    for _ in range(STEPS):
        ours.step(1)


def read():
    for _ in range(STEPS):
        _ = bodies.position


def step_and_read():
    for _ in range(STEPS):
        ours.step(1)
        _ = bodies.position


def numpy_step():
    for _ in range(STEPS):
        hand.step()


taken = alternate(ROUNDS, step=step, read=read, step_and_read=step_and_read, numpy=numpy_step)
micro = {name: seconds / STEPS * 1e6 for name, seconds in taken.items()}
bench.table([("", "microseconds"), *((name, f"{value:.1f}") for name, value in micro.items())])
bench.figures = {
    "microseconds": {name: round(value, 2) for name, value in micro.items()},
    "apart after 500 steps": apart,
    "step over numpy": round(micro["step"] / micro["numpy"], 3),
}
bench.require("apart from NumPy after 500 steps", apart, at_most=1e-5)
bench.require("a step, microseconds", micro["step"], at_most=60.0)
bench.require("reading positions, microseconds", micro["read"], at_most=10.0)
bench.finish()
