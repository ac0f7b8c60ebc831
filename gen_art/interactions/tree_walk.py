"""The walk through a tree of targets: what acts on each cell from afar, and on the particles of each leaf from near by.

A task owns a branch of the target tree and comes down to it from the root. At each cell it sorts the sources that its parent left
open: distant ones go into the cell's local expansion, eight at a time; the others are opened, or are left to the cell's children.
At a leaf, what is left acts particle by particle, with sixteen targets as lanes.

Whether two cells are distant, and which of the two is opened, is the same from either side: what A does to B, B does to A.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.expansions import CENTRE, GRADIENT, MOMENTS, VALUE, expansion
from gen_art.interactions.pair_sums import LANES, half_powers, load, spread

__all__ = ["LEVEL_COLUMNS", "walk_kernel"]

CELL, FIRST_OPEN, LAST_OPEN, NEXT_CHILD, LEVEL_COLUMNS = 0, 1, 2, 3, 4  # what a task knows of each cell on its way down

_FAR = 8  # distant cells at a time
_ROOM = (
    32  # entries that a run of up to eight cells, or the filling of the last group of distant cells, may add to a list
)

INTS, TABLE, CUBE = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i32, 2), ti.types.ndarray(ti.i32, 3)
NUMBERS, DOUBLE, DOUBLES = ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.f64, 2), ti.types.ndarray(ti.f64, 3)


@ti.func
def _eight(x):
    return ti.Vector([ti.cast(x, ti.f64) for _ in ti.static(range(_FAR))])


@ti.func
def _sort_open(
    task, a, first, last, links: ti.template(), s_links: ti.template(), A: ti.template(), B: ti.template(), lists: ti.template(),
    waiting: ti.template(), far: ti.template(), q: ti.template(), same, full: ti.template(),
):  # fmt: skip
    """Sort the open sources lists[task, first:last] of cell a: the distant ones into `far`, those that stay open behind `last`.

    Returns the end of those that stay open, and the number of distant ones.
    """
    x, y, z, radius, leaf = A[a, 0], A[a, 1], A[a, 2], A[a, 3], links[a, 1] == 0
    kept, distant = last, 0
    for at in range(first, last):
        s, run, top = lists[task, at], 1, 0  # run: sibling cells to look at; top: cells that wait to be opened
        while run > 0:
            if ti.max(kept, distant, top) + _ROOM > lists.shape[1]:
                full[task] = 1
            if full[task] == 1:
                run, top = 0, 0
            for b in range(s, s + run):
                dx, dy, dz, other = x - B[b, 0], y - B[b, 1], z - B[b, 2], B[b, 3]
                reach = radius + other
                if same == 1 and b == a:
                    if leaf:
                        lists[task, kept] = b
                        kept += 1
                    else:  # both are opened: each child meets all children
                        for k in range(links[a, 1]):
                            lists[task, kept + k] = links[a, 0] + k
                        kept += links[a, 1]
                elif reach * reach < q[1] * (dx * dx + dy * dy + dz * dz):
                    far[task, distant] = b
                    distant += 1
                elif s_links[b, 1] > 0 and (leaf or other > radius or (other == radius and b > a)):
                    waiting[task, top] = b
                    top += 1
                else:
                    lists[task, kept] = b
                    kept += 1
            run = 0
            if top > 0:
                top -= 1
                s, run = s_links[waiting[task, top], 0], s_links[waiting[task, top], 1]
    return kept, distant


@ti.func
def _next_cell(
    task, level, root, begin: ti.template(), end: ti.template(), links: ti.template(), levels: ti.template()
):
    """The level of the task's next cell, whose parent notes which child it is; or -1 at the end.

    It is the next child of the last cell, or of the closest cell above that has one. Above the task's own branch that is only
    the child which leads to the branch.
    """
    child = -1
    while child < 0 and level >= 0:
        c, k = levels[task, level, CELL], levels[task, level, NEXT_CHILD]
        if c < root and begin[c] <= begin[root] and end[c] >= end[root]:
            if k > 0:
                k = links[c, 1]
            else:
                while end[links[c, 0] + k] <= begin[root]:
                    k += 1
        if k < links[c, 1]:
            levels[task, level, NEXT_CHILD] = k + 1
            child = links[c, 0] + k
            levels[task, level + 1, CELL] = child
        level -= 1
    return ti.select(child < 0, -1, level + 2)


@cache
def walk_kernel(valued: bool, order: int, precision: str):
    """The kernel that writes ψ, if `valued`, into row 0 of `out`, or else its gradient; by expansions of an order.

    roots : (tasks,), the cells that the tasks own
    begin, end, links : of the target tree; s_begin, s_end, s_links : of the source tree
    A, B : (cells, 4), centres and radii of the cells of both, m
    M, N : (cells, columns) of the targets' and of the sources' cells; N has one row more: moments of 0, far away
    P, S : (4, n + LANES) and (4, m or more), targets and sources in order
    lists, waiting, far : (tasks, capacity), the open sources of each level; those to be opened; the distant ones
    levels : (tasks, levels + 1, LEVEL_COLUMNS)
    C : (tasks, levels, coefficients), local expansions
    q : softening^2, theta^2
    same : 1 if the sources are the targets
    places : (n,), the columns of `out` for the targets in order
    full : (tasks,), 1 for a task whose lists were too short: its results have no meaning
    """
    float_type = runtime.DTYPES[precision]
    matrix = ti.types.ndarray(float_type, 2)
    weight = half_powers(-1 if valued else -3)
    rows = [VALUE] if valued else [GRADIENT, GRADIENT + 1, GRADIENT + 2]
    terms = expansion(order)
    needed = list(range(VALUE if valued else GRADIENT, terms.coefficients))  # the value acts on nothing else
    add_far_field, add_shifted = terms.add_far_field, terms.add_shifted

    @ti.func
    def act_from_afar(
        task, level, a, distant, far: ti.template(), M: ti.template(), N: ti.template(), C: ti.template(), q: ti.template()
    ):  # fmt: skip
        """Add the fields of the `distant` first cells in `far` to the expansion of cell a."""
        for k in range(_FAR):
            far[task, distant + k] = N.shape[0] - 1
        total = [_eight(0.0) for _ in ti.static(range(terms.coefficients))]
        for group in range((distant + _FAR - 1) // _FAR):
            at = [far[task, group * _FAR + k] for k in ti.static(range(_FAR))]
            R = [
                _eight(M[a, CENTRE + i]) - ti.Vector([N[at[k], CENTRE + i] for k in ti.static(range(_FAR))])
                for i in ti.static(range(3))
            ]
            m = [
                ti.Vector([N[at[k], MOMENTS + column] for k in ti.static(range(_FAR))])
                for column in ti.static(range(terms.moments))
            ]
            whole = [_eight(k) for k in ti.static(range(terms.whole))]
            add_far_field(total, R, m, _eight(q[0]), whole, needed[0])
        for k in ti.static(needed):
            v = total[k]
            C[task, level, k] += ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]))

    @ti.func
    def act_near_by(
        task, level, a, first, last, begin: ti.template(), end: ti.template(), s_begin: ti.template(), s_end: ti.template(),
        M: ti.template(), P: ti.template(), S: ti.template(), lists: ti.template(), C: ti.template(), q: ti.template(),
        places: ti.template(), out: ti.template(),
    ):  # fmt: skip
        """Write the sums of the particles of leaf a: its expansion, and the particles of the cells lists[task, first:last]."""
        for tile in range((end[a] - begin[a] + LANES - 1) // LANES):
            i = begin[a] + tile * LANES
            X = [load(P, k, i) for k in ti.static(range(3))]
            back = [spread(M[a, CENTRE + k]) - X[k] for k in ti.static(range(3))]
            old = [spread(C[task, level, k]) for k in ti.static(range(terms.coefficients))]
            whole = [spread(k) for k in ti.static(range(terms.whole))]
            total = [spread(0.0) for _ in ti.static(rows)]  # ψ, or minus its gradient
            add_shifted(total, old, back, whole, rows)
            softening2 = spread(q[0])
            for n in range(first, last):
                s = lists[task, n]
                for j in range(s_begin[s], s_end[s]):
                    dx, dy, dz = X[0] - spread(S[0, j]), X[1] - spread(S[1, j]), X[2] - spread(S[2, j])
                    w = weight(spread(S[3, j]), dx * dx + dy * dy + dz * dz + softening2)
                    if ti.static(valued):
                        total[0] += w
                    else:
                        total[0] += w * dx
                        total[1] += w * dy
                        total[2] += w * dz
            for k in ti.static(range(len(rows))):
                for lane in ti.static(range(LANES)):
                    if i + lane < end[a]:
                        out[k, places[i + lane]] = total[k][lane] if ti.static(valued) else -total[k][lane]

    @ti.kernel
    def walk(
        roots: INTS, begin: INTS, end: INTS, links: TABLE, s_begin: INTS, s_end: INTS, s_links: TABLE, A: DOUBLE, B: DOUBLE,
        M: DOUBLE, N: DOUBLE, P: matrix, S: matrix, lists: TABLE, waiting: TABLE, far: TABLE, levels: CUBE, C: DOUBLES,
        q: NUMBERS, same: ti.i32, places: INTS, out: matrix, full: INTS,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for task in range(roots.shape[0]):
            for k in range(C.shape[2]):
                C[task, 0, k] = 0.0
            lists[task, 0] = 0
            levels[task, 0, CELL] = 0
            level, first, last = 0, 0, 1  # the open sources of the cell at hand are lists[task, first:last]
            while level >= 0:
                a = levels[task, level, CELL]
                kept, distant = _sort_open(
                    task, a, first, last, links, s_links, A, B, lists, waiting, far, q, same, full
                )
                if full[task] == 1:
                    level = -1
                else:
                    if distant > 0:
                        act_from_afar(task, level, a, distant, far, M, N, C, q)
                    if links[a, 1] == 0:
                        act_near_by(
                            task, level, a, last, kept, begin, end, s_begin, s_end, M, P, S, lists, C, q, places, out
                        )
                    levels[task, level, FIRST_OPEN], levels[task, level, LAST_OPEN] = last, kept
                    levels[task, level, NEXT_CHILD] = 0
                    level = _next_cell(task, level, roots[task], begin, end, links, levels)
                if level >= 0:
                    c, b = levels[task, level - 1, CELL], levels[task, level, CELL]
                    first, last = levels[task, level - 1, FIRST_OPEN], levels[task, level - 1, LAST_OPEN]
                    old = [C[task, level - 1, n] for n in ti.static(range(terms.coefficients))]
                    new = [ti.f64(0.0) for _ in ti.static(needed)]
                    back = [M[c, CENTRE + i] - M[b, CENTRE + i] for i in ti.static(range(3))]
                    add_shifted(new, old, back, [ti.cast(k, ti.f64) for k in ti.static(range(terms.whole))], needed)
                    for n in ti.static(range(len(needed))):
                        C[task, level, needed[n]] = new[n]

    return runtime.kernel(walk, precision, vectors=True)
