"""Elementary functions against NumPy in extended precision, and random streams against their NumPy twin."""

import numpy as np
import pytest

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.maths import array_functions, elementary
from gen_art.maths import random as rng

CASES = {
    "exp": (elementary.exp, np.exp, -80, 80, True),
    "log": (elementary.log, np.log, 1e-3, 100, False),
    "sin": (elementary.sin, np.sin, -1000, 1000, False),
    "cos": (elementary.cos, np.cos, -1000, 1000, False),
    "phi": (elementary.phi, lambda z: -np.expm1(-z) / z, -20, 60, True),
}


def values(function, x, precision):
    real = runtime.DTYPES[precision]

    @ti.kernel
    def run(a: ti.types.ndarray(real, 1), out: ti.types.ndarray(real, 1)):
        ti.loop_config(block_dim=1)
        for b in range(a.shape[0] // 16):
            for j in range(16):
                out[b * 16 + j] = function(a[b * 16 + j])

    out = np.zeros_like(x)
    runtime.kernel(run, precision)(x, out)
    return out


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("name", CASES)
def test_accuracy(name, precision):
    function, reference, low, high, relative = CASES[name]
    dtype = np.float32 if precision == "f32" else np.float64
    x = np.random.default_rng(0).uniform(low, high, 1 << 16).astype(dtype)
    exact = reference(x.astype(np.longdouble))
    error = np.abs(values(function, x, precision) - exact)
    unit = np.abs(exact) if relative else np.maximum(np.abs(exact), 1)
    assert float((error / unit).max()) <= 2 * np.finfo(dtype).eps


@pytest.mark.parametrize("name,low,high,relative", [
    ("exp", -700, 700, True), ("log", 1e-3, 100, False), ("sin", -1000, 1000, False), ("cos", -1000, 1000, False),
    ("arctanh", -0.999, 0.999, False), ("expm1", -700, 700, True), ("expm1", -1e-3, 1e-3, True),
])  # fmt: skip
def test_array_functions(name, low, high, relative):
    x = np.random.default_rng(0).uniform(low, high, 1 << 16)
    exact = getattr(np, name)(x.astype(np.longdouble))
    error = np.abs(getattr(array_functions, name)(x) - exact)
    unit = np.abs(exact) if relative else np.maximum(np.abs(exact), 1)
    assert float((error / unit).max()) <= 4 * np.finfo(float).eps
    assert getattr(array_functions, name)(0.5) == getattr(array_functions, name)(np.array([0.5]))[0]


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_limits(precision):
    dtype = np.float32 if precision == "f32" else np.float64
    x = np.array([0.0, 1e-30, 1e4, 1e30] * 4, dtype)
    assert np.array_equal(values(elementary.phi, x, precision)[:2], [1.0, 1.0])
    assert np.all(values(elementary.phi, x, precision)[2:4] <= 1.01e-4)
    assert np.array_equal(values(elementary.exp, -x, precision)[2:4], [0.0, 0.0])


def test_streams_are_the_same_in_kernels_and_numpy():
    n = 4096
    keys = rng.derive(np.uint64(7), np.arange(n))
    words = np.stack([(keys >> np.uint64(32)).astype(np.uint32), (keys & np.uint64(0xFFFFFFFF)).astype(np.uint32)])

    from gen_art.emitters.birth_kernel import make_stream

    @ti.kernel
    def run(K: ti.types.ndarray(ti.u32, 2), out: ti.types.ndarray(ti.f64, 1)):
        ti.loop_config(block_dim=1)
        for b in range(1):
            for i in range(out.shape[0]):
                r = make_stream(K[1, i], K[0, i])
                out[i] = r.uniform(17)

    out = np.zeros(n)
    runtime.kernel(run, "f64")(words, out)
    assert np.array_equal(out, rng.uniform(keys, 17))


def test_keys_are_the_same_in_kernels_and_numpy():
    """Mutants: another of the two shifts, a factor's last bit, the number without its offset."""
    numbers = np.append(np.arange(1000), [2**31, 2**32 + 5, 2**40, 2**62]).astype(np.int64)
    keys = rng.derive(np.uint64(2**63 + 11), numbers + 1)

    @ti.kernel
    def run(keys: ti.types.ndarray(ti.u64, 1), numbers: ti.types.ndarray(ti.i64, 1), out: ti.types.ndarray(ti.u64, 1)):
        for i in range(out.shape[0]):
            out[i] = rng.child_key(keys[i], ti.cast(numbers[i], ti.u64))

    out = np.zeros(len(numbers), np.uint64)
    runtime.kernel(run, "f64")(keys, numbers, out)
    assert np.array_equal(out, rng.derive(keys, numbers))


def test_streams_are_uniform_and_independent():
    keys = rng.derive(np.uint64(3), np.arange(200_000))
    u, v = rng.uniform(keys, 1), rng.uniform(keys, 2)
    assert (u > 0).all() and (u < 1).all()
    counts = np.bincount((u * 100).astype(int), minlength=100)
    assert ((counts - 2000) ** 2 / 2000).sum() < 150  # chi squared, 99 degrees of freedom, p about 1e-3
    assert abs(np.corrcoef(u, v)[0, 1]) < 0.01
    assert abs(np.corrcoef(u[:-1], u[1:])[0, 1]) < 0.01
    assert len(np.unique(keys)) == len(keys)


@pytest.mark.parametrize("n", [1, 2, 7, 10])
def test_median(n):
    """Mutants: the upper of the two middle numbers; the numbers as they come."""
    x = np.random.default_rng(n).normal(0, 1, n)
    assert array_functions.median(x) == np.median(x)
    assert array_functions.median(x.reshape(n, 1)) == np.median(x)
