"""How much memory does a particle take, and does `inspect` predict the peak of a run?"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from _bench import ROOT, Bench

import gen_art as ga
from gen_art.preset import load_preset
from gen_art.preset.estimate import estimate
from gen_art.preset.shipped import preset_names
from gen_art.preset.thinning import thinned

# a liquid, which no shipped preset is
LIQUID = """
version: 1
clock: {duration: 0.5, fps: 30, step: 1/600}
forces: {gravity: [0, -9.81, 0]}
sky: {sun: 35}
ground: {albedo: white, checker: {size: 0.25, color: black}}
colliders: {box: {min: [-1, 0, -0.4], max: [1, 3, 0.4], restitution: 0, friction: 0}}
systems:
  water:
    particle: {radius: 0.02, density: 1000}
    integrator: semi_implicit_euler
    interactions: {contacts: {restitution: 0.1, friction: 0, duration: 1/80}}
    emitters: {spout: {rate: 4000, shape: {disc: 0.25, center: [-0.6, 1.3, 0]}, velocity: [0.5, -3, 0]}}
    look: {draw: surface, radius: 0.03, liquid: {color: teal, distance: 0.6}}
camera: {position: [1.2, 1.3, 3.0], target: [0, 0.25, 0], fov: 36}
"""
RUN = """
import resource, sys
from gen_art.commands.main import run
assert run(sys.argv[1:]) == 0
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(peak if sys.platform == "darwin" else peak * 1024)
"""
INSPECT = "import sys; from gen_art.commands.main import run; sys.exit(run(sys.argv[1:]))"


def gen_art(code: str, *arguments: str) -> str:
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": paths},
    )
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout.strip()


bench = Bench("memory", __doc__)
# what is made, of which preset, in which size; a film long enough for its encoder to be full
JOBS = (
    [("still", "charged", "320x180"), ("film", "charged", "320x180")]
    if bench.quick
    else [
        ("still", "fire", "1280x720"), ("still", "smoke", "1280x720"), *(
            ("still", name, "3840x2160") for name in ("wormhole", "fire", "fireworks", "smoke", "charged")
        ), ("film", "charged", "3840x2160"),
        *(("still", name, "3840x2160") for name in ("course/pour", "course/marbles", "course/flag", "liquid")),
    ]
)  # fmt: skip
FRAMES = 4 if bench.quick else 64
bench.settings = {"jobs": JOBS, "moment": "the last frame of a still's preset", "frames of a film": FRAMES}

rows = [("", "bytes a particle of state")]
largest = 0.0
for name in preset_names():
    few, _ = thinned(load_preset(name), 1.0, 50)
    for label, state in ga.Simulation(few).systems.items():
        share = state.nbytes / state.floats.shape[1]
        largest = max(largest, share)
        rows.append((f"{name}.{label}", f"{share:g}"))
        bench.figures.setdefault("bytes_a_particle", {})[f"{name}.{label}"] = share
bench.table(rows)

rows = [("", "size", "particles", "predicted, MB", "measured, MB", "predicted / measured")]
ratios = {}
with tempfile.TemporaryDirectory() as folder:
    for kind, title, size in JOBS:
        name = title
        if title == "liquid":
            name = os.path.join(folder, "liquid.yaml")
            Path(name).write_text(LIQUID, encoding="utf-8")
        short = ["--set", "clock.preroll=0", "--duration", "0.2"] if bench.quick else []
        piece = load_preset(name, overrides={"clock.preroll": 0, "clock.duration": 0.2} if bench.quick else None)
        last = (piece.clock.frames - 1) / piece.clock.fps
        told = json.loads(gen_art(INSPECT, "inspect", name, "--json", "--size", size, *short))
        moment = (
            ["still", name, "--time", f"{last!r}"]
            if kind == "still"
            else ["render", name, "--frames", f"0..{FRAMES - 1}"]
        )
        path = os.path.join(folder, f"{Path(name).stem}-{size}.{'png' if kind == 'still' else 'mp4'}")
        measured = float(gen_art(RUN, *moment, "--size", size, "-o", path, *short).splitlines()[-1])
        predicted, title = told["memory"][kind], f"{kind} of {title}"
        ratios[f"{title}, {size}"] = predicted / measured
        particles = round(estimate(piece).particles)
        figures = (f"{predicted / 1e6:.0f}", f"{measured / 1e6:.0f}", f"{predicted / measured:.2f}")
        rows.append((title, size, f"{particles:,}", *figures))
        bench.figures[f"{title}, {size}"] = {"particles": particles, "predicted": predicted, "measured": measured}
bench.table(rows)
bench.require("bytes a particle, the most of any system", largest, at_most=120)
for name, ratio in ratios.items():
    bench.require(f"{name}: predicted peak off by, per cent", 100 * abs(ratio - 1), at_most=20)
bench.finish()
