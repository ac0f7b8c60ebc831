"""One, two and four threads draw the same bytes: every kernel of the renderer, layers, mirrors and lenses among them.

A kernel that adds up in the order in which threads come, as `out[i] += x` of two threads does, gives other bytes on four threads
than on one.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.render.thread_scenes import SCENES

ROOT = Path(__file__).parents[2]


pytestmark = pytest.mark.proof  # minutes: every kernel of the renderer is compiled


@pytest.fixture(scope="module")
def digests():
    """The digests of all scenes on one thread, two and four, from processes of their own; the first one compiles for the others."""
    said = []
    for threads in (1, 2, 4):
        run = subprocess.run(
            [sys.executable, "-m", "tests.render.thread_scenes", str(threads)],
            cwd=ROOT, text=True, capture_output=True, env={**os.environ, "PYTHONPATH": str(ROOT)},
        )  # fmt: skip
        assert run.returncode == 0, run.stderr
        said.append(json.loads(run.stdout))
    return said


@pytest.mark.parametrize("name", SCENES)
def test_one_two_and_four_threads_draw_the_same_bytes(name, digests):
    one, two, four = (each[name] for each in digests)
    assert one == two == four
