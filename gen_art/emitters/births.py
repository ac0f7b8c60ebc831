"""Births: what an emitter's particles are, and how scheduled births are made.

Keys: a scheduled birth has the key H(emitter's key, serial), where the emitter's key is H(H(seed, system), emitter). A child has
H(H(parent's key, event), ordinal). Every attribute comes from the particle's key, so nothing depends on other emitters or on
the order of births.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from gen_art.emitters.base import Emitter, Shape, Velocity, sampled
from gen_art.emitters.birth_kernel import make_birth, make_scheduled_birth
from gen_art.emitters.schedule import Schedule
from gen_art.errors import UsageError
from gen_art.maths.array_functions import cos, log, sin
from gen_art.maths.random import channel_of, derive, uniform
from gen_art.particles.rows import LIFETIME
from gen_art.particles.storage import Particles

__all__ = [
    "BirthBatch",
    "BatchStreams",
    "ActiveEmitter",
    "BirthEvent",
    "BirthKind",
    "ScheduledBatch",
    "EmitterMotion",
    "give_birth",
    "scheduled_births",
]


@dataclass(eq=False)
class BirthKind:
    """One kind of particle that an emitter makes.

    attributes : name -> (low, high)
    weight : for the choice among several kinds
    count : (low, high), children of an event
    channels : declared attribute -> row of the state array
    """

    name: str = ""
    tag: str | None = None
    shape: Shape | None = None
    velocity: Velocity | None = None
    scripted: Emitter | None = None
    attributes: dict[str, tuple[float, float]] = field(default_factory=dict)
    weight: float = 1.0
    count: tuple[int, int] = (1, 1)
    channels: dict[str, int] = field(default_factory=dict)

    @property
    def fixed(self) -> tuple:
        """What the birth kernel is compiled for: the classes, their choices, and the names. Numbers are never part of it."""
        fixed = tuple(None if t is None else t.fixed for t in (self.shape, self.velocity, self.scripted))
        return (fixed, tuple(self.attributes), tuple(self.channels))

    def __hash__(self):
        return hash(self.fixed)

    def __eq__(self, other):
        return isinstance(other, BirthKind) and self.fixed == other.fixed

    def numbers(self, dtype) -> np.ndarray:
        """The run-time numbers of the birth kernel."""
        parts = [self.scripted] if self.scripted is not None else [self.shape, self.velocity]
        numbers = [n for part in parts if part is not None for n in part.numbers()]
        return np.array([*numbers, *(n for bounds in self.attributes.values() for n in bounds), 0.0], dtype)


@dataclass(frozen=True)
class BirthEvent:
    """Births caused by the particles of another system.

    kind : birth, death, impact or path
    tags : only parents with one of these tags, if any are named
    inherit : whether children get their parents' velocity
    pairs : whether they come in pairs with opposite place and velocity
    rate : births per second along a path
    """

    system: str
    kind: str
    tags: tuple[str, ...] = ()
    inherit: bool = False
    pairs: bool = False
    rate: float = 0.0


@dataclass(frozen=True)
class EmitterMotion:
    """A moving emitter: origin(t) = velocity t + radius (cos, sin)(2 pi t / period + phase) across an axis."""

    velocity: tuple = (0.0, 0.0, 0.0)
    radius: float = 0.0
    period: float = 1.0
    axis: tuple = (0.0, 1.0, 0.0)
    phase: float = 0.0

    def at(self, t: np.ndarray) -> np.ndarray:
        """The emitter's place (3, m) at times t (m,)."""
        e, f = _plane_across(self.axis)
        angle = 2 * np.pi * t / self.period + self.phase
        circle = self.radius * (np.outer(e, cos(angle)) + np.outer(f, sin(angle)))
        return np.outer(np.asarray(self.velocity, float), t) + circle


