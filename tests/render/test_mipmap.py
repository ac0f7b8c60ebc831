"""Mipmaps: each level is the mean of two by two texels of the one before, also where only some rows hold anything."""

import numpy as np
import pytest

from gen_art.renderer.mipmap import mipmap_chain

SIDE = 32


def halved(level: np.ndarray) -> np.ndarray:
    half = len(level) // 2
    return level.reshape(half, 2, half, 2, 4).mean(axis=(1, 3))


@pytest.mark.parametrize("rows", [(0, 32), (5, 6), (5, 12), (31, 32), (15, 17), (0, 0)])
def test_each_level_halves_the_one_before(rows):
    level = np.zeros((SIDE, SIDE, 4), np.float32)
    level[slice(*rows)] = np.random.default_rng(1).uniform(-1, 1, (rows[1] - rows[0], SIDE, 4))
    chain, start, expected = mipmap_chain(level[slice(*rows)], rows[0]), 0, level.astype(np.float64)
    assert np.array_equal(chain, mipmap_chain(level))
    while True:
        side = len(expected)
        # sums of four numbers in float64, then one rounding to float32
        found = chain[start : start + side * side].reshape(side, side, 4)
        assert np.abs(found - expected).max() <= 2.0**-24 * 1.001
        start += side * side
        if side == 1:
            break
        expected = halved(expected)
    assert start == len(chain)
