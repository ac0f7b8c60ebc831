"""How many particles a preset will have, and the memory they take, before anything is allocated.

A census in slices of simulated time: births by rate, time, count and event; deaths spread over the range of lifetimes.
"""

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gen_art.errors import MemoryRefused
from gen_art.preset.camera import CameraSpec
from gen_art.preset.look import Look
from gen_art.preset.schema import Preset, SystemSpec
from gen_art.preset.values import Curve, Range

__all__ = ["Estimate", "available_memory", "estimate", "megabytes", "refuse_if_too_large"]

SLICES = 600
FLOAT_CHANNELS = 10  # position, velocity, mass, charge, radius, lifetime
BOOKKEEPING = 28  # bytes: birth time, key, id, source
INDEX_LIMIT = 2**31 - 1  # of a system's whole array
_FOREVER = 1e300


# bytes at the peak of the process, measured with one preset of each kind at several sizes and rates
PROCESS = 190e6  # with Taichi, a small picture and no particles
GROWTH = 2.0  # capacity beyond the slots in use, and the old arrays beside the new ones
BIRTH = 160  # a birth while it is being made
SHADED, LIT, LISTED, SORTED = 50, 36, 85, 36  # a particle on the picture, of a lit system, as a sprite, sorted by depth
REMEMBERED = 20  # a particle's place that a ribbon goes back to
CELL = 4 * 4  # of the density grid that a light shines through: eight arrays of a cloud that fills half of its cube
FILM, PICTURE = 16, 10  # a pixel of light; of the developed picture, its halos and its file
BATCH_BIRTHS = 4096  # births, or an eighth of the living, that a launch of several steps may make
BATCH = 64  # steps taken at once where no events and no interactions tie them


@dataclass(frozen=True)
class Estimate:
    """Per system: births over the whole preset, the most alive at once, bytes of state then; and the process's peak.

    `working` is the memory that goes with the particles, in bytes: state with room to grow, births, drawing; `pixel` that of
    one pixel of the picture before it is written.
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
        """Bytes at the peak of the process that makes a picture of this size; coded : what an encoder holds for each pixel."""
        return PROCESS + self.working + (self.pixel + coded) * size[0] * size[1]

    def __str__(self) -> str:
        return f"at most about {self.particles:,.0f} particles at once, {megabytes(self.memory)} of state"


def bytes_per_particle(system: SystemSpec, precision: str = "f32") -> int:
    """Bytes of state a particle takes in a system's storage."""
    return (FLOAT_CHANNELS + _attributes(system)) * (8 if precision == "f64" else 4) + BOOKKEEPING


def _attributes(system: SystemSpec) -> int:
    """How many attributes a system's particles have: what it declares, and what its emitters' classes do."""
    names = set(system.particle.attributes)
    for emitter in system.emitters.values():
        names |= set(getattr(emitter.scripted, "declares", ()))
    return len(names)


def estimate(preset: Preset, precision: str = "f32", until: float | None = None) -> Estimate:
    """The census of a preset up to simulated time `until` (the last frame when None)."""
    census = _Census(preset, preset.clock.simulated if until is None else until)
    with np.errstate(over="ignore", invalid="ignore"):
        census.run()
    peak, size, state, births, drawing = {}, {}, 0.0, 0.0, 0.0
    for name, system in preset.systems.items():
        peak[name] = float(np.nan_to_num(census.peak[name], nan=np.inf))
        size[name] = peak[name] * bytes_per_particle(system, precision)
        steady, sudden = (float(np.nan_to_num(most[name], nan=np.inf)) for most in (census.steady, census.sudden))
        # the births of a batch stand beside its dead; a launch takes fewer steps where they would be many
        steady = min(steady, max(BATCH_BIRTHS, peak[name] / 8, steady / BATCH))
        slots = peak[name] + steady
        state += GROWTH * slots * bytes_per_particle(system, precision)
        births = max(births, BIRTH * max(steady, sudden))
        if system.look is not None:
            drawing += _drawing(system.look) * peak[name]
            drawing += CELL * system.look.light.resolution**3 if system.look.light else 0.0
    born = {name: float(census.born[name]) for name in preset.systems}
    return Estimate(born, peak, size, state + max(births, drawing), _pixel(preset))


def _drawing(look: Look) -> float:
    """Bytes of a particle while it is drawn."""
    if look.ribbon is not None:
        return SHADED + look.ribbon.points * (REMEMBERED + LISTED)
    if look.blend == "add":
        return SHADED + (0 if look.draw in ("point", "pixel") else LISTED)
    return SHADED + LISTED + SORTED + (LIT if look.light else 0)


def _pixel(preset: Preset) -> float:
    """Bytes of a pixel of the picture while it is made."""
    camera = preset.camera or CameraSpec()
    trails = sum(s.look is not None and s.look.trail is not None for s in preset.systems.values())
    averaged = (camera.supersample > 1) + (camera.subframes > 1)
    return PICTURE + FILM * (camera.supersample**2 * (1 + trails) + averaged)


