"""The Simulation: systems of particles that are advanced together by fixed time steps."""

import hashlib
import math
import os
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art import arguments
from gen_art.backend import runtime
from gen_art.emitters.births import give_birth, scheduled_births
from gen_art.errors import GenArtError, UsageError
from gen_art.html_table import html_table
from gen_art.maths.random import channel_of, derive
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.storage import Particles
from gen_art.registry import suggest
from gen_art.simulation.children import Children
from gen_art.simulation.coupled_systems import CoupledSystems
from gen_art.simulation.potential_check import check_potentials
from gen_art.simulation.stepper import Stepper
from gen_art.simulation.system import ParticleSystem
from gen_art.simulation.watch import Watch

if TYPE_CHECKING:
    from gen_art.particles.entries import LedgerEntry
    from gen_art.preset.schema import Preset
    from gen_art.simulation.diagnostics import Diagnostics
    from gen_art.simulation.ledger import Ledger, LedgerKeeper
    from gen_art.simulation.observer import Observer
    from gen_art.simulation.record import Record
    from gen_art.simulation.snapshot import Snapshot

__all__ = ["Simulation"]

_BATCH = 64  # the most steps one launch takes
_DTYPES: dict[str, type[np.floating]] = {"f32": np.float32, "f64": np.float64}


def _checked_systems(given: Any) -> "Preset | dict[str, ParticleSystem]":
    """A Preset, or ParticleSystems by name. Raises UsageError for anything else."""
    if isinstance(given, Mapping):
        if not given:
            raise UsageError("a Simulation needs at least one ParticleSystem, by name")
        example = 'ParticleSystems by name, {"stars": stars}, or a preset from ga.load_preset(...)'
        return arguments.named("the systems of a Simulation", given, ParticleSystem, example)
    if not hasattr(given, "systems") or isinstance(given, (type, Simulation)):
        hint = ': write {"stars": system}' if isinstance(given, ParticleSystem) else ""
        raise UsageError(
            f"a Simulation is made of ParticleSystems by name, or of a preset from ga.load_preset(...), not of "
            f"{arguments.shown(given)}{hint}"
        )
    return given


def _checked_domain(given: Any) -> PeriodicBox | None:
    """The periodic box of a mapping as in YAML, or None. Raises UsageError with every problem."""
    if given is None:
        return None
    if not isinstance(given, Mapping):
        raise UsageError(
            f"domain must be a mapping of its keys, such as {{'periodic': {{'min': (0, 0, 0), 'max': (1, 1, 1)}}}}, not "
            f"{arguments.shown(given)}"
        )
    from pydantic import ValidationError

    from gen_art.preset.domain import Domain
    from gen_art.preset.model import friendly
    from gen_art.preset.overrides import plain
    from gen_art.preset.problems import dotted

    try:
        return Domain.model_validate(plain(given)).box
    except ValidationError as error:
        problems = [f"{dotted(('domain', *problem['loc']))}: {friendly(problem)}" for problem in error.errors()]
        raise UsageError("; ".join(problems)) from None


def _parts(system: ParticleSystem) -> tuple:
    """What must agree in a system for the particles of one to go on in the other."""
    saved = [(one.name, list(one.saved_arrays)) for one in system.interactions]
    return [emitter.name for emitter in system.emitters], saved, system.entries, system.attribute_names


def _check_events(members: Mapping[str, ParticleSystem]) -> None:
    for system in members.values():
        for emitter in system.emitters:
            event = emitter.event
            if event is None:
                continue
            if event.system not in members:
                raise UsageError(f"emitter '{emitter.name}' listens to '{event.system}', which is no system here")
            if event.kind == "impact" and not members[event.system].reports_impacts:
                raise UsageError(
                    f"emitter '{emitter.name}' listens to impacts of '{event.system}', but none of its colliders has "
                    "`action: emit`"
                )


