"""Expansions of the inverse square law: moments of cells of sources, and local expansions about the centres of cells of targets.

ψ(x) = sum_a c_a g(x - x_a), g(R) = 1 / sqrt(R^2 + softening^2), to order 3 in d = x - z_B and s = x_a - z_A: the moments of the
sources up to the quadrupole, and a local expansion of 20 coefficients, its value, gradient, and second and third derivatives. Two
cells that act on each other keep all terms up to the same order, so that their forces cancel to round-off.

A function of this file works on numbers or on whole vectors, whose lanes are cells or particles. Coefficients are in lists,
because Taichi keeps only vectors of 2, 4, 8 or 16 numbers whole.

The one-letter names in kernels are in docs/glossary.md. Source: Dehnen (2002), J. Comput. Phys. 179, 27.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti

__all__ = [
    "AMOUNT", "CENTRE", "COEFFICIENTS", "GRADIENT", "MOMENTS", "RADIUS", "VALUE", "add_far_field", "add_shifted",
    "moments_kernel",
]  # fmt: skip

# columns of the moments M of a cell
CENTRE, RADIUS, AMOUNT, DIPOLE, QUADRUPOLE, MOMENTS = 0, 3, 4, 5, 8, 14

# places in a local expansion, with the derivatives in the orders of _SECOND and _THIRD
VALUE, GRADIENT, _D2, _D3, COEFFICIENTS = 0, 1, 4, 10, 20

_TASK = 64  # cells
_SECOND = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_THIRD = ((0, 0, 0), (1, 1, 1), (2, 2, 2), (0, 0, 1), (0, 0, 2), (1, 1, 0), (1, 1, 2), (2, 2, 0), (2, 2, 1), (0, 1, 2))
_TWO = [
    [_D2 + next(n for n, two in enumerate(_SECOND) if sorted(two) == sorted((i, j))) for j in range(3)]
    for i in range(3)
]
_THREE = [
    [
        [_D3 + next(n for n, three in enumerate(_THIRD) if sorted(three) == sorted((i, j, k))) for k in range(3)]
        for j in range(3)
    ]
    for i in range(3)
]


@cache
def moments_kernel(precision: str):
    """The kernel that writes the moments (cells, MOMENTS) of the particles begin to end - 1 of each cell.

    P : (4, n), positions, m, and amounts
    A cell's centre is that of the magnitudes of its amounts, and its radius the distance of the farthest particle from there.
    """
    ints, double = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.f64, 2)

    @ti.kernel
    def gather(P: ti.types.ndarray(runtime.DTYPES[precision], 2), begin: ints, end: ints, M: double):
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
                radius2, total = ti.f64(0.0), ti.f64(0.0)
                first, second = ti.Vector([0.0] * 3, ti.f64), ti.Vector([0.0] * 6, ti.f64)
                for i in range(begin[c], end[c]):
                    d = ti.cast(ti.Vector([P[0, i], P[1, i], P[2, i]]), ti.f64) - z
                    w = ti.cast(P[3, i], ti.f64)
                    radius2 = ti.max(radius2, d.dot(d))
                    total += w
                    first += w * d
                    for k, pair in ti.static(enumerate(_SECOND)):
                        second[k] += w * d[pair[0]] * d[pair[1]]
                for k in ti.static(range(3)):
                    M[c, CENTRE + k] = z[k]
                    M[c, DIPOLE + k] = first[k]
                M[c, RADIUS], M[c, AMOUNT] = ti.sqrt(radius2), total
                for k in ti.static(range(6)):
                    M[c, QUADRUPOLE + k] = second[k]

    return runtime.kernel(gather, precision)


@ti.func
def add_far_field(total: ti.template(), R: ti.template(), m: ti.template(), e2, one):
    """Add to the 20 coefficients `total` the field of sources whose centre the expansion's centre is at R from.

    R : three numbers, m
    m : ten numbers, amount, dipole and quadrupole
    e2 : softening^2, m^2
    one : 1, as a number or a vector like the others
    """
    u = one / (R[0] * R[0] + R[1] * R[1] + R[2] * R[2] + e2)
    half, three = one / (one + one), one + one + one
    # the derivatives of g: g0, -g1, g2, -g3 (Taichi 1.7.4 cannot negate a whole vector, nor subtract by -=)
    g0 = ti.sqrt(u)
    g1 = g0 * u
    g2 = three * g1 * u
    g3 = (three + one + one) * g2 * u
    q = [
        m[4] * R[0] + m[7] * R[1] + m[8] * R[2],
        m[7] * R[0] + m[5] * R[1] + m[9] * R[2],
        m[8] * R[0] + m[9] * R[1] + m[6] * R[2],
    ]  # quadrupole times R
    trace, along = m[4] + m[5] + m[6], q[0] * R[0] + q[1] * R[1] + q[2] * R[2]
    dipole = m[1] * R[0] + m[2] * R[1] + m[3] * R[2]
    inwards, outwards = g1 * m[0] + g2 * dipole, g2 * m[0] + g3 * dipole
    towards = half * (g2 * trace - g3 * along) - inwards
    total[VALUE] += g0 * m[0] + g1 * dipole + half * (g2 * along - g1 * trace)
    for i in ti.static(range(3)):
        total[GRADIENT + i] += towards * R[i] + g1 * m[1 + i] + g2 * q[i]
    for k in ti.static(range(6)):
        i, j = ti.static(_SECOND[k])
        if ti.static(i == j):
            total[_D2 + k] += (outwards * R[i] - (g2 + g2) * m[1 + i]) * R[i] - inwards
        else:
            total[_D2 + k] += outwards * R[i] * R[j] - g2 * (m[1 + i] * R[j] + m[1 + j] * R[i])
    second, third = g2 * m[0], g3 * m[0]
    for k in ti.static(range(10)):
        i, j, l = ti.static(_THIRD[k])
        if ti.static(i == l):
            total[_D3 + k] += (three * second - third * R[i] * R[i]) * R[i]
        elif ti.static(i == j):
            total[_D3 + k] += (second - third * R[i] * R[i]) * R[l]
        else:
            total[_D3 + k] = total[_D3 + k] - third * R[i] * R[j] * R[l]


@ti.func
def add_shifted(new: ti.template(), old: ti.template(), d: ti.template(), one):
    """Add to the coefficients `new` those of the local expansion `old` about the point at d from its centre."""
    half, sixth = one / (one + one), one / (one + one + one + one + one + one)
    new[VALUE] += old[VALUE]
    for i in ti.static(range(3)):
        new[GRADIENT + i] += old[GRADIENT + i]
        new[VALUE] += old[GRADIENT + i] * d[i]
        for j in ti.static(range(3)):
            new[VALUE] += half * old[_TWO[i][j]] * d[i] * d[j]
            new[GRADIENT + i] += old[_TWO[i][j]] * d[j]
            for l in ti.static(range(3)):
                new[VALUE] += sixth * old[_THREE[i][j][l]] * d[i] * d[j] * d[l]
                new[GRADIENT + i] += half * old[_THREE[i][j][l]] * d[j] * d[l]
    for k in ti.static(range(6)):
        new[_D2 + k] += old[_D2 + k]
        for l in ti.static(range(3)):
            new[_D2 + k] += old[_THREE[_SECOND[k][0]][_SECOND[k][1]][l]] * d[l]
    for k in ti.static(range(10)):
        new[_D3 + k] += old[_D3 + k]
