"""How long do the large pieces take: a still, a first picture, a frame of a film at 1280x720, and how busy are the cores?"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from _bench import ROOT, Bench

from gen_art.backend.processor import cores

bench = Bench("pieces", __doc__)
SIZE = "64x36" if bench.quick else "1280x720"
# piece: first and last frame of two films that begin alike; the longer one has more frames of the time that matters
FILMS = {"wormhole": (90, 96, 120), "charged": (120, 126, 150), "fireworks": (90, 96, 120), "galaxy": (30, 32, 40)}
if bench.quick:
    FILMS = {"charged": (0, 1, 2)}
bench.settings = {"size": SIZE, "frames": FILMS}
CORES = cores()


def taken(*arguments: str) -> tuple[float, float]:
    """(wall seconds, core-seconds) of one command of gen-art, whose kernels are in the cache."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))}
    subprocess.run([sys.executable, str(ROOT / "cli.py"), *arguments], check=True, capture_output=True, env=environment)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


with tempfile.TemporaryDirectory() as folder:
    out = str(Path(folder) / "out.png")
    rows = [("piece", "seconds", "cores busy")]
    commands = {
        "galaxy, first picture": (8.0, "render", "galaxy", "--frames", "0"),
        "galaxy, still --time 1": (20.0, "still", "galaxy", "--time", "1"),
    }
    for name, (most, *command) in {} if bench.quick else commands.items():
        runs = [taken(*command, "-o", out, "--size", SIZE, "--overwrite") for _ in range(3)]
        wall, cores = sorted(runs)[1]
        bench.figures[name] = {"seconds": wall, "cores": cores}
        rows.append((name, f"{wall:.1f}", f"{cores / wall / CORES:.0%}"))
        bench.require(f"{name}, s", wall, at_most=most)
    for name, (first, shorter, longer) in FILMS.items():
        film, spent = str(Path(folder) / "out.mp4"), []
        for _ in range(1 if bench.quick else 3):
            runs = [
                taken("render", name, "-o", film, "--size", SIZE, "--frames", f"{first}..{last}", "--overwrite")
                for last in (shorter, longer)
            ]
            spent.append([(b - a) / (longer - shorter) for a, b in zip(*runs)])
        wall, cores = sorted(spent)[len(spent) // 2]
        bench.figures[f"{name}, a frame"] = {"seconds": wall, "cores": cores}
        rows.append((f"{name}, a frame", f"{wall:.3f}", f"{cores / wall / CORES:.0%}"))
        bench.require(f"{name}, cores busy in a film", cores / wall / CORES, at_least=0.85)
bench.table(rows)
bench.finish()
