"""Estimates how many particles a preset has and how much memory it needs, before anything is allocated.

Births by rate, time, count and event are counted in slices of simulated time; deaths are spread over the range of
lifetimes.
"""

import weakref
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gen_art.backend.memory import available_memory
from gen_art.errors import MemoryRefused
from gen_art.preset.picture_memory import fixed_bytes, particle_bytes, pixel_bytes
from gen_art.preset.schema import Preset, SystemSpec
from gen_art.preset.values import Curve

__all__ = ["Estimate", "estimate", "megabytes", "refuse_if_too_large"]

SLICES = 600
FLOAT_CHANNELS = 10  # position, velocity, mass, charge, radius, lifetime
OTHER_COLUMNS = 28  # bytes of a particle: birth time, key, id, source
INDEX_LIMIT = 2**31 - 1  # numbers in a system's float array
_FOREVER = 10**9  # slices


# memory at the peak of the process, bytes; measured with one preset of each kind at several sizes and rates
PROCESS = 190e6  # with Taichi, a small picture and no particles
GROWTH = 2.0  # factor for spare capacity, and for old arrays that exist beside new ones while a system grows
BIRTH = 160  # of a particle while it is being born
BATCH_BIRTHS = 4096  # births in a launch of several steps; an eighth of the living particles if that is more
BATCH = 64  # steps of a launch without events and interactions


@dataclass(frozen=True)
class Estimate:
    """The particles and the memory of a preset.

    born : by system, births in the whole preset
    peak : by system, the most particles alive at once
    bytes : by system, memory of the state at that peak
    working : memory that depends on the particles, bytes: state with spare capacity, births, drawing
    pixel : memory of one pixel of the picture before it is written, bytes
    """

    born: dict[str, float]
    peak: dict[str, float]
    bytes: dict[str, float]
    working: float
    pixel: float

    @property
    def particles(self) -> float:
        return sum(self.peak.values())

    @property
    def memory(self) -> float:
        return sum(self.bytes.values())

    def process(self, size: tuple[int, int], coded: float = 0.0) -> float:
        """Memory at the peak of the process that makes a picture of this size, bytes.

        coded : bytes that an encoder holds for each pixel
        """
        return PROCESS + self.working + (self.pixel + coded) * size[0] * size[1]

    def __str__(self) -> str:
        return f"at most about {self.particles:,.0f} particles at once, {megabytes(self.memory)} of state"


def bytes_per_particle(system: SystemSpec, precision: str = "f32") -> int:
    """Bytes of a particle in a system's storage."""
    numbers = (FLOAT_CHANNELS + _attributes(system)) * (8 if precision == "f64" else 4)
    return numbers + OTHER_COLUMNS + 8 * len(system.ledger_entries)


def _attributes(system: SystemSpec) -> int:
    """The number of attributes of a system's particles: those it declares and those its emitters' classes declare."""
    names = set(system.particle.attributes)
    for emitter in system.emitters.values():
        names |= set(getattr(emitter.scripted, "declares", ()))
    return len(names)


def estimate(preset: Preset, precision: str = "f32", until: float | None = None) -> Estimate:
    """The estimate for a preset up to simulated time `until`, s (the last frame when None)."""
    census = _census(preset, preset.clock.simulated if until is None else until)
    peak, size, state, births, drawing = {}, {}, 0.0, 0.0, 0.0
    for name, system in preset.systems.items():
        peak[name] = float(np.nan_to_num(census.peak[name], nan=np.inf))
        size[name] = peak[name] * bytes_per_particle(system, precision)
        steady, sudden = (float(np.nan_to_num(most[name], nan=np.inf)) for most in (census.steady, census.sudden))
        # the births of a batch are stored beside its dead; a launch has fewer steps when there would be many births
        steady = min(steady, max(BATCH_BIRTHS, peak[name] / 8, steady / BATCH))
        slots = peak[name] + steady
        state += GROWTH * slots * bytes_per_particle(system, precision)
        births = max(births, BIRTH * max(steady, sudden))
        for look in system.all_looks.values():
            shown = census.tagged(name, look.tag) if look.tag else peak[name]
            drawing += particle_bytes(preset, name, look) * min(shown, peak[name])
    born = {name: float(census.born[name]) for name in preset.systems}
    drawing += fixed_bytes(preset)
    return Estimate(born, peak, size, state + max(births, drawing), pixel_bytes(preset))


