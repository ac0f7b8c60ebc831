"""Springs as strands: runs of springs that are listed head to tail, sorted so that many can be solved at once.

A strand is a run of springs (a, b), (b, c), (c, d) ... in the order of their list that visits no particle twice; a single
spring is a strand of one. Strands are coloured greedily in their order, so that strands of one colour share no particle: they
can be solved in any order, or at once, with the same bits. LANES strands of similar length form a group and are stored side by
side, neighbours in the list together. Unused slots hold the last particle of their strand, or one past the end, and no spring.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti

__all__ = ["LANES", "SCRATCH", "Strands"]

LANES = 16
SCRATCH = 5  # rows of scratch for each row of a group, see xpbd.py
_COLOURS = (
    60  # strands that find no free colour, at particles with more strands than this, are solved one after the other
)
_MAX_TASKS = 16  # per colour: each task has scratch of its own, which stays in the cache
_MIN_SLOTS = 256  # per task


class Strands:
    """The springs between `pairs` (m, 2), slots, of `count` particles, with `numbers` (m, 3): stiffness, rest length, damping.

    Groups lie one after the other in rows of LANES slots; a group has as many rows as its longest strand has particles.

    nodes : (slots,), the particle at each slot
    numbers : (3 rows, LANES), of the springs that end at each slot
    places : (m, 3), the flat positions of each spring's numbers in `numbers`
    first : (groups + 1,), each group's first row
    tasks : (tasks + 1,), the first group of each task
    colours : (first task, end) of each colour
    index : tasks, first and nodes in one array
    parts : where first and nodes begin in `index`
    scratch : scratch_rows rows for each task of a colour
    total : (rows, LANES), N s, the impulse of each spring in the sweeps so far
    particles : (2 (count + LANES), 4), the state of each particle, and of the unused slots past the end
    """

    def __init__(self, pairs: np.ndarray, numbers: np.ndarray, count: int, dtype):
        start, length, nodes = _runs(pairs, count)
        strands = len(start)
        begin = np.concatenate([[0], np.cumsum(length + 1)]).astype(np.int32)
        colour = np.zeros(max(strands, 1), np.int32)
        if strands:
            _colouring()(nodes, begin, np.zeros(count, np.int64), colour)
        order = np.lexsort((-(length // LANES), colour[:strands]))
        colour, length = colour[:strands][order], length[order]
        # LANES strands to a group; one to a group where no colour was free
        rank = np.arange(strands) - np.searchsorted(colour, colour)
        alone = colour == _COLOURS
        lane = np.where(alone, 0, rank % LANES)
        group = np.cumsum(alone | (lane == 0)) - 1
        leaders = np.flatnonzero(alone | (lane == 0))
        size = (np.maximum.reduceat(length, leaders) + 1) * LANES if strands else np.zeros(0, int)
        self.first = np.concatenate([[0], np.cumsum(size)]).astype(np.int32)
        slots = int(size.sum())
        # every particle of every strand, in the sorted order
        owner = np.repeat(np.arange(strands), length + 1)
        step = np.arange(len(owner)) - np.repeat(np.cumsum(length + 1) - (length + 1), length + 1)
        slot = self.first[group[owner]] + step * LANES + lane[owner]
        source = begin[:-1][order][owner] + step  # the node's position in `nodes`
        self.nodes = np.full(max(slots, 1), -1, np.int32)
        self.nodes[slot] = nodes[source]
        last = np.broadcast_to(count + np.arange(LANES), (len(leaders), LANES)).astype(np.int32).copy()
        last[group, lane] = nodes[begin[1:][order] - 1]
        empty = np.flatnonzero(self.nodes[:slots] < 0)
        empty_group = np.searchsorted(self.first[:-1], empty, "right") - 1
        self.nodes[empty] = last[empty_group, (empty - self.first[empty_group]) % LANES]
        ends_spring = step > 0
        spring_slot = np.zeros(len(pairs), np.int64)
        spring = source[ends_spring] - order[owner[ends_spring]] - 1  # each strand has one node more than springs
        spring_slot[spring] = slot[ends_spring]
        self.places = (spring_slot + 2 * (spring_slot - spring_slot % LANES))[:, None] + LANES * np.arange(3)
        rows = max(slots // LANES, 1)
        self.numbers = runtime.aligned((3 * rows, LANES), dtype)
        self.numbers.reshape(-1)[self.places] = numbers
        self.tasks, self.colours = _tasks(colour[leaders], size)
        self.first //= LANES
        index = [self.tasks, self.first, self.nodes]
        self.index = np.concatenate(index)  # one array, because a launch costs time for each array
        self.parts = np.cumsum([len(part) for part in index])[:2].tolist()
        self.scratch_rows = SCRATCH * int(size.max(initial=0)) // LANES
        self.scratch = runtime.aligned((_MAX_TASKS * self.scratch_rows + 1, LANES), dtype)
        self.total = runtime.aligned((rows, LANES), dtype)
        self.particles = runtime.aligned((2 * (count + LANES), 4), dtype)


def _runs(pairs, count):
    """For each strand its first spring and its number of springs; and the particles of all strands, one after the other."""
    m = len(pairs)
    joined = np.zeros(m, bool)
    joined[1:] = pairs[1:, 0] == pairs[:-1, 1]
    while True:
        start = np.flatnonzero(~joined)
        length = np.diff(np.append(start, m))
        strand = np.cumsum(~joined) - 1
        nodes = np.empty(m + len(start), np.int32)
        nodes[np.arange(m) + strand + 1] = pairs[:, 1]
        nodes[start + np.arange(len(start))] = pairs[start, 0]
        owner = np.repeat(np.arange(len(start)), length + 1)
        visits = np.sort(owner.astype(np.int64) * count + nodes)
        twice = np.unique(visits[1:][visits[1:] == visits[:-1]] // max(count, 1))
        if not len(twice):
            return start, length, nodes
        joined[np.isin(strand, twice)] = False  # a ring, or a run that crosses itself, is split into single springs


def _tasks(colour, size):
    """Groups in tasks of _MIN_SLOTS slots or more, none across two colours; strands without a colour are one task."""
    tasks, colours = [0], []
    for c in np.unique(colour):
        groups = np.flatnonzero(colour == c)
        before = np.cumsum(size[groups]) - size[groups]
        part = before // max(_MIN_SLOTS, -(-size[groups].sum() // _MAX_TASKS)) if c < _COLOURS else before * 0
        ends = groups[np.append(np.flatnonzero(np.diff(part)), len(part) - 1)] + 1
        colours.append((len(tasks) - 1, len(tasks) - 1 + len(ends)))
        tasks.extend(ends.tolist())
    return np.array(tasks, np.int32), colours


def _colouring():
    ints = ti.types.ndarray(ti.i32, 1)

    @ti.kernel
    def paint(nodes: ints, begin: ints, used: ti.types.ndarray(ti.i64, 1), colour: ints):
        """The lowest colour that none of a strand's particles has, in the order of the strands; runs on one CPU thread.

        used : the colours of each particle's strands, as bits
        """
        ti.loop_config(serialize=True)
        for u in range(colour.shape[0]):
            taken = ti.i64(0)
            for k in range(begin[u], begin[u + 1]):
                taken |= used[nodes[k]]
            c = 0
            while c < _COLOURS and (taken >> ti.cast(c, ti.i64)) & ti.i64(1) == ti.i64(1):
                c += 1
            if c < _COLOURS:
                for k in range(begin[u], begin[u + 1]):
                    used[nodes[k]] = used[nodes[k]] | (ti.i64(1) << ti.cast(c, ti.i64))
            colour[u] = c

    return runtime.kernel(paint)
