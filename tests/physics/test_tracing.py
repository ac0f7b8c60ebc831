"""Tracing leanly gives what Taichi's own way gives: the same results, the same kernels in the cache, the same words for an error."""

import os
import subprocess
import sys

import numpy as np
import pytest

from gen_art.backend import runtime, tracing_patch
from gen_art.backend.runtime import ti

F1 = ti.types.ndarray(ti.f32, 1)


@ti.func
def raised(x, n: ti.template()):
    value = x
    for _ in ti.static(range(n)):
        value *= x
    return value


@ti.func
def inner(x):
    return raised(x, 1) + raised(raised(x, 1), 2)


class Maths:
    @ti.func
    def square(self, x):
        return x * x


MATHS = Maths()


@ti.kernel
def _nested(x: F1):
    for i in range(x.shape[0]):
        x[i] = inner(inner(x[i])) + MATHS.square(x[i])


@ti.func
def wrong(x):
    return x + nowhere  # noqa: F821


@ti.kernel
def _wrong(x: F1):
    for i in range(x.shape[0]):
        x[i] = wrong(x[i])


@ti.func
def branching(x, k):
    y = x
    if k == 1:
        y = -x
    for _ in range(k):
        y *= 2.0
    return y


@ti.real_func
def called(x: ti.f32, k: ti.i32) -> ti.f32:
    return branching(x, k)


@ti.kernel
def _calls(x: F1):
    for i in range(x.shape[0]):
        x[i] = called(x[i], i)


@pytest.fixture(autouse=True)
def started():
    runtime.init()


def test_a_function_inlined_within_its_own_arguments():
    def once(v):
        return v**2 + v**6

    x = np.array([0.5, 1.0], np.float32)
    runtime.kernel(_nested)(x)
    assert np.allclose(x, [once(once(0.5)) + 0.25, once(once(1.0)) + 1.0])


def test_a_kernel_is_traced_again_for_another_precision():
    """Its tree is used a second time: what the first pass wrote into it must not be seen."""
    function = runtime.kernel(_again)
    function(single := np.ones(3, np.float32))
    function(double := np.ones(3))
    assert single.tolist() == double.tolist() == [3.0, 3.0, 3.0]


@ti.kernel
def _again(x: ti.types.ndarray(ndim=1)):
    for i in range(x.shape[0]):
        x[i] += 2.0


def test_an_error_names_the_line_and_shows_it():
    with pytest.raises(ti.TaichiNameError) as error:
        runtime.kernel(_wrong)(np.ones(1, np.float32))
    words = str(error.value)
    assert 'Name "nowhere" is not defined' in words
    assert "in wrong:\n    return x + nowhere" in words and "^^^^^^^" in words
    assert "in _wrong:\n        x[i] = wrong(x[i])" in words


def test_a_function_under_an_if_is_still_found():
    x = np.full(1, 2.0, np.float32)
    runtime.kernel(_uses_hidden)(x)
    assert x[0] == 4.0


if True:

    @ti.func
    def hidden(x):
        return x * x


@ti.kernel
def _uses_hidden(x: F1):
    for i in range(x.shape[0]):
        x[i] = hidden(x[i])


def test_no_tree_stays_in_use_after_an_error():
    with pytest.raises(ti.TaichiNameError):
        runtime.kernel(_wrong)(np.ones(1, np.float32))
    assert not tracing_patch._in_use


@pytest.mark.parametrize("lean", [True, False])
def test_the_cache_serves_both_ways_of_tracing(lean, tmp_path):
    """One process fills the cache, another finds every kernel in it, whichever of the two traces leanly."""
    code = """
import sys
from gen_art.backend import tracing_patch
if sys.argv[1] == "plain":
    tracing_patch.install = lambda: None
import gen_art as ga
from gen_art.backend import runtime
sim = ga.Simulation(ga.load_preset("fire", overrides={"seed": 1}), threads=1)
sim.step(2)
print(sim.digest())
runtime.finish()
"""
    env = {**os.environ, "GEN_ART_CACHE": str(tmp_path)}
    order = ["lean", "plain"] if lean else ["plain", "lean"]
    digests, files = [], []
    for way in order:
        done = subprocess.run([sys.executable, "-c", code, way], capture_output=True, text=True, env=env)
        assert done.returncode == 0, done.stderr
        digests.append(done.stdout.split()[-1])
        files.append({path.name for path in tmp_path.rglob("*.tic")} | {path.name for path in tmp_path.rglob("*.ll")})
    assert digests[0] == digests[1]
    assert files[0] and files[0] == files[1]


def test_branches_and_loops_stay_inside_the_real_function_that_uses_them():
    x = np.ones(4, np.float32)
    runtime.kernel(_calls)(x)
    assert x.tolist() == [1.0, -2.0, 4.0, 8.0]
