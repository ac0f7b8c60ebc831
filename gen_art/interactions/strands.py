"""Springs as threads: runs that are listed head to tail, sorted so that many can be taken at once.

A thread is a run of springs (a, b), (b, c), (c, d) ... in the order of their list that meets no particle twice; a spring alone
is a thread of one. Threads get colours, greedily in their order, so that those of one colour share no particle: a
colour's threads may then be taken in any order, or at once, to the same bits. LANES threads of like length stand
side by side, those next to each other in the list together; slots that are left over hold the last particle of their
thread, or one past the end, and no spring.
"""

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti

__all__ = ["LANES", "Strands"]

LANES = 16
_COLOURS = (
    60  # more need a particle with more threads than that: those of it that are left are taken one after the other
)
_TASKS = 16  # of a colour, at most: each has scratch of its own, which stays in the cache
_BATCH = 256  # slots a task, at least


class Strands:
    """The springs between `pairs` ((m, 2) slots) of `count` particles, with `numbers` (m, 3): stiffness, rest length, damping.

    Slots lie in rows of LANES: nodes (slots,): the particle at each slot     numbers (3 rows, LANES): of the springs ending there
    at (m, 3): where the numbers of each spring stand, flat     first (groups + 1,): each group's first row
    tasks (tasks + 1,): the first group of each task     colours: (first task, end) of each
    index, parts: tasks, first and nodes in one array, and where all but the first begin
    scratch: `room` rows for each task of a colour     total (rows, LANES): the impulse of each spring in the sweeps so far
    particles (2 count', 4): what a sweep asks of each particle and of those past the end
    """

    def __init__(self, pairs: np.ndarray, numbers: np.ndarray, count: int, dtype):
        start, length, nodes = _runs(pairs, count)
        units = len(start)
        begin = np.concatenate([[0], np.cumsum(length + 1)]).astype(np.int32)
        colour = np.zeros(max(units, 1), np.int32)
        if units:
            _paint()(nodes, begin, np.zeros(count, np.int64), colour)
        order = np.lexsort((-(length // LANES), colour[:units]))
        shade, length = colour[:units][order], length[order]
        # LANES to a group; where a particle has too many threads, one
        rank = np.arange(units) - np.searchsorted(shade, shade)
        alone = shade == _COLOURS
        lane = np.where(alone, 0, rank % LANES)
        group = np.cumsum(alone | (lane == 0)) - 1
        leads = np.flatnonzero(alone | (lane == 0))
        size = (np.maximum.reduceat(length, leads) + 1) * LANES if units else np.zeros(0, int)
        self.first = np.concatenate([[0], np.cumsum(size)]).astype(np.int32)
        total = int(size.sum())
        # every particle of every thread, in the sorted order
        own = np.repeat(np.arange(units), length + 1)
        step = np.arange(len(own)) - np.repeat(np.cumsum(length + 1) - (length + 1), length + 1)
        slot = self.first[group[own]] + step * LANES + lane[own]
        of = begin[:-1][order][own] + step  # where that node stands in `nodes`
        self.nodes = np.full(max(total, 1), -1, np.int32)
        self.nodes[slot] = nodes[of]
        last = np.broadcast_to(count + np.arange(LANES), (len(leads), LANES)).astype(np.int32).copy()
        last[group, lane] = nodes[begin[1:][order] - 1]
        empty = np.flatnonzero(self.nodes[:total] < 0)
        at = np.searchsorted(self.first[:-1], empty, "right") - 1
        self.nodes[empty] = last[at, (empty - self.first[at]) % LANES]
        spring = step > 0
        where = np.zeros(len(pairs), np.int64)
        where[of[spring] - order[own[spring]] - 1] = slot[spring]  # each thread has one node more than springs
        self.at = (where + 2 * (where - where % LANES))[:, None] + LANES * np.arange(3)
        rows = max(total // LANES, 1)
        self.numbers = runtime.aligned((3 * rows, LANES), dtype)
        self.numbers.reshape(-1)[self.at] = numbers
        self.tasks, self.colours = _tasks(shade[leads], size)
        self.first //= LANES
        index = [self.tasks, self.first, self.nodes]
        self.index = np.concatenate(index)  # in one: a launch costs by the array
        self.parts = np.cumsum([len(part) for part in index])[:2].tolist()
        self.room = 5 * int(size.max(initial=0)) // LANES
        self.scratch = runtime.aligned((_TASKS * self.room + 1, LANES), dtype)
        self.total = runtime.aligned((rows, LANES), dtype)
        self.particles = runtime.aligned((2 * (count + LANES), 4), dtype)


def _runs(pairs, count):
    """Where each thread begins in the list, how many springs it has, and the particles of all, one thread after the other."""
    m = len(pairs)
    joined = np.zeros(m, bool)
    joined[1:] = pairs[1:, 0] == pairs[:-1, 1]
    while True:
        start = np.flatnonzero(~joined)
        length = np.diff(np.append(start, m))
        unit = np.cumsum(~joined) - 1
        nodes = np.empty(m + len(start), np.int32)
        nodes[np.arange(m) + unit + 1] = pairs[:, 1]
        nodes[start + np.arange(len(start))] = pairs[start, 0]
        owner = np.repeat(np.arange(len(start)), length + 1)
        marked = np.sort(owner.astype(np.int64) * count + nodes)
        twice = np.unique(marked[1:][marked[1:] == marked[:-1]] // max(count, 1))
        if not len(twice):
            return start, length, nodes
        joined[np.isin(unit, twice)] = False  # a ring, or a run that crosses itself: spring by spring


def _tasks(shade, size):
    """Groups in tasks of _BATCH slots or more, none across two colours; those of the last colour of all are one task."""
    tasks, colours = [0], []
    for colour in np.unique(shade):
        groups = np.flatnonzero(shade == colour)
        before = np.cumsum(size[groups]) - size[groups]
        part = before // max(_BATCH, -(-size[groups].sum() // _TASKS)) if colour < _COLOURS else before * 0
        ends = groups[np.append(np.flatnonzero(np.diff(part)), len(part) - 1)] + 1
        colours.append((len(tasks) - 1, len(tasks) - 1 + len(ends)))
        tasks.extend(ends.tolist())
    return np.array(tasks, np.int32), colours


def _paint():
    whole = ti.types.ndarray(ti.i32, 1)

    @ti.kernel
    def paint(nodes: whole, begin: whole, used: ti.types.ndarray(ti.i64, 1), colour: whole):
        """The lowest colour that none of a thread's particles has, in the order of the threads: on one thread of the machine."""
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
