"""The Simulation: systems of particles advanced together by fixed steps."""

import hashlib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from gen_art import runtime
from gen_art.emitters.emission import Batch, give_birth, scheduled
from gen_art.emitters.events import Window, children
from gen_art.errors import UsageError
from gen_art.integrators.kernels import make_step
from gen_art.interactions.base import Pull, Turn
from gen_art.particles.state import PADDING, Particles
from gen_art.particles.system import ParticleSystem
from gen_art.registry import suggest
from gen_art.rng import channel_of, derive

if TYPE_CHECKING:
    from gen_art.ledger import Bookkeeper

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
            from gen_art.build import systems_of

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
        self._joined = self._find_joined()
        self._stepped = {n: _Stepper(s, precision, n in self._joined) for n, s in definitions.items()}
        self._eventful = [(n, e) for n, s in definitions.items() for e in s.emitters if e.event is not None]
        self._pairs_at = -1
        for system in definitions.values():
            give_birth(system.state, [b for e in system.emitters for b in scheduled(e, 0.0)], precision)
        # ids of the children made at the end of the last step: their own events were not seen yet
        self._behind = {name: (0, system.state.next_id) for name, system in definitions.items()}
        for system in definitions.values():
            for one in system.interactions:
                one.join(system, self.dt)
        self._ledger: Bookkeeper | None = None
        if ledger:
            from gen_art import ledger as accounts

            self._ledger = accounts.Bookkeeper(self)
            for stepper in self._stepped.values():
                stepper.books = self._ledger

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
            for one in system.interactions:
                other = one.source_system
                if other is not None and other not in self._members:
                    raise UsageError(
                        f"system '{name}' takes '{other}' as sources: no such system{suggest(other, self._members)}"
                    )
                if other is not None and self._members[other].scheme.stages != system.scheme.stages:
                    raise UsageError(
                        f"systems '{name}' and '{other}' are joined by a force: give both the same integrator"
                    )

    def _find_joined(self) -> set[str]:
        """The systems that pair forces join: those they act on and those that act."""
        joined = {name for name, s in self._members.items() if s.interactions}
        return joined | {
            one.source_system for s in self._members.values() for one in s.interactions if one.source_system
        }

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
        paired = bool(self._joined)
        steps = 1 if (move or self._eventful or paired or self._ledger) else self._batch(most)
        first, t0, t1 = self.steps_done, self.time, (self.steps_done + steps) * self.dt
        for system in self._members.values():
            if system.state.tidy(t0, system.name in self._joined):
                self._pairs_at = -1
        self._was_behind = self._behind
        for name, system in self._members.items():
            new = give_birth(system.state, [b for e in system.emitters for b in scheduled(e, t1)], self.precision)
            if new.stop > new.start:
                self._pairs_at = -1
                if self._ledger:
                    self._ledger.born(name, new)
        parents = {e.event.system for _, e in self._eventful if e.event.kind == "path"}
        before = {
            name: self._members[name].state.floats[:6, : self._members[name].state.count].copy() for name in parents
        }
        if move:
            move(first)
            self._pairs_at = -1
        elif paired:
            self._paired_step(first)
        else:
            for stepper in self._stepped.values():
                stepper.run(first, steps, self.dt)
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
                self._pairs_at = -1
                self._stepped[name].run(first, 1, self.dt, new.start, -math.inf)

    # -- pairwise interactions

    def _paired_step(self, first: int) -> None:
        """One step, stage by stage: pair accelerations at each stage's positions, then the fused kernel's stage."""
        joined = {name: self._stepped[name] for name in self._joined}
        for name, stepper in self._stepped.items():
            if name in joined:
                stepper.begin()
            else:
                stepper.run(first, 1, self.dt)
        schemes = [stepper.system.scheme for stepper in joined.values()]
        if any(s.first_drift for s in schemes):
            self._pairs_at = -1
            for stepper in joined.values():
                stepper.stage(first, self.dt, -1, 0)
        for g in range(max(len(s.stages) for s in schemes)):
            active = {name: stepper for name, stepper in joined.items() if g < len(stepper.system.scheme.stages)}
            if g > 0 or self._pairs_at != self.steps_done:
                for name, stepper in active.items():
                    self._pull(name, stepper, g)
            for name, stepper in active.items():
                if any(one.implicit for one in stepper.system.interactions):
                    self._implicit_stage(name, stepper, first, g)
                else:
                    stepper.stage(first, self.dt, g, g + 1)
        # where nothing moves after the last kick, its pair accelerations serve the next step's first
        still = all(s.kind == "splitting" and s.stages[-1][2] == 0 for s in schemes)
        still = still and not any(stepper.system.composition.colliders for stepper in joined.values())
        self._pairs_at = self.steps_done + 1 if still else -1
        for name, stepper in joined.items():
            for one in stepper.system.interactions:
                energy = one.let_go(stepper.system.state, self.precision) if one.tears else None
                if energy is not None:
                    self._pairs_at = -1
                    if self._ledger:
                        self._ledger.released(name, one, energy)

    def _implicit_stage(self, name: str, stepper: "_Stepper", first: int, g: int) -> None:
        """Kick, the implicit interactions' own change of velocities, and the drift: theirs, if one carries the particles."""
        system, state = stepper.system, stepper.system.state
        kick, time, drift = system.scheme.stages[g]
        # two stages, so that walls and engines act in the drift alone
        parts = np.array([0.0, kick, time, 0.0, 0.0, time, drift, 0.0], state.floats.dtype)
        old = state.floats[3:6, : state.count].copy()
        turn = Turn(old, self.dt * kick, self.dt * drift, self.time, self.dt, self.precision, bool(self._ledger))
        stepper.stage(first, self.dt, 0, 1, parts)
        carrier = None
        for one in system.interactions:
            if one.implicit and state.count:
                before = state.floats[3:6, : state.count].copy()
                one.solve(state, turn)
                carrier = one if one.carries else carrier
                if self._ledger:
                    self._ledger.solved(name, one, state, before, turn)
        if carrier is None:
            stepper.stage(first, self.dt, 1, 2, parts)
        elif drift > 0:
            carrier.drift(state, turn)

    def _pull(self, name: str, stepper: "_Stepper", g: int) -> None:
        system = self._members[name]
        for k, one in enumerate(system.interactions):
            if one.implicit:
                continue
            other = self._stepped[one.source_system or name]
            if system.state.count:
                pull = Pull(
                    stepper.stage_rows(g), system.state, system.state.count, other.stage_rows(g), other.system.state,
                    other.system.state.count, stepper.span(g, self.dt), self.dt, self.precision,
                )  # fmt: skip
                first = 3 * stepper.parts[k]
                one.accelerate(pull, stepper.pair[first : first + 3 * len(one.parts)])

    # -- what it says of itself

    def diagnostics(self):
        """The sums over all living particles now, in float64: see ga.Diagnostics."""
        from gen_art.diagnostics import diagnose

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
        from gen_art.snapshot import save

        save(self, path)

    @classmethod
    def restore(cls, path) -> "Simulation":
        """The simulation a snapshot was taken of; it goes on to the same bits."""
        from gen_art.snapshot import restore

        return restore(path)


