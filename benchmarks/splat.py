"""How fast do points and small discs become light? Four million points, and a million discs, in a picture of 1920 x 1080.

Points: a disc galaxy seen from above, in the order in which they were drawn at random, and sorted by the pixel they fall in.
The renderer adds three colours, clears its framebuffer, and gives the same bits on any number of threads; datashader counts, in
one channel. Discs: 5 x 5 pixels, against a numba loop that adds the same discs to one thread's buffer.
"""

import numpy as np
from _bench import Bench, alternate

from gen_art.backend import runtime
from gen_art.renderer.direct_splat import discs, pixels, points
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.sprite import BLUE, FOOTPRINT, RED, X, Y

bench = Bench("splat", __doc__)
n, number, rounds, size = (20_000, 10_000, 1, (320, 180)) if bench.quick else (4_000_000, 1_000_000, 11, (1920, 1080))
bench.settings = {"points": n, "discs": number, "rounds": rounds, "size": list(size), "threads": 2}
runtime.init("cpu", 2)

width, height = size
rng = np.random.default_rng(0)
channels = runtime.aligned((11, n + 64), np.float32)  # as the shading kernel leaves them
radius = rng.exponential(0.18, n)
angle = 2 * np.log(radius + 0.01) + rng.uniform(0, 2 * np.pi, n)
channels[X, :n] = width / 2 + radius * 0.47 * width * np.cos(angle)
channels[Y, :n] = height / 2 + radius * 0.47 * height * np.sin(angle) + rng.normal(0, 0.008 * height, n)
channels[RED : BLUE + 1, :n] = rng.random((3, n))
order = np.argsort(np.clip(channels[Y, :n], 0, height - 1).astype(np.int64) * width + channels[X, :n].astype(np.int64))
in_order = runtime.aligned(channels.shape, np.float32)
in_order[:, :n] = channels[:, order]
round_ones = channels[:, : number + 64].copy()
round_ones[FOOTPRINT] = 2.4  # five pixels across, wherever it lies
framebuffer = FrameBuffer(size)


def draw(what, particles, how):
    framebuffer.clear()
    how(particles, what, framebuffer)


things = {
    "pixel": lambda: draw(n, channels, pixels),
    "point": lambda: draw(n, channels, points),
    "pixel, in order": lambda: draw(n, in_order, pixels),
    "point, in order": lambda: draw(n, in_order, points),
    "discs": lambda: draw(number, round_ones, discs),
}
try:
    import datashader
    import pandas

    canvas = datashader.Canvas(width, height, x_range=(0, width), y_range=(0, height))
    for name, these in (("datashader", channels), ("datashader, in order", in_order)):
        frame = pandas.DataFrame({"x": these[X, :n], "y": these[Y, :n]})
        things[name] = lambda frame=frame: canvas.points(frame, "x", "y", datashader.count())
except ImportError:
    print("  datashader is not installed and is left out")
try:
    import numba

    @numba.njit
    def deposit(x, y, colours, reach, buffer):
        """The same discs: weights (1 - t^2)^4 of columns and rows, scaled to the light of each."""
        buffer[:] = 0.0
        across, down = np.zeros(8, np.float32), np.zeros(8, np.float32)
        for i in range(x.shape[0]):
            left, top = int(np.floor(x[i] - reach)), int(np.floor(y[i] - reach))
            wide, high = np.float32(0), np.float32(0)
            for k in range(6):
                t = (left + k + np.float32(0.5) - x[i]) / reach
                s = max(np.float32(1) - t * t, np.float32(0))
                across[k] = s * s * s * s
                t = (top + k + np.float32(0.5) - y[i]) / reach
                s = max(np.float32(1) - t * t, np.float32(0))
                down[k] = s * s * s * s
                wide, high = wide + across[k], high + down[k]
            scale = 1 / (wide * high)
            for k in range(6):
                row = top + k
                if 0 <= row < buffer.shape[0]:
                    for m in range(6):
                        column = left + m
                        if 0 <= column < buffer.shape[1]:
                            weight = down[k] * across[m] * scale
                            for c in range(3):
                                buffer[row, column, c] += colours[c, i] * weight

    buffer = np.zeros((height, width, 4), np.float32)
    place = round_ones[X, :number].copy(), round_ones[Y, :number].copy()
    colours = round_ones[RED : BLUE + 1, :number].copy()
    things["numba discs"] = lambda: deposit(*place, colours, np.float32(2.4), buffer)
except ImportError:
    print("  numba is not installed and is left out")

taken = alternate(rounds, again=True, **things)
much = {name: number if "disc" in name else n for name in taken}
bench.table([
    ("", "ms", "M/s"), *((name, f"{1e3 * s:.1f}", f"{much[name] / s / 1e6:.1f}") for name, s in taken.items())
])  # fmt: skip
covered = 25.0 * number
print(f"  discs: {covered / taken['discs'] / 1e6:.0f} million covered pixels a second")
bench.figures = {"seconds": taken, "a_second": {k: much[k] / s for k, s in taken.items()},
                 "covered_pixels_a_second": covered / taken["discs"]}  # fmt: skip
if "datashader" in taken:
    for kind in ("pixel", "point"):
        for ending in ("", ", in order"):
            ratio = taken["datashader" + ending] / taken[kind + ending]
            bench.figures[f"{kind}{ending}, times datashader"] = ratio
            if not ending:
                bench.require(f"{kind}: times as fast as datashader's count", ratio, at_least=1.0)
if "numba discs" in taken:
    bench.require("discs: times as fast as numba", taken["numba discs"] / taken["discs"], at_least=3.0)
bench.finish()
