"""Structure-of-arrays storage of one system's particles."""

import math
from copy import copy

import numpy as np

from gen_art.backend.memory import available_memory
from gen_art.errors import MemoryRefused
from gen_art.particles.compaction import compact, slots_of_living
from gen_art.particles.entries import LedgerEntry
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.rows import CHARGE, FIRST_ATTRIBUTE, LIFETIME, MASS, POSITION, RADIUS

__all__ = ["BASE_ROWS", "PADDING", "Particles"]

BASE_ROWS = {"mass": MASS, "charge": CHARGE, "radius": RADIUS, "lifetime": LIFETIME}
PADDING = 64  # slots past the end that a tile may read and write
_TOLERATED = 0.2  # share of dead slots up to which keeping them is cheaper than removing them
_BIRTHS_BETWEEN_COUNTS = 0.25  # for each living particle; about as many die until the dead are counted again
_PATIENCE = 32  # launches after which the dead slots are counted


def _sum(values: list[float]) -> float:
    """The sum, correctly rounded, so that it depends on no order; not finite where that of the values is not."""
    try:
        return math.fsum(values)
    except (OverflowError, ValueError):  # beyond float64; or inf - inf
        with np.errstate(over="ignore", invalid="ignore"):
            return float(np.sum(values))


class Particles:
    """The state of one system's particles as arrays with the particle (slot) on the last axis.

    floats : (channels, capacity) f32 or f64, the state array; gen_art.particles.rows names its rows
    birth : (capacity,) f64, exact time of birth, s
    key : (2, capacity) uint32, high and low word of the key of the random stream
    id : (capacity,) int64, never reused
    source : (capacity,) int32, index into `sources`
    may_die, has_fixed : whether a particle may die, and whether one is fixed
    last_birth : s, the latest of all births so far
    count : number of used slots, [0, count), in the order of their ids
    box : the periodic box that all positions are in between steps; None in open space
    booked : (entries, capacity) f64, J: the share of each particle in the `entries` of the ledger since its birth. It is no
        part of the state: the ledger writes it, and no force reads it
    removed : by entry, J: the sum of the shares of the particles that were removed
    launches, count_at : launches since the dead were counted, and the next id above which they are counted again
    A particle is dead when birth + lifetime <= time; `tidy` removes the dead and keeps the order.
    """

    def __init__(
        self, dtype, attributes: tuple[str, ...] = (), sources: tuple = (), capacity: int = 1024,
        box: PeriodicBox | None = None, entries: tuple[LedgerEntry, ...] = (),
    ):  # fmt: skip
        self.channels = {**BASE_ROWS, **{name: FIRST_ATTRIBUTE + k for k, name in enumerate(attributes)}}
        self.attributes = tuple(attributes)
        self.sources = list(sources)
        self.box = box
        self.entries = tuple(entries)
        self.removed = [0.0] * len(self.entries)
        self.count = 0
        self.next_id = 0
        self.may_die = False
        self.has_fixed = False
        self.last_birth = -math.inf
        self.launches = 0
        self.count_at = 0
        self._allocate(np.dtype(dtype), capacity)

    def __repr__(self) -> str:
        with_attributes = f", with {', '.join(self.attributes)}" if self.attributes else ""
        return f"<Particles: {self.count:,} of {self.capacity:,} slots, {self.floats.dtype}{with_attributes}>"

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
            self.booked = np.zeros((len(self.entries), size), np.float64)
        except MemoryError:
            raise MemoryRefused(f"there is no memory for {capacity:,} particles") from None
        self.floats[MASS] = 1.0  # lanes past the end are computed too and must not divide by zero
        self.capacity = capacity

    def columns(self):
        """Every array of the state, with the particle on the last axis."""
        return (self.floats, self.birth, self.key, self.id, self.source)

    def _arrays(self):
        """Every array, with the particle on the last axis."""
        return (*self.columns(), self.booked)

    def reserve(self, extra: int) -> None:
        """Make room for `extra` more particles. If the capacity grows, it grows by at least half."""
        if self.count + extra <= self.capacity:
            return
        old, n = self._arrays(), self.count
        capacity = max(self.count + extra, self.capacity * 3 // 2)
        needed, free = capacity * self.nbytes / self.capacity, available_memory()
        if needed > free:
            raise MemoryRefused(
                f"{self.count + extra:,} particles in one system need {needed / 1e6:,.0f} MB more, and {free / 1e6:,.0f} MB are "
                "free: lower a rate, a count or a lifetime"
            )
        self._allocate(self.floats.dtype, capacity)
        for new, previous in zip(self._arrays(), old):
            new[..., :n] = previous[..., :n]

    def append(self, birth, key, source) -> slice:
        """Add particles with these times of birth (f64), keys (uint64) and sources; returns their slots."""
        new = self.grow(len(birth), float(np.max(birth, initial=-math.inf)))
        self.identify(new, birth, key, source)
        return new

    def grow(self, count: int, last_birth: float) -> slice:
        """Take slots for `count` more particles, the latest of them born at `last_birth`; returns them.

        They have their ids and zeros in all rows. Their times of birth, keys and sources are still to be written.
        """
        self.reserve(count)
        new = slice(self.count, self.count + count)
        self.floats[:, new] = 0.0
        self.booked[:, new] = 0.0
        self.id[new] = np.arange(self.next_id, self.next_id + count)
        self.last_birth = max(self.last_birth, last_birth)
        self.next_id += count
        self.count += count
        return new

    def identify(self, slots: slice | np.ndarray, birth, key, source) -> None:
        """Write the times of birth (f64), keys (uint64) and sources of the particles in these slots."""
        self.birth[slots] = birth
        self.key[0, slots] = key >> np.uint64(32)
        self.key[1, slots] = key & np.uint64(0xFFFFFFFF)
        self.source[slots] = source

    def with_tags(self, tags: tuple[str, ...]) -> "Particles":
        """The particles whose source has one of these tags, as a copy; themselves if all have."""
        wanted = np.array([getattr(source, "tag", None) in tags for source in self.sources], bool)
        slots = np.flatnonzero(wanted[self.source[: self.count]])
        return self if len(slots) == self.count else self.some(slots)

    def some(self, slots: np.ndarray) -> "Particles":
        """A copy of the particles in these slots."""
        some = copy(self)
        some.count = some.capacity = len(slots)
        padded = np.append(slots, np.zeros(PADDING, slots.dtype))
        some.floats, some.birth, some.key, some.id, some.source, some.booked = (
            np.take(column, padded, axis=-1) for column in self._arrays()
        )
        return some

    def death(self, slots=slice(None)) -> np.ndarray:
        """Times of death (f64) of the used slots."""
        used = slice(0, self.count)
        return (self.birth[used] + self.floats[LIFETIME, used].astype(np.float64))[slots]

    def alive(self, time: float) -> np.ndarray:
        """Bools: which used slots have a particle that is alive at `time`."""
        if not self.may_die and self.last_birth <= time:
            return np.ones(self.count, bool)
        return (self.death() > time) & (self.birth[: self.count] <= time)

    def wrap(self, slots: slice) -> None:
        """Move these particles into the periodic box, if there is one."""
        if self.box is not None:
            self.box.wrap(self.floats[POSITION, slots])

    def tidy(self, time: float, at_once: bool) -> bool:
        """Remove the dead particles when there may be many, keeping the order; returns whether slots have changed.

        at_once : remove them even if there are few
        Keeping a few dead particles costs less than removing them at every step. It changes no living particle; sums of the
        shares of the dead in a ledger may be rounded otherwise.
        """
        self.launches += 1
        if (
            not self.may_die
            or not self.count
            or not (at_once or self.launches >= _PATIENCE or self.next_id > self.count_at)
        ):
            return False
        most = self.count - 1 if at_once else int(self.count * (1.0 - _TOLERATED))
        living, kept = slots_of_living(self.floats, self.birth, self.count, time, most)
        dead = self.count - living if kept is None else 0
        self.launches, self.count_at = 0, self.next_id + max(int(_BIRTHS_BETWEEN_COUNTS * living) - dead, 1024)
        if kept is None:
            return False
        self.keep(kept)
        return True

    def remove(self, slots: np.ndarray) -> None:
        """Remove the particles in these slots; the others keep their order."""
        self.keep(np.delete(np.arange(self.count), slots))

    def keep(self, slots: np.ndarray) -> None:
        """Remove all particles but those in these slots, which ascend."""
        if self.entries:
            gone = np.delete(np.arange(self.count), slots)
            self.removed = [_sum([sum_, *row[gone]]) for sum_, row in zip(self.removed, self.booked)]
        if 0 < len(slots) < self.count:
            compact(slots.astype(np.int32), *self._arrays())
        self.count = len(slots)

    def forget_booked(self) -> None:
        """Set every share to 0: a ledger begins."""
        self.booked[:] = 0.0
        self.removed = [0.0] * len(self.entries)

    def booked_total(self, k: int) -> float:
        """The sum of entry k over all particles that ever were, J, correctly rounded: it depends on no order."""
        return _sum([self.removed[k], *self.booked[k, : self.count]])

    @property
    def nbytes(self) -> int:
        return sum(column.nbytes for column in self._arrays())
