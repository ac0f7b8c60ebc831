"""Is the fused step worth its generator? A million particles under gravity, drag and three octaves of curl noise."""

import numpy as np
from _bench import Bench, alternate
from _peers import numpy_step, plain_kernel

import gen_art as ga
from gen_art.backend import runtime
from gen_art.integrators.kernel_terms import KernelTerms

bench = Bench("step", __doc__)
n, rounds = (20_000, 1) if bench.quick else (1_000_000, 7)
H, FIRST = 0.01, 37  # the step, s, and how many of them lie behind
laws = {
    "gravity": (0.0, -9.81, 0.0), "linear": 0.3, "quadratic": 0.05,
    "noise": {"strength": 2.0, "scale": 1.3, "speed": 0.7, "octaves": 3, "gain": 0.5, "lacunarity": 2.0, "seed": 5},
}  # fmt: skip
bench.settings = {"particles": n, "rounds": rounds, "integrator": "position_verlet", **laws}

r = np.random.default_rng(0)
forces = [ga.forces.Gravity(laws["gravity"]), ga.forces.Drag(laws["linear"], laws["quadratic"])]
medium = ga.Medium(curl_noise=laws["noise"])
start = {"position": r.uniform(-5, 5, (n, 3)), "velocity": r.normal(0, 2, (n, 3)), "mass": r.uniform(0.5, 2, n)}
system = ga.ParticleSystem(**start, forces=forces, medium=medium, integrator="position_verlet")
sim = ga.Simulation({"s": system}, dt=H)
sim.steps_done = FIRST  # the noise is between two of its patterns, so both are computed
state = sim["s"]._state
initial = state.floats[:, :n].copy()

keys = np.zeros((2, n), np.uint32)
numbers = KernelTerms(forces, medium).numbers(np.float32)
simple, blocked = (plain_kernel(KernelTerms(forces, medium), blocks) for blocks in (False, True))
peers = {
    "numpy": lambda S: numpy_step(S, laws, FIRST * H, H, block=n),
    "numpy, in blocks": lambda S: numpy_step(S, laws, FIRST * H, H, block=16384),
    "plain": lambda S: simple(S, keys, numbers, n, FIRST * H, H),
    "plain, in blocks": lambda S: blocked(S, keys, numbers, n, FIRST * H, H),
}
try:
    from _numba import numba_step

    peers["numba"] = lambda S: numba_step(S, laws, FIRST * H, H)
except ImportError:
    print("  numba is not installed and is left out")

sim.step(1)
ours = state.floats[:6, :n].astype(np.float64)
work = {name: initial.copy() for name in peers}
apart = {}
for name, step in peers.items():
    step(work[name])
    apart[name] = float(np.abs(work[name][:6] - ours).max() / np.abs(ours).max())
    assert apart[name] < 1e-4, f"{name} does not take the same step: {apart[name]:.2e} apart"

taken = alternate(
    rounds, gen_art=lambda: sim.step(1), **{name: lambda f=f, S=work[name]: f(S) for name, f in peers.items()}
)
sixteen = alternate(rounds, sixteen=lambda: sim.step(16))["sixteen"] / 16
rows = [("", "ms a step", "M particles/s", "gen_art is", "differs by")]
for name, seconds in taken.items():
    ratio = seconds / taken["gen_art"]
    rows.append(
        (name, f"{1e3 * seconds:.1f}", f"{n / seconds / 1e6:.1f}", f"{ratio:.1f}x", f"{apart.get(name, 0.0):.0e}")
    )
rows.append(
    (
        "gen_art, 16 a launch",
        f"{1e3 * sixteen:.1f}",
        f"{n / sixteen / 1e6:.1f}",
        f"{sixteen / taken['gen_art']:.1f}x",
        "",
    )
)
bench.table(rows)
bench.figures = {
    "threads": runtime.threads(), "seconds_a_step": taken, "sixteen_steps_a_launch": sixteen, "largest_difference": apart,
}  # fmt: skip
plain = min(taken["plain"], taken["plain, in blocks"])
bench.require("times as fast as NumPy", taken["numpy"] / taken["gen_art"], at_least=20)
bench.require("times as fast as a plain Taichi kernel", plain / taken["gen_art"], at_least=4)
bench.finish()
