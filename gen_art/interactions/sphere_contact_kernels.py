"""The kernels of contacts: each sphere sums the forces of those it touches, in the order of the grid."""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.neighbour_grid import ROWS, cell_of, run_of

__all__ = ["BLOCK", "deepest", "pushes"]

BLOCK = 512  # spheres a task
_LISTED = 32  # touching spheres at a time


@ti.func
def three(P: ti.template(), k):
    return ti.Vector([P[k], P[k + 1], P[k + 2]])


@ti.func
def cell(x, low: ti.template(), shape, size):
    """The grid's cell that holds x, y and z wrapped round."""
    return ti.Vector([
        cell_of(x[0], size) - low[0], (cell_of(x[1], size) - low[1]) % shape[1], (cell_of(x[2], size) - low[2]) % shape[2]
    ])  # fmt: skip


@ti.func
def gap(at, side):
    """The square of how far a place in a cell (0 to 1) is from the cell before it (side -1), its own (0) or the next (1)."""
    far = ti.select(side < 0, at, ti.select(side > 0, 1.0 - at, 0.0 * at))
    return far * far


@ti.func
def spin_of(S: ti.template(), row, i):
    return ti.Vector([S[row, i], S[row + 1, i], S[row + 2, i]])


@cache
def pushes(precision: str, spins: bool):
    """(accelerate, hand_back, potential) of spheres that turn, or do not."""
    real = runtime.DTYPES[precision]
    matrix, whole, vector = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1), ti.types.ndarray(real, 1)

    @ti.kernel
    def accelerate(
        P: vector, slots: whole, first: whole, low: whole, extent: whole, q: vector, size: real, S: matrix, spin: ti.i32,
        F: vector, turn: matrix, parts: ti.i32,
    ):  # fmt: skip
        """F: accelerations in the grid's order, loss after push; S: the state, with spins from the row `spin` on;
        turn: angular accelerations, 1/s^2."""
        n = slots.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            shape = ti.Vector([extent[0], extent[1], extent[2]])
            touching = ti.Vector([0] * (_LISTED + 1))
            stiff, damp, mu, halt, rolling = q[0], q[1], q[2], q[3], q[4]
            for k in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, v, r, w = three(P, ROWS * k), three(P, ROWS * k + 3), P[ROWS * k + 6], P[ROWS * k + 7]
                push, loss, torque = x * 0.0, x * 0.0, x * 0.0
                c = cell(x, low, shape, size)
                scaled = x / size
                at = scaled - ti.floor(scaled)  # where in its cell: cells too far from there are left out
                near = 1.001 + 1e-6 * ti.abs(scaled).sum()
                # those that touch are listed first, without a branch, and then pushed; again where the list was too short
                done, again = 0, 1
                while again > 0:
                    seen, kept = 0, 0
                    for row in range(9):
                        across = gap(at[1], row % 3 - 1) + gap(at[2], row // 3 - 1)  # squares, in cells
                        left = ti.cast(across + at[0] * at[0] < near, ti.i32)
                        right = ti.cast(across + (1.0 - at[0]) * (1.0 - at[0]) < near, ti.i32)
                        begin, end = run_of(first, shape, c[0], c[1] + row % 3 - 1, c[2] + row // 3 - 1, left, right)
                        end = ti.select(across < near, end, begin)
                        for j in range(begin, end):
                            d = x - three(P, ROWS * j)
                            reach = r + P[ROWS * j + 6]
                            hit = ti.cast((d.dot(d) < reach * reach) & (j != k), ti.i32)
                            touching[kept] = j
                            kept += hit * ti.cast((seen >= done) & (kept < _LISTED), ti.i32)
                            seen += hit
                    done += kept
                    again = ti.cast(seen > done, ti.i32)
                    for h in range(kept):
                        o = ROWS * touching[h]
                        d = x - three(P, o)
                        reach = r + P[o + 6]
                        if w + P[o + 7] > 0.0:
                            distance = d.norm()
                            normal = d * (1.0 / ti.max(distance, 1e-30))
                            m = 1.0 / (w + P[o + 7])
                            f = m * stiff * (reach - distance)
                            push += f * normal
                            if parts > 1:
                                u = v - three(P, o + 3)
                                along = u.dot(normal)
                                g = -m * damp * along
                                slide = u - along * normal
                                hold, arm, one, other = m * halt, distance / reach, v * 0.0, v * 0.0
                                if ti.static(spins):  # arms that end in one point, so that no angular momentum is made
                                    one, other = spin_of(S, spin, slots[k]), spin_of(S, spin, slots[touching[h]])
                                    slide -= ((arm * r) * one + (arm * P[o + 6]) * other).cross(normal)
                                    hold *= 2.0 / 7.0  # a sphere that turns gives way to friction 7/2 times as easily
                                speed = slide.norm()
                                most = ti.min(mu * ti.max(f + g, 0.0), hold * speed)
                                rub = slide * (most / ti.max(speed, 1e-30))
                                loss += g * normal - rub
                                if ti.static(spins):
                                    torque += (arm * r) * normal.cross(rub)
                                    roll = one - other
                                    roll -= roll.dot(normal) * normal
                                    rate = roll.norm()
                                    inertia = 0.4 / (w / (r * r) + P[o + 7] / (P[o + 6] * P[o + 6]))
                                    brake = rolling * (r * P[o + 6] / reach) * ti.max(f + g, 0.0)
                                    torque -= roll * (ti.min(brake, inertia * halt * rate) / ti.max(rate, 1e-30))
                i = slots[k]
                for a in ti.static(range(3)):
                    F[6 * k + a], F[6 * k + 3 + a] = push[a] * w, loss[a] * w
                if ti.static(spins):
                    for a in ti.static(range(3)):
                        turn[a, i] = torque[a] * (2.5 * w / ti.max(r * r, 1e-30))

    @ti.kernel
    def hand_back(F: vector, rank: whole, out: matrix, rows: ti.i32):
        """out[:, i] = F at rank[i]: one look far away for each sphere, not one for each number of it."""
        n = rank.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                for a in range(rows):
                    out[a, i] = F[6 * rank[i] + a]

    @ti.kernel
    def potential(
        P: vector, first: whole, low: whole, extent: whole, q: vector, size: real, out: ti.types.ndarray(ti.f64, 2)
    ):
        n = P.shape[0] // ROWS
        ti.loop_config(block_dim=1)
        for b in range(out.shape[0]):
            shape = ti.Vector([extent[0], extent[1], extent[2]])
            total = ti.f64(0.0)
            for k in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, r, w = three(P, ROWS * k), P[ROWS * k + 6], P[ROWS * k + 7]
                c = cell(x, low, shape, size)
                for row in range(9):
                    begin, end = run_of(first, shape, c[0], c[1] + row % 3 - 1, c[2] + row // 3 - 1, 1, 1)
                    for j in range(begin, end):
                        d = x - three(P, ROWS * j)
                        overlap = r + P[ROWS * j + 6] - d.norm()
                        if (overlap > 0.0) & (j != k) & (w + P[ROWS * j + 7] > 0.0):
                            total += ti.cast(0.25 * q[0] * overlap * overlap / (w + P[ROWS * j + 7]), ti.f64)
            out[b, 0] = total

    return tuple(runtime.kernel(f, precision) for f in (accelerate, hand_back, potential))


@cache
def deepest(precision: str):
    """A kernel: how deep each sphere overlaps another that it pushes, at most, and which."""
    real = runtime.DTYPES[precision]
    whole, vector = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(real, 1)

    @ti.kernel
    def measure(
        P: vector, slots: whole, first: whole, low: whole, extent: whole, size: real, depth: vector, other: whole
    ):
        n = slots.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            shape = ti.Vector([extent[0], extent[1], extent[2]])
            for k in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x, r, w = three(P, ROWS * k), P[ROWS * k + 6], P[ROWS * k + 7]
                most, which = r * 0.0, k
                c = cell(x, low, shape, size)
                for row in range(9):
                    begin, end = run_of(first, shape, c[0], c[1] + row % 3 - 1, c[2] + row // 3 - 1, 1, 1)
                    for j in range(begin, end):
                        d, reach = x - three(P, ROWS * j), r + P[ROWS * j + 6]
                        if (
                            (most < reach)
                            & (d.dot(d) < (reach - most) * (reach - most))
                            & (j != k)
                            & (w + P[ROWS * j + 7] > 0.0)
                        ):
                            most, which = reach - d.norm(), j
                depth[slots[k]], other[slots[k]] = most, slots[which]

    return runtime.kernel(measure, precision)
