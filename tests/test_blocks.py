"""Functions of large arrays go block by block, with the same bits."""

import numpy as np
import pytest

from gen_art.maths import array_functions as maths
from gen_art.maths.random import derive, uniform

N = 3 * (1 << 14) + 5  # four blocks, the last one short
KEYS = np.arange(N, dtype=np.uint64)
X = np.random.default_rng(0).uniform(0.1, 5.0, N)


@pytest.mark.parametrize(
    "function, arguments",
    [(maths.exp, (X,)), (maths.log, (X,)), (maths.arctan2, (X, X[::-1])), (uniform, (KEYS, 3)), (derive, (7, KEYS))],
)
def test_blocks_change_no_bit(function, arguments):
    whole = function.__wrapped__(*arguments)
    assert function(*arguments).tobytes() == whole.tobytes()
    assert not np.array_equal(whole[: 1 << 14], whole[1 << 14 : 2 << 14])  # a block that is written twice is seen


def test_shapes_are_kept():
    assert maths.exp(X[:-2].reshape(3, -1)).shape == (3, (N - 2) // 3)
    assert maths.exp(1.0) == pytest.approx(np.e)
    assert derive(KEYS[:, None], KEYS[:3]).shape == (N, 3)
