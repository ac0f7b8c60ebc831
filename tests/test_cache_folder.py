"""A cache folder that cannot be used: one sentence, the same picture, no crash."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOT = """version: 1
clock: {duration: 1, fps: 30, step: 1/30}
systems:
  dot:
    emitters: {start: {count: 1, shape: {point: [0, 0, 0]}}}
    look: {draw: pixel, emission: {intensity: 5}}
camera: {position: [0, 0, 3], target: [0, 0, 0], height: 2}
"""


def still(folder: Path, **environment):
    """(finished process, digest of the picture) with these variables; None removes one."""
    kept = {k: v for k, v in os.environ.items() if k not in environment}
    given = {k: str(v) for k, v in environment.items() if v is not None}
    picture = folder / "a.png"
    command = ["still", "-", "--time", "0", "--size", "32x18", "--overwrite", "-o", str(picture)]
    done = subprocess.run(
        [sys.executable, str(ROOT / "cli.py"), *command], input=DOT, env=kept | given, capture_output=True, text=True
    )
    return done, hashlib.sha256(picture.read_bytes()).hexdigest() if picture.exists() else None


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("usual")
    done, digest = still(folder, GEN_ART_CACHE=folder / "cache")
    assert (done.returncode, done.stderr) == (0, "") and any((folder / "cache").iterdir())
    return digest


@pytest.mark.parametrize(
    "case", ["no home", "empty home", "file", "below a file", "no folder can be made", "read-only"]
)
def test_a_cache_that_cannot_be_used_is_one_sentence(tmp_path, expected, case):
    (tmp_path / "file").touch()
    (tmp_path / "fixed").mkdir(mode=0o555)
    if case == "read-only" and os.access(tmp_path / "fixed", os.W_OK):
        pytest.skip("this user may write to a folder that is read-only")
    environment = {
        "no home": {"HOME": None, "XDG_CACHE_HOME": None, "GEN_ART_CACHE": None},
        "empty home": {"HOME": "", "XDG_CACHE_HOME": None, "GEN_ART_CACHE": None},
        "file": {"GEN_ART_CACHE": tmp_path / "file"},
        "below a file": {"GEN_ART_CACHE": None, "XDG_CACHE_HOME": tmp_path / "file" / "x"},
        "no folder can be made": {"GEN_ART_CACHE": "/proc/none"},
        "read-only": {"GEN_ART_CACHE": tmp_path / "fixed"},
    }[case]
    done, digest = still(tmp_path, TMPDIR=tmp_path, **environment)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("\n") == 1 and "gen-art: warning: " in done.stderr and "set GEN_ART_CACHE" in done.stderr
    assert digest == expected
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png", "file", "fixed"], "the temporary cache is gone"


def test_home_may_be_missing_where_the_cache_is_named(tmp_path, expected):
    done, digest = still(tmp_path, HOME=None, GEN_ART_CACHE=tmp_path / "cache")
    assert (done.returncode, done.stderr, digest) == (0, "", expected)
