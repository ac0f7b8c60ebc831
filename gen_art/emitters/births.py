"""Emissions: what the births of one emitter are, and the making of them, whichever way they come about.

Keys: a scheduled birth has H(emission's key, serial), the emission's key being H(H(seed, system), emitter); a child has
H(H(parent's key, event), ordinal). Every attribute comes from its key, so nothing depends on other emitters or on order.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from gen_art.emitters.base import Emitter, Shape, Velocity
from gen_art.emitters.birth_kernel import make_birth
from gen_art.emitters.schedule import Schedule
from gen_art.errors import UsageError
from gen_art.maths.random import channel_of, derive, uniform
from gen_art.particles.rows import LIFETIME
from gen_art.particles.storage import Particles

__all__ = [
    "BirthBatch",
    "BatchStreams",
    "ActiveEmitter",
    "BirthEvent",
    "BirthKind",
    "EmitterMotion",
    "give_birth",
    "scheduled",
]


@dataclass(eq=False)
class BirthKind:
    """One kind of particle an emitter makes: where, how fast, with what. `attributes` maps names to (low, high)."""

    name: str = ""
    tag: str | None = None
    shape: Shape | None = None
    velocity: Velocity | None = None
    scripted: Emitter | None = None
    attributes: dict[str, tuple[float, float]] = field(default_factory=dict)
    weight: float = 1.0
    count: tuple[int, int] = (1, 1)
    channels: dict[str, int] = field(default_factory=dict)

    def _signature(self):
        fixed = tuple(None if t is None else t.fixed for t in (self.shape, self.velocity, self.scripted))
        return (fixed, tuple(self.attributes), tuple(self.channels))

    def __hash__(self):
        return hash(self._signature())

    def __eq__(self, other):
        return isinstance(other, BirthKind) and self._signature() == other._signature()

    def numbers(self, dtype) -> np.ndarray:
        """The run-time numbers of the birth kernel."""
        things = [self.scripted] if self.scripted is not None else [self.shape, self.velocity]
        numbers = [n for thing in things if thing is not None for n in thing.numbers()]
        return np.array([*numbers, *(n for bounds in self.attributes.values() for n in bounds), 0.0], dtype)


@dataclass(frozen=True)
class BirthEvent:
    """Births fed by another system: `kind` is birth, death, impact or path; only parents of these tags, if any are named."""

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
        n = np.asarray(self.axis, float) / np.linalg.norm(self.axis)
        helper = np.array([0.0, 1.0, 0.0]) if abs(n[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
        e = np.cross(helper, n)
        e /= np.linalg.norm(e)
        f = np.cross(n, e)
        angle = 2 * np.pi * t / self.period + self.phase
        circle = self.radius * (np.outer(e, np.cos(angle)) + np.outer(f, np.sin(angle)))
        return np.outer(np.asarray(self.velocity, float), t) + circle


class ActiveEmitter:
    """One emitter of one system, ready to give births: a schedule or an event, and the kinds to choose from."""

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

    def choose(self, keys: np.ndarray) -> np.ndarray:
        """Which kind each key takes, by weight."""
        if len(self.kinds) == 1:
            return np.zeros(len(keys), np.int64)
        shares = np.cumsum([k.weight for k in self.kinds])
        return np.searchsorted(shares / shares[-1], uniform(keys, channel_of("choose")), "right")


@dataclass
class BirthBatch:
    """Births of one kind to be made together: one entry per particle."""

    kind: BirthKind
    source: int
    when: np.ndarray
    keys: np.ndarray
    paired: np.ndarray
    burst: np.ndarray
    ordinal: np.ndarray
    sign: np.ndarray
    origin: np.ndarray
    rank: np.ndarray  # ties in time go by rank (uint64), then by ordinal


class BatchStreams:
    """The streams of many particles in NumPy, for `Emitter.sample`: each call gives one value per particle."""

    def __init__(self, keys: np.ndarray):
        self.keys = keys

    def uniform(self, channel: int) -> np.ndarray:
        return uniform(self.keys, channel)

    def normal(self, channel: int) -> np.ndarray:
        u, v = self.uniform(channel), self.uniform(channel + 0x40000000)
        return np.sqrt(-2 * np.log(u)) * np.cos(2 * np.pi * v)

    def sphere(self, channel: int) -> np.ndarray:
        z, a = 2 * self.uniform(channel) - 1, 2 * np.pi * self.uniform(channel + 0x40000000)
        s = np.sqrt(np.maximum(1 - z * z, 0))
        return np.stack([s * np.cos(a), s * np.sin(a), z])


def scheduled(emission: ActiveEmitter, t1: float) -> list[BirthBatch]:
    """The births of a scheduled emission up to and including t1 that have not been made yet."""
    if emission.schedule is None:
        return []
    last = emission.schedule.until(t1)
    first, emission.done = emission.done, max(last, emission.done)
    if last <= first:
        return []
    serial = np.arange(first, last)
    when = emission.schedule.times(first, last)
    keys = derive(emission.key, serial)
    origin = np.zeros((6, len(when)))
    if emission.motion is not None:
        origin[:3] = emission.motion.at(when)
    choice = emission.choose(keys)
    batches = []
    for c in np.unique(choice):
        of = choice == c
        one = np.ones(int(of.sum()))
        batches.append(
            BirthBatch(
                emission.kinds[c], emission.first_source + int(c), when[of], keys[of], keys[of], keys[of],
                serial[of], one, origin[:, of], np.full(len(one), emission.key, np.uint64),
            )
        )  # fmt: skip
    return batches


def give_birth(particles: Particles, batches: list[BirthBatch], precision: str) -> slice:
    """Append the particles of all batches in order of (time, rank, ordinal) and draw their attributes."""
    if not batches:
        return slice(particles.count, particles.count)
    when = np.concatenate([b.when for b in batches])
    order = np.lexsort((np.concatenate([b.ordinal for b in batches]), np.concatenate([b.rank for b in batches]), when))
    keys = np.concatenate([b.keys for b in batches])
    source = np.concatenate([np.full(len(b.when), b.source, np.int32) for b in batches])
    new = particles.append(when[order], keys[order], source[order])
    slots = np.empty(len(order), np.int32)
    slots[order] = np.arange(new.start, new.stop, dtype=np.int32)
    dtype, at = particles.floats.dtype, 0
    for b in batches:
        mine = slots[at : at + len(b.when)]
        at += len(b.when)
        if b.kind.scripted is not None and b.kind.scripted.sample is not None:
            _sample(particles, b, b.kind.scripted.sample, mine)
            continue
        make_birth(b.kind, precision)(
            particles.floats, particles.key, mine, _words(b.paired), _words(b.burst),
            (b.ordinal & 0x7FFFFFFF).astype(np.int32), b.sign.astype(dtype), b.origin.astype(dtype),
            b.when.astype(dtype), b.kind.numbers(dtype),
        )  # fmt: skip
    if not particles.may_die:
        particles.may_die = bool(np.isfinite(particles.floats[LIFETIME, new]).any())
    return new


def _words(keys: np.ndarray) -> np.ndarray:
    return np.stack([(keys >> np.uint64(32)).astype(np.uint32), (keys & np.uint64(0xFFFFFFFF)).astype(np.uint32)])


def _sample(particles: Particles, batch: BirthBatch, sample: Callable, slots: np.ndarray) -> None:
    """Births by an emitter written in NumPy; what it does not set, or sets to NaN, comes from the kind's attributes."""
    draws = BatchStreams(batch.keys)
    rows = particles.channels
    for name, (low, high) in batch.kind.attributes.items():
        if name != "density":
            particles.floats[rows[name], slots] = (
                low if low == high else low + (high - low) * draws.uniform(channel_of(name))
            )
    born = sample(draws, len(slots))
    unknown = set(born) - {"position", "velocity", *rows}
    if unknown:
        raise UsageError(f"emitter '{batch.kind.name}' sets {', '.join(sorted(unknown))}, which no particle here has")
    for name, values in born.items():
        if name in ("position", "velocity"):
            first = 0 if name == "position" else 3
            particles.floats[first : first + 3, slots] = np.asarray(values) + batch.origin[first : first + 3]
        else:
            values = np.asarray(values)
            of = np.broadcast_to(~np.isnan(values), slots.shape)
            particles.floats[rows[name], slots[of]] = np.broadcast_to(values, slots.shape)[of]
