"""Expansions of the inverse square law: moments of cells of sources, and local expansions about the centres of cells of targets.

ψ(x) = sum_a c_a g(x - x_a), g(R) = 1 / sqrt(R^2 + softening^2). With R from the centre of the sources to that of targets,
d = x - z_B, s = x_a - z_A, and multi-indices n and k (n! is the product of three factorials, abs(n) the sum of the three):

m_k = sum_a c_a s^k / k!, the moments; F_n = (-1)^abs(n) times the n-th derivative of g at R
K_n = sum_k m_k F_(n+k) over abs(n) + abs(k) <= order, the coefficients of the local expansion
ψ(x) = sum_n K_n (-d)^n / n!

Two cells that act on each other keep all terms up to the same order, so that their forces cancel to round-off. The derivatives
come from h_m = (2m - 1)!! / (R^2 + softening^2)^(m + 1/2), which is F_0 of g for m = 0, by

F(m)_n = R_i F(m+1)_(n-e_i) - (n_i - 1) F(m+1)_(n-2e_i), F(m)_0 = h_m, F_n = F(0)_n

A function of this file works on numbers or on whole vectors, whose lanes are cells or particles. Coefficients are in lists,
because Taichi keeps only vectors of 2, 4, 8 or 16 numbers whole.

The one-letter names in kernels are in docs/glossary.md. Source: Dehnen (2002), J. Comput. Phys. 179, 27; McMurchie & Davidson
(1978), J. Comput. Phys. 26, 218, for the derivatives.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti

__all__ = [
    "CENTRE",
    "GRADIENT",
    "MOMENTS",
    "RADIUS",
    "VALUE",
    "Expansion",
    "expansion",
    "gather_kernel",
    "raise_kernel",
]

# columns of what is known of a cell: its centre, its radius, and its moments from MOMENTS on
CENTRE, RADIUS, MOMENTS = 0, 3, 4
VALUE, GRADIENT = 0, 1  # places in a local expansion: of the value, and of the first of three derivatives

_TASK = 64  # cells

Index = tuple[int, int, int]


def _multi_indices(order: int) -> list[Index]:
    """All multi-indices up to an order, by order: first (0, 0, 0), then (1, 0, 0), (0, 1, 0), (0, 0, 1)."""
    everything = [(i, j, k) for i in range(order + 1) for j in range(order + 1 - i) for k in range(order + 1 - i - j)]
    return sorted(everything, key=lambda n: (sum(n), [-x for x in n]))


def _lower(n: Index, axis: int, by: int = 1) -> Index:
    i, j, k = (x - by * (a == axis) for a, x in enumerate(n))
    return i, j, k


def _shortest_axis(n: Index) -> int:
    """The axis along which a multi-index is smallest, but not 0."""
    return min((x, axis) for axis, x in enumerate(n) if x)[1]


class Expansion:
    """Expansions of one order: their tables, and the functions of kernels.

    coefficients : the number of coefficients of a local expansion
    moments : the number of moments of a cell, up to order - 1: higher ones act on the value alone
    columns : the columns of a cell
    whole : how many whole numbers, from 0 on, the functions need as numbers or vectors of their kind
    moment_powers : the steps by which `monomials` makes those of the moments
    raised : for each moment of a cell, the pairs (moment of a child, monomial) whose products it is the sum of
    """

    def __init__(self, order: int):
        indices = _multi_indices(order)
        place = {n: at for at, n in enumerate(indices)}
        self.coefficients, self.moments = len(indices), len(_multi_indices(order - 1))
        self.columns, self.whole = MOMENTS + self.moments, 2 * order
        some = indices[: self.moments]
        every = [(m, n) for m in range(order, -1, -1) for n in indices if m + sum(n) <= order]
        at = {entry: k for k, entry in enumerate(every)}
        bases = [at[m, (0, 0, 0)] for m in range(order + 1)]
        steps = []  # place of F(m)_n, axis, places of the two that it comes from, the factor of the second
        for m, n in every:
            if n != (0, 0, 0):
                axis = _shortest_axis(n)
                one = _lower(n, axis)
                factor = one[axis]
                second = at[m + 1, _lower(n, axis, 2)] if factor else 0
                steps.append((at[m, n], axis, at[m + 1, one], second, factor))
        derivatives = [at[0, n] for n in indices]
        powers = [
            (place[n], place[_lower(n, _shortest_axis(n))], _shortest_axis(n), n[_shortest_axis(n)])
            for n in indices[1:]
        ]  # x^n / n! = x^(n - e) / (n - e)! x_axis / n_axis

        def total(n: Index, k: Index) -> Index:
            return n[0] + k[0], n[1] + k[1], n[2] + k[2]

        products = [
            (a, b, derivatives[place[total(n, k)]])
            for a, n in enumerate(indices)
            for b, k in enumerate(some)
            if sum(n) + sum(k) <= order
        ]
        shifts = [[(place[total(n, k)], b) for b, k in enumerate(indices) if sum(n) + sum(k) <= order] for n in indices]
        raised = [
            [(b, place[k[0] - j[0], k[1] - j[1], k[2] - j[2]]) for b, j in enumerate(some) if all(x <= y for x, y in zip(j, k))]
            for k in some
        ]  # fmt: skip
        moment_powers = [power for power in powers if power[0] < self.moments]

        @ti.func
        def monomials(x: ti.template(), whole: ti.template(), wanted: ti.template()):
            """x^n / n! for the multi-indices in order."""
            P = [whole[1] for _ in ti.static(range(len(wanted) + 1))]
            for to, of, axis, divisor in ti.static(wanted):
                if ti.static(divisor == 1):
                    P[to] = P[of] * x[axis]
                else:
                    P[to] = P[of] * x[axis] / whole[divisor]
            return P

        @ti.func
        def add_far_field(
            total: ti.template(), R: ti.template(), m: ti.template(), e2, whole: ti.template(), first: ti.template()
        ):
            """Add to the coefficients `total`, from place `first` on, the field of sources.

            R : three numbers, m, from the centre of the sources to that of the expansion
            m : the moments of the sources
            e2 : softening^2, m^2
            whole : the numbers 0, 1, 2, ... as numbers or vectors like the others
            """
            F = [whole[0] for _ in ti.static(range(len(every)))]
            u = whole[1] / (R[0] * R[0] + R[1] * R[1] + R[2] * R[2] + e2)
            F[bases[0]] = ti.sqrt(u)
            for k in ti.static(range(1, order + 1)):
                F[bases[k]] = whole[2 * k - 1] * F[bases[k - 1]] * u
            for to, axis, one, second, factor in ti.static(steps):
                if ti.static(factor == 0):
                    F[to] = R[axis] * F[one]
                elif ti.static(factor == 1):
                    F[to] = R[axis] * F[one] - F[second]
                else:
                    F[to] = R[axis] * F[one] - whole[factor] * F[second]
            for a, b, of in ti.static(products):
                if ti.static(a >= first):
                    total[a] += m[b] * F[of]

        @ti.func
        def add_shifted(
            new: ti.template(), old: ti.template(), back: ti.template(), whole: ti.template(), rows: ti.template()
        ):
            """Add to `new` the coefficients in places `rows` of the local expansion `old` about another point.

            back : from that point to the centre of `old`, m
            """
            P = monomials(back, whole, powers)
            for to in ti.static(range(len(rows))):
                for of, by in ti.static(shifts[rows[to]]):
                    new[to] += old[of] * P[by]

        self.add_far_field, self.add_shifted, self.monomials = add_far_field, add_shifted, monomials
        self.raised, self.moment_powers = raised, moment_powers


@cache
def expansion(order: int) -> Expansion:
    """The expansions of an order, from 1 on."""
    return Expansion(order)


@cache
def gather_kernel(order: int, precision: str):
    """The kernel that writes the centres and radii of all cells, and the moments of leaves, into M (cells, columns).

    P : (4, n), positions, m, and amounts
    begin, end : the particles of each cell are begin to end - 1
    links : (cells, 2), the second number is 0 for a leaf
    A cell's centre is that of the magnitudes of its amounts, and its radius the distance of the farthest particle from there.
    """
    ints, double = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.f64, 2)
    terms = expansion(order)
    number, most, monomials, wanted = terms.moments, terms.whole, terms.monomials, terms.moment_powers

    @ti.kernel
    def gather(
        P: ti.types.ndarray(runtime.DTYPES[precision], 2), begin: ints, end: ints,
        links: ti.types.ndarray(ti.i32, 2), M: double,
    ):  # fmt: skip
        cells = begin.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((cells + _TASK - 1) // _TASK):
            for c in range(b * _TASK, ti.min((b + 1) * _TASK, cells)):
                weight, centre = ti.f64(0.0), ti.Vector([0.0, 0.0, 0.0], ti.f64)
                unweighted = ti.Vector([0.0, 0.0, 0.0], ti.f64)
                for i in range(begin[c], end[c]):
                    x = ti.cast(ti.Vector([P[0, i], P[1, i], P[2, i]]), ti.f64)
                    w = ti.abs(ti.cast(P[3, i], ti.f64))
                    weight += w
                    centre += w * x
                    unweighted += x
                z = unweighted / ti.cast(end[c] - begin[c], ti.f64)
                if weight > 0.0:
                    z = centre / weight
                radius2 = ti.f64(0.0)
                for i in range(begin[c], end[c]):
                    d = ti.cast(ti.Vector([P[0, i], P[1, i], P[2, i]]), ti.f64) - z
                    radius2 = ti.max(radius2, d.dot(d))
                for k in ti.static(range(3)):
                    M[c, CENTRE + k] = z[k]
                M[c, RADIUS] = ti.sqrt(radius2)
                if links[c, 1] == 0:
                    m = [ti.f64(0.0) for _ in ti.static(range(number))]
                    for i in range(begin[c], end[c]):
                        d = ti.cast(ti.Vector([P[0, i], P[1, i], P[2, i]]), ti.f64) - z
                        whole = [ti.cast(k, ti.f64) for k in ti.static(range(most))]
                        powers, w = monomials(d, whole, wanted), ti.cast(P[3, i], ti.f64)
                        for k in ti.static(range(number)):
                            m[k] += w * powers[k]
                    for k in ti.static(range(number)):
                        M[c, MOMENTS + k] = m[k]

    return runtime.kernel(gather, precision)


@cache
def raise_kernel(order: int):
    """The kernel that adds up the moments of the children of cells first to last - 1, in M (cells, columns)."""
    terms = expansion(order)
    number, most, monomials, wanted = terms.moments, terms.whole, terms.monomials, terms.moment_powers
    raised = terms.raised

    @ti.kernel
    def add_up(links: ti.types.ndarray(ti.i32, 2), M: ti.types.ndarray(ti.f64, 2), first: ti.i32, last: ti.i32):
        ti.loop_config(block_dim=1)
        for b in range((last - first + _TASK - 1) // _TASK):
            for c in range(first + b * _TASK, ti.min(first + (b + 1) * _TASK, last)):
                if links[c, 1] > 0:
                    m = [ti.f64(0.0) for _ in ti.static(range(number))]
                    for child in range(links[c, 0], links[c, 0] + links[c, 1]):
                        d = [M[child, CENTRE + i] - M[c, CENTRE + i] for i in ti.static(range(3))]
                        whole = [ti.cast(k, ti.f64) for k in ti.static(range(most))]
                        powers = monomials(d, whole, wanted)
                        old = [M[child, MOMENTS + k] for k in ti.static(range(number))]
                        for k in ti.static(range(number)):
                            for of, by in ti.static(raised[k]):
                                m[k] += old[of] * powers[by]
                    for k in ti.static(range(number)):
                        M[c, MOMENTS + k] = m[k]

    return runtime.kernel(add_up, "f64")