@lru_cache(64)
def _plane_across(axis: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across an axis and each other."""
    n = _unit(np.asarray(axis, float))
    helper = np.array([0.0, 1.0, 0.0]) if abs(n[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    e = _unit(np.cross(helper, n))
    return e, np.cross(n, e)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


class ActiveEmitter:
    """One emitter of one system, ready for births: a schedule or an event, and the kinds to choose from.

    key : of its random numbers
    first_source : index of its first kind among the system's sources
    done : how many scheduled births have been made
    begins : s, the births of earlier events are left out
    """

    def __init__(
        self,
        name: str,
        kinds: list[BirthKind],
        schedule: Schedule | None = None,
        event: BirthEvent | None = None,
        motion=None,
    ):
        if (schedule is None) == (event is None):
            raise UsageError(f"emitter '{name}' needs either times of births or an event")
        self.name, self.kinds, self.schedule, self.event, self.motion = name, kinds, schedule, event, motion
        self.key = np.uint64(0)
        self.first_source = 0
        self.done = 0
        self.begins = -math.inf

    def fresh(self) -> "ActiveEmitter":
        """The same emitter for another simulation, before any birth."""
        return ActiveEmitter(self.name, self.kinds, self.schedule, self.event, self.motion)

    def choose(self, keys: np.ndarray) -> np.ndarray:
        """The index of the kind that each key takes, by weight."""
        if len(self.kinds) == 1:
            return np.zeros(len(keys), np.int64)
        shares = np.cumsum([k.weight for k in self.kinds])
        return np.searchsorted(shares / shares[-1], uniform(keys, channel_of("choose")), "right")


@dataclass
class BirthBatch:
    """Births of one kind that events cause, to be made together; each array has one entry per particle.

    when : s
    keys, paired, burst : keys of the particle, of what a pair shares, of what a burst shares
    sign : factor of place and velocity, 1 or -1 for the two of a pair, 0 for a particle without a partner
    origin : (6, m) position and velocity that place and velocity are relative to
    rank : uint64; births at the same time are ordered by rank, then by ordinal
    """

    kind: BirthKind
    source: int
    when: np.ndarray
    keys: np.ndarray
    paired: np.ndarray
    burst: np.ndarray
    ordinal: np.ndarray
    sign: np.ndarray
    origin: np.ndarray
    rank: np.ndarray

    in_order = False  # whether they are known to be in the order of time, rank and ordinal

    def by_choice(self, emitter: ActiveEmitter, choice: np.ndarray) -> list["BirthBatch"]:
        """The births of each kind, where `choice` holds the index of the kind of each."""
        if len(emitter.kinds) == 1:
            return [self]
        batches = []
        for c in np.unique(choice):
            own = choice == c
            batches.append(
                BirthBatch(
                    emitter.kinds[c], emitter.first_source + int(c), self.when[own], self.keys[own], self.paired[own],
                    self.burst[own], self.ordinal[own], self.sign[own], self.origin[:, own], self.rank[own],
                )
            )  # fmt: skip
        return batches

    def bear(self, particles: Particles, slots: np.ndarray, precision: str) -> None:
        """Write the particles into these slots (int32), which have their ids already."""
        dtype = particles.floats.dtype
        particles.identify(slots, self.when, self.keys, self.source)
        if self.kind.scripted is not None and self.kind.scripted.sample is not None:
            _sample(particles, self.kind, self.keys, self.origin, slots)
            return
        make_birth(self.kind, precision)(
            particles.floats, particles.key, slots, _words(self.paired), _words(self.burst),
            (self.ordinal & 0x7FFFFFFF).astype(np.int32), self.sign.astype(dtype), self.origin.astype(dtype, order="C"),
            self.when.astype(dtype), self.kind.numbers(dtype),
        )  # fmt: skip


@dataclass
class ScheduledBatch:
    """Scheduled births of one kind to be made together, in the order of time and number.

    key : the emitter's
    when : (m,) s
    serial : (m,) int64, the numbers of the births
    origin : (6, m), or (6, 1) for all, position and velocity that place and velocity are relative to
    """

    kind: BirthKind
    source: int
    key: np.uint64
    when: np.ndarray
    serial: np.ndarray
    origin: np.ndarray

    in_order = True

    @property
    def ordinal(self) -> np.ndarray:
        return self.serial

    @property
    def rank(self) -> np.ndarray:
        return np.full(len(self.when), self.key)

    def bear(self, particles: Particles, slots: np.ndarray, precision: str) -> None:
        """Write the particles into these slots (int32), which have their ids already."""
        if self.kind.scripted is not None and self.kind.scripted.sample is not None:
            keys = derive(self.key, self.serial)
            particles.identify(slots, self.when, keys, self.source)
            _sample(particles, self.kind, keys, self.origin, slots)
            return
        dtype = particles.floats.dtype
        make_scheduled_birth(self.kind, precision)(
            particles.floats, particles.birth, particles.key, particles.source, slots, self.when, self.serial,
            self.origin.astype(dtype, order="C"), self.kind.numbers(dtype), int(self.key.astype(np.int64)), self.source,
        )  # fmt: skip


class BatchStreams:
    """The random streams of many particles in NumPy, for `Emitter.sample`: each call gives one value per particle."""

    def __init__(self, keys: np.ndarray):
        self.keys = keys

    def uniform(self, channel: int) -> np.ndarray:
        return uniform(self.keys, channel)

    def normal(self, channel: int) -> np.ndarray:
        u, v = self.uniform(channel), self.uniform(channel + 0x40000000)
        return np.sqrt(-2 * log(u)) * cos(2 * np.pi * v)

    def sphere(self, channel: int) -> np.ndarray:
        z, a = 2 * self.uniform(channel) - 1, 2 * np.pi * self.uniform(channel + 0x40000000)
        s = np.sqrt(np.maximum(1 - z * z, 0))
        return np.stack([s * cos(a), s * sin(a), z])


def scheduled_births(emitter: ActiveEmitter, t1: float) -> list[ScheduledBatch]:
    """The births of a scheduled emitter up to and including t1 that have not been made yet, a batch for each of its kinds."""
    if emitter.schedule is None:
        return []
    last = emitter.schedule.until(t1)
    first, emitter.done = emitter.done, max(last, emitter.done)
    if last <= first:
        return []
    serial, when, origin = np.arange(first, last, dtype=np.int64), emitter.schedule.times(first, last), np.zeros((6, 1))
    if emitter.motion is not None:
        origin = np.concatenate([emitter.motion.at(when), np.zeros((3, len(when)))])
    choice = emitter.choose(derive(emitter.key, serial)) if len(emitter.kinds) > 1 else np.zeros(1, np.int64)
    batches = []
    for c in np.unique(choice):
        own = choice == c if len(emitter.kinds) > 1 else slice(None)
        moved = origin[:, own] if emitter.motion is not None else origin
        source = emitter.first_source + int(c)
        batches.append(ScheduledBatch(emitter.kinds[c], source, emitter.key, when[own], serial[own], moved))
    return batches


def give_birth(particles: Particles, batches: Sequence[BirthBatch | ScheduledBatch], precision: str) -> slice:
    """Append the particles of all batches in order of (time, rank, ordinal), draw their attributes, and return their slots.

    In a periodic box, particles that are born outside are wrapped into it.
    """
    if not batches:
        return slice(particles.count, particles.count)
    count = sum(len(b.when) for b in batches)
    new = particles.grow(count, max(float(np.max(b.when, initial=-math.inf)) for b in batches))
    slots = np.arange(new.start, new.stop, dtype=np.int32)
    if len(batches) > 1 or not batches[0].in_order:
        order = np.lexsort([np.concatenate([getattr(b, key) for b in batches]) for key in ("ordinal", "rank", "when")])
        slots[order] = slots.copy()
    done = 0
    for b in batches:
        b.bear(particles, slots[done : done + len(b.when)], precision)
        done += len(b.when)
    particles.wrap(new)
    if not particles.may_die:
        particles.may_die = bool(np.isfinite(particles.floats[LIFETIME, new]).any())
    return new


def _words(keys: np.ndarray) -> np.ndarray:
    """The high and the low 32 bits of keys, (2, m) uint32."""
    return np.stack([(keys >> np.uint64(32)).astype(np.uint32), (keys & np.uint64(0xFFFFFFFF)).astype(np.uint32)])


def _sample(particles: Particles, kind: BirthKind, keys: np.ndarray, origin: np.ndarray, slots: np.ndarray) -> None:
    """Births by an emitter written in NumPy. Values that it does not set, or sets to NaN, come from the kind's attributes."""
    assert kind.scripted is not None, "only a class with `sample` is called here"
    draws = BatchStreams(keys)
    rows = particles.channels
    for name, (low, high) in kind.attributes.items():
        if name != "density":
            value = low if low == high else low + (high - low) * draws.uniform(channel_of(name))
            particles.floats[rows[name], slots] = value
    born = sampled(kind.scripted, draws, len(slots), f"emitter '{kind.name}': ")
    unknown = set(born) - {"position", "velocity", *rows}
    if unknown:
        raise UsageError(f"emitter '{kind.name}' sets {', '.join(sorted(unknown))}, which no particle here has")
    for name, values in born.items():
        if name in ("position", "velocity"):
            first = 0 if name == "position" else 3
            particles.floats[first : first + 3, slots] = values + origin[first : first + 3]
        else:
            given = ~np.isnan(values)
            particles.floats[rows[name], slots[given]] = values[given]