class _Stepper:
    """One system's kernel and what it is launched with."""

    def __init__(self, system: ParticleSystem, precision: str, joined: bool):
        self.system, self.joined = system, joined
        dtype = system.state.floats.dtype
        self.books: Bookkeeper | None = None
        self.numbers = system.composition.numbers(dtype)
        self.scheme_numbers = np.array(system.scheme.numbers, dtype)
        self.pair = np.zeros((1, 1), dtype)
        self.scratch = np.zeros((1, 1), dtype)
        self.parts = np.cumsum([0, *(len(one.parts) for one in system.interactions)]).tolist()
        self.kernel = make_step(
            system.composition, system.scheme.kind, system.scheme.rotates, self.parts[-1],
            joined, system.state.attributes, precision,
        )  # fmt: skip

    def run(self, first: int, steps: int, dt: float, begin: int = 0, earliest: float = 0.0) -> None:
        """Whole steps in one launch, for slots from `begin` on."""
        if self.joined:
            self.begin()
            self.pair[:, begin : self.system.state.count] = (
                0.0  # children feel the others from their first whole step on
            )
        self._launch(begin, first, steps, dt, earliest, -1, len(self.system.scheme.stages))

    def begin(self) -> None:
        """Fit the arrays of pair accelerations and stage states to the storage."""
        size = self.system.state.capacity + PADDING
        if self.system.interactions and self.pair.shape[1] != size:
            self.pair = np.zeros((max(1, 3 * self.parts[-1]), size), self.numbers.dtype)
        keeps = self.system.scheme.kind == "runge_kutta" or self.system.composition.colliders
        if keeps and self.scratch.shape[1] != size:
            self.scratch = np.zeros((12, size), self.numbers.dtype)

    def span(self, g: int, dt: float) -> float:
        """The length of the kick of stage g, s; 0 in Runge-Kutta."""
        return dt * self.system.scheme.stages[g][0] if self.system.scheme.kind == "splitting" else 0.0

    def stage_rows(self, g: int) -> np.ndarray:
        """Rows of which the first six are the positions and velocities at stage g."""
        return self.scratch if g > 0 and self.system.scheme.kind == "runge_kutta" else self.system.state.floats

    def stage(self, first: int, dt: float, stage0: int, stage1: int, numbers: np.ndarray | None = None) -> None:
        """Stages stage0 to stage1 - 1 of one step; from -1 the first drift. numbers : in the place of the scheme's"""
        own = self.scheme_numbers
        self.scheme_numbers = own if numbers is None else numbers
        self._launch(0, first, 1, dt, 0.0, stage0, stage1)
        self.scheme_numbers = own

    def _launch(self, begin, first, steps, dt, earliest, stage0, stage1) -> None:
        state = self.system.state
        if state.count > begin:
            if self.books:
                self.books.step(self.system.name, self, begin, first, dt, earliest, stage0, stage1)
            self.kernel(
                state.floats, state.birth, state.key, self.pair, self.scratch, self.numbers, self.scheme_numbers,
                begin, state.count, float(first), steps, dt, earliest, stage0, stage1,
            )  # fmt: skip