class Simulation:
    """Particle systems, their forces and a clock.

    preset : a Preset from ga.load_preset, or a dict of ParticleSystems by name
    dt : time step, s; the preset's clock.step when None, required with a dict
    seed : the preset's when None; 0 with a dict
    precision : "f32" or "f64"
    arch : "cpu"
    threads : None for all; fixed by the first Simulation of the process
    ledger : keep a ledger of work, dissipation, births and deaths; the state's bits are the same with and without it. A
        system whose look goes by joules (`by: {work: drag}`), or whose `booked` names some, makes it keep one anyway
    domain : the space of the systems given by name, as `domain:` of a preset: {"periodic": {"min": (0, 0, 0), "max": (1, 1, 1)}};
        open when None. A preset has its own, and then this is refused
    advice : what happens when a step, a scheme or a precision cannot carry the motion, at the start and during the run: "warn"
        gives an AdviceWarning, once a cause; "error" raises UsageError; "none" says nothing. See docs/when_physics_says_no.md
    Raises UsageError for anything that cannot be simulated, and DivergedError, from a step on, where numbers leave the
    finite ones.

    `sim["name"]` is a ParticleSystem, `sim.members` are all of them, `sim.systems` their storage. All three are read-only;
    `sim.box` is the periodic box, None in open space.
    `step`, `advance` and `advance_to_frame` change a simulation, and `set`, `add` and `remove` of its ParticleSystems.
    """

    def __init__(
        self,
        preset: "Preset | dict[str, ParticleSystem]",
        *,
        dt: float | None = None,
        seed: int | None = None,
        precision: str = "f32",
        arch: str = "cpu",
        threads: int | None = None,
        ledger: bool = False,
        domain: "Mapping[str, Any] | None" = None,
        advice: str = "warn",
    ) -> None:
        if not isinstance(precision, str) or precision not in _DTYPES:
            raise UsageError(
                f"precision must be f32 or f64, not {arguments.shown(precision)}{suggest(precision, _DTYPES)}"
            )
        preset = _checked_systems(preset)
        runtime.init(arch, threads)
        self.precision, self.dtype = precision, _DTYPES[precision]
        self.preset: Preset | None = None
        if isinstance(preset, dict):
            members = dict(preset)
            if (box := _checked_domain(domain)) is not None:
                for system in members.values():
                    system.enter(box)
        else:
            if domain is not None:
                raise UsageError(
                    'a preset has its space in itself: set it there, or by load_preset(..., overrides={"domain": ...})'
                )
            from gen_art.simulation.from_preset import systems_of

            self.preset = preset
            box = None if preset.domain is None else preset.domain.box
            members = systems_of(preset)
            dt = preset.clock.step if dt is None else dt
            seed = preset.seed if seed is None else seed
        self.box: PeriodicBox | None = box
        if box is not None:
            box.check_precision(self.dtype)
        self.dt = arguments.number("dt, the time step,", dt, "s", above=0.0)
        self.seed, self.steps_done = arguments.whole("seed", 0 if seed is None else seed, 0, 2**63 - 1), 0
        self.members: Mapping[str, ParticleSystem] = MappingProxyType(members)
        self._watch = Watch(self, advice)
        self._watch.start()
        root = derive(np.uint64(self.seed), channel_of("gen-art"))
        for name, system in members.items():
            system.allocate(name, self, np.uint64(derive(root, channel_of(name))))
        _check_events(members)
        coupled = CoupledSystems.names(members)
        self._steppers = {n: Stepper(s, precision, n in coupled) for n, s in members.items()}
        self._coupled = CoupledSystems(self._steppers, coupled, self.dt, precision)
        self._unknown_rest = True  # whether it is to be found out which systems rest, because particles have come
        for system in members.values():
            give_birth(system.state, [b for e in system.emitters for b in scheduled_births(e, 0.0)], precision)
        self._children = Children(members, precision)
        for name, system in members.items():
            for interaction in system.interactions:
                interaction.check(system)
                for k, sentence in enumerate(interaction.attach(system, self.dt)):
                    self._watch.say(name, f"{interaction.name} {k}", sentence)
        check_potentials(self)
        self._watch.look()
        self._observers: list[Observer] = []
        self._ledger: LedgerKeeper | None = None
        if ledger or any(system.entries for system in members.values()):
            self.keep_ledger()

    def keep_ledger(self, saved: "dict | None" = None) -> None:
        """Keep the ledger from now on; or go on with what another has `saved`, if it is given."""
        from gen_art.simulation.ledger import LedgerKeeper

        self._ledger = self._coupled.ledger = LedgerKeeper(self)
        for stepper in self._steppers.values():
            stepper.ledger = self._ledger
        if saved is not None:
            self._ledger.restore(saved)

    @property
    def time(self) -> float:
        """Simulated seconds since the start (before the preroll)."""
        return self.steps_done * self.dt

    @property
    def systems(self) -> dict[str, Particles]:
        """The storage of each system, read-only, for renderers."""
        return {name: system.state for name, system in self.members.items()}

    @property
    def keeps_ledger(self) -> bool:
        return self._ledger is not None

    @property
    def coupled_names(self) -> list[str]:
        """The names of the systems that forces between particles couple."""
        return list(self._coupled.steppers)

    def stepper(self, name: str) -> Stepper:
        """The Stepper of one system: its step kernel and its arguments."""
        return self._steppers[name]

    def sum_pair_forces(self, name: str, out: np.ndarray) -> None:
        """Write the present accelerations, m/s^2, by each force between the particles of a system to three rows of `out`."""
        self._coupled.sum_pair_forces(self._steppers[name], 0, self.time, out)

    def living(self, name: str) -> np.ndarray:
        """Slots of a system's living particles, in the order of their ids."""
        return np.flatnonzero(self.members[name].state.alive(self.time))

    def __repr__(self) -> str:
        counts = ", ".join(f"{name}: {system.count:,}" for name, system in self.members.items())
        return f"<Simulation at {self.time:g} s, dt {self.dt:g} s, {self.precision}; {counts}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the time, the step and the systems with their forces."""
        caption = f"Simulation at {self.time:g} s, {self.steps_done:,} steps of {self.dt:g} s, {self.precision}"
        rows = [
            (name, f"{system.count:,}", ", ".join(system.acting) or "none", system.scheme.name)
            for name, system in self.members.items()
        ]
        return html_table(caption, rows, ("System", "Particles", "Forces", "Integrator"))

    def __getitem__(self, name: str) -> ParticleSystem:
        if arguments.text("the name of a system", name) not in self.members:
            raise UsageError(f"no system '{name}'{suggest(name, self.members)}")
        return self.members[name]

    def advance(self, seconds: float) -> None:
        """Advance by simulated seconds.

        Raises UsageError (a ValueError) unless they are a whole number of steps; it names the nearest.
        """
        self.step(self.steps_in(seconds))

    def steps_in(self, seconds: float) -> int:
        """The number of steps in `seconds` of simulated time. Raises UsageError unless it is a whole number."""
        seconds = arguments.number("the time to advance by", seconds, "s")
        steps = seconds / self.dt
        if not math.isfinite(steps) or steps < 0:
            raise UsageError(f"cannot advance by {seconds:.12g} s")
        nearest = round(steps)
        if abs(steps - nearest) > 1e-6 * max(1.0, steps):
            raise UsageError(
                f"{seconds:.12g} s is {steps:.6g} steps of {self.dt:g} s; the nearest is {nearest * self.dt:.12g} s"
            )
        return nearest

    def advance_to_frame(self, frame: int) -> None:
        """Advance to frame k of the film, simulated time preroll + speed k / fps. Raises UsageError for a frame in the past."""
        if self.preset is None:
            raise UsageError("frames are counted by a preset's clock; this simulation has none")
        clock = self.preset.clock
        target = clock.preroll_steps + arguments.whole("frame", frame, 0) * clock.steps_per_frame
        if target < self.steps_done:
            raise UsageError(f"frame {frame} is in the past: the simulation is at step {self.steps_done}")
        self.step(target - self.steps_done)
        self._watch.check_finite()

    def step(self, count: int = 1) -> None:
        """Advance by `count` steps of dt."""
        count = arguments.whole("the number of steps", count, 0)
        while count > 0:
            wanted = min((one.steps_left(self.steps_done) for one in self._observers), default=count)
            count -= self._advance(min(count, _BATCH, self._watch.most_steps(), wanted))

    def step_with(self, move: Callable[[int], None]) -> None:
        """Take one step in which `move(number of the step)` moves the particles instead of their integrators."""
        self._advance(1, move)

    def change(self, name: str, act: Callable[[], None]) -> None:
        """Let `act` change the particles of one system from outside, between two steps; the ledger books what has changed."""
        before = self._ledger.holdings(name) if self._ledger else None
        act()
        if self._ledger and before is not None:
            self._ledger.record_outside(name, before)
        self._coupled.forget()
        self._unknown_rest = True
        self._children.add_unseen(name)
        self._watch.restart()

    def _advance(self, most: int, move: Callable[[int], None] | None = None) -> int:
        """Take up to `most` steps in one launch; returns their number."""
        if self._unknown_rest:
            self._coupled.find_resting()
            self._unknown_rest = False
        coupled = bool(self._coupled.moving)
        eventless = self._children.steps_without_events(self.steps_done, most, self.dt) if move is None else 0
        steps = 1 if (coupled or self._ledger or not eventless) else self._batch(eventless)
        first, t0, t1 = self.steps_done, self.time, (self.steps_done + steps) * self.dt
        if self._children.begin(t0, t1, has_events=not eventless):
            self._coupled.forget()
        for system in self.members.values():
            if system.state.tidy(t0, system.name in self._coupled.steppers):
                self._coupled.forget()
        for name, system in self.members.items():
            new = give_birth(
                system.state, [b for e in system.emitters for b in scheduled_births(e, t1)], self.precision
            )
            if new.stop > new.start:
                self._coupled.forget()
                if self._ledger:
                    self._ledger.record_births(name, new)
        self._children.remember_motion()
        if move:
            move(first)
            for system in self.members.values():
                system.state.wrap(slice(0, system.state.count))
            self._coupled.forget()
        else:
            for name, stepper in self._steppers.items():
                if name not in self._coupled.steppers:
                    stepper.run(first, steps, self.dt)
            if coupled:
                self._coupled.step(first)
        self.steps_done += steps
        for name, new in self._children.give_birth(t0, t1):
            if self._ledger:
                self._ledger.record_births(name, new)
            self._coupled.forget()
            self._steppers[name].run(first, 1, self.dt, new.start, -math.inf)
        if self._ledger:
            self._ledger.record_deaths(t0, t1)
        self._watch.look()
        for observer in self._observers:
            observer.look(self)
        return steps

    def _batch(self, most: int) -> int:
        """The number of steps of one launch: fewer when many particles are born, because all are stored before the launch."""
        steps = most
        for system in self.members.values():
            allowed = max(4096, system.state.count // 8)
            while steps > 1 and system.births_until((self.steps_done + steps) * self.dt) > allowed:
                steps = (steps + 1) // 2
        return steps

    def check_finite(self) -> None:
        """Raise DivergedError if a living particle's position or velocity is not finite."""
        self._watch.check()

    def diagnostics(self) -> "Diagnostics":
        """The sums over all living particles now, in float64: see ga.Diagnostics.

        Raises DivergedError if a position or a velocity is not finite.
        """
        self._watch.check()
        from gen_art.simulation.diagnostics import diagnose

        return diagnose(self)

    def ledger(self) -> "Ledger":
        """The ledger so far. Raises UsageError unless the simulation was made with ledger=True."""
        if self._ledger is None:
            raise UsageError("there is no ledger: make the simulation with ledger=True")
        return self._ledger.report()

    def record(
        self, every: int = 10, what: Iterable[str] = ("energy", "momentum"), *, to: str | os.PathLike | None = None
    ) -> "Record":
        """Keep values from now on: now, and after every `every` steps. Recording changes no bit of the simulation.

        what : sums of ga.Diagnostics, such as "energy", of all systems, or of one as "stars.energy"; and quantities of each
            particle that lives now: "stars.position", "stars.velocity", "stars.age" and every attribute
        to : a file (.npz, .parquet, .zarr) that holds the record after its `close()`. Until then its values are in a temporary
            folder beside it, and the memory does not grow
        Raises UsageError for an unknown quantity, and for an ending whose package is missing.
        """
        from gen_art.simulation.record import Record

        record = Record(self, every, what, to)
        self.observe(record)
        return record

    def observe(self, observer: "Observer") -> None:
        """Let an observer look at the steps that it wants to see."""
        self._observers.append(observer)

    def stop_observing(self, observer: "Observer") -> None:
        """Let it look no more."""
        self._observers = [one for one in self._observers if one is not observer]

    def joules(self) -> "dict[str, dict[LedgerEntry, float]]":
        """By system, those entries of the ledger, J, of which its particles keep their shares: see ParticleSystem.booked."""
        if self._ledger is None:
            return {}
        totals = self._ledger.total
        return {
            name: {entry: totals(name, entry) for entry in system.entries}
            for name, system in self.members.items()
            if system.entries
        }

    def digest(self, system: str | None = None) -> str:
        """SHA-256 of the state: the clock, and every living particle of every system, by name.

        system : the name of the only system that counts; all of them when None
        Raises DivergedError if a position or a velocity is not finite, UsageError for an unknown system.
        """
        names = sorted(self.members) if system is None else [self[system].name]
        self._watch.check()
        h = hashlib.sha256(f"{self.precision} {self.steps_done} {self.dt!r} {self.seed}".encode())
        if self.box is not None:
            h.update(repr(self.box).encode())
        for name in names:
            state, living = self.members[name].state, self.living(name)
            h.update(f"{name} {len(living)} {state.next_id} {state.attributes}".encode())
            for column in state.columns():
                h.update(np.ascontiguousarray(column[..., living]).tobytes())
            for interaction in self.members[name].interactions:
                for key, array in interaction.saved_arrays.items():
                    h.update(f"{interaction.name} {key}".encode() + np.ascontiguousarray(array).tobytes())
        return h.hexdigest()

    def save(self, path: str | os.PathLike) -> None:
        """Write the whole state and the ledger, bit for bit, to a snapshot (.gas).

        Raises OutputError when the file cannot be written, DivergedError if a position or a velocity is not finite.
        """
        from gen_art.simulation.snapshot import write

        write(self, self._snapshot(), path)

    def _snapshot(self) -> "Snapshot":
        """The present state, in this simulation's own arrays. Raises DivergedError if a position or velocity is not finite."""
        self._watch.check()
        from gen_art.simulation.snapshot import capture

        return capture(self, self._children.unseen, None if self._ledger is None else self._ledger.saved())

    def go_on_from(self, snapshot: "Snapshot") -> None:
        """Take over the state of a snapshot, whose simulation was made of the same systems as this one."""
        if snapshot.ledger is not None:
            self.keep_ledger(snapshot.ledger)
        self.steps_done = snapshot.steps_done
        snapshot.restore_systems(self.members, self.time)
        self._children.unseen = snapshot.unprocessed_ids
        self._unknown_rest = True

    def copy(self) -> "Simulation":
        """An independent simulation in the same state, the ledger's too. From then on both take the same steps to the same bits.

        It shares the forces, colliders and looks, which do not change. A record stays with the original.
        Raises DivergedError if a position or a velocity is not finite.
        """
        snapshot = self._snapshot()
        twin = type(self)(
            self.preset if self.preset is not None else {k: s.without_particles() for k, s in self.members.items()},
            dt=self.dt,
            seed=self.seed,
            precision=self.precision,
            domain=None if self.preset is not None or self.box is None else {"periodic": self.box.as_dict()},
            advice="none",
        )
        twin._watch = self._watch.continued(twin)
        twin.go_on_from(snapshot)
        return twin

    def continued(self, preset: "Preset") -> "Simulation":
        """A simulation of another preset that goes on from this one's particles and time.

        Its step, and the names of its systems, emitters, interactions and, with a ledger, forces must be the same. Births go
        on by its own schedule. Raises UsageError for another preset, DivergedError if a position or a velocity is not finite.
        """
        other = type(self)(preset, precision=self.precision, advice="none")
        if other.dt != self.dt or list(other.members) != list(self.members):
            raise UsageError("the preset has another step, or other systems")
        for name, system in self.members.items():
            twin = other.members[name]
            booked_alike = self.keeps_ledger == other.keeps_ledger and (
                not self.keeps_ledger or system.ledger_rows == twin.ledger_rows
            )
            if _parts(system) != _parts(twin) or not booked_alike:
                raise UsageError(f"system '{name}' has other emitters, forces between particles or ledger entries")
        try:
            return other._take_particles(self._snapshot())
        except (ValueError, LookupError) as error:  # as of bodies or springs of another number
            if isinstance(error, GenArtError):
                raise
            raise UsageError(f"the particles cannot go on under this preset: {error}") from error

    def _take_particles(self, snapshot: "Snapshot") -> "Simulation":
        """Go on from the particles of a snapshot of another preset; returns this simulation."""
        snapshot.check_members(self.members)
        self.go_on_from(snapshot)
        for emitter in (e for system in self.members.values() for e in system.emitters):
            if emitter.schedule is not None:
                emitter.done = emitter.schedule.until(self.time)
        return self

    @classmethod
    def restore(cls, path: str | os.PathLike, preset: "Preset | None" = None) -> "Simulation":
        """The simulation of a snapshot. It continues with the same bits as the simulation that was saved.

        preset : go on with this preset in place of the saved one, from the saved particles; its systems, emitters and
            interactions must have the same names. Births go on by its own schedule, from the saved time on
        Raises OutputError when the file cannot be read, UsageError when it is not a snapshot, or not one of such a preset.
        """
        from gen_art.simulation.snapshot import read

        snapshot = read(path)
        try:
            if preset is not None:
                return cls(preset, precision=snapshot.precision)._take_particles(snapshot)
            sim = cls(
                snapshot.definition,
                dt=snapshot.dt,
                seed=snapshot.seed,
                precision=snapshot.precision,
                domain=snapshot.domain,
            )
            sim.go_on_from(snapshot)
        except GenArtError:
            raise
        except (TypeError, ValueError, LookupError, AttributeError, OverflowError) as error:
            raise UsageError(f"{path} is damaged: {error}") from error
        return sim
