"""The movement of a hand-held camera: smooth noise as a function of time.

x(t) = sum over k of sqrt(2) a_k cos(2 pi (f_k t + p_k)), with the sum of a_k^2 = 1, so x has mean 0 and variance 1 over time.
The range from f / 2 to 2 f is divided into FREQUENCIES equal ratios; each holds one frequency f_k. Its place there and the
phase p_k are random numbers of the seed. a_k is proportional to 1 / f_k: a hand's speed, not its displacement, is the same at
all frequencies.
Source: Shinozuka and Deodatis, Simulation of stochastic processes by spectral representation (Applied Mechanics Reviews
44, 1991).
"""

import math

import numpy as np

from gen_art.maths.random import derive, uniform

__all__ = ["FREQUENCIES", "shake_noise"]

FREQUENCIES = 6


def shake_noise(time: float, frequency: float, seed: int, channels: int = 3) -> np.ndarray:
    """(channels,) independent values at film time `time`, each of mean 0 and standard deviation 1 over time.

    time : s
    frequency : Hz
    No value is beyond 3.4, which it reaches when all parts are at their maximum.
    """
    keys = derive(derive(np.uint64(seed), np.arange(channels))[:, None], np.arange(FREQUENCIES))
    octaves = 2.0 * (np.arange(FREQUENCIES) + uniform(keys, 0)) / FREQUENCIES - 1.0
    amplitude = 2.0**-octaves
    amplitude *= math.sqrt(2.0) / np.sqrt((amplitude * amplitude).sum(axis=1, keepdims=True))
    phases = np.mod(frequency * 2.0**octaves * time + uniform(keys, 1), 1.0)
    return (amplitude * np.cos(2.0 * math.pi * phases)).sum(axis=1)
