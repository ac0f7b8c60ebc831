"""Every benchmark still runs, with few particles, and writes what it measured."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"
SLOW = {"startup", "memory", "pieces", "studio", "watching", "lighting"}  # start many processes, or compile much
NAMES = sorted(path.stem for path in FOLDER.glob("[!_]*.py"))


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.proof if n in SLOW else ()) for n in NAMES])
def test_a_quick_run_writes_its_figures(name, tmp_path):
    command = [sys.executable, str(FOLDER / f"{name}.py"), "--quick", "--results", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / f"{name}.json").read_text())
    assert result["benchmark"] == name and result["quick"] and result["figures"]
    assert result["machine"]["cpu"] and result["machine"]["cores"] and result["machine"]["taichi"]
    assert name == "splat" or result["requirements"]


def test_the_readme_names_every_benchmark():
    text = (FOLDER / "README.md").read_text()
    assert NAMES and all(f"`{name}`" in text for name in NAMES)
