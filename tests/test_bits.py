"""The same bytes for any number of threads, any run, a warm and a cold cache; and presets through the command line."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gen_art.preset.load import load_preset
from gen_art.preset.shipped import preset_names
from tests.small import SMALL

ROOT = Path(__file__).parents[1]

SCRIPT = """
import hashlib, json, sys
from pathlib import Path
import gen_art as ga
from gen_art.output.job import render
threads, folder = int(sys.argv[1]), Path(sys.argv[2])
small = json.loads(sys.stdin.read())
out = {}
for name, overrides in small.items():
    preset = ga.load_preset(name, overrides=overrides)
    sim = ga.Simulation(preset, threads=threads)
    sim.step(40)
    frames = render(preset, folder / (name + "_####.png"), frames=range(2), size=(96, 54), threads=threads)
    out[name] = [sim.digest(), *(hashlib.sha256(p.read_bytes()).hexdigest() for p in frames)]
if "fireworks" in small:
    preset = ga.load_preset("fireworks", overrides=small["fireworks"])
    film = render(preset, folder / "f.mp4", frames=range(4), size=(96, 54), threads=threads)
    out["film"] = hashlib.sha256(film[0].read_bytes()).hexdigest()
print(json.dumps(out))
"""


def digests(folder: Path, threads: int, names=tuple(SMALL), cache: str | None = None) -> dict:
    folder.mkdir()
    small = json.dumps({name: SMALL[name] for name in names})
    env = {**os.environ, "PYTHONPATH": str(ROOT), **({"GEN_ART_CACHE": cache} if cache else {})}
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(threads), str(folder)], input=small, capture_output=True, text=True, env=env,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


@pytest.fixture(scope="module")
def two_threads(tmp_path_factory):
    return digests(tmp_path_factory.mktemp("bits") / "two", 2)


def test_one_thread_and_two_give_the_same_bytes(two_threads, tmp_path):
    one = digests(tmp_path / "one", 1)
    assert one == two_threads
    assert len({v[0] for k, v in one.items() if k != "film"}) == len(SMALL)


def test_a_cold_cache_gives_the_same_bytes(two_threads, tmp_path):
    cold = digests(tmp_path / "cold", 2, ("galaxy", "wormhole"), str(tmp_path / "cache"))
    assert cold == {name: two_threads[name] for name in cold} and len(cold) == 2


@pytest.mark.parametrize("name", ["fire", "galaxy", "charged"])
def test_a_preset_renders_through_the_command_line(name, tmp_path):
    settings = [word for key, value in SMALL[name].items() for word in ("--set", f"{key}={value}")]
    out = tmp_path / "a.png"
    run = subprocess.run(
        [sys.executable, "-m", "gen_art", "still", name, "-o", str(out), "--time", "0", "--size", "96x54", "--progress", "none", *settings],
        capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == str(out)
    assert run.stderr == ""
    from PIL import Image

    with Image.open(out) as picture:
        assert picture.size == (96, 54)
        assert picture.convert("L").getextrema()[1] > 40  # something is lit


def test_every_preset_has_a_small_version():
    assert sorted(SMALL) == preset_names()


@pytest.mark.parametrize("name", SMALL)
def test_the_small_version_is_the_preset(name):
    """The overrides change counts and the preroll alone."""
    assert all(k.split(".")[-1] in ("rate", "fuel", "count", "preroll") for k in SMALL[name])
    load_preset(name, overrides=SMALL[name])
