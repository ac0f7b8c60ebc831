"""The cost of developing 1920 x 1080: bloom, tone map, dither, 8 bits, against reading the light and writing the picture."""

import numpy as np
from _bench import Bench, alternate

from gen_art.backend import runtime
from gen_art.backend.runtime import kernel, ti
from gen_art.preset.develop import DevelopSpec
from gen_art.renderer.auto_exposure import metered_stops
from gen_art.renderer.bloom import as_vectors, bloom_pyramid
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.tone_map import develop

bench = Bench("develop", __doc__)
runtime.init(threads=2)
rounds, (width, height) = (1, (320, 180)) if bench.quick else (60, (1920, 1080))
bench.settings = {"rounds": rounds, "size": [width, height], "threads": 2}

LANES, CHUNKS = 32, 180


@ti.kernel
def _read(linear: ti.types.ndarray(ti.f32, 1), sums: ti.types.ndarray(ti.f32, 1)):
    ti.loop_config(block_dim=1)
    tiles = linear.shape[0] // CHUNKS // LANES
    for b in range(CHUNKS):
        s = ti.Vector([0.0] * LANES)
        for t in range(tiles):
            for j in range(LANES):
                s[j] += linear[(b * tiles + t) * LANES + j]
        sums[b] = s.sum()


@ti.kernel
def _write(picture: ti.types.ndarray(ti.i32, 1), value: ti.i32):
    ti.loop_config(block_dim=1)
    words = picture.shape[0] // CHUNKS
    for b in range(CHUNKS):
        for t in range(words):
            picture[b * words + t] = value


read, write = kernel(_read), kernel(_write)
linear = FrameBuffer((width, height)).pixels  # as the renderer keeps it
linear[:] = np.random.default_rng(0).exponential(0.2, linear.shape)
plane, sums, picture = linear.reshape(-1), np.zeros(CHUNKS, np.float32), np.empty((height, width, 3), np.uint8)
words = picture.reshape(-1).view(np.int32)


def once():
    read(plane, sums)
    write(words, 7)


plain = DevelopSpec(bloom=0)
pyramid = bloom_pyramid(width, height)
things = {
    "read the film, write the picture": once,
    "develop": lambda: develop(linear, out=picture),
    "of this, without bloom": lambda: develop(linear, plain, out=picture),
    "of this, the halos": lambda: pyramid.scatter(*as_vectors(linear), 0.5),
    "metering for automatic exposure": lambda: metered_stops(linear),
}
taken = alternate(rounds, **things)
floor = taken["read the film, write the picture"]
bench.table([("", "ms", "times the floor"), *((k, f"{1e3 * s:.2f}", f"{s / floor:.2f}") for k, s in taken.items())])
bench.figures = {"seconds": taken, "bytes_a_second": (linear.nbytes + picture.nbytes) / floor}
bench.require("develop, times reading and writing once", taken["develop"] / floor, at_most=4.0)
bench.finish()
