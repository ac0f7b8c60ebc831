"""Watches a simulation while it runs: numbers that are not finite, and motion that the step or the precision cannot carry.

Now and then it looks at a sample of the particles. It never changes anything.
"""

import math
import sys
import warnings
from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import AdviceWarning, DivergedError, UsageError
from gen_art.maths.array_functions import median
from gen_art.registry import suggest
from gen_art.simulation.advice import system_advice
from gen_art.simulation.block_steps import parts_of
from gen_art.simulation.motion import MotionSample, is_smooth
from gen_art.simulation.no_effect import silent_parts

if TYPE_CHECKING:
    from gen_art.simulation.simulation import Simulation

__all__ = ["MODES", "Watch"]

MODES = ("warn", "error", "none")
_FINITE_EVERY = 64  # steps between two looks for numbers that are not finite, at most
# A sample is three states at consecutive steps. Samples begin at these steps, then at each multiple of the last one.
_SAMPLES = (0, 4, 64, 256, 1024, 4096)
_SAMPLE = 256  # particles in a sample
_TOO_FAST = 1.0  # rad a step, squared
_FEW, _FEW_PAIRED = 0.1, 1e-3  # of a sample that may be too fast: a picture does not depend on them
# Particles that act on each other meet for a few steps only: these many of them are looked at, every _STRIDE steps.
_MOST_PAIRED = 1_000
_STRIDE = 4
_PAIRED_STATES = 18  # are judged together: one by one, most of the time would go into calls
_TOO_FAST_PAIRED = 1.0  # of 2 (1 - cos a), for the angle a in _STRIDE steps: 0.26 rad a step
_ADVISED = 0.15  # rad a step of the step that is advised
_COARSE = 4e-3  # rounding over the median path in a step, in two samples after another


