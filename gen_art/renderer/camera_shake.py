"""The movement of a hand that holds a camera: smooth noise as a function of time.

x(t) = sum over k of sqrt(2) a_k cos(2 pi (f_k t + p_k)), with the sum of a_k^2 = 1: mean 0 and variance 1 over time. The
frequencies lie one in each of PARTS equal ratios from f / 2 to 2 f, their places in it and the phases p_k are drawn by the
seed, and a_k falls as 1 / f_k: a hand's speed, not its place, is alike at all frequencies.
Source: Shinozuka and Deodatis, Simulation of stochastic processes by spectral representation (Applied Mechanics Reviews
44, 1991).
"""

import math

import numpy as np

from gen_art.maths.random import derive, uniform

__all__ = ["PARTS", "shake_noise"]

PARTS = 6


def shake_noise(time: float, frequency: float, seed: int, channels: int = 3) -> np.ndarray:
    """(channels,) independent values at film time `time` (s), each of mean 0 and standard deviation 1 over time;
    frequency in Hz. No value is beyond 3.4, when all parts are at their crests.
    """
    keys = derive(derive(np.uint64(seed), np.arange(channels))[:, None], np.arange(PARTS))
    octave = 2.0 * (np.arange(PARTS) + uniform(keys, 0)) / PARTS - 1.0
    weight = 2.0**-octave
    weight *= math.sqrt(2.0) / np.sqrt((weight * weight).sum(axis=1, keepdims=True))
    turns = np.mod(frequency * 2.0**octave * time + uniform(keys, 1), 1.0)
    return (weight * np.cos(2.0 * math.pi * turns)).sum(axis=1)
