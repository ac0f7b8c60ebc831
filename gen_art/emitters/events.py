"""Births fed by what happens to other particles: at their birth, at their death, along their path, where they strike.

Children of a step are made at its end, one generation a step, in the order of their times and their parents' keys.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.emitters.births import ActiveEmitter, BirthBatch
from gen_art.maths.random import channel_of, derive, uniform
from gen_art.particles.storage import Particles

__all__ = ["EventWindow", "children"]

_PAIR = np.uint64(1 << 40)  # keys of balanced pairs lie beyond every ordinal


@dataclass
class EventWindow:
    """What a step did to a system of parents: its time span, the state before it, and whose events were not seen before."""

    t0: float
    t1: float
    before: np.ndarray | None  # (6, count) positions and velocities before the step, where paths are wanted
    behind: tuple[int, int]  # ids first .. last - 1 were made at the end of the step before

    def fresh(self, ids: np.ndarray) -> np.ndarray:
        return (ids >= self.behind[0]) & (ids < self.behind[1])


def children(emission: ActiveEmitter, system: str, parents: Particles, window: EventWindow) -> list[BirthBatch]:
    """The births that `emission` (of the system of that name) owes to its parents in this window."""
    event = emission.event
    assert event is not None, "scheduled births have no parents"
    of_tag = np.ones(len(parents.sources), bool)
    if event.tags:
        of_tag = np.array([source.tag in event.tags for source in parents.sources], bool)
    n = parents.count
    birth, death = parents.birth[:n], parents.death()
    fresh = window.fresh(parents.id[:n])
    eligible = of_tag[parents.source[:n]]
    if event.kind == "path":
        picked = np.flatnonzero(eligible & ((death > window.t0) | fresh) & (birth <= window.t1))
        start = np.where(fresh[picked], birth[picked], np.maximum(birth[picked], window.t0))
        end = np.minimum(death[picked], window.t1)
        first = np.floor((start - birth[picked]) * event.rate + 0.5).astype(np.int64)
        last = np.floor((end - birth[picked]) * event.rate + 0.5).astype(np.int64)
        counts = np.maximum(last - first, 0)
        if not counts.any():
            return []
        parent = np.repeat(picked, counts)
        ordinal = _count_up(counts) + np.repeat(first, counts)
        when = birth[parent] + (ordinal + 0.5) / event.rate
        assert window.before is not None, "paths need the state before the step"
        origin = _along(parents, parent, when, window, window.before)
        keys = _event_keys(emission, system, parents, parent)
        choice = emission.choose(keys)
    else:
        moment = death if event.kind == "death" else birth
        if event.kind == "impact":  # the last of a step; a particle that has struck nothing has no such age
            age = parents.floats[parents.channels["impact"], :n].astype(np.float64)
            moment = np.where(age > 0, birth + age, np.inf)
        happened = (moment <= window.t1) & ((moment > window.t0) | fresh)
        picked = np.flatnonzero(eligible & happened & np.isfinite(moment))
        if not len(picked):
            return []
        keys = _event_keys(emission, system, parents, picked)
        kind = emission.choose(keys)
        low = np.array([k.count[0] for k in emission.kinds])[kind]
        high = np.array([k.count[1] for k in emission.kinds])[kind]
        counts = low
        if (high > low).any():
            counts = low + np.floor(uniform(keys, channel_of("count")) * (high - low + 1)).astype(np.int64)
        parent, keys, choice = np.repeat(picked, counts), np.repeat(keys, counts), np.repeat(kind, counts)
        ordinal = _count_up(counts)
        when = moment[parent]
        origin = parents.floats[:6, parent].astype(np.float64)
        if event.kind == "impact":  # it has flown on since
            origin[:3] -= origin[3:] * (np.minimum(window.t1, death[parent]) - when)
    if not len(parent):
        return []
    if not event.inherit:
        origin[3:] = 0.0
    own = derive(keys, ordinal)
    paired, sign = own, np.ones(len(own))
    if event.pairs:
        paired = derive(keys, _PAIR + (ordinal // 2).astype(np.uint64))
        alone = np.repeat(counts, counts) - 1 == ordinal
        sign = np.where(ordinal % 2 == 1, -1.0, np.where(alone, 0.0, 1.0))
    rank = _key_from_words(parents.key[:, parent])
    batches = []
    for c in np.unique(choice):
        of = choice == c
        batches.append(
            BirthBatch(
                emission.kinds[c], emission.first_source + int(c), when[of], own[of], paired[of], keys[of],
                ordinal[of], sign[of], origin[:, of], rank[of],
            )
        )  # fmt: skip
    return batches


def _key_from_words(words: np.ndarray) -> np.ndarray:
    return (words[0].astype(np.uint64) << np.uint64(32)) | words[1].astype(np.uint64)


def _event_keys(emission: ActiveEmitter, system: str, parents: Particles, slots: np.ndarray) -> np.ndarray:
    return derive(_key_from_words(parents.key[:, slots]), channel_of(f"{system}.{emission.name}"))


def _count_up(counts: np.ndarray) -> np.ndarray:
    """0 .. c - 1 for each count c, one after the other."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)


def _along(
    parents: Particles, parent: np.ndarray, when: np.ndarray, window: EventWindow, before: np.ndarray
) -> np.ndarray:
    """Position and velocity (6, m) on the cubic through both ends of each parent's step."""
    t0 = np.maximum(parents.birth[parent], window.t0)
    t0 = np.where(window.fresh(parents.id[parent]), window.t0, t0)
    t1 = np.minimum(parents.death()[parent], window.t1)
    h = np.maximum(t1 - t0, 1e-300)
    s = (when - t0) / h
    a, b = before[:, parent].astype(np.float64), parents.floats[:6, parent].astype(np.float64)
    x0, v0, x1, v1 = a[:3], a[3:] * h, b[:3], b[3:] * h
    s2, s3 = s * s, s * s * s
    x = (2 * s3 - 3 * s2 + 1) * x0 + (s3 - 2 * s2 + s) * v0 + (3 * s2 - 2 * s3) * x1 + (s3 - s2) * v1
    v = ((6 * s2 - 6 * s) * (x0 - x1) + (3 * s2 - 4 * s + 1) * v0 + (3 * s2 - 2 * s) * v1) / h
    return np.concatenate([x, v])
