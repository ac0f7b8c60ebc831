"""A sweep on several processes that is stopped: they end with it, what is made stays, and the next run goes on."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PIECE = """version: 1
clock: {duration: 2, fps: 25, step: 1/100}
systems:
  dots:
    particle: {radius: 0.1}
    emitters: {some: {count: 400, shape: {sphere: 1}}}
    look: {draw: disc}
camera: {position: [0, 0, 6], size: [160, 90]}
"""
# tests in the background of a shell run with SIGINT ignored, which a child inherits: the child heeds it again
START = "import runpy, signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); runpy.run_path(sys.argv.pop(1), run_name='__main__')"


def processes_of(folder: Path) -> list[int]:
    """The processes whose working directory is the folder."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            if Path(os.readlink(entry / "cwd")) == folder:
                found.append(int(entry.name))
        except OSError:
            continue
    return found


def sweep(folder: Path) -> subprocess.Popen:
    command = [sys.executable, "-c", START, str(ROOT / "cli.py"), "sweep", "piece.yaml", "-o", "out/{seed}.mkv"]
    command += ["--seeds", "1..6", "--workers", "2", "--threads", "1"]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.skipif(not Path("/proc/self/cwd").exists(), reason="reads /proc")
@pytest.mark.parametrize(
    ("number", "status", "last"), [(signal.SIGINT, 130, "stopped"), (signal.SIGTERM, 143, "terminated")]
)
def test_a_stopped_sweep_ends_its_processes_and_goes_on_later(tmp_path, number, status, last):
    (tmp_path / "piece.yaml").write_text(PIECE, encoding="utf-8")
    process = sweep(tmp_path)
    try:
        while not list(tmp_path.glob("out/?.mkv")):
            assert process.poll() is None, process.communicate()
            time.sleep(0.02)
        process.send_signal(number)
        _, err = process.communicate(timeout=120)
    finally:
        process.kill()
    assert process.returncode == status and "Traceback" not in err, err
    assert last in err.strip().splitlines()[-1]
    end = time.monotonic() + 60
    while processes_of(tmp_path):
        assert time.monotonic() < end, "a worker process goes on"
        time.sleep(0.05)
    before = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("out/?.mkv")}
    again = sweep(tmp_path)
    _, err = again.communicate(timeout=300)
    assert again.returncode == 0, err
    made = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("out/*")}
    assert sorted(made) == [f"{k}.mkv" for k in range(1, 7)]
    assert {name: made[name] for name in before} == before
