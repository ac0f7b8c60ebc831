"""Births caused by events of other particles: their birth, their death, an impact, or their path.

The children of a step are made at its end, one generation a step, ordered by time and then by their parents' keys.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gen_art.emitters.births import ActiveEmitter, BirthBatch
from gen_art.maths.random import channel_of, derive, uniform
from gen_art.particles.storage import Particles

__all__ = ["EventWindow", "event_births"]

_PAIR = np.uint64(1 << 40)  # keys of balanced pairs are beyond those of all ordinals


@dataclass(frozen=True)
class EventWindow:
    """What a step did to a system of parents; all emitters that its events feed share what is found out of it.

    parents : as they are after the step
    t0, t1 : the step's time span, s
    before : (6, count) positions and velocities before the step, where paths need them
    new_ids : (first, end); the particles with these ids were made at the end of the previous step, and their births and deaths
        since then have not been seen yet
    """

    parents: Particles
    t0: float
    t1: float
    before: np.ndarray | None
    new_ids: tuple[int, int]
    _slots: dict[str, np.ndarray] = field(
        default_factory=dict, init=False
    )  # by kind of event, once they were asked for

    @cached_property
    def birth(self) -> np.ndarray:
        return self.parents.birth[: self.parents.count]

    @cached_property
    def death(self) -> np.ndarray:
        return self.parents.death()

    @cached_property
    def is_new(self) -> np.ndarray:
        """Which parents were made at the end of the previous step."""
        ids = self.parents.id[: self.parents.count]
        return (ids >= self.new_ids[0]) & (ids < self.new_ids[1])

    @cached_property
    def impact(self) -> np.ndarray:
        """The times of the parents' last impacts, s; inf without any."""
        age = self.parents.floats[self.parents.channels["impact"], : self.parents.count].astype(np.float64)
        return np.where(age > 0, self.birth + age, np.inf)

    def moments(self, kind: str) -> np.ndarray:
        """The times of the parents' births, deaths or impacts, s."""
        return self.impact if kind == "impact" else self.death if kind == "death" else self.birth

    def slots(self, kind: str) -> np.ndarray:
        """The slots of parents with an event of this kind in the step; those with a path lived for some of it."""
        if kind not in self._slots:
            if kind == "path":
                happened = ((self.death > self.t0) | self.is_new) & (self.birth <= self.t1)
            else:
                moment = self.moments(kind)
                happened = (moment <= self.t1) & ((moment > self.t0) | self.is_new) & (moment < np.inf)
            self._slots[kind] = np.flatnonzero(happened)
        return self._slots[kind]