_latest: deque[tuple[weakref.ref, float, "_Census"]] = deque(maxlen=4)  # a command asks for the same ones several times


def _census(preset: Preset, until: float) -> "_Census":
    """The counts for a preset up to simulated time `until`, s."""
    for known, time, census in tuple(_latest):
        if known() is preset and time == until:
            return census
    with np.errstate(over="ignore", invalid="ignore"):
        census = _Census(preset, until)
        census.run()
    _latest.append((weakref.ref(preset), until, census))
    return census


@dataclass(frozen=True)
class _Emitter:
    """An emitter in the census, or one of its choices.

    share : births of each of its events
    events : (SLICES,) how often it emits; of an emitter that follows events, how often for each of them
    follows : kind of the events that it follows and the indices of the emitters that have them; None if it follows none
    lifetime : the fewest and the most slices that its particles live; None if they live on
    """

    tag: str | None
    by_rate: bool
    share: float
    events: np.ndarray
    follows: tuple[str, list[int]] | None
    lifetime: tuple[int, int] | None

    def deaths(self, born: np.ndarray) -> np.ndarray:
        """The deaths in each slice, when `born` are born in each: spread evenly over the lifetimes."""
        died = np.zeros(SLICES)
        if self.lifetime is not None:
            first, last = self.lifetime
            total = np.concatenate([np.zeros(1), np.cumsum(born)])
            died[first:] = total[1 : max(SLICES + 1 - first, 1)]
            died[last + 1 :] -= total[1 : max(SLICES - last, 1)]
            died /= last - first + 1
        return died


