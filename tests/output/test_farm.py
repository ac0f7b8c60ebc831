"""A sweep on several processes: the files of the serial sweep, byte for byte, also when processes are killed or units fail."""

import importlib.util
import os
import signal
import threading
from pathlib import Path

import pytest

from gen_art.errors import DivergedError, OutputError, UsageError
from gen_art.output.farm import sweep_on_farm
from gen_art.output.partial_film import partial_path
from gen_art.output.sweep import plan_sweep, sweep
from gen_art.plugins import load_plugins
from gen_art.preset.variations import grid_of, parse_seeds, parse_vary

PRESET = {
    "name": "dots",
    "version": 1,
    "clock": {"duration": 1, "fps": 10, "step": "1/100"},
    "knobs": {"pull": {"value": 9.0}},
    "systems": {
        "dots": {
            "forces": {"spring": {"center": [0, 0, 0], "stiffness": "$pull"}},
            "particle": {"mass": 1.0},
            "emitters": {
                "some": {"count": 50, "shape": {"sphere": {"radius": 1}}, "velocity": {"constant": [0, 1, 0]}}
            },
            "look": {"draw": "disc", "radius": 0.1, "emission": {"intensity": 1}},
        }
    },
    "camera": {"height": 4},
}
SMALL = {"size": (64, 36), "precision": "f32"}


def plan(folder, seeds: str, *vary: str, end=".png", preset=PRESET, **options):
    names = "_".join(["{seed}", *("{" + one.partition("=")[0].rpartition(".")[2] + "}" for one in vary)])
    rows = grid_of([parse_seeds(seeds), *map(parse_vary, vary)])
    return plan_sweep(preset, f"{folder}/{names}{end}", rows, **SMALL, **options)


def contents(folder) -> dict[str, bytes]:
    # what a killed process was writing stays there unfinished, under a name that no other process uses
    return {path.name: path.read_bytes() for path in Path(folder).iterdir() if not path.name.startswith(".gen-art-")}


def children() -> set[int]:
    """The worker processes of this process."""
    listed = Path(f"/proc/{os.getpid()}/task").glob("*/children")
    numbers = {int(number) for path in listed for number in path.read_text().split()}
    return {number for number in numbers if b"spawn_main" in Path(f"/proc/{number}/cmdline").read_bytes()}


@pytest.fixture(autouse=True)
def _no_process_is_left():
    before = children()
    yield
    assert children() <= before


PLUGIN = '''
import gen_art as ga
from gen_art import ti

@ga.force("test_sideways")
class Sideways(ga.Force):
    """A push along x. a = strength."""

    strength: float = ga.param(1.0, unit="m/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        return ti.Vector([q.strength, 0.0, 0.0])
'''


def test_the_files_are_those_of_the_serial_sweep(tmp_path, monkeypatch):
    """Pictures and films; the paths are relative to the folder in which the command runs."""
    monkeypatch.chdir(tmp_path)
    told, counted = [], []
    units = plan("one", "1,2", "knobs.pull=4,9", end=".png") + plan("one", "3", "knobs.pull=4,9", end=".mkv")
    paths = sweep_on_farm(
        units, workers=2, threads=1, tell=told.append, done=lambda k, unit: counted.append((k, unit.path))
    )
    assert paths == [unit.path for unit in units]
    assert [k for k, _ in counted] == [1, 2, 3, 4, 5, 6] and {path for _, path in counted} == set(paths)
    assert len(told) == 1 and "127.0.0.1" in told[0]
    sweep(plan("other", "1,2", "knobs.pull=4,9", end=".png") + plan("other", "3", "knobs.pull=4,9", end=".mkv"))
    made = contents("one")
    assert made == contents("other") and len(set(made.values())) == 6


def test_what_a_killed_process_was_making_is_made_by_another(tmp_path):
    """Two of twelve are there when a process is killed in the midst of another; nothing is lost."""
    killed = []

    def kill(k, unit):
        if k == 2:
            killed.append(max(children()))
            os.kill(killed[0], signal.SIGKILL)

    sweep_on_farm(plan(tmp_path / "one", "1..12", time=0.5), workers=2, threads=1, done=kill)
    assert killed and not Path(f"/proc/{killed[0]}").exists()
    sweep(plan(tmp_path / "other", "1..12", time=0.5))
    made = contents(tmp_path / "one")
    assert made == contents(tmp_path / "other") and len(made) == 12


