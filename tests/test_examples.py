"""Everything in examples/, and every Python block of the README and docs/scripting.md, does what it says."""

import importlib
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.plugins import load_plugin

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
PLUGINS = [EXAMPLES / "swirl.py", EXAMPLES / "spiral.py"]


def blocks(page: str) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(encoding="utf-8"), re.M | re.S)


PAGES = [(page, k) for page in ("README.md", "docs/scripting.md") for k in range(len(blocks(page)))]


@pytest.mark.parametrize("page,k", PAGES)
def test_python_on_a_page_runs(page, k, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script = tmp_path / f"block_{k}.py"  # a file, because kernels read their source
    script.write_text(blocks(page)[k], encoding="utf-8")
    runpy.run_path(str(script), run_name="__main__")


def test_the_swirl_pushes_round(monkeypatch):
    """dv = strength (r x y) dt from rest, in one kick."""
    monkeypatch.syspath_prepend(str(ROOT))
    Swirl = importlib.import_module("examples.swirl").Swirl
    x = np.array([[1.0, 0.5, 0.0], [0.2, -1.0, -3.0]])
    system = ga.ParticleSystem(position=x, forces=[Swirl(strength=2.5)], integrator="semi_implicit_euler")
    sim = ga.Simulation({"s": system}, dt=0.01, precision="f64")
    sim.step(1)
    expected = 2.5 * np.cross(x, [0.0, 1.0, 0.0]) * 0.01
    assert np.abs(sim["s"].velocity - expected).max() < 1e-15
    assert np.abs(sim["s"].velocity + expected).max() > 0.01  # the mutant: the other way round


@pytest.mark.parametrize("script,argument,words", [
    ("flight_simulator", "bad.csv", "bad.csv: line 2: '1;2' is not a number"),
    ("flight_simulator", "none.csv", "none.csv: there is no such file"),
    ("submarine", "depth.csv", "depth.csv: has no column depth to give; the columns are time, flooded"),
    ("submarine", "time.csv", "time.csv: has no input beside time; give at least one of flooded"),
    ("submarine", "-x", "unrecognized arguments"), ("solar_system", "soon", "invalid float value: 'soon'"),
    ("solar_system", "0.1", "the nearest is 0 s"), ("solar_system", "nan", "the time to advance by must be a finite number s, not nan"),
])  # fmt: skip
def test_wrong_input_is_a_sentence(script, argument, words, tmp_path, monkeypatch, capsys):
    """And exit status 2, as of a wrong argument."""
    monkeypatch.chdir(tmp_path)
    for name, text in (("bad", "a;b\n1;2\n"), ("depth", "time,depth\n0,1\n"), ("time", "time\n0\n")):
        Path(f"{name}.csv").write_text(text)
    monkeypatch.setattr(sys, "argv", [f"{script}.py", argument])
    with pytest.raises(SystemExit) as left:
        runpy.run_path(str(EXAMPLES / f"{script}.py"), run_name="__main__")
    assert left.value.code == 2 and words in capsys.readouterr().err


@pytest.fixture(scope="module")
def pinwheel():
    for plugin in PLUGINS:
        load_plugin(plugin)
    overrides = {"knobs.push": 0, "systems.sparks.emitters.wheel.spiral.spread": 0, "clock.preroll": 0}
    return ga.load_preset(EXAMPLES / "swirl.yaml", overrides=overrides)


def test_the_spiral_gives_birth_on_its_line(pinwheel):
    sim = ga.Simulation(pinwheel, precision="f64")
    sim.step(1)
    sparks = sim["sparks"]
    x = sparks.position
    s = np.hypot(x[:, 0], x[:, 2]) / 1.2
    turn = np.arctan2(x[:, 2], x[:, 0]) / (2 * np.pi)
    off = np.abs((2 * s - turn + 0.5) % 1.0 - 0.5)  # turns away from the spiral
    assert sparks.count > 20
    assert off.max() < 0.02  # up to a sixtieth of a second of outward drift
    assert ((sparks.radius >= 0.005) & (sparks.radius <= 0.02)).all() and len(set(sparks.radius)) == sparks.count


def test_through_the_command_line(tmp_path):
    """A still by --plugin, and the same bytes again from the recipe inside it."""
    plugins = [word for path in PLUGINS for word in ("--plugin", str(path))]
    command = [sys.executable, str(ROOT / "cli.py")]
    options = ["--size", "64x36", "--set", "clock.preroll=0.5", "--threads", "2", "--progress", "none"]
    still = ["still", str(EXAMPLES / "swirl.yaml"), "--time", "0", "-o", "a.png", *plugins, *options]
    for arguments in (still, ["rerun", "a.png", "-o", "b.png", *plugins]):
        done = subprocess.run([*command, *arguments], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    assert np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).max() > 100
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_orbit(capsys):
    runpy.run_path(str(EXAMPLES / "orbit.py"), run_name="__main__")
    assert "energy -1.5" in capsys.readouterr().out


def test_the_flight_simulator_finds_the_phugoid_and_flies_a_file(capsys, monkeypatch):
    script = str(EXAMPLES / "flight_simulator.py")
    monkeypatch.setattr(sys, "argv", [script])
    runpy.run_path(script, run_name="__main__")
    measured, theory = (float(x) for x in re.findall(r"(\d+\.\d+) s", capsys.readouterr().out))
    assert measured == pytest.approx(theory, rel=0.01)
    monkeypatch.setattr(sys, "argv", [script, str(EXAMPLES / "flight_inputs.csv")])
    runpy.run_path(script, run_name="__main__")
    assert len(capsys.readouterr().out.splitlines()) == 12


def test_the_double_pendulum(capsys):
    runpy.run_path(str(EXAMPLES / "double_pendulum.py"), run_name="__main__")
    assert "m g l off" in capsys.readouterr().out


def test_the_submarine_hovers_dives_and_surfaces():
    log = np.array(runpy.run_path(str(EXAMPLES / "submarine.py"))["dive"](seconds=240.0))
    depth = log[:, 1]
    assert depth[1] == pytest.approx(30, abs=1e-6)
    assert depth.max() > 60 and np.abs(depth[-8:]).mean() < 12  # it bobs at the surface
