"""The radix sort against NumPy's stable sort."""

import numpy as np
import pytest

from gen_art.backend import runtime
from gen_art.maths import radix_sort


@pytest.fixture(autouse=True)
def started():
    runtime.init()


@pytest.mark.parametrize("n", [0, 1, 1000, 40_000, 100_001])
@pytest.mark.parametrize("most", [1, 2, 1 << 10, 1 << 33, (1 << 64) - 1])
def test_the_order_is_numpy_s(n, most):
    keys = np.random.default_rng(n).integers(0, most, n, dtype=np.uint64, endpoint=False)
    before = keys.copy()
    assert np.array_equal(radix_sort.stable_order(keys), np.argsort(keys, kind="stable"))
    assert np.array_equal(keys, before)


def test_digits_that_all_keys_share_are_left_out():
    keys = np.random.default_rng(1).integers(0, 2, 50_000).astype(np.uint64) << np.uint64(50)
    assert np.array_equal(radix_sort.stable_order(keys), np.argsort(keys, kind="stable"))
