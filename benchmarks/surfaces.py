"""What does the surface of a liquid cost? 500,000 particles at 1280 x 720, by `draw: surface`, beside the same ones as discs.

Discs are `draw: sphere` with `blend: opaque`, even discs that hide what is behind them. The liquid is a body of particles that
fills half of the picture: found, smoothed, shaded and refracted in an even light, and once more over a ground that it shadows.
The figures of `process time` are seconds of all threads together.
"""

import time
from types import SimpleNamespace

import numpy as np
from _bench import Bench, alternate

from gen_art.backend import runtime
from gen_art.preset.look import Look
from gen_art.preset.surface import ground_of
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.surfaces.scene import Scene

bench = Bench("surfaces", __doc__)
n, rounds, size = (20_000, 1, (320, 180)) if bench.quick else (500_000, 7, (1280, 720))
bench.settings = {"particles": n, "rounds": rounds, "size": list(size), "threads": 2}
runtime.init("cpu", 2)

rng = np.random.default_rng(1)
points = rng.uniform([-1, 0, -1], [1, 0.5, 1], (3 * n, 3))
height = 0.25 + 0.06 * np.sin(4 * points[:, 0] + 1) * np.cos(3 * points[:, 2])
points = points[points[:, 1] < height][:n]
floats = np.zeros((10, n + 64), np.float32)
floats[:3, :n] = points.T
floats[6, :n], floats[8, :n], floats[9, :n] = 1.0, 0.6 * (1.0 / n) ** (1 / 3), np.inf
water = SimpleNamespace(
    floats=floats, birth=np.zeros(n + 64), key=rng.integers(0, 2**32, (2, n + 64), dtype=np.uint32), id=np.arange(n + 64),
    source=np.zeros(n + 64, np.int32), sources=[SimpleNamespace(name="all", tag=None)], count=n, channels={}, box=None,
    entries=(), booked=np.zeros((0, n + 64)),
)  # fmt: skip
members = {"water": SimpleNamespace(look=None, colliders=())}
sim = SimpleNamespace(time=0.0, systems={"water": water}, members=members, preset=None)
camera = Camera(position=(0.6, 1.2, 3.2), target=(0, 0.25, 0), fov=36)


def painter(look, ground=None):
    scene = Scene(None, ground_of(ground))
    return Painter(size, camera, {"water": Look.model_validate(look)}, scene=scene)


clear, mud = {"draw": "surface"}, {"draw": "surface", "liquid": {"clear": False}}
painters = {
    "discs": painter({"draw": "sphere", "blend": "opaque"}),
    "clear": painter(clear),
    "opaque": painter(mud),
    "clear, over a ground": painter(clear, "#888888"),
}
spent: dict[str, list[float]] = {name: [] for name in painters}


def paint(name):
    start = time.process_time()
    painters[name].paint(sim, 0.0)
    spent[name].append(time.process_time() - start)


medians = alternate(rounds, **{name: lambda name=name: paint(name) for name in painters})
process = {name: float(np.median(seconds[1:])) for name, seconds in spent.items()}
bench.figures = {"seconds": medians, "process time": process}
rows = [(f"{n:,} particles", "s", "process s", "of discs")]
for name in painters:
    rows.append((name, f"{medians[name]:.3f}", f"{process[name]:.3f}", f"{medians[name] / medians['discs']:.2f}"))
bench.table(rows)
bench.require("clear liquid, of discs", medians["clear"] / medians["discs"], at_most=1.5)
bench.finish()