def event_births(emitter: ActiveEmitter, system: str, window: EventWindow) -> list[BirthBatch]:
    """The births that the parents' events in this window cause.

    emitter : fed by an event
    system : name of the system it belongs to
    """
    event, parents = emitter.event, window.parents
    assert event is not None, "scheduled births have no parents"
    causes = window.slots(event.kind)
    if event.tags and len(causes):
        has_tag = np.array([source.tag in event.tags for source in parents.sources], bool)
        causes = causes[has_tag[parents.source[causes]]]
    if not len(causes):
        return []
    if event.kind == "path":
        birth = window.birth[causes]
        start = np.where(window.is_new[causes], birth, np.maximum(birth, window.t0))
        end = np.minimum(window.death[causes], window.t1)
        first = np.floor((start - birth) * event.rate + 0.5).astype(np.int64)
        last = np.floor((end - birth) * event.rate + 0.5).astype(np.int64)
        counts = np.maximum(last - first, 0)
        if not counts.any():
            return []
        parent = np.repeat(causes, counts)
        ordinal = _count_up(counts) + np.repeat(first, counts)
        when = window.birth[parent] + (ordinal + 0.5) / event.rate
        origin = _path_state(parent, when, window)
        keys = _event_keys(emitter, system, parents, parent)
        choice = emitter.choose(keys)
    else:
        keys = _event_keys(emitter, system, parents, causes)
        kind_index = emitter.choose(keys)
        low = np.array([k.count[0] for k in emitter.kinds])[kind_index]
        high = np.array([k.count[1] for k in emitter.kinds])[kind_index]
        counts = low
        if (high > low).any():
            counts = low + np.floor(uniform(keys, channel_of("count")) * (high - low + 1)).astype(np.int64)
        parent, keys, choice = np.repeat(causes, counts), np.repeat(keys, counts), np.repeat(kind_index, counts)
        ordinal = _count_up(counts)
        when = window.moments(event.kind)[parent]
        origin = parents.floats[:6, parent].astype(np.float64)
        if event.kind == "impact":  # the parent has moved on since the impact: back along its velocity
            origin[:3] -= origin[3:] * (np.minimum(window.t1, window.death[parent]) - when)
    if not len(parent):
        return []
    if not event.inherit:
        origin[3:] = 0.0
    child_keys = derive(keys, ordinal)
    paired, sign = child_keys, np.ones(len(child_keys))
    if event.pairs:
        paired = derive(keys, _PAIR + (ordinal // 2).astype(np.uint64))
        unpaired = np.repeat(counts, counts) - 1 == ordinal
        sign = np.where(ordinal % 2 == 1, -1.0, np.where(unpaired, 0.0, 1.0))
    rank = _key_from_words(parents.key[:, parent])
    whole = BirthBatch(
        emitter.kinds[0], emitter.first_source, when, child_keys, paired, keys, ordinal, sign, origin, rank
    )
    return whole.by_choice(emitter, choice)


def _key_from_words(words: np.ndarray) -> np.ndarray:
    return (words[0].astype(np.uint64) << np.uint64(32)) | words[1].astype(np.uint64)


def _event_keys(emitter: ActiveEmitter, system: str, parents: Particles, slots: np.ndarray) -> np.ndarray:
    return derive(_key_from_words(parents.key[:, slots]), channel_of(f"{system}.{emitter.name}"))


def _count_up(counts: np.ndarray) -> np.ndarray:
    """0 .. c - 1 for each count c, concatenated."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)


def _path_state(parent: np.ndarray, when: np.ndarray, window: EventWindow) -> np.ndarray:
    """Position and velocity (6, m) at times `when`, on the cubic through both ends of each parent's step.

    In a periodic box the end is the image nearest to the place that the mean velocity leads to.
    """
    parents, before = window.parents, window.before
    assert before is not None, "paths need the state before the step"
    t0 = np.maximum(window.birth[parent], window.t0)
    t0 = np.where(window.is_new[parent], window.t0, t0)
    t1 = np.minimum(window.death[parent], window.t1)
    h = np.where(t1 > t0, t1 - t0, 1.0)
    s = (when - t0) / h
    a, b = before[:, parent].astype(np.float64), parents.floats[:6, parent].astype(np.float64)
    x0, v0, x1, v1 = a[:3], a[3:] * h, b[:3], b[3:] * h
    if parents.box is not None:
        expected = x0 + 0.5 * (v0 + v1)
        x1 = expected + parents.box.nearest(x1 - expected)
    s2, s3 = s * s, s * s * s
    x = (2 * s3 - 3 * s2 + 1) * x0 + (s3 - 2 * s2 + s) * v0 + (3 * s2 - 2 * s3) * x1 + (s3 - s2) * v1
    v = ((6 * s2 - 6 * s) * (x0 - x1) + (3 * s2 - 4 * s + 1) * v0 + (3 * s2 - 2 * s) * v1) / h
    over = t1 <= t0  # of parents that have died in the step in which they were born: they are where they died
    if over.any():
        x[:, over] = b[:3, over] + b[3:, over] * (when - t1)[over]
        v[:, over] = b[3:, over]
    return np.concatenate([x, v])
