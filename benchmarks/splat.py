"""How fast do points become light? Four million of them in a picture of 1920 x 1080, from particles to linear pixels."""

import numpy as np
from _bench import Bench, alternate

import gen_art as ga
from gen_art.renderer.film import Film, splat
from gen_art.renderer.frame import Painter

bench = Bench("splat", __doc__)
n, rounds, size = (20_000, 1, (320, 180)) if bench.quick else (4_000_000, 7, (1920, 1080))
bench.settings = {"points": n, "rounds": rounds, "size": list(size)}

r = np.random.default_rng(0)
system = ga.ParticleSystem(position=np.clip(r.normal(0, 0.9, (n, 3)), -2.0, 2.0))
sim = ga.Simulation({"points": system}, dt=0.01)
camera = ga.Camera(position=(0, 0, 10), target=(0, 0, 0), fov=30)
painter = Painter(size, camera)
painter.paint(sim, 0.0)
sprites, film = painter._sprites, Film(size)


def renderer_splat():
    film.clear()
    splat(sprites, film)


things = {"particles to picture": lambda: painter.paint(sim, 0.0), "of this, the splat": renderer_splat}

x, y, z = (sim.systems["points"].floats[c, :n].astype(np.float64) for c in range(3))
scale = size[1] / (2 * np.tan(np.radians(15)))
px, py = (
    (size[0] / 2 + scale * x / (10 - z)).astype(np.float32),
    (size[1] / 2 - scale * y / (10 - z)).astype(np.float32),
)
try:
    import numba

    @numba.njit
    def deposit(px, py, buffer):
        buffer[:] = 0.0
        for i in range(px.shape[0]):
            column, row = int(px[i]), int(py[i])
            if 0 <= column < buffer.shape[1] and 0 <= row < buffer.shape[0]:
                for c in range(4):
                    buffer[row, column, c] += np.float32(1)

    buffer = np.zeros((size[1], size[0], 4), np.float32)
    things["numba, one thread, one pixel a point"] = lambda: deposit(px, py, buffer)
except ImportError:
    print("  numba is not installed and is left out")
try:
    import datashader
    import pandas

    frame = pandas.DataFrame({"x": px, "y": py})
    canvas = datashader.Canvas(*size, x_range=(0, size[0]), y_range=(0, size[1]))
    things["datashader, counts"] = lambda: canvas.points(frame, "x", "y", datashader.count())
except ImportError:
    print("  datashader is not installed and is left out")

taken = alternate(rounds, **things)
bench.table([("", "ms", "M points/s"), *((k, f"{1e3 * s:.0f}", f"{n / s / 1e6:.1f}") for k, s in taken.items())])
inside = float(((px >= 0) & (px < size[0]) & (py >= 0) & (py < size[1])).mean())
bench.figures = {"seconds": taken, "points_a_second": {k: n / s for k, s in taken.items()}, "share_inside": inside}
bench.finish()
