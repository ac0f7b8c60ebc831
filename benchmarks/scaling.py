"""What does size cost? A particle's share of a step at one and at ten million, and the fixed cost of a small system's step."""

import numpy as np
from _bench import Bench, alternate

import gen_art as ga
from gen_art.preset import load_preset

bench = Bench("scaling", __doc__)
small, large, rounds, steps = (20_000, 80_000, 2, 20) if bench.quick else (1_000_000, 10_000_000, 7, 400)


def cloud(n: int, **laws) -> ga.Simulation:
    """A simulation of n independent particles."""
    r = np.random.default_rng(0)
    x = r.uniform(-5, 5, (n, 3))
    system = ga.ParticleSystem(
        position=x, forces=[ga.forces.Gravity(), ga.forces.Damping(0.3)], integrator="position_verlet", **laws
    )
    return ga.Simulation({"s": system}, dt=0.001)


def fountains(systems: int) -> ga.Simulation:
    """Systems of one emitter each, with about 16 particles alive."""
    one = {
        "particle": {"lifetime": 1.6, "mass": 0.1, "radius": 0.01},
        "integrator": "position_verlet",
        "emitters": {"nozzle": {"rate": 10, "velocity": {"cone": [0, 1, 0], "angle": 10, "speed": "3..4"}}},
    }
    laws = {"gravity": [0, -9.81, 0], "damping": 0.5}
    clock = {"duration": 10, "fps": 30, "step": "1/240"}
    names = [f"fountain_{k}" for k in range(systems)]
    piece = load_preset({"version": 1, "clock": clock, "forces": laws, "systems": dict.fromkeys(names, one)})
    sim = ga.Simulation(piece)
    sim.advance(2.5)
    assert all(14 <= sim[name].count <= 18 for name in names)
    return sim


rows = [("", f"ns a particle at {small:,}", f"at {large:,}", "ratio")]
ratios = {}
for name, laws in (
    ("gravity and damping", {}),
    (
        "with three octaves of curl noise",
        {"medium": ga.Medium(curl_noise={"strength": 1.0, "octaves": 3, "speed": 0.5})},
    ),
):
    few, many = cloud(small, **laws), cloud(large, **laws)
    times = large // small

    def repeated(few=few, times=times):
        for _ in range(times):
            few.step(1)

    taken = alternate(rounds, few=repeated, many=lambda many=many: many.step(1))
    few_ns, many_ns = (1e9 * seconds / large for seconds in taken.values())  # both move `large` particles
    ratios[name] = many_ns / few_ns
    rows.append((name, f"{few_ns:.2f}", f"{many_ns:.2f}", f"{ratios[name]:.2f}"))
    bench.figures[name] = {"ns_a_particle": {str(small): few_ns, str(large): many_ns}, "ratio": ratios[name]}
    del few, many
bench.table(rows)


def fixed(sim: ga.Simulation):
    def run():
        for _ in range(steps):
            sim.step(1)

    return run


one, eight = fountains(1), fountains(8)
taken = alternate(3, one=fixed(one), eight=fixed(eight))
share = {"one system": 1e3 * taken["one"] / steps, "each of eight": 1e3 * taken["eight"] / steps / 8}
bench.table([("a system of 16 particles and one emitter", "ms a step"), *((k, f"{v:.3f}") for k, v in share.items())])
bench.figures["ms_a_step_of_16_particles"] = share
bench.settings = {"particles": [small, large], "rounds": rounds, "steps_one_at_a_time": steps}
for name, ratio in ratios.items():
    bench.require(f"cost a particle, ten times as many, {name}", ratio, at_most=1.3)
bench.require("ms a step, one small system", share["one system"], at_most=1.0)
bench.require("ms a step and system, eight small systems", share["each of eight"], at_most=1.0)
bench.finish()