@pytest.mark.proof
def test_a_process_killed_every_ten_seconds_loses_nothing(tmp_path):
    """Two hundred pictures, of which each takes a good part of a second; the killed process is another one each time."""
    killed, ended = [], threading.Event()

    def kill():
        while not ended.wait(10.0):
            alive = sorted(children())
            if alive:
                killed.append(alive[len(killed) % len(alive)])
                os.kill(killed[-1], signal.SIGKILL)

    dots = PRESET["systems"]["dots"]
    some = {**dots["emitters"]["some"], "count": 500_000}
    many = {**PRESET, "systems": {"dots": {**dots, "emitters": {"some": some}}}}
    thread = threading.Thread(target=kill)
    thread.start()
    try:
        sweep_on_farm(plan(tmp_path / "one", "1..200", time=0.9, preset=many), workers=2, threads=1)
    finally:
        ended.set()
        thread.join()
    assert len(killed) >= 3
    made = contents(tmp_path / "one")
    assert len(made) == 200 and len(set(made.values())) == 200
    sweep(plan(tmp_path / "other", "1,100,200", time=0.9, preset=many))
    assert {name: made[name] for name in contents(tmp_path / "other")} == contents(tmp_path / "other")


def test_what_a_process_left_that_died_is_no_obstacle(tmp_path):
    """A film that was made, but not reported; a part of another one; and pictures moved by a plugin."""
    plugin = tmp_path / "sideways.py"
    plugin.write_text(PLUGIN, encoding="utf-8")
    plugins = load_plugins([plugin])
    dots = PRESET["systems"]["dots"]
    moved = {**PRESET, "systems": {"dots": {**dots, "forces": {**dots["forces"], "test_sideways": 3.0}}}}

    def planned(folder):
        films = plan(tmp_path / folder, "1,2", end=".mkv")
        return films, plan(tmp_path / folder, "3", preset=moved, plugins=plugins)

    films, pictures = planned("other")
    sweep(films)
    sweep(pictures, plugins=plugins)
    films, pictures = planned("one")
    (tmp_path / "one").mkdir()
    films[0].path.write_bytes((tmp_path / "other" / "1.mkv").read_bytes())
    before = films[0].path.stat().st_mtime_ns
    partial_path(films[1].path).write_bytes(b"what was written until then")
    sweep_on_farm(films, workers=1, threads=1)
    assert films[0].path.stat().st_mtime_ns == before
    sweep_on_farm(pictures, workers=1, threads=1, plugins=plugins)
    assert contents(tmp_path / "one") == contents(tmp_path / "other")


def test_a_unit_that_fails_stops_no_other(tmp_path, capfd):
    """Its error names it, and nothing of Dask reaches the terminal."""
    units = plan(tmp_path, "1", "knobs.pull=1e37,2e37,9", time=0.5)
    with pytest.raises(DivergedError) as caught:
        sweep_on_farm(units, workers=1, threads=1)
    assert [path.name for path in tmp_path.iterdir()] == [units[2].path.name]
    notes = caught.value.__notes__
    assert notes[0] == f"this is of {units[0].path} ({units[0].label})" and len(notes) == 2
    assert notes[1].startswith(f"{units[1].path} ({units[1].label}) failed too: ")
    assert capfd.readouterr() == ("", "")


def test_a_scheduler_that_runs_already(tmp_path):
    """Its worker may be given several units at once: it makes one after the other, and stays for the next sweep."""
    from distributed import LocalCluster

    told = []
    with LocalCluster(n_workers=1, threads_per_worker=2, host="127.0.0.1", dashboard_address=None) as cluster:
        for seeds in ("1..4", "5"):
            sweep_on_farm(
                plan(tmp_path / "one", seeds, time=0.5),
                scheduler=cluster.scheduler_address,
                threads=1,
                tell=told.append,
            )
    assert told == [f"Dask's scheduler is at {cluster.scheduler_address}"] * 2
    sweep(plan(tmp_path / "other", "1..5", time=0.5))
    assert contents(tmp_path / "one") == contents(tmp_path / "other")


def test_what_is_made_starts_no_process(tmp_path):
    sweep(plan(tmp_path, "1", time=0.5))
    told = []
    assert sweep_on_farm(plan(tmp_path, "1", time=0.5), workers=2, tell=told.append) == [tmp_path / "1.png"]
    assert not told


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({}, UsageError, "give one of them"),
        ({"workers": 2, "scheduler": "tcp://127.0.0.1:1"}, UsageError, "give one of them"),
        ({"workers": 0}, UsageError, "workers must be"),
        ({"scheduler": "nowhere"}, UsageError, "--scheduler nowhere: is no address such as tcp://10.0.0.5:8786"),
        ({"scheduler": "tcp://127.0.0.1:1"}, OutputError, "tcp://127.0.0.1:1: no Dask scheduler answers there"),
    ],
)
def test_wrong_farms(tmp_path, monkeypatch, options, error, words):
    monkeypatch.setattr("gen_art.output.farm._ANSWER", 1.0)
    with pytest.raises(error, match=words):
        sweep_on_farm(plan(tmp_path, "1"), **options)


def test_without_distributed(tmp_path, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "distributed" else find(name))
    with pytest.raises(UsageError, match=r"needs the package distributed, .* pip install 'gen-art\[farm\]'"):
        sweep_on_farm(plan(tmp_path, "1"), workers=1)
