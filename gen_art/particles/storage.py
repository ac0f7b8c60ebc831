"""Structure-of-arrays storage of one system's particles."""

import numpy as np

from gen_art.errors import MemoryRefused
from gen_art.particles.rows import CHARGE, FIRST_ATTRIBUTE, LIFETIME, MASS, RADIUS

__all__ = ["BASE_ROWS", "PADDING", "Particles"]

BASE_ROWS = {"mass": MASS, "charge": CHARGE, "radius": RADIUS, "lifetime": LIFETIME}
PADDING = 64  # slots past the end that a tile may read and write
_TOLERATED = 0.2  # share of dead slots that is cheaper to carry than to remove
_PATIENCE = 32  # launches after which the dead are counted


class Particles:
    """One (channels, capacity) float array and the whole-number columns beside it.

    floats (channels, capacity) f32 or f64     birth (capacity,) f64, s: the exact time of birth
    key (2, capacity) uint32: high word, low word of the random stream     id (capacity,) int64, never reused
    source (capacity,) int32: which of `sources` it came from
    Slots [0, count) are in order of id. One is dead when birth + lifetime <= time; `tidy` removes the dead, stably.
    """

    def __init__(self, dtype, attributes: tuple[str, ...] = (), sources: tuple = (), capacity: int = 1024):
        self.channels = {**BASE_ROWS, **{name: FIRST_ATTRIBUTE + k for k, name in enumerate(attributes)}}
        self.attributes = tuple(attributes)
        self.sources = list(sources)
        self.count = 0
        self.next_id = 0
        self.may_die = False
        self._untidy = self._look_at = 0
        self._allocate(np.dtype(dtype), capacity)

    def _allocate(self, dtype, capacity: int) -> None:
        size = capacity + PADDING
        if size >= 2**31 // max(1, FIRST_ATTRIBUTE + len(self.attributes)):
            raise MemoryRefused(f"{capacity:,} particles in one system are more than an array's index can reach")
        try:
            self.floats = np.zeros((FIRST_ATTRIBUTE + len(self.attributes), size), dtype)
            self.birth = np.zeros(size, np.float64)
            self.key = np.zeros((2, size), np.uint32)
            self.id = np.zeros(size, np.int64)
            self.source = np.zeros(size, np.int32)
        except MemoryError:
            raise MemoryRefused(f"no memory for {capacity:,} particles") from None
        self.floats[MASS] = 1.0  # a lane past the end computes too: give it a mass
        self.capacity = capacity

    def columns(self):
        """Every array, with the particle on the last axis."""
        return (self.floats, self.birth, self.key, self.id, self.source)

    def reserve(self, extra: int) -> None:
        """Make room for `extra` more particles; the capacity grows by half at least."""
        if self.count + extra <= self.capacity:
            return
        old, n = self.columns(), self.count
        self._allocate(self.floats.dtype, max(self.count + extra, self.capacity * 3 // 2))
        for new, previous in zip(self.columns(), old):
            new[..., :n] = previous[..., :n]

    def append(self, birth, key, source) -> slice:
        """Add particles with these births (f64), keys (uint64) and sources; returns their slots. Ids follow on."""
        m = len(birth)
        self.reserve(m)
        new = slice(self.count, self.count + m)
        self.floats[:, new] = 0.0
        self.birth[new] = birth
        self.key[0, new] = key >> np.uint64(32)
        self.key[1, new] = key & np.uint64(0xFFFFFFFF)
        self.id[new] = np.arange(self.next_id, self.next_id + m)
        self.source[new] = source
        self.next_id += m
        self.count += m
        return new

    def death(self, slots=slice(None)) -> np.ndarray:
        """Times of death (f64) of the used slots."""
        used = slice(0, self.count)
        return (self.birth[used] + self.floats[LIFETIME, used].astype(np.float64))[slots]

    def alive(self, time: float) -> np.ndarray:
        """Which used slots hold a particle that lives at `time` (bool)."""
        return (self.death() > time) & (self.birth[: self.count] <= time)

    def tidy(self, time: float, at_once: bool) -> bool:
        """Remove the dead when they may be many (or `at_once`, when there are any), keeping the order. True if slots moved.

        Carrying some costs less than removing them each step; nothing visible depends on when it happens.
        """
        self._untidy += 1
        if (
            not self.may_die
            or not self.count
            or not (at_once or self._untidy >= _PATIENCE or self.next_id > self._look_at)
        ):
            return False
        self._untidy, self._look_at = 0, self.next_id + max(int(_TOLERATED * self.count), 1024)
        keep = np.flatnonzero(self.death() > time)
        if len(keep) == self.count or (not at_once and len(keep) > self.count * (1.0 - _TOLERATED)):
            return False
        for column in self.columns():
            column[..., : len(keep)] = column[..., keep]
        self.count = len(keep)
        return True

    @property
    def nbytes(self) -> int:
        return sum(column.nbytes for column in self.columns())
