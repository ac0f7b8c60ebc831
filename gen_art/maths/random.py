"""Counter-based random numbers: a value is a function of (key, channel) and does not depend on the order of calls.

Philox-2x32 with 10 rounds: counter (key low word, channel), key (key high word). The same function exists for kernels
(`Stream`) and for NumPy (`uniform`, `derive`), bit for bit.
Source: Salmon, Moraes, Dror, Shaw, Parallel random numbers: as easy as 1, 2, 3 (SC11).
"""

import zlib

import numpy as np

from gen_art.backend.runtime import real, ti
from gen_art.maths.blocks import in_blocks
from gen_art.maths.elementary import cos, log, sin

__all__ = ["channel_of", "child_key", "derive", "philox", "philox_numpy", "uniform", "Stream"]

_MULTIPLIER = 0xD256D193
_WEYL = 0x9E3779B9


def channel_of(name: str) -> int:
    """The channel number of an attribute's name: the same in every preset and every order of declaration."""
    return zlib.crc32(name.encode()) & 0x3FFFFFFF


def philox_numpy(c0, c1, key):
    """Two words (uint32) from counter words c0, c1 and a key word; arrays broadcast."""
    with np.errstate(over="ignore"):
        c0, c1, key = (np.asarray(a, dtype=np.uint64) for a in (c0, c1, key))
        mask = np.uint64(0xFFFFFFFF)
        for _ in range(10):
            product = c0 * np.uint64(_MULTIPLIER)
            c0, c1 = (product >> np.uint64(32)) ^ key ^ c1, product & mask
            key = (key + np.uint64(_WEYL)) & mask
    return c0.astype(np.uint32), c1.astype(np.uint32)


def _mixed(z):
    """A 64-bit bijection in which every input bit affects every output bit (SplitMix64's finaliser, variant 13)."""
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@in_blocks
def derive(key, number) -> np.ndarray:
    """A child key (uint64) of `key` (uint64) and a whole number of at least 0: H(key, number). Arrays broadcast.

    One-to-one in the number for a given key, and in the key for a given number.
    Source: Stafford's mixers; Steele, Lea, Flood, Fast splittable pseudorandom number generators (OOPSLA 2014).
    """
    with np.errstate(over="ignore"):
        key, number = np.asarray(key, np.uint64), np.asarray(number, np.uint64)
        inner = _mixed(number * np.uint64(0x9E3779B97F4A7C15) + np.uint64(0xD1B54A32D192ED03))
        return _mixed((key ^ inner) + np.uint64(0x9E3779B97F4A7C15))


@in_blocks
def uniform(key, channel: int) -> np.ndarray:
    """Float64 in (0, 1) for each uint64 key: the value of `r.uniform(channel)` in a float64 kernel."""
    key = np.asarray(key, np.uint64)
    a, b = philox_numpy(key & np.uint64(0xFFFFFFFF), channel, key >> np.uint64(32))
    return (a.astype(np.float64) * 2.0**-32) + (b >> np.uint32(12)).astype(np.float64) * 2.0**-52 + 2.0**-53


@ti.func
def _word(high: ti.template(), low: ti.template()):
    """64 bits from two constants of 32: Taichi takes no larger constant."""
    return (ti.u64(high) << ti.u64(32)) | ti.u64(low)


@ti.func
def _mixed_in_kernel(z):
    """_mixed of a u64."""
    y = (z ^ (z >> ti.u64(30))) * _word(0xBF58476D, 0x1CE4E5B9)
    y = (y ^ (y >> ti.u64(27))) * _word(0x94D049BB, 0x133111EB)
    return y ^ (y >> ti.u64(31))


@ti.func
def child_key(key, number):
    """`derive` in a kernel, bit for bit: both are u64."""
    inner = _mixed_in_kernel(number * _word(0x9E3779B9, 0x7F4A7C15) + _word(0xD1B54A32, 0xD192ED03))
    return _mixed_in_kernel((key ^ inner) + _word(0x9E3779B9, 0x7F4A7C15))


@ti.func
def philox(c0, c1, key):
    """Two words (u32) from counter words c0, c1 and a key word, all u32: the same as philox_numpy. It vectorises."""
    x, y, k = c0, c1, key
    for _ in ti.static(range(10)):
        product = ti.cast(x, ti.u64) * ti.u64(_MULTIPLIER)
        x = ti.cast(product >> ti.u64(32), ti.u32) ^ k ^ y
        y = ti.cast(product & ti.u64(0xFFFFFFFF), ti.u32)
        k += ti.u32(_WEYL)
    return x, y


# a real function is compiled once and called, instead of inlined at every draw: this halves the time to trace and compile a
# kernel of births
@ti.real_func
def _uniform(low: ti.u32, high: ti.u32, channel: ti.u32) -> ti.f64:
    """Uniform in (0, 1) from the two words of a key and a channel: 52 bits of the result of the ten rounds."""
    x, y, k = low, channel, high
    for _ in range(10):  # a run-time loop: unrolled, it would be a thousand nodes to trace
        product = ti.cast(x, ti.u64) * ti.u64(_MULTIPLIER)
        x = ti.cast(product >> ti.u64(32), ti.u32) ^ k ^ y
        y = ti.cast(product & ti.u64(0xFFFFFFFF), ti.u32)
        k = k + ti.u32(_WEYL)
    u = ti.cast(x, ti.f64) * ti.cast(2.0**-32, ti.f64)
    return u + ti.cast(y >> ti.u32(12), ti.f64) * ti.cast(2.0**-52, ti.f64) + ti.cast(2.0**-53, ti.f64)


class Stream:
    """The random stream of one particle inside a kernel: `r.uniform(channel)`, `r.normal(channel)`, `r.sphere(channel)`.

    Channels are whole numbers of the author's choice; the same channel always gives the same value. Values are computed in
    float64 and rounded to the kernel's precision, so float32 and float64 simulations have the same births.
    """

    _data_oriented = True

    def __init__(self, low, high, offset: int = 0):
        self._low, self._high, self._offset = low, high, offset

    @ti.func
    def uniform(self, channel):
        """Uniform in (0, 1)."""
        return ti.cast(_uniform(self._low, self._high, ti.cast(channel + self._offset, ti.u32)), real())

    @ti.func
    def range(self, bounds, channel):
        """Uniform between bounds[0] and bounds[1] (a `range` parameter)."""
        return bounds[0] + (bounds[1] - bounds[0]) * self.uniform(channel)

    @ti.func
    def normal(self, channel):
        """Standard normal, by the Box-Muller transform of this channel and channel + 0x40000000."""
        u, v = self.uniform(channel), self.uniform(channel + 0x40000000)
        return ti.sqrt(-2.0 * log(u)) * cos(6.283185307179586 * v)

    @ti.func
    def sphere(self, channel):
        """A direction uniform over the sphere (unit vector)."""
        z = 2.0 * self.uniform(channel) - 1.0
        angle = 6.283185307179586 * self.uniform(channel + 0x40000000)
        s = ti.sqrt(ti.max(1.0 - z * z, 0.0))
        return ti.Vector([s * cos(angle), s * sin(angle), z])
