"""GEN_ART_STOCK_TAICHI=1 runs without the patches of Taichi and without bitcode, and gives the same bits."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.small import SMALL

ROOT = Path(__file__).resolve().parents[1]
PLAIN = {  # a collider, births and deaths, noise, a magnetic field, small sprites and large; no surfaces, which compile for long
    "version": 1, "seed": 3, "clock": {"duration": 1, "fps": 10, "step": "1/100"},
    "colliders": {"sphere": {"center": [0, 0.3, 0], "radius": 0.2}},
    "systems": {
        "fountain": {
            "particle": {"radius": 0.02, "lifetime": "0.05..0.3"},
            "forces": {"gravity": [0, -9.81, 0], "damping": 0.5, "curl_noise": {"strength": 1, "scale": 0.5}},
            "emitters": {"nozzle": {"rate": 30000, "velocity": {"cone": [0, 1, 0], "angle": 20, "speed": "1..3"}}},
            "look": {"draw": "disc", "radius": 0.02, "stretch": {"time": 0.02}},
        },
        "dust": {"emitters": {"box": {"count": 40000, "shape": {"sphere": 1}}}, "look": {"draw": "point"}},
        "ions": {
            "particle": {"radius": 0.01, "charge": 1}, "integrator": "boris",
            "forces": {"magnetic_field": {"field": [0, 0, 5]}},
            "emitters": {"source": {"count": 500, "velocity": {"sphere": 2}}},
            "look": {"draw": "streak", "width": 0.02},
        },
    },
    "camera": {"position": [0, 0, 4], "target": [0, 0, 0]},
}  # fmt: skip
PIECES = {  # colliders, rigid bodies, lit smoke, sprites that are only added, a magnetic field, no births
    "course/obstacles": {},
    "course/tower": {},
    "smoke": SMALL["smoke"],
    "charged": SMALL["charged"],
    "course/chain": {},
}
SCRIPT = """
import hashlib, json, sys
import gen_art as ga
from gen_art.backend import intrinsics, runtime
pieces, stock = json.loads(sys.stdin.read()), sys.argv[1] == "1"
assert runtime.STOCK_TAICHI == stock
assert not (stock and (intrinsics.HAS_PREFETCH or intrinsics.HAS_PACK or intrinsics.HAS_LANES))
import taichi.lang.kernel_impl as inside
assert inside._get_tree_and_ctx.__module__.startswith("taichi" if stock else "gen_art")
assert ("gen_art.backend.launch_patch" in sys.modules) != stock
found = {}
for name, overrides in pieces.items():
    preset = ga.load_preset(overrides) if "version" in overrides else ga.load_preset(name, overrides=overrides)
    sim = ga.Simulation(preset, threads=2)
    sim.advance_to_frame(1)
    picture = ga.render_frame(sim, size=(160, 90))
    assert picture.max() > 0
    found[name] = [sim.digest(), hashlib.sha256(picture.tobytes()).hexdigest()]
print(json.dumps(found))
"""


def run(stock: str, pieces: dict) -> dict:
    env = {**os.environ, "PYTHONPATH": str(ROOT), "GEN_ART_STOCK_TAICHI": stock}
    done = subprocess.run(
        [sys.executable, "-W", "error::RuntimeWarning", "-c", SCRIPT, stock],
        input=json.dumps(pieces), capture_output=True, text=True, env=env, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    "pieces", [{"plain": PLAIN}, pytest.param(PIECES, marks=pytest.mark.proof)], ids=["plain", "shipped"]
)
def test_stock_taichi_gives_the_same_bits(pieces):
    stock, patched = run("1", pieces), run("0", pieces)
    assert stock == patched and set(stock) == set(pieces)
    assert len({digest for digest, _ in stock.values()}) == len(pieces)


@pytest.mark.parametrize("stock", ["0", "1"])
def test_another_version_of_taichi_is_met_by_one_sentence(stock):
    script = """
import importlib.metadata as m
real = m.version
m.version = lambda name: "9.9.9" if name == "taichi" else real(name)
from gen_art.commands.main import main
main()
"""
    command = [sys.executable, "-c", script, "still", "course/cube", "-o", "never.png", "--time", "0", "--dry-run"]
    env = {**os.environ, "PYTHONPATH": str(ROOT), "GEN_ART_STOCK_TAICHI": stock}
    done = subprocess.run(command, capture_output=True, text=True, env=env)
    if stock == "1":
        assert done.returncode == 0, done.stderr
    else:
        assert done.returncode == 2
        assert done.stderr.startswith("gen-art: this version needs taichi 1.7.4, but 9.9.9 is installed")
        assert len(done.stderr.splitlines()) == 1
