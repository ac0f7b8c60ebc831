"""Do contacts stay cheap with many spheres? The same packing of 10,000 and of 1,000,000, and SciPy's cKDTree beside them."""

import warnings

import numpy as np
from _bench import Bench, alternate

import gen_art as ga
from gen_art.backend import runtime

bench = Bench("contacts", __doc__)
few, many, rounds = (1000, 8000, 1) if bench.quick else (10_000, 1_000_000, 3)
FILLING = 0.5  # of the box by spheres
RADIUS = 0.05
bench.settings = {"few": few, "many": many, "rounds": rounds, "filling": FILLING, "radius": RADIUS}


def crowd(n: int) -> ga.Simulation:
    side = (n * 4 / 3 * np.pi * RADIUS**3 / FILLING) ** (1 / 3)
    r = np.random.default_rng(0)
    system = ga.ParticleSystem(
        position=r.uniform(0, side, (n, 3)), velocity=r.normal(0, 0.01, (n, 3)), radius=RADIUS,
        interactions=[ga.interactions.Contacts(restitution=0.5, friction=0.3)], integrator="semi_implicit_euler",
    )  # fmt: skip
    return ga.Simulation({"s": system}, dt=1e-5)


with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # they overlap from the start, as they should here
    small, large = crowd(few), crowd(many)
touching, state = large["s"].interactions[0], large["s"].state
work = {
    "few": lambda: small.step(1), "many": lambda: large.step(1),
    "many, search alone": lambda: touching.overlaps(state, "f32"),
}  # fmt: skip
try:
    from scipy.spatial import cKDTree

    def search() -> None:
        positions = large["s"].position
        cKDTree(positions).query_pairs(2 * RADIUS, output_type="ndarray")

    work["cKDTree"] = search
except ImportError:
    print("  SciPy is not installed and is left out")
taken = alternate(rounds, **work)
each = {name: seconds / (few if name == "few" else many) for name, seconds in taken.items()}
rows = [("", "spheres", "ms", "ns a sphere")]
for name, seconds in taken.items():
    rows.append((name, few if name == "few" else many, f"{1e3 * seconds:.1f}", f"{1e9 * each[name]:.0f}"))
bench.table(rows)
bench.figures = {"threads": runtime.threads(), "seconds": taken, "seconds_a_sphere": each}
bench.require("cost of a sphere among many over that among few", each["many"] / each["few"], at_most=2)
if "cKDTree" in taken:
    bench.require("search: times as fast as SciPy's", taken["cKDTree"] / taken["many, search alone"], at_least=5)
    bench.require("search and forces: times as fast as SciPy's search", taken["cKDTree"] / taken["many"], at_least=5)
bench.finish()