class Watch:
    """What is noticed about one simulation. mode : of advice, one of MODES; divergence is always an error."""

    def __init__(self, sim: "Simulation", mode: str):
        if mode not in MODES:
            raise UsageError(f"advice must be warn, error or none, not {mode!r}{suggest(mode, MODES)}")
        self._sim, self._mode = sim, mode
        self._said: dict[tuple[str, str], str] = {}  # by system and cause
        self._checked_at = 0  # the step of the last look for numbers that are not finite
        self._due = 0  # the next step at which there is anything to look at
        self._sample_at = self._next_at = 0  # the steps at which the present sample began and the next one will
        self._samples, self._paired = {}, {}
        for name, system in sim.members.items() if mode != "none" else ():
            if system.interactions and is_smooth(system):
                self._paired[name] = MotionSample(system, _MOST_PAIRED, _PAIRED_STATES)
            self._samples[name] = MotionSample(system, _SAMPLE)
        self._coarse: set[str] = set()  # systems whose last sample was

    def continued(self, sim: "Simulation") -> "Watch":
        """The Watch of a copy of the simulation, which does not say again what this one has said."""
        other = Watch(sim, self._mode)
        other._said = dict(self._said)
        return other

    def say(self, name: str, cause: str, sentence: str) -> None:
        """Give advice about a system, once a cause. Raises UsageError in mode "error".

        name : of the system; "" where the sentence names it
        """
        if self._mode == "none" or (name, cause) in self._said:
            return
        self._said[name, cause] = sentence
        text = f"system '{name}': {sentence}" if name else sentence
        if self._mode == "error":
            raise UsageError(text)
        warnings.warn(text, AdviceWarning, stacklevel=_depth_of_caller())

    def start(self) -> None:
        """Give the advice that follows from the numbers of the systems, before they have particles."""
        sim = self._sim
        if self._mode == "none":
            return
        for k, sentence in enumerate(silent_parts(sim.preset or sim.members, sim.members)):
            self.say("", f"silent {k}", sentence)
        for name, system in sim.members.items():
            for k, sentence in enumerate(system_advice(system, sim.dt)):
                self.say(name, f"start {k}", sentence)

    def most_steps(self) -> int:
        """The number of steps that a launch may take before the watch must look."""
        if not self._samples:
            return 2**62
        done = self._sim.steps_done
        return 1 if self._into_sample(done) < 2 else self._next_at - done

    def restart(self) -> None:
        """Forget the samples so far, because the particles were changed from outside, which is no motion."""
        self._judge_pairs()
        self._restart_samples()

    def _restart_samples(self) -> None:
        for sample in (*self._samples.values(), *self._paired.values()):
            sample.restart()

    def _into_sample(self, done: int) -> int:
        """The number of steps since the latest sample began."""
        if done >= self._next_at:
            self._sample_at, self._next_at = _samples_around(done)
        return done - self._sample_at

    def look(self) -> None:
        """Look at the state after a launch. Raises DivergedError for numbers that are not finite."""
        done = self._sim.steps_done
        if done < self._due:
            return
        if done - self._checked_at >= _FINITE_EVERY:
            self.check_finite()
        into = self._into_sample(done)
        self._due = self._checked_at + _FINITE_EVERY
        if self._mode == "none":
            return
        self._due = min(self._due, done + 1 if into < 2 else self._next_at)
        if self._paired:
            self._due = min(self._due, done - done % _STRIDE + _STRIDE)
        if into == 0:
            self._judge_pairs()
            # particles that were born since are among those that are chosen now
            self._restart_samples()
        if done % _STRIDE == 0:
            for sample in self._paired.values():
                sample.record()
            if any(sample.is_full for sample in self._paired.values()):
                self._judge_pairs()
        if into <= 2:
            self._look_at_samples()
        if into == 0:
            self._ask_interactions()

    def check(self) -> None:
        """Say what was noticed of particles that act on each other, and raise DivergedError as check_finite does."""
        self._judge_pairs()
        self.check_finite()

    def _judge_pairs(self) -> None:
        """Judge the states of systems whose particles act on each other since the last time."""
        sim = self._sim
        for name, sample in self._paired.items():
            limit = _TOO_FAST_PAIRED * parts_of([sim.members[name]]) ** 2
            counts = sample.count_above(limit)
            for k in np.flatnonzero(counts > _FEW_PAIRED * len(sample.ids)):
                before = len(counts) - 1 - int(k)
                time = sim.time - sim.dt * (sim.steps_done % _STRIDE + before * _STRIDE)
                changes, slots = sample.measure(time, sim.dt, before)
                if (changes > limit).sum() > _FEW_PAIRED * len(changes):
                    self._say_too_fast(name, time, changes, slots, _STRIDE)
            sample.keep(2)

    def _look_at_samples(self) -> None:
        """Take the next state of every system's sample, and judge those that have three."""
        sim = self._sim
        for name, sample in self._samples.items():
            sample.record()
            changes, slots = sample.measure(sim.time, sim.dt)
            if not len(changes):
                continue
            self._judge_features(name, sample.paths(sim.dt))
            if not is_smooth(sim.members[name]):
                continue
            if (changes > _TOO_FAST * parts_of([sim.members[name]]) ** 2).sum() > _FEW * len(changes):
                self._say_too_fast(name, sim.time, changes, slots, 1)
            if sim.dtype == np.float32 and sim.steps_done > _SAMPLES[2]:
                self._judge_precision(name, median(sample.rounding(slots, sim.dt)))

    def _ask_interactions(self) -> None:
        for name, system in self._sim.members.items():
            for interaction in system.interactions:
                for sentence in interaction.advice(system.state):
                    self.say(name, interaction.name, sentence)

    def _say_too_fast(self, name: str, time: float, changes: np.ndarray, slots: np.ndarray, stride: int) -> None:
        sim, system = self._sim, self._sim.members[name]
        worst = int(np.argmax(changes))
        if not math.isfinite(changes[worst]):
            return  # check_finite finds it
        parts = parts_of([system])
        angle = math.sqrt(changes[worst]) / stride / parts
        better = _ADVISED * sim.dt / angle
        bare = [i.name for i in system.interactions if i.values.get("softening") == 0.0]
        soften = f", or give {bare[0]} a softening" if bare else ""
        self.say(
            name, "step",
            f"a step of {sim.dt:g} s is too long for particle {system.state.id[slots[worst]]} at {time:.6g} s: its velocity "
            f"changes as in an oscillation of {angle:.2g} rad a step; use a step of at most {better:.2g} s{soften}",
        )  # fmt: skip

    def _judge_features(self, name: str, paths: np.ndarray) -> None:
        """Say that most particles cross the features of a field within a step."""
        path, dt = float(np.partition(paths, (len(paths) - 1) // 2)[(len(paths) - 1) // 2]), self._sim.dt
        for force in _fields(self._sim.members[name]):
            if path > force.feature_size:
                self.say(
                    name, force.name,
                    f"particles move {path:.3g} m in a step of {dt:g} s, past the {force.feature_size:g} m of {force.name}'s "
                    f"scale; use a step of at most {0.3 * dt * force.feature_size / path:.2g} s, or a larger scale",
                )  # fmt: skip

    def _judge_precision(self, name: str, rounding: float) -> None:
        if rounding <= _COARSE:
            self._coarse.discard(name)
        elif name not in self._coarse:
            self._coarse.add(name)
        else:
            self.say(
                name, "precision",
                f"in float32 a position is rounded by up to {rounding / 2:.2%} of the path in a step, and these errors add up: "
                "use precision f64, units in which positions are smaller, or a longer step",
            )  # fmt: skip

    def check_finite(self) -> None:
        """Raise DivergedError if a living particle's position or velocity is not finite."""
        sim = self._sim
        self._checked_at = sim.steps_done
        for name, system in sim.members.items():
            state = system.state
            rows = state.floats[:6, : state.count]
            with np.errstate(all="ignore"):
                if np.isfinite(rows.sum()):
                    continue
            living = sim.living(name)
            lost = living[~np.isfinite(rows[:, living]).all(axis=0)]
            if len(lost):
                self._judge_pairs()  # may say why
                first = f"particle {state.id[lost[0]]}"
                who = first if len(lost) == 1 else f"{len(lost):,} particles, {first} the first of them,"
                raise DivergedError(
                    f"system '{name}': {who} left the finite numbers by step {sim.steps_done} ({sim.time:.6g} s): "
                    f"{self._likely_cause(name)}"
                )

    def _likely_cause(self, name: str) -> str:
        said = [sentence for (system, _), sentence in self._said.items() if system == name]
        if said:
            return f"most likely because {said[0]}"
        system = self._sim.members[name]
        acting = [*(i.name for i in system.interactions), *(t.name for t in system.composition.terms)]
        under = f" of {', '.join(acting)}" if acting else ""
        return (
            f"most likely a step of {self._sim.dt:g} s is too long for the forces{under}, or two particles without softening "
            "met; try a step ten times shorter"
        )


def _fields(system) -> list:
    """The forces on a system, and the terms of its media."""
    composition = system.composition
    return [term.force for terms in (composition.terms, *composition.media) for term in terms]


def _depth_of_caller() -> int:
    """The stack level, as warnings.warn in the calling function counts it, of the first frame outside this package."""
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("gen_art."):
        depth, frame = depth + 1, frame.f_back
    return depth


def _samples_around(step: int) -> tuple[int, int]:
    """The steps at which the latest sample until `step` begins, and the first one after it."""
    last = _SAMPLES[-1]
    starts = [*_SAMPLES, step - step % last, step - step % last + last]
    return max(s for s in starts if s <= step), min(s for s in starts if s > step)
