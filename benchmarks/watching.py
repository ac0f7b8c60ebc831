"""What does it cost to look for steps that are too long and for numbers that are not finite? The share of it in runs."""

import statistics
import time
import warnings

import numpy as np
from _bench import Bench

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


def made(make, n):
    return lambda: ga.Simulation({"s": ga.ParticleSystem(**make(n))}, dt=1e-3)


FILMS = ("fireworks", "charged", "course/two_stars", "course/coulomb_crystal", "course/satellites")
CASES = {  # without pictures: (simulation, steps of a run, steps of a call)
    "1,000 free, 16 steps a call": (made(free, 1_000), 8_192, 16),
    "1,000,000 free, 1 step a call": (made(free, 1_000_000), 32, 1),
    "2 bodies": (made(mutual, 2), 8_192, 64),
    "1,000 bodies": (made(mutual, 1_000), 1_024, 64),
    "10,000 bodies": (made(mutual, 10_000), 64, 16),
}
rounds = 1 if bench.quick else 5
bench.settings = {"rounds": rounds}


def looking_and_running(sim, calls: list) -> tuple[float, float]:
    """CPU seconds of looking, and wall seconds of the calls: their number times the median."""
    looking, depth = [0.0], [0]
    watch = sim._watch
    for work in (watch.look, watch.most_steps, watch.check_finite):

        def timed(work=work):
            begun, depth[0] = time.thread_time(), depth[0] + 1
            result = work()
            depth[0] -= 1
            if not depth[0]:  # one of them calls another
                looking[0] += time.thread_time() - begun
            return result

        setattr(watch, work.__name__, timed)
    calls[0]()  # compiles
    looking[0], taken = 0.0, []
    for call in calls[1:]:
        begun = time.perf_counter()
        call()
        taken.append(time.perf_counter() - begun)
    return looking[0], statistics.median(taken) * len(taken)


def steps_alone(what):
    make, steps, call = CASES[what]
    sim = make()
    return sim, [lambda: sim.step(call)] * (1 + (2 if bench.quick else steps // call))


def film(name):
    sim = ga.Simulation(ga.load_preset(name))

    def frame(k):
        sim.advance_to_frame(k)
        ga.render_frame(sim, (1280, 720))

    return sim, [lambda k=k: frame(k) for k in range(3 if bench.quick else 48)]


rows, shares = [("", "a call, ms", "looking, us", "share")], {}
for what in (*(f"{name}, a frame" for name in FILMS), *CASES):
    runs = []
    for _ in range(rounds):
        sim, calls = steps_alone(what) if what in CASES else film(what.split(",")[0])
        looking, running = looking_and_running(sim, calls)
        runs.append((looking / (len(calls) - 1), running / (len(calls) - 1)))
    looking, running = (statistics.median(times) for times in zip(*runs))
    shares[what] = looking / running
    rows.append((what, f"{1e3 * running:.3f}", f"{1e6 * looking:.1f}", f"{shares[what]:.2%}"))
bench.table(rows)
bench.figures = {"shares": shares}
bench.require("the largest share of a film", max(v for k, v in shares.items() if k not in CASES), at_most=0.02)
bench.finish()
