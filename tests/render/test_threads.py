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

from tests.render.thread_scenes import SCENES, digest_of

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def on_other_numbers_of_threads():
    """The digests of all scenes on one thread and on four, from processes that run beside each other."""
    runs = [
        subprocess.Popen(
            [sys.executable, "-m", "tests.render.thread_scenes", str(threads)], cwd=ROOT, text=True, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        for threads in (1, 4)
    ]  # fmt: skip
    said = [run.communicate() for run in runs]
    for run, (_, error) in zip(runs, said):
        assert run.returncode == 0, error
    return [json.loads(out) for out, _ in said]


@pytest.mark.parametrize("name", SCENES)
def test_one_two_and_four_threads_draw_the_same_bytes(name, on_other_numbers_of_threads):
    here = digest_of(name)
    assert [each[name] for each in on_other_numbers_of_threads] == [here, here]
