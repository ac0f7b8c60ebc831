"""How long until the first picture? `gen-art still fire --time 1` against a bare start of Taichi, and cold compile times."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from _bench import ROOT, Bench

from gen_art.preset.shipped import preset_names

# What the command takes beyond simulating, drawing and writing does not depend on how much there is to simulate, so it is
# measured with few particles, where it is not lost in the noise of the work: a process that runs the command twice, its
# wall time less twice what the second picture takes, when every kernel is loaded. The whole command's time stands beside
# it. A cold compile: the time a preset of few particles takes to the middle of its film with an empty cache less the time
# it takes with a full one.
BARE = "import taichi as ti; ti.init(arch=ti.cpu)"
WHOLE = "import sys; from gen_art.commands.main import main; main(sys.argv[1:])"
TWICE = """
import json, sys, time
from gen_art.commands.main import leave, run
assert run(sys.argv[1:]) == 0
started = time.perf_counter()
assert run(sys.argv[1:]) == 0
print(json.dumps({"second": time.perf_counter() - started}))
leave(0)
"""
TINY = """
import sys
from gen_art.preset.thinning import thinned
from gen_art.output import job
from gen_art.preset import load_preset
piece, frame = load_preset(sys.argv[1]), int(sys.argv[3])
few, _ = thinned(piece, piece.clock.simulated, 50)
job.still(few, sys.argv[2], frame / piece.clock.fps, size=(64, 36), overwrite=True)
"""


def process(code: str, *arguments: str, cache: Path) -> tuple[float, str]:
    """Wall seconds of a Python process, and its last line."""
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    environment = {**os.environ, "PYTHONPATH": paths, "GEN_ART_CACHE": str(cache)}
    environment |= {"PYTHONPYCACHEPREFIX": str(cache.parent / "bytecode")}  # as installed: modules are compiled once
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    started = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, env=environment, cwd=cache.parent
    )
    taken = time.perf_counter() - started
    if code == BARE and done.returncode == -signal.SIGSEGV:  # one in thirty: its check for a new version races the exit
        return process(code, *arguments, cache=cache)
    if done.returncode:
        raise SystemExit(f"exit status {done.returncode}\n{done.stderr}\n{done.stdout}")
    return taken, (done.stdout.strip().splitlines() or [""])[-1]


def middle(name: str) -> int:
    """A frame by which everything in the piece has begun."""
    from gen_art.preset import load_preset

    return load_preset(name).clock.frames // 2


bench = Bench("startup", __doc__)
rounds = 1 if bench.quick else 15
names = ["charged"] if bench.quick else preset_names()
still = ["still", "fire", "--time", "1", "-o", "fire.png", "--overwrite"]
few = [*still, "--set", "knobs.fuel=200"]
if bench.quick:
    still = few = [*few, "--size", "64x36", "--set", "clock.preroll=0"]
bench.settings = {"rounds": rounds, "command": "gen-art " + " ".join(few), "presets": names}

with tempfile.TemporaryDirectory() as folder:
    warm = Path(folder, "warm")
    warm.mkdir()
    process(TWICE, *few, cache=warm)
    bare, beyond = [], []
    for _ in range(rounds):
        bare.append(process(BARE, cache=warm)[0])
        wall, line = process(TWICE, *few, cache=warm)
        beyond.append(wall - 2 * json.loads(line)["second"])
    start, over = float(np.median(bare)), float(np.median(beyond))
    whole = process(WHOLE, *still, cache=warm)[0]
    bench.table([
        ("", "s"), ("import taichi, ti.init", f"{start:.2f}"), ("still fire, beyond simulating and writing", f"{over:.2f}"),
        ("still fire, all of it", f"{whole:.2f}"),
    ])  # fmt: skip
    cold = {}
    rows = [("", "empty cache, s", "full cache, s", "compiling, s")]
    for name in names:
        frame = 4 if bench.quick else middle(name)
        cache = Path(folder, name)
        cache.mkdir()
        first, second = (process(TINY, name, f"{name}.png", str(frame), cache=cache)[0] for _ in range(2))
        cold[name] = {"empty_cache": first, "full_cache": second, "compiling": first - second}
        rows.append((name, f"{first:.1f}", f"{second:.1f}", f"{first - second:.1f}"))
    total = sum(one["compiling"] for one in cold.values())
    bench.table([*rows, ("together", "", "", f"{total:.1f}")])

bench.figures = {"bare_taichi": start, "beyond": over, "whole": whole, "cold": cold, "compiling_together": total}
bench.require("start-up as a multiple of Taichi's own", over / start, at_most=3.0)
bench.finish()
