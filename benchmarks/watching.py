"""What does it cost to look for steps that are too long and for numbers that are not finite? Runs with and without both."""

import warnings

import numpy as np
from _bench import Bench, alternate

import gen_art as ga

bench = Bench("watching", __doc__)
warnings.simplefilter("ignore")  # what is said does not matter here
F, I = ga.forces, ga.interactions
r = np.random.default_rng(0)


def free(n):
    return {
        "position": r.uniform(-5, 5, (n, 3)), "velocity": r.normal(0, 2, (n, 3)), "integrator": "position_verlet",
        "forces": [F.Gravity((0, -9.81, 0)), F.Damping(0.3)], "medium": ga.Medium(curl_noise={"strength": 2.0, "octaves": 3}),
    }  # fmt: skip


def mutual(n):
    return {"position": r.normal(size=(n, 3)), "mass": 1 / n, "interactions": [I.SelfGravity(G=1.0, softening=0.1)]}


CASES = {  # what: (system, steps of a run, steps of a call)
    "1,000 free, 16 steps a call": (free, 1_000, 4_096, 16),
    "100,000 free, 16 steps a call": (free, 100_000, 256, 16),
    "1,000,000 free, 1 step a call": (free, 1_000_000, 32, 1),
    "2 bodies": (mutual, 2, 4_096, 64),
    "1,000 bodies": (mutual, 1_000, 512, 64),
    "10,000 bodies": (mutual, 10_000, 32, 16),
}
rounds = 1 if bench.quick else 9
bench.settings = {"rounds": rounds}
rows, ratios = [("", "without, ms a step", "with, ms a step", "ratio")], {}
for what, (make, n, steps, call) in CASES.items():
    if bench.quick:
        n, steps = min(n, 1_000), 2 * call
    start = make(n)
    sims = {
        advice: ga.Simulation({"s": ga.ParticleSystem(**start)}, dt=1e-3, advice=advice) for advice in ("none", "warn")
    }
    sims["none"]._watch.check_finite = lambda: None

    def run(advice, sims=sims, steps=steps, call=call):
        for _ in range(steps // call):
            sims[advice].step(call)

    taken = alternate(rounds, none=lambda: run("none"), warn=lambda: run("warn"))
    ratios[what] = taken["warn"] / taken["none"]
    rows.append(
        (what, f"{1e3 * taken['none'] / steps:.4f}", f"{1e3 * taken['warn'] / steps:.4f}", f"{ratios[what]:.3f}")
    )
bench.table(rows)
bench.figures = {"ratios": ratios}
bench.require("the largest ratio", max(ratios.values()), at_most=1.02)
bench.finish()
