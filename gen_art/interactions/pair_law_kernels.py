"""The kernels of a user's law of pairs: each target sums its sources in a fixed order, that of their slots or of the grid.

The one-letter names in kernels are in docs/glossary.md.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters, particle, traced
from gen_art.backend.runtime import impl, make_matrix, ti
from gen_art.interactions.neighbour_grid import nearest_image, periodic_cell, place_in_grid, run_beyond, run_of
from gen_art.interactions.sphere_contact_kernels import cell
from gen_art.particles.rows import CHARGE, FIRST_ATTRIBUTE, LIFETIME, MASS, RADIUS

if TYPE_CHECKING:
    from gen_art.interactions.pair_law import PairLaw

__all__ = ["BLOCK", "NO_GRID", "GridArrays", "LawKernels", "law_kernels", "probe_kernel"]

BLOCK = 64  # targets per task
_CHUNK = 256  # sources in a partial sum: keeps float32 sums over many thousands accurate
NO_GRID = np.zeros(1, np.int32)

_CUTOFF, _SIZE, _FRAME = range(3)  # the numbers of GridArrays


class GridArrays(NamedTuple):
    """A neighbour grid as kernels take it; NO_GRID where all pairs are summed.

    numbers : (14,), cutoff and width of a cell, m, and the frame of a periodic box (12 zeros in open space)
    """

    slots: np.ndarray
    first: np.ndarray
    low: np.ndarray
    shape: np.ndarray
    numbers: np.ndarray


class LawKernels(NamedTuple):
    """The kernels of one law: the accelerations of all targets, and the potential energy of each block of them."""

    accelerate: Callable[..., None]
    potential: Callable[..., None]


_made: dict[tuple, Any] = {}


def _once(key: tuple, make: Callable[[], Any]) -> Any:
    if key not in _made:
        _made[key] = make()
    return _made[key]


def _fixed(law: "PairLaw") -> tuple:
    """What a law's kernels are compiled for: its class and its choices and flags."""
    values = tuple((k, law.values[k]) for k, p in law.parameters.items() if p.kind in ("bool", "choice", "text"))
    return type(law), values


@traced
def _view(S, K, i, x, v, age, attributes):
    """The particle in slot i; without an age, one for a potential, which has no time."""
    row = lambda r: impl.subscript(None, S, r, i)  # noqa: E731
    known = {name: row(FIRST_ATTRIBUTE + k) for k, name in enumerate(attributes)}
    if age is not None:
        known["age"] = age
    return particle(
        position=x, velocity=v, mass=row(MASS), charge=row(CHARGE), radius=row(RADIUS), lifetime=row(LIFETIME),
        key=make_matrix([impl.subscript(None, K, 0, i), impl.subscript(None, K, 1, i)]), **known,
    )  # fmt: skip


def law_kernels(law: "PairLaw", attributes: tuple, source_attributes: tuple, precision: str) -> LawKernels:
    """The kernels of a law between particles with these declared attributes."""
    by_grid, periodic = law.reach is not None, law.box is not None
    key = (*_fixed(law), attributes, source_attributes, precision, by_grid, periodic)
    return _once(key, lambda: _make(law, attributes, source_attributes, precision, by_grid, periodic))


def probe_kernel(law: "PairLaw", attributes: tuple) -> Callable[..., None]:
    """The kernel (A, KA, B, KB, ages, numbers, out) that evaluates a law in float64 for each column k of A and B, two particles.

    out : (7, n), the force on A by B, the force on B by A, N, and the potential, J (0 without one)
    """
    return _once((*_fixed(law), attributes, "probe"), lambda: _make_probe(law, attributes))


@ti.func
def _row_of_cells(first: ti.template(), shape, c, row, q: ti.template(), periodic: ti.template()):
    """Where the cells of one of the rows around the cell c begin and end; rows from 9 on lie beyond a periodic side."""
    r = row % 9
    y, z = c[1] + r % 3 - 1, c[2] + r // 3 - 1
    begin, end = run_of(first, shape, c[0], y, z, 1, 1)
    if ti.static(periodic):
        begin_beyond, end_beyond = run_beyond(first, shape, c[0], y, z, 1, 1, q, _FRAME)
        begin, end = ti.select(row < 9, begin, begin_beyond), ti.select(row < 9, end, end_beyond)
    return begin, end


@ti.func
def _at(S: ti.template(), row: ti.template(), i):
    return ti.Vector([S[row, i], S[row + 1, i], S[row + 2, i]])


