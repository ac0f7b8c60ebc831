"""The kernels of the tree: moments of cells, the walk over pairs of cells, expansions, and the sums over near pairs.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache
from types import SimpleNamespace

from gen_art.backend import runtime
from gen_art.backend.runtime import ti

__all__ = ["COEFFICIENTS", "MOMENTS", "tree_kernels"]

# columns of the moments M or N of a cell
_CENTRE, _RADIUS, _AMOUNT, _DIPOLE, _QUADRUPOLE, MOMENTS = 0, 3, 4, 5, 8, 14

# columns of the local expansion C of a cell, with the derivatives in the orders of _SECOND and _THIRD
_VALUE, _GRADIENT, _D2, _D3, COEFFICIENTS = 0, 1, 4, 10, 20

_FAR, _NEAR, _OPEN_TARGET, _OPEN_SOURCE, _OPEN_BOTH = 1, 2, 3, 4, 5  # what the walk does with a pair of cells
_LANES = 16
_BLOCK = 64  # cells per task
_SECOND = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_THIRD = ((0, 0, 0), (1, 1, 1), (2, 2, 2), (0, 0, 1), (0, 0, 2), (1, 1, 0), (1, 1, 2), (2, 2, 0), (2, 2, 1), (0, 1, 2))


def _second(i: int, j: int) -> int:
    return _SECOND.index((min(i, j), max(i, j)))


def _third(i: int, j: int, k: int) -> int:
    return next(n for n, three in enumerate(_THIRD) if sorted(three) == sorted((i, j, k)))


_TWO = [[_second(i, j) for j in range(3)] for i in range(3)]
_THREE = [[[_third(i, j, k) for k in range(3)] for j in range(3)] for i in range(3)]


@cache
def tree_kernels(precision: str) -> SimpleNamespace:
    """gather, walk, far, down, near and, for values instead of gradients, value; arrays as in tree_sum.py."""
    real = runtime.DTYPES[precision]
    matrix, ints, table = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.i32, 2)
    double, exact = ti.types.ndarray(ti.f64, 2), ti.types.ndarray(ti.f64, 1)
    vector = ti.types.ndarray(real, 1)

    @ti.kernel
    def gather(P: matrix, begin: ints, end: ints, M: double):
        cells = begin.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((cells + _BLOCK - 1) // _BLOCK):
            for c in range(b * _BLOCK, ti.min((b + 1) * _BLOCK, cells)):
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
                    M[c, _CENTRE + k] = z[k]
                    M[c, _DIPOLE + k] = first[k]
                M[c, _RADIUS], M[c, _AMOUNT] = ti.sqrt(radius2), total
                for k in ti.static(range(6)):
                    M[c, _QUADRUPOLE + k] = second[k]

    @ti.kernel
    def walk(
        child: ints, children: ints, source_child: ints, source_children: ints, M: double, N: double, stack: table, count: table,
        far: ints, near: ints, same: ti.i32, fills: ti.i32, theta: exact,
    ):  # fmt: skip
        ti.loop_config(serialize=True)
        for _ in range(1):
            top = 1
            stack[0, 0], stack[1, 0] = 0, 0
            while top > 0:
                top -= 1
                a, b = stack[0, top], stack[1, top]
                kind = 0
                if same == 1 and a == b:
                    kind = _NEAR if children[a] == 0 else _OPEN_BOTH
                else:
                    r2 = ti.f64(0.0)
                    for k in ti.static(range(3)):
                        r2 += (M[a, _CENTRE + k] - N[b, _CENTRE + k]) ** 2
                    size = M[a, _RADIUS] + N[b, _RADIUS]
                    if size * size < theta[0] * theta[0] * r2:
                        kind = _FAR
                    elif children[a] == 0 and source_children[b] == 0:
                        kind = _NEAR
                    elif source_children[b] == 0 or (children[a] > 0 and M[a, _RADIUS] >= N[b, _RADIUS]):
                        kind = _OPEN_TARGET
                    else:
                        kind = _OPEN_SOURCE
                if kind <= _NEAR:
                    row = kind - _FAR
                    for side in range(1 + ti.cast(same == 1 and a != b, ti.i32)):
                        target, source = a, b
                        if side == 1:
                            target, source = b, a
                        at = count[row, target]
                        count[row, target] = at + 1
                        if fills == 1:
                            if kind == _FAR:
                                far[at] = source
                            else:
                                near[at] = source
                elif kind == _OPEN_TARGET:
                    for k in range(children[a]):
                        stack[0, top], stack[1, top] = child[a] + k, b
                        top += 1
                elif kind == _OPEN_SOURCE:
                    for k in range(source_children[b]):
                        stack[0, top], stack[1, top] = a, source_child[b] + k
                        top += 1
                else:
                    for k in range(children[a]):
                        for l in range(k, children[a]):
                            stack[0, top], stack[1, top] = child[a] + k, child[a] + l
                            top += 1

    @ti.kernel
    def expand(M: double, N: double, far: ints, first: ints, C: double, e2: exact):
        cells = M.shape[0]
        ti.loop_config(block_dim=1)
        for block in range((cells + _BLOCK - 1) // _BLOCK):
            for c in range(block * _BLOCK, ti.min((block + 1) * _BLOCK, cells)):
                total = ti.Vector([0.0] * COEFFICIENTS, ti.f64)
                for at in range(first[c], first[c + 1]):
                    b = far[at]
                    R = ti.Vector([M[c, 0] - N[b, 0], M[c, 1] - N[b, 1], M[c, 2] - N[b, 2]])
                    m0 = N[b, _AMOUNT]
                    m1 = ti.Vector([N[b, _DIPOLE + k] for k in ti.static(range(3))])
                    m2 = ti.Vector([N[b, _QUADRUPOLE + k] for k in ti.static(range(6))])
                    u = 1.0 / (R.dot(R) + e2[0])
                    g0 = ti.sqrt(u)
                    g1 = -g0 * u
                    g2 = -3.0 * g1 * u
                    g3 = -5.0 * g2 * u
                    q = ti.Vector([0.0, 0.0, 0.0], ti.f64)  # second moments times R
                    for i in ti.static(range(3)):
                        for j in ti.static(range(3)):
                            q[i] += m2[ti.static(_TWO[i][j])] * R[j]
                    trace, along, dipole = m2[0] + m2[1] + m2[2], q.dot(R), m1.dot(R)
                    total[_VALUE] += g0 * m0 - g1 * dipole + 0.5 * (g1 * trace + g2 * along)
                    for i in ti.static(range(3)):
                        total[_GRADIENT + i] += (
                            g1 * m0 * R[i] - g1 * m1[i] - g2 * dipole * R[i]
                            + 0.5 * (g2 * (trace * R[i] + 2.0 * q[i]) + g3 * along * R[i])
                        )  # fmt: skip
                    for k, ij in ti.static(enumerate(_SECOND)):
                        value = (g2 * m0 - g3 * dipole) * R[ij[0]] * R[ij[1]] - g2 * (
                            m1[ij[0]] * R[ij[1]] + m1[ij[1]] * R[ij[0]]
                        )
                        if ti.static(ij[0] == ij[1]):
                            value += g1 * m0 - g2 * dipole
                        total[_D2 + k] += value
                    for k, ijl in ti.static(enumerate(_THIRD)):
                        value = g3 * R[ijl[0]] * R[ijl[1]] * R[ijl[2]]
                        if ti.static(ijl[0] == ijl[1]):
                            value += g2 * R[ijl[2]]
                        if ti.static(ijl[0] == ijl[2]):
                            value += g2 * R[ijl[1]]
                        if ti.static(ijl[1] == ijl[2]):
                            value += g2 * R[ijl[0]]
                        total[_D3 + k] += m0 * value
                for k in range(COEFFICIENTS):
                    C[c, k] = total[k]

    @ti.func
    def shifted(C: ti.template(), c, d):
        """The local expansion of cell c about a point at d from its centre."""
        old = ti.Vector([0.0] * COEFFICIENTS, ti.f64)
        for k in range(COEFFICIENTS):
            old[k] = C[c, k]
        new = old
        for i in ti.static(range(3)):
            new[_VALUE] += old[_GRADIENT + i] * d[i]
            for j in ti.static(range(3)):
                new[_VALUE] += 0.5 * old[_D2 + ti.static(_TWO[i][j])] * d[i] * d[j]
                new[_GRADIENT + i] += old[_D2 + ti.static(_TWO[i][j])] * d[j]
                for l in ti.static(range(3)):
                    three = old[_D3 + ti.static(_THREE[i][j][l])]
                    new[_VALUE] += three * d[i] * d[j] * d[l] / 6.0
                    new[_GRADIENT + i] += 0.5 * three * d[j] * d[l]
        for k, pair in ti.static(enumerate(_SECOND)):
            for l in ti.static(range(3)):
                new[_D2 + k] += old[_D3 + ti.static(_THREE[pair[0]][pair[1]][l])] * d[l]
        return new

    @ti.kernel
    def down(M: double, child: ints, children: ints, begin: ti.i32, end: ti.i32, C: double):
        ti.loop_config(block_dim=1)
        for block in range((end - begin + _BLOCK - 1) // _BLOCK):
            for c in range(begin + block * _BLOCK, ti.min(begin + (block + 1) * _BLOCK, end)):
                for k in range(children[c]):
                    cell = child[c] + k
                    d = ti.Vector([M[cell, 0] - M[c, 0], M[cell, 1] - M[c, 1], M[cell, 2] - M[c, 2]])
                    parent = shifted(C, c, d)
                    for m in range(COEFFICIENTS):
                        C[cell, m] = C[cell, m] + parent[m]

    def make_close(valued: bool):
        @ti.kernel
        def close(
            P: matrix, S: matrix, M: double, C: double, leaves: ints, begin: ints, end: ints, first: ints, last: ints,
            near: ints, at: ints, e2: vector, same: ti.i32, out: matrix,
        ):  # fmt: skip
            ti.loop_config(block_dim=1)
            for leaf in range(leaves.shape[0]):
                c = leaves[leaf]
                for i in range(begin[c], end[c]):
                    d = ti.cast(ti.Vector([P[0, i], P[1, i], P[2, i]]), ti.f64) - ti.Vector([M[c, 0], M[c, 1], M[c, 2]])
                    here = shifted(C, c, d)
                    for k in ti.static(range(3)):
                        out[k, i] = ti.cast(here[_GRADIENT + k], real)
                    out[3, i] = ti.cast(here[_VALUE], real)
                for tile in range((end[c] - begin[c] + _LANES - 1) // _LANES):
                    i = begin[c] + tile * _LANES
                    X, Y, Z = ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES)
                    A, B, D = ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES), ti.Vector([0.0] * _LANES)
                    E = ti.Vector([0.0] * _LANES)
                    for k in range(_LANES):
                        X[k], Y[k], Z[k] = P[0, i + k], P[1, i + k], P[2, i + k]
                    for n in range(at[c], at[c + 1]):
                        s = near[n]
                        for j in range(first[s], last[s]):
                            xj, yj, zj, mj = S[0, j], S[1, j], S[2, j], S[3, j]
                            self_lane = ti.select(same == 1, j - i, -1)  # the lane that is the source itself
                            for k in range(_LANES):
                                dx, dy, dz = xj - X[k], yj - Y[k], zj - Z[k]
                                r2 = dx * dx + dy * dy + dz * dz + e2[0]
                                g = ti.select(r2 > 0.0, 1.0 / ti.sqrt(r2), 0.0)
                                g = ti.select(k == self_lane, 0.0, g)
                                if ti.static(valued):
                                    E[k] += mj * g
                                else:
                                    w = mj * g * g * g
                                    A[k] += w * dx
                                    B[k] += w * dy
                                    D[k] += w * dz
                    for k in range(ti.min(_LANES, end[c] - i)):
                        out[0, i + k] += A[k]
                        out[1, i + k] += B[k]
                        out[2, i + k] += D[k]
                        out[3, i + k] += E[k]

        return close

    made = {"gather": gather, "walk": walk, "far": expand, "down": down}
    made |= {"near": make_close(False), "value": make_close(True)}
    return SimpleNamespace(**{name: runtime.kernel(kernel, precision) for name, kernel in made.items()})
