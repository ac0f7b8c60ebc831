"""The Simulation: systems of particles advanced together by fixed steps."""

import hashlib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from gen_art.backend import runtime
from gen_art.emitters.births import Batch, give_birth, scheduled
from gen_art.emitters.events import Window, children
from gen_art.errors import UsageError
from gen_art.maths.random import channel_of, derive
from gen_art.particles.storage import Particles
from gen_art.registry import suggest
from gen_art.simulation.coupled_systems import Joined
from gen_art.simulation.stepper import Stepper
from gen_art.simulation.system import ParticleSystem

if TYPE_CHECKING:
    from gen_art.simulation.ledger import Bookkeeper

__all__ = ["Simulation"]

_BATCH = 64  # steps one launch may take where nothing ties them
_DTYPES = {"f32": np.float32, "f64": np.float64}


class Simulation:
    """Particles, their laws and a clock.

    preset : a Preset from ga.load_preset, or a dict of ParticleSystems by name (then `dt`, s, is needed)
    precision : "f32" or "f64"     arch : "cpu"     threads : None for all; fixed by the first Simulation of the process
    ledger : keep the account of work, dissipation, births and deaths; the state's bits are the same with and without
    Raises UsageError for anything that cannot be simulated.
    """

    def __init__(self, preset, *, dt=None, seed=None, precision="f32", arch="cpu", threads=None, ledger=False):
        if precision not in _DTYPES:
            raise UsageError(f"precision must be f32 or f64, not {precision!r}{suggest(precision, _DTYPES)}")
        if isinstance(preset, dict) and not all(isinstance(s, ParticleSystem) for s in preset.values()):
            raise UsageError("systems must be ParticleSystems by name; for a preset use ga.load_preset(...)")
        runtime.init(arch, threads)
        self.precision, self.dtype = precision, _DTYPES[precision]
        self.preset = None
        if isinstance(preset, dict):
            definitions = dict(preset)
        else:
            from gen_art.simulation.from_preset import systems_of

            self.preset = preset
            definitions = systems_of(preset)
            dt = preset.clock.step if dt is None else dt
            seed = preset.seed if seed is None else seed
        if dt is None or not math.isfinite(dt) or dt <= 0:
            raise UsageError(f"dt must be a time step above 0 seconds, not {dt}")
        self.dt, self.seed, self.steps_done = float(dt), int(seed or 0), 0
        self._members: dict[str, ParticleSystem] = definitions
        root = derive(np.uint64(self.seed), channel_of("gen-art"))
        for name, system in definitions.items():
            system._join(name, self.dtype, derive(root, channel_of(name)), lambda: self.time)
        self._check()
        joined = Joined.names(definitions)
        self._stepped = {n: Stepper(s, precision, n in joined) for n, s in definitions.items()}
        self._joined = Joined(self._stepped, joined, self.dt, precision)
        self._eventful = [(n, e) for n, s in definitions.items() for e in s.emitters if e.event is not None]
        for system in definitions.values():
            give_birth(system.state, [b for e in system.emitters for b in scheduled(e, 0.0)], precision)
        # ids of the children made at the end of the last step: their own events were not seen yet
        self._behind = {name: (0, system.state.next_id) for name, system in definitions.items()}
        for system in definitions.values():
            for one in system.interactions:
                one.join(system, self.dt)
        self._ledger: Bookkeeper | None = None
        if ledger:
            self._keep_books()

    def _check(self) -> None:
        for name, system in self._members.items():
            for emission in system.emitters:
                event = emission.event
                if event is None:
                    continue
                if event.system not in self._members:
                    raise UsageError(f"emitter '{emission.name}' listens to '{event.system}', which is no system here")
                if event.kind == "impact" and not self._members[event.system].tells_impacts:
                    raise UsageError(
                        f"emitter '{emission.name}' listens to impacts of '{event.system}', but none of its colliders has "
                        "`action: emit`"
                    )

    def _keep_books(self) -> None:
        """Keep the ledger from now on."""
        from gen_art.simulation.ledger import Bookkeeper

        self._ledger = self._joined.books = Bookkeeper(self)
        for stepper in self._stepped.values():
            stepper.books = self._ledger

    # -- time

    @property
    def time(self) -> float:
        """Simulated seconds since the start (before the preroll)."""
        return self.steps_done * self.dt

    @property
    def systems(self) -> dict[str, Particles]:
        """The storage of each system, for renderers: read only."""
        return {name: system.state for name, system in self._members.items()}

    def __repr__(self):
        counts = ", ".join(f"{name}: {system.count:,}" for name, system in self._members.items())
        return f"<Simulation at {self.time:g} s, dt {self.dt:g} s, {self.precision}; {counts}>"

    def __getitem__(self, name: str) -> ParticleSystem:
        if name not in self._members:
            raise UsageError(f"no system '{name}'{suggest(name, self._members)}")
        return self._members[name]

    def advance(self, seconds: float) -> None:
        """Advance by simulated seconds: a whole number of steps, else UsageError (a ValueError) names the nearest."""
        self.step(self._steps_in(seconds))

    def _steps_in(self, seconds: float) -> int:
        steps = seconds / self.dt
        if not math.isfinite(steps) or steps < 0:
            raise UsageError(f"cannot advance by {seconds} s")
        nearest = round(steps)
        if abs(steps - nearest) > 1e-6 * max(1.0, steps):
            raise UsageError(
                f"{seconds} s is {steps:.6g} steps of {self.dt:g} s; the nearest is {nearest * self.dt:.12g} s"
            )
        return nearest

    def advance_to_frame(self, frame: int) -> None:
        """Advance to film frame k: simulated time preroll + speed k / fps. Raises UsageError if it lies behind."""
        if self.preset is None:
            raise UsageError("frames are counted by a preset's clock; this simulation has none")
        clock = self.preset.clock
        target = clock.preroll_steps + frame * clock.steps_per_frame
        if target < self.steps_done:
            raise UsageError(f"frame {frame} lies behind: the simulation is at step {self.steps_done}")
        self.step(target - self.steps_done)

    def step(self, count: int = 1) -> None:
        """Advance by `count` steps of dt."""
        if count < 0 or int(count) != count:
            raise UsageError(f"steps must be a whole number of at least 0, not {count}")
        while count > 0:
            taken = self._advance(min(int(count), _BATCH))
            count -= taken

    def _advance(self, most: int, move: Callable[[int], None] | None = None) -> int:
        """Up to `most` steps in one launch; `move` moves the particles over one step in the place of their integrators."""
        paired = bool(self._joined.steppers)
        steps = 1 if (move or self._eventful or paired or self._ledger) else self._batch(most)
        first, t0, t1 = self.steps_done, self.time, (self.steps_done + steps) * self.dt
        for system in self._members.values():
            if system.state.tidy(t0, system.name in self._joined.steppers):
                self._joined.forget()
        self._was_behind = self._behind
        for name, system in self._members.items():
            new = give_birth(system.state, [b for e in system.emitters for b in scheduled(e, t1)], self.precision)
            if new.stop > new.start:
                self._joined.forget()
                if self._ledger:
                    self._ledger.born(name, new)
        parents = {e.event.system for _, e in self._eventful if e.event.kind == "path"}
        before = {
            name: self._members[name].state.floats[:6, : self._members[name].state.count].copy() for name in parents
        }
        if move:
            move(first)
            self._joined.forget()
        else:
            for name, stepper in self._stepped.items():
                if name not in self._joined.steppers:
                    stepper.run(first, steps, self.dt)
            if paired:
                self._joined.step(first)
        self.steps_done += steps
        if self._eventful:
            self._give_children(first, t0, t1, before)
        else:
            self._behind = {name: (s.state.next_id, s.state.next_id) for name, s in self._members.items()}
        if self._ledger:
            self._ledger.after_step(t0, t1)
        return steps

    def _batch(self, most: int) -> int:
        """How many steps one launch takes: fewer where many are born, whose storage waits for them meanwhile."""
        steps = most
        for system in self._members.values():
            allowed = max(4096, system.state.count // 8)
            while steps > 1 and system.births_until((self.steps_done + steps) * self.dt) > allowed:
                steps = (steps + 1) // 2
        return steps

    def _give_children(self, first: int, t0: float, t1: float, before: dict) -> None:
        made: dict[str, list[Batch]] = {}
        for name, emission in self._eventful:
            parent = emission.event.system
            window = Window(t0, t1, before.get(parent), self._behind[parent])
            made.setdefault(name, []).extend(children(emission, name, self._members[parent].state, window))
        self._behind = {name: (s.state.next_id, s.state.next_id) for name, s in self._members.items()}
        for name, batches in made.items():
            new = give_birth(self._members[name].state, batches, self.precision)
            self._behind[name] = (self._behind[name][0], self._members[name].state.next_id)
            if new.stop > new.start:
                if self._ledger:
                    self._ledger.born(name, new)
                self._joined.forget()
                self._stepped[name].run(first, 1, self.dt, new.start, -math.inf)

    # -- what it says of itself

    def diagnostics(self):
        """The sums over all living particles now, in float64: see ga.Diagnostics."""
        from gen_art.simulation.diagnostics import diagnose

        return diagnose(self)

    def ledger(self):
        """The account so far; needs Simulation(..., ledger=True), else UsageError."""
        if self._ledger is None:
            raise UsageError("the ledger was not kept: make the simulation with ledger=True")
        return self._ledger.report()

    def digest(self) -> str:
        """SHA-256 of the state: the clock, and every living particle of every system, by name."""
        h = hashlib.sha256(f"{self.precision} {self.steps_done} {self.dt!r} {self.seed}".encode())
        for name in sorted(self._members):
            state = self._members[name].state
            living = np.flatnonzero(state.alive(self.time))
            h.update(f"{name} {len(living)} {state.next_id} {state.attributes}".encode())
            for column in state.columns():
                h.update(np.ascontiguousarray(column[..., living]).tobytes())
            for one in self._members[name].interactions:
                for key, array in one.memory.items():
                    h.update(f"{one.name} {key}".encode() + np.ascontiguousarray(array).tobytes())
        return h.hexdigest()

    def save(self, path) -> None:
        """Write the whole state, bit for bit, to a snapshot (.gas)."""
        from gen_art.simulation.snapshot import save

        save(self, path)

    @classmethod
    def restore(cls, path) -> "Simulation":
        """The simulation a snapshot was taken of; it goes on to the same bits."""
        from gen_art.simulation.snapshot import restore

        return restore(path)