def _make(law, attributes, source_attributes, precision, by_grid, periodic) -> LawKernels:
    real = runtime.DTYPES[precision]
    matrix, ints, vector = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1), ti.types.ndarray(real, 1)
    doubles, keys = ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.u32, 2)
    rows = 18 if periodic else 9

    @ti.func
    def from_to(x, y, g: ti.template()):
        """The vector from y to x, in a periodic box that of nearest images."""
        d = x - y
        if ti.static(periodic):
            d = nearest_image(d, g, _FRAME)
        return d

    @ti.func
    def cell_at(x, low: ti.template(), extent, g: ti.template()):
        c = cell(x, low, extent, g[_SIZE])
        if ti.static(periodic):
            c = periodic_cell(place_in_grid(x, g, _FRAME), low, extent, g, _FRAME)
        return c

    @ti.kernel
    def accelerate(
        X: matrix, S: matrix, birth: doubles, K: keys, n: ti.i32, Y: matrix, T: matrix, source_birth: doubles,
        source_K: keys, m: ti.i32, same: ti.i32, time: ti.f64, Q: vector, slots: ints, first: ints, low: ints, shape: ints,
        g: vector, out: matrix,
    ):  # fmt: skip
        """The accelerations of n targets.

        X, S, birth, K: their positions and velocities, state, births and keys; Y, T, source_birth, source_K: of the m sources
        same: 1 where targets and sources are the same particles
        Q: the law's parameters
        slots, first, low, shape, g: the GridArrays
        """
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, v = _at(X, 0, i), _at(X, 3, i)
                t = ti.cast(time, real)
                one = _view(S, K, i, x, v, ti.cast(time - birth[i], real), attributes)
                q = parameters(Q, law, 0)
                F = x * 0.0
                if ti.static(by_grid):
                    extent = ti.Vector([shape[0], shape[1], shape[2]])
                    c = cell_at(x, low, extent, g)
                    for row in range(rows):
                        begin, end = _row_of_cells(first, extent, c, row, g, periodic)
                        for k in range(begin, end):
                            j = slots[k]
                            r = from_to(x, _at(Y, 0, j), g)
                            if r.dot(r) < g[_CUTOFF] * g[_CUTOFF] and not (same == 1 and i == j):
                                w = _at(Y, 3, j)
                                other = _view(
                                    T, source_K, j, x - r, w, ti.cast(time - source_birth[j], real), source_attributes
                                )
                                F += law.pair(r, v - w, one, other, t, q)
                else:
                    for chunk in range((m + _CHUNK - 1) // _CHUNK):
                        G = x * 0.0
                        for j in range(chunk * _CHUNK, ti.min((chunk + 1) * _CHUNK, m)):
                            if not (same == 1 and i == j):
                                r, w = from_to(x, _at(Y, 0, j), g), _at(Y, 3, j)
                                other = _view(
                                    T, source_K, j, x - r, w, ti.cast(time - source_birth[j], real), source_attributes
                                )
                                G += law.pair(r, v - w, one, other, t, q)
                        F += G
                for k in ti.static(range(3)):
                    out[k, i] = F[k] / S[MASS, i]

    @ti.kernel
    def potential(
        S: matrix,
        K: keys,
        n: ti.i32,
        Q: vector,
        slots: ints,
        first: ints,
        low: ints,
        shape: ints,
        g: vector,
        out: doubles,
    ):
        """The energy of the pairs of n particles, each pair once: the sum of each block of first particles."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            total = ti.cast(0.0, ti.f64)
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, v = _at(S, 0, i), _at(S, 3, i)
                one = _view(S, K, i, x, v, None, attributes)
                q = parameters(Q, law, 0)
                if ti.static(by_grid):
                    extent = ti.Vector([shape[0], shape[1], shape[2]])
                    c = cell_at(x, low, extent, g)
                    for row in range(rows):
                        begin, end = _row_of_cells(first, extent, c, row, g, periodic)
                        for k in range(begin, end):
                            j = slots[k]
                            r = from_to(x, _at(S, 0, j), g)
                            if r.dot(r) < g[_CUTOFF] * g[_CUTOFF] and i < j:
                                other = _view(S, K, j, x - r, _at(S, 3, j), None, attributes)
                                total += ti.cast(law.potential(r, one, other, q), ti.f64)
                else:
                    for j in range(i + 1, n):
                        r = from_to(x, _at(S, 0, j), g)
                        other = _view(S, K, j, x - r, _at(S, 3, j), None, attributes)
                        total += ti.cast(law.potential(r, one, other, q), ti.f64)
            out[b] = total

    return LawKernels(runtime.kernel(accelerate, precision), runtime.kernel(potential, precision))


def _make_probe(law, attributes) -> Callable[..., None]:
    matrix, vector, keys = ti.types.ndarray(ti.f64, 2), ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.u32, 2)
    has_potential = callable(getattr(law, "potential", None))

    @ti.kernel
    def probe(A: matrix, KA: keys, B: matrix, KB: keys, ages: matrix, Q: vector, out: matrix):
        ti.loop_config(serialize=True)
        for k in range(out.shape[1]):
            x, v, y, w = _at(A, 0, k), _at(A, 3, k), _at(B, 0, k), _at(B, 3, k)
            a = _view(A, KA, k, x, v, ages[0, k], attributes)
            b = _view(B, KB, k, y, w, ages[1, k], attributes)
            q = parameters(Q, law, 0)
            t = ti.cast(0.0, ti.f64)
            F, G = law.pair(x - y, v - w, a, b, t, q), law.pair(y - x, w - v, b, a, t, q)
            for c in ti.static(range(3)):
                out[c, k] = F[c]
                out[3 + c, k] = G[c]
            if ti.static(has_potential):
                out[6, k] = law.potential(x - y, a, b, q)

    return runtime.kernel(probe, "f64")
