"""How fast is gravity between all pairs, directly beside a numba loop, and by the tree beside pytreegrav?"""

import numpy as np
from _bench import Bench, alternate

from gen_art.backend import runtime
from gen_art.interactions.pair_sums import field_kernel
from gen_art.interactions.tree_sum import sum_by_tree

bench = Bench("pairs", __doc__)
F = np.float32
SOFTENING = 0.01
TREES = ((3, 0.7), (4, 0.7), (4, 0.9), (5, 0.6))  # order, theta
direct_sizes, tree_sizes = ([512], [2_000]) if bench.quick else ([1024, 16_384], [100_000, 1_000_000])
crossing = [512] if bench.quick else [8_000, 12_000, 16_000, 20_000]  # bodies of which both ways are timed
rounds = 1 if bench.quick else 7
bench.settings = {
    "direct": direct_sizes,
    "tree": tree_sizes,
    "softening": SOFTENING,
    "order, theta": TREES,
    "rounds": rounds,
}
runtime.init()


def plummer(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (3, n), in scale radii, and masses of a Plummer sphere of mass 1."""
    r = np.random.default_rng(0)
    radius = (r.uniform(0, 0.999, n) ** (-2 / 3) - 1) ** -0.5
    way = r.normal(size=(3, n))
    return (way / np.linalg.norm(way, axis=0) * radius).astype(F), np.full(n, 1 / n, F)


def exact(x: np.ndarray, m: np.ndarray, of: np.ndarray) -> np.ndarray:
    """(3, len(of)), in float64."""
    x, m = x.astype(np.float64), m.astype(np.float64)
    out = np.zeros((3, len(of)))
    for k, i in enumerate(of):
        d = x - x[:, i : i + 1]
        out[:, k] = (m * d / ((d * d).sum(0) + SOFTENING**2) ** 1.5).sum(1)
    return out


def errors(found: np.ndarray, right: np.ndarray) -> dict[str, float]:
    e = np.linalg.norm(found - right, axis=0) / np.linalg.norm(right, axis=0)
    rms, (median, most) = np.sqrt((e * e).mean()), np.quantile(e, (0.5, 0.99))
    return {"rms": float(rms), "median": float(median), "99%": float(most), "largest": float(e.max())}


try:
    from _numba import numba_pairs
except ImportError:
    numba_pairs = None
    print("  numba is not installed and is left out")
try:
    import pytreegrav
except ImportError:
    pytreegrav = None
    print("  pytreegrav is not installed and is left out")

rows = [("all pairs", "gen_art, G pairs/s", "numba, G pairs/s", "ratio", "differ by")]
for n in direct_sizes:
    x, m = plummer(n)
    sources, numbers = np.ascontiguousarray(np.concatenate([x, m[None]])), np.array([1, SOFTENING**2], F)
    ours, theirs = np.zeros((2, 3, n), F)
    things = {"gen_art": lambda n=n, s=sources, q=numbers, out=ours: field_kernel(-2, "f32")(s, s, out, n, q)}
    apart = 0.0
    if numba_pairs:
        things["numba"] = lambda x=x, m=m, out=theirs: numba_pairs(x, m, F(SOFTENING**2), out)
        for sums in things.values():
            sums()
        apart = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
        assert apart < 1e-4, f"numba sums something else: {apart:.1e} apart"
    taken = alternate(rounds, **things)
    rate = {name: n * n / seconds / 1e9 for name, seconds in taken.items()}
    bench.figures[f"direct, {n}"] = {"giga_pairs_a_second": rate, "differ_by": apart}
    if numba_pairs:
        ratio = rate["gen_art"] / rate["numba"]
        rows.append((f"{n:,}", f"{rate['gen_art']:.2f}", f"{rate['numba']:.2f}", f"{ratio:.2f}", f"{apart:.0e}"))
        if n == direct_sizes[-1]:
            bench.require("direct sums, of numba's speed", ratio, at_least=0.8)
bench.table(rows)

rows = [("where the tree is faster", "direct, ms", "tree, ms")]
for n in crossing:
    x, m = plummer(n)
    sources, numbers = np.ascontiguousarray(np.concatenate([x, m[None]])), np.array([1, SOFTENING**2], F)
    out = np.zeros((3, n), F)
    taken = alternate(
        rounds,
        direct=lambda n=n, s=sources, q=numbers, out=out: field_kernel(-2, "f32")(s, s, out, n, q),
        tree=lambda x=x, m=m: sum_by_tree(x, None, m, SOFTENING, *reversed(TREES[-1]), "f32"),
    )
    bench.figures[f"direct and tree, {n}"] = taken
    rows.append((f"{n:,}", *(f"{1e3 * seconds:.1f}" for seconds in taken.values())))
bench.table(rows)

rows = [("tree", "bodies/s", "rms error", "median", "99%", "largest", "sum of forces")]
for n in tree_sizes:
    x, m = plummer(n)
    of = np.random.default_rng(1).choice(n, min(n, 1000), replace=False)
    right = exact(x, m, of)
    things = {
        f"gen_art, order {p}, theta {t}": lambda x=x, m=m, p=p, t=t: sum_by_tree(x, None, m, SOFTENING, t, p, "f32")
        for p, t in TREES
    }
    result: dict = {}
    for name, of_tree in things.items():
        found = of_tree()
        force = m * found.astype(np.float64)
        result[name] = errors(found[:, of], right)
        result[name]["sum of forces"] = float(np.abs(force.sum(1)).max() / np.abs(force).sum())
    if pytreegrav:
        place, mass, width = x.T.astype(np.float64).copy(), m.astype(np.float64), np.full(n, 2.8 * SOFTENING)

        def peer(place=place, mass=mass, width=width):
            return pytreegrav.Accel(place, mass, softening=width, theta=TREES[0][1], parallel=True, method="tree")

        result["pytreegrav"] = errors(peer()[of].T, right)
        things["pytreegrav"] = peer
    taken = alternate(min(rounds, 5), **things)
    bench.figures[f"tree, {n}"] = {"errors": result, "seconds": taken}
    for name, seconds in taken.items():
        values = [f"{v:.1e}" for v in result[name].values()]
        rows.append((f"{name}, {n:,}", f"{n / seconds / 1e6:.2f} M", *values, *[""] * (5 - len(values))))
    ours = [name for name in things if name != "pytreegrav"]
    most = max(result[name]["sum of forces"] for name in ours)
    bench.require(f"sum of the forces of {n:,}, of the sum of their magnitudes", most, at_most=1e-6)
    if pytreegrav and n == tree_sizes[-1]:
        bench.require(
            "tree, times as fast as pytreegrav at the same theta", taken["pytreegrav"] / taken[ours[0]], at_least=10
        )
        no_worse = [taken[name] for name in ours if result[name]["rms"] <= result["pytreegrav"]["rms"]]
        if no_worse:
            bench.require("the same, at an rms error no larger", taken["pytreegrav"] / min(no_worse), at_least=10)
bench.table(rows)

n = tree_sizes[0]
x, m = plummer(n)
of = np.random.default_rng(1).choice(n, min(n, 1000), replace=False)
right = exact(x, m, of)
rows = [(f"order, theta, {n:,}", "bodies/s", "rms error", "median", "99%", "largest")]
for order in (3, 4, 5, 6):
    for theta in (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0):

        def tree(t=theta, p=order):
            return sum_by_tree(x, None, m, SOFTENING, t, p, "f32")

        e = errors(tree()[:, of], right)
        seconds = alternate(min(rounds, 3), tree=tree)["tree"]
        bench.figures.setdefault(f"order {order}", {})[theta] = {**e, "seconds": seconds}
        rows.append((f"{order}, {theta}", f"{n / seconds / 1e6:.2f} M", *(f"{v:.1e}" for v in e.values())))
bench.table(rows)
bench.finish()
