"""What do shadows and a ground that reflects cost? Frames at 1280 x 720, drawn in turns by one process.

Smoke: the preset `smoke` at its poster time, with `shadows: true` and `false`; balls: 2,000 on a ground, the same. Ground: 2,000
small discs under a sky, without a ground, over one, and over one that mirrors them smoothly and roughly; it fills three fifths of
the picture. Surfaces that rest are traced once for a film; "traced anew" is what each picture takes while the camera moves. The
figures of `process time` are seconds of all threads together.
"""

import time

import numpy as np
from _bench import Bench, alternate

from gen_art.backend import runtime
from gen_art.output.playback import Playback
from gen_art.preset import load_preset

bench = Bench("lighting", __doc__)
rounds, size = (1, (160, 90)) if bench.quick else (9, (1280, 720))
bench.settings = {"rounds": rounds, "size": list(size), "threads": 2}
runtime.init("cpu", 2)

GROUND = {"albedo": "#b0a898", "roughness": 0.1}
DISCS = {
    "version": 1, "name": "discs", "clock": {"duration": 1, "fps": 30, "step": "1/60"}, "sky": {"sun": 30},
    "systems": {
        "beads": {
            "emitters": {"burst": {"count": 2000, "shape": {"disc": 1.5, "center": [0, 1.0, 0]}}},
            "look": {"draw": "disc", "radius": 0.02},
        },
    },
    "camera": {"position": [2, 1.4, 3.5], "target": [0, 0.6, 0], "fov": 36},
}  # fmt: skip


BALLS = {
    "beads": {
        "particle": {"radius": 0.04}, "look": {"draw": "sphere", "blend": "opaque"},
        "emitters": {"burst": {"count": 2000, "shape": {"box": [[-1.5, 0.05, -1.5], [1.5, 0.65, 1.5]]}}},
    },
}  # fmt: skip


def smoke(shadows):
    preset = load_preset("smoke")
    return preset.model_copy(update={"shadows": shadows}), preset.poster_time


def ground(**keys):
    return load_preset(DISCS | keys), 0.1


scenes = {
    "smoke, no shadows": smoke(False),
    "smoke": smoke(True),
    "balls, no shadows": ground(ground=GROUND, systems=BALLS, shadows=False),
    "balls": ground(ground=GROUND, systems=BALLS),
    "discs": ground(),
    "discs over a ground": ground(ground=GROUND),
    "over a mirror": ground(ground=GROUND | {"mirror": True, "roughness": 0}),
    "over a rough mirror": ground(ground=GROUND | {"mirror": True}),
}
scenes |= {f"{name}, traced anew": scenes[name] for name in ("smoke", "discs over a ground", "over a rough mirror")}
playbacks, spent = {}, {name: [] for name in scenes}
for name, (preset, film_time) in scenes.items():
    run = Playback(preset, size, "f32", 2)
    run.picture(run.step_of(film_time))
    playbacks[name] = run


def draw(name):
    run, start = playbacks[name], time.process_time()
    if name.endswith("traced anew"):
        run.painter.forget_surfaces()
    run.painter.paint(run.sim, scenes[name][1])
    spent[name].append(time.process_time() - start)


medians = alternate(rounds, **{name: lambda name=name: draw(name) for name in scenes})
process = {name: float(np.median(seconds[1:] or seconds)) for name, seconds in spent.items()}
bench.figures = {"seconds": medians, "process time": process}
rows = [("frame", "ms", "process ms")]
for name in scenes:
    rows.append((name, f"{1e3 * medians[name]:.0f}", f"{1e3 * process[name]:.0f}"))
bench.table(rows)
bench.require("smoke, of that without shadows", medians["smoke"] / medians["smoke, no shadows"], at_most=1.25)
bench.require("balls, of those without shadows", medians["balls"] / medians["balls, no shadows"], at_most=1.15)
added = 1e3 * (medians["over a rough mirror"] - medians["discs"])
bench.require("a ground that rests and reflects roughly, ms more", added, at_most=60)
bench.finish()