class _Census:
    def __init__(self, preset: Preset, until: float):
        self.preset = preset
        self.width = max(until, 1e-300) / SLICES
        self.groups = {
            (name, source, tag): np.zeros(SLICES + 1)
            for name, system in preset.systems.items()
            for source, emitter in system.emitters.items()
            for tag in (emitter.tag, *(c.tag for c in emitter.choose.values()))
        }  # deaths in each slice, by system, emitter and tag
        self.alive = dict.fromkeys(self.groups, 0.0)
        self.born = dict.fromkeys(preset.systems, 0.0)
        self.peak = dict.fromkeys(preset.systems, 0.0)
        self.steady = dict.fromkeys(preset.systems, 0.0)  # the most births made together, by rates
        self.sudden = dict.fromkeys(preset.systems, 0.0)  # and by counts
        tied = any(s.interactions or any(e.source for e in s.emitters.values()) for s in preset.systems.values())
        self.batch = (1 if tied else BATCH) * preset.clock.step

    def run(self) -> None:
        births = dict.fromkeys(self.groups, 0.0)
        for k in range(SLICES):
            start, stop = k * self.width, (k + 1) * self.width
            died = {group: min(deaths[k], self.alive[group]) for group, deaths in self.groups.items()}
            born: dict = dict.fromkeys(self.groups, 0.0)
            for name, system in self.preset.systems.items():
                for label, emitter in system.emitters.items():
                    for tag, number, lifetime in self._births(name, emitter, start, stop, died, births):
                        born[name, label, tag] += number
                        self._schedule((name, label, tag), k, number, lifetime or system.particle.lifetime)
            for name, system in self.preset.systems.items():
                by_rate = sum(n for (s, e, _), n in born.items() if s == name and system.emitters[e].rate is not None)
                by_count = sum(n for (s, e, _), n in born.items() if s == name and system.emitters[e].rate is None)
                self.steady[name] = max(self.steady[name], by_rate * self.batch / self.width)
                self.sudden[name] = max(self.sudden[name], by_count)
                mine = [group for group in self.groups if group[0] == name]
                number = sum(born[group] for group in mine)
                self.born[name] += number
                self.peak[name] = max(self.peak[name], sum(self.alive[group] for group in mine) + number)
            for group in self.groups:
                self.alive[group] += born[group] - died[group]
            births = born

    def _schedule(self, group, k: int, number: float, lifetime: Range | None) -> None:
        """Deaths of `number` births in slice k, spread evenly over the range of lifetimes."""
        if lifetime is None or not number:
            return
        first = k + max(1, int(min(lifetime.lo / self.width, 2 * SLICES)))
        last = k + max(1, int(min(lifetime.hi / self.width, 1e9)))
        if first <= SLICES:
            self.groups[group][first : last + 1] += number / (last - first + 1)

    def _births(self, name, emitter, start, stop, died, births):
        """(tag, number, lifetime) born of one emitter in a slice."""
        events = self._events(emitter, start, stop, died, births)
        weights = sum(choice.weight for choice in emitter.choose.values())
        for choice in emitter.choose.values() or [None]:
            count = (choice and choice.count) or emitter.count
            number = events * (count.mean if count else 1.0) * (choice.weight / weights if choice else 1.0)
            yield (choice or emitter).tag, number, (choice and choice.lifetime) or emitter.lifetime

    def _events(self, emitter, start, stop, died, births) -> float:
        """Times an emitter fires in a slice: births by rate, moments of `at`, or events of another system."""
        if emitter.source is None:
            first = emitter.start or 0.0
            if emitter.at is not None:
                return sum(start <= time < stop for time in emitter.at)
            if emitter.rate is None:
                return float(start <= first < stop)
            return _integral(
                emitter.rate, max(start, first), min(stop, _FOREVER if emitter.stop is None else emitter.stop)
            )
        # how often a particle strikes is not known before it has: once is assumed, when it is born
        table = {"death": died, "birth": births, "impact": births, "path": self.alive}[emitter.source.kind]
        total = sum(
            number
            for (system, _, tag), number in table.items()
            if system == emitter.source.system and (not emitter.source.tag or tag in emitter.source.tag)
        )
        return total * (_integral(emitter.rate, start, stop) if emitter.source.kind == "path" else 1.0)


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


def available_memory() -> float:
    """Bytes this process may still take: what the machine has free, or what its control group leaves."""
    found = []
    with suppress(OSError, ValueError, IndexError):
        line = next(row for row in Path("/proc/meminfo").read_text().splitlines() if row.startswith("MemAvailable"))
        found.append(float(line.split()[1]) * 1024)
    if not found:
        with suppress(OSError, ValueError, AttributeError):
            found.append(float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES"))
    with suppress(OSError, ValueError):
        limit = Path("/sys/fs/cgroup/memory.max").read_text().strip()
        if limit != "max":
            found.append(float(limit) - float(Path("/sys/fs/cgroup/memory.current").read_text()))
    return max(0.0, min(found)) if found else 8e9


def refuse_if_too_large(
    preset: Preset,
    precision: str = "f32",
    size: tuple[int, int] | None = None,
    until: float | None = None,
    coded: float = 0.0,
) -> Estimate:
    """The estimate; MemoryRefused, naming the figures, when its particles (and a picture of `size`) cannot fit."""
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
