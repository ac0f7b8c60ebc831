"""The particles of a simulation that events of others make: which steps may have events, and who is born at their ends."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from gen_art.emitters.births import BirthBatch, give_birth
from gen_art.emitters.events import EventWindow, event_births
from gen_art.particles.storage import Particles

if TYPE_CHECKING:
    from gen_art.simulation.system import ParticleSystem

__all__ = ["Children"]


class Children:
    """Gives birth to the children of a step's events, at its end.

    Of a step: `begin`, then scheduled births, `remember_motion`, the motion, and `give_birth`.
    unseen : by system, the ids from..to of particles that were made at the end of the last step: no emitter has seen their
        births yet
    """

    def __init__(self, members: "Mapping[str, ParticleSystem]", precision: str):
        self._members, self._precision = members, precision
        self._emitters = [(n, e, e.event) for n, s in members.items() for e in s.emitters if e.event is not None]
        self._parents = sorted({event.system for _, _, event in self._emitters})
        self._active: list = []  # emitters that this step's events may feed
        self._gone: dict[str, Particles] = {}  # parents that were removed before their events were seen
        self._before: dict[str, np.ndarray] = {}  # positions and velocities of parents before the step, for paths
        self.unseen: dict[str, tuple[int, int]] = {n: (0, s.state.next_id) for n, s in members.items()}

    def add_unseen(self, name: str) -> None:
        """Particles were added to a system from outside: emitters have yet to see their births."""
        self.unseen[name] = (self.unseen[name][0], self._members[name].state.next_id)

    def steps_without_events(self, first: int, most: int, dt: float) -> int:
        """How many steps from step `first` on, up to `most`, surely have no event that feeds an emitter; 0 if the next may."""
        t0 = first * dt
        for _, emitter, event in self._emitters:
            if (first + most) * dt <= emitter.begins:
                continue
            parents, unseen = self._members[event.system], self.unseen[event.system]
            if unseen[1] > unseen[0]:
                return 0
            if event.kind != "birth":
                death = parents.state.death()
                death = death[death > t0]
                if len(death) and (event.kind != "death" or parents.composition.colliders):  # which may end a life
                    return 0
                if len(death) and np.min(death) < np.inf:
                    most = min(most, int((np.min(death) - t0) / dt) - 1)
            while most > 0 and parents.births_until((first + most) * dt) > 0:
                most //= 2
            if most < 1:
                return 0
        return most

    def begin(self, t0: float, t1: float, has_events: bool) -> list[str]:
        """Begin the step from t0 to t1, s, or steps without events; returns the names of systems whose slots have changed.

        Parents that were born of events in the last step and have died in it are set aside: their events have not been seen yet,
        and a storage removes whoever is dead.
        """
        self._active = [each for each in self._emitters if has_events and t1 > each[1].begins]
        self._gone, self._before = {}, {}
        for name in self._parents if has_events else ():
            state, unseen = self._members[name].state, self.unseen[name]
            if unseen[1] > unseen[0]:
                slots = np.flatnonzero((state.id[: state.count] >= unseen[0]) & (state.death() <= t0))
                if len(slots):
                    self._gone[name] = state.some(slots)
                    state.remove(slots)
        return list(self._gone)

    def remember_motion(self) -> None:
        """Keep the positions and velocities before the step of parents whose paths feed emitters."""
        for _, _, event in self._active:
            if event.kind == "path" and event.system not in self._before:
                state = self._members[event.system].state
                self._before[event.system] = state.floats[:6, : state.count].copy()

    def give_birth(self, t0: float, t1: float) -> Iterator[tuple[str, slice]]:
        """Make the children of the step's events; yields each system's name and the slots of its children."""
        windows = {name: self._windows(name, t0, t1) for name in {event.system for _, _, event in self._active}}
        born: dict[str, list[BirthBatch]] = {}
        for name, emitter, event in self._active:
            for window in windows[event.system]:
                if window.parents.count:
                    born.setdefault(name, []).extend(event_births(emitter, name, window))
        self.unseen = {name: (s.state.next_id, s.state.next_id) for name, s in self._members.items()}
        for name, batches in born.items():
            new = give_birth(self._members[name].state, batches, self._precision)
            self.add_unseen(name)
            if new.stop > new.start:
                yield name, new

    def _windows(self, parent: str, t0: float, t1: float) -> list[EventWindow]:
        unseen, gone = self.unseen[parent], self._gone.get(parent)
        windows = [EventWindow(self._members[parent].state, t0, t1, self._before.get(parent), unseen)]
        if gone is not None:
            windows.append(EventWindow(gone, t0, t1, gone.floats[:6, : gone.count], unseen))
        return windows
