"""Launching leanly does what Taichi's own way does, and vectors stay whole."""

import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from gen_art.backend import runtime
from gen_art.backend.runtime import ti


def _kernels():
    lanes = ti.types.ndarray(ti.types.vector(8, ti.f32), 1)

    @ti.kernel
    def scaled(x: ti.types.ndarray(), n: ti.i32, by: ti.f32):
        for i in range(n):
            x[i] = x[i] * by

    @ti.kernel
    def together(x: lanes, y: lanes):
        for i in range(x.shape[0]):
            y[i] = ti.sqrt(x[i] * x[i] + y[i]) - x[i]

    return runtime.kernel(scaled), runtime.kernel(together), runtime.kernel(together, vectors=True)


@pytest.fixture(scope="module")
def kernels():
    runtime.init()
    return _kernels()


def test_later_launches_take_other_arrays_numbers_and_types(kernels):
    scale = kernels[0]
    for dtype in (np.float32, np.float64, np.float32, np.int32):
        for n, by in ((3, 2.0), (5, 3.0), (np.int64(4), np.float32(0.5))):
            x = np.arange(6).astype(dtype) * 4
            expected = x.copy()
            expected[:n] = (expected[:n] * by).astype(dtype)
            scale(x, n, by)
            assert np.array_equal(x, expected), (dtype, n, by)


def test_a_launch_takes_only_the_arguments_that_changed(kernels):
    scale = kernels[0]
    x, y = np.ones(4, np.float32), np.ones(4, np.float32)
    for array, n, by, expected in (
        (x, 4, 2.0, [2, 2, 2, 2]), (x, 4, 2.0, [4, 4, 4, 4]), (y, 4, 2.0, [2, 2, 2, 2]), (x, 2, 2.0, [8, 8, 4, 4]),
        (x, 2, 0.5, [4, 4, 4, 4]), (x, 4, 0.5, [2, 2, 2, 2]),
    ):  # fmt: skip
        scale(array, n, by)
        assert np.array_equal(array, expected)
    for k in range(50):  # each array at the address of one before that is gone
        fresh = np.full(4 + k % 2, k, np.float32)
        scale(fresh, 4, 2.0)
        assert (fresh[:4] == 2 * k).all()


def test_no_launch_keeps_an_array_alive(kernels):
    x = np.ones(4, np.float32)
    for _ in range(3):
        kernels[0](x, 4, 2.0)
    gone = weakref.ref(x)
    del x
    assert gone() is None


def test_threads_may_launch_the_same_kernel(kernels):
    def work(seed):
        x = np.full(3, seed, np.float32)
        for _ in range(200):
            kernels[0](x, 3, 2.0)
            kernels[0](x, 3, 0.5)
        return (x == seed).all()

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(1, 9)))


def test_what_taichi_refuses_is_refused_at_every_launch(kernels):
    scale = kernels[0]
    x = np.arange(12, dtype=np.float32)
    for _ in range(2):
        scale(x[:6], 3, 2.0)
        with pytest.raises(ValueError, match="contiguous"):
            scale(x[::2], 3, 2.0)
        with pytest.raises((TypeError, ti.TaichiRuntimeTypeError)):
            scale(x[:6], 2.5, 2.0)


def test_a_bound_launch_reads_its_arrays_anew_each_time(kernels):
    x, y = np.arange(4, dtype=np.float32), np.ones(4, np.float32)
    twice, thrice = kernels[0].bound(x, 3, 2.0), kernels[0].bound(y, 4, 3.0)
    for k in range(1, 4):
        twice()
        thrice()
        assert np.array_equal(x, [0, 2**k, 2 * 2**k, 3]) and (y == 3**k).all()


def test_whole_vectors_give_the_same_bits(kernels):
    rng = np.random.default_rng(0)
    _, apart, whole = kernels
    for _ in range(2):
        x, y, z = (runtime.aligned((50, 8), np.float32) for _ in range(3))
        x[:], y[:] = rng.normal(0, 3, x.shape), rng.uniform(0, 2, y.shape)
        z[:] = y
        expected = np.sqrt(x * x + y) - x
        apart(x, y)
        whole(x, z)
        assert np.array_equal(y, expected) and np.array_equal(z, expected)


def test_vectors_at_a_crooked_address_are_refused(kernels):
    crooked = runtime.aligned(8 * 51, np.float32)[1 : 1 + 400].reshape(50, 8)
    with pytest.raises(ValueError, match=r"runtime\.aligned"):
        kernels[2](crooked, runtime.aligned((50, 8), np.float32))
