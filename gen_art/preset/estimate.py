"""Estimates how many particles a preset has and how much memory it needs, before anything is allocated.

Births by rate, time, count and event are counted in slices of simulated time; deaths are spread over the range of
lifetimes.
"""

import weakref
from collections import deque
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
_FOREVER = 1e300


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
    census = _Census(preset, until)
    with np.errstate(over="ignore", invalid="ignore"):
        census.run()
    _latest.append((weakref.ref(preset), until, census))
    return census


@dataclass(frozen=True)
class _Emitter:
    """An emitter in the census: how often it emits in each slice, and what comes of that.

    events : (SLICES,) how often it emits; of an emitter that follows events, how often for each of them
    source : kind of the events that it follows (None if it follows none) and the indices of the groups that have them
    births : (index of the group, births an event, first and last slice of their deaths after their own) of each choice
    """

    system: str
    by_rate: bool
    events: list[float]
    source: tuple[str, list[int]] | None
    births: list[tuple[int, float, int | None, int]]


class _Census:
    """Counts births and deaths in slices of simulated time, by groups: system, emitter and tag."""

    def __init__(self, preset: Preset, until: float):
        self.width = max(until, 1e-300) / SLICES
        systems = preset.systems
        groups = dict.fromkeys(
            (name, label, tag)
            for name, system in systems.items()
            for label, emitter in system.emitters.items()
            for tag in (emitter.tag, *(c.tag for c in emitter.choose.values()))
        )
        self.groups = {group: k for k, group in enumerate(groups)}
        self.of_system = {name: [k for group, k in self.groups.items() if group[0] == name] for name in systems}
        self.emitters = [self._emitter(systems, n, e) for n, system in systems.items() for e in system.emitters]
        self.deaths = np.zeros((len(groups), SLICES + 1))
        self.most = [0.0] * len(groups)  # alive at once
        self.born = dict.fromkeys(systems, 0.0)
        self.peak = dict.fromkeys(systems, 0.0)
        self.steady = dict.fromkeys(systems, 0.0)  # the most births of one launch, by rates
        self.sudden = dict.fromkeys(systems, 0.0)  # and by counts
        stepwise = any(s.interactions or any(e.source for e in s.emitters.values()) for s in systems.values())
        self.batch = (1 if stepwise else BATCH) * preset.clock.step  # simulated time of a launch, s

    def tagged(self, name: str, tags: tuple[str, ...]) -> float:
        """At most so many particles of a system with one of these tags are alive at once."""
        most = sum(self.most[k] for (system, _, tag), k in self.groups.items() if system == name and tag in tags)
        return float(np.nan_to_num(most, nan=np.inf))

    def run(self) -> None:
        number = range(len(self.groups))
        alive, births = [0.0] * len(number), [0.0] * len(number)
        for k in range(SLICES):
            died = [min(deaths, living) for deaths, living in zip(self.deaths[:, k].tolist(), alive)]
            # the number of a particle's impacts is not known beforehand: one is assumed, at its birth
            table = {"death": died, "birth": births, "impact": births, "path": alive}
            born = [0.0] * len(number)
            by_rate, by_count = dict.fromkeys(self.born, 0.0), dict.fromkeys(self.born, 0.0)
            for emitter in self.emitters:
                events = emitter.events[k]
                if emitter.source is not None:
                    kind, parents = emitter.source
                    events *= sum(table[kind][parent] for parent in parents)
                if events:
                    total = by_rate if emitter.by_rate else by_count
                    total[emitter.system] += self._give_birth(emitter, events, k, born)
            for name, groups in self.of_system.items():
                self.steady[name] = max(self.steady[name], by_rate[name] * self.batch / self.width)
                self.sudden[name] = max(self.sudden[name], by_count[name])
                together = sum(born[group] for group in groups)
                self.born[name] += together
                self.peak[name] = max(self.peak[name], sum(alive[group] for group in groups) + together)
            for group in number:
                self.most[group] = max(self.most[group], alive[group] + born[group])
                alive[group] += born[group] - died[group]
            births = born

    def _give_birth(self, emitter: _Emitter, events: float, k: int, born: list[float]) -> float:
        """The number of births of `events` in slice k, which are added to `born`; their deaths are spread over the lifetimes."""
        together = 0.0
        for group, number, first, last in emitter.births:
            births = events * number
            born[group] += births
            together += births
            if first is not None and k + first <= SLICES:
                self.deaths[group, k + first : k + last + 1] += births / (last - first + 1)
        return together

    def _emitter(self, systems, name: str, label: str) -> _Emitter:
        emitter = systems[name].emitters[label]
        weights = sum(choice.weight for choice in emitter.choose.values())
        births = []
        for choice in emitter.choose.values() or [None]:
            count = (choice and choice.count) or emitter.count
            number = (count.mean if count else 1.0) * (choice.weight / weights if choice else 1.0)
            lifetime = (choice and choice.lifetime) or emitter.lifetime or systems[name].particle.lifetime
            span: tuple[int | None, int] = (None, 0)
            if lifetime is not None:
                last = max(1, int(min(lifetime.hi / self.width, 1e9)))
                span = max(1, int(min(lifetime.lo / self.width, 2 * SLICES))), last
            births.append((self.groups[name, label, (choice or emitter).tag], number, *span))
        source = None
        if emitter.source is not None:
            parent, tags = emitter.source.system, emitter.source.tag
            parents = [
                k for (system, _, tag), k in self.groups.items() if system == parent and (not tags or tag in tags)
            ]
            source = emitter.source.kind, parents
        edges = [k * self.width for k in range(SLICES + 1)]
        events = [_events(emitter, start, stop) for start, stop in zip(edges, edges[1:])]
        return _Emitter(name, emitter.rate is not None, events, source, births)


def _events(emitter, start: float, stop: float) -> float:
    """How often an emitter emits from `start` to `stop`: births by rate or times of `at`; else for each event that it follows."""
    if emitter.source is not None:
        return _integral(emitter.rate, start, stop) if emitter.source.kind == "path" else 1.0
    first = emitter.start or 0.0
    if emitter.at is not None:
        return float(sum(start <= time < stop for time in emitter.at))
    if emitter.rate is None:
        return float(start <= first < stop)
    return _integral(emitter.rate, max(start, first), min(stop, _FOREVER if emitter.stop is None else emitter.stop))


def _integral(rate: float | Curve, start: float, stop: float) -> float:
    if stop <= start:
        return 0.0
    return rate.integral(start, stop) if isinstance(rate, Curve) else rate * (stop - start)


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