class _Census:
    """Counts births and deaths in slices of simulated time, by emitters and their choices."""

    def __init__(self, preset: Preset, until: float):
        self.width = max(until, 1e-300) / SLICES
        systems = preset.systems
        tags = [
            (name, (choice or emitter).tag)
            for name, system in systems.items()
            for emitter in system.emitters.values()
            for choice in emitter.choose.values() or [None]
        ]
        self.emitters = [
            each
            for system in systems.values()
            for emitter in system.emitters.values()
            for each in self._choices(emitter, system.particle.lifetime, tags)
        ]
        self.of_system = {name: [k for k, (system, _) in enumerate(tags) if system == name] for name in systems}
        stepwise = any(s.interactions or any(e.source for e in s.emitters.values()) for s in systems.values())
        self.batch = (1 if stepwise else BATCH) * preset.clock.step  # simulated time of a launch, s

    def _choices(self, emitter, lifetime, tags: list[tuple]) -> Iterator[_Emitter]:
        """The choices of an emitter; one where it has none."""
        weights = sum(choice.weight for choice in emitter.choose.values())
        follows = None
        if emitter.source is not None:
            parent, wanted = emitter.source.system, emitter.source.tag
            followed = [k for k, (system, tag) in enumerate(tags) if system == parent and (not wanted or tag in wanted)]
            follows = emitter.source.kind, followed
        events = _events(emitter, self.width * np.arange(SLICES + 1))
        for choice in emitter.choose.values() or [None]:
            count = (choice and choice.count) or emitter.count
            share = (count.mean if count else 1.0) * (choice.weight / weights if choice else 1.0)
            range_ = (choice and choice.lifetime) or emitter.lifetime or lifetime
            span = None
            if range_ is not None:
                span = self._slices(range_.lo), self._slices(range_.hi)
            yield _Emitter((choice or emitter).tag, emitter.rate is not None, share, events, follows, span)

    def _slices(self, lifetime: float) -> int:
        """A lifetime, s, in slices; 1 at least, so that a particle dies in a later slice than that of its birth."""
        return max(1, int(min(lifetime / self.width, _FOREVER)))

    def tagged(self, name: str, tags: tuple[str, ...]) -> float:
        """At most so many particles of a system with one of these tags are alive at once."""
        most = sum(self.most[k] for k in self.of_system[name] if self.emitters[k].tag in tags)
        return float(np.nan_to_num(most, nan=np.inf))

    def run(self) -> None:
        """Count: births follow events of the slices before, so that they are final when they do not change any more."""
        births = np.zeros((len(self.emitters), SLICES))
        while True:
            alive, following = self._lives_and_births(births)
            if np.array_equal(following, births, equal_nan=True):
                break
            births = following
        self.most = (alive + births).max(1)
        self.born: dict[str, float] = {}
        self.peak: dict[str, float] = {}
        self.steady: dict[str, float] = {}  # the most births of one launch, by rates
        self.sudden: dict[str, float] = {}  # and by counts
        for name, rows in self.of_system.items():
            self.born[name] = births[rows].sum()
            self.peak[name] = (alive[rows] + births[rows]).sum(0).max()
            by_rate = [k for k in rows if self.emitters[k].by_rate]
            by_count = [k for k in rows if not self.emitters[k].by_rate]
            self.steady[name] = births[by_rate].sum(0).max() * self.batch / self.width
            self.sudden[name] = births[by_count].sum(0).max()

    def _lives_and_births(self, births: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How many are alive at the beginning of each slice, and the births that follow from these lives."""
        died = np.zeros_like(births)
        for k, emitter in enumerate(self.emitters):
            died[k] = emitter.deaths(births[k])
        before = np.pad(births, ((0, 0), (1, 0)))[:, :-1]
        alive = np.maximum(np.cumsum(before - np.pad(died, ((0, 0), (1, 0)))[:, :-1], 1), 0.0)
        # the number of a particle's impacts is not known beforehand: one is assumed, at its birth
        table = {"death": died, "birth": before, "impact": before, "path": alive}
        following = np.empty_like(births)
        for k, emitter in enumerate(self.emitters):
            following[k] = emitter.share * emitter.events
            if emitter.follows is not None:
                kind, followed = emitter.follows
                following[k] *= table[kind][followed].sum(0)
        return alive, following


def _events(emitter, edges: np.ndarray) -> np.ndarray:
    """How often an emitter emits between `edges`: births by rate or times of `at`; else for each event that it follows."""
    starts, stops = edges[:-1], edges[1:]
    if emitter.source is not None:
        return emitter.rate * (stops - starts) if emitter.source.kind == "path" else np.ones(len(starts))
    first = emitter.start or 0.0
    if emitter.rate is None:
        slices = np.searchsorted(edges, [first] if emitter.at is None else emitter.at, "right") - 1
        return np.bincount(slices[slices < len(starts)], minlength=len(starts)).astype(float)
    starts, stops = np.maximum(starts, first), np.minimum(stops, np.inf if emitter.stop is None else emitter.stop)
    if isinstance(emitter.rate, Curve):
        return np.array([emitter.rate.integral(*span) if span[0] < span[1] else 0.0 for span in zip(starts, stops)])
    return emitter.rate * np.maximum(stops - starts, 0.0)


def megabytes(size: float) -> str:
    """12345678 -> `12 MB`, in the unit that fits."""
    for unit, scale in (("EB", 1e18), ("PB", 1e15), ("TB", 1e12), ("GB", 1e9)):
        if size >= scale:
            return f"{size / scale:,.1f} {unit}"
    return f"{size / 1e6:.0f} MB"


def refuse_if_too_large(
    preset: Preset,
    precision: str = "f32",
    size: tuple[int, int] | None = None,
    until: float | None = None,
    coded: float = 0.0,
) -> Estimate:
    """The estimate. Raises MemoryRefused, with the figures, if the particles (and a picture of `size`) do not fit."""
    expected = estimate(preset, precision, until)
    for name, peak in expected.peak.items():
        limit = INDEX_LIMIT // (FLOAT_CHANNELS + _attributes(preset.systems[name]))
        if not peak <= limit:
            raise MemoryRefused(
                f"system '{name}' would hold {peak:.3g} particles at once ({megabytes(expected.bytes[name])}); "
                f"a system holds {limit:,} at most"
            )
    needed, free = expected.process(size or (0, 0), coded), available_memory()
    if needed > free:
        picture = f" in a picture of {size[0]}x{size[1]}" if size else ""
        raise MemoryRefused(
            f"{expected.particles:.3g} particles{picture} need about {megabytes(needed)} of memory; "
            f"{megabytes(free)} are free. Lower a rate, a count, a lifetime or the size"
        )
    return expected
