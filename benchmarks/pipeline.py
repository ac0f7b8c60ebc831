"""Do the stages of a film overlap? A million small particles at 1920 x 1080 as H.264 `web`, against its stages' core-seconds."""

import tempfile
import time
from pathlib import Path

import numpy as np
from _bench import Bench

from gen_art.backend import processor, runtime
from gen_art.output import job
from gen_art.output.formats import find_format
from gen_art.output.playback import Playback
from gen_art.output.stills import write_still
from gen_art.output.video import film_writer
from gen_art.preset import load_preset
from gen_art.renderer.tone_map import develop

# Each stage runs alone, and the processor time of the whole process says what it took of the cores; their sum over the cores
# is the least wall time a film can have. The film then runs as `gen-art render` makes it. Simulating includes building the
# simulation, encoding includes YUV and joining the segments; compiling is over before. PNGs are measured the same way.

bench = Bench("pipeline", __doc__)
count, (width, height), seconds, rounds = (5_000, (320, 180), 2, 1) if bench.quick else (1_000_000, (1920, 1080), 6, 3)
cores = processor.cores()
FPS, STILLS = 30, 4 if bench.quick else 30
PRESET = load_preset({
    "version": 1, "name": "pipeline", "clock": {"duration": seconds, "fps": FPS, "step": "1/60"},
    "medium": {"curl_noise": {"strength": 0.6, "scale": 0.8, "speed": 0.5, "octaves": 2}},
    "systems": {
        "dust": {
            "particle": {"lifetime": 100}, "forces": {"damping": {"rate": 4}},
            "emitters": {"burst": {"at": [0], "count": count, "shape": {"sphere": 1.2}}},
            "look": {"draw": "point", "emission": {"color": {"by": "speed", "range": "0..1", "gradient": ["blue", "orange"]}}},
        },
    },
    "camera": {"position": [0, 0, 6], "target": [0, 0, 0], "fov": 30, "size": [width, height]},
})  # fmt: skip


class Stages:
    """Processor seconds of each stage."""

    def __init__(self):
        self.taken: dict[str, float] = {}
        self._nested = 0.0

    def measure(self, name, function, *args, **options):
        """Call a function; what stages inside it take is theirs."""
        outer, self._nested, start = self._nested, 0.0, time.process_time()
        try:
            return function(*args, **options)
        finally:
            spent = time.process_time() - start
            self.taken[name] = self.taken.get(name, 0.0) + spent - self._nested
            self._nested = outer + spent


def alone(folder: Path, frames: int, film: bool) -> dict[str, float]:
    """Processor seconds of the stages of a film, or of a sequence of PNGs."""
    stages, pictures = Stages(), []
    run = stages.measure("simulate", Playback, PRESET, (width, height), "f32", cores)
    step = run.sim.step
    run.sim.step = lambda steps: stages.measure("simulate", step, steps)
    clock = PRESET.clock
    films = run.pictures([clock.preroll_steps + k * clock.steps_per_frame for k in range(frames)])
    for k in range(frames):
        light, exposure = stages.measure("draw", next, films)
        pictures.append(stages.measure("develop", develop, light, PRESET.develop, frame=k, exposure=exposure))
    if film:
        path = folder / "alone.mp4"
        writer = stages.measure("encode", film_writer, path, (width, height), FPS, None, find_format(path))
        for picture in pictures:
            stages.measure("encode", writer.add, picture)
        stages.measure("encode", writer.close)
    else:
        for k, picture in enumerate(pictures):
            stages.measure("encode", write_still, folder / f"alone_{k}.png", picture)
    return stages.taken


def whole(folder: Path, frames: int, name: str) -> float:
    """Wall seconds of the command's work."""
    start = time.perf_counter()
    job.render(PRESET, folder / name, frames=range(frames), threads=cores, overwrite=True)
    return time.perf_counter() - start


runtime.init(threads=cores)
bench.settings = {
    "particles": count,
    "size": [width, height],
    "frames": seconds * FPS,
    "stills": STILLS,
    "rounds": rounds,
}
with tempfile.TemporaryDirectory() as temporary:
    folder = Path(temporary)
    whole(folder, 2, "first.mp4")
    for title, name, frames in (("film", "film.mp4", seconds * FPS), ("sequence", "a_####.png", STILLS)):
        shares, walls = [], []
        for _ in range(rounds):
            shares.append(alone(folder, frames, title == "film"))
            walls.append(whole(folder, frames, name))
        taken = {stage: float(np.median([one[stage] for one in shares])) for stage in shares[0]}
        ratios = [wall / (sum(one.values()) / cores) for wall, one in zip(walls, shares)]
        rows = [(f"{title}, {frames} frames", "core-s", "core-ms a frame")]
        rows += [(stage, f"{s:.2f}", f"{1e3 * s / frames:.1f}") for stage, s in taken.items()]
        rows.append((f"sum over {cores} cores", f"{sum(taken.values()) / cores:.2f}", ""))
        bench.table([*rows, ("wall", f"{np.median(walls):.2f}", f"{1e3 * np.median(walls) / frames:.1f}")])
        bench.figures[title] = {"core_seconds": taken, "wall": float(np.median(walls)), "ratios": ratios}
        if title == "film":
            bench.require(
                "wall time of the film over its stages' core-seconds / cores", float(np.median(ratios)), at_most=1.1
            )
        else:
            bench.require("the same of a sequence of PNGs", float(np.median(ratios)), at_most=1.25)
bench.finish()
